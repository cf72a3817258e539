"""Two tracks brought together in space: palms that meet, hands that touch, faces turned to faces.

The stage is the target's frame. Contacts are solved for the palm, which lies beyond the wrist that
inverse kinematics places, so the wrist is moved until the palm is where it should be.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.ndimage import gaussian_filter1d

from affectsim_data.builders.performances.curves import curve, keyframes
from affectsim_data.builders.performances.dyads.interaction import (
    Clasp,
    Interaction,
    Look,
    Share,
    Spot,
    Touch,
)
from affectsim_data.builders.performances.rig import SIGN, BodyTrack, Contact, solve_body
from affectsim_data.builders.performances.scenarios.vocabulary import Arm
from affectsim_data.builders.performances.styles import Side
from affectsim_data.poses import (
    FloatArray,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
    yaw_quaternion,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES

__all__ = ["PALM", "Actor", "meet"]

PALM = np.array([0.085, -0.02, 0.0])
"""Skin of the left palm in the wrist's joint, metres; the right one is its mirror image."""
_EYES = np.array([0.0, 0.07, 0.0])
"""In the head's joint."""
_ROUNDS, _CLOSE_M = 8, 5e-4
_SLOW_FRAMES, _TURN_FRAMES = 8.0, 2.5
"""Nods are faster than the one, turns of the head no faster than the other."""
_YAW_MAX, _PITCH_MIN, _PITCH_MAX = np.deg2rad([68.0, -32.0, 48.0])
_HEAD, _CHEST = JOINT_NAMES.index("head"), JOINT_NAMES.index("spine3")
_Pose = tuple[FloatArray, FloatArray]


@dataclasses.dataclass
class Actor:
    """A track at its place on the stage."""

    track: BodyTrack
    hand: Side
    """The preferred one."""
    x: float = 0.0
    z: float = 0.0
    yaw: float = 0.0
    """Radians; 0 looks as the target does at the start."""

    def side(self, arm: Arm) -> Side:
        """Left or right of the preferred or the other arm."""
        return self.hand if arm == "hand" else "right" if self.hand == "left" else "left"

    def pose(self) -> _Pose:
        """Joints on the stage: positions `(n, 22, 3)` and rotations `(n, 22, 4)`."""
        positions, rotations = BODY.forward_kinematics(*solve_body(self.track))
        turn = yaw_quaternion(self.yaw)
        place = np.array([self.x, 0.0, self.z])
        return quaternion_rotate(turn, positions) + place, quaternion_multiply(turn, rotations)

    def from_stage(self, points: FloatArray) -> FloatArray:
        """Points of the stage `(n, 3)` in the actor's own frame."""
        return quaternion_rotate(yaw_quaternion(-self.yaw), points - [self.x, 0.0, self.z])


@dataclasses.dataclass(frozen=True)
class _Hold:
    """A palm that is to be at a place."""

    actor: Actor
    side: Side
    place: FloatArray
    """On the stage, metres, `(n, 3)`."""
    share: FloatArray
    """How far it is to be there, `(n,)`."""


def meet(interaction: Interaction, target: Actor, partner: Actor, phase: FloatArray) -> None:
    """Writes looks and contacts into both tracks; `phase` is that of each frame, `(n,)`."""
    mine, others = target.pose(), partner.pose()
    for looks, actor, own, other, seen in (
        (interaction.target.looks, target, mine, partner, others),
        (interaction.partner.looks, partner, others, target, mine),
    ):
        for look in looks:
            share = _share(look.share, phase, interaction)
            _turn_head(actor, own, _seen(look, other, seen, target), share)
    clasped = []
    for clasp in interaction.clasps:
        place = _way(clasp, phase, interaction, target)
        share = _share(clasp.share, phase, interaction)
        clasped.append(_Hold(target, target.side(clasp.target_arm), place, share))
        clasped.append(_Hold(partner, partner.side(clasp.partner_arm), place, share))
    _solve(clasped)
    # Clasps move what is touched.
    touching = []
    for touch in interaction.touches:
        by, on = (target, partner) if touch.by == "target" else (partner, target)
        share = _share(touch.share, phase, interaction)
        touching.append(_Hold(by, by.side(touch.arm), _skin(touch, on), share))
    _solve(touching)


