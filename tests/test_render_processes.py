"""Contexts: opening, closing, caching, threads, forks, and sharing a process with pyrender."""

from __future__ import annotations

import dataclasses
import gc
import subprocess
import sys
import threading

import numpy as np
import pytest
from render_scenes import capsule_avatar, clip, one_room, standing_person, still_camera

from affectsim_data.cameras import CameraTrajectory
from affectsim_data.errors import RendererUnavailableError
from affectsim_data.render import ClipSpec, open_renderer, process_renderer
from affectsim_data.render.device import describe_device, draw_triangle
from affectsim_data.render.rasterizer import EglRenderer

AVATAR = capsule_avatar(rings=4, sides=8)


def small_clip(scene_id: str = "room") -> ClipSpec:
    person = standing_person(AVATAR, num_frames=2)
    return clip(one_room(scene_id), still_camera(num_frames=2), person)


def in_a_process(program: str, *, timeout_s: float = 60.0) -> str:
    """What a Python process prints; a hang or a crash fails the test."""
    done = subprocess.run(
        [sys.executable, "-c", "from test_render_processes import *\n" + program],
        capture_output=True,
        text=True,
        timeout=timeout_s,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_importing_opens_nothing_and_loads_no_opengl() -> None:
    program = (
        "import sys, affectsim_data.render as r\n"
        "r.process_renderer('egl')\n"
        "print(sorted({m.split('.')[0] for m in sys.modules} & "
        "{'moderngl', 'glcontext', 'pyrender', 'OpenGL', 'torch'}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.strip() == "[]"


def test_the_process_renderer_is_one() -> None:
    assert process_renderer("egl") is process_renderer("egl")


@pytest.mark.egl
def test_a_closed_renderer_says_so_and_closing_twice_is_fine() -> None:
    renderer = open_renderer()
    renderer.render(small_clip())
    renderer.close()
    renderer.close()
    with pytest.raises(RuntimeError, match="closed; open a new one with open_renderer"):
        renderer.render(small_clip())


@pytest.mark.egl
def test_uploads_are_bounded_and_go_with_their_scenes() -> None:
    renderer = EglRenderer(cache_bytes=2**29)
    first = small_clip("first")
    renderer.render(first)
    one_scene = renderer.cached_bytes
    renderer.close()

    bounded = EglRenderer(cache_bytes=2 * one_scene)
    kept = [small_clip(f"scene-{index}") for index in range(6)]
    for spec in kept:
        bounded.render(spec)
        assert bounded.cached_bytes <= 2.2 * one_scene
    bounded.close()

    unbounded = EglRenderer(cache_bytes=2**29)
    for spec in kept:
        unbounded.render(spec)
    # Six scenes, one body.
    assert unbounded.cached_bytes > 3 * one_scene
    del spec
    kept.clear()
    gc.collect()
    unbounded.render(first)
    assert unbounded.cached_bytes <= 1.1 * one_scene
    unbounded.close()


@pytest.mark.egl
def test_backgrounds_are_kept_up_to_a_bound_and_change_no_pixel() -> None:
    spec = small_clip()
    pose = spec.trajectory.T_world_camera[0]
    views = []
    for step in range(6):
        moved = pose.copy()
        moved[0, 3] += 0.01 * step
        trajectory = CameraTrajectory.still(moved, num_frames=len(spec.trajectory))
        views.append(dataclasses.replace(spec, trajectory=trajectory))
    roomy = EglRenderer(cache_bytes=2**29)
    first = [roomy.render(view).rgb for view in views]
    one = roomy.background_bytes / len(views)
    assert one > 0
    again = [roomy.render(view).rgb for view in views]
    assert roomy.background_bytes == one * len(views)
    roomy.close()

    tight = EglRenderer(cache_bytes=2**29, max_background_bytes=int(2.5 * one))
    bounded = []
    for view in [*views, *reversed(views)]:
        bounded.append(tight.render(view).rgb)
        assert tight.background_bytes <= 2.5 * one
    tight.close()
    for pixels in (again, bounded[:6], bounded[:5:-1]):
        assert all(np.array_equal(a, b) for a, b in zip(first, pixels, strict=True))
    assert not np.array_equal(first[0], first[-1])


@pytest.mark.egl
def test_another_thread_is_refused() -> None:
    renderer = open_renderer()
    renderer.render(small_clip())
    errors: list[str] = []

    def draw() -> None:
        try:
            renderer.render(small_clip())
        except RuntimeError as error:
            errors.append(str(error))

    thread = threading.Thread(target=draw)
    thread.start()
    thread.join(timeout=60)
    assert len(errors) == 1
    assert "only on the thread that opened it" in errors[0]
    renderer.close()


@pytest.mark.egl
def test_both_renderers_share_a_process_and_survive_a_terminated_display() -> None:
    egl, reference = open_renderer("egl"), open_renderer("pyrender")
    spec = small_clip()
    expected = egl.render(spec).rgb
    reference.render(spec)
    np.testing.assert_array_equal(egl.render(spec).rgb, expected)
    reference.close()
    np.testing.assert_array_equal(egl.render(spec).rgb, expected)
    lasting = open_renderer("pyrender")
    drawn = lasting.render(spec).rgb
    # As pyrender's own `delete` does.
    from affectsim_data.render import egl as library

    context = egl._device.egl  # type: ignore[attr-defined]
    library._egl().eglMakeCurrent(context._display, None, None, None)
    library.terminate_displays()
    np.testing.assert_array_equal(egl.render(spec).rgb, expected)
    np.testing.assert_array_equal(lasting.render(spec).rgb, drawn)
    lasting.close()
    egl.close()


@pytest.mark.egl
def test_parent_and_children_draw_on_after_forks() -> None:
    if not describe_device().software:
        pytest.skip("drivers of GPUs do not survive a fork")
    printed = in_a_process(
        "import os\n"
        "renderer, spec = open_renderer(), small_clip()\n"
        "expected = renderer.render(spec).rgb.tobytes()\n"
        "for turn in range(20):\n"
        "    child = os.fork()\n"
        "    if child == 0:\n"
        "        same = renderer.render(spec).rgb.tobytes() == expected\n"
        "        os._exit(0 if same else 3) if turn % 2 else sys.exit(0 if same else 3)\n"
        "    assert renderer.render(spec).rgb.tobytes() == expected\n"
        "    assert os.waitpid(child, 0)[1] == 0, turn\n"
        "print('done')\n"
    )
    assert printed.strip() == "done"


@pytest.mark.egl
def test_a_child_draws_after_the_parent_has_closed_or_only_looked() -> None:
    if not describe_device().software:
        pytest.skip("drivers of GPUs do not survive a fork")
    printed = in_a_process(
        "import os\n"
        "def child_draws():\n"
        "    child = os.fork()\n"
        "    if child == 0:\n"
        "        open_renderer().render(small_clip())\n"
        "        sys.exit(0)\n"
        "    assert os.waitpid(child, 0)[1] == 0\n"
        "describe_device()\n"
        "child_draws()\n"
        "renderer = open_renderer()\n"
        "renderer.render(small_clip())\n"
        "renderer.close()\n"
        "child_draws()\n"
        "print('done')\n"
    )
    assert printed.strip() == "done"


@pytest.mark.egl
def test_a_stock_data_loader_works_after_the_parent_has_drawn() -> None:
    if not describe_device().software:
        pytest.skip("drivers of GPUs do not survive a fork")
    printed = in_a_process(
        "import torch\n"
        "class Clips(torch.utils.data.Dataset):\n"
        "    def __len__(self): return 6\n"
        "    def __getitem__(self, i):\n"
        "        return torch.from_numpy(process_renderer().render(small_clip()).rgb)\n"
        "expected = Clips()[0]\n"
        "loader = torch.utils.data.DataLoader(\n"
        "    Clips(), batch_size=2, num_workers=2, multiprocessing_context='fork'\n"
        ")\n"
        "for epoch in range(2):\n"
        "    assert all((clip == expected).all() for batch in loader for clip in batch)\n"
        "    assert (Clips()[0] == expected).all()\n"
        "print('done')\n",
        timeout_s=120.0,
    )
    assert printed.strip() == "done"


@pytest.mark.egl
def test_a_context_that_cannot_survive_a_fork_is_an_error_in_the_child_not_a_hang() -> None:
    # Forked from another thread than the one that draws: it is left alone.
    printed = in_a_process(
        "import os\n"
        "renderer, spec = open_renderer(), small_clip()\n"
        "renderer.render(spec)\n"
        "def fork():\n"
        "    child = os.fork()\n"
        "    if child == 0:\n"
        "        try:\n"
        "            renderer.render(spec)\n"
        "        except Exception as error:\n"
        "            print(type(error).__name__, error, flush=True)\n"
        "        renderer.close()\n"
        "        try:\n"
        "            open_renderer().render(spec)\n"
        "        except Exception as error:\n"
        "            print(type(error).__name__, error, flush=True)\n"
        "        sys.exit(0)\n"
        "    os.waitpid(child, 0)\n"
        "thread = threading.Thread(target=fork)\n"
        "thread.start()\n"
        "thread.join()\n"
        "renderer.render(spec)\n"
        "print('parent draws on')\n"
    )
    assert printed.startswith("ForkedContextError this renderer was opened in process")
    assert "ForkedContextError EGL device 0 was opened in process" in printed
    assert "multiprocessing_context='forkserver'" in printed
    assert "affectsim_data.loaders.data_loader" in printed
    assert printed.strip().endswith("parent draws on")


@pytest.mark.egl
def test_a_device_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(RendererUnavailableError, match="EGL device 99 does not exist"):
        open_renderer(device=99).render(small_clip())
    monkeypatch.setenv("AFFECTSIM_EGL_DEVICE", "first")
    with pytest.raises(ValueError, match="AFFECTSIM_EGL_DEVICE must be a device index"):
        open_renderer().render(small_clip())


def test_without_egl_the_error_says_what_to_install() -> None:
    printed = in_a_process(
        "import ctypes\n"
        "def missing(name, *rest, **more): raise OSError(f'{name}: cannot open shared object')\n"
        "ctypes.CDLL = missing\n"
        "try:\n"
        "    open_renderer().render(small_clip())\n"
        "except RendererUnavailableError as error:\n"
        "    print(error)\n"
    )
    assert "libEGL.so.1" in printed
    assert "apt-get install -y libegl1 libgl1-mesa-dri libgles2" in printed
    assert "affectsim doctor" in printed


@pytest.mark.egl
def test_the_device_describes_itself_and_draws() -> None:
    info = describe_device()
    assert info.renderer
    assert info.version
    assert 0 <= info.device < info.num_devices
    assert info.max_texture_size >= 4096
    image = draw_triangle()
    assert image.shape == (64, 64, 3)
    # Point up: the row above the middle is narrower than the row below it.
    orange = image[..., 0] > 128
    assert 0 < orange[20].sum() < orange[50].sum()
