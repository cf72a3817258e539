"""Scenes and bodies made of code, for tests and benchmarks of the renderers."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.avatars import Avatar, AvatarMesh
from affectsim_data.cameras import Camera, CameraTrajectory
from affectsim_data.poses import (
    FloatArray,
    axis_angle_quaternion,
    compose_pose,
    look_at,
    yaw_quaternion,
)
from affectsim_data.render import ClipSpec, PosedAvatar
from affectsim_data.scenes import Doorway, Room, Scene, Surface
from affectsim_data.scenes.chunks import chunk_surfaces
from affectsim_data.skeletons import BODY, JOINT_NAMES, JOINT_PARENTS, NUM_JOINTS

__all__ = [
    "box",
    "capsule_avatar",
    "checker",
    "flat_of_rooms",
    "furnished_room",
    "grid",
    "merge",
    "moving_camera",
    "one_room",
    "scene_of",
    "standing_person",
    "still_camera",
]

CAMERA = Camera(width=224, height=224, hfov=np.deg2rad(60.0))
Rgb = tuple[int, int, int]


def grid(
    origin: ArrayLike, across: ArrayLike, along: ArrayLike, steps: int, *, color: Rgb, name: str
) -> Surface:
    """A flat, `steps` x `steps` times divided parallelogram; uvs are metres."""
    o, a, b = (np.asarray(v, np.float64) for v in (origin, across, along))
    s, t = np.meshgrid(np.linspace(0.0, 1.0, steps + 1), np.linspace(0.0, 1.0, steps + 1))
    places = np.stack([s.ravel(), t.ravel()], axis=1)
    positions = o + places[:, :1] * a + places[:, 1:] * b
    corner = (np.arange(steps)[:, None] * (steps + 1) + np.arange(steps)).ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + steps + 2], axis=1),
            np.stack([corner, corner + steps + 2, corner + steps + 1], axis=1),
        ]
    )
    normal = np.cross(a, b)
    normal /= np.linalg.norm(normal)
    # A fixed light from above stands in for a baked one.
    light = 0.75 + 0.25 * float(normal @ np.array([0.3, 0.85, 0.43]))
    rgba = np.clip([*(np.array(color) * light), 255.0], 0, 255).astype(np.uint8)
    return Surface(
        name=name,
        positions=positions.astype(np.float32),
        normals=np.tile(normal, (len(positions), 1)).astype(np.float32),
        colors=np.tile(rgba, (len(positions), 1)),
        faces=faces.astype(np.uint32),
        uvs=(places * [np.linalg.norm(a), np.linalg.norm(b)]).astype(np.float32),
    )


def merge(parts: list[Surface], *, name: str, texture: NDArray[np.uint8] | None = None) -> Surface:
    """One surface of several; all have uvs."""
    starts = np.cumsum([0, *(len(part.positions) for part in parts)])
    faces = [part.faces + np.uint32(start) for part, start in zip(parts, starts, strict=False)]
    return Surface(
        name=name,
        positions=np.concatenate([part.positions for part in parts]),
        normals=np.concatenate([part.normals for part in parts]),
        colors=np.concatenate([part.colors for part in parts]),
        faces=np.concatenate(faces).astype(np.uint32),
        uvs=np.concatenate([part.uvs for part in parts if part.uvs is not None]),
        texture=texture,
    )


def box(
    centre: ArrayLike, size: ArrayLike, *, color: Rgb, name: str = "box", steps: int = 1
) -> Surface:
    """A closed box with outward normals."""
    c, (w, h, d) = np.asarray(centre, np.float64), np.asarray(size, np.float64)
    x, y, z = np.array([w, 0, 0]), np.array([0, h, 0]), np.array([0, 0, d])
    sides = [(x, y, z), (y, x, -z), (y, z, x), (z, y, -x), (z, x, y), (x, z, -y)]
    parts = [
        grid(c - a / 2 - b / 2 + n / 2, a, b, steps, color=color, name=name) for a, b, n in sides
    ]
    return merge(parts, name=name)


def checker(size: int = 128, *, cells: int = 8) -> NDArray[np.uint8]:
    """A grey checkerboard texture `(size, size, 3)`."""
    index = np.arange(size) * cells // size
    dark = (index[:, None] + index) % 2
    return np.repeat(np.where(dark, 205, 255).astype(np.uint8)[..., None], 3, axis=2)


def scene_of(*surfaces: Surface, scene_id: str = "test") -> Scene:
    """A scene of one large room around the origin."""
    room = Room("room", "living", ((-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)))
    return Scene(scene_id=scene_id, surfaces=surfaces, rooms=(room,), licence="CC0-1.0")


def _shell(*, half: float, height: float, steps: int) -> list[Surface]:
    s, h = 2.0 * half, height
    x, y, z = np.eye(3)
    floor = grid((-half, 0, half), s * x, -s * z, steps, color=(176, 148, 118), name="floor")
    walls = [
        grid((-half, 0, -half), s * x, h * y, steps, color=(214, 208, 196), name="wall"),
        grid((half, 0, half), -s * x, h * y, steps, color=(214, 208, 196), name="wall"),
        grid((-half, 0, half), -s * z, h * y, steps, color=(200, 208, 204), name="wall"),
        grid((half, 0, -half), s * z, h * y, steps, color=(200, 208, 204), name="wall"),
        grid((-half, h, -half), s * x, s * z, steps, color=(236, 234, 228), name="ceiling"),
    ]
    return [merge([floor], name="floor", texture=checker()), merge(walls, name="walls")]


def one_room(scene_id: str = "room") -> Scene:
    """A closed 8 m room with a checkered floor, a red box left, a blue one right of the middle."""
    return scene_of(
        *_shell(half=4.0, height=2.6, steps=2),
        box((-1.5, 0.4, -1.0), (0.8, 0.8, 0.8), color=(200, 40, 30), name="red"),
        box((1.4, 0.5, 0.6), (0.5, 1.0, 0.5), color=(40, 60, 200), name="blue"),
        scene_id=scene_id,
    )


def furnished_room(*, num_triangles: int, rng: np.random.Generator) -> Scene:
    """A room of finely divided, textured boxes as furniture; about `num_triangles`."""
    pieces, steps = 48, max(1, round((num_triangles * 0.8 / (48 * 12)) ** 0.5))
    shell = _shell(half=5.0, height=2.6, steps=max(2, round((num_triangles * 0.2 / 12) ** 0.5)))
    boxes: list[Surface] = []
    while len(boxes) < pieces:
        x, z = rng.uniform(-4.6, 4.6, 2)
        width, depth = rng.uniform(0.3, 1.2, 2)
        height = rng.uniform(0.25, 1.1)
        # The middle stays free for the person and the camera's way.
        if abs(x) > 1.2 or abs(z) > 2.6:
            red, green, blue = (int(v) for v in rng.integers(70, 235, 3))
            centre, size = (x, height / 2, z), (width, height, depth)
            boxes.append(
                box(centre, size, color=(red, green, blue), name=f"b{len(boxes)}", steps=steps)
            )
    textured = [merge(boxes[i::4], name=f"fabric{i}", texture=checker(512)) for i in range(4)]
    return scene_of(*shell, *textured, scene_id=f"furnished-{num_triangles}")


ROOM_M, WALL_M, CEILING_M, DOORWAY_M = 4.0, 0.2, 2.5, (0.9, 2.0)
"""Of `flat_of_rooms`: inner size, thickness of walls, height, width and height of doorways."""


def flat_of_rooms(*, rng: np.random.Generator, pieces: int = 10) -> Scene:
    """Four furnished rooms around the origin, a ring of doorways off the middle of their walls.

    Room `r0` is at -x and -z, `r1` at +x, `r2` at +z, `r3` at both. Walls are closed solids that
    reach into one another, so that nothing can be seen through cracks; the ceiling is a sheet.
    """
    step = ROOM_M + WALL_M
    centres = [(x * step / 2, z * step / 2) for z in (-1, 1) for x in (-1, 1)]
    rooms = tuple(_square_room(f"r{i}", x, z) for i, (x, z) in enumerate(centres))
    whole = 2.0 * ROOM_M + 3.0 * WALL_M
    parts = [box((0, -0.1, 0), (whole, 0.2, whole), color=(170, 150, 120), steps=8)]
    for side in (-1, 1):
        outer = side * (whole - WALL_M) / 2
        parts.append(box((outer, 1.25, 0), (WALL_M, 2.6, whole), color=(210, 205, 200), steps=4))
        parts.append(box((0, 1.25, outer), (whole, 2.6, WALL_M), color=(200, 205, 210), steps=4))
    places = {(0, 1): -1.1, (2, 3): 0.7, (0, 2): 1.2, (1, 3): -0.4}
    doorways = [_holed_wall(parts, centres, *pair, shift) for pair, shift in places.items()]
    ceiling = grid(
        (-whole / 2, CEILING_M, -whole / 2), (whole, 0, 0), (0, 0, whole), 6,
        color=(235, 235, 230), name="ceiling",
    )  # fmt: skip
    shell = [merge(parts, name="solid", texture=checker()), merge([ceiling], name="sheet")]
    contents = [one for x, z in centres for one in _things(x, z, pieces=pieces, rng=rng)]
    # Surfaces of their own, so that each is a chunk and counts where it alone is in view.
    numbered = [dataclasses.replace(one, name=f"thing {i}") for i, one in enumerate(contents)]
    surfaces, chunks = chunk_surfaces([*shell, *numbered], rooms)
    scene = Scene("flat", surfaces, rooms, doorways=tuple(doorways), licence="CC0-1.0")
    return dataclasses.replace(scene, chunks=chunks)


def _things(x: float, z: float, *, pieces: int, rng: np.random.Generator) -> list[Surface]:
    """Boxes and 36 tiles on the floor of a room, in colours of their own."""
    things, tile = [], ROOM_M / 6
    for _ in range(pieces):
        size = rng.uniform(0.2, 1.0, 3) * (1.0, 2.0, 1.0)
        u, v = rng.uniform(-1.4, 1.4, 2)
        centre = (x + u, size[1] / 2, z + v)
        things.append(box(centre, size, color=_any_color(rng), steps=2))
    for corner in np.ndindex(6, 6):
        u, v = np.array(corner) * tile - ROOM_M / 2
        origin, across, along = (x + u, 0.01, z + v + tile), (tile, 0, 0), (0, 0, -tile)
        things.append(grid(origin, across, along, 1, color=_any_color(rng), name="tile"))
    return things


def _any_color(rng: np.random.Generator) -> Rgb:
    red, green, blue = (int(c) for c in rng.integers(40, 255, 3))
    return red, green, blue


def _square_room(room_id: str, x: float, z: float) -> Room:
    half = ROOM_M / 2
    corners = [
        (x - half, z - half),
        (x + half, z - half),
        (x + half, z + half),
        (x - half, z + half),
    ]
    return Room(room_id, "living", tuple(corners), ceiling_y=CEILING_M)


def _holed_wall(
    parts: list[Surface], centres: list[tuple[float, float]], one: int, other: int, shift: float
) -> Doorway:
    """Adds the wall between two rooms to `parts`, with a doorway `shift` off its middle."""
    (xa, za), (xb, zb) = centres[one], centres[other]
    middle = np.array([(xa + xb) / 2, 0.0, (za + zb) / 2])
    along = np.array([0.0, 0.0, 1.0]) if xa != xb else np.array([1.0, 0.0, 0.0])
    through = np.array([1.0, 0.0, 0.0]) if xa != xb else np.array([0.0, 0.0, 1.0])
    width, height = DOORWAY_M
    reach, low, high = ROOM_M / 2 + WALL_M, shift - width / 2, shift + width / 2
    for start, end, bottom in ((-reach, low, 0.0), (high, reach, 0.0), (low, high, height)):
        centre = middle + (start + end) / 2 * along + (0.0, (bottom + CEILING_M) / 2, 0.0)
        size = (end - start) * along + WALL_M * through + (0.0, CEILING_M - bottom, 0.0)
        parts.append(box(centre, size, color=(220, 200, 180), steps=4))
    x, y, z = (float(value) for value in middle + shift * along)
    yaw = float(np.degrees(np.arctan2(through[0], through[2])))
    return Doorway((f"r{one}", f"r{other}"), (x, y, z), yaw, width, height, WALL_M)


def capsule_avatar(*, rings: int = 8, sides: int = 12, avatar_id: str = "capsules") -> Avatar:
    """A body of one capsule per bone, skinned with soft joints; `rings`, `sides` set its detail."""
    rest = BODY.rest_positions
    radius = {"head": 0.10, "spine": 0.15, "pelvis": 0.14, "hip": 0.09, "knee": 0.07}
    colors = {"head": (224, 172, 140), "wrist": (224, 172, 140), "elbow": (70, 110, 170)}
    parts: list[tuple[FloatArray, FloatArray, NDArray[np.int64], int, int, Rgb]] = []
    for joint, parent in enumerate(JOINT_PARENTS):
        if parent < 0:
            continue
        name = JOINT_NAMES[joint]
        thick = next((r for key, r in radius.items() if key in name), 0.055)
        tint = next((c for key, c in colors.items() if key in name), (70, 110, 170))
        if any(key in name for key in ("knee", "ankle", "hip", "foot")):
            tint = (60, 60, 72)
        top = rest[joint] + (np.array([0, 0.12, 0]) if name == "head" else 0.0)
        vertices, normals, faces = _capsule(rest[parent], top, thick, rings=rings, sides=sides)
        parts.append((vertices, normals, faces, parent, joint, tint))
    return Avatar(avatar_id, BODY, (_skinned(parts),), source="code", licence="CC0-1.0")


def _capsule(
    start: FloatArray, end: FloatArray, radius: float, *, rings: int, sides: int
) -> tuple[FloatArray, FloatArray, NDArray[np.int64]]:
    axis = (end - start) / np.linalg.norm(end - start)
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    u = np.cross(axis, helper)
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    latitude = np.linspace(-np.pi / 2, np.pi / 2, 2 * rings)
    longitude = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    ring = np.cos(longitude)[:, None] * u + np.sin(longitude)[:, None] * v
    normals = np.cos(latitude)[:, None, None] * ring + np.sin(latitude)[:, None, None] * axis
    base = np.where(latitude[:, None, None] < 0.0, start, end)
    vertices = (base + radius * normals).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(2 * rings - 1), np.arange(sides), indexing="ij")
    a, b = (i * sides + j).ravel(), (i * sides + (j + 1) % sides).ravel()
    c, d = a + sides, b + sides
    faces = np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])
    return vertices, normals.reshape(-1, 3), faces


def _skinned(
    parts: list[tuple[FloatArray, FloatArray, NDArray[np.int64], int, int, Rgb]],
) -> AvatarMesh:
    vertices = np.concatenate([part[0] for part in parts])
    starts = np.cumsum([0, *(len(part[0]) for part in parts)])
    indices = np.zeros((len(vertices), 4), np.uint8)
    weights = np.zeros((len(vertices), 4), np.uint8)
    colors = np.full((len(vertices), 4), 255, np.uint8)
    for (points, _, _, parent, joint, tint), start in zip(parts, starts, strict=False):
        rows = slice(start, start + len(points))
        indices[rows, :2] = parent, joint
        half = len(points) // 2
        # The far end of a bone's capsule belongs a little to the next joint: bends show.
        weights[rows, 0] = np.where(np.arange(len(points)) < half, 255, 205)
        weights[rows, 1] = 255 - weights[rows, 0]
        colors[rows, :3] = tint
    return AvatarMesh(
        positions=vertices.astype(np.float32),
        normals=np.concatenate([part[1] for part in parts]).astype(np.float32),
        colors=colors,
        joint_indices=indices,
        joint_weights=weights,
        faces=np.concatenate(
            [part[2] + start for part, start in zip(parts, starts, strict=False)]
        ).astype(np.uint32),
    )


def standing_person(
    avatar: Avatar, *, num_frames: int, at: tuple[float, float] = (0.0, 0.0), yaw: float = 0.0
) -> PosedAvatar:
    """Someone who stands at `(x, z)` and waves with both arms."""
    time = np.linspace(0.0, 1.0, num_frames, endpoint=False)
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (num_frames, NUM_JOINTS, 1))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        raised = -sign * (0.9 - 0.9 * np.sin(2.0 * np.pi * time))
        rotations[:, JOINT_NAMES.index(f"{side}_shoulder")] = axis_angle_quaternion(
            (0.0, 0.0, 1.0), raised
        )
    root = np.tile(BODY.joint_offsets[0], (num_frames, 1))
    placed = compose_pose(yaw_quaternion(yaw), np.array([at[0], 0.0, at[1]]))
    return PosedAvatar(avatar, placed @ avatar.joint_matrices(root, rotations))


def still_camera(
    *, num_frames: int, eye: ArrayLike = (0.0, 1.2, 3.4), target: ArrayLike = (0.0, 1.0, 0.0)
) -> CameraTrajectory:
    """A camera that does not move."""
    return CameraTrajectory.still(look_at(eye, target), num_frames=num_frames)


def moving_camera(*, num_frames: int, distance_m: float = 3.4) -> CameraTrajectory:
    """A camera on its way around the middle of the room."""
    angle = np.linspace(-0.5, 0.5, num_frames)
    height = np.full_like(angle, 1.2)
    eye = np.stack([distance_m * np.sin(angle), height, distance_m * np.cos(angle)], axis=1)
    return CameraTrajectory(look_at(eye, np.tile([0.0, 1.0, 0.0], (num_frames, 1))))


def clip(
    scene: Scene,
    trajectory: CameraTrajectory,
    *people: PosedAvatar,
    camera: Camera = CAMERA,
) -> ClipSpec:
    """A clip specification."""
    return ClipSpec(scene, people, camera, trajectory)