def _share(keys: Share, phase: FloatArray, interaction: Interaction) -> FloatArray:
    duration_s = interaction.target.script.duration_s
    return curve(phase, [at / duration_s for at, _ in keys], [share for _, share in keys])


def _way(clasp: Clasp, phase: FloatArray, interaction: Interaction, target: Actor) -> FloatArray:
    """Where palms meet, `(n, 3)` on the stage."""
    duration_s = interaction.target.script.duration_s
    return keyframes(phase, [(at / duration_s, _point(spot, target)) for at, spot in clasp.way])


def _point(spot: Spot, target: Actor) -> FloatArray:
    return np.array([SIGN[target.hand] * spot.side, spot.up, spot.forward])


def _skin(touch: Touch, actor: Actor) -> FloatArray:
    """The touched place over time, `(n, 3)` on the stage."""
    side = actor.side(touch.of)
    joint = JOINT_NAMES.index(f"{side}_{touch.limb}")
    positions, rotations = actor.pose()
    offset = np.array(touch.place) * [SIGN[side], 1.0, 1.0]
    return positions[:, joint] + quaternion_rotate(rotations[:, joint], offset)


def _solve(holds: Sequence[_Hold]) -> None:
    """Adds the contacts that bring palms to their places, by moving wrists until they are there."""
    for actor in {id(hold.actor): hold.actor for hold in holds}.values():
        mine = [(hold, actor.from_stage(hold.place)) for hold in holds if hold.actor is actor]
        for hold, palm in mine:
            actor.track.contacts[hold.side] = Contact(palm, hold.share)
        for _ in range(_ROUNDS):
            _, rotations = BODY.forward_kinematics(*solve_body(actor.track))
            moved = 0.0
            for hold, palm in mine:
                wrist = rotations[:, JOINT_NAMES.index(f"{hold.side}_wrist")]
                contact = actor.track.contacts[hold.side]
                position = palm - quaternion_rotate(wrist, PALM * [SIGN[hold.side], 1.0, 1.0])
                step = np.linalg.norm(position - contact.position, axis=1)
                moved = max(moved, float((hold.share * step).max()))
                contact.position = position
            if moved < _CLOSE_M:
                break


def _seen(look: Look, other: Actor, pose: _Pose, target: Actor) -> FloatArray:
    """What is looked at, on the stage, `(n, 3)`."""
    positions, rotations = pose
    if isinstance(look.at, Spot):
        return np.tile(_point(look.at, target), (len(positions), 1))
    if look.at == "partner":
        return positions[:, _HEAD] + quaternion_rotate(rotations[:, _HEAD], _EYES)
    return positions[:, JOINT_NAMES.index(f"{other.side(look.at)}_wrist")]


def _turn_head(actor: Actor, pose: _Pose, goal: FloatArray, share: FloatArray) -> None:
    """Turns the face towards a goal `(n, 3)`; what the head does faster than a turn stays."""
    positions, rotations = pose
    eyes = positions[:, _HEAD] + quaternion_rotate(rotations[:, _HEAD], _EYES)
    chest = quaternion_conjugate(rotations[:, _CHEST])
    wanted = _angles(quaternion_rotate(chest, goal - eyes))
    wanted = np.clip(wanted, [_PITCH_MIN, -_YAW_MAX], [_PITCH_MAX, _YAW_MAX])
    wanted = gaussian_filter1d(wanted, _TURN_FRAMES, axis=0, mode="wrap")
    ahead = quaternion_rotate(rotations[:, _HEAD], np.array([0.0, 0.0, 1.0]))
    now = gaussian_filter1d(
        _angles(quaternion_rotate(chest, ahead)), _SLOW_FRAMES, axis=0, mode="wrap"
    )
    actor.track.head_turn[:, :2] += share[:, None] * (wanted - now)


def _angles(ways: FloatArray) -> FloatArray:
    """Pitch and yaw, `(n, 2)`, of directions `(n, 3)`."""
    level = np.hypot(ways[:, 0], ways[:, 2])
    return np.stack([np.arctan2(-ways[:, 1], level), np.arctan2(ways[:, 0], ways[:, 2])], axis=1)
