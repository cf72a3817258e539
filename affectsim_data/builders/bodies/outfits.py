"""Clothes of a figure: shirt, trousers and shoes cut from the tights of the base mesh."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.spatial import ConvexHull

from affectsim_data.builders.bodies.figures import Figure
from affectsim_data.builders.bodies.surfaces import Surface, merge, normalized
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["OVERLAP_M", "Cut", "clothes", "skin_field"]

OVERLAP_M = 0.045
"""How far skin goes on under a cuff or a collar."""
_TUBE_M, _ROW_M, _FLARE = 0.01, 0.012, 0.6
"""A shirt leaves the trunk and becomes a tube so many metres above the hip joints, in rows of this
height, and grows wider by this share of itself a metre."""


@dataclasses.dataclass(frozen=True)
class Cut:
    """How clothes are cut."""

    sleeves: float
    """Where sleeves end: 0 at the shoulder, 1 at the elbow, 2 at the wrist."""
    collar_m: float
    """Depth of the collar at the front, metres below the neck joint."""
    shirt_m: float
    """How far the shirt hangs below the hip joints, metres."""
    leg_m: float
    """Least radius of a trouser leg, metres."""
    ease_m: float
    """Room between shirt and body, metres."""
    open_m: float = 0.0
    """Half the width of the opening of a jacket at the collar, metres; 0 for a closed shirt."""


def _ramp(values: FloatArray, low: float, high: float) -> FloatArray:
    """0 below `low`, 1 above `high`, smooth in between."""
    share = ((values - low) / (high - low)).clip(0.0, 1.0)
    smooth: FloatArray = share * share * (3.0 - 2.0 * share)
    return smooth


def _collar_field(figure: Figure, cut: Cut, points: FloatArray) -> FloatArray:
    """Metres into the opening of the collar, `(n,)`; negative where the shirt is."""
    neck = figure.joints["neck"]
    front = points[:, 2] - neck[2]
    slope = _ramp(front, -0.07, 0.11)
    opening = points[:, 1] - neck[1] - 0.012 + (0.012 + cut.collar_m) * slope
    # Shoulders lie as high as the front of a wide collar, but further out.
    outside = 0.074 + 0.2 * cut.collar_m - np.abs(points[:, 0])
    blend = ((0.03 - np.abs(opening - outside)) / 0.03).clip(min=0.0)
    field: FloatArray = np.minimum(opening, outside) - blend * blend * 0.03 / 4.0
    return field


def _cuff(figure: Figure, cut: Cut) -> float:
    """Distance of a cuff from the middle of the body, metres."""
    names = ("left_shoulder", "left_elbow", "left_wrist")
    return float(np.interp(cut.sleeves, [0, 1, 2], [figure.joints[name][0] for name in names]))


def skin_field(figure: Figure, cut: Cut, points: FloatArray) -> FloatArray:
    """Positive where skin shows or lies just under the edge of the clothes, `(n,)`."""
    collar = _collar_field(figure, cut, points) + OVERLAP_M
    return np.maximum(collar, np.abs(points[:, 0]) - _cuff(figure, cut) + OVERLAP_M)


def _opened(figure: Figure, cut: Cut, body: Surface, more_m: float) -> tuple[Surface, Surface]:
    """The opening of a jacket, `more_m` wider on both sides, and what is left of the jacket."""
    neck, hip = figure.joints["neck"], figure.joints["left_hip"]

    def half(points: FloatArray) -> FloatArray:
        """Half its width, `(n,)`: most at the collar, little at the hem."""
        rise = ((points[:, 1] - hip[1]) / (neck[1] - hip[1])).clip(0.0, 1.0)
        width: FloatArray = cut.open_m * (0.35 + 0.65 * rise**2) + more_m
        return width

    return body.carve(
        (
            lambda points: points[:, 2] - hip[2],
            lambda points: half(points) - points[:, 0],
            lambda points: half(points) + points[:, 0],
        )
    )


def _tube(figure: Figure, shell: Surface, bottom: float) -> Surface:
    """The trunk above the hips, carried on downwards to height `bottom` as one tube around both
    thighs: a hem that knows nothing of the crotch."""
    level = figure.joints["left_hip"][1] + _TUBE_M
    trunk, _ = shell.cut(shell.positions[:, 1] - level)
    edges = trunk.boundary()
    edges = edges[(trunk.positions[edges, 1] < level + 1e-6).all(axis=1)]
    rim, inverse = np.unique(edges, return_inverse=True)
    around = trunk.positions[rim]
    num_rows = max(int(np.ceil((level - bottom) / _ROW_M)), 2)
    rows = []
    for height in np.linspace(level, bottom, num_rows + 1)[1:]:
        near = shell.positions[np.abs(shell.positions[:, 1] - height) < 0.02]
        near = near[np.abs(near[:, 0]) < 2.5 * figure.joints["left_hip"][0]]
        reach = _reach(near[:, [0, 2]], around[:, [0, 2]])
        flat = around[:, [0, 2]] * np.maximum(reach, 1.0)[:, None]
        flat *= 1.0 + _FLARE * _ROW_M
        rows.append(np.insert(flat, 1, height, axis=1))
        around = rows[-1]
    points = np.concatenate([trunk.positions[rim], *rows])
    start, end = inverse.reshape(-1, 2).T
    shifts = len(rim) * np.arange(num_rows)[:, None]
    quads = np.stack(
        [end + shifts, start + shifts, start + shifts + len(rim), end + shifts + len(rim)], axis=-1
    ).reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return trunk.welded(shell.carried(points, faces), rim)


def _reach(points: FloatArray, rays: FloatArray) -> FloatArray:
    """How many times a ray `(m, 2)` from the origin fits to the convex hull of `(n, 2)`, `(m,)`."""
    planes = ConvexHull(points).equations  # Outward normal and minus its distance.
    facing = rays @ planes[:, :2].T
    times: FloatArray = np.where(
        facing > 1e-9, -planes[:, 2] / np.maximum(facing, 1e-9), np.inf
    ).min(axis=1)
    return times


def _fitted(shell: Surface, offset: FloatArray, passes: int) -> Surface:
    """The shell smoothed `passes` times and then held at least `offset` `(n,)` off the body."""
    normals = shell.vertex_normals()
    smooth = shell.smooth(passes)
    height = np.einsum("ni,ni->n", smooth.positions - shell.positions, normals)
    lift = np.maximum(offset - height, 0.0)
    return smooth.moved(smooth.positions + normals * lift[:, None]).smooth(2)


def _draped(shirt: Surface, share: FloatArray) -> Surface:
    """The trunk drawn towards the convex hull of its height by `share` `(n,)`: cloth bridges."""
    points = shirt.positions.copy()
    heights = points[:, 1]
    for low in np.arange(heights[share > 0.0].min(), heights[share > 0.0].max(), 0.01):
        here = np.flatnonzero((share > 0.0) & (heights >= low) & (heights < low + 0.01))
        near = (share > 0.0) & (np.abs(heights - low - 0.005) < 0.02)
        if not len(here) or near.sum() < 12:
            continue
        flat = shirt.positions[near][:, [0, 2]]
        middle = (flat.min(axis=0) + flat.max(axis=0)) / 2.0
        away = shirt.positions[here][:, [0, 2]] - middle
        growth = 1.0 + share[here] * (_reach(flat - middle, away).clip(1.0, 2.0) - 1.0)
        points[here[:, None], [0, 2]] = middle + away * growth[:, None]
    return shirt.moved(points).smooth(4)


def _hung(figure: Figure, shirt: Surface) -> Surface:
    """The shirt with a loose hem: in front it lies on the thighs, behind it half hangs down."""
    hip, points = figure.joints["left_hip"], shirt.positions
    pelvis, left, right = (JOINT_NAMES.index(name) for name in ("pelvis", "left_hip", "right_hip"))
    weights = shirt.weights.copy()
    front = _ramp(points[:, 2], hip[2] - 0.06, hip[2] + 0.04)
    weights[:, [left, right]] *= (0.5 + 0.5 * front)[:, None]
    weights[:, pelvis] += 1.0 - weights.sum(axis=1)
    laid = 0.6 * front * _ramp(-points[:, 1], -hip[1] - 0.03, -hip[1] + 0.05) * weights[:, pelvis]
    to_left = (0.5 + points[:, 0] / hip[0] / 2.0).clip(0.0, 1.0)
    weights[:, left] += laid * to_left
    weights[:, right] += laid * (1.0 - to_left)
    weights[:, pelvis] -= laid
    return dataclasses.replace(shirt, weights=weights)


def _shirt(figure: Figure, cut: Cut, shell: Surface, num_faces: int) -> dict[str, Surface]:
    """Parts by colour name: `shirt`, `trim` and, for a jacket, `inner`."""
    joints = figure.joints
    hem = joints["left_hip"][1] - cut.shirt_m
    shell = _tube(figure, shell, hem - 0.03)
    points = shell.positions
    along = np.abs(points[:, 0])
    sleeve = _ramp(along, joints["left_shoulder"][0], joints["left_elbow"][0])
    loose = _ramp(-points[:, 1], -joints["spine2"][1], -hem) * (1.0 - sleeve)
    ease = np.full(len(points), cut.ease_m) * (1.0 - 0.35 * sleeve) + 0.007 * loose
    neck = _ramp(points[:, 1], joints["neck"][1] - 0.05, joints["neck"][1])
    shirt = _fitted(shell, np.maximum(ease * (1.0 - 0.5 * neck), 0.006), 24)
    trunk = _ramp(-along, -joints["left_shoulder"][0], -joints["left_shoulder"][0] + 0.05)
    below = _ramp(-points[:, 1], -joints["spine3"][1] - 0.08, -joints["spine2"][1])
    shirt = _draped(shirt, trunk * below * 0.85)
    shirt = figure.simplified(_hung(figure, shirt), num_faces, parts=("shoulder", "elbow"))
    shirt = shirt.with_normals()
    shirt, _ = shirt.cut(shirt.positions[:, 1] - hem)
    shirt, _ = shirt.cut(_cuff(figure, cut) - np.abs(shirt.positions[:, 0]))
    shirt, _ = shirt.cut(-_collar_field(figure, cut, shirt.positions))
    collar_band, body = shirt.cut(_collar_field(figure, cut, shirt.positions) + 0.018)
    cuff_band, body = body.cut(np.abs(body.positions[:, 0]) - _cuff(figure, cut) + 0.02)
    wide, narrow = shirt.hem(0.014), shirt.hem(0.006)  # Cuffs stay off the skin.
    _, lower = wide.cut(wide.positions[:, 1] - hem - 0.05)
    upper, _ = narrow.cut(narrow.positions[:, 1] - hem - 0.05)
    trims = [collar_band, cuff_band, upper]
    if cut.open_m == 0.0:
        return {"shirt": merge([body, lower]), "trim": merge(trims)}
    inner, body = _opened(figure, cut, body, 0.0)
    lapel, body = _opened(figure, cut, body, 0.016)
    return {"shirt": merge([body, lower]), "trim": merge([*trims, lapel]), "inner": inner}


def _trousers(figure: Figure, cut: Cut, shell: Surface, num_faces: int) -> Surface:
    joints = figure.joints
    top = joints["left_hip"][1] - cut.shirt_m + OVERLAP_M
    bottom = joints["left_ankle"][1] - 0.035
    legs = _fitted(shell, np.full(len(shell.positions), 0.007), 12)
    points = legs.positions.copy()
    side = np.where(points[:, 0] >= 0.0, 1.0, -1.0)
    hip, knee, ankle = (joints[f"left_{name}"] for name in ("hip", "knee", "ankle"))
    heights = [ankle[1], knee[1], hip[1]]
    axis = np.stack(
        [
            side * np.interp(points[:, 1], heights, [ankle[0], knee[0], hip[0]]),
            points[:, 1],
            np.interp(points[:, 1], heights, [ankle[2] - 0.005, knee[2] - 0.005, hip[2]]),
        ],
        axis=1,
    )
    away = points - axis
    radius = np.linalg.norm(away, axis=1)
    wide = cut.leg_m * (1.0 + 0.12 * _ramp(-points[:, 1], -knee[1], -bottom))
    least = wide * _ramp(-points[:, 1], -(knee[1] + 0.25), -(knee[1] + 0.02))
    # A soft maximum: a leg keeps a hint of knee and calf.
    target = np.cbrt(radius**3 + least**3 * 0.6)
    target = np.where(least > 0.0, np.maximum(target, radius), radius)
    points = axis + normalized(away) * target[:, None]
    inner = (0.004 - points[:, 0] * side).clip(min=0.0)
    points[:, 0] += np.where(points[:, 1] < hip[1] - 0.1, inner * side, 0.0)
    legs = legs.moved(points).smooth(4)
    legs = figure.simplified(legs, num_faces, parts=("hip", "knee", "ankle")).with_normals()
    legs, _ = legs.cut(top - legs.positions[:, 1])
    legs, _ = legs.cut(legs.positions[:, 1] - bottom)
    return merge([legs, legs.hem(0.015)])


def _shoes(figure: Figure, shell: Surface, num_faces: int) -> tuple[Surface, Surface]:
    """Uppers and soles."""
    ankle, ball = figure.joints["left_ankle"], figure.joints["left_foot"]
    shoe = _fitted(shell, np.full(len(shell.positions), 0.006), 3)
    points = shoe.positions.copy()
    floor = points[:, 1].min()
    low = 1.0 - _ramp(points[:, 1], floor + 0.012, floor + 0.034)
    middle = np.stack(
        [np.sign(points[:, 0]) * ball[0], points[:, 1], np.full(len(points), ball[2] * 0.45)],
        axis=1,
    )
    points += normalized(points - middle) * [1.0, 0.0, 1.0] * (0.006 * low)[:, None]
    points[:, 1] = np.where(points[:, 1] < floor + 0.014, floor, points[:, 1])
    shoe = shoe.moved(points).simplify(num_faces, keep_borders=True).with_normals()
    shoe, _ = shoe.cut(ankle[1] + 0.02 - shoe.positions[:, 1])
    upper, sole = shoe.cut(shoe.positions[:, 1] - floor - 0.022)
    return merge([upper, upper.hem(0.006)]), sole


def clothes(figure: Figure, cut: Cut, *, num_faces: int) -> dict[str, Surface]:
    """Parts by colour name: `shirt`, `trim`, `trousers`, `shoes`, `soles`, for a jacket `inner`.

    Args:
        figure: The body they fit.
        cut: How they are cut.
        num_faces: About how many triangles they may have together.
    """
    tights = figure.surface("helper-tights")
    shell = tights.subdivided()
    height = shell.positions[shell.faces, 1]
    hem = figure.joints["left_hip"][1] - cut.shirt_m
    upper = shell.with_faces(shell.faces[height.max(axis=1) > hem - 0.08])
    legs = shell.with_faces(shell.faces[height.min(axis=1) < hem + OVERLAP_M + 0.05])
    ankle = figure.joints["left_ankle"][1]
    low = tights.positions[tights.faces, 1].min(axis=1) < ankle + 0.05
    feet = tights.with_faces(tights.faces[low])
    shoes, soles = _shoes(figure, feet, num_faces // 6)
    return {
        **_shirt(figure, cut, upper, num_faces // 2),
        "trousers": _trousers(figure, cut, legs, num_faces // 3),
        "shoes": shoes,
        "soles": soles,
    }
