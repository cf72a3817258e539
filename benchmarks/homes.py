"""What a furnished home costs: plan, shell, furniture, textures and light, on one core.

Seconds of the core's time per stage; the light is given per 100,000 triangles too.

python -m benchmarks.homes
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from benchmarks.parts import Rows, run_part, serve_part

_HOMES = 6
"""Of the full set, evenly spread by size of recipe."""

_Out = TypeVar("_Out")


def homes() -> Rows:
    """Seconds per stage of homes of the full set."""
    from affectsim_data.builders.homes import home_recipes
    from affectsim_data.content import content_path

    recipes = home_recipes(content_path("builders", "homes-full.toml"))
    step = max(len(recipes) // _HOMES, 1)
    return [_stages(recipe) for recipe in recipes[::step][:_HOMES]]


def _stages(recipe: object) -> dict[str, str | int | float]:
    """One row: stages of a home are told apart by building it with and without light."""
    from affectsim_data.builders.homes import HomeRecipe, build_home

    assert isinstance(recipe, HomeRecipe)
    build_home(recipe, rng=np.random.default_rng(recipe.seed), lit=False)
    unlit_s, scene = _timed(
        lambda: build_home(recipe, rng=np.random.default_rng(recipe.seed), lit=False)
    )
    whole_s, _ = _timed(lambda: build_home(recipe, rng=np.random.default_rng(recipe.seed)))
    textures_s = _textures_s([surface.name for surface in scene.surfaces])
    light_s = whole_s - unlit_s
    return {
        "home": recipe.scene_id,
        "rooms": len(scene.rooms),
        "triangles": scene.num_triangles,
        "geometry_s": unlit_s - textures_s,
        "textures_s": textures_s,
        "light_s": light_s,
        "light_s_per_100k": 1e5 * light_s / scene.num_triangles,
        "whole_s": whole_s,
    }


def _textures_s(names: list[str]) -> float:
    from affectsim_data.builders.homes.textures import material_texture

    rng = np.random.default_rng(0)
    seconds, _ = _timed(lambda: [material_texture(name, rng=rng) for name in names])
    return seconds


def _timed(work: Callable[[], _Out]) -> tuple[float, _Out]:
    """Seconds of this process's time on the core, and the result."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


PARTS = {"homes": homes}

if __name__ == "__main__":
    if len(sys.argv) > 1:
        serve_part(PARTS)
    else:
        print(json.dumps(run_part("benchmarks.homes", "homes", cores=1), indent=2))
