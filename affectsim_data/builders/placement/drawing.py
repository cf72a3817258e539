"""Candidates of one slot: pairs of a pool with the slot's motions put there."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from affectsim_data.affordances import rooms_of
from affectsim_data.builders.placement.ledger import Ledger
from affectsim_data.builders.placement.pools import Pool, distance_suits
from affectsim_data.builders.placement.stages import Placement, Stage
from affectsim_data.builders.placement.supports import MotionSet, place_at_supports
from affectsim_data.builders.recipes import Recipe, Thresholds
from affectsim_data.builders.slots import Slot
from affectsim_data.poses import (
    FloatArray,
    compose_pose,
    quaternion_rotate,
    transform_points,
    yaw_quaternion,
)
from affectsim_data.schemas import Challenge

__all__ = ["GRID_SLACK_M", "PERSON_CLEARANCE_M", "Candidates", "draw_candidates"]

PERSON_CLEARANCE_M = 0.12
"""Free floor around a pelvis beyond the robot radius that the navmesh already keeps."""
GRID_SLACK_M = 0.03
"""About how far the grid may be off."""
_START_JITTER_DEG = 8.0
_DRAWN, _ROUNDS, _ENOUGH = 512, 16, 48
_ROOM_WORDS = "floor under the whole motion"


@dataclasses.dataclass(frozen=True, eq=False)
class Candidates:
    """Placements of one slot to be looked at in order, arrays over `n`."""

    anchor: FloatArray
    """`(n, 3)`, metres."""
    facing: FloatArray
    """Radians, `(n,)`."""
    start: FloatArray
    """`(n, 3)`, metres."""
    start_yaw: FloatArray
    """Radians, `(n,)`."""
    support: NDArray[np.intp]
    """Seat or door, -1 for none, `(n,)`."""

    def __len__(self) -> int:
        return len(self.anchor)

    @property
    def T_world_performance(self) -> FloatArray:
        """Performance frames, `(n, 4, 4)`."""
        return compose_pose(yaw_quaternion(self.facing), self.anchor)

    @property
    def distance(self) -> FloatArray:
        """From start to anchor, metres, `(n,)`."""
        distance: FloatArray = np.linalg.norm(self.start - self.anchor, axis=1)
        return distance

    def taken(self, which: NDArray[np.intp]) -> Candidates:
        """Some of them."""
        return Candidates(*(getattr(self, one.name)[which] for one in dataclasses.fields(self)))

    def placement(self, number: int, stage: Stage, slot: Slot) -> Placement:
        """One of them."""
        word = {"seat": "seat", "before_seat": "seat", "door": "door"}.get(slot.placement)
        room = int(rooms_of(stage.scene, self.anchor[number]))
        return Placement(
            anchor=self.anchor[number],
            facing=float(self.facing[number]),
            start=self.start[number],
            start_yaw=float(self.start_yaw[number]),
            room_id=stage.scene.rooms[room].room_id,
            support=word and f"{word} {int(self.support[number])}",
        )


def draw_candidates(
    stage: Stage,
    slot: Slot,
    wanted: MotionSet,
    pool: Pool,
    recipe: Recipe,
    *,
    ledger: Ledger,
    rng: np.random.Generator,
) -> Candidates:
    """Candidates of a slot in random order, all in the right place for what the slot does.

    Args:
        stage: The scene.
        slot: What for.
        wanted: Its motions.
        pool: Of the slot's kind of placement and challenge.
        recipe: Thresholds.
        ledger: Counts what is left.
        rng: Of the slot.
    """
    if slot.placement in ("floor", "pair"):
        found = _on_floor(stage, slot, wanted, pool, recipe.thresholds, ledger, rng)
    else:
        found = _at_supports(stage, slot, wanted, pool, ledger, rng)
    suits = distance_suits(slot.challenge, found.distance, recipe.thresholds)
    rooms = rooms_of(stage.scene, found.anchor)
    suits &= rooms >= 0
    if slot.challenge is None:
        suits &= rooms == rooms_of(stage.scene, found.start)
    return found.taken(ledger.keep("a start at the right distance", np.arange(len(found)), suits))


def _at_supports(
    stage: Stage,
    slot: Slot,
    wanted: MotionSet,
    pool: Pool,
    ledger: Ledger,
    rng: np.random.Generator,
) -> Candidates:
    index, which = np.unique(pool.support, return_inverse=True)
    anchor, facing, holds = place_at_supports(
        stage.scene, stage.navmesh, slot.placement, index, wanted
    )
    pairs = pool.order(rng)
    for words, right in holds.items():
        pairs = ledger.keep(words, pairs, right[which[pairs]])
    anchor, facing, start = anchor[which[pairs]], facing[which[pairs]], pool.start[pairs]
    start_yaw = _looking(start, pool.place[pairs], rng)
    return Candidates(anchor, facing, start, start_yaw, pool.support[pairs])


def _on_floor(
    stage: Stage,
    slot: Slot,
    wanted: MotionSet,
    pool: Pool,
    limits: Thresholds,
    ledger: Ledger,
    rng: np.random.Generator,
) -> Candidates:
    """Pairs of the pool, each with a facing at which all motions have the floor they need."""
    order, found, count = pool.order(rng), [], 0
    for turn in range(_ROUNDS):
        drawn = np.arange(turn * _DRAWN, turn * _DRAWN + min(_DRAWN, len(pool)))
        pairs = order[drawn % len(pool)]
        place, start = pool.place[pairs], pool.start[pairs]
        facing = _facings(slot.challenge, start - place, wanted, limits, rng)
        anchor = place - quaternion_rotate(yaw_quaternion(facing), wanted.middle)
        fits = _has_room(stage, wanted, anchor, facing)
        yaw = _looking(start, place, rng)
        found.append(Candidates(anchor, facing, start, yaw, pool.support[pairs]).taken(fits))
        count += len(fits)
        if count >= _ENOUGH:
            break
    ledger.note(_ROOM_WORDS, count)
    return Candidates(
        *(
            np.concatenate([getattr(part, one.name) for part in found])
            for one in dataclasses.fields(Candidates)
        )
    )


def _has_room(
    stage: Stage, wanted: MotionSet, anchor: FloatArray, facing: FloatArray
) -> NDArray[np.intp]:
    """Which places have floor under all motions, by the grid."""
    least = PERSON_CLEARANCE_M - GRID_SLACK_M
    left = np.arange(len(anchor))
    # A few points throw out most places.
    for points in (wanted.footprint[::12], wanted.footprint):
        poses = compose_pose(yaw_quaternion(facing[left]), anchor[left])
        around = stage.floor.around(transform_points(poses, points))
        left = left[np.all(around >= least, axis=1)]
    return left


def _facings(
    challenge: Challenge | None,
    way: FloatArray,
    wanted: MotionSet,
    limits: Thresholds,
    rng: np.random.Generator,
) -> FloatArray:
    """Facings for starts off by `way` `(n, 3)`: any, or with the back to the robot."""
    if challenge != "rear_view":
        return rng.uniform(-math.pi, math.pi, len(way))
    spread = max(abs(wrapped(one.mean_heading - wanted.heading)) for one in wanted.members)
    free = max(math.pi - math.radians(limits.rear_bearing_deg) - float(spread), 0.0)
    away = np.arctan2(-way[:, 0], -way[:, 2]) + rng.uniform(-free, free, len(way))
    return wrapped(away - wanted.heading)


def _looking(start: FloatArray, place: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Yaws of a robot that looks at places, give or take; at yaw 0 it looks along -Z."""
    way = start - place
    jitter = np.radians(rng.uniform(-_START_JITTER_DEG, _START_JITTER_DEG, len(way)))
    return wrapped(np.arctan2(way[:, 0], way[:, 2]) + jitter)


def wrapped(angle: FloatArray | float) -> FloatArray:
    """The same angles in (-pi, pi]."""
    turned: FloatArray = np.angle(np.exp(1j * np.asarray(angle)))
    return turned
