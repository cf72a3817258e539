"""A scene of any number of surfaces and textures to one that is ready to draw."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence

from affectsim_data.scenes.baking.atlases import fit_textures
from affectsim_data.scenes.baking.decimation import decimate_surfaces
from affectsim_data.scenes.baking.losses import measure_loss
from affectsim_data.scenes.baking.merging import fold_flat_textures, merge_alike
from affectsim_data.scenes.baking.report import BakeCounts, BakeLoss, BakeReport
from affectsim_data.scenes.baking.welding import weld_surface
from affectsim_data.scenes.chunks import chunk_surfaces
from affectsim_data.scenes.scene import Scene
from affectsim_data.scenes.surfaces import Surface

__all__ = ["MAX_INPUT_TRIANGLES", "TEXTURE_BUDGET", "bake_scene"]

TEXTURE_BUDGET = 5 * 2**19
"""Texels of all textures of a scene: what decodes and uploads in 0.1 s on a slow core."""
MAX_INPUT_TRIANGLES = 8_000_000


def bake_scene(
    scene: Scene,
    *,
    max_draw_calls: int = 32,
    max_triangles: int | None = None,
    texture_budget: int = TEXTURE_BUDGET,
) -> tuple[Scene, BakeReport]:
    """The scene ready to draw, and what was done to it.

    Surfaces without a texture become one, as do those with equal textures; where they are still
    too many, textures share atlas pages. Vertices lie on a grid of 2^-13 m and are welded,
    triangles that draw nothing are left out, and chunks are cut and know their rooms. Without
    `max_triangles` the surface stays in place to 0.1 mm and no light is lost. Baking a baked scene
    again changes nothing, and equal scenes give equal bytes.

    Args:
        scene: From a builder or an importer, lit or not.
        max_draw_calls: Most surfaces of the result, at least 2.
        max_triangles: Most triangles of the result; `None` decimates nothing.
        texture_budget: Most texels of all its textures; those with most texels per metre are made
            smaller first.

    Raises:
        MissingExtraError: Decimation needs fast-simplification, of the extra `build`.
        ValueError: A limit is too small, or the scene too large; the message names the scene.
    """
    _check_limits(scene, max_draw_calls, max_triangles, texture_budget)
    before = BakeCounts.of(scene.surfaces)
    try:
        surfaces, notes = _gathered(scene.surfaces, max_draw_calls, texture_budget)
        surfaces, loss, dropped = _welded(surfaces, max_triangles)
    except ValueError as error:
        raise ValueError(f"scene {scene.scene_id!r}: {error}") from error
    if not surfaces:
        raise ValueError(f"scene {scene.scene_id!r}: no triangle has an area")
    notes += [f"{count:,} {what} left out" for what, count in sorted(dropped.items()) if count]
    ordered, chunks = chunk_surfaces(surfaces, scene.rooms)
    baked = dataclasses.replace(scene, surfaces=ordered, chunks=chunks)
    return baked, BakeReport(scene.scene_id, before, BakeCounts.of(ordered), loss, tuple(notes))


def _check_limits(
    scene: Scene, max_draw_calls: int, max_triangles: int | None, texture_budget: int
) -> None:
    limits = (
        ("max_draw_calls", max_draw_calls, 2),
        ("texture_budget", texture_budget, 1),
        ("max_triangles", max_triangles, max_draw_calls),
    )
    for name, value, least in limits:
        if value is not None and value < least:
            raise ValueError(
                f"scene {scene.scene_id!r}: {name} must be at least {least}, got {value}"
            )
    if scene.num_triangles > MAX_INPUT_TRIANGLES:
        raise ValueError(
            f"scene {scene.scene_id!r}: {scene.num_triangles:,} triangles are more than baking "
            f"takes, {MAX_INPUT_TRIANGLES:,}, whatever max_triangles says; decimate its meshes"
        )


def _gathered(
    surfaces: Sequence[Surface], max_draw_calls: int, texture_budget: int
) -> tuple[list[Surface], list[str]]:
    """Few surfaces with small enough textures, the one without first, and notes."""
    folded, num_flat = fold_flat_textures(surfaces)
    alike = merge_alike(folded)
    notes = [f"{num_flat} textures of one colour became vertex colours"] if num_flat else []
    plain = [one for one in alike if one.texture is None]
    textured, more = fit_textures(
        [one for one in alike if one.texture is not None],
        max_calls=max_draw_calls - len(plain),
        max_texels=texture_budget,
        taken={one.name for one in surfaces},
    )
    if more:
        # Small textures may be of one colour, or equal to each other, where large ones were not.
        alike = merge_alike(fold_flat_textures(plain + textured)[0])
    return sorted(alike, key=lambda one: one.texture is not None), notes + more


def _welded(
    surfaces: Sequence[Surface], max_triangles: int | None
) -> tuple[list[Surface], BakeLoss | None, Counter[str]]:
    """Welded surfaces within a number of triangles, the loss, and what was dropped."""
    dropped: Counter[str] = Counter()
    welded = []
    for surface in surfaces:
        one, less = weld_surface(surface)
        welded += [one] if len(one.faces) else []
        dropped += less
    if max_triangles is None or sum(len(one.faces) for one in welded) <= max_triangles:
        return welded, None, dropped
    small = [weld_surface(one)[0] for one in decimate_surfaces(welded, max_triangles)]
    return [one for one in small if len(one.faces)], measure_loss(welded, small), dropped
