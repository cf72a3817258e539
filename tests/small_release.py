"""A tiny release made in code: two box rooms, two box-limbed bodies, seven motions, six episodes.

Everything here is our own and may be used freely (CC0).
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from affectsim_data.avatars import Avatar, AvatarMesh
from affectsim_data.cameras import Camera
from affectsim_data.episodes import (
    RING_DISTANCES_M,
    Episode,
    Participant,
    Person,
    ReferenceView,
    Robot,
    World,
)
from affectsim_data.motions import EMOTIONS, Emotion, Motion
from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray, axis_angle_quaternion, yaw_quaternion
from affectsim_data.scenes import Door, Room, Scene, Seat, Surface
from affectsim_data.schemas import SPLITS, Split
from affectsim_data.skeletons import BODY, JOINT_NAMES, JOINT_PARENTS, Skeleton

CAMERA = Camera(width=224, height=224, hfov=math.radians(60.0))
ROBOT = Robot()
LICENCE = "CC0-1.0"
Point = tuple[float, float, float]


def surface(name: str, quads: ArrayLike, color: Sequence[int] = (200, 200, 200, 255)) -> Surface:
    """A surface of quads `(n, 4, 3)`, corners counter-clockwise from outside."""
    corners = np.asarray(quads, np.float32).reshape(-1, 4, 3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    first = 4 * np.arange(len(corners), dtype=np.uint32)[:, None, None]
    return Surface(
        name=name,
        positions=corners.reshape(-1, 3),
        normals=np.repeat(normals, 4, axis=0).astype(np.float32),
        colors=np.tile(np.array(color, np.uint8), (4 * len(corners), 1)),
        faces=(first + np.array([[0, 1, 2], [0, 2, 3]], np.uint32)).reshape(-1, 3),
    )


def box_quads(low: Point, high: Point) -> FloatArray:
    """The six faces of an axis-aligned box, seen from outside, `(6, 4, 3)`."""
    x0, y0, z0, x1, y1, z1 = *low, *high
    return np.array(
        [
            [[x0, y1, z1], [x1, y1, z1], [x1, y1, z0], [x0, y1, z0]],
            [[x0, y0, z0], [x1, y0, z0], [x1, y0, z1], [x0, y0, z1]],
            [[x0, y0, z1], [x1, y0, z1], [x1, y1, z1], [x0, y1, z1]],
            [[x1, y0, z0], [x0, y0, z0], [x0, y1, z0], [x1, y1, z0]],
            [[x1, y0, z1], [x1, y0, z0], [x1, y1, z0], [x1, y1, z1]],
            [[x0, y0, z0], [x0, y0, z1], [x0, y1, z1], [x0, y1, z0]],
        ]
    )


def box_room(
    scene_id: str, *, half: float = 4.0, boxes: Iterable[tuple[Point, Point]] = ()
) -> Scene:
    """A square room around the origin, floor at 0, ceiling at 2.6 m, with boxes in it."""
    inside = box_quads((-half, 0.0, -half), (half, 2.6, half))[:, ::-1]
    surfaces = [
        surface("plaster", inside[[0, 2, 3, 4, 5]], (220, 215, 205, 255)),
        surface("oak", inside[[1]], (150, 110, 70, 255)),
    ]
    crates = [box_quads(low, high) for low, high in boxes]
    if crates:
        surfaces.append(surface("crates", np.concatenate(crates), (90, 120, 160, 255)))
    corners = ((-half, -half), (half, -half), (half, half), (-half, half))
    return Scene(
        scene_id=scene_id,
        surfaces=tuple(surfaces),
        rooms=(Room("room", "living", corners),),
        seats=(Seat((2.0, 0.45, 0.0), 90.0, depth=0.5, height=0.45),),
        doors=(Door((0.0, 1.4, -half), 0.0, width=0.9, height=2.0, hinge=(-0.45, 0.0, -half)),),
        source="tests",
        licence=LICENCE,
    )


def limb_avatar(avatar_id: str, *, scale: float = 1.0) -> Avatar:
    """A body of one box per bone, rigidly skinned, in the proportions of the canonical body."""
    skeleton = Skeleton(JOINT_NAMES, JOINT_PARENTS, BODY.joint_offsets * scale)
    rest = skeleton.rest_positions
    positions, normals, faces, joints = [], [], [], []
    bones = [(parent, rest[joint]) for joint, parent in enumerate(JOINT_PARENTS) if parent >= 0]
    bones.append((JOINT_NAMES.index("head"), rest[JOINT_NAMES.index("head")] + (0.0, 0.15, 0.0)))
    for number, (joint, end) in enumerate(bones):
        low = np.minimum(rest[joint], end) - 0.05
        high = np.maximum(rest[joint], end) + 0.05
        bone = surface("bone", box_quads(tuple(low), tuple(high)))
        positions.append(bone.positions)
        normals.append(bone.normals)
        faces.append(bone.faces + np.uint32(24 * number))
        joints.append(np.full((24, 1), joint))
    vertices = np.concatenate(positions)
    vertices[:, 1] = np.maximum(vertices[:, 1], 0.0)
    indices = np.concatenate(joints) * np.array([1, 0, 0, 0])
    mesh = AvatarMesh(
        positions=vertices,
        normals=np.concatenate(normals),
        colors=np.tile(np.array([180, 120, 90, 255], np.uint8), (len(vertices), 1)),
        joint_indices=indices.astype(np.uint8),
        joint_weights=np.tile(np.array([255, 0, 0, 0], np.uint8), (len(vertices), 1)),
        faces=np.concatenate(faces),
    )
    return Avatar(avatar_id, skeleton, (mesh,), source="tests", licence=LICENCE)


def _standing(num_frames: int) -> FloatArray:
    """Joint rotations of a body that stands with its arms down, `(num_frames, 22, 4)`."""
    rotations = np.zeros((num_frames, 22, 4))
    rotations[..., 0] = 1.0
    for side, sign in (("left", -1.0), ("right", 1.0)):
        turn = axis_angle_quaternion([0.0, 0.0, 1.0], np.radians(75.0 * sign))
        rotations[:, JOINT_NAMES.index(f"{side}_shoulder")] = turn
    return rotations


def sway_motion(motion_id: str, emotion: Emotion, *, performer_id: str = "p0") -> Motion:
    """Two seconds of standing and swaying the trunk, alike for every emotion."""
    num_frames = 60
    swing = 0.15 * np.sin(2.0 * np.pi * np.arange(num_frames) / num_frames)
    rotations = _standing(num_frames)
    rotations[:, JOINT_NAMES.index("spine1")] = axis_angle_quaternion([0.0, 0.0, 1.0], swing)
    root = np.tile([0.0, BODY.hip_height, 0.0], (num_frames, 1))
    return _motion(motion_id, emotion, "sway", performer_id, 30.0, root, rotations)


def circle_motion(
    motion_id: str, emotion: Emotion, *, performer_id: str = "p0", radius: float = 0.5
) -> Motion:
    """Three seconds of walking a circle to the left, at 20 frames a second."""
    num_frames = 60
    heading = 2.0 * np.pi * np.arange(num_frames) / num_frames
    rotations = _standing(num_frames)
    rotations[:, 0] = yaw_quaternion(heading)
    height = np.full(num_frames, BODY.hip_height)
    root = np.stack([radius - radius * np.cos(heading), height, radius * np.sin(heading)], axis=1)
    return _motion(motion_id, emotion, "simple_walk", performer_id, 20.0, root, rotations)


def _motion(
    motion_id: str,
    emotion: Emotion,
    action: str,
    performer_id: str,
    fps: float,
    root: FloatArray,
    rotations: FloatArray,
) -> Motion:
    return Motion(
        motion_id=motion_id,
        performer_id=performer_id,
        group_id=f"group-{performer_id}",
        emotion=emotion,
        action=action,
        fps=fps,
        root_translation=root,
        joint_rotations=rotations,
        source="tests",
        licence=LICENCE,
    ).rounded()


def place(motion: Motion, avatar: Avatar, anchor: Point, facing: float) -> Participant:
    """A participant from what it performs, in which body and where."""
    return Participant(motion.motion_id, motion.performer_id, avatar.avatar_id, anchor, facing)


def world_of(
    scene: Scene, people: Iterable[tuple[Motion, Avatar, Point, float]], camera: Camera = CAMERA
) -> World:
    """A world of people at anchors and facings; the first is the target."""
    persons = tuple(
        Person(motion, avatar, place(motion, avatar, anchor, facing).T_world_performance)
        for motion, avatar, anchor, facing in people
    )
    return World(scene=scene, people=persons, camera=camera, robot=ROBOT)


def front_view(num_knots: int = 10) -> ReferenceView:
    """A still reference camera 2 m along +Z, 1.2 m high, looking along -Z."""
    knots = np.tile([0.0, 1.2, 2.0, 1.0, 0.0, 0.0, 0.0], (num_knots, 1)).astype(np.float32)
    parts = {"visibility": 1.0, "alignment": 1.0, "distance_fit": 0.9}
    parts |= {"framing": 0.8, "clearance": 0.7}
    return ReferenceView(0.0, 2.0, 1.2, 0.9, parts, knots.astype(np.float64))


def make_episode(**changes: Any) -> Episode:
    """An episode of the swaying motion in the first room; `changes` replace its fields."""
    fields: dict[str, Any] = {
        "episode_id": "small/0",
        "split": "test",
        "scene_split": "train",
        "placement_id": "placement_0",
        "support": None,
        "group_id": "group-p0",
        "family": "observation_controlled",
        "challenge": "rear_view",
        "action": "sway",
        "emotion": "happy",
        "scene_id": "empty_room",
        "target": Participant("sway_happy", "p0", "plain", (0.0, 0.0, 0.0), 0.0),
        "partner": None,
        "target_index": 0,
        "start_position": (0.0, 0.0, -2.5),
        "start_yaw": math.pi,
        "phase_s": 0.5,
        "duration_s": 2.0,
        "monitor_position": (-3.8, 2.4, -3.8),
        "monitor_yaw": math.radians(-135.0),
        "monitor_pitch": math.radians(-25.0),
        "reference": front_view(),
        "d_star": {1: 1.5, 3: 0.5, 5: "empty"},
        "navmesh_sha256": hashlib.sha256(b"").hexdigest(),
        "agent_radius_m": 0.3,
        "initial_bearing": math.pi,
        "visible_share_init": 1.0,
        "visible_share_ref": 1.0,
        "visible_share_mon": 0.9,
        "source": "tests",
        "recipe": "small",
        "seed": 7,
        "code_version": "0.0.0",
    }
    return Episode(**{**fields, **changes})


def small_scenes() -> dict[str, Scene]:
    """An empty room, and one with a chest-high box."""
    crate = ((1.0, 0.0, -0.5), (1.6, 1.1, 0.5))
    return {
        scene.scene_id: scene
        for scene in (box_room("empty_room"), box_room("crate_room", boxes=[crate]))
    }


@functools.cache
def small_navmeshes() -> dict[str, NavMesh]:
    """Where the robot can go in them."""
    return {
        name: NavMesh.from_mesh(*scene.mesh(), mesh_sha256=scene.mesh_sha256())
        for name, scene in small_scenes().items()
    }


def _d_star(episode: Episode) -> dict[str, Any]:
    """What the navmesh says of an episode's start, as changes to the episode."""
    navmesh = small_navmeshes()[episode.scene_id]
    d_star: dict[int, float | str] = {}
    for r in RING_DISTANCES_M:
        length = navmesh.ring_distance(episode.start_position, episode.target.anchor, r)
        reason = "empty" if math.isnan(length) else "unreachable"
        d_star[r] = length if math.isfinite(length) else reason
    return {"d_star": d_star, "navmesh_sha256": hashlib.sha256(navmesh.to_bytes()).hexdigest()}


