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
from typing import Literal, TypeVar

import numpy as np

from affectsim_data.motions.motion import EMOTIONS, Emotion, emotion_label

__all__ = [
    "GAITS",
    "TEMPO",
    "Expression",
    "KINEMATICS",
    "POSTURES",
    "Gait",
    "Kinematics",
    "Performer",
    "Posture",
    "Quirk",
    "Side",
    "blend",
    "blend_loosely",
    "performer",
    "take_intensity",
]

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
    response_hz: float = 2.2
    """How promptly limbs follow what they are meant to do: anger snaps, sadness drags."""
    breath_hz: float = 0.28
    breath_deg: float = 0.7
    """How far the chest rises with a breath."""


@dataclasses.dataclass(frozen=True)
class Gait:
    """How feet, arms and eyes behave in a walk, beyond what was measured."""

    foot_lift_m: float
    strike_deg: float
    """Toes up as the heel lands."""
    push_deg: float
    """Heel up as the toes leave."""
    unevenness: float
    """Share by which pace and steps vary."""
    snap: float
    """How abruptly arms turn about, 0 to 1."""
    roll_deg: float
    """Sideways swing of the chest with every step."""
    look_deg: float
    """How far the eyes wander from the way."""


_MOOD_SHARE = 0.35
"""Standard deviation of the share of a mood in a take."""
_TEMPOS = (0.75, 1.3)
_LOOSE = 0.35
_RESTRAINED = 0.4
_MOST_RESERVED = 0.3
_Row = TypeVar("_Row", Kinematics, Posture, Gait)

POSTURES: dict[Emotion, Posture] = {
    "angry": Posture(3.6, 11.0, -4.0, 7.0, 0.02, 0.15, 0.004, 0.0, 4.0, 0.5, 1.2),
    "fearful": Posture(4.4, 12.0, 6.0, 16.0, 0.065, 0.09, 0.006, 0.0, 3.6, 0.75, 0.8),
    "happy": Posture(3.2, -3.0, -10.0, 3.0, 0.01, 0.11, 0.0, 0.0, 2.7, 0.38, 0.8),
    "neutral": Posture(4.4, 1.0, 0.0, 0.0, 0.0, 0.10, 0.0, 0.0, 2.8),
    "sad": Posture(6.0, 15.0, 26.0, -9.0, 0.015, 0.085, 0.0, 18.0, 1.4, 0.2, 1.5),
}

TEMPO: dict[Emotion, float] = {
    "angry": 1.3,
    "fearful": 1.15,
    "happy": 1.2,
    "neutral": 1.0,
    "sad": 0.75,
}
"""How fast things are done beside what a neutral person would take for them."""

GAITS: dict[Emotion, Gait] = {
    "angry": Gait(0.050, -20.0, 57.0, 0.03, 0.8, 2.0, 5.0),
    "fearful": Gait(0.050, -4.0, 42.0, 0.16, 0.0, 1.0, 38.0),
    "happy": Gait(0.064, -14.0, 60.0, 0.03, 0.6, 4.5, 12.0),
    "neutral": Gait(0.045, -16.0, 55.0, 0.02, 0.45, 1.5, 7.0),
    "sad": Gait(0.020, -5.0, 34.0, 0.05, 0.6, 3.0, 4.0),
}


@dataclasses.dataclass(frozen=True)
class Quirk:
    """How one person's version of one emotion departs from their habits: an interaction effect."""

    tempo: float = 1.0
    """Factor on speed."""
    reach: float = 1.0
    """Factor on the size of gestures."""
    trunk_pitch_deg: float = 0.0
    """Added lean."""
    head_pitch_deg: float = 0.0
    """Added bow of the head."""
    elbow_flexion_deg: float = 0.0
    """Added bend of hanging arms."""


