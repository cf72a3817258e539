"""Cameras that hold people tightly through a whole motion, still or gliding along with them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from affectsim_data.cameras import Camera, CameraTrajectory
from affectsim_data.episodes import Person
from affectsim_data.poses import FloatArray, look_at
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["TRAVEL_M", "View", "needed_aspect", "sheet_camera"]

TRAVEL_M = 0.7
"""People who go farther than this from the middle of their way are followed."""
_ELEVATION = 0.2
_VFOV = np.deg2rad(26.0)
"""Narrow, so that nobody is drawn large for being nearer."""
_BESIDE = np.deg2rad(20.0)
"""How far from square two people are seen: both are a little in front or behind."""
_FLOOR = np.array([1.0, 0.0, 1.0])
_RATE_HZ = 15.0
_PADS_M = {"head": 0.21, "left_wrist": 0.19, "right_wrist": 0.19, "left_foot": 0.11}
_PADS_M["right_foot"] = _PADS_M["left_foot"]
_PAD_M = 0.11


class View:
    """What a camera has to hold: joints of all instants, seen from one side.

    Who stays is seen by a still camera. Who walks off is followed by a camera that moves as they
    do, without turning, so that they stay large and the floor passes by.
    """

    def __init__(self, people: Sequence[Person], azimuth_deg: float) -> None:
        """Looks at people from `azimuth_deg` to the left of where the first looks at the start.

        Two people are seen side by side, as near to that as it goes: neither hides the other.
        """
        self.people = people
        motion = people[0].motion
        time_s = np.arange(0.0, motion.duration_s, 1.0 / _RATE_HZ)
        joints = np.concatenate([_joints(person, time_s) for person in people], axis=1)
        low, high = joints.min(axis=(0, 1)), joints.max(axis=(0, 1))
        self.center = 0.5 * (low + high)
        self._reach: FloatArray = np.stack([low, high])[:, [0, 2]]
        roots = self._roots(time_s) - self.center * _FLOOR
        self.follows = float(np.linalg.norm(roots, axis=1).max()) > TRAVEL_M
        self.way = _way(people[0], azimuth_deg)
        if len(people) == 2:
            self.way = _beside(self.way, *(_joints(person, time_s)[:, 0] for person in people))
        axes = look_at(self.way, np.zeros(3))[:3, :3]
        seen = ((joints - self.targets(time_s)[:, None]) @ axes).reshape(-1, 3)
        pads = np.tile([_PADS_M.get(name, _PAD_M) for name in JOINT_NAMES], len(people))
        self._axes, self._seen = axes, seen
        self._pads = np.tile(pads, len(time_s))

    def targets(self, time_s: FloatArray) -> FloatArray:
        """What the camera moves along with at instants `(n,)`, `(n, 3)`."""
        if not self.follows:
            return np.tile(self.center, (len(time_s), 1))
        targets: FloatArray = self._roots(time_s) + self.center * [0.0, 1.0, 0.0]
        return targets

    def reach(self) -> FloatArray:
        """Corners of the floor that people come to, world x and z, `(2, 2)`."""
        return self._reach

    def aspect(self) -> float:
        """Width by height of what is seen."""
        x, y = self._seen[:, 0], self._seen[:, 1]
        width = (x + self._pads).max() - (x - self._pads).min()
        return float(width / ((y + self._pads).max() - (y - self._pads).min()))

    def trajectory(self, camera: Camera, time_s: FloatArray) -> CameraTrajectory:
        """Poses at instants `(n,)`, as near as holds every joint at every instant of the cycle."""
        half = np.tan([0.5 * camera.hfov, 0.5 * camera.vfov])
        # A point is in the image if |x - shift| <= half * (distance - z): two planes per side,
        # and the nearest camera lies where the outermost ones meet.
        right = np.max(self._seen[:, 2:] + (self._seen[:, :2] + self._pads[:, None]) / half, axis=0)
        left = np.max(self._seen[:, 2:] - (self._seen[:, :2] - self._pads[:, None]) / half, axis=0)
        shift, distance = 0.5 * half * (right - left), float(np.max(0.5 * (right + left)))
        pose = np.tile(np.eye(4), (len(time_s), 1, 1))
        pose[:, :3, :3] = self._axes
        offset = self._axes @ np.array([*shift, distance])
        pose[:, :3, 3] = self.targets(time_s) + offset
        return CameraTrajectory(pose)

    def _roots(self, time_s: FloatArray) -> FloatArray:
        """Middle of the people on the floor, `(n, 3)`."""
        roots = [_joints(person, time_s)[:, 0] for person in self.people]
        middle: FloatArray = np.mean(roots, axis=0) * _FLOOR
        return middle


def needed_aspect(views: Sequence[View], *, low: float = 0.5, high: float = 1.3) -> float:
    """Width by height of images that suit all views, within bounds."""
    return float(np.clip(max(view.aspect() for view in views), low, high))


def sheet_camera(width: int, height: int) -> Camera:
    """The camera of all sheets, for images of that size."""
    return Camera(width, height, hfov=2.0 * float(np.arctan(np.tan(_VFOV / 2.0) * width / height)))


def _joints(person: Person, time_s: FloatArray) -> FloatArray:
    """Joints in the world at instants `(n,)`, `(n, 22, 3)`."""
    joints: FloatArray = person.joint_frames(time_s)[..., :3, 3]
    return joints


def _way(person: Person, azimuth_deg: float) -> FloatArray:
    """Unit direction from people to the camera, `(3,)`."""
    facing = person.T_world_performance[:3, :3] @ np.array([0.0, 0.0, 1.0])
    azimuth = np.arctan2(facing[0], facing[2]) + np.deg2rad(azimuth_deg)
    way: FloatArray = np.array([np.sin(azimuth), _ELEVATION, np.cos(azimuth)])
    way /= np.linalg.norm(way)
    return way


def _beside(way: FloatArray, first: FloatArray, second: FloatArray) -> FloatArray:
    """Direction to a camera that sees two roots side by side, as near to `way` as that allows."""
    line = (second - first).mean(axis=0) * _FLOOR
    if float(np.linalg.norm(line)) < 0.1:
        return way
    line /= np.linalg.norm(line)
    side = np.cross([0.0, 1.0, 0.0], line)
    share = np.array([np.cos(_BESIDE), np.sin(_BESIDE)])
    share *= np.where(np.array([side @ way, line @ way]) >= 0.0, 1.0, -1.0)
    level = float(np.linalg.norm(way * _FLOOR))
    turned: FloatArray = level * (share[0] * side + share[1] * line)
    turned[1] = way[1]
    return turned
