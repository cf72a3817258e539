"""Whether bodies are out of walls and furniture, and the two of a dyad apart as performed."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.measuring import on_floor, partner_place
from affectsim_data.builders.validation.findings import Measure
from affectsim_data.builders.validation.part import Part
from affectsim_data.builders.validation.tracks import Track, placed
from affectsim_data.poses import FloatArray, invert_pose, transform_points

__all__ = ["check_bodies"]

SKIN_M = 0.03
"""Bodies may be this deep in things: cushions give, and so do clothes."""
FREE_SHARE = 0.003
"""Of the rays inside a body, those that may meet the scene over the cycle."""
SEATED_SHARE, PRESSED_SHARE = 0.021, 0.151
"""The same of sitters, who touch what is around a seat, and of their seat and thighs, which press
into cushions."""
PAIR_OFF_M = 1e-3
"""How far a partner may be off the place that interactions are performed for."""
PAIR_APART_M = 0.2
"""Between two pelvises: who embraces comes near, nobody walks through another."""


def check_bodies(part: Part) -> list[Measure]:
    """Rays inside bodies that meet the scene; the place of partners."""
    inside = _shares_inside(part, part.tracks, part.pose)
    if part.partner_tracks:
        rows = np.array(list(part.partner_tracks), np.intp)
        partners = list(part.partner_tracks.values())
        # A dyad's rays are those of both.
        inside[rows] = (inside[rows] + _shares_inside(part, partners, part.partner_pose[rows])) / 2
    seated = np.isin(part.kinds.astype(str), ["seat", "before_seat"])
    most, pressed = (np.where(seated, one, FREE_SHARE) for one in (SEATED_SHARE, PRESSED_SHARE))
    return [
        part.measure("body_free", inside[:, 0], high=most),
        part.measure("seat_free", inside[:, 1], high=pressed),
        *_pairs(part),
    ]


def _shares_inside(part: Part, tracks: list[Track], poses: FloatArray) -> FloatArray:
    """Of all rays from joints to the skin and to the next joints, those that meet the scene.

    Returns:
        Shares over the cycle, `(n, 2)`: of the rays that do not end in seat and thighs, and of
        those that do.
    """
    roots, surface, bones = (
        np.stack([getattr(track, name) for track in tracks])
        for name in ("roots", "surface", "bones")
    )
    way = surface - roots
    length = np.linalg.norm(way, axis=-1, keepdims=True)
    below = roots + way * np.maximum(length - SKIN_M, 0.0) / np.maximum(length, 1e-9)
    inner = placed(poses, on_floor(np.concatenate([roots, bones[..., 0, :]], axis=2)))
    outer = placed(poses, on_floor(np.concatenate([below, bones[..., 1, :]], axis=2)))
    met = part.caster.hidden(inner, outer).mean(axis=1)
    sits = np.stack([track.sits for track in tracks])
    sits = np.pad(sits, ((0, 0), (0, met.shape[1] - sits.shape[1])))
    share: FloatArray = np.stack([met * ~sits, met * sits], axis=-1).mean(axis=1)
    return share


def _pairs(part: Part) -> list[Measure]:
    """How far partners are off their place, and how near pelvises come, metres."""
    off, apart = np.zeros(len(part)), np.full(len(part), np.inf)
    for place, partner in part.partner_tracks.items():
        target = part.tracks[place]
        scale = 0.5 * (target.motion_scale + partner.motion_scale)
        relative = invert_pose(part.pose[place]) @ part.partner_pose[place]
        off[place] = np.abs(relative - partner_place(scale)).max()
        mine = target.pelvis
        theirs = transform_points(relative, partner.pelvis)
        # Both cycles are as long; sampled at the same share of it.
        index = np.round(np.linspace(0, len(theirs) - 1, len(mine))).astype(np.intp)
        apart[place] = np.linalg.norm((mine - theirs[index])[:, [0, 2]], axis=1).min()
    return [
        part.measure("pair_place", off, where=part.has_partner, high=PAIR_OFF_M),
        part.measure("pair_apart", apart, where=part.has_partner, low=PAIR_APART_M),
    ]
