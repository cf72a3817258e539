"""How an emotion and a performer shape movement: tables of numbers, no motion.

`KINEMATICS` holds effects measured on acted walks and gestures (Bandai-Namco Research motion
data sets, two clips a style; fearful is their `not-confident`, the nearest style there). Directions
agree with Roether et al. 2009, Barliya et al. 2013 and Halovic & Kroos 2018. `POSTURES` adds what a
walk does not show, from the same literature: head and shoulders sink in sadness, the body shrinks
in fear, opens in joy, leans in and stiffens in anger.
"""

from __future__ import annotations

import dataclasses
import hashlib
from typing import Literal

import numpy as np

from affectsim_data.motions.motion import Emotion

__all__ = ["KINEMATICS", "POSTURES", "Kinematics", "Performer", "Posture", "Side", "performer"]

Side = Literal["left", "right"]


@dataclasses.dataclass(frozen=True)
class Kinematics:
    """What was measured on walks."""

    cadence_steps_min: float
    stride_m: float
    """Distance of two steps."""
    bounce_m: float
    """Height the pelvis rises and falls."""
    elbow_flexion_deg: float
    hand_swing_m: float
    """Fore and aft way of a wrist relative to the body."""
    trunk_pitch_deg: float
    """Positive forward."""
    neck_pitch_deg: float
    """Positive down."""
    hand_span: float
    """Distance between the wrists as a share of stature."""


KINEMATICS: dict[Emotion, Kinematics] = {
    "angry": Kinematics(128.0, 1.34, 0.039, 43.0, 0.47, 9.9, 10.8, 0.36),
    "fearful": Kinematics(127.0, 0.85, 0.020, 73.0, 0.04, 13.8, 26.9, 0.05),
    "happy": Kinematics(126.0, 1.34, 0.103, 64.0, 0.46, 4.4, -9.2, 0.37),
    "neutral": Kinematics(111.0, 1.35, 0.034, 20.0, 0.41, -0.3, -5.0, 0.37),
    "sad": Kinematics(101.0, 0.73, 0.012, 16.0, 0.13, 3.3, 4.0, 0.26),
}


@dataclasses.dataclass(frozen=True)
class Posture:
    """How someone holds the body where they stand or sit."""

    cycle_s: float
    """Length of one cycle of gestures."""
    trunk_pitch_deg: float
    head_pitch_deg: float
    shrug_deg: float
    """Collar bones raised; negative drops the shoulders."""
    crouch_m: float
    """Pelvis below standing height."""
    stance_m: float
    """Half distance of the feet."""
    tremor_m: float
    """Of the hands."""
    head_bow_deg: float = 0.0
    """Added to the head of a walk: the sad bow far deeper than the table's neck says."""


POSTURES: dict[Emotion, Posture] = {
    "angry": Posture(3.6, 11.0, -4.0, 7.0, 0.02, 0.15, 0.004),
    "fearful": Posture(4.4, 12.0, 6.0, 16.0, 0.09, 0.09, 0.008),
    "happy": Posture(3.2, -3.0, -10.0, 3.0, 0.01, 0.11, 0.0),
    "neutral": Posture(4.4, 1.0, 0.0, 0.0, 0.0, 0.10, 0.0),
    "sad": Posture(6.0, 15.0, 26.0, -9.0, 0.015, 0.085, 0.0, head_bow_deg=16.0),
}


@dataclasses.dataclass(frozen=True)
class Performer:
    """What one person brings to every emotion alike."""

    performer_id: str
    tempo: float
    """Factor on speed."""
    reach: float
    """Factor on the size of gestures."""
    hand: Side
    """The preferred one."""
    trunk_pitch_deg: float
    """Habitual lean."""
    elbow_out: float
    """How far elbows are held from the body, 0 to 1."""
    stance: float
    """Factor on the width of the stance."""
    raise_m: float
    """Gestures are this much higher."""

    @property
    def other_hand(self) -> Side:
        """The hand that is not preferred."""
        return "left" if self.hand == "right" else "right"


def performer(performer_id: str) -> Performer:
    """The traits of a performer: the same for every emotion and every run, drawn from the id."""
    digest = hashlib.sha256(f"performer:{performer_id}".encode()).digest()
    rng = np.random.default_rng(int.from_bytes(digest[:8], "little"))
    return Performer(
        performer_id=performer_id,
        tempo=float(rng.uniform(0.92, 1.08)),
        reach=float(rng.uniform(0.9, 1.08)),
        hand="left" if rng.random() < 0.3 else "right",
        trunk_pitch_deg=float(rng.uniform(-2.5, 2.5)),
        elbow_out=float(rng.uniform(0.1, 0.6)),
        stance=float(rng.uniform(0.9, 1.2)),
        raise_m=float(rng.uniform(-0.03, 0.03)),
    )