@dataclasses.dataclass(frozen=True)
class Performer:
    """What one person brings to every emotion alike, and how it bends with each."""

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
    head_pitch_deg: float = 0.0
    """Habitual bow of the head."""
    expressiveness: float = 1.0
    """How strongly emotions show: 1 as in the tables, 0 not at all."""
    reserve: float = 0.0
    """Share of takes in which hardly anything shows."""
    stride: float = 1.0
    """Factor on the length of steps."""
    sway: float = 1.0
    """Factor on sway, weight shifts and wandering looks."""
    bounce: float = 1.0
    """Factor on the rise and fall of the pelvis."""
    asymmetry: float = 0.0
    """Share by which the preferred arm moves more and the other less."""
    elbow_flexion_deg: float = 0.0
    """Habitual bend of hanging arms, added to that of the emotion."""
    hands_out_m: float = 0.0
    """Each hand is carried this much further from the body."""
    shrug_deg: float = 0.0
    """Habitual height of the shoulders."""
    habit: int = 0
    """Which of several ways to do a thing comes first, 0 or more."""
    quirks: tuple[Quirk, ...] = (Quirk(),) * len(EMOTIONS)
    """One for each of `EMOTIONS`."""

    @property
    def other_hand(self) -> Side:
        """The hand that is not preferred."""
        return "left" if self.hand == "right" else "right"

    def feeling(self, emotion: Emotion) -> Performer:
        """The person under an emotion: habits with that emotion's quirk in them, none left over."""
        quirk = self.quirks[emotion_label(emotion)]
        return dataclasses.replace(
            self,
            tempo=self.tempo * quirk.tempo,
            reach=self.reach * quirk.reach,
            trunk_pitch_deg=self.trunk_pitch_deg + quirk.trunk_pitch_deg,
            head_pitch_deg=self.head_pitch_deg + quirk.head_pitch_deg,
            elbow_flexion_deg=self.elbow_flexion_deg + quirk.elbow_flexion_deg,
            quirks=(Quirk(),) * len(EMOTIONS),
        )

    def today(self, rng: np.random.Generator) -> Performer:
        """The person in one take: never quite the same twice, and never of one feeling only.

        A mood, of any of the five emotions, colours tempo, reach and posture a little.
        """
        mood: Emotion = EMOTIONS[int(rng.integers(len(EMOTIONS)))]
        share = _MOOD_SHARE * abs(_spread(rng, 1.0))
        calm, tinge = POSTURES["neutral"], POSTURES[mood]
        tempo = self.tempo * TEMPO[mood] ** share * (1.0 + _spread(rng, 0.04))
        return dataclasses.replace(
            self,
            tempo=float(np.clip(tempo, *_TEMPOS)),
            reach=self.reach * (1.0 + _spread(rng, 0.05)),
            trunk_pitch_deg=self.trunk_pitch_deg
            + share * (tinge.trunk_pitch_deg - calm.trunk_pitch_deg)
            + _spread(rng, 1.5),
            head_pitch_deg=self.head_pitch_deg
            + share * (tinge.head_pitch_deg - calm.head_pitch_deg)
            + _spread(rng, 2.0),
            shrug_deg=self.shrug_deg + share * (tinge.shrug_deg - calm.shrug_deg),
            elbow_flexion_deg=self.elbow_flexion_deg + _spread(rng, 3.0),
            hands_out_m=self.hands_out_m + _spread(rng, 0.01),
            bounce=self.bounce * (1.0 + _spread(rng, 0.1)),
        )


@dataclasses.dataclass(frozen=True)
class Expression:
    """How strongly an emotion shows in each of its channels: 1 as in the tables, 0 not at all."""

    posture: float
    pace: float
    size: float
    """Of gestures and swings."""
    snap: float
    """How abruptly limbs move, and how they tremble."""
    loose: float = 0.0
    """How much every single trait departs from its channel, as a standard deviation."""

    @property
    def restrained(self) -> bool:
        """Whether people do the everyday thing, only in the manner of what they feel."""
        return self.size < _RESTRAINED

    @classmethod
    def even(cls, intensity: float) -> Expression:
        """The same in every channel."""
        return cls(intensity, intensity, intensity, intensity)

    @classmethod
    def drawn(cls, intensity: float, rng: np.random.Generator) -> Expression:
        """More in one channel than in another, as it falls out in a take."""
        shares = [max(1.0 + _spread(rng, 0.22), 0.0) for _ in range(4)]
        posture, pace, size, snap = (intensity * share for share in shares)
        return cls(posture, pace, size, snap, _LOOSE)


