"""Writes small made-up files with the exact skeletons, channels, names and folders of real corpora.

Nothing here comes from a corpus: offsets are those of our own 1.70 m body, and the only movement is
an elbow that bends to 40 degrees in the middle of the clip, so that what comes back can be known.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from affectsim_data.motions import Motion
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import BODY, JOINT_NAMES, JOINT_PARENTS

BEND_DEG = 40.0
XYZ = ("Xposition", "Yposition", "Zposition")
Numbers = tuple[float, float, float]


@dataclasses.dataclass(frozen=True)
class Bone:
    """A joint of a made-up BVH skeleton, its offset in centimetres."""

    name: str
    parent: str
    offset: Numbers
    end: Numbers | None = None


@dataclasses.dataclass(frozen=True)
class Rig:
    """A skeleton with the channels of its joints."""

    bones: Sequence[Bone]
    order: str
    """Order of the rotation channels, such as `ZXY`."""
    every_joint_moves: bool
    """Whether every joint has six channels, or the root alone."""
    elbow: str

    def channels(self, bone: Bone) -> tuple[str, ...]:
        position = XYZ if self.every_joint_moves or not bone.parent else ()
        return (*position, *(f"{axis}rotation" for axis in self.order))

    def hierarchy(self, bone: Bone) -> list[str]:
        channels = self.channels(bone)
        lines = [f"{'JOINT' if bone.parent else 'ROOT'} {bone.name}", "{", _offset(bone.offset)]
        lines.append(f"CHANNELS {len(channels)} {' '.join(channels)}")
        for child in self.bones:
            if child.parent == bone.name:
                lines += self.hierarchy(child)
        if bone.end is not None:
            lines += ["End Site", "{", _offset(bone.end), "}"]
        return [*lines, "}"]


def _offset(offset: Numbers) -> str:
    return "OFFSET " + " ".join(f"{number:.4f}" for number in offset)


def kdae_rig() -> Rig:
    """59 joints and 13 end sites, six channels on each, hands with fingers."""
    bones = [Bone("Hips", "", (0.0, 93.0, 0.0))]
    for side, x in (("Right", -1.0), ("Left", 1.0)):
        bones += [
            Bone(f"{side}UpLeg", "Hips", (9.0 * x, -3.0, 0.0)),
            Bone(f"{side}Leg", f"{side}UpLeg", (0.0, -41.5, 0.0)),
            Bone(f"{side}Foot", f"{side}Leg", (0.0, -42.0, 0.0), (0.0, -4.5, 13.0)),
        ]
    chain = ["Hips", "Spine", "Spine1", "Spine2", "Spine3", "Neck", "Head"]
    heights = (11.0, 9.0, 9.0, 9.0, 16.0, 10.0)
    for parent, name, y in zip(chain, chain[1:], heights, strict=False):
        end = (0.0, 17.0, 0.0) if name == "Head" else None
        bones.append(Bone(name, parent, (0.0, y, 0.0), end))
    for side, x in (("Right", -1.0), ("Left", 1.0)):
        bones += [
            Bone(f"{side}Shoulder", "Spine3", (6.0 * x, 11.0, 0.0)),
            Bone(f"{side}Arm", f"{side}Shoulder", (11.0 * x, 0.0, 0.0)),
            Bone(f"{side}ForeArm", f"{side}Arm", (29.0 * x, 0.0, 0.0)),
            Bone(f"{side}Hand", f"{side}ForeArm", (26.0 * x, 0.0, 0.0)),
        ]
        for number, finger in enumerate(("Thumb", "Index", "Middle", "Ring", "Pinky")):
            parent = f"{side}Hand"
            if finger != "Thumb":
                parent = f"{side}InHand{finger}"
                bones.append(Bone(parent, f"{side}Hand", (4.0 * x, 0.0, 3.0 - number)))
            for joint in (1, 2, 3):
                name = f"{side}Hand{finger}{joint}"
                end = (2.0 * x, 0.0, 0.0) if joint == 3 else None
                bones.append(Bone(name, parent, (3.0 * x, 0.0, 0.0), end))
                parent = name
    return Rig(bones, "ZXY", every_joint_moves=True, elbow="LeftForeArm")


def emilya_rig() -> Rig:
    """23 joints and 5 end sites as Xsens MVN exports them."""
    bones = [Bone("Hips", "", (0.0, 95.0, 0.0))]
    chain = ["Hips", "Chest", "Chest2", "Chest3", "Chest4", "Neck", "Head"]
    heights = (10.0, 10.0, 9.0, 9.0, 13.0, 9.0)
    for parent, name, y in zip(chain, chain[1:], heights, strict=False):
        end = (0.0, 17.0, 0.0) if name == "Head" else None
        bones.append(Bone(name, parent, (0.0, y, 0.0), end))
    for side, x in (("Right", -1.0), ("Left", 1.0)):
        bones += [
            Bone(f"{side}Collar", "Chest4", (3.0 * x, 8.0, 0.0)),
            Bone(f"{side}Shoulder", f"{side}Collar", (14.0 * x, 0.0, 0.0)),
            Bone(f"{side}Elbow", f"{side}Shoulder", (29.0 * x, 0.0, 0.0)),
            Bone(f"{side}Wrist", f"{side}Elbow", (25.0 * x, 0.0, 0.0), (18.0 * x, 0.0, 0.0)),
        ]
    for side, x in (("Right", -1.0), ("Left", 1.0)):
        bones += [
            Bone(f"{side}Hip", "Hips", (9.0 * x, 0.0, 0.0)),
            Bone(f"{side}Knee", f"{side}Hip", (0.0, -44.0, 0.0)),
            Bone(f"{side}Ankle", f"{side}Knee", (0.0, -43.0, 0.0)),
            Bone(f"{side}Toe", f"{side}Ankle", (0.0, -6.0, 14.0), (0.0, 0.0, 6.0)),
        ]
    return Rig(bones, "YXZ", every_joint_moves=False, elbow="LeftElbow")


def body_rig() -> Rig:
    """The canonical body."""
    bones = []
    for joint, (name, parent) in enumerate(zip(JOINT_NAMES, JOINT_PARENTS, strict=True)):
        x, y, z = (float(number) for number in BODY.joint_offsets[joint] * 100.0)
        end = None if joint in JOINT_PARENTS else (0.0, 0.0, 0.0)
        bones.append(Bone(name, JOINT_NAMES[parent] if parent >= 0 else "", (x, y, z), end))
    return Rig(bones, "ZXY", every_joint_moves=False, elbow="left_elbow")


def rig_bvh(rig: Rig, num_frames: int, fps: float) -> str:
    """A BVH file of a rig in its zero pose, a T-pose, whose left elbow bends forward and back."""
    by_name = {bone.name: bone for bone in rig.bones}
    hierarchy = rig.hierarchy(rig.bones[0])
    order = [by_name[line.split()[1]] for line in hierarchy if line.startswith(("ROOT", "JOINT"))]
    columns = [(bone, channel) for bone in order for channel in rig.channels(bone)]
    values = np.zeros((num_frames, len(columns)))
    for column, (bone, channel) in enumerate(columns):
        if channel in XYZ:
            values[:, column] = bone.offset[XYZ.index(channel)]
        elif bone.name == rig.elbow and channel == "Yrotation":
            # About +Y: the left arm's direction, +X, turns towards the front, +Z, by minus.
            values[:, column] = -BEND_DEG * bend_share(num_frames)
    rows = [" ".join(f"{value:.4f}" for value in row) for row in values]
    head = ["HIERARCHY", *hierarchy, "MOTION", f"Frames: {num_frames}"]
    return "\n".join([*head, f"Frame Time: {1.0 / fps:.7f}", *rows]) + "\n"


def bend_share(num_frames: int) -> FloatArray:
    """How far the elbow is bent in each frame: from 0 to 1 in the middle and back."""
    share: FloatArray = np.sin(np.pi * np.arange(num_frames) / num_frames)
    return share


def elbow_bends_deg(motion: Motion, side: str = "left") -> FloatArray:
    """Angle between upper arm and forearm, `(num_frames,)`, 0 for a straight arm."""
    names = [JOINT_NAMES.index(f"{side}_{part}") for part in ("shoulder", "elbow", "wrist")]
    bones = np.diff(motion.joint_positions()[:, names], axis=1)
    bones /= np.linalg.norm(bones, axis=-1, keepdims=True)
    angles: FloatArray = np.rad2deg(np.arccos((bones[:, 0] * bones[:, 1]).sum(-1).clip(-1.0, 1.0)))
    return angles


def write_tree(root: Path, names: Sequence[str], text: str) -> None:
    """The same text as many files."""
    for name in names:
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def write_kdae(root: Path, names: Sequence[str]) -> None:
    """Files such as `F01A0V1` as the corpus lays them out: `BVH/F01/F01A0V1.bvh`, 125 Hz."""
    text = rig_bvh(kdae_rig(), 250, 125.0)
    write_tree(root, [f"BVH/{name[:3]}/{name}.bvh" for name in names], text)
    lines = ["filename,actor_ID,emotion,actor_gender,scenario_ID,version"]
    lines += [f"{name},{name[:3]},?,{name[0]},{name[-3]},{name[-1]}" for name in names]
    (root / "file-info.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_emilya(root: Path, places: Sequence[tuple[str, str, str]], fps: float = 120.0) -> None:
    """Two clips and the duplicate of one in each action, emotion and actor's folder."""
    text = rig_bvh(emilya_rig(), 2 * round(fps), fps)
    for place in places:
        folder = "/".join(("Emilya", "PerAction", *place))
        write_tree(root, [f"{folder}/{n}.bvh" for n in ("clip-001", "clip-002")], text)
        write_tree(root, [f"{folder}/clip-001_zyx.bvh"], text)


def smpl_arrays(num_frames: int = 240, fps: float = 120.0, width: int = 156) -> dict[str, Any]:
    """Arrays of an AMASS file: a body in T-pose facing -Y, +Z up, whose left elbow bends."""
    poses = np.zeros((num_frames, width))
    poses[:, 0] = np.pi / 2.0  # the body's +Y becomes +Z
    elbow = 3 * JOINT_NAMES.index("left_elbow")
    poses[:, elbow + 1] = -np.deg2rad(BEND_DEG) * bend_share(num_frames)
    translation = np.tile([1.5, -2.0, 0.92], (num_frames, 1))
    return {
        "poses": poses,
        "trans": translation,
        "mocap_framerate": np.array(fps),
        "gender": np.array("female"),
        "betas": np.zeros(16),
        "dmpls": np.zeros((num_frames, 8)),
    }


def write_smpl(path: Path, arrays: Mapping[str, Any] | None = None) -> Path:
    """An `.npz` file of the arrays, or of the default ones."""
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez(path, **dict(arrays or smpl_arrays()))
    return path
