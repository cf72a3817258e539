"""Pools: pairs of a place and a start in a scene that suit a challenge for a body of any kind.

Made once for a scene, by the recipe's seed, from a stand-in body of a few points; what a slot's own
motions make of a pair is measured later, and mostly agrees.
"""

from __future__ import annotations

import dataclasses
import zlib
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from affectsim_data.affordances import rooms_of
from affectsim_data.builders.compositions import PLACEMENT_KINDS, PlacementKind
from affectsim_data.builders.placement.ledger import Ledger
from affectsim_data.builders.placement.stages import Stage
from affectsim_data.builders.placement.supports import usable_supports
from affectsim_data.builders.recipes import Recipe, Thresholds
from affectsim_data.observations import head_camera_pose
from affectsim_data.poses import FloatArray
from affectsim_data.schemas import CHALLENGES, Challenge

__all__ = ["LEG_HEIGHT_M", "RING_M", "Pool", "distance_suits", "has_detour", "pool_of"]

LEG_HEIGHT_M = 0.4
"""At which a straight way is blocked for a robot."""
RING_M, RING_TOLERANCE_M = 1.0, 0.1
"""The ring a detour leads to."""
_PLACES, _STARTS = 400, 400
_DETOUR_PLACES, _DETOUR_STARTS = 48, 160
"""Fewer, because shortest ways cost more than rays."""
_MOST_PAIRS = 4000
_DETOUR_FROM_M = 2.0
"""Nearest start of a detour: there is a ring to go to."""
_PLACE_CLEARANCE_M = 0.1
"""Free floor around a place beyond the robot radius that the navmesh already keeps."""
_SLACK = 0.06
"""Of a stand-in's visible share, which comes in eighths."""
MARGIN_M = 1e-3
"""Kept from distances that are limits, so that nothing depends on rounding."""
_FIGURES = {
    "standing": ((0.1, 0.45, 0.8, 1.0, 1.2, 1.35, 1.5, 1.65), (-1, 1, -1, 2, -2, 1, -1, 0)),
    "seated": ((0.1, 0.35, 0.5, 0.65, 0.8, 0.95, 1.1, 1.25), (-1, 1, -1, 2, -2, 1, -1, 0)),
}
"""Heights of a stand-in's points in metres, and how far they are to the side in `_SIDE_M`."""
_SIDE_M = 0.11


@dataclasses.dataclass(frozen=True, eq=False)
class Pool:
    """Candidate pairs of a scene, arrays over `n` pairs."""

    place: FloatArray
    """Where the body is, on the floor, `(n, 3)`."""
    start: FloatArray
    """Where the robot is, `(n, 3)`."""
    support: NDArray[np.intp]
    """Seat or door at the place, its index in the scene; -1 for none, `(n,)`."""
    survivors: Mapping[str, int]
    """Pairs left after each constraint, in order."""

    def __len__(self) -> int:
        return len(self.place)

    def order(self, rng: np.random.Generator) -> NDArray[np.intp]:
        """All pairs in random order, those at any support equally likely to come early."""
        draws = rng.exponential(size=len(self))
        _, which, counts = np.unique(self.support, return_inverse=True, return_counts=True)
        return np.argsort(draws * counts[which], kind="stable")


def pool_of(stage: Stage, kind: PlacementKind, challenge: Challenge | None, recipe: Recipe) -> Pool:
    """The pool of a kind of placement and challenge in a scene; made once."""
    # A dyad's target stands where anybody would stand.
    kind = "floor" if kind == "pair" else "seat" if kind == "before_seat" else kind
    pool = stage.pools.get((kind, challenge))
    if pool is None:
        seed = [recipe.seed, 7, zlib.crc32(stage.scene.scene_id.encode())]
        seed += [PLACEMENT_KINDS.index(kind), (*CHALLENGES, None).index(challenge)]
        rng = np.random.default_rng(seed)
        pool = stage.pools[kind, challenge] = _make_pool(stage, kind, challenge, recipe, rng)
    return pool


def distance_suits(
    challenge: Challenge | None, distance: FloatArray, limits: Thresholds
) -> NDArray[np.bool_]:
    """Whether starts at distances `(...)` suit a challenge, `(...)`."""
    if challenge == "far_visible":
        return distance >= limits.far_distance_m + MARGIN_M
    if challenge == "obstacle_detour":
        return distance >= _DETOUR_FROM_M
    return (distance >= limits.near_m + MARGIN_M) & (distance <= limits.far_m - MARGIN_M)


def has_detour(geodesic: FloatArray, distance: FloatArray, limits: Thresholds) -> NDArray[np.bool_]:
    """Whether ways to the ring are long enough a detour, `(...)`.

    Args:
        geodesic: Shortest way from the start to the ring around the anchor, metres; may be `inf`
            or `nan` where there is none.
        distance: From start to anchor, metres.
        limits: Of the recipe.
    """
    straight = distance - RING_M - RING_TOLERANCE_M
    long_enough = geodesic >= limits.detour_ratio * straight + MARGIN_M
    return np.asarray(np.isfinite(geodesic) & long_enough & (straight > 0.0))


def is_blocked(stage: Stage, start: FloatArray, anchor: FloatArray) -> NDArray[np.bool_]:
    """Whether something stands in the straight way from starts to the ring around anchors.

    At the height of legs; `(n, 3)` each, `(n,)`.
    """
    way = anchor - start
    way[:, 1] = 0.0
    length = np.linalg.norm(way, axis=1, keepdims=True)
    ring = anchor - way * (RING_M / np.maximum(length, RING_M))
    lift = np.array([0.0, LEG_HEIGHT_M, 0.0])
    return stage.caster.hidden(start + lift, ring + lift)


