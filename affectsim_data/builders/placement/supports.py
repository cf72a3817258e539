"""Seats and doors: where a set of motions must be put to sit on the one and knock on the other.

The rules read a set of motions as a whole, never an emotion: what they take from the motions is the
median over the set. Whether the place is right for each motion is measured after that.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from affectsim_data.affordances import knockable_doors, reachable_seats
from affectsim_data.builders.compositions import PlacementKind
from affectsim_data.builders.measuring import PELVIS_OVER_SEAT_M, Measures
from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import (
    FloatArray,
    compose_pose,
    quaternion_rotate,
    transform_points,
    yaw_quaternion,
)
from affectsim_data.scenes import Scene

__all__ = [
    "BEFORE_DOOR_M",
    "BEFORE_SEAT_M",
    "FEET_OFF_FLOOR_M",
    "HAND_SHORT_M",
    "HAND_THROUGH_M",
    "INSIDE_FREE",
    "INSIDE_SEATED",
    "PELVIS_OFF_SEAT_M",
    "PELVIS_OFF_SEAT_PLAN_M",
    "MotionSet",
    "Supports",
    "place_at_supports",
    "usable_supports",
]

PELVIS_OFF_SEAT_M = 0.08
"""Greatest height of a sitter's lowest pelvis over or under where it would rest on the seat."""
PELVIS_OFF_SEAT_PLAN_M = 0.12
"""Greatest distance on the plan between a sitter's lowest pelvis and the middle of the seat."""
FEET_OFF_FLOOR_M = 0.04
"""Greatest height of a sitter's floor over or under the floor of the room."""
HAND_THROUGH_M, HAND_SHORT_M = 0.04, 0.10
"""How far beyond a leaf or short of it the farthest point of a hand that knocks may be."""
_HAND_MARGIN_M = 0.015
"""Kept from going through: between the frames looked at hands come a little farther."""
INSIDE_FREE, INSIDE_SEATED = (0.002, 0.002), (0.15, 0.02)
"""Greatest shares of the rays inside a body that meet the scene, those in seat and thighs and the
other ones: sitters press into cushions, and touch what is around a seat."""
BEFORE_SEAT_M, BEFORE_DOOR_M = 0.25, 0.08
"""How far from the floor that the robot's middle can reach a slimmer person may stand."""
_FOOTPRINT_M = 0.02
_EDGE_M = 0.02
"""Between a hand that knocks and the edge of the leaf."""


@dataclasses.dataclass(frozen=True, eq=False)
class MotionSet:
    """What the motions of a slot ask for together."""

    members: tuple[Measures, ...]
    """One for each emotion."""
    scale: float
    """`motion_scale` of the performer, whose body they share."""

    @functools.cached_property
    def heading(self) -> float:
        """Median of the mean headings, radians."""
        return _median_angle([one.mean_heading for one in self.members])

    @functools.cached_property
    def low_heading(self) -> float:
        """Median of the headings while the pelvis is lowest, radians."""
        return _median_angle([one.low_heading for one in self.members])

    @functools.cached_property
    def middle(self) -> FloatArray:
        """Median of the mean places of the target's pelvis, on the floor, `(3,)`."""
        return self._median([one.middle for one in self.members])

    @functools.cached_property
    def low_pelvis(self) -> FloatArray:
        """Median of the lowest places of the pelvis, `(3,)`."""
        return self._median([one.low_pelvis for one in self.members])

    @functools.cached_property
    def footprint(self) -> FloatArray:
        """Floor under all pelvises of all motions, one point of each 2 cm, `(n, 3)`."""
        points = np.concatenate([one.footprint for one in self.members])
        _, first = np.unique(np.rint(points / _FOOTPRINT_M), axis=0, return_index=True)
        return points[np.sort(first)]

    @functools.cached_property
    def hands(self) -> FloatArray:
        """Farthest hands as seen along the median heading: side, height, ahead, `(n, 3)`."""
        hands = np.stack([one.hand for one in self.members])
        return quaternion_rotate(yaw_quaternion(-self.heading), hands)

    @staticmethod
    def _median(points: Sequence[FloatArray]) -> FloatArray:
        median: FloatArray = np.median(np.stack(points), axis=0)
        return median


def _median_angle(angles: Sequence[float]) -> float:
    """Median about the circular mean, radians."""
    turns = np.array(angles)
    mean = float(np.angle(np.exp(1j * turns).mean()))
    return mean + float(np.median(np.angle(np.exp(1j * (turns - mean)))))


@dataclasses.dataclass(frozen=True, eq=False)
class Supports:
    """Seats or doors of a scene that somebody can use, arrays over `n` of them."""

    index: NDArray[np.intp]
    """Place in `scene.seats` or `scene.doors`, `(n,)`."""
    place: FloatArray
    """On the floor, under the pelvis of who sits or before the leaf, `(n, 3)`."""
    constraint: str
    """What all the others lack."""


def usable_supports(scene: Scene, navmesh: NavMesh, kind: PlacementKind) -> Supports:
    """Seats with room for a sitter that a robot comes near, or closed doors one can stand before.

    Args:
        scene: With its seats and doors.
        navmesh: Of the scene.
        kind: `seat`, `before_seat` or `door`.
    """
    if kind == "door":
        if not scene.doors:
            return _none("a door")
        doors = knockable_doors(scene, navmesh)
        constraint = "a closed door one can stand before"
        index = np.flatnonzero(doors.is_knockable)
        return Supports(index, doors.stand[index], constraint)
    if not scene.seats:
        return _none("a seat")
    usable = reachable_seats(scene, navmesh).is_usable
    index = np.flatnonzero(usable)
    place = np.array([seat.position for seat in scene.seats], np.float64)[index]
    place[:, 1] -= np.array([seat.height for seat in scene.seats])[index]
    return Supports(index, place, "a seat in reach, with room for legs and trunk")