def performer(performer_id: str) -> Performer:
    """The traits of a performer: the same for every emotion and every run, drawn from the id.

    Spreads are set so that people differ, over all descriptors, by 30 to 50 % of what emotions
    differ by.
    """
    digest = hashlib.sha256(f"performer:{performer_id}".encode()).digest()
    rng = np.random.default_rng(int.from_bytes(digest[:8], "little"))
    return Performer(
        performer_id=performer_id,
        tempo=1.0 + _spread(rng, 0.13),
        reach=1.0 + _spread(rng, 0.13),
        hand="left" if rng.random() < 0.3 else "right",
        trunk_pitch_deg=_spread(rng, 3.5),
        elbow_out=0.4 + _spread(rng, 0.19),
        stance=1.1 + _spread(rng, 0.14),
        raise_m=_spread(rng, 0.03),
        head_pitch_deg=_spread(rng, 6.0),
        expressiveness=1.0 + _spread(rng, 0.13),
        reserve=float(rng.uniform(0.16, 0.36)),
        stride=1.0 + _spread(rng, 0.08),
        sway=1.0 + _spread(rng, 0.35),
        bounce=1.0 + _spread(rng, 0.25),
        asymmetry=_spread(rng, 0.18),
        elbow_flexion_deg=_spread(rng, 8.0),
        hands_out_m=_spread(rng, 0.03),
        shrug_deg=_spread(rng, 3.0),
        habit=int(rng.integers(1 << 16)),
        quirks=tuple(_quirk(rng) for _ in EMOTIONS),
    )


def take_intensity(
    who: Performer, rng: np.random.Generator, *, reserved_takes: float = 1.0
) -> float:
    """How strongly an emotion shows in one take: 1 as in the tables, 0 as neutral.

    Most takes are near the performer's expressiveness; in some people keep it to themselves.

    Args:
        who: The performer.
        rng: What falls out in this take.
        reserved_takes: Factor on how often they do; 0 for never.
    """
    reserved = rng.random() < reserved_takes * who.reserve
    least = rng.uniform(0.0, _MOST_RESERVED)
    return who.expressiveness * (least if reserved else 1.0 + _spread(rng, 0.12))


def blend(row: _Row, neutral: _Row, intensity: float) -> _Row:
    """A row of a table shown at an intensity: 0 gives `neutral`, 1 `row`, above 1 exaggerates.

    Examples:
        >>> blend(POSTURES["sad"], POSTURES["neutral"], 0.5).cycle_s
        5.2
    """
    mixed = {
        field.name: getattr(neutral, field.name)
        + intensity * (getattr(row, field.name) - getattr(neutral, field.name))
        for field in dataclasses.fields(row)
    }
    return type(row)(**mixed)


def blend_loosely(
    row: _Row, neutral: _Row, intensity: float, loose: float, rng: np.random.Generator
) -> _Row:
    """`blend`, but every column at an intensity of its own.

    Args:
        row: The row of an emotion.
        neutral: The row of none.
        intensity: Mean over the columns.
        loose: Standard deviation of a column's intensity, as a share of the mean.
        rng: How they fall.
    """
    mixed = {}
    for field in dataclasses.fields(row):
        calm, full = getattr(neutral, field.name), getattr(row, field.name)
        mixed[field.name] = calm + intensity * (1.0 + _spread(rng, loose)) * (full - calm)
    return type(row)(**mixed)


def _quirk(rng: np.random.Generator) -> Quirk:
    return Quirk(
        tempo=1.0 + _spread(rng, 0.04),
        reach=1.0 + _spread(rng, 0.05),
        trunk_pitch_deg=_spread(rng, 1.5),
        head_pitch_deg=_spread(rng, 2.5),
        elbow_flexion_deg=_spread(rng, 3.0),
    )


def _spread(rng: np.random.Generator, deviation: float) -> float:
    """A normal draw around 0 that stays within two standard deviations."""
    return float(np.clip(rng.normal(), -2.0, 2.0)) * deviation
