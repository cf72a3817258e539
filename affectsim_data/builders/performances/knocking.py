"""Knocking on a door, waiting, knocking again, in each emotion."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.performances.acting import act, choose
from affectsim_data.builders.performances.arms import Place
from affectsim_data.builders.performances.places import (
    AKIMBO,
    BELLY,
    CLAP,
    CLAP_OPEN,
    CLASPED_OVER,
    CLASPED_UNDER,
    HANG,
    HUG_UNDER,
    MOUTH,
    OPEN,
    SWING,
    THROWN,
)
from affectsim_data.builders.performances.rig import BodyTrack
from affectsim_data.builders.performances.scripts import ArmKey, FootStep, Script, Tap, beats
from affectsim_data.builders.performances.styles import Expression, Performer
from affectsim_data.motions.motion import Emotion

__all__ = ["DOOR_M", "KNOCKING", "knock_track"]

DOOR_M = 0.65
"""How far ahead of the start the door is."""
_KNUCKLES_M = 0.13
"""From the wrist of a hand that knocks to the door."""
_ELBOW = (0.35, -1.0, 0.15)


def _at_door(height_m: float, away_m: float) -> Place:
    """A wrist in front of the door, the back of the hand to it, fingers up."""
    forward = DOOR_M - _KNUCKLES_M - away_m
    return Place("floor", (0.17, height_m, forward), _ELBOW, 75.0, 22.0)


def _knocks(
    start_s: float,
    count: int,
    every_s: float,
    height_m: float,
    swing_m: float,
    upright_m: float = 0.01,
) -> list[ArmKey]:
    """Back and to the door, `count` times; it begins and ends drawn back.

    A hand that stands upright can come `upright_m` closer with its wrist.
    """
    back = _at_door(height_m + 0.2 * swing_m, swing_m - upright_m)
    at = _at_door(height_m, -upright_m)
    keys = [
        (round(start_s + (index + share) * every_s, 6), place)
        for index in range(count)
        for share, place in ((0.0, back), (0.55, at))
    ]
    return [*keys, (round(start_s + count * every_s, 6), back)]


_POUNDS = Script(
    5.2,
    {
        "hand": [
            *[(0.0, SWING), *_knocks(0.35, 5, 0.27, 1.46, 0.17, 0.055), (2.05, THROWN)],
            *[(2.5, THROWN)],
            *[(2.8, SWING), *_knocks(3.1, 5, 0.25, 1.46, 0.18, 0.055), (4.75, AKIMBO)],
        ],
        "other": [
            *[(0.0, AKIMBO), (1.6, AKIMBO), (2.1, THROWN), (2.5, THROWN), (3.0, HANG)],
            *[(4.4, HANG), (4.8, AKIMBO)],
        ],
    },
    {
        "trunk_pitch": [
            *[(0.0, 8), (0.3, 14), (1.7, 15), (2.1, -4), (2.6, 4), (3.0, 15), (4.4, 16)],
            *[(4.9, 6)],
        ],
        "trunk_yaw": [
            *[*beats(0.3, 5, 0.27, 9, -3), (1.8, 0), (2.8, 0), *beats(3.05, 5, 0.25, 9, -3)],
            *[(4.5, 0)],
        ],
        "head_pitch": [(0.0, -4), (1.0, -2), (2.1, -16), (2.7, -2), (4.4, -2)],
        "head_yaw": [
            *[(0.0, 0), (1.7, 0), *beats(2.0, 2, 0.42, -16, 16), (3.0, 0)],
            *[*beats(4.4, 1, 0.5, -12, 12)],
        ],
        "shrug": [(0.0, 4)],
        "forward": [
            *[(0.0, 0.03), (0.4, 0.03), (1.7, 0.03), (2.1, 0.0), (2.8, 0.03), (3.1, 0.03)],
            *[(4.5, 0.03)],
        ],
    },
    {"hand": (0.04, -0.04, 0.0), "other": (0.04, 0.08, 0.0)},
    steps=[FootStep("other", 2.0, 2.4, lift_m=0.11)],
)
_HAMMERS = Script(
    5.0,
    {
        "hand": [
            *[(0.0, AKIMBO), *_knocks(0.5, 6, 0.24, 1.50, 0.16, 0.055), (2.4, HANG), (2.9, AKIMBO)],
            *[(3.2, AKIMBO), *_knocks(3.5, 4, 0.26, 1.50, 0.18, 0.055), (4.8, AKIMBO)],
        ],
        "other": [(0.0, AKIMBO), (2.0, AKIMBO), (2.35, OPEN), (2.6, HANG), (3.1, AKIMBO)],
    },
    {
        "trunk_pitch": [(0.0, 8), (0.5, 16), (2.0, 16), (2.5, 4), (3.4, 16), (4.6, 16)],
        "trunk_yaw": [
            *[*beats(0.45, 6, 0.24, 8, -3), (2.1, 0), (2.5, -10), (3.2, -8)],
            *[*beats(3.45, 4, 0.26, 9, -3), (4.7, 0)],
        ],
        "head_pitch": [(0.0, -2), (2.0, -2), (2.5, 8), (3.2, 4), (3.6, -4)],
        "head_yaw": [(0.0, 0), (2.0, 0), (2.4, -34), (2.75, -30), (3.1, 12), (3.4, 0)],
        "shrug": [(0.0, 5)],
        "forward": [
            *[(0.0, 0.03), (0.5, 0.03), (2.0, 0.03), (2.5, 0.0), (3.2, 0.02), (3.5, 0.03)],
            *[(4.6, 0.03)],
        ],
        "aside": [(0.0, 0.0), (2.0, 0.0), (2.6, -0.03), (3.2, 0.0)],
    },
    {"hand": (0.05, 0.06, 0.0), "other": (0.04, -0.05, 0.0)},
    taps=[Tap("hand", 3.2, -16.0, 2.3, 3.4)],
)
_DREADS = Script(
    5.8,
    {
        "hand": [
            *[(0.0, BELLY), (0.5, BELLY), (0.9, _at_door(1.33, 0.14))],
            *[*_knocks(1.2, 3, 0.22, 1.33, 0.05, 0.02)],
            *[(2.3, MOUTH), (3.6, MOUTH), *_knocks(4.1, 2, 0.22, 1.33, 0.05, 0.02), (4.95, BELLY)],
        ],
        "other": [(0.0, HUG_UNDER), (2.0, HUG_UNDER)],
    },
    {
        "trunk_pitch": [(0.0, 11), (1.1, 14), (1.9, 13), (2.3, 4), (3.6, 9), (4.2, 14), (4.9, 6)],
        "trunk_yaw": [
            *[(0.0, -6), (1.0, 4), (1.9, 0), (2.4, 16), (3.3, 14), (3.9, 0), (4.6, 0)],
            *[(5.0, -16), (5.5, -14)],
        ],
        "head_pitch": [(0.0, 0), (1.2, 4), (2.2, -6), (3.6, 0), (4.3, 4), (5.0, -6)],
        "head_yaw": [
            *[(0.0, -30), (0.9, 0), (1.9, 0), (2.4, 48), (3.2, 46), (3.8, 0), (4.6, 0)],
            *[(5.0, -50), (5.5, -46)],
        ],
        "shrug": [(0.0, 2), (2.2, 8), (3.0, 3)],
        "forward": [
            *[(0.0, 0.0), (1.0, 0.03), (1.9, 0.02), (2.3, -0.03), (3.5, 0.0), (4.1, 0.03)],
            *[(4.6, 0.02), (5.0, -0.02)],
        ],
    },
    {"hand": (-0.02, 0.03, 0.0), "other": (-0.02, -0.07, 0.0)},
    taps=[Tap("other", 4.0, 8.0, 2.3, 3.7)],
)
_HESITATES = Script(
    6.0,
    {
        "hand": [
            *[(0.0, MOUTH), (0.4, MOUTH), (0.9, _at_door(1.36, 0.10)), (1.2, _at_door(1.36, 0.13))],
            *[(1.6, BELLY), (2.0, BELLY), *_knocks(2.5, 3, 0.21, 1.36, 0.05, 0.02), (3.5, BELLY)],
            *[(4.2, BELLY), *_knocks(4.6, 2, 0.21, 1.36, 0.04, 0.02), (5.4, MOUTH)],
        ],
        "other": [(0.0, HUG_UNDER), (2.0, HUG_UNDER)],
    },
    {
        "trunk_pitch": [
            *[(0.0, 10), (0.9, 15), (1.6, 8), (2.5, 15), (3.2, 13), (3.6, 6), (4.6, 14)],
            *[(5.3, 8)],
        ],
        "trunk_yaw": [
            *[(0.0, 10), (0.7, 0), (1.6, -12), (2.3, 0), (3.3, 0), (3.7, 14), (4.3, 0)],
            *[(5.4, 10)],
        ],
        "head_pitch": [(0.0, 0), (1.0, 4), (1.7, -4), (2.6, 4), (3.6, -6), (4.6, 4)],
        "head_yaw": [
            *[(0.0, 40), (0.5, 36), (0.8, 0), (1.25, 0), (1.6, -46), (2.1, -42), (2.5, 0)],
            *[(3.2, 0), (3.7, 46), (4.2, 40), (4.6, 0), (5.2, 0), (5.6, 40)],
        ],
        "shrug": [(0.0, 3), (1.6, 8), (2.4, 3), (3.6, 7), (4.5, 3)],
        "forward": [
            *[(0.0, 0.0), (0.9, 0.02), (1.6, -0.03), (2.5, 0.02), (3.2, 0.01), (3.6, -0.02)],
            *[(4.6, 0.02), (5.4, 0.0)],
        ],
    },
    {"hand": (-0.03, -0.05, 0.0), "other": (-0.02, 0.03, 0.0)},
)
_RAPS = Script(
    5.0,
    {
        "hand": [
            *[(0.0, SWING), *_knocks(0.5, 2, 0.34, 1.44, 0.10, 0.02)],
            *[*_knocks(1.3, 3, 0.22, 1.44, 0.09, 0.02)],
            *[(2.3, OPEN), (2.7, CLAP), (2.9, CLAP_OPEN), (3.1, CLAP)],
            *[*_knocks(3.5, 2, 0.22, 1.44, 0.10, 0.02), (4.2, SWING)],
        ],
        "other": [
            *[(0.0, HANG), (1.8, SWING), (2.4, OPEN), (2.7, CLAP), (2.9, CLAP_OPEN), (3.1, CLAP)],
            *[(3.6, SWING), (4.3, HANG)],
        ],
    },
    {
        "trunk_pitch": [(0.0, -2), (0.5, 5), (1.9, 4), (2.4, -4), (3.5, 4), (4.3, -4)],
        "trunk_roll": beats(0.0, 5, 1.0, 5, -5),
        "head_pitch": [(0.0, -8), (0.7, -2), (2.0, -4), (2.5, -12), (3.6, -4), (4.3, -10)],
        "head_roll": beats(0.1, 5, 1.0, -7, 7),
        "rise": beats(0.0, 10, 0.5, 0.0, -0.03),
        "heels": [(1.9, 0), *beats(2.1, 3, 0.5, 0, 24), (3.7, 0), (4.2, 0), (4.45, 22), (4.7, 0)],
        "aside": beats(0.0, 5, 1.0, 0.02, -0.02),
        "forward": [(0.0, 0.02), (0.5, 0.03), (1.9, 0.02), (2.4, 0.0), (3.4, 0.03), (4.2, 0.02)],
    },
)
_DRUMS = Script(
    5.2,
    {
        "hand": [
            *[(0.0, HANG), *_knocks(0.5, 5, 0.24, 1.48, 0.09, 0.02), (2.0, SWING)],
            *[(2.5, HANG), (3.0, SWING)],
            *[*_knocks(3.4, 3, 0.24, 1.48, 0.10, 0.02), (4.5, OPEN), (4.8, SWING)],
        ],
        "other": [
            *[(0.0, SWING), (0.6, HANG), (2.0, HANG), (2.4, SWING), (2.9, HANG), (3.4, SWING)],
            *[(4.5, OPEN), (4.8, SWING)],
        ],
    },
    {
        "trunk_pitch": [(0.0, -2), (0.5, 6), (1.8, 5), (2.3, -6), (3.4, 4), (4.4, -5)],
        "trunk_yaw": [(1.8, 0), *beats(2.0, 1, 1.2, 12, -12), (3.4, 0)],
        "trunk_roll": beats(0.0, 4, 1.3, 5, -5),
        "head_pitch": [(0.0, -8), (0.7, -2), (2.2, -12), (3.4, -4), (4.4, -14)],
        "head_roll": beats(0.1, 4, 1.3, -8, 8),
        "rise": beats(0.0, 8, 0.65, 0.0, -0.035),
        "heels": [(0.4, 0), (1.9, 0), *beats(2.1, 2, 0.6, 0, 26), (3.4, 0), (4.4, 24), (4.8, 0)],
        "aside": beats(0.0, 4, 1.3, 0.02, -0.02),
        "forward": [(0.0, 0.02), (0.5, 0.03), (1.8, 0.02), (2.3, -0.01), (3.4, 0.03), (4.4, 0.0)],
    },
)
_KNOCKS = Script(
    5.6,
    {
        "hand": [
            *[(0.0, HANG), (0.3, HANG), *_knocks(1.0, 3, 0.32, 1.40, 0.09), (2.5, HANG)],
            *[(3.2, HANG)],
            *[*_knocks(3.8, 2, 0.32, 1.40, 0.09), (5.0, HANG)],
        ],
        "other": [(0.0, HANG), (2.0, HANG)],
    },
    {
        "trunk_pitch": [(0.0, 0), (0.9, 6), (2.0, 5), (2.6, 0), (3.8, 5), (4.6, 4), (5.1, 0)],
        "head_pitch": [(0.0, 0), (1.2, 2), (2.6, -2), (3.8, 2)],
        "head_yaw": [(0.0, 0), (2.2, 0), (2.7, -14), (3.2, -12), (3.7, 0)],
        "forward": [
            *[(0.0, 0.0), (0.9, 0.02), (2.0, 0.02), (2.6, 0.0), (3.7, 0.02), (4.5, 0.02)],
            *[(5.1, 0.0)],
        ],
        "aside": [(0.0, -0.01), (1.5, 0.015), (2.8, -0.02), (4.0, 0.015)],
    },
    {"hand": (0.0, -0.03, 0.0), "other": (0.0, 0.05, 0.0)},
    hz=3.2,
)
_WAITS = Script(
    5.8,
    {
        "hand": [
            *[(0.0, HANG), (0.3, HANG), *_knocks(0.9, 2, 0.34, 1.42, 0.09)],
            *[(2.2, CLASPED_OVER), (3.2, CLASPED_OVER)],
            *[*_knocks(3.8, 3, 0.32, 1.42, 0.09), (5.2, HANG)],
        ],
        "other": [
            *[(0.0, HANG), (1.7, HANG), (2.3, CLASPED_UNDER), (3.2, CLASPED_UNDER), (4.0, HANG)],
        ],
    },
    {
        "trunk_pitch": [(0.0, 0), (0.8, 6), (1.7, 5), (2.3, 0), (3.7, 5), (4.8, 4), (5.3, 0)],
        "head_pitch": [(0.0, 0), (1.2, 2), (2.4, 6), (3.0, 4), (3.8, 0)],
        "head_yaw": [(0.0, 0), (1.8, 0), (2.3, 12), (3.1, 10), (3.7, 0)],
        "forward": [
            *[(0.0, 0.0), (0.8, 0.02), (1.7, 0.02), (2.3, 0.0), (3.6, 0.02), (4.8, 0.02)],
            *[(5.3, 0.0)],
        ],
        "aside": [(0.0, 0.01), (1.2, -0.015), (2.6, 0.02), (4.2, -0.01)],
    },
    {"hand": (0.0, 0.04, 0.0), "other": (0.0, -0.03, 0.0)},
    hz=3.2,
)
_FAINTLY = Script(
    7.4,
    {
        "hand": [
            *[(0.0, HANG), (0.4, HANG), (1.3, _at_door(1.26, 0.08))],
            *[*_knocks(1.6, 2, 0.62, 1.26, 0.055, -0.01), (3.8, HANG)],
            *[(4.4, HANG), *_knocks(5.3, 1, 0.64, 1.26, 0.055, -0.01), (6.8, HANG)],
        ],
        "other": [(0.0, HANG), (3.0, HANG)],
    },
    {
        "trunk_pitch": [(0.0, 13), (1.4, 15), (2.8, 15), (3.8, 18), (5.4, 16), (6.8, 14)],
        "trunk_roll": [(0.0, 2), (1.6, -3), (3.8, 3), (5.6, -3)],
        "head_pitch": [(0.0, 22), (1.4, 14), (2.6, 16), (3.8, 32), (4.6, 30), (5.4, 18), (6.8, 26)],
        "head_yaw": [(0.0, 0), (2.8, 0), (3.8, -8), (4.8, -6), (5.6, 0)],
        "shrug": [(3.0, 0), (3.5, 6), (4.3, -3), (5.4, 0)],
        "forward": [(0.0, 0.0), (1.3, 0.01), (2.8, 0.0), (3.8, 0.0), (5.2, 0.01), (6.6, 0.0)],
        "aside": [(0.0, 0.02), (1.8, -0.02), (3.8, 0.02), (5.6, -0.02)],
    },
    {"hand": (-0.02, 0.02, 0.0), "other": (-0.02, -0.03, 0.0)},
    hz=1.9,
)
_SAGS = Script(
    7.6,
    {
        "hand": [
            *[(0.0, HANG), (0.5, HANG), *_knocks(1.5, 2, 0.66, 1.24, 0.055, -0.01)],
            *[(3.2, _at_door(1.22, 0.01)), (4.2, _at_door(1.18, 0.01))],
            *[*_knocks(4.7, 1, 0.66, 1.24, 0.05, -0.01), (6.2, HANG)],
        ],
        "other": [(0.0, HANG), (3.0, HANG)],
    },
    {
        "trunk_pitch": [
            *[(0.0, 13), (1.4, 15), (2.9, 16), (3.6, 21), (4.4, 20), (5.4, 15), (6.6, 14)],
        ],
        "trunk_roll": [(0.0, -2), (1.6, 3), (3.6, -3), (5.6, 2)],
        "head_pitch": [(0.0, 24), (1.5, 16), (2.8, 18), (3.6, 34), (4.3, 34), (5.0, 18), (6.4, 28)],
        "head_yaw": [(0.0, 0), (3.0, 2), (3.8, 8), (4.4, -4), (5.4, 0), (6.6, -6)],
        "shrug": [(5.2, 0), (5.7, 6), (6.5, -3)],
        "forward": [(0.0, 0.0), (1.4, 0.01), (3.6, 0.015), (4.8, 0.01), (6.2, 0.0)],
        "aside": [(0.0, -0.02), (1.8, 0.02), (5.6, 0.015)],
    },
    {"hand": (-0.02, -0.02, 0.0), "other": (-0.02, 0.03, 0.0)},
    hz=1.9,
)
KNOCKING: dict[Emotion, tuple[Script, Script]] = {
    "angry": (_POUNDS, _HAMMERS),
    "fearful": (_DREADS, _HESITATES),
    "happy": (_RAPS, _DRUMS),
    "neutral": (_KNOCKS, _WAITS),
    "sad": (_FAINTLY, _SAGS),
}
"""Two ways to knock in each emotion; takes alternate."""


def knock_track(
    emotion: Emotion,
    who: Performer,
    *,
    take: int = 0,
    expression: Expression,
    rng: np.random.Generator,
) -> BodyTrack:
    """Knocks on a door 0.65 m ahead with the preferred hand, waits, and knocks again.

    Args:
        emotion: What is felt.
        who: The performer.
        take: Which of the ways, beginning with this performer's own.
        expression: How strongly it shows.
        rng: Noise of this take.
    """
    script, plain = choose(KNOCKING, emotion, who, take, expression)
    return act(script, emotion, who, expression=expression, rng=rng, seated=False, plain=plain)
