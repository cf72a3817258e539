"""Head, hands and eyes of a figure, split by colour along sharp lines."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.spatial import cKDTree

from affectsim_data.builders.bodies.figures import Figure
from affectsim_data.builders.bodies.outfits import OVERLAP_M, Cut, skin_field
from affectsim_data.builders.bodies.surfaces import Surface, merge
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["eye_centers", "skin"]

_IRIS_M = 0.0062
_PUPIL_M = 0.0026


def eye_centers(figure: Figure) -> dict[str, FloatArray]:
    """Centre of each eyeball, metres, `(3,)`, by side."""
    eyes = {"left": "helper-l-eye", "right": "helper-r-eye"}
    return {side: figure.surface(name).positions.mean(axis=0) for side, name in eyes.items()}


def _brow(figure: Figure, rest: Surface, side: str, thickness_m: float) -> tuple[Surface, Surface]:
    """An eyebrow and what is left, cut by one line after the other: it is thinner than a face."""
    center = eye_centers(figure)[side]
    sign = 1.0 if side == "left" else -1.0

    def along(points: FloatArray) -> FloatArray:
        """Position along the brow, from the nose outwards, in units of its length."""
        share: FloatArray = ((points[:, 0] - center[0]) * sign + 0.019) / 0.045
        return share

    def edge(points: FloatArray, direction: float) -> FloatArray:
        share = along(points)
        height = center[1] + np.interp(share, [0, 0.55, 1.0], [0.0175, 0.0235, 0.0170])
        half = thickness_m * np.interp(share, [0.0, 0.4, 1.0], [1.0, 1.0, 0.35]) / 2.0
        inside: FloatArray = half - direction * (points[:, 1] - height)
        return inside

    return rest.carve(
        (
            lambda points: points[:, 2] - center[2],
            along,
            lambda points: 1.0 - along(points),
            lambda points: edge(points, 1.0),
            lambda points: edge(points, -1.0),
        )
    )


def _lashes(figure: Figure, head: Surface) -> Surface:
    """Dark lines along the upper lids."""
    edges = head.boundary()
    middles = head.positions[edges].mean(axis=1)
    upper = np.zeros(len(edges), bool)
    for center in eye_centers(figure).values():
        away = middles - center
        upper |= (np.linalg.norm(away, axis=1) < 0.022) & (away[:, 1] > -0.001)
    return head.strip(edges[upper], np.array([0.0, -0.0017, 0.0009]))


def _beard_field(figure: Figure, head: Surface) -> FloatArray:
    """Metres into a short full beard, `(n,)`."""
    points = head.positions
    eyes = np.mean(list(eye_centers(figure).values()), axis=0)
    joint = figure.joints["head"]
    side = np.abs(points[:, 0])
    line = np.interp(side, [0.0, 0.018, 0.040, 0.070], [-0.053, -0.055, -0.056, 0.010])
    below = eyes[1] + line - points[:, 1]
    jaw = points[:, 1] - (eyes[1] - 0.128)
    front = points[:, 2] - joint[2] - 0.012
    field: FloatArray = np.minimum(np.minimum(below, jaw), front)
    return field


def _lip_field(body: Surface) -> FloatArray:
    """Metres into the lips, `(n,)`: a distance stays sharp where a mask blurs."""
    lips = body.scalars["lips"] > 0.5
    to_lips, _ = cKDTree(body.positions[lips]).query(body.positions)
    to_skin, _ = cKDTree(body.positions[~lips]).query(body.positions)
    field: FloatArray = (to_skin - to_lips) / 2.0
    return field


def _eyes(figure: Figure, num_faces: int) -> dict[str, Surface]:
    parts: dict[str, list[Surface]] = {"eyes": [], "iris": [], "pupils": []}
    for side, center in eye_centers(figure).items():
        eye = figure.surface("helper-l-eye" if side == "left" else "helper-r-eye").with_normals()
        eye, _ = eye.cut(eye.positions[:, 2] - center[2] - 0.003)
        eye = eye.simplify(num_faces).with_normals()
        middle = np.array([center[0], center[1], eye.positions[:, 2].max()])
        iris, white = eye.cut(_IRIS_M - np.linalg.norm((eye.positions - middle)[:, :2], axis=1))
        for name, part in (("eyes", white), ("iris", iris), ("pupils", _pupil(middle))):
            parts[name].append(part)
    return {name: merge(surfaces) for name, surfaces in parts.items()}


def _pupil(middle: FloatArray) -> Surface:
    """A flat disc just before the cornea."""
    angles = np.arange(8) * np.pi / 4.0
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(8)], axis=1) * _PUPIL_M
    points = np.concatenate([np.zeros((1, 3)), ring]) + middle + [0.0, 0.0, 0.0002]
    around = np.arange(8)
    faces = np.stack([np.zeros(8, np.int64), 1 + around, 1 + (around + 1) % 8], axis=1)
    weights = np.zeros((9, len(JOINT_NAMES)))
    weights[:, JOINT_NAMES.index("head")] = 1.0
    return Surface(points, faces, weights).with_normals()


def _simplify_head(figure: Figure, head: Surface, num_faces: int) -> Surface:
    """The head simplified, most of its triangles kept for the face.

    Distances from the middle of the face are raised to a power below one for the while, which
    makes eyes and mouth large and the back of the head small.
    """
    eyes = np.mean(list(eye_centers(figure).values()), axis=0)
    middle, power = eyes - np.array([0.0, 0.03, 0.01]), 0.4

    def warp(points: FloatArray, exponent: float) -> FloatArray:
        away = points - middle
        radius = np.linalg.norm(away, axis=1, keepdims=True)
        warped: FloatArray = middle + away * radius ** (exponent - 1.0)
        return warped

    magnified = head.moved(warp(head.positions, power))
    simple = magnified.simplify(num_faces, keep_borders=num_faces > 1000)
    return simple.moved(warp(simple.positions, 1.0 / power))


def skin(
    figure: Figure,
    cut: Cut,
    *,
    num_head: int,
    num_hands: int,
    num_eye: int,
    tuck: float,
    brow_m: float,
    beard: bool,
) -> dict[str, Surface]:
    """Parts by colour name: `skin`, `lips`, `brows`, `lashes`, `beard`, `eyes`, `iris`, `pupils`.

    Args:
        figure: The body.
        cut: Its clothes; skin deep under them is left out.
        num_head: About how many triangles head and neck may have.
        num_hands: About how many triangles both hands may have together.
        num_eye: About how many triangles one eye may have.
        tuck: Slope at which skin sinks under the clothes; more for coarser surfaces.
        brow_m: Thickness of the eyebrows, metres.
        beard: Whether a beard is coloured in.
    """
    body = figure.surface("body")
    open_faces = body.scalars["inside"][body.faces].min(axis=1) < 0.5
    body = body.with_faces(body.faces[open_faces])
    body, _ = body.cut(skin_field(figure, cut, body.positions))
    normals = body.vertex_normals()
    sunk = (-skin_field(figure, cut, body.positions) + OVERLAP_M).clip(0.0, OVERLAP_M) * tuck
    body = body.moved(body.positions - normals * sunk[:, None])
    body = dataclasses.replace(body, scalars={"lips": _lip_field(body)})
    arms, head = body.cut(np.abs(body.positions[:, 0]) - figure.joints["left_shoulder"][0])
    head = _simplify_head(figure, head, num_head).with_normals()
    parts: dict[str, Surface] = {"lashes": _lashes(figure, head)}
    parts["lips"], rest = head.cut(head.scalars["lips"])
    brows = []
    for side in ("left", "right"):
        brow, rest = _brow(figure, rest, side, brow_m)
        brows.append(brow)
    parts["brows"] = merge(brows)
    if beard:
        parts["beard"], rest = rest.cut(_beard_field(figure, rest))
    hands = [arms.cut(sign * arms.positions[:, 0])[0] for sign in (1.0, -1.0)]
    parts["skin"] = merge([rest, *(hand.simplify(num_hands // 2).with_normals() for hand in hands)])
    return {**parts, **_eyes(figure, num_eye)}
