"""Poses the canonical body from where its parts should be: pelvis, trunk, head, wrists, ankles."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.builders.performances.styles import Side
from affectsim_data.motions.inverse_kinematics import align_bone, two_bone_ik
from affectsim_data.poses import (
    FloatArray,
    axis_angle_quaternion,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
    standard_quaternion,
    yaw_quaternion,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES, JOINT_PARENTS, NUM_JOINTS

__all__ = [
    "SIDES",
    "SIGN",
    "TOE_OFFSET",
    "BodyTrack",
    "Contact",
    "body_frames",
    "clear_of_trunk",
    "foot_rotation",
    "solve_body",
    "turn_rotation",
]

SIDES: tuple[Side, Side] = ("left", "right")
SIGN = {"left": 1.0, "right": -1.0}
_ELBOW_FLEXION = np.deg2rad(150.0)
"""How far elbows bend (AAOS, Joint Motion, 1965)."""
TOE_OFFSET = BODY.joint_offsets[JOINT_NAMES.index("left_foot")]
"""Toe base in the foot, metres, `(3,)`; the same on both sides."""
_TRUNK_HALF_M = np.array([0.20, 0.16])
"""Half width and half depth of the clothed trunk, that wrists keep out of."""


@dataclasses.dataclass
class Contact:
    """A wrist at a place of the world, for as long as `share` is above 0."""

    position: FloatArray
    """World, metres, `(num_frames, 3)`."""
    share: FloatArray
    """0 follows `BodyTrack.wrists`, 1 this place, `(num_frames,)`."""


@dataclasses.dataclass
class BodyTrack:
    """Where the parts of a body are over time; every array starts with `num_frames`.

    Angles are radians. Turns of trunk and head are `(pitch, yaw, roll)`: pitch positive forward,
    yaw to the left, roll to the right. Hands are given per side from their shoulder as
    `(out, up, forward)`, metres, in a level frame that turns with the chest.
    """

    pelvis_position: FloatArray
    """World, metres, `(num_frames, 3)`."""
    pelvis_turn: FloatArray
    """Pitch, yaw, roll in the world, `(num_frames, 3)`."""
    trunk_turn: FloatArray
    """Chest in the pelvis, `(num_frames, 3)`."""
    head_turn: FloatArray
    """Head in the chest, `(num_frames, 3)`."""
    shrug: FloatArray
    """Collar bones raised, `(num_frames,)`."""
    wrists: dict[Side, FloatArray]
    """`(num_frames, 3)`."""
    elbows: dict[Side, FloatArray]
    """Which way the elbow sticks out, `(num_frames, 3)`."""
    palms: dict[Side, FloatArray]
    """Turn of the hand about the forearm, thumb outward, `(num_frames,)`."""
    ankles: dict[Side, FloatArray]
    """World, metres, `(num_frames, 3)`."""
    feet: dict[Side, FloatArray]
    """Yaw in the world and pitch (positive lifts the heel), `(num_frames, 2)`."""
    wrist_bends: dict[Side, FloatArray] = dataclasses.field(default_factory=dict)
    """Hand bent at the wrist, positive towards the palm, `(num_frames,)`; straight if not given."""
    contacts: dict[Side, Contact] = dataclasses.field(default_factory=dict)
    """Wrists held at places of the world instead, such as another person's shoulder."""
    knees: dict[Side, FloatArray] = dataclasses.field(default_factory=dict)
    """Which way the knee sticks out in the world, `(num_frames, 3)`; over the toes if not given."""
    nod: FloatArray | None = None
    """Pitch of the head alone on the neck, beside `head_turn`, `(num_frames,)`."""


def foot_rotation(feet: FloatArray) -> FloatArray:
    """World rotation of feet `(n, 2)` (yaw, pitch), `(n, 4)`."""
    pitch = axis_angle_quaternion([1.0, 0.0, 0.0], feet[:, 1])
    return quaternion_multiply(yaw_quaternion(feet[:, 0]), pitch)


