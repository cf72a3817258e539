"""The upper body of a performance: trunk, head, shoulders, and arms that find their landmarks."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.performances.curves import FPS, noise, wave
from affectsim_data.builders.performances.rig import BodyTrack, body_frames
from affectsim_data.builders.performances.scenarios.arms import Landmark, arm_path
from affectsim_data.builders.performances.scenarios.stage import Stage
from affectsim_data.builders.performances.scenarios.vocabulary import ARMS, Anchor, Arm, Channel
from affectsim_data.poses import FloatArray, quaternion_rotate, yaw_quaternion
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["place_arms", "upper_body"]

_HEAD_MOST = np.deg2rad([48.0, 72.0, 30.0])
"""Pitch, yaw and roll that a neck comes near to but does not reach."""
_GAZE_LEAD_S = 0.10
"""The face turns before the trunk does."""
_HIP_SHARES = np.array([0.3, 0.25, 0.0])
"""Pitch, yaw and roll of the trunk that come from the hips."""
_DEEP_BEND = np.deg2rad(20.0)
_SHAKES: dict[Arm, tuple[Channel, ...]] = {
    "hand": ("hand_out", "hand_up", "hand_forward", "hand_palm", "hand_bend"),
    "other": ("other_out", "other_up", "other_forward", "other_palm", "other_bend"),
}


def upper_body(stage: Stage, track: BodyTrack) -> None:
    """Turns trunk and head, raises the shoulders; the hips follow the trunk, and balance it."""
    trunk, look, shrug = _turns(stage)
    mirror = np.array([1.0, stage.sign, -stage.sign])
    trunk, look = (stage.smooth(np.deg2rad(turn) * mirror) for turn in (trunk, look))
    track.shrug = stage.smooth(np.deg2rad(shrug))
    # Deep bends come from the hips more than shallow ones, and the hips go back under them.
    hips = _HIP_SHARES * trunk
    hips[:, 0] += 0.35 * np.maximum(trunk[:, 0] - _DEEP_BEND, 0.0)
    track.trunk_turn = trunk - hips
    track.trunk_turn[:, 2] -= track.pelvis_turn[:, 2]
    back = np.zeros_like(trunk)
    back[:, 2] = -0.16 * np.sin(trunk[:, 0])
    track.pelvis_position += quaternion_rotate(yaw_quaternion(track.pelvis_turn[:, 1]), back)
    track.pelvis_turn += hips
    track.head_turn = _HEAD_MOST * np.tanh(1.05 * (look - trunk) / _HEAD_MOST)


def place_arms(stage: Stage, track: BodyTrack) -> None:
    """Leads both arms through their poses, on the body that the rest of the track makes."""
    rotations, positions = body_frames(track)
    forward = quaternion_rotate(rotations[:, JOINT_NAMES.index("spine3")], [0.0, 0.0, 1.0])
    level = yaw_quaternion(np.arctan2(forward[:, 0], forward[:, 2]))
    for arm in ARMS:
        side = stage.side(arm)
        names: dict[Anchor, str] = {
            "shoulder": f"{side}_shoulder",
            "chest": "spine3",
            "head": "head",
            "pelvis": "pelvis",
            "thigh": f"{side}_hip",
        }
        landmarks = {
            anchor: Landmark(
                positions[:, JOINT_NAMES.index(name)],
                level if anchor == "shoulder" else rotations[:, JOINT_NAMES.index(name)],
            )
            for anchor, name in names.items()
        }
        _place_arm(stage, track, arm, landmarks)


def _turns(stage: Stage) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Trunk `(n, 3)`, gaze `(n, 3)` and shoulders `(n,)`, degrees, to the preferred side."""
    posture, who, phase, script = stage.posture, stage.who, stage.phase, stage.script
    breaths = max(round(stage.manner.breath_hz * len(phase) / FPS), 1)
    breath = stage.manner.breath_deg * wave(phase, breaths)
    trunk = stage.amount * stage.curve(script.trunk)
    trunk += stage.shaken("trunk_pitch", "trunk_yaw", "trunk_roll")
    look = stage.amount * stage.curve(script.look, lead_s=_GAZE_LEAD_S)
    look += stage.shaken("look_pitch", "look_yaw", "look_roll")
    for axis in range(3):
        trunk[:, axis] += noise(phase, amplitude=who.sway, rng=stage.rng)
        look[:, axis] += noise(phase, amplitude=1.5 * who.sway, rng=stage.rng)
    lean = posture.trunk_pitch_deg + who.trunk_pitch_deg
    trunk[:, 0] += lean - breath
    look[:, 0] += lean + posture.head_pitch_deg + who.head_pitch_deg
    shrug = stage.amount * stage.curve(script.shrug) + stage.shaken("shrug")[:, 0]
    return trunk, look, shrug + posture.shrug_deg + who.shrug_deg + breath


def _place_arm(stage: Stage, track: BodyTrack, arm: Arm, landmarks: dict[Anchor, Landmark]) -> None:
    side = stage.side(arm)
    uneven = 0.5 * stage.who.asymmetry * (1.0 if arm == "hand" else -1.0)
    path = arm_path(
        stage.script.hand if arm == "hand" else stage.script.other,
        stage.time_s,
        stage.script.duration_s,
        side,
        landmarks,
        stage.who,
        size=stage.size * (1.0 + uneven),
        rng=stage.rng,
    )
    shaken = stage.shaken(*_SHAKES[arm])
    tremor = noise(
        stage.phase,
        amplitude=0.3 * stage.posture.tremor_m,
        rng=stage.rng,
        slowest=max(len(shaken) // 10, 1),
    )
    track.wrists[side] = stage.smooth(path.wrist + shaken[:, :3])
    track.wrists[side] += tremor[:, None] * np.array([0.5, 1.0, 0.5])
    track.elbows[side] = stage.smooth(path.elbow)
    track.palms[side] = stage.smooth(path.palm) + np.deg2rad(shaken[:, 3])
    track.wrist_bends[side] = stage.smooth(path.bend) + np.deg2rad(shaken[:, 4])
