"""Things to sit and lie on. Every piece stands on the floor at its origin and faces +Z."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box, cushion, lathe
from affectsim_data.builders.homes.pieces import Furniture, LocalSeat
from affectsim_data.poses import FloatArray

__all__ = [
    "Furniture",
    "LocalSeat",
    "armchair",
    "bed",
    "desk_chair",
    "dining_chair",
    "sofa",
    "stool",
]


def sofa(palette: Palette, *, places: int, rng: np.random.Generator) -> Furniture:
    """A sofa of two or three places on short legs, with throw pillows."""
    arm, depth, seat_y, place = 0.18, 0.92, 0.45, 0.62
    width = places * place + 2.0 * arm
    color = palette.sofa
    parts = [
        box((width - 0.04, 0.2, depth - 0.06), (0.0, 0.2, 0.0), color=color * 0.94,
            material="fabric", radius=0.02, segments=2),
        cushion((width - 2.0 * arm, 0.58, 0.2), (0.0, 0.53, -depth / 2.0 + 0.11), color=color,
                radius=0.06, puff=0.0, axis=2, cells=12),
    ]  # fmt: skip
    for sign in (-1.0, 1.0):
        middle = sign * (width - arm) / 2.0
        parts.append(cushion((arm, 0.5, depth), (middle, 0.37, 0.0), color=color, radius=0.06,
                             puff=0.015, axis=0, cells=8))  # fmt: skip
        parts += [_leg(sign * (width / 2.0 - 0.1), z, 0.12, palette) for z in (-0.36, 0.36)]
    seats = []
    for index in range(places):
        x = (index - (places - 1) / 2.0) * place
        parts.append(cushion((place - 0.005, 0.15, 0.7), (x, seat_y - 0.085, 0.1), color=color,
                             radius=0.05, puff=0.02))  # fmt: skip
        back = cushion((place - 0.01, 0.42, 0.17), (x, seat_y + 0.2, -0.2), color=color,
                       radius=0.07, puff=0.04, axis=2)  # fmt: skip
        parts.append(back.tilted(-0.16, pivot=(x, seat_y, -0.2)))
        seats.append(LocalSeat((x, seat_y, 0.24), 0.5))
    for sign in (-1.0, 1.0):
        parts.append(_pillow(sign * (places * place / 2.0 - 0.22), seat_y, palette, rng))
    return Furniture(tuple(parts), width, depth, 0.86, tuple(seats))


def _leg(x: float, z: float, height: float, palette: Palette, *, radius: float = 0.022) -> Part:
    profile = [(0.0, 0.0), (radius * 0.7, 0.0), (radius, height)]
    return lathe(profile, color=palette.dark_wood, material="wood", center=(x, 0.0, z), segments=12)


def _pillow(x: float, seat_y: float, palette: Palette, rng: np.random.Generator) -> Part:
    pillow = cushion((0.4, 0.4, 0.1), (0.0, 0.0, 0.0), color=palette.accent, radius=0.045,
                     puff=0.05, axis=2, cells=10)  # fmt: skip
    turn = float(rng.uniform(-0.25, 0.25))
    return pillow.tilted(-0.3).moved(x, seat_y + 0.2, 0.0, yaw=turn)


def armchair(palette: Palette) -> Furniture:
    """A low upholstered chair with a wooden frame."""
    color, width, depth, seat_y = palette.textile, 0.74, 0.78, 0.44
    parts = [
        cushion((0.58, 0.15, 0.62), (0.0, seat_y - 0.085, 0.06), color=color, radius=0.05,
                puff=0.02),
        cushion((0.58, 0.56, 0.15), (0.0, seat_y + 0.2, -0.27), color=color, radius=0.06,
                puff=0.03, axis=2).tilted(-0.2, pivot=(0.0, seat_y, -0.27)),
        box((0.6, 0.05, 0.62), (0.0, 0.26, 0.04), color=palette.wood, material="wood"),
    ]  # fmt: skip
    for sign in (-1.0, 1.0):
        x = sign * (width / 2.0 - 0.03)
        parts += [
            box((0.05, 0.6, 0.05), (x, 0.3, 0.3), color=palette.wood, material="wood"),
            box((0.05, 0.66, 0.05), (x, 0.33, -0.26), color=palette.wood, material="wood"),
            box((0.06, 0.035, 0.68), (x, 0.61, 0.02), color=palette.wood, material="wood",
                radius=0.012),
            box((0.025, 0.05, 0.5), (x, 0.3, 0.02), color=palette.wood, material="wood"),
        ]  # fmt: skip
    return Furniture(
        tuple(parts), width, depth, 0.92, (LocalSeat((0.0, seat_y, 0.2), 0.5),)
    )  # fmt: skip


def dining_chair(palette: Palette) -> Furniture:
    """A wooden chair with a padded seat and three slats."""
    wood, seat_y = palette.dark_wood, 0.46
    parts = [
        cushion((0.44, 0.05, 0.43), (0.0, seat_y - 0.028, 0.015), color=palette.textile,
                radius=0.02, puff=0.006),
        box((0.41, 0.05, 0.4), (0.0, seat_y - 0.075, 0.0), color=wood, material="wood"),
    ]  # fmt: skip
    for sign in (-1.0, 1.0):
        x = sign * 0.19
        parts += [
            box((0.035, seat_y - 0.05, 0.035), (x, (seat_y - 0.05) / 2.0, 0.19), color=wood,
                material="wood"),
            box((0.035, 0.9, 0.035), (x, 0.45, -0.2), color=wood, material="wood"),
            box((0.02, 0.03, 0.36), (x, 0.2, 0.0), color=wood, material="wood"),
        ]  # fmt: skip
    for y in (0.6, 0.72, 0.85):
        parts.append(box((0.36, 0.07, 0.018), (0.0, y, -0.2), color=wood, material="wood"))
    return Furniture(tuple(parts), 0.46, 0.46, 0.9, (LocalSeat((0.0, seat_y, 0.11), 0.42),))


def stool(palette: Palette) -> Furniture:
    """A bar stool; too high to be a `Seat`."""
    height = 0.66
    top = [(0.0, -0.04), (0.16, -0.04), (0.175, -0.02), (0.17, 0.0), (0.0, 0.0)]
    parts = [
        lathe(top, color=palette.wood, material="wood", center=(0.0, height, 0.0), segments=24),
        lathe([(0.125, 0.0), (0.125, 0.016)], color=(0.4, 0.4, 0.4), center=(0.0, 0.22, 0.0)),
    ]
    for yaw in np.pi * np.array([0.25, 0.75, 1.25, 1.75]):
        leg = box((0.026, height - 0.03, 0.026), (0.0, (height - 0.03) / 2.0, 0.13),
                  color=palette.dark_wood, material="wood")  # fmt: skip
        parts.append(leg.moved(yaw=float(yaw)))
    return Furniture(tuple(parts), 0.36, 0.36, height)


def desk_chair(palette: Palette) -> Furniture:
    """A swivel chair on five castors."""
    dark, seat_y = np.array([0.27, 0.27, 0.28]), 0.47
    parts = [
        cushion((0.48, 0.09, 0.47), (0.0, seat_y - 0.05, 0.02), color=palette.sofa, radius=0.035,
                puff=0.01),
        cushion((0.44, 0.5, 0.07), (0.0, seat_y + 0.36, -0.22), color=palette.sofa, radius=0.03,
                puff=0.02, axis=2).tilted(-0.1, pivot=(0.0, seat_y, -0.22)),
        box((0.06, 0.32, 0.025), (0.0, seat_y + 0.08, -0.25), color=dark),
        lathe([(0.03, 0.07), (0.03, 0.38)], color=dark, segments=14),
    ]  # fmt: skip
    for spoke in range(5):
        yaw = 2.0 * np.pi * spoke / 5.0
        bar = box((0.04, 0.03, 0.26), (0.0, 0.075, 0.14), color=dark, radius=0.01)
        castor = lathe(_ball(0.03), color=dark * 0.8, center=(0.0, 0.0, 0.26), segments=12,
                       smooth=True)  # fmt: skip
        parts += [bar.moved(yaw=yaw), castor.moved(yaw=yaw)]
    return Furniture(tuple(parts), 0.6, 0.6, 1.08, (LocalSeat((0.0, seat_y, 0.13), 0.44),))


def _ball(radius: float) -> list[tuple[float, float]]:
    angle = np.linspace(-np.pi / 2.0, np.pi / 2.0, 7)
    return [(radius * float(np.cos(a)), radius + radius * float(np.sin(a))) for a in angle]


def bed(palette: Palette, *, width: float) -> Furniture:
    """A made bed, its headboard at the back: mattress, duvet, pillows and a throw."""
    length, wood = 2.08, palette.wood
    white = np.array([0.93, 0.92, 0.9])
    parts = [
        box((width + 0.08, 0.2, length - 0.06), (0.0, 0.2, 0.0), color=wood, material="wood",
            radius=0.01),
        box((width + 0.12, 1.0, 0.06), (0.0, 0.5, -length / 2.0 + 0.03), color=wood,
            material="wood", radius=0.012),
        cushion((width, 0.2, 2.0), (0.0, 0.4, 0.01), color=white, radius=0.05, puff=0.0),
        cushion((width + 0.06, 0.13, 1.4), (0.0, 0.49, 0.31), color=palette.textile, radius=0.06,
                puff=0.03, cells=14),
        cushion((width + 0.08, 0.05, 0.55), (0.0, 0.555, 0.66), color=palette.accent,
                radius=0.02, puff=0.02, cells=12),
    ]  # fmt: skip
    legs = [(x, z) for x in (-width / 2.0, width / 2.0) for z in (-0.92, 0.92)]
    parts += [_leg(x, z, 0.12, palette, radius=0.03) for x, z in legs]
    for sign in (-1.0, 1.0):
        parts.append(_bed_pillow(sign * width / 4.0, white))
    return Furniture(tuple(parts), width + 0.12, length, 1.0)


def _bed_pillow(x: float, color: FloatArray) -> Part:
    pillow = cushion((0.62, 0.12, 0.4), (0.0, 0.0, 0.0), color=color, radius=0.05, puff=0.04)
    return pillow.tilted(-0.35).moved(x, 0.61, -0.76)
