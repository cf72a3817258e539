"""Finds a placement for each slot: candidates drawn from a pool, measured with all its motions."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from affectsim_data.affordances import fits
from affectsim_data.builders.measuring import (
    Measures,
    Performance,
    Shares,
    measure_performance,
    measure_shares,
    share_inside,
)
from affectsim_data.builders.placement.drawing import (
    GRID_SLACK_M,
    PERSON_CLEARANCE_M,
    Candidates,
    draw_candidates,
    wrapped,
)
from affectsim_data.builders.placement.ledger import Ledger
from affectsim_data.builders.placement.pools import RING_M, has_detour, is_blocked, pool_of
from affectsim_data.builders.placement.stages import Placement, Stage, Unplaced
from affectsim_data.builders.placement.supports import INSIDE_FREE, INSIDE_SEATED, MotionSet
from affectsim_data.builders.recipes import Recipe, Thresholds
from affectsim_data.builders.slots import Slot, slot_seed
from affectsim_data.observations import head_camera_pose
from affectsim_data.poses import invert_pose, transform_points
from affectsim_data.schemas import Challenge

__all__ = ["find_placements"]

_BATCHES = (2, 6, 24, 64)
"""Candidates measured at a time: the first ones mostly hold."""
_FROM_PERSON_M = 0.5
"""Least distance of a start from the person's way."""
_FROM_SKIN_M = 0.25
"""Least distance of the camera at the start from anybody's skin, at the instants of the cycle."""
_REAR_SHARE, _REAR_SLACK_DEG = 0.75, 15.0
"""Least share of the cycle in which the back is turned to the robot, to within so many degrees."""
_SHARE_MARGIN, _FEW_RAYS = 0.003, 0.08
_ANGLE_MARGIN_DEG = 0.1
"""Kept from limits, so that nothing depends on rounding."""

Check = Callable[[Candidates], NDArray[np.bool_]]


def find_placements(
    stage: Stage, slots: Sequence[Slot], performances: Mapping[str, Performance], recipe: Recipe
) -> list[Placement | Unplaced]:
    """For each slot a placement that holds for all its motions, or why there is none.

    What becomes of a slot depends on the recipe, the scene and the slot alone.

    Args:
        stage: The scene.
        slots: To be placed.
        performances: By the target's motion.
        recipe: Thresholds, camera, seed.
    """
    return [_find(stage, slot, performances, recipe) for slot in slots]


def _find(
    stage: Stage, slot: Slot, performances: Mapping[str, Performance], recipe: Recipe
) -> Placement | Unplaced:
    pool = pool_of(stage, slot.placement, slot.challenge, recipe)
    ledger = Ledger(pool.survivors)
    if len(pool):
        members = [performances[motion_id] for motion_id in slot.motion_ids]
        # All members share the performer's body, so the first one speaks for all.
        scale = members[0].avatar.motion_scale
        wanted = MotionSet(tuple(measure_performance(one) for one in members), scale)
        rng = np.random.default_rng(slot_seed(recipe.seed, slot))
        drawn = draw_candidates(stage, slot, wanted, pool, recipe, ledger=ledger, rng=rng)
        checks = _checks(stage, slot, wanted, recipe)
        low = 0
        for size in _BATCHES:
            batch = np.arange(low, min(low + size, len(drawn)))
            for words, check in checks.items():
                if len(batch):
                    batch = ledger.keep(words, batch, check(drawn.taken(batch)))
            if len(batch):
                return drawn.placement(int(batch[0]), stage, slot)
            low += size
    return Unplaced(slot.key, ledger.binding, ledger.counts)


def _checks(stage: Stage, slot: Slot, wanted: MotionSet, recipe: Recipe) -> dict[str, Check]:
    """What a placement must be measured to meet, the cheapest first."""
    limits, challenge = recipe.thresholds, slot.challenge
    checks: dict[str, Check] = {}
    if challenge == "partial_occlusion":
        # Most of them show too much or too little, and a few rays tell.
        checks["a visible share about right"] = functools.partial(
            _is_seen, stage, wanted, challenge, recipe, few=True
        )
    if slot.placement in ("floor", "pair"):
        radius_m = stage.navmesh.settings.agent_radius + PERSON_CLEARANCE_M
        checks["free floor around the whole motion"] = functools.partial(
            _has_floor, stage, wanted, radius_m
        )
    checks["a start off the person's way"] = functools.partial(_is_off_way, wanted)
    checks["nobody's body before the camera"] = functools.partial(_is_off_bodies, wanted, recipe)
    if challenge == "rear_view":
        checks["back turned in every emotion"] = functools.partial(_is_turned, wanted, limits)
    checks["body clear of walls and furniture in every emotion"] = functools.partial(
        _is_clear,
        stage,
        wanted,
        INSIDE_SEATED if slot.placement in ("seat", "before_seat") else INSIDE_FREE,
    )
    if challenge == "obstacle_detour":
        words = f"a blocked way and a detour of {limits.detour_ratio:g} to the 1 m ring"
        checks[words] = functools.partial(_is_detour, stage, limits)
    else:
        checks[_share_words(challenge, limits)] = functools.partial(
            _is_seen, stage, wanted, challenge, recipe
        )
    return checks