def solve_body(track: BodyTrack) -> tuple[FloatArray, FloatArray]:
    """`root_translation` `(num_frames, 3)` and `joint_rotations` `(num_frames, 22, 4)`."""
    world = np.zeros((len(track.pelvis_position), NUM_JOINTS, 4))
    positions = np.zeros((len(world), NUM_JOINTS, 3))
    _place_trunk(track, world, positions)
    for side in SIDES:
        _place_arm(track, side, world, positions)
        _place_leg(track, side, world, positions)
    local = world.copy()
    for joint, parent in enumerate(JOINT_PARENTS):
        if parent >= 0:
            inverse = quaternion_conjugate(world[:, parent])
            local[:, joint] = quaternion_multiply(inverse, world[:, joint])
    return track.pelvis_position, standard_quaternion(local)


def clear_of_trunk(target: FloatArray, chest: FloatArray, positions: FloatArray) -> FloatArray:
    """Wrist targets moved out of an elliptic column around the chest's axis, below the neck."""
    origin = positions[:, JOINT_NAMES.index("spine3")]
    local = quaternion_rotate(quaternion_conjugate(chest), target - origin)
    flat = local[:, [0, 2]] / _TRUNK_HALF_M
    radius = np.linalg.norm(flat, axis=1)
    below = local[:, 1] < 0.12
    factor = np.where(below & (radius < 1.0), 1.0 / np.maximum(radius, 1e-3), 1.0)
    local[:, [0, 2]] *= factor[:, None]
    return origin + quaternion_rotate(chest, local)


def body_frames(track: BodyTrack) -> tuple[FloatArray, FloatArray]:
    """World rotations `(num_frames, 22, 4)` and positions of all joints but arms, metres.

    Places on the body, such as a mouth or a thigh, can be found before the arms reach for them.
    Elbows and wrists are left at 0.
    """
    world = np.zeros((len(track.pelvis_position), NUM_JOINTS, 4))
    positions = np.zeros((len(world), NUM_JOINTS, 3))
    _place_trunk(track, world, positions)
    for side in SIDES:
        _place_leg(track, side, world, positions)
    return world, positions


def _place_trunk(track: BodyTrack, world: FloatArray, positions: FloatArray) -> None:
    """Pelvis to head, and the collar bones."""
    world[:, 0] = turn_rotation(track.pelvis_turn)
    positions[:, 0] = track.pelvis_position
    for names, turn in (
        (("spine1", "spine2", "spine3"), track.trunk_turn),
        (("neck", "head"), track.head_turn),
    ):
        share = turn_rotation(turn / len(names))
        for name in names:
            joint, parent = _place(name, world, positions)
            world[:, joint] = quaternion_multiply(world[:, parent], share)
    if track.nod is not None:
        nod = axis_angle_quaternion([1.0, 0.0, 0.0], track.nod)
        world[:, joint] = quaternion_multiply(world[:, joint], nod)
    for side in SIDES:
        joint, parent = _place(f"{side}_collar", world, positions)
        lift = axis_angle_quaternion([0.0, 0.0, SIGN[side]], track.shrug)
        world[:, joint] = quaternion_multiply(world[:, parent], lift)
        _place(f"{side}_shoulder", world, positions)
        _place(f"{side}_hip", world, positions)


