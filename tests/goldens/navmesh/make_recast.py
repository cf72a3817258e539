"""Makes `recast.json`: ways and moves by Recast and Detour on 20 floors laid out like homes.

    g++ -O2 ORACLE.cpp -o ORACLE -lRecast -lDetour      (Debian: librecast-dev)
    python make_recast.py ./ORACLE

ORACLE reads `vertices.f32 faces.i32 CELL CELL_HEIGHT AGENT_HEIGHT AGENT_RADIUS AGENT_CLIMB` from
its arguments, builds a navmesh with Recast (settings as in habitat-sim, regions of 400 cells and
more) and answers lines of its standard input: `P ax ay az bx by bz` with the length of the path or
`inf`, `M ax ay az bx by bz` with where Detour's `moveAlongSurface` from a towards b ends. The file
here was made with Debian 12's librecast 1.5.1+git20210215.

A floor is a list of parts, `[kind, x, y, z, width, height, depth, yaw, tilt]`, kind 0 for a box and
1 for an upright prism of twelve sides; y is the middle of its foot.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

NUM_FLOORS, NUM_PAIRS, NUM_MOVES = 20, 60, 30
WALL_M, DOOR_M, CEILING_M, LINTEL_M, PRISM_SIDES = 0.12, 0.9, 2.5, 2.05, 12

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]
Part = list[float]
Rectangle = tuple[float, float, float, float]


def prism(corners: NDArray[np.float64]) -> Mesh:
    """An upright solid of height 1 over a convex outline `(x, z)`, counter-clockwise from above."""
    n = len(corners)
    low, high = (np.insert(corners, 1, y, axis=1) for y in (0.0, 1.0))
    here, there = np.arange(n), np.roll(np.arange(n), -1)
    sides = [[here, there, there + n], [here, there + n, here + n]]
    caps = [np.stack([np.zeros(n - 2, int), np.arange(1, n - 1), np.arange(2, n)])]
    faces = [np.stack(side, axis=1) for side in sides]
    faces += [caps[0].T[:, ::-1], caps[0].T + n]
    return np.concatenate([low, high]), np.concatenate(faces)


def _outline(sides: int) -> NDArray[np.float64]:
    angle = 2.0 * np.pi * (np.arange(sides) + 0.5) / sides
    ring = np.stack([np.cos(angle), -np.sin(angle)], axis=1)
    return np.asarray(ring / (2.0 * np.abs(ring).max()))


SHAPES = (prism(_outline(4)), prism(_outline(PRISM_SIDES)))


def floor_mesh(width: float, depth: float, parts: list[Part]) -> Mesh:
    """A level floor from the origin with parts on it."""
    corners = [[0.0, 0.0, 0.0], [width, 0.0, 0.0], [width, 0.0, depth], [0.0, 0.0, depth]]
    vertices, faces, count = [np.array(corners)], [np.array([[0, 2, 1], [0, 3, 2]])], 4
    for kind, x, y, z, wide, high, deep, yaw, tilt in parts:
        points, triangles = SHAPES[int(kind)]
        cos, sin = np.cos(yaw), np.sin(yaw)
        turn = np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])
        cos, sin = np.cos(tilt), np.sin(tilt)
        lean = np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]])
        vertices.append(points * [wide, high, deep] @ (turn @ lean).T + [x, y, z])
        faces.append(triangles + count)
        count += len(points)
    # Recast reads float32.
    merged = np.concatenate(vertices).astype(np.float32).astype(np.float64)
    return merged, np.concatenate(faces)


def random_floor(rng: np.random.Generator) -> tuple[float, float, list[Part]]:
    """Rooms with doorways between them, and furniture in each."""
    width, depth = rng.uniform(7.0, 10.5), rng.uniform(6.0, 8.5)
    rooms: list[Rectangle] = [(0.0, 0.0, width, depth)]
    parts: list[Part] = []
    for _ in range(int(rng.integers(2, 6))):
        rooms.sort(key=lambda r: (r[2] - r[0]) * (r[3] - r[1]))
        parts += _split(rooms, rng)
    for room in rooms:
        parts += _furniture(room, rng)
    rounded = [[round(float(value), 2 if k else 0) for k, value in enumerate(p)] for p in parts]
    return round(width, 2), round(depth, 2), rounded


def _split(rooms: list[Rectangle], rng: np.random.Generator) -> list[Part]:
    """Cuts the largest room in two by a wall with a doorway, in place."""
    low_x, low_z, high_x, high_z = rooms.pop()
    across = high_x - low_x < high_z - low_z
    low, high = (low_z, high_z) if across else (low_x, high_x)
    start, end = (low_x, high_x) if across else (low_z, high_z)
    cut = rng.uniform(0.35, 0.65) * (high - low) + low
    door = rng.uniform(start + 0.6, end - 0.6)
    pieces = [
        (start, door - DOOR_M / 2.0, 0.0, CEILING_M),
        (door - DOOR_M / 2.0, door + DOOR_M / 2.0, LINTEL_M, CEILING_M),
        (door + DOOR_M / 2.0, end, 0.0, CEILING_M),
    ]
    walls = []
    for a, b, foot, top in pieces:
        middle, length = (a + b) / 2.0, b - a
        if length > 0.02:
            place = [middle, foot, cut] if across else [cut, foot, middle]
            size = [length, top - foot, WALL_M] if across else [WALL_M, top - foot, length]
            walls.append([0.0, *place, *size, 0.0, 0.0])
    if across:
        rooms += [(low_x, low_z, high_x, cut), (low_x, cut, high_x, high_z)]
    else:
        rooms += [(low_x, low_z, cut, high_z), (cut, low_z, high_x, high_z)]
    return walls


def _furniture(room: Rectangle, rng: np.random.Generator) -> list[Part]:
    """Boxes against walls and askew, tables to look under, rugs, pots, a leaning plank."""
    low_x, low_z, high_x, high_z = room
    parts: list[Part] = []
    for _ in range(int((high_x - low_x) * (high_z - low_z) / 4.0)):
        x, z = rng.uniform(low_x, high_x), rng.uniform(low_z, high_z)
        wide, deep = rng.uniform(0.3, 1.8), rng.uniform(0.3, 0.9)
        yaw = rng.choice([0.0, np.pi / 2.0, rng.uniform(0.0, np.pi)], p=[0.4, 0.3, 0.3])
        kind = rng.choice(["box", "table", "rug", "pot", "platform", "plank"], p=_SHARES)
        if kind == "box":
            parts.append([0, x, 0, z, wide, rng.choice([0.45, 0.75, 2.0]), deep, yaw, 0])
        elif kind == "table":
            parts.append([0, x, 0.72, z, wide, 0.04, deep + 0.3, yaw, 0])
            parts.append([0, x, 0, z, 0.08, 0.72, 0.08, yaw, 0])
        elif kind == "rug":
            parts.append([0, x, 0, z, wide + 0.5, 0.02, deep + 0.7, yaw, 0])
        elif kind == "pot":
            parts.append(
                [1, x, 0, z, 0.2 + deep / 2.0, rng.uniform(0.3, 1.2), 0.2 + deep / 2.0, 0, 0]
            )
        elif kind == "platform":
            parts.append([0, x, 0, z, wide + 1.0, 0.12, deep + 0.8, yaw, 0])
        else:
            parts.append([0, x, 0, z, wide, 0.05, 1.5, yaw, rng.uniform(-1.2, -0.3)])
    return parts


_SHARES = (0.5, 0.15, 0.15, 0.12, 0.05, 0.03)


def answers(oracle: str, mesh: Mesh, questions: list[str]) -> list[str]:
    """One line per question."""
    with tempfile.TemporaryDirectory() as folder:
        vertices, faces = Path(folder, "vertices.f32"), Path(folder, "faces.i32")
        vertices.write_bytes(mesh[0].astype("<f4").tobytes())
        faces.write_bytes(mesh[1].astype("<i4").tobytes())
        settings = ["0.05", "0.05", "1.5", "0.3", "0.2"]
        command = [oracle, str(vertices), str(faces), *settings]
        text = "\n".join(questions)
        done = subprocess.run(command, input=text, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def _asked(kind: str, pairs: NDArray[np.float64]) -> list[str]:
    return [f"{kind} " + " ".join(f"{v:.3f}" for v in pair) for pair in pairs]


def main(oracle: str) -> None:
    from affectsim_data.navmesh import NavMesh

    floors = []
    for seed in range(NUM_FLOORS):
        rng = np.random.default_rng(seed)
        width, depth, parts = random_floor(rng)
        mesh = floor_mesh(width, depth, parts)
        # Our own mesh only proposes points that are clearly inside; Recast answers.
        navmesh = NavMesh.from_mesh(*mesh)
        points = navmesh.random_points(2000, rng).round(3)
        points = points[navmesh.navigable(points, 0.05)]
        points = points[navmesh.distance_to_wall(points) > 0.1]
        pairs = points[: 2 * NUM_PAIRS].reshape(-1, 6)
        starts = points[2 * NUM_PAIRS :][:NUM_MOVES]
        angle, length = rng.uniform(0.0, 2.0 * np.pi, NUM_MOVES), rng.choice([0.25, 0.5], NUM_MOVES)
        way = length[:, None] * np.stack([np.cos(angle), 0.0 * angle, np.sin(angle)], axis=1)
        moves = np.concatenate([starts, starts + way], axis=1).round(3)
        lengths = [float(v) for v in answers(oracle, mesh, _asked("P", pairs))]
        ends = [
            [float(v) for v in line.split()] for line in answers(oracle, mesh, _asked("M", moves))
        ]
        floors.append(
            {
                "width": width,
                "depth": depth,
                "parts": parts,
                "pairs": pairs.tolist(),
                "lengths_m": [None if np.isinf(v) else round(v, 4) for v in lengths],
                "moves": moves.tolist(),
                "ends": [[round(v, 4) for v in end] for end in ends],
            }
        )
    lines = ",\n".join(json.dumps(floor) for floor in floors)
    Path(__file__).with_name("recast.json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1])
