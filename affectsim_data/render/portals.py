"""Which rooms a camera may see through doorways, and in what part of the image. NumPy only.

A scene that names its doorways says that its rooms are closed but for these: whatever one sees of
another room, one sees through them. So from the room the camera stands in, every doorway in view
is followed into the room behind it, and there only what is in view through it is followed further.
Every step errs towards seeing more: what is drawn in vain costs time, what is missing is an error.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.render.framing import NEAR_M
from affectsim_data.scenes import Doorway, Room, Scene

__all__ = ["Portals"]

EYE_MARGIN_M = 0.01
"""How much farther away than the near plane walls must be: what it cuts off can be seen through."""
OPENING_MARGIN_M = 0.06
"""By how much holes are taken to be larger than they are told, on every side."""
WINDOW_MARGIN = 0.01
"""By how much windows are widened on every side; the image is 2 wide. About two samples."""
MAX_STEPS = 512
"""Doorways followed for one frame before everything is drawn: open plans have many ways."""
_NEAREST_M = 1e-3
"""Least depth of a point of a hole: they are never nearer than the near plane's corners."""

_Window = tuple[float, float, float, float]
_WHOLE: _Window = (-1.0, -1.0, 1.0, 1.0)
_NOTHING: _Window = (1.0, 1.0, -1.0, -1.0)


class Portals:
    """Rooms and doorways of a scene, ready to be followed from any camera."""

    def __init__(self, scene: Scene) -> None:
        numbers = {room.room_id: place for place, room in enumerate(scene.rooms)}
        self._rooms = scene.rooms
        self._outside = len(scene.rooms)
        self._holes = np.array([_hole(doorway) for doorway in scene.doorways])
        self._exits: list[list[tuple[int, int]]] = [[] for _ in range(self._outside + 1)]
        for place, doorway in enumerate(scene.doorways):
            # A room that is not there stands for outside, from where anything might be seen.
            one, other = (numbers.get(room_id, self._outside) for room_id in doorway.room_ids)
            self._exits[one].append((place, other))
            self._exits[other].append((place, one))

    def windows(self, clip_from_world: FloatArray, eyes: FloatArray) -> list[FloatArray | None]:
        """What part of the image each room can be seen in, for every camera.

        Args:
            clip_from_world: Clip matrices, `(num_frames, 4, 4)`.
            eyes: Where the cameras are, `(num_frames, 3)`.

        Returns:
            Per camera `(num_rooms + 1, 4)`: least x and y, greatest x and y in normalised device
            coordinates; least > greatest if a room cannot be seen. The last row, index -1, is for
            what is in no room: the whole image. `None` where rooms cannot be told apart: the
            camera is in none or too near to a wall, it is in a doorway, or it sees outside.
        """
        found: list[FloatArray | None] = [None] * len(eyes)
        if not len(self._holes):
            return found
        margin = _near_reach(clip_from_world[0]) + EYE_MARGIN_M
        inside = np.stack([_contains(room, eyes, margin) for room in self._rooms], axis=1)
        around = np.stack([_contains(room, eyes, -margin) for room in self._rooms], axis=1)
        holes = _hole_windows(self._holes, clip_from_world)
        clear = inside.any(axis=1) & ~self._in_holes(eyes, margin)
        for frame in np.flatnonzero(clear).tolist():
            found[frame] = self._follow(np.flatnonzero(around[frame]).tolist(), holes[frame])
        return found

    def _in_holes(self, eyes: FloatArray, margin: float) -> NDArray[np.bool_]:
        """Which cameras are in a doorway, from one face of its wall to the other, `(n,)`."""
        start, end = self._holes[:, 0, 0], self._holes[:, 1, 0]
        axes = np.stack([end - start, self._holes[:, 0, 1] - start], axis=1)
        length = np.linalg.norm(axes, axis=2)
        along = np.einsum("fdk,dak->fda", eyes[:, None] - start, axes) / np.maximum(length, 1e-9)
        within = (along > -margin) & (along < length + margin)
        return np.asarray(within.all(axis=2).any(axis=1))

    def _follow(self, rooms: list[int], holes: FloatArray) -> FloatArray | None:
        """The windows of one frame; every way through doorways is gone, none of them twice."""
        windows, seen = holes.tolist(), [_NOTHING] * (self._outside + 1)
        ways: list[tuple[int, _Window, frozenset[int]]] = [(r, _WHOLE, frozenset()) for r in rooms]
        steps = 0
        while ways:
            room, window, crossed = ways.pop()
            seen[room] = window if seen[room] == _NOTHING else _union(seen[room], window)
            steps += 1
            if room == self._outside or steps > MAX_STEPS:
                return None
            for doorway, other in self._exits[room]:
                through = _intersection(window, windows[doorway])
                if doorway not in crossed and through[0] < through[2] and through[1] < through[3]:
                    ways.append((other, through, crossed | {doorway}))
        seen[self._outside] = _WHOLE
        return np.array(seen)


