"""Parts of a home to surfaces: merged per material, with their light baked in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from affectsim_data.builders.homes.parts import Part, merged
from affectsim_data.builders.homes.textures import MATERIALS, material_texture
from affectsim_data.builders.lighting import (
    Lamp,
    LightMesh,
    WindowLight,
    bake_light,
    exposed,
    relit,
)
from affectsim_data.scenes import Surface

__all__ = ["lit_surfaces", "unlit_surfaces"]

_GLOWING = frozenset(name for name, material in MATERIALS.items() if material.glows)


def unlit_surfaces(parts: Sequence[Part], *, rng: np.random.Generator) -> tuple[Surface, ...]:
    """One surface per material, in the order of `MATERIALS`; colours are albedo.

    Raises:
        KeyError: A part has a material that is not in `MATERIALS`.
    """
    groups: dict[str, list[Part]] = {name: [] for name in MATERIALS}
    for part in parts:
        groups[part.material].append(part)
    return tuple(_surface(merged(group), rng=rng) for group in groups.values() if group)


def _surface(part: Part, *, rng: np.random.Generator) -> Surface:
    colors = np.full((len(part.positions), 4), 255, np.uint8)
    colors[:, :3] = np.round(np.clip(part.colors, 0.0, 1.0) * 255.0)
    return Surface(
        name=part.material,
        positions=part.positions.astype(np.float32),
        normals=part.normals.astype(np.float32),
        colors=colors,
        faces=part.faces.astype(np.uint32),
        uvs=(part.uvs / MATERIALS[part.material].tile_m).astype(np.float32),
        texture=material_texture(part.material, rng=rng),
    )


def lit_surfaces(
    parts: Sequence[Part],
    windows: Sequence[WindowLight],
    lamps: Sequence[Lamp],
    *,
    rng: np.random.Generator,
) -> tuple[Surface, ...]:
    """`unlit_surfaces` with the light of windows and lamps multiplied into their colours.

    Quads may be cut along their other diagonal, where light then interpolates better.
    """
    surfaces = unlit_surfaces(parts, rng=rng)
    dull = [surface for surface in surfaces if MATERIALS[surface.name].shadows]
    if not dull:
        return surfaces
    # Panes throw nothing back: they are windows, which are sources.
    mesh = LightMesh.of(dull, dark=_GLOWING)
    light, area = bake_light(mesh, windows=windows, lamps=lamps)
    lit = {surface.name: surface for surface in relit(dull, mesh, exposed(light, area))}
    return tuple(surface if surface.name in _GLOWING else lit[surface.name] for surface in surfaces)
