"""Rugs, plants, lamps, curtains and pictures."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box, grid_faces, lathe, sheet, smooth_normals
from affectsim_data.builders.homes.pieces import Furniture
from affectsim_data.builders.homes.plans import Opening, Wall
from affectsim_data.builders.homes.shell import on_wall
from affectsim_data.poses import FloatArray

__all__ = ["CURTAIN_WIDTH", "curtains", "floor_lamp", "picture", "plant", "rug"]

CURTAIN_WIDTH = 0.36
"""Of a drawn-back curtain, metres."""
_METAL = np.array([0.33, 0.32, 0.31])


def rug(width: float, depth: float, *, color: FloatArray, border: FloatArray) -> Furniture:
    """A flat rug with a border stripe, 8 mm thick."""
    stripe = 0.09
    parts = [
        box((width, 0.006, depth), (0.0, 0.003, 0.0), color=border, material="carpet",
            radius=0.002, step=0.25),
        box((width - 2.0 * stripe, 0.0035, depth - 2.0 * stripe), (0.0, 0.00625, 0.0), color=color,
            material="carpet", radius=0.001, step=0.25),
    ]  # fmt: skip
    return Furniture(tuple(parts), width, depth, 0.008)


def floor_lamp() -> Furniture:
    """A standing lamp with a fabric shade."""
    shade = (1.0, 0.95, 0.84)
    parts = [
        lathe([(0.15, 0.0), (0.15, 0.02), (0.014, 0.03), (0.012, 1.38)], color=_METAL),
        lathe([(0.2, 1.3), (0.15, 1.6)], color=shade, material="lamp", segments=28),
        lathe([(0.15, 1.6), (0.0, 1.6)], color=shade, material="lamp", segments=28),
        lathe([(0.0, 1.3), (0.2, 1.3)], color=shade, material="lamp", segments=28),
    ]
    return Furniture(tuple(parts), 0.42, 0.42, 1.6, lamp_y=1.45)


def plant(*, tall: float, rng: np.random.Generator) -> Furniture:
    """A pot plant of arching leaves, `tall` metres high."""
    pot_height = 0.32
    pot = [(0.0, 0.0), (0.12, 0.0), (0.165, pot_height), (0.15, pot_height),
           (0.145, pot_height - 0.03), (0.0, pot_height - 0.03)]  # fmt: skip
    parts = [lathe(pot, color=(0.86, 0.82, 0.76), segments=26)]
    green = np.array([0.36, 0.52, 0.30])
    for index in range(30):
        yaw = 2.4 * index + float(rng.uniform(-0.3, 0.3))
        share = (index + 1) / 30.0
        rise = (tall - pot_height) * (0.45 + 0.5 * share)
        reach = 0.26 * (1.1 - 0.75 * share) + 0.05
        leaf = _leaf(rise=rise, reach=reach, color=green * float(rng.uniform(0.85, 1.2)))
        parts.append(leaf.moved(0.0, pot_height - 0.04, 0.0, yaw=yaw))
    return Furniture(tuple(parts), 0.66, 0.66, tall)


def _leaf(*, rise: float, reach: float, color: FloatArray) -> Part:
    """A bent blade from the origin up and out along +Z, with a front and a back."""
    rows = 9
    t = np.linspace(0.0, 1.0, rows)
    spine = np.stack([np.zeros(rows), rise * np.sin(1.75 * t) / np.sin(1.57), reach * t**1.6], 1)
    half = 0.052 * np.sin(np.pi * np.clip(t, 0.0, 1.0) ** 0.8) + 0.004
    across = np.array([-1.0, 0.0, 1.0])
    points = np.repeat(spine[:, None, :], 3, axis=1)
    points[..., 0] += half[:, None] * across
    points[..., 1] += 0.25 * half[:, None] * np.abs(across)
    return _two_sided(points, color=color, material="plain", thickness=0.003)


def _two_sided(
    points: FloatArray, *, color: ArrayLike, material: str, thickness: float
) -> Part:  # fmt: skip
    """A thin bent sheet, `(rows, columns, 3)`, as two skins so that both sides are drawn."""
    rows, columns = points.shape[:2]
    flat, faces = points.reshape(-1, 3), grid_faces(rows, columns)
    normals = smooth_normals(flat, faces)
    along = np.cumsum(np.linalg.norm(np.diff(points, axis=1, prepend=points[:, :1]), axis=2), 1)
    up = np.cumsum(np.linalg.norm(np.diff(points, axis=0, prepend=points[:1]), axis=2), axis=0)
    uvs = np.stack([along, -up], axis=-1).reshape(-1, 2)
    shift = normals * (thickness / 2.0)
    positions = np.concatenate([flat + shift, flat - shift])
    return Part(
        material=material,
        positions=positions,
        normals=np.concatenate([normals, -normals]),
        uvs=np.concatenate([uvs, uvs]),
        colors=np.broadcast_to(np.clip(color, 0.0, 1.0), positions.shape).copy(),
        faces=np.concatenate([faces, faces[:, ::-1] + len(flat)]),
    )


def curtains(wall: Wall, opening: Opening, palette: Palette) -> list[Part]:
    """Two drawn-back curtains on a rod."""
    u, rod_y, out = wall.u_of(opening.middle), 2.36, 0.09
    reach = opening.width / 2.0 + 0.62 * CURTAIN_WIDTH
    rod = on_wall(wall, u, rod_y + 0.02, (2.0 * reach + 0.24, 0.022, 0.022), color=_METAL,
                  out=out - 0.011, radius=0.009)  # fmt: skip
    parts = [rod]
    for sign in (-1.0, 1.0):
        across = np.linspace(-CURTAIN_WIDTH / 2.0, CURTAIN_WIDTH / 2.0, 41)
        heights = np.array([0.03, 0.4, 0.9, 1.4, 1.9, rod_y])
        spread = 1.0 - 0.12 * np.sin(np.pi * heights / rod_y)[:, None]
        fold = 0.032 * np.sin(across * (2.0 * np.pi * 5.0 / CURTAIN_WIDTH))
        points = np.stack(
            np.broadcast_arrays(across * spread, heights[:, None], fold * np.ones((6, 1))), axis=-1
        )
        cloth = _two_sided(points, color=palette.textile, material="fabric", thickness=0.006)
        x, _, z = wall.point(u + sign * reach, 0.0, out)
        parts.append(cloth.moved(float(x), 0.0, float(z), yaw=wall.yaw))
    return parts


def picture(
    wall: Wall, u: float, y: float, size: tuple[float, float], *, painting: int
) -> list[Part]:
    """A framed picture with its middle at `(u, y)`; `painting` is one of the four of the atlas."""
    width, height = size
    frame = on_wall(wall, u, y, (width, height, 0.025), color=np.array([0.36, 0.29, 0.22]))
    canvas = sheet(
        wall.point(u - width / 2.0 + 0.02, y - height / 2.0 + 0.02, 0.027), wall.along,
        (0.0, 1.0, 0.0), np.linspace(0.0, width - 0.04, 3), np.linspace(0.0, height - 0.04, 3),
        color=(1.0, 1.0, 1.0), material="art",
    )  # fmt: skip
    # A little inside its quarter of the atlas, so that filtering does not reach the next painting.
    share = 0.02 + 0.96 * (canvas.uvs / (width - 0.04, height - 0.04) + (0.0, 1.0))
    corner = np.array([painting % 2, painting // 2])
    return [frame, dataclasses.replace(canvas, uvs=0.5 * (share + corner))]