def _none(constraint: str) -> Supports:
    return Supports(np.zeros(0, np.intp), np.zeros((0, 3)), constraint)


def place_at_supports(
    scene: Scene, navmesh: NavMesh, kind: PlacementKind, index: NDArray[np.intp], wanted: MotionSet
) -> tuple[FloatArray, FloatArray, dict[str, NDArray[np.bool_]]]:
    """Where a set of motions goes at each support, and what holds there for every motion.

    Args:
        scene: With its seats and doors.
        navmesh: Of the scene.
        kind: `seat`, `before_seat` or `door`.
        index: Supports, `(n,)`.
        wanted: The motions.

    Returns:
        Anchors `(n, 3)`, facings `(n,)`, and for each constraint in order whether it holds, `(n,)`.
    """
    if kind == "door":
        return _before_doors(scene, navmesh, index, wanted)
    return _at_seats(scene, navmesh, kind, index, wanted)


def _at_seats(
    scene: Scene, navmesh: NavMesh, kind: PlacementKind, index: NDArray[np.intp], wanted: MotionSet
) -> tuple[FloatArray, FloatArray, dict[str, NDArray[np.bool_]]]:
    seats = [scene.seats[number] for number in index]
    position = np.array([seat.position for seat in seats], np.float64).reshape(-1, 3)
    height = np.array([seat.height for seat in seats], np.float64)
    facing = np.radians([seat.yaw_deg for seat in seats]) - wanted.low_heading
    anchor = position - quaternion_rotate(yaw_quaternion(facing), wanted.low_pelvis)
    over_seat = PELVIS_OVER_SEAT_M * wanted.scale
    floor = position[:, 1] - height
    lift = _lift(height + over_seat - wanted.low_pelvis[1]) if kind == "seat" else 0.0 * floor
    anchor[:, 1] = floor + lift
    pelvis = np.stack([one.low_pelvis for one in wanted.members])
    pelvis = anchor[:, None] + quaternion_rotate(yaw_quaternion(facing)[:, None], pelvis)
    off = pelvis - position[:, None]
    off_height = np.abs(off[..., 1] - over_seat).max(axis=1)
    off_plan = np.hypot(off[..., 0], off[..., 2]).max(axis=1)
    holds = {
        "a seat of the right height": (off_height <= PELVIS_OFF_SEAT_M)
        & (np.abs(lift) <= FEET_OFF_FLOOR_M),
        "pelvis over the seat in every emotion": off_plan <= PELVIS_OFF_SEAT_PLAN_M,
    }
    if kind == "before_seat":
        holds["free floor before the seat"] = navmesh.navigable(anchor, max_offset=BEFORE_SEAT_M)
    return anchor, facing, holds


def _lift(gap: FloatArray) -> FloatArray:
    """Height above the floor, metres, of who sits on seats a gap higher than the own ones, `(n,)`.

    Who stands up again stands on the floor; who only sits lets the feet hang a little from a high
    seat, and on a low one shares what is missing between the cushion and the soles.
    """
    return np.where(gap > 0.0, np.minimum(gap, FEET_OFF_FLOOR_M), gap / 3.0)


def _is_walkable(
    navmesh: NavMesh, anchor: FloatArray, facing: FloatArray, wanted: MotionSet
) -> NDArray[np.bool_]:
    """Whether all of the motions stay where a robot could almost go, at `n` anchors, `(n,)`."""
    way = transform_points(compose_pose(yaw_quaternion(facing), anchor), wanted.footprint)
    near = navmesh.navigable(way.reshape(-1, 3), max_offset=BEFORE_DOOR_M)
    return np.asarray(near.reshape(way.shape[:2]).all(axis=1))


def _before_doors(
    scene: Scene, navmesh: NavMesh, index: NDArray[np.intp], wanted: MotionSet
) -> tuple[FloatArray, FloatArray, dict[str, NDArray[np.bool_]]]:
    doors = [scene.doors[number] for number in index]
    yaw = np.radians([door.yaw_deg for door in doors])
    facing = yaw + np.pi - wanted.heading
    hands = wanted.hands
    # On the axis of the leaf, as far from it as hands reach, and so far that none goes through.
    side = quaternion_rotate(yaw_quaternion(-wanted.heading), wanted.middle)[0]
    farthest_m = float(hands[:, 2].max()) - HAND_THROUGH_M + _HAND_MARGIN_M
    reach = np.array([side, 0.0, max(float(np.median(hands[:, 2])), farthest_m)])
    leaf = np.array([door.knock_point for door in doors], np.float64).reshape(-1, 3)
    anchor = leaf - quaternion_rotate(yaw_quaternion(yaw + np.pi), reach)
    foot = np.array([door.hinge[1] for door in doors], np.float64)
    anchor[:, 1] = foot
    ahead = hands[:, 2] - reach[2]
    reaches = bool(np.all((ahead <= HAND_THROUGH_M) & (ahead >= -HAND_SHORT_M)))
    half = np.array([door.width for door in doors], np.float64) / 2.0 - _EDGE_M
    on_leaf = np.abs(hands[:, 0] - side).max() <= half
    on_leaf &= hands[:, 1].max() <= np.array([door.height for door in doors]) - _EDGE_M
    return (
        anchor,
        facing,
        {
            "hand at the leaf in every emotion": on_leaf & reaches,
            "free floor before the door": _is_walkable(navmesh, anchor, facing, wanted),
        },
    )
