"""What moving about in a home costs: its navmesh built, loaded and asked, on one core.

The homes are those of the built-in release. The peer is what one would write without this package:
the same floor as a grid of 0.05 m cells with eight neighbours and SciPy's Dijkstra from the start.
It is off by up to 8 % and answers one start for all ends; the column `ratio` is its time over ours
for one pair, both measured in the same process.

python -m benchmarks.navigation
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.parts import Rows, run_part, serve_part

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from affectsim_data.navmesh import NavMesh
    from affectsim_data.poses import FloatArray

_QUERIES, _ROUNDS, _PEER_QUERIES = 100, 5, 8
_MOVE_M, _RINGS_M, _CELL_M = 0.25, (1.0, 3.0, 5.0), 0.05


def navigation() -> Rows:
    """Milliseconds per home: build, load, first question, and then each kind of question."""
    from affectsim_data.builders.homes import build_home, home_recipes
    from affectsim_data.content import content_path

    rows = []
    for recipe in home_recipes(content_path("builders") / "homes-mini.toml"):
        scene = build_home(recipe, rng=np.random.default_rng(recipe.seed))
        rows.append(
            {"scene": scene.scene_id, "triangles": scene.num_triangles} | _costs(*scene.mesh())
        )
    return rows


def _costs(vertices: FloatArray, faces: NDArray[np.int64]) -> dict[str, float]:
    from affectsim_data.navmesh import NavMesh

    build = _least(lambda: NavMesh.from_mesh(vertices, faces), rounds=2)
    navmesh = NavMesh.from_mesh(vertices, faces)
    payload, start = navmesh.to_bytes(), time.process_time()
    navmesh = NavMesh.from_bytes(payload, name="benchmark")
    load = time.process_time() - start
    rng = np.random.default_rng(0)
    points = navmesh.random_points(2 * _QUERIES, rng, island=0)
    starts, ends = points[:_QUERIES], points[_QUERIES:]
    start = time.process_time()
    navmesh.distance_matrix(starts[:2], ends[:2])
    first = time.process_time() - start
    angle = rng.uniform(0.0, 2.0 * np.pi, _QUERIES)
    moves = starts + _MOVE_M * np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=1)
    geodesic = _per_query(navmesh.geodesic_distance, starts, ends)
    return {
        "floor_m2": navmesh.area_m2,
        "build_s": build,
        "load_ms": 1e3 * load,
        "first_question_ms": 1e3 * first,
        "geodesic_ms": geodesic,
        "three_rings_ms": _per_query(
            lambda a, b: [navmesh.ring_distance(a, b, r) for r in _RINGS_M], starts, ends
        ),
        "step_ms": _per_query(lambda a, b: navmesh.step(a, b), starts, moves),
        "slide_ms": _per_query(lambda a, b: navmesh.step(a, b, sliding=True), starts, moves),
        "ratio": _grid_ms(navmesh, starts, ends) / geodesic,
    }


def _per_query(
    ask: Callable[[FloatArray, FloatArray], object], starts: FloatArray, ends: FloatArray
) -> float:
    """Least milliseconds per question over rounds of more points than a navmesh remembers."""

    def one_round() -> None:
        for start, end in zip(starts, ends, strict=True):
            ask(start, end)

    return 1e3 * _least(one_round) / len(starts)


def _grid_ms(navmesh: NavMesh, starts: FloatArray, ends: FloatArray) -> float:
    """Milliseconds of the peer per pair."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    low, high = (np.array(corner) for corner in (navmesh.islands[0].low, navmesh.islands[0].high))
    shape = tuple(np.ceil((high - low)[[0, 2]] / _CELL_M).astype(int) + 1)
    cell = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
    centers = low + _CELL_M * np.insert(cell.reshape(-1, 2), 1, 0, axis=1)
    free = navmesh.navigable(centers, 0.05).reshape(shape)
    number = np.arange(free.size).reshape(shape)
    rows, columns, lengths = [], [], []
    for i, j in ((1, 0), (0, 1), (1, 1), (1, -1)):
        here = (slice(0, -1 if i else None), slice(max(0, -j), -1 if j > 0 else None))
        there = (slice(i, None), slice(max(0, j), -1 if j < 0 else None))
        both = free[here] & free[there]
        rows.append(number[here][both])
        columns.append(number[there][both])
        lengths.append(np.full(int(both.sum()), _CELL_M * np.hypot(i, j)))
    parts = (np.concatenate(part) for part in (lengths, rows, columns))
    length, row, column = parts
    graph = coo_array((length, (row, column)), shape=(free.size,) * 2).tocsr()
    places = [
        np.ravel_multi_index(tuple(np.rint((p - low)[:, [0, 2]] / _CELL_M).astype(int).T), shape)
        for p in (starts[:_PEER_QUERIES], ends[:_PEER_QUERIES])
    ]

    def ask() -> None:
        for start, end in zip(*places, strict=True):
            dijkstra(graph, directed=False, indices=start)[end]

    return 1e3 * _least(ask, rounds=2) / _PEER_QUERIES


def _least(work: Callable[[], object], *, rounds: int = _ROUNDS) -> float:
    """Least seconds of this process's time on the core."""
    seconds = []
    for _ in range(rounds):
        start = time.process_time()
        work()
        seconds.append(time.process_time() - start)
    return min(seconds)


PARTS = {"navigation": navigation}

if __name__ == "__main__":
    if len(sys.argv) > 1:
        serve_part(PARTS)
    else:
        print(json.dumps(run_part("benchmarks.navigation", "navigation", cores=1), indent=2))