def _make_pool(
    stage: Stage,
    kind: PlacementKind,
    challenge: Challenge | None,
    recipe: Recipe,
    rng: np.random.Generator,
) -> Pool:
    ledger, limits = Ledger(), recipe.thresholds
    place, support, starts = _places(stage, kind, challenge, ledger, rng)
    first, second = (grid.ravel() for grid in np.indices((len(place), len(starts))))
    distance = np.linalg.norm(starts[second] - place[first], axis=1)
    pairs = np.flatnonzero(distance_suits(challenge, distance, limits))
    ledger.note(_distance_words(challenge, limits), len(pairs))
    if challenge is None:
        rooms, other = rooms_of(stage.scene, place), rooms_of(stage.scene, starts)
        same = rooms[first[pairs]] == other[second[pairs]]
        pairs = ledger.keep("a start in the same room", pairs, same)
    pairs = rng.permutation(pairs)[:_MOST_PAIRS]
    if challenge == "obstacle_detour":
        blocked = is_blocked(stage, starts[second[pairs]], place[first[pairs]])
        pairs = ledger.keep("a blocked straight way", pairs, blocked)
        geodesic = stage.navmesh.distance_matrix(starts, place)[second[pairs], first[pairs]]
        # To the anchor it is at least as much farther than to the ring.
        geodesic = geodesic - RING_M - RING_TOLERANCE_M
        words = f"a detour of {limits.detour_ratio:g} times the straight way"
        pairs = ledger.keep(words, pairs, has_detour(geodesic, distance[pairs], limits))
    else:
        figure = "seated" if kind == "seat" else "standing"
        visible, in_image = _stand_in(
            stage, place[first[pairs]], starts[second[pairs]], figure, recipe
        )
        holds = _stand_in_holds(challenge, visible, in_image, limits)
        pairs = ledger.keep(_view_words(challenge), pairs, holds)
    return Pool(place[first[pairs]], starts[second[pairs]], support[first[pairs]], ledger.counts)


def _places(
    stage: Stage,
    kind: PlacementKind,
    challenge: Challenge | None,
    ledger: Ledger,
    rng: np.random.Generator,
) -> tuple[FloatArray, NDArray[np.intp], FloatArray]:
    """Places `(n, 3)`, their supports `(n,)` and starts `(m, 3)`."""
    detour = challenge == "obstacle_detour"
    starts = stage.navmesh.random_points(_DETOUR_STARTS if detour else _STARTS, rng, island=0)
    starts = starts[rooms_of(stage.scene, starts) >= 0]
    if kind in ("seat", "door"):
        supports = usable_supports(stage.scene, stage.navmesh, kind)
        ledger.note(supports.constraint, len(supports.index))
        return supports.place, supports.index, starts
    places = stage.navmesh.random_points(3 * _PLACES, rng, island=0)
    free = (stage.floor.around(places) >= _PLACE_CLEARANCE_M) & (rooms_of(stage.scene, places) >= 0)
    places = places[free][: _DETOUR_PLACES if detour else _PLACES]
    ledger.note("floor to stand on", len(places))
    return places, np.full(len(places), -1, np.intp), starts


def _stand_in(
    stage: Stage, place: FloatArray, start: FloatArray, figure: str, recipe: Recipe
) -> tuple[FloatArray, FloatArray]:
    """Visible share of a stand-in body at places, and its share in the image, `(n,)` each."""
    heights, sides = (np.array(values, np.float64) for values in _FIGURES[figure])
    way = place - start
    yaw = np.arctan2(-way[:, 0], -way[:, 2])
    across = np.stack([np.cos(yaw), 0.0 * yaw, -np.sin(yaw)], axis=1)
    points = place[:, None] + _SIDE_M * sides[:, None] * across[:, None]
    points[..., 1] += heights
    cameras = head_camera_pose(start, yaw, recipe.robot)
    inside = recipe.camera.sees(points, cameras)
    hidden = stage.caster.hidden(cameras[:, None, :3, 3], points)
    return (inside & ~hidden).mean(axis=1), inside.mean(axis=1)


def _stand_in_holds(
    challenge: Challenge | None, visible: FloatArray, in_image: FloatArray, limits: Thresholds
) -> NDArray[np.bool_]:
    if challenge == "partial_occlusion":
        holds = (visible >= limits.occluded_low - _SLACK) & (in_image >= limits.in_image)
        return np.asarray(holds & (visible <= limits.occluded_high + _SLACK))
    least = limits.grounded_visible if challenge is None else limits.visible
    return visible >= least + _SLACK


def _distance_words(challenge: Challenge | None, limits: Thresholds) -> str:
    if challenge == "far_visible":
        return f"a start {limits.far_distance_m:g} m or more away"
    if challenge == "obstacle_detour":
        return f"a start {_DETOUR_FROM_M:g} m or more away"
    return f"a start {limits.near_m:g} to {limits.far_m:g} m away"


def _view_words(challenge: Challenge | None) -> str:
    if challenge == "partial_occlusion":
        return "a view partly blocked by walls or furniture"
    if challenge == "far_visible":
        return "distance of 5 m or more inside view"
    return "a view past walls and furniture"