def _has_floor(
    stage: Stage, wanted: MotionSet, radius_m: float, some: Candidates
) -> NDArray[np.bool_]:
    way = transform_points(some.T_world_performance, wanted.footprint)
    least = radius_m - stage.navmesh.settings.agent_radius
    # Where the grid says that there is more than enough room on a level floor, there is.
    free = stage.floor.around(way) >= least + 2.0 * GRID_SLACK_M
    if not stage.navmesh.islands[0].is_level:
        free[:] = False
    free[~free] = fits(stage.navmesh, way[~free], radius_m=radius_m)
    return np.asarray(free.all(axis=1))


def _is_off_way(wanted: MotionSet, some: Candidates) -> NDArray[np.bool_]:
    way = transform_points(some.T_world_performance, wanted.footprint) - some.start[:, None]
    return np.asarray(np.hypot(way[..., 0], way[..., 2]).min(axis=1) >= _FROM_PERSON_M)


def _is_off_bodies(wanted: MotionSet, recipe: Recipe, some: Candidates) -> NDArray[np.bool_]:
    eyes = head_camera_pose(some.start, some.start_yaw, recipe.robot)[:, :3, 3]
    local = transform_points(invert_pose(some.T_world_performance), eyes[:, None])[:, 0]
    nearest = [cKDTree(one.outer).query(local)[0] for one in wanted.members]
    return np.asarray(np.min(nearest, axis=0) >= _FROM_SKIN_M)


def _is_turned(wanted: MotionSet, limits: Thresholds, some: Candidates) -> NDArray[np.bool_]:
    """Whether every mean bearing is a rear view, and most of the cycle shows the back."""
    way = some.start - some.anchor
    bearing = np.arctan2(way[:, 0], way[:, 2]) - some.facing
    turned = np.ones(len(some), bool)
    least = math.radians(limits.rear_bearing_deg)
    for one in wanted.members:
        mean = np.abs(wrapped(bearing - one.mean_heading))
        turned &= mean >= least + math.radians(_ANGLE_MARGIN_DEG)
        now = np.abs(wrapped(bearing[:, None] - one.headings))
        share = (now >= least - math.radians(_REAR_SLACK_DEG)).mean(axis=1)
        turned &= share >= _REAR_SHARE
    return turned


def _is_detour(stage: Stage, limits: Thresholds, some: Candidates) -> NDArray[np.bool_]:
    """Whether the straight way to the 1 m ring is blocked and the shortest one long enough."""
    holds = is_blocked(stage, some.start, some.anchor)
    # Each anchor has a ring of its own, and the first that holds is enough.
    for number in np.flatnonzero(holds):
        geodesic = stage.navmesh.ring_distance(some.start[number], some.anchor[number], RING_M)
        holds[number] = has_detour(np.array(geodesic), some.distance[number], limits)
        if holds[number]:
            holds[number + 1 :] = False
            break
    return holds


def _is_clear(
    stage: Stage, wanted: MotionSet, most: tuple[float, float], some: Candidates
) -> NDArray[np.bool_]:
    def holds(one: Measures, left: Candidates) -> NDArray[np.bool_]:
        sitting, other = share_inside(one, left.T_world_performance, stage.caster)
        return np.asarray((sitting <= most[0]) & (other <= most[1]))

    return _in_every_emotion(wanted, some, holds)


def _is_seen(
    stage: Stage,
    wanted: MotionSet,
    challenge: Challenge | None,
    recipe: Recipe,
    some: Candidates,
    *,
    few: bool = False,
) -> NDArray[np.bool_]:
    """Whether the body is as visible as the challenge wants; with `few` rays, about so."""

    def holds(one: Measures, left: Candidates) -> NDArray[np.bool_]:
        shares = measure_shares(
            one,
            left.T_world_performance,
            head_camera_pose(left.start, left.start_yaw, recipe.robot),
            camera=recipe.camera,
            caster=stage.caster,
            few=few,
        )
        margin = -_FEW_RAYS if few else _SHARE_MARGIN
        return _share_suits(challenge, shares, recipe.thresholds, margin)

    return _in_every_emotion(wanted, some, holds)


def _in_every_emotion(
    wanted: MotionSet,
    some: Candidates,
    holds: Callable[[Measures, Candidates], NDArray[np.bool_]],
) -> NDArray[np.bool_]:
    """Whether something holds for all motions; one after another, for what the others left."""
    left = np.arange(len(some))
    for one in wanted.members:
        if len(left):
            left = left[holds(one, some.taken(left))]
    return np.isin(np.arange(len(some)), left)


def _share_suits(
    challenge: Challenge | None, shares: Shares, limits: Thresholds, margin: float
) -> NDArray[np.bool_]:
    visible = shares.visible
    if challenge == "partial_occlusion":
        return np.asarray(
            (visible >= limits.occluded_low + margin)
            & (visible <= limits.occluded_high - margin)
            & (shares.in_image >= limits.in_image + margin)
        )
    least = limits.grounded_visible if challenge is None else limits.visible
    return visible >= least + margin


def _share_words(challenge: Challenge | None, limits: Thresholds) -> str:
    if challenge == "partial_occlusion":
        low, high = limits.occluded_low, limits.occluded_high
        return f"visible share of {low:g} to {high:g} in every emotion"
    least = limits.grounded_visible if challenge is None else limits.visible
    return f"visible share of {least:g} in every emotion"
