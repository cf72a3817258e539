"""Makes `recast.json`: path lengths by Recast and Detour on random flats of boxes.

    python make_recast.py ORACLE

ORACLE is a program that reads `vertices.f32 faces.i32 CELL CELL_HEIGHT AGENT_HEIGHT AGENT_RADIUS
AGENT_CLIMB` from its arguments and `P ax ay az bx by bz` lines from its standard input, builds a
navmesh with Recast (settings as in habitat-sim, regions of 400 cells and more) and prints the
length of each path or `inf`. The file here was made with Debian 12's librecast 1.5.1+git20210215.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

NUM_FLATS = 6
NUM_PAIRS = 40
CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (0, 1) for z in (-0.5, 0.5)])
# Two triangles per side, counter-clockwise from outside.
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
BOX_FACES = np.array([t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))])

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]


def flat_mesh(boxes: list[list[float]]) -> Mesh:
    """A floor of 8 x 8 m with boxes `[x, z, width, depth, height, yaw]` on it."""
    vertices = [np.array([[-4, 0, -4], [4, 0, -4], [4, 0, 4], [-4, 0, 4]], np.float64)]
    faces = [np.array([[0, 2, 1], [0, 3, 2]])]
    for number, (x, z, width, depth, height, yaw) in enumerate(boxes):
        cos, sin = np.cos(yaw), np.sin(yaw)
        turn = np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])
        vertices.append(CORNERS * [width, height, depth] @ turn.T + [x, 0, z])
        faces.append(BOX_FACES + 4 + 8 * number)
    # Recast reads float32.
    merged = np.concatenate(vertices).astype(np.float32).astype(np.float64)
    return merged, np.concatenate(faces)


def random_boxes(rng: np.random.Generator) -> list[list[float]]:
    """Furniture-sized boxes and one wall, rounded so that the file stays small."""
    boxes = [[float(rng.uniform(-2, 2)), 0.0, 0.1, 6.5, 2.5, float(rng.uniform(-0.5, 0.5))]]
    for _ in range(14):
        x, z = rng.uniform(-4, 4, 2)
        width, depth = rng.uniform(0.2, 1.6, 2)
        height, yaw = rng.choice([0.1, 0.45, 0.75, 2.0]), rng.uniform(0, 3.14)
        boxes.append([x, z, width, depth, height, yaw])
    return [[round(float(value), 3) for value in box] for box in boxes]


def recast_lengths(oracle: str, mesh: Mesh, pairs: NDArray[np.float64]) -> list[float | None]:
    """Path length per pair, `(n, 6)`; `None` where there is no path."""
    with tempfile.TemporaryDirectory() as folder:
        vertices, faces = Path(folder, "vertices.f32"), Path(folder, "faces.i32")
        vertices.write_bytes(mesh[0].astype("<f4").tobytes())
        faces.write_bytes(mesh[1].astype("<i4").tobytes())
        settings = ["0.05", "0.05", "1.5", "0.3", "0.2"]
        queries = "\n".join("P " + " ".join(f"{v:.3f}" for v in pair) for pair in pairs)
        command = [oracle, str(vertices), str(faces), *settings]
        done = subprocess.run(command, input=queries, capture_output=True, text=True, check=True)
    lengths = [float(line) for line in done.stdout.split()]
    return [None if np.isinf(length) else round(length, 4) for length in lengths]


def main(oracle: str) -> None:
    from affectsim_data.navmesh import NavMesh

    flats = []
    for seed in range(NUM_FLATS):
        rng = np.random.default_rng(seed)
        boxes = random_boxes(rng)
        mesh = flat_mesh(boxes)
        # Our own mesh only proposes points that are clearly inside; Recast answers.
        navmesh = NavMesh.from_mesh(*mesh)
        points = navmesh.random_points(400, rng)
        points = points[navmesh.distance_to_wall(points) > 0.1][: 2 * NUM_PAIRS].round(3)
        pairs = np.concatenate([points[::2], points[1::2]], axis=1)
        lengths = recast_lengths(oracle, mesh, pairs)
        flats.append({"boxes": boxes, "pairs": pairs.tolist(), "lengths_m": lengths})
    lines = ",\n".join(json.dumps(flat) for flat in flats)
    Path(__file__).with_name("recast.json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1])
