"""Empty rooms of all purposes drawn by seed, for tests of furnishing."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.plans import Opening, Rect, RoomPlan, Side
from affectsim_data.builders.homes.purposes import Purpose

__all__ = ["PALETTE", "PURPOSES", "drawn_room"]

PURPOSES: tuple[Purpose, ...] = ("living", "kitchen", "dining", "bedroom", "bath", "study", "hall")
_AREAS = {
    "living": (18, 45), "kitchen": (6, 20), "dining": (8, 22), "bedroom": (8, 22), "bath": (3, 10),
    "study": (6, 18), "hall": (4, 14),
}  # fmt: skip
_LEAST = {"bath": 1.5, "hall": 1.2}
PALETTE = Palette(
    **{
        name: np.array(color)
        for name, color in {
            "wall": (0.95, 0.93, 0.89), "accent_wall": (0.79, 0.82, 0.8),
            "floor": (0.79, 0.65, 0.49), "wood": (0.78, 0.62, 0.44),
            "dark_wood": (0.49, 0.36, 0.25), "sofa": (0.5, 0.56, 0.61),
            "textile": (0.85, 0.8, 0.72), "rug": (0.89, 0.87, 0.82),
            "accent": (0.79, 0.46, 0.31), "cabinet": (0.93, 0.92, 0.89),
        }.items()
    }
)  # fmt: skip


def drawn_room(purpose: Purpose, rng: np.random.Generator) -> RoomPlan:
    """A room of a usual size, with doors and windows anywhere in its walls."""
    low, high = _AREAS[purpose]
    ratio = float(rng.uniform(1.0, 2.6 if purpose == "hall" else 1.7))
    area = float(rng.uniform(low, high))
    least = _LEAST.get(purpose, 2.2)
    sides = [max(np.sqrt(area * ratio), least), max(np.sqrt(area / ratio), least)]
    width, depth = (float(side) for side in rng.permutation(sides))
    openings: list[Opening] = []
    doors = int(rng.integers(1, 5 if purpose in ("hall", "living") else 3))
    for _ in range(doors):
        _open(openings, "doorway", 0.9, 0.0, 2.05, (width, depth), rng)
    if purpose == "living" and rng.random() < 0.5:
        _open(openings, "doorway", 2.2, 0.0, 2.2, (width, depth), rng)
    if rng.random() < 0.3:
        _open(openings, "door", 0.9, 0.0, 2.05, (width, depth), rng)
    for _ in range(int(rng.integers(0, 3)) if purpose != "hall" else 0):
        small = purpose in ("kitchen", "bath")
        wide = 1.0 if small else float(rng.uniform(1.0, 2.0))
        _open(openings, "window", wide, 1.1 if small else 0.8, 2.1, (width, depth), rng)
    clear: tuple[Rect, ...] = ()
    if purpose == "living":
        size = np.array([3.2, 2.2] if width >= depth else [2.2, 3.2])
        corner = rng.uniform(0.1, np.maximum(np.array([width, depth]) - size - 0.1, 0.1))
        x, z = (float(value) for value in corner)
        clear = ((x, z, x + float(size[0]), z + float(size[1])),)
    return RoomPlan(
        purpose, purpose, 0.0, 0.0, width, depth, tuple(openings), (), clear
    )  # fmt: skip


def _open(
    openings: list[Opening], kind: str, width: float, bottom: float, top: float,
    size: tuple[float, float], rng: np.random.Generator,
) -> None:  # fmt: skip
    """Adds an opening away from the others; after some tries none."""
    sides: tuple[Side, ...] = ("left", "right", "back", "front")
    for _ in range(20):
        side = sides[int(rng.integers(4))]
        length = size[1] if side in ("left", "right") else size[0]
        if length < width + 0.5:
            continue
        middle = float(rng.uniform(width / 2.0 + 0.2, length - width / 2.0 - 0.2))
        near = (
            abs(middle - other.middle) < (width + other.width) / 2.0 + 0.35
            for other in openings
            if other.side == side
        )
        if any(near):
            continue
        curtains = kind == "window" and bottom < 1.0 and bool(rng.random() < 0.7)
        openings.append(Opening(kind, side, middle, width, bottom, top, curtains))  # type: ignore[arg-type]
        return
