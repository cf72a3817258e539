"""What a person can do in a scene: its rooms, seats and doors, and the things that stand in it.

Points are `(x, y, z)` in the world, Y up, metres. Yaw angles are degrees counter-clockwise from
above, 0 looks along +Z.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from affectsim_data.poses import FloatArray

__all__ = ["Door", "Doorway", "Room", "SceneObject", "Seat"]

Point = tuple[float, float, float]


@dataclasses.dataclass(frozen=True)
class Room:
    """A room as a polygon on the floor plan."""

    room_id: str
    """Unique in its scene."""
    purpose: str
    """`living`, `kitchen`, `bedroom`, ..."""
    polygon: tuple[tuple[float, float], ...]
    """Corners `(x, z)`, metres, in order."""
    floor_y: float = 0.0
    """Height of its floor."""
    ceiling_y: float = 2.6
    """Height of its ceiling."""

    def __post_init__(self) -> None:
        if len(self.polygon) < 3 or any(len(corner) != 2 for corner in self.polygon):
            raise ValueError(
                f"room {self.room_id!r}: polygon must be three or more corners (x, z), "
                f"got {self.polygon}"
            )


@dataclasses.dataclass(frozen=True)
class Seat:
    """A place to sit."""

    position: Point
    """Middle of the seat surface's front half, where a sitter's pelvis rests."""
    yaw_deg: float
    """Which way a sitter looks."""
    depth: float
    """Free depth of the seat surface, metres."""
    height: float
    """Of the seat surface above the floor, metres."""


@dataclasses.dataclass(frozen=True)
class Door:
    """A door leaf; one that is closed can be knocked on."""

    knock_point: Point
    """On the leaf, about 1.4 m high."""
    yaw_deg: float
    """Which way the leaf faces, towards its free side."""
    width: float
    """Of the leaf, metres."""
    height: float
    """Of the leaf, metres."""
    hinge: Point
    """Foot of the axis the leaf turns about."""
    opening_deg: float = 0.0
    """How far the leaf stands open; 0 is closed."""
    room_id: str = ""
    """The room on its free side; empty if unknown."""

    @property
    def is_closed(self) -> bool:
        """Whether it can be knocked on."""
        return self.opening_deg == 0.0


@dataclasses.dataclass(frozen=True)
class Doorway:
    """A hole between two rooms that one can see and walk through."""

    room_ids: tuple[str, str]
    """The rooms it joins."""
    position: Point
    """Middle of its threshold, halfway through the wall."""
    yaw_deg: float
    """Direction through it, from the first room to the second."""
    width: float
    """Metres."""
    height: float
    """Metres above the threshold."""
    depth: float
    """Thickness of the wall, metres."""


@dataclasses.dataclass(frozen=True)
class SceneObject:
    """A thing that stands, lies or hangs in a scene, as a box about its vertical axis."""

    object_id: str
    """Unique in its scene."""
    category: str
    """`sofa`, `chair`, `table`, `bed`, `rug`, `picture`, ...; empty if unknown."""
    position: Point
    """Middle of the bottom of its box."""
    size: tuple[float, float, float]
    """Width along its own x, height, depth along its own z, metres."""
    yaw_deg: float
    """Which way its front faces."""
    room_id: str = ""
    """The room it is in; empty if unknown."""

    @property
    def footprint(self) -> FloatArray:
        """Corners of its box on the plan `(x, z)`, `(4, 2)`, in order."""
        half = np.array([self.size[0], self.size[2]]) / 2.0
        corners = half * [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        yaw = math.radians(self.yaw_deg)
        c, s = math.cos(yaw), math.sin(yaw)
        middle = np.array([self.position[0], self.position[2]])
        turned: FloatArray = middle + corners @ np.array([[c, -s], [s, c]])
        return turned
