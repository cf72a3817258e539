"""Whether challenges hold: distance, side, visible shares and detours measured again."""

from __future__ import annotations

import functools

import numpy as np

from affectsim_data.affordances import same_room
from affectsim_data.builders.validation.findings import Measure
from affectsim_data.builders.validation.part import Part
from affectsim_data.builders.validation.shares import initial_shares
from affectsim_data.poses import FloatArray

__all__ = ["bearings_deg", "check_challenges"]

LEG_HEIGHT_M = 0.4
"""Height at which the straight way to the person must meet something."""
RING_M, TOLERANCE_M = 1.0, 0.1
"""The ring a detour leads to, and half its width."""


def check_challenges(part: Part) -> list[Measure]:
    """The conditions of every challenge, and those of grounded and dyadic starts."""
    limits = part.thresholds
    challenge = part.episodes.text("challenge").astype(str)
    far, rear, occluded, detour = (
        challenge == name
        for name in ("far_visible", "rear_view", "partial_occlusion", "obstacle_detour")
    )
    grounded = challenge == "None"
    near = rear | occluded | grounded
    distance = np.linalg.norm(part.start - part.anchor, axis=1)
    visible, in_image = initial_shares(part)
    low = np.select([far | rear, occluded], [limits.visible, limits.occluded_low], -np.inf)
    low = np.where(grounded, limits.grounded_visible, low)
    high = np.where(occluded, limits.occluded_high, np.inf)
    others = ~same_room(part.scene, part.start, part.anchor)
    measure = part.measure
    return [
        measure(
            "challenge_distance",
            distance,
            where=far | near,
            low=np.where(far, limits.far_distance_m, limits.near_m),
            high=np.where(far, np.inf, limits.far_m),
        ),
        measure("challenge_visible", visible, where=far | near, low=low, high=high),
        measure("challenge_bearing", bearings_deg(part), where=rear, low=limits.rear_bearing_deg),
        measure("challenge_in_image", in_image, where=occluded, low=limits.in_image),
        measure("challenge_blocked", _free_ways(part), where=detour, high=0.0),
        measure("challenge_detour", _detours(part), where=detour, low=limits.detour_ratio),
        measure("grounded_room", others.astype(np.float64), where=grounded, high=0.0),
    ]


def bearings_deg(part: Part) -> FloatArray:
    """Starts seen from the targets, off their mean facing, degrees, 0 to 180, `(n,)`."""
    return np.abs(signed_bearings_deg(part))


@functools.lru_cache(maxsize=2)
def signed_bearings_deg(part: Part) -> FloatArray:
    """The same, positive to the target's left, in (-180, 180]."""
    way = part.start - part.anchor
    facing = np.radians(part.episodes.number("facing_deg"))
    heading = facing + np.array([track.heading for track in part.tracks])
    off: FloatArray = np.degrees(
        np.angle(np.exp(1j * (np.arctan2(way[:, 0], way[:, 2]) - heading)))
    )
    return off


def _free_ways(part: Part) -> FloatArray:
    """1 where nothing stands between start and anchor at leg height, `(n,)`."""
    lift = np.array([0.0, LEG_HEIGHT_M, 0.0])
    free: FloatArray = (~part.caster.hidden(part.start + lift, part.anchor + lift)).astype(float)
    return free


def _detours(part: Part) -> FloatArray:
    """Way to the ring along the floor over the straight one, `(n,)`; not a number for none."""
    straight = np.linalg.norm(part.start - part.anchor, axis=1) - RING_M - TOLERANCE_M
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio: FloatArray = np.where(
            straight > 0.0, part.episodes.number("d_star_1m") / straight, np.nan
        )
    return ratio
