"""The `egl` backend: moderngl on a headless EGL context."""

from __future__ import annotations

from typing import Any

import numpy as np

from affectsim_data.poses import invert_pose
from affectsim_data.render.backgrounds import MAX_BYTES
from affectsim_data.render.buffers import SceneBuffers
from affectsim_data.render.drawing import (
    Device,
    DrawnClip,
    as_rectangle,
    draw_background,
    draw_people,
    draw_scene,
    open_device,
    room_windows,
    union_rectangles,
    upload_person,
)
from affectsim_data.render.egl import default_device
from affectsim_data.render.framing import FAR_M, NEAR_M
from affectsim_data.render.processes import survive_forks
from affectsim_data.render.protocol import ClipSpec, RenderedClip, RendererName
from affectsim_data.render.targets import Targets, sample_scale

__all__ = ["EglRenderer"]


class EglRenderer:
    """Draws clips on a headless EGL device, a software one included; see `Renderer`.

    The context opens with the first clip. Uploaded scenes and bodies are kept, least recently used
    first out, up to `cache_bytes`. The background of a still camera is drawn once and kept a while;
    people are drawn over copies of it, and only around them pixels are resolved and read back.
    """

    name: RendererName = "egl"

    def __init__(
        self,
        device: int | None = None,
        *,
        cache_bytes: int,
        max_background_bytes: int = MAX_BYTES,
        reuse_background: bool = True,
    ) -> None:
        """Prepares a renderer without opening anything.

        Args:
            device: EGL device index; `None` for `AFFECTSIM_EGL_DEVICE`, else the first that opens.
            cache_bytes: Bound on uploaded scenes and bodies.
            max_background_bytes: Bound on backgrounds of still cameras.
            reuse_background: `False` draws still cameras as moving ones: the same pixels, slower.
        """
        self._device_index = device
        self._cache_bytes = cache_bytes
        self._max_background_bytes = max_background_bytes
        self._reuse_background = reuse_background
        self._device: Device | None = None
        self._closed = False
        survive_forks(self)

    def render(self, spec: ClipSpec, *, instances: bool = False) -> RenderedClip:
        """The images of `spec`.

        Raises:
            ForkedContextError: The context was opened before a fork it could not survive.
            RendererUnavailableError: No device opens.
            RuntimeError: Closed, or called on another thread than the first clip.
        """
        device = self._current_device()
        clip = self._prepare(device, spec, instances=instances)
        try:
            if self._reuse_background and spec.trajectory.is_still:
                self._render_still(device, clip)
            else:
                self._render_moving(device, clip)
        finally:
            for person in clip.people:
                person.release()
            device.scenes.trim()
            device.bodies.trim()
        return RenderedClip(clip.rgb, clip.depth, clip.instances)

    @property
    def info(self) -> dict[str, Any]:
        """What the driver says of itself: `GL_RENDERER`, `GL_VERSION`, ...; opens the context."""
        return dict(self._current_device().context.info)

    @property
    def cached_bytes(self) -> int:
        """Device memory of uploaded scenes and bodies."""
        if self._device is None:
            return 0
        return self._device.scenes.num_bytes + self._device.bodies.num_bytes

    @property
    def background_bytes(self) -> int:
        """Memory of backgrounds of still cameras, on the device and off it."""
        return 0 if self._device is None else self._device.backgrounds.num_bytes

    def close(self) -> None:
        """Frees the device; the renderer cannot be used again."""
        self._closed = True
        if self._device is not None and self._device.owner.is_here:
            self._release_device()
        self._device = None

    @property
    def is_open(self) -> bool:
        """Whether it holds a context."""
        return self._device is not None

    @property
    def can_suspend(self) -> bool:
        """Whether its driver can be shut down by the calling thread."""
        device = self._device
        return device is None or (device.owner.is_here and device.egl.device.software)

    def suspend(self) -> None:
        """Gives up the context, to be opened again by the next clip, in whichever process."""
        if self._device is not None:
            self._release_device()

    def _release_device(self) -> None:
        device, self._device = self._device, None
        assert device is not None
        if device.egl.make_current():
            device.scenes.clear()
            device.bodies.clear()
            device.backgrounds.clear()
            if device.targets is not None:
                device.targets.release()
            for program in device.programs.values():
                program.release()
        device.context.release()
        device.egl.release()

    def _current_device(self) -> Device:
        if self._closed:
            raise RuntimeError("this renderer was closed; open a new one with open_renderer()")
        if self._device is None:
            index = default_device() if self._device_index is None else self._device_index
            self._device = open_device(index, self._cache_bytes, self._max_background_bytes)
        self._device.owner.check()
        if not self._device.egl.make_current():
            # Another user of EGL, pyrender for one, shut the display down: start afresh.
            self._device = None
            return self._current_device()
        return self._device

    def _prepare(self, device: Device, spec: ClipSpec, *, instances: bool) -> DrawnClip:
        """Uploads what is new and allocates the result."""
        camera, programs = spec.camera, device.programs
        context, num_frames = device.context, len(spec.trajectory)
        if device.targets is None or device.targets.size != (camera.width, camera.height):
            if device.targets is not None:
                device.targets.release()
            device.targets = Targets(
                context, device.egl.load_opengl_function, programs["resolve"], camera
            )
        scene = device.scenes.get(
            spec.scene,
            lambda: SceneBuffers(context, spec.scene, programs["scene"], programs["textured"]),
        )
        clip_from_view = camera.projection_matrix(near=NEAR_M, far=FAR_M)
        # Upside down, so that the rows come back top first.
        clip_from_view[:2] *= sample_scale(camera)[:, None] * [[1.0], [-1.0]]
        shape = (num_frames, camera.height, camera.width)
        clip = DrawnClip(
            spec,
            scene,
            [],
            invert_pose(spec.trajectory.T_world_camera),
            clip_from_view,
            np.empty((*shape, 3), np.uint8),
            np.empty(shape, np.float32),
            np.empty(shape, np.uint8) if instances else None,
        )
        clip.people += [upload_person(device, clip, place) for place in range(len(spec.people))]
        projection = clip_from_view.T.astype("<f4").tobytes()
        for name in ("body", "shadow"):
            programs[name]["clip_from_view"].write(projection)
        return clip

    def _render_moving(self, device: Device, clip: DrawnClip) -> None:
        targets = device.targets
        assert targets is not None
        num_frames, height, width = clip.depth.shape
        batch = targets.frames_per_strip(width, height)
        whole = (0, 0, width, height)
        for start in range(0, num_frames, batch):
            frames = range(start, min(start + batch, num_frames))
            chosen = slice(frames.start, frames.stop)
            windows = room_windows(clip, chosen)
            targets.open_strip(width, len(frames) * height)
            for group in targets.groups(frames):
                for tile, frame in group:
                    targets.begin(tile)
                    draw_scene(clip, frame, windows[frame - start])
                    draw_people(device, clip, frame)
                for tile, frame in group:
                    targets.resolve(tile, whole, row=(frame - start) * height)
            ids = None if clip.instances is None else clip.instances[chosen]
            targets.read(clip.rgb[chosen], clip.depth[chosen], ids)

    def _render_still(self, device: Device, clip: DrawnClip) -> None:
        targets = device.targets
        assert targets is not None
        pose = clip.spec.trajectory.T_world_camera[0].tobytes()
        background = device.backgrounds.get(
            (clip.scene.serial, clip.spec.camera, pose), lambda: draw_background(targets, clip)
        )
        clip.rgb[:], clip.depth[:] = background.rgb, background.depth
        if clip.instances is not None:
            clip.instances[:] = 0
        if clip.people:
            self._render_people_over(device, targets, clip, background.tile)

    def _render_people_over(
        self, device: Device, targets: Targets, clip: DrawnClip, background: Any
    ) -> None:
        """Redraws the rectangle around the people of every frame over the background."""
        rectangles = union_rectangles([person.rectangles for person in clip.people])
        tile_width = int((rectangles[:, 2] - rectangles[:, 0]).max())
        tile_height = int((rectangles[:, 3] - rectangles[:, 1]).max())
        if not tile_width:
            return
        batch = targets.frames_per_strip(tile_width, tile_height)
        for start in range(0, len(rectangles), batch):
            frames = range(start, min(start + batch, len(rectangles)))
            targets.open_strip(tile_width, len(frames) * tile_height)
            for group in targets.groups([frame for frame in frames if rectangles[frame, 2]]):
                for tile, frame in group:
                    targets.restore(background, tile, as_rectangle(rectangles[frame]))
                for tile, frame in group:
                    tile.use()
                    draw_people(device, clip, frame)
                for tile, frame in group:
                    row = (frame - start) * tile_height
                    targets.resolve(tile, as_rectangle(rectangles[frame]), row=row)
            shape = (len(frames), tile_height, tile_width)
            rgb, depth = np.empty((*shape, 3), np.uint8), np.empty(shape, np.float32)
            ids = None if clip.instances is None else np.empty(shape, np.uint8)
            targets.read(rgb, depth, ids)
            for row, frame in enumerate(frames):
                u0, v0, u1, v1 = as_rectangle(rectangles[frame])
                inside = (row, slice(v1 - v0), slice(u1 - u0))
                clip.rgb[frame, v0:v1, u0:u1] = rgb[inside]
                clip.depth[frame, v0:v1, u0:u1] = depth[inside]
                if clip.instances is not None and ids is not None:
                    clip.instances[frame, v0:v1, u0:u1] = ids[inside]
