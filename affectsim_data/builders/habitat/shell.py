"""Floor, walls and ceiling around objects whose stage is not there."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from affectsim_data.builders.habitat.stand_ins import floor_height
from affectsim_data.builders.habitat.things import Thing
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Room, Surface

__all__ = ["Shell", "build_shell"]

_MARGIN_M = 0.06
"""Between the outermost objects and the walls: pictures hang on them."""
_POINT_MARGIN_M = 0.3
"""Around objects of which only the place is known."""
_HEIGHTS_M = (2.6, 4.0)
_REACH_M = (-0.6, 4.0)
"""Objects further below or above the floor do not say how large the room is."""
_SPAN_M = 100.0
_CELL_M = 0.5
"""Walls are divided this finely, so that light can be baked into their corners."""
_COLORS = {"floor": (176, 150, 122), "walls": (232, 230, 224), "ceiling": (244, 244, 242)}


@dataclasses.dataclass(frozen=True)
class Shell:
    """A single room."""

    surfaces: tuple[Surface, ...]
    room: Room
    left_out: int
    """Objects that stand so far off that the room does not reach to them."""


def build_shell(things: Sequence[Thing], anchors: Sequence[FloatArray]) -> Shell:
    """A box around the objects of a scene, with floor, walls and ceiling.

    Args:
        things: Objects with their meshes, or what stands for them.
        anchors: Where objects stand that have none.

    Raises:
        ValueError: There are no objects at all, or they are more than 100 m apart.
    """
    boxes = _boxes(things, anchors)
    if not len(boxes):
        raise ValueError("a shell needs objects to stand around, and there are none")
    floor_y = floor_height(boxes[:, 0, 1], boxes[:, 1, 1])
    near = (boxes[:, 0, 1] > floor_y + _REACH_M[0]) & (boxes[:, 0, 1] < floor_y + _REACH_M[1])
    low, high = boxes[near, 0].min(axis=0) - _MARGIN_M, boxes[near, 1].max(axis=0) + _MARGIN_M
    if (high - low)[[0, 2]].max() > _SPAN_M:
        raise ValueError(
            f"objects stand {(high - low)[[0, 2]].max():.0f} m apart, more than {_SPAN_M:.0f}: "
            "no shell is built around them"
        )
    ceiling_y = floor_y + float(np.clip(high[1] - floor_y, *_HEIGHTS_M))
    low, high = np.array([low[0], floor_y, low[2]]), np.array([high[0], ceiling_y, high[2]])
    corners = ((low[0], low[2]), (high[0], low[2]), (high[0], high[2]), (low[0], high[2]))
    polygon = tuple((float(x), float(z)) for x, z in corners)
    room = Room("room-0", "living", polygon, floor_y, ceiling_y)
    return Shell(_surfaces(low, high), room, int((~near).sum()))


def _boxes(things: Sequence[Thing], anchors: Sequence[FloatArray]) -> FloatArray:
    """Low and high corner of all objects, `(n, 2, 3)`."""
    found = [np.stack([thing.points.min(axis=0), thing.points.max(axis=0)]) for thing in things]
    around = np.array([_POINT_MARGIN_M, 0.0, _POINT_MARGIN_M])
    found += [np.stack([anchor - around, anchor + around]) for anchor in anchors]
    return np.array(found).reshape(-1, 2, 3)


def _surfaces(low: FloatArray, high: FloatArray) -> tuple[Surface, ...]:
    """Sheets that face inwards."""
    x, y, z = high - low
    right, up, forward = np.eye(3) * (high - low)
    sheets = {
        "floor": [(low, forward, right, (z, x))],
        "walls": [
            (low, right, up, (x, y)),
            (low + right, forward, up, (z, y)),
            (high - up, -right, up, (x, y)),
            (low + forward, -forward, up, (z, y)),
        ],
        "ceiling": [(low + up, right, forward, (x, z))],
    }
    return tuple(_sheets(name, parts) for name, parts in sheets.items())


def _sheets(
    name: str, parts: list[tuple[FloatArray, FloatArray, FloatArray, tuple[float, float]]]
) -> Surface:
    positions, normals, faces, start = [], [], [], 0
    for origin, across, along, lengths in parts:
        n, m = (max(1, int(np.ceil(length / _CELL_M))) for length in lengths)
        s, t = np.meshgrid(np.linspace(0.0, 1.0, n + 1), np.linspace(0.0, 1.0, m + 1))
        positions.append(origin + s.reshape(-1, 1) * across + t.reshape(-1, 1) * along)
        normal = np.cross(across, along)
        normals.append(np.tile(normal / np.linalg.norm(normal), (s.size, 1)))
        corner = (np.arange(m)[:, None] * (n + 1) + np.arange(n)).ravel() + start
        ends = np.stack([corner, corner + 1, corner + n + 2, corner + n + 1], axis=1)
        faces += [ends[:, [0, 1, 2]], ends[:, [0, 2, 3]]]
        start += s.size
    return Surface(
        name=f"shell/{name}",
        positions=np.concatenate(positions).astype(np.float32),
        normals=np.concatenate(normals).astype(np.float32),
        colors=np.tile(np.array([*_COLORS[name], 255], np.uint8), (start, 1)),
        faces=np.concatenate(faces).astype(np.uint32),
    )