def _union(a: _Window, b: _Window) -> _Window:
    return (min(a[0], b[0]), min(a[1], b[1]), max(a[2], b[2]), max(a[3], b[3]))


def _intersection(a: _Window, b: _Window) -> _Window:
    return (max(a[0], b[0]), max(a[1], b[1]), min(a[2], b[2]), min(a[3], b[3]))


def _hole(doorway: Doorway) -> FloatArray:
    """Both ends of the hole through the wall as rectangles, widened, `(2, 4, 3)`."""
    yaw = math.radians(doorway.yaw_deg)
    through = np.array([math.sin(yaw), 0.0, math.cos(yaw)])
    across, up = np.array([through[2], 0.0, -through[0]]), np.array([0.0, 1.0, 0.0])
    half = doorway.width / 2.0 + OPENING_MARGIN_M
    low, high = -OPENING_MARGIN_M, doorway.height + OPENING_MARGIN_M
    places = ((-half, low), (half, low), (half, high), (-half, high))
    end = np.array(doorway.position) + np.array([u * across + y * up for u, y in places])
    return np.stack([end + side * doorway.depth / 2.0 * through for side in (-1.0, 1.0)])


def _near_reach(clip_from_world: FloatArray) -> float:
    """How far from the camera the corners of the near plane are, metres."""
    slopes = 1.0 / np.linalg.norm(clip_from_world[:2, :3], axis=1)
    return NEAR_M * math.sqrt(1.0 + float(slopes @ slopes))


def _contains(room: Room, points: FloatArray, margin: float) -> NDArray[np.bool_]:
    """Which points are in a room and `margin` away from its bounds; if less than 0, around it."""
    start = np.array(room.polygon)
    along = np.roll(start, -1, axis=0) - start
    offset = points[:, None, [0, 2]] - start
    # Even-odd rule: edges that a ray towards +x crosses.
    crosses = (offset[..., 1] < 0.0) != (offset[..., 1] < along[:, 1])
    rise = np.where(along[:, 1] == 0.0, 1.0, along[:, 1])
    inside = (crosses & (offset[..., 0] < offset[..., 1] / rise * along[:, 0])).sum(axis=1) % 2 == 1
    square = np.maximum(np.einsum("ek,ek->e", along, along), 1e-12)
    share = np.clip(np.einsum("pek,ek->pe", offset, along) / square, 0.0, 1.0)
    gap = np.linalg.norm(offset - share[..., None] * along, axis=2).min(axis=1)
    height = points[:, 1]
    level = (height > room.floor_y + margin) & (height < room.ceiling_y - margin)
    on_plan = inside & (gap > margin) if margin > 0.0 else inside | (gap < -margin)
    return np.asarray(on_plan & level)


def _hole_windows(holes: FloatArray, clip_from_world: FloatArray) -> FloatArray:
    """Windows that both ends of each hole leave, `(num_frames, num_holes, 4)`.

    Where an edge goes behind the camera it ends where it does.
    """
    clip = np.einsum("fij,dskj->fdski", clip_from_world[:, :, :3], holes)
    clip += clip_from_world[:, None, None, None, :, 3]
    following = np.roll(clip, -1, axis=3)
    w, w_next = clip[..., 3], following[..., 3]
    front = w > _NEAREST_M
    cut = front != (w_next > _NEAREST_M)
    share = np.where(cut, (_NEAREST_M - w) / np.where(cut, w_next - w, 1.0), 0.0)
    points = np.concatenate([clip, clip + share[..., None] * (following - clip)], axis=3)
    valid = np.concatenate([front, cut], axis=3)[..., None]
    places = points[..., :2] / np.where(valid, points[..., 3:], 1.0)
    low = np.where(valid, places, np.inf).min(axis=3).max(axis=2)
    high = np.where(valid, places, -np.inf).max(axis=3).min(axis=2)
    window: FloatArray = np.concatenate([low - WINDOW_MARGIN, high + WINDOW_MARGIN], axis=2)
    return window