def _place_arm(track: BodyTrack, side: Side, world: FloatArray, positions: FloatArray) -> None:
    shoulder, elbow, wrist = (
        JOINT_NAMES.index(f"{side}_{n}") for n in ("shoulder", "elbow", "wrist")
    )
    chest = world[:, JOINT_NAMES.index("spine3")]
    forward = quaternion_rotate(chest, [0.0, 0.0, 1.0])
    level = yaw_quaternion(np.arctan2(forward[:, 0], forward[:, 2]))
    mirror = np.array([SIGN[side], 1.0, 1.0])
    target = quaternion_rotate(level, track.wrists[side] * mirror)
    target = clear_of_trunk(positions[:, shoulder] + target, chest, positions)
    if side in track.contacts:
        contact = track.contacts[side]
        target = target + contact.share[:, None] * (contact.position - target)
    pole = quaternion_rotate(level, track.elbows[side] * mirror)
    lengths = np.linalg.norm(BODY.joint_offsets[[elbow, wrist]], axis=1)
    upper, lower, hinge = two_bone_ik(
        target - positions[:, shoulder],
        pole,
        float(lengths[0]),
        float(lengths[1]),
        max_flexion=_ELBOW_FLEXION,
    )
    bone, axis = [SIGN[side], 0.0, 0.0], [0.0, -SIGN[side], 0.0]
    world[:, shoulder] = align_bone(upper, hinge, bone, axis)
    forearm = align_bone(lower, hinge, bone, axis)
    # Forearm bones carry part of the turn of the hand, as in anatomy; skin twists less that way.
    half = axis_angle_quaternion([SIGN[side], 0.0, 0.0], -SIGN[side] * track.palms[side] / 2.0)
    world[:, elbow] = quaternion_multiply(forearm, half)
    world[:, wrist] = quaternion_multiply(world[:, elbow], half)
    if side in track.wrist_bends:
        bend = axis_angle_quaternion([0.0, 0.0, -SIGN[side]], track.wrist_bends[side])
        world[:, wrist] = quaternion_multiply(world[:, wrist], bend)


def _place_leg(track: BodyTrack, side: Side, world: FloatArray, positions: FloatArray) -> None:
    hip, knee, ankle, toe = (
        JOINT_NAMES.index(f"{side}_{n}") for n in ("hip", "knee", "ankle", "foot")
    )
    lengths = np.linalg.norm(BODY.joint_offsets[[knee, ankle]], axis=1)
    feet = track.feet[side]
    toes_forward = quaternion_rotate(yaw_quaternion(feet[:, 0]), [0.0, 0.0, 1.0])
    pole = toes_forward + quaternion_rotate(world[:, 0], [0.0, 0.0, 1.0])
    pole = track.knees.get(side, pole)
    upper, lower, hinge = two_bone_ik(
        track.ankles[side] - positions[:, hip], pole, float(lengths[0]), float(lengths[1])
    )
    world[:, hip] = align_bone(upper, hinge, [0.0, -1.0, 0.0], [1.0, 0.0, 0.0])
    world[:, knee] = align_bone(lower, hinge, [0.0, -1.0, 0.0], [1.0, 0.0, 0.0])
    positions[:, knee] = positions[:, hip] + lengths[0] * upper
    positions[:, ankle] = positions[:, knee] + lengths[1] * lower
    world[:, ankle] = foot_rotation(feet)
    # Toes stay on the floor while the heel lifts.
    flat = np.stack([feet[:, 0], np.minimum(feet[:, 1], 0.0)], axis=1)
    world[:, toe] = foot_rotation(flat)


def _place(name: str, world: FloatArray, positions: FloatArray) -> tuple[int, int]:
    """Puts a joint at its offset in its parent; gives the indices of both."""
    joint = JOINT_NAMES.index(name)
    parent = JOINT_PARENTS[joint]
    turned = quaternion_rotate(world[:, parent], BODY.joint_offsets[joint])
    positions[:, joint] = positions[:, parent] + turned
    return joint, parent


def turn_rotation(turn: FloatArray) -> FloatArray:
    """Rotation `(n, 4)` of `(pitch, yaw, roll)` `(n, 3)`: roll first, then pitch, then yaw."""
    pitch = axis_angle_quaternion([1.0, 0.0, 0.0], turn[:, 0])
    roll = axis_angle_quaternion([0.0, 0.0, 1.0], turn[:, 2])
    return quaternion_multiply(yaw_quaternion(turn[:, 1]), quaternion_multiply(pitch, roll))
