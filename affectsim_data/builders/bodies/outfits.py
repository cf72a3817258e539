"""Clothes of a figure: shirt, trousers and shoes cut from the tights of the base mesh."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.builders.bodies.figures import Figure
from affectsim_data.builders.bodies.surfaces import Surface, merge, normalized
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["OVERLAP_M", "Cut", "clothes", "skin_field"]

OVERLAP_M = 0.045
"""How far skin goes on under a cuff or a collar."""


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


def _fitted(shell: Surface, offset: FloatArray, passes: int) -> Surface:
    """The shell smoothed `passes` times and then held at least `offset` `(n,)` off the body."""
    normals = shell.vertex_normals()
    smooth = shell.smooth(passes)
    height = np.einsum("ni,ni->n", smooth.positions - shell.positions, normals)
    lift = np.maximum(offset - height, 0.0)
    return smooth.moved(smooth.positions + normals * lift[:, None]).smooth(2)


def _hung(shirt: Surface) -> Surface:
    """The shirt with half of what the thighs pull left to the pelvis: its hem is loose."""
    weights = shirt.weights.copy()
    hips = [JOINT_NAMES.index(name) for name in ("left_hip", "right_hip")]
    weights[:, hips] *= 0.5
    weights[:, JOINT_NAMES.index("pelvis")] += 1.0 - weights.sum(axis=1)
    return dataclasses.replace(shirt, weights=weights)


def _shirt(figure: Figure, cut: Cut, shell: Surface, num_faces: int) -> tuple[Surface, Surface]:
    joints, points = figure.joints, shell.positions
    hem = joints["left_hip"][1] - cut.shirt_m
    along = np.abs(points[:, 0])
    sleeve = _ramp(along, joints["left_shoulder"][0], joints["left_elbow"][0])
    loose = _ramp(-points[:, 1], -joints["spine2"][1], -hem) * (1.0 - sleeve)
    ease = np.full(len(points), cut.ease_m) * (1.0 - 0.35 * sleeve) + 0.007 * loose
    neck = _ramp(points[:, 1], joints["neck"][1] - 0.05, joints["neck"][1])
    shirt = _fitted(shell, np.maximum(ease * (1.0 - 0.5 * neck), 0.006), 8)
    shirt = _hung(shirt).simplify(num_faces, keep_borders=True).with_normals()
    shirt, _ = shirt.cut(shirt.positions[:, 1] - hem)
    shirt, _ = shirt.cut(_cuff(figure, cut) - np.abs(shirt.positions[:, 0]))
    shirt, _ = shirt.cut(-_collar_field(figure, cut, shirt.positions))
    collar_band, body = shirt.cut(_collar_field(figure, cut, shirt.positions) + 0.018)
    cuff_band, body = body.cut(np.abs(body.positions[:, 0]) - _cuff(figure, cut) + 0.02)
    return merge([body, shirt.hem(0.014)]), merge([collar_band, cuff_band])


def _trousers(figure: Figure, cut: Cut, shell: Surface, num_faces: int) -> Surface:
    joints = figure.joints
    top = joints["left_hip"][1] - cut.shirt_m + OVERLAP_M
    bottom = joints["left_ankle"][1] - 0.035
    legs = _fitted(shell, np.full(len(shell.positions), 0.007), 4)
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
    legs = legs.moved(points).smooth(2).simplify(num_faces, keep_borders=True).with_normals()
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
    """Parts by colour name: `shirt`, `trim`, `trousers`, `shoes`, `soles`.

    Args:
        figure: The body they fit.
        cut: How they are cut.
        num_faces: About how many triangles they may have together.
    """
    shell = figure.surface("helper-tights")
    height = shell.positions[shell.faces, 1]
    hem = figure.joints["left_hip"][1] - cut.shirt_m
    shirt, trim = _shirt(
        figure, cut, shell.with_faces(shell.faces[height.max(axis=1) > hem - 0.05]), num_faces // 2
    )
    legs = shell.with_faces(shell.faces[height.min(axis=1) < hem + OVERLAP_M + 0.05])
    ankle = figure.joints["left_ankle"][1]
    feet = shell.with_faces(shell.faces[height.min(axis=1) < ankle + 0.05])
    shoes, soles = _shoes(figure, feet, num_faces // 6)
    return {
        "shirt": shirt,
        "trim": trim,
        "trousers": _trousers(figure, cut, legs, num_faces // 3),
        "shoes": shoes,
        "soles": soles,
    }
