"""A clip in device terms, and how its scene and people are drawn on a tile."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import UP, FloatArray
from affectsim_data.render import shaders
from affectsim_data.render.backgrounds import Background, BackgroundCache
from affectsim_data.render.buffers import BodyBuffers, SceneBuffers
from affectsim_data.render.cache import BufferCache
from affectsim_data.render.egl import EglContext
from affectsim_data.render.framing import body_corners, choose_mesh, screen_rectangles
from affectsim_data.render.lighting import KEY
from affectsim_data.render.processes import Owner
from affectsim_data.render.protocol import ClipSpec
from affectsim_data.render.shadows import VERTICES_PER_PERSON, shadow_discs
from affectsim_data.render.targets import (
    Rectangle,
    Targets,
    release_framebuffer,
    resolve_constants,
)

__all__ = [
    "Device",
    "DrawnClip",
    "DrawnPerson",
    "as_rectangle",
    "draw_background",
    "draw_people",
    "draw_scene",
    "open_device",
    "room_windows",
    "union_rectangles",
    "upload_person",
]

_POSE_STRIDE = 1280
"""Bytes from frame to frame: 66 rows of 16 bytes, up to a multiple of 256 for any driver."""


@dataclasses.dataclass
class Device:
    """Everything that dies with the context."""

    egl: EglContext
    context: Any
    programs: dict[str, Any]
    owner: Owner
    scenes: BufferCache[SceneBuffers]
    bodies: BufferCache[BodyBuffers]
    backgrounds: BackgroundCache
    targets: Targets | None = None


@dataclasses.dataclass
class DrawnPerson:
    """One participant of the clip at hand."""

    body: BodyBuffers
    poses: Any
    discs: Any
    shadows: Any
    rectangles: NDArray[np.int64]

    def release(self) -> None:
        """Frees what is of this clip only."""
        for item in (self.shadows, self.discs, self.poses):
            item.release()


@dataclasses.dataclass
class DrawnClip:
    """A clip specification in device terms."""

    spec: ClipSpec
    scene: SceneBuffers
    people: list[DrawnPerson]
    view_from_world: FloatArray
    clip_from_view: FloatArray
    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    instances: NDArray[np.uint8] | None


def open_device(index: int | None, cache_bytes: int, max_background_bytes: int) -> Device:
    """Opens a device and compiles its programs."""
    egl = EglContext(index)
    context = egl.wrap()
    sources = {
        "scene": shaders.SCENE,
        "textured": shaders.TEXTURED_SCENE,
        "body": shaders.BODY,
        "shadow": shaders.SHADOW,
        "resolve": shaders.RESOLVE,
    }
    programs = {
        name: context.program(vertex_shader=vertex, fragment_shader=fragment)
        for name, (vertex, fragment) in sources.items()
    }
    resolve_constants(programs["resolve"])
    # Two-sided: rays that decide what is hidden hit both sides of a triangle, so must pixels. Only
    # for closed solids do scene buffers turn culling on; images are drawn upside down, so turn.
    context.enable_only(context.DEPTH_TEST)
    context.front_face = "cw"
    # The alpha channel carries instance ids: shadows leave it alone.
    context.blend_func = (context.ZERO, context.ONE_MINUS_SRC_ALPHA, context.ZERO, context.ONE)
    scenes: BufferCache[SceneBuffers] = BufferCache(cache_bytes)
    bodies: BufferCache[BodyBuffers] = BufferCache(max(cache_bytes // 8, 1))
    backgrounds = BackgroundCache(max_background_bytes)
    return Device(egl, context, programs, Owner(), scenes, bodies, backgrounds)


def draw_background(targets: Targets, clip: DrawnClip) -> Background:
    """What a still camera sees without people."""
    _, height, width = clip.depth.shape
    tile = targets.new_tile()
    targets.open_strip(width, height)
    targets.begin(tile)
    draw_scene(clip, 0, room_windows(clip, slice(0, 1))[0])
    targets.resolve(tile, (0, 0, width, height), row=0)
    rgb, depth = np.empty((1, height, width, 3), np.uint8), np.empty((1, height, width), np.float32)
    targets.read(rgb, depth, None)
    return Background(tile, rgb[0], depth[0], release_framebuffer)


def upload_person(device: Device, clip: DrawnClip, place: int) -> DrawnPerson:
    """A participant on the device, with the poses of all frames."""
    person, spec = clip.spec.people[place], clip.spec
    mesh = choose_mesh(person, spec)
    body = device.bodies.get(
        mesh, lambda: BodyBuffers(device.context, mesh, device.programs["body"])
    )
    # Into the camera frame in double precision: joints of the shader are small numbers.
    joints = clip.view_from_world[:, None] @ person.joint_matrices
    poses = np.zeros((len(joints), _POSE_STRIDE // 4), np.float32)
    poses[:, : 66 * 4] = joints[:, :, :3].reshape(len(joints), -1)
    discs = shadow_discs(spec.scene, person)
    points = np.concatenate(
        [body_corners(body.boxes, person.joint_matrices), discs[..., :3]], axis=1
    )
    disc_buffer = device.context.buffer(discs.tobytes())
    return DrawnPerson(
        body,
        device.context.buffer(poses.tobytes()),
        disc_buffer,
        device.context.vertex_array(
            device.programs["shadow"], [(disc_buffer, "3f4 3f4", "position", "disc")]
        ),
        screen_rectangles(points, spec.camera, spec.trajectory.T_world_camera),
    )


def draw_scene(clip: DrawnClip, frame: int, windows: FloatArray | None) -> None:
    """Draws the static scene of a frame on the bound tile; for `windows` see `room_windows`."""
    clip_from_world = clip.clip_from_view @ clip.view_from_world[frame]
    clip.scene.draw(clip_from_world, clip.spec.trajectory.T_world_camera[frame, :3, 3], windows)


def room_windows(clip: DrawnClip, frames: slice) -> list[FloatArray | None]:
    """Where in the image of each frame each room can be seen, see `Portals.windows`."""
    clip_from_world = clip.clip_from_view @ clip.view_from_world[frames]
    eyes = clip.spec.trajectory.T_world_camera[frames, :3, 3]
    return clip.scene.portals.windows(clip_from_world, eyes)


def draw_people(device: Device, clip: DrawnClip, frame: int) -> None:
    """Shadows of all, then bodies: nobody's shadow falls on a body."""
    context, body, shadow = device.context, device.programs["body"], device.programs["shadow"]
    view = clip.view_from_world[frame]
    visible = [(i, p) for i, p in enumerate(clip.people, start=1) if p.rectangles[frame, 2]]
    if not visible:
        return
    shadow["view_from_world"].write(view.T.astype("<f4").tobytes())
    context.enable(context.BLEND)
    context.fbo.depth_mask = False
    for _, person in visible:
        person.shadows.render(
            context.TRIANGLES, vertices=VERTICES_PER_PERSON, first=frame * VERTICES_PER_PERSON
        )
    context.fbo.depth_mask = True
    context.disable(context.BLEND)
    body["up_view"].value = tuple(view[:3, :3] @ UP)
    body["key_view"].value = tuple(view[:3, :3] @ KEY)
    for place, person in visible:
        person.poses.bind_to_uniform_block(0, frame * _POSE_STRIDE, 66 * 16)
        body["instance"].value = place / 255.0
        person.body.draw()


def union_rectangles(rectangles: list[NDArray[np.int64]]) -> NDArray[np.int64]:
    """Rectangles around rectangles, frame by frame; all-zero ones are empty."""
    stacked = np.stack(rectangles)
    empty = stacked[..., 2] == 0
    low = np.where(empty[..., None], np.iinfo(np.int64).max, stacked[..., :2]).min(axis=0)
    union = np.concatenate([low, stacked[..., 2:].max(axis=0)], axis=1)
    union[empty.all(axis=0)] = 0
    return union


def as_rectangle(row: NDArray[np.int64]) -> Rectangle:
    """Plain integers of one row."""
    u0, v0, u1, v1 = (int(value) for value in row)
    return u0, v0, u1, v1
