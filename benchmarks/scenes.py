"""What a scene costs from its shard to the device, and what baking makes of it.

The same scene as it was built and baked, on one core: parsing its GLB, its textures, the upload
with mipmaps, and both together, beside trimesh, which reads the same GLB and uploads nothing.

python -m benchmarks.scenes
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from affectsim_data.scenes import Scene
from benchmarks.parts import Rows, run_part, serve_part

_ROOT = Path(__file__).resolve().parents[1]
_TRIANGLES = 200_000
_ROUNDS = 7


def scenes() -> Rows:
    """Sizes, and milliseconds of this process's time, least of some rounds."""
    from affectsim_data.scenes.baking import bake_scene

    rows = []
    for scene in (_furnished_room(), _home()):
        start = time.process_time()
        baked, _ = bake_scene(scene)
        seconds = time.process_time() - start
        rows.append(_row(scene, "as built", 0.0))
        rows.append(_row(baked, "baked", seconds))
    return rows


def _furnished_room() -> Scene:
    """A room of about as many triangles as a large home has."""
    # The scenes made of code are those of the tests.
    sys.path.insert(0, str(_ROOT / "tests"))
    from render_scenes import furnished_room

    return furnished_room(num_triangles=_TRIANGLES, rng=np.random.default_rng(0))


def _home() -> Scene:
    """The first home of the built-in release."""
    from affectsim_data.builders.homes import build_home, home_recipes
    from affectsim_data.content import content_path

    recipe = home_recipes(content_path("builders", "homes-mini.toml"))[0]
    return build_home(recipe, rng=np.random.default_rng(recipe.seed))


def _row(scene: Scene, form: str, bake_s: float) -> dict[str, Any]:
    import pyarrow as pa
    import trimesh

    payload = scene.to_glb()
    packed = pa.compress(payload, codec="zstd", asbytes=True)
    read = _least(lambda: Scene.from_glb(payload, name="scene"))
    upload = _least(_uploading(Scene.from_glb(payload, name="scene")))
    peer = _least(
        lambda: trimesh.load_scene(trimesh.util.wrap_as_stream(payload), file_type="glb"), rounds=2
    )
    return {
        "scene": scene.scene_id,
        "form": form,
        "triangles": scene.num_triangles,
        "draw_calls": len(scene.surfaces),
        "glb_kb": len(payload) // 1000,
        "zstd_kb": len(packed) // 1000,
        "bake_s": bake_s,
        "read_ms": 1e3 * read,
        "upload_ms": 1e3 * upload,
        "read_and_upload_ms": 1e3 * (read + upload),
        "trimesh_read_ms": 1e3 * peer,
    }


def _uploading(scene: Scene) -> Callable[[], None]:
    """Uploads the scene to a device of its own and waits for it."""
    from affectsim_data.render.buffers import SceneBuffers
    from affectsim_data.render.drawing import open_device

    device = open_device(None, 2**30, 2**20)

    def upload() -> None:
        programs = device.programs
        SceneBuffers(device.context, scene, programs["scene"], programs["textured"]).release()
        device.context.finish()

    return upload


def _least(work: Callable[[], object], *, rounds: int = _ROUNDS) -> float:
    """Least seconds of this process's time, threads of the driver included."""
    seconds = []
    for _ in range(rounds):
        start = time.process_time()
        work()
        seconds.append(time.process_time() - start)
    return min(seconds)


PARTS = {"scenes": scenes}

if __name__ == "__main__":
    if len(sys.argv) > 1:
        serve_part(PARTS)
    else:
        print(json.dumps(run_part("benchmarks.scenes", "scenes", cores=1), indent=2))
