"""Parts of a home to surfaces: merged per material, with their light baked in."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.homes.lighting import Lamp, WindowLight, bake_light, lit_colors
from affectsim_data.builders.homes.parts import Part, merged
from affectsim_data.builders.homes.textures import MATERIALS, material_texture
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Surface
from affectsim_data.visibility import RayCaster

__all__ = ["lit_surfaces"]

_FINE_RAYS, _RAYS = 64, 20
_FINE = ("paint", "planks", "tiles")
"""Materials of large faces, whose light must be smooth: they get `_FINE_RAYS` ambient rays."""
_INWARD = 0.25
"""How far the light of a vertex is taken towards the middle of its triangles: at the very edge of a
floor it would be that of the inside of the baseboard."""


def lit_surfaces(
    parts: list[Part],
    windows: list[WindowLight],
    lamps: list[Lamp],
    *,
    rng: np.random.Generator,
) -> tuple[Surface, ...]:
    """One lit surface per material, in the order of `MATERIALS`."""
    groups = [
        merged(part for part in parts if part.material == name)
        for name in MATERIALS
        if any(part.material == name for part in parts)
    ]
    # Lamps shine through their own shades.
    whole = merged(group for group in groups if group.material != "lamp")
    caster = RayCaster(whole.positions, whole.faces)
    surfaces = []
    for group in groups:
        material = MATERIALS[group.material]
        if material.glows:
            light = np.full_like(group.positions, np.inf)
        else:
            light = _light(group, windows, lamps, caster)
        surfaces.append(
            Surface(
                name=group.material,
                positions=group.positions.astype(np.float32),
                normals=group.normals.astype(np.float32),
                colors=lit_colors(group.colors, light),
                faces=group.faces.astype(np.uint32),
                uvs=(group.uvs / material.tile_m).astype(np.float32),
                texture=material_texture(group.material, rng=rng),
            )
        )
    return tuple(surfaces)


def _light(
    group: Part, windows: list[WindowLight], lamps: list[Lamp], caster: RayCaster
) -> FloatArray:
    """Baked light of a material's vertices, computed once per place and direction, `(n, 3)`."""
    points = group.positions + _INWARD * (_triangle_middles(group) - group.positions)
    keys = np.round(np.concatenate([points * 1e3, group.normals * 20.0], axis=1))
    _, first, same = np.unique(
        keys.astype(np.int32), axis=0, return_index=True, return_inverse=True
    )
    light = bake_light(
        points[first], group.normals[first],
        rays=_FINE_RAYS if group.material in _FINE else _RAYS,
        windows=windows, lamps=lamps, caster=caster,
    )  # fmt: skip
    return light[same.reshape(-1)]


def _triangle_middles(group: Part) -> FloatArray:
    """Mean middle of the triangles around every vertex, `(num_vertices, 3)`."""
    middles = np.repeat(group.positions[group.faces].mean(axis=1), 3, axis=0)
    corners, count = group.faces.reshape(-1), len(group.positions)
    sums = [np.bincount(corners, middles[:, axis], minlength=count) for axis in range(3)]
    number = np.maximum(np.bincount(corners, minlength=count), 1)
    return np.stack(sums, axis=1) / number[:, None]