def small_avatars() -> dict[str, Avatar]:
    """A body in canonical size and a taller one."""
    return {
        avatar.avatar_id: avatar
        for avatar in (limb_avatar("plain"), limb_avatar("tall", scale=1.1))
    }


def small_motions() -> dict[str, Motion]:
    """One sway per emotion and two walks on a circle."""
    motions = [sway_motion(f"sway_{emotion}", emotion) for emotion in EMOTIONS]
    motions.append(circle_motion("circle_sad", "sad", performer_id="p1"))
    motions.append(circle_motion("circle_angry", "angry", performer_id="p2"))
    return {motion.motion_id: motion for motion in motions}


def small_episodes() -> list[Episode]:
    """Two episodes a split; the last is a dyad."""
    motions = small_motions()
    names = ("sway_angry", "circle_sad", "sway_fearful", "sway_neutral", "sway_happy", "sway_sad")
    bodies, rooms = ("plain", "tall"), ("empty_room", "crate_room")
    episodes = []
    for number, motion_id in enumerate(names):
        motion = motions[motion_id]
        target = place(motion, small_avatars()[bodies[number % 2]], (0.0, 0.0, 0.0), 0.3)
        changes: dict[str, Any] = {
            "episode_id": f"small/{number}",
            "split": SPLITS[number // 2],
            "scene_split": "train",
            "placement_id": "placement_0",
            "support": None,
            "group_id": f"group-{number // 2}",
            "action": motion.action,
            "emotion": motion.emotion,
            "scene_id": rooms[number % 2],
            "target": target,
            "phase_s": 0.1 * number,
            "duration_s": motion.duration_s,
            "initial_bearing": math.pi - 0.3,
        }
        if number == len(names) - 1:
            partner = Participant("circle_angry", "p2", "plain", (1.2, 0.0, 2.0), math.pi)
            changes |= {"family": "dyadic", "challenge": None, "partner": partner}
        episode = make_episode(**changes)
        episodes.append(dataclasses.replace(episode, **_d_star(episode)))
    return episodes


def small_rows() -> dict[str, list[dict[str, Any]]]:
    """The rows of all tables, by table."""
    from affectsim_data.releases.rows import avatar_row, motion_row, scene_row

    return {
        "episodes": [episode.to_row() for episode in small_episodes()],
        "motions": [motion_row(motion) for motion in small_motions().values()],
        "scenes": [
            scene_row(scene, small_navmeshes()[scene_id])
            for scene_id, scene in small_scenes().items()
        ],
        "avatars": [avatar_row(avatar) for avatar in small_avatars().values()],
    }


def write_release(
    out: Path,
    *,
    rows: Mapping[str, list[dict[str, Any]]] | None = None,
    splits: Sequence[Split] = SPLITS,
    overwrite: bool = False,
    seed: int = 7,
) -> None:
    """Writes the small release, or one of other rows, into a folder."""
    # Not at the top: the bodies and rooms above serve tests that need no release.
    from affectsim_data.releases import ReleaseWriter

    tables = small_rows() if rows is None else rows
    with ReleaseWriter(out, overwrite=overwrite) as writer:
        for split in splits:
            chosen = [row for row in tables["episodes"] if row["split"] == split]
            writer.add_table("episodes", chosen, stem=split)
        writer.add_table("motions", tables["motions"])
        writer.add_table("scenes", tables["scenes"])
        writer.add_table("avatars", tables["avatars"])
        writer.finish(
            name="small",
            recipe="small",
            seed=seed,
            code_version="0.0.0",
            camera=CAMERA,
            robot=ROBOT,
            licences=[LICENCE],
        )


if __name__ == "__main__":
    import sys

    write_release(Path(sys.argv[1]), overwrite="--overwrite" in sys.argv)
