"""Makes `exact.json`: shortest ways on the islands of furnished homes, by extremitypathfinder.

    pip install extremitypathfinder==2.7.2          (needs NumPy 1: an environment of its own)
    python make_exact.py HOME.navmesh ...

HOME.navmesh is a file of `NavMesh.save`; its largest island is kept as rings of corners, so that
the lengths do not depend on how homes or navmeshes are made. Here: the four homes of the built-in
release. The peer is an exact solver on one polygon with holes, written independently.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

NUM_PAIRS = 40


def main(paths: list[str]) -> None:
    from extremitypathfinder import PolygonEnvironment  # type: ignore[import-not-found]

    from affectsim_data.navmesh import NavMesh

    homes = []
    for seed, path in enumerate(paths):
        navmesh, rng = NavMesh.load(path), np.random.default_rng(seed)
        rings = [ring.astype(float).round(3) for ring in navmesh.islands[0].rings]
        environment = PolygonEnvironment()
        environment.store(rings[0], rings[1:], validate=True)
        points = navmesh.random_points(8 * NUM_PAIRS, rng, island=0).round(3)
        points = points[navmesh.distance_to_wall(points) > 0.01][: 2 * NUM_PAIRS, [0, 2]]
        lengths = [
            environment.find_shortest_path(tuple(start), tuple(end))[1]
            for start, end in points.reshape(-1, 2, 2)
        ]
        homes.append(
            {
                "rings": [ring.tolist() for ring in rings],
                "pairs": points.reshape(-1, 4).tolist(),
                "lengths_m": [round(float(length), 5) for length in lengths],
            }
        )
    lines = ",\n".join(json.dumps(home) for home in homes)
    Path(__file__).with_name("exact.json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
