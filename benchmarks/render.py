"""Frames per second of the `egl` renderer against pyrender, which gets the body anew each frame.

All draw the same clips and the same body mesh in one process, taking turns, so that a busy machine
slows all. pyrender is measured twice: as its documentation shows it (`Mesh.from_trimesh`, one
directional light, default flags), and as fast as it goes (flat shading, bare primitives).

The part `home` is a walk through a furnished home. habitat-sim's rates stand beside it as they were
measured once, on the same kind of machine; what it drew was not antialiased.

python -m benchmarks.render [--only render home] [--rounds N]
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from affectsim_data.avatars import Avatar
from affectsim_data.cameras import Camera, CameraTrajectory
from affectsim_data.poses import look_at
from affectsim_data.render import ClipSpec
from affectsim_data.render.framing import choose_mesh
from affectsim_data.render.rasterizer import EglRenderer
from affectsim_data.render.reference import PyrenderRenderer, import_pyrender, surface_primitive
from affectsim_data.scenes import Scene
from benchmarks.render_home import (
    HABITAT_FPS,
    beside,
    drawn_per_frame,
    furnished_home,
    home_walk,
)

_ROOT = Path(__file__).resolve().parents[1]
# The scenes and bodies made of code are those of the tests.
sys.path.insert(0, str(_ROOT / "tests"))

from render_scenes import (  # noqa: E402 - found by the line above
    capsule_avatar,
    furnished_room,
    moving_camera,
    standing_person,
    still_camera,
)

SIZES = ((224, 224), (640, 480))
SCENE_TRIANGLES = (15_000, 150_000)
NUM_FRAMES = 64
REFERENCE_FRAMES = 6
"""pyrender's time per frame does not depend on a clip's length; more would only take longer."""


HOME = 34
"""Place in `builders/homes-full.toml` of the home that is walked through: seven rooms."""

Draw = Callable[[ClipSpec], object]


def run(*, rounds: int = 8) -> list[dict[str, Any]]:
    """One row per scene, image size and camera; the best of `rounds` for every renderer."""
    fast, flat = EglRenderer(cache_bytes=2**29), PyrenderRenderer(exact=False)
    usual = UsualPyrender()
    draws: dict[str, Draw] = {"egl": fast.render, "usual": usual.render, "flat": flat.render}
    avatar, rows = _avatar(), []
    for num_triangles in SCENE_TRIANGLES:
        scene = furnished_room(num_triangles=num_triangles, rng=np.random.default_rng(0))
        for width, height in SIZES:
            camera = Camera(width, height, float(np.deg2rad(60.0)))
            for motion, path in (("still", still_camera), ("moving", moving_camera)):
                long, eight, short = (
                    _clip(scene, avatar, camera, path, n) for n in (NUM_FRAMES, 8, REFERENCE_FRAMES)
                )
                row = {
                    "camera": motion,
                    "image": f"{width}x{height}",
                    "scene_triangles": scene.num_triangles,
                    "body_triangles": len(choose_mesh(long.people[0], long).faces),
                }
                rows.append({**row, **_compare(draws, long, eight, short, rounds)})
    flat.close()
    fast.close()
    usual.close()
    return rows


def run_home(*, rounds: int = 8) -> list[dict[str, Any]]:
    """One row per image size of a camera that walks through a furnished home past one body."""
    fast, flat, usual = (
        EglRenderer(cache_bytes=2**29),
        PyrenderRenderer(exact=False),
        UsualPyrender(),
    )
    draws: dict[str, Draw] = {"egl": fast.render, "usual": usual.render, "flat": flat.render}
    avatar, scene, rows = _avatar(), furnished_home(HOME), []
    walk = home_walk(scene, num_frames=NUM_FRAMES).T_world_camera
    x, z = beside(scene, walk[:, :3, 3])

    def path(*, num_frames: int) -> CameraTrajectory:
        return CameraTrajectory(walk[np.linspace(0, NUM_FRAMES - 1, num_frames).astype(int)])

    for width, height in SIZES:
        camera = Camera(width, height, float(np.deg2rad(60.0)))
        long, eight, short = (
            _clip(scene, avatar, camera, path, n, at=(x, z))
            for n in (NUM_FRAMES, 8, REFERENCE_FRAMES)
        )
        image = f"{width}x{height}"
        rates = _compare(draws, long, eight, short, rounds)
        row = {"home": scene.scene_id, "rooms": len(scene.rooms), "image": image}
        habitat = HABITAT_FPS[image]
        against = {"habitat_fps": habitat, "ratio_to_habitat": rates["egl_fps"] / habitat}
        rows.append({**row, **drawn_per_frame(long), **rates, **against})
    flat.close()
    fast.close()
    usual.close()
    return rows


def _compare(
    draws: dict[str, Draw], long: ClipSpec, eight: ClipSpec, short: ClipSpec, rounds: int
) -> dict[str, Any]:
    work = {
        "egl": (draws["egl"], long),
        "egl_8": (draws["egl"], eight),
        "usual": (draws["usual"], short),
        "flat": (draws["flat"], short),
    }
    times = dict.fromkeys(work, np.inf)
    # The first round uploads.
    for turn in range(rounds + 1):
        for name, (draw, spec) in work.items():
            seconds = _seconds(draw, spec) / len(spec.trajectory)
            times[name] = min(times[name], seconds) if turn else np.inf
    return {
        "egl_fps": 1.0 / times["egl"],
        "egl_8_frame_clip_fps": 1.0 / times["egl_8"],
        "pyrender_fps": 1.0 / times["usual"],
        "pyrender_flat_fps": 1.0 / times["flat"],
        "ratio": times["usual"] / times["egl"],
        "ratio_to_flat": times["flat"] / times["egl"],
    }


class UsualPyrender:
    """pyrender as its documentation has it, the body taken out and put back for every frame."""

    def __init__(self) -> None:
        self._pyrender = import_pyrender()
        self._offscreen: Any = None
        self._scene: tuple[Scene, Any] | None = None

    def render(self, spec: ClipSpec) -> list[Any]:
        """Colour and depth of every frame."""
        pyrender, camera = self._pyrender, spec.camera
        if self._offscreen is None:
            self._offscreen = pyrender.OffscreenRenderer(camera.width, camera.height)
        offscreen = self._offscreen
        offscreen.viewport_width, offscreen.viewport_height = camera.width, camera.height
        scene = self._static_scene(spec.scene)
        aspect = camera.width / camera.height
        eye = scene.add(pyrender.PerspectiveCamera(yfov=camera.vfov, aspectRatio=aspect))
        scene.main_camera_node = eye
        person, images = spec.people[0], []
        mesh = choose_mesh(person, spec)
        for frame, T_world_camera in enumerate(spec.trajectory.T_world_camera):
            scene.set_pose(eye, T_world_camera)
            body = trimesh.Trimesh(
                mesh.skin(person.joint_matrices[frame]),
                mesh.faces,
                vertex_colors=mesh.colors,
                process=False,
            )
            node = scene.add(pyrender.Mesh.from_trimesh(body))
            images.append(offscreen.render(scene))
            scene.remove_node(node)
        scene.remove_node(eye)
        return images

    def close(self) -> None:
        """Frees the device; last of all, for pyrender takes the display down with it."""
        self._offscreen, self._scene = None, None

    def _static_scene(self, source: Scene) -> Any:
        pyrender = self._pyrender
        if self._scene is None or self._scene[0] is not source:
            scene = pyrender.Scene(ambient_light=[0.4, 0.4, 0.4])
            for surface in source.surfaces:
                scene.add(pyrender.Mesh([surface_primitive(pyrender, surface)]))
            light = pyrender.DirectionalLight(intensity=3.0)
            scene.add(light, pose=look_at((1.0, 3.0, 2.0), (0.0, 0.0, 0.0)))
            self._scene = (source, scene)
        return self._scene[1]


def _clip(
    scene: Scene,
    avatar: Avatar,
    camera: Camera,
    path: Callable[..., CameraTrajectory],
    num_frames: int,
    *,
    at: tuple[float, float] = (0.0, 0.0),
) -> ClipSpec:
    person = standing_person(avatar, num_frames=num_frames, at=at)
    return ClipSpec(scene, (person,), camera, path(num_frames=num_frames))


def _seconds(draw: Draw, spec: ClipSpec) -> float:
    start = time.perf_counter()
    draw(spec)
    return time.perf_counter() - start


def _avatar() -> Avatar:
    """A baked body if there is one, else one of capsules with 20,000 triangles."""
    baked = sorted((_ROOT / "builders" / "avatars").glob("*.glb"))
    if baked:
        return Avatar.from_glb(baked[0].read_bytes(), name=baked[0].name)
    return capsule_avatar(rings=10, sides=26)


PARTS: dict[str, Callable[..., list[dict[str, Any]]]] = {"render": run, "home": run_home}
"""Tables that `benchmarks` writes, by name."""


def main() -> None:
    """Prints the rows as JSON, with what they were measured on."""
    from benchmarks.machine import describe_machine

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=8)
    parser.add_argument("--only", nargs="*", choices=PARTS, default=list(PARTS))
    options = parser.parse_args()
    rows = {part: PARTS[part](rounds=options.rounds) for part in options.only}
    print(json.dumps({"machine": describe_machine(), **rows}, indent=2))


if __name__ == "__main__":
    main()
