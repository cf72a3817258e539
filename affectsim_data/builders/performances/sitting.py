"""Sitting down and getting up again, in each emotion."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.performances.acting import act, choose
from affectsim_data.builders.performances.places import (
    BELLY,
    CLAP,
    CLAP_OPEN,
    FIST_HIGH,
    FOLDED_OVER,
    FOLDED_UNDER,
    HANG,
    HUG_OVER,
    HUG_UNDER,
    KNEE,
    LAP_OVER,
    LAP_UNDER,
    MOUTH,
    OPEN,
    SEAT,
    SWING,
    THIGH,
    UP,
)
from affectsim_data.builders.performances.rig import BodyTrack
from affectsim_data.builders.performances.scripts import FootStep, Script, Tap, beats, shaken
from affectsim_data.builders.performances.styles import Expression, Performer
from affectsim_data.motions.motion import Emotion

__all__ = ["SITTING", "sit_down_track"]

_DROPS_AND_FOLDS = Script(
    5.2,
    {
        "hand": [
            *[(0.0, HANG), (0.5, HANG), (0.8, THIGH), (1.2, THIGH), (1.7, FOLDED_OVER)],
            *[(3.5, FOLDED_OVER), (3.8, FIST_HIGH), (4.0, KNEE), (4.2, KNEE), (4.7, HANG)],
        ],
        "other": [
            *[(0.0, HANG), (0.5, HANG), (0.8, THIGH), (1.2, THIGH), (1.65, FOLDED_UNDER)],
            *[(3.5, FOLDED_UNDER), (3.8, FIST_HIGH), (4.0, KNEE), (4.2, KNEE), (4.7, HANG)],
        ],
    },
    {
        "seated": [(0.45, 0), (0.95, 1), (4.05, 1), (4.5, 0)],
        "trunk_pitch": [
            *[(0.0, 10), (0.5, 14), (1.0, 18), (1.2, -6), (1.7, -2), (3.5, -2), (3.8, -8)],
            *[(4.05, 20), (4.6, 10)],
        ],
        "rise": [(0.9, 0), (1.05, -0.02), (1.2, 0.012), (1.35, 0.0), (4.6, 0.0)],
        "trunk_yaw": [(1.2, 0), (1.8, 8), (3.5, 8), (4.0, 0)],
        "head_pitch": [(0.0, -2), (0.95, 0), (1.15, 14), (1.4, 0), (1.8, 8), (3.5, 6), (4.6, -2)],
        "head_yaw": [
            *[(0.0, -8), (0.9, 0), (1.7, 24), (2.4, 24), *beats(2.6, 2, 0.46, -12, 10), (3.7, 0)],
        ],
        "shrug": [(0.0, 4)],
    },
    {"hand": (0.05, 0.0, 0.0), "other": (0.05, 0.0, 0.0)},
    taps=[Tap("hand", 3.0, -16.0, 1.6, 3.6)],
)
_DROPS_AND_POUNDS = Script(
    5.2,
    {
        "hand": [
            *[(0.0, HANG), (0.5, HANG), (0.9, KNEE), (2.0, KNEE), (2.3, FIST_HIGH), (2.5, KNEE)],
            *[(2.9, KNEE), (3.15, FIST_HIGH), (3.35, KNEE), (4.2, KNEE), (4.7, HANG)],
        ],
        "other": [(0.0, HANG), (0.5, HANG), (0.9, KNEE), (4.2, KNEE), (4.7, HANG)],
    },
    {
        "seated": [(0.45, 0), (0.95, 1), (4.05, 1), (4.5, 0)],
        "trunk_pitch": [
            *[(0.0, 10), (0.5, 14), (1.0, 26), (1.3, 14), (2.1, 16), (2.3, 8), (2.5, 24)],
            *[(2.9, 16), (3.15, 8), (3.35, 25), (4.05, 18), (4.6, 10)],
        ],
        "rise": [(0.9, 0), (1.05, -0.02), (1.2, 0.012), (1.35, 0.0), (4.6, 0.0)],
        "head_pitch": [(0.0, -2), (1.15, 10), (1.5, -8), (2.5, 2), (2.9, -8), (3.35, 2), (3.9, -8)],
        "head_yaw": [(1.2, 0), *beats(1.5, 2, 0.5, -12, 12), (2.6, 0), (4.0, -6)],
        "shrug": [(0.0, 5)],
    },
    {"hand": (0.06, 0.0, 0.0), "other": (0.06, 0.0, 0.0)},
    steps=[FootStep("other", 2.2, 2.52, lift_m=0.08)],
)
_PERCHES = Script(
    6.0,
    {
        "hand": [
            *[(0.0, BELLY), (0.6, BELLY), (2.1, LAP_OVER), (2.9, LAP_OVER), (3.3, MOUTH)],
            *[(4.5, MOUTH), (4.9, BELLY)],
        ],
        "other": [(0.0, HUG_UNDER), (1.2, HUG_UNDER), (2.1, LAP_UNDER), (4.5, LAP_UNDER)],
    },
    {
        "seated": [(0.6, 0), (1.15, 0.45), (1.45, 0.45), (2.0, 0.93), (4.7, 0.93), (5.15, 0)],
        "trunk_pitch": [(0.0, 14), (1.2, 16), (2.2, 20), (3.4, 24), (4.6, 20), (5.3, 12)],
        "trunk_yaw": [(0.0, 0), (0.4, -14), (1.3, -14), (1.9, 0), (4.8, 0)],
        "head_pitch": [(0.0, 0), (0.5, 14), (1.2, 16), (2.0, -4), (3.4, 6), (5.0, -6)],
        "head_yaw": [(0.0, 0), (0.4, -44), (1.3, -44), (1.9, 10), (2.2, 0), (5.0, 0)],
        "shrug": [(0.0, 3), (2.0, 1), (4.7, 6)],
        "forward": [(0.0, 0.0), (1.2, 0.01), (2.0, 0.05), (4.6, 0.05), (5.2, 0.0)],
    },
    {"hand": (-0.03, 0.0, 0.0), "other": (-0.03, 0.0, 0.0)},
    taps=[Tap("hand", 4.2, 12.0, 2.2, 4.5)],
    glances_deg=36.0,
)
_SHRINKS = Script(
    6.2,
    {
        "hand": [
            *[(0.0, HUG_OVER), (0.8, HUG_OVER), (2.2, HUG_OVER), (4.6, HUG_OVER)],
            *[(5.2, HUG_OVER)],
        ],
        "other": [(0.0, HUG_UNDER), (1.0, HUG_UNDER), (1.8, SEAT), (2.3, HUG_UNDER)],
    },
    {
        "seated": [(0.8, 0), (1.4, 0.35), (1.7, 0.3), (2.3, 0.95), (4.9, 0.95), (5.4, 0)],
        "trunk_pitch": [(0.0, 14), (1.4, 14), *beats(2.3, 3, 0.85, 28, 20), (5.0, 20), (5.6, 13)],
        "trunk_yaw": [(0.0, 0), (0.7, 12), (1.4, 12), (2.2, 0), (5.2, 0)],
        "head_pitch": [(0.0, 2), (0.8, 14), (1.5, 12), (2.4, 4), (4.8, -2)],
        "head_yaw": [(0.0, 0), (0.7, 42), (1.5, 40), (2.1, -8), (2.4, 0), (5.0, 0)],
        "shrug": [(0.0, 4)],
        "forward": [(0.0, 0.0), (1.4, 0.01), (2.3, 0.05), (4.8, 0.05), (5.4, 0.0)],
    },
    {"hand": (-0.04, 0.0, 0.0), "other": (-0.04, 0.0, 0.0)},
    taps=[Tap("other", 4.2, 12.0, 2.5, 4.7)],
    glances_deg=40.0,
)
_BOUNCES = Script(
    5.2,
    {
        "hand": [
            *[(0.0, HANG), (0.3, SWING), (0.7, HANG), (1.05, OPEN), (1.4, THIGH), (1.9, THIGH)],
            *[(2.3, UP), (2.6, OPEN), (2.9, UP), (3.4, THIGH), (3.7, THIGH), (4.2, SWING)],
            *[(4.5, UP), (4.8, OPEN)],
        ],
        "other": [
            *[(0.0, HANG), (0.35, SWING), (0.75, HANG), (1.1, OPEN), (1.45, THIGH), (1.9, THIGH)],
            *[(2.35, UP), (2.65, OPEN), (2.95, UP), (3.45, THIGH), (3.7, THIGH), (4.25, SWING)],
            *[(4.55, UP), (4.85, OPEN)],
        ],
    },
    {
        "seated": [(0.0, 0), (0.25, 0.05), (0.5, 0), (0.65, 0), (1.2, 1), (3.7, 1), (4.25, 0)],
        "rise": [(1.1, 0), (1.4, 0.06), (1.62, 0), (1.85, 0.03), (2.05, 0), (4.0, 0)],
        "heels": [(0.3, 0), (0.5, 20), (0.65, 0), (4.1, 0), (4.4, 26), (4.7, 0)],
        "trunk_pitch": [(0.0, -3), (0.9, 4), (1.4, -10), (2.9, -12), (3.6, 4), (4.4, -8)],
        "trunk_roll": [
            *[(0.0, 4), (0.5, -4), (1.2, 0), *beats(1.8, 2, 0.8, 7, -7), (3.8, 0), (4.6, -4)],
        ],
        "head_pitch": [(0.0, -8), (0.8, 0), (1.4, -8), (2.4, -14), (3.2, -8), (3.8, 0), (4.5, -14)],
        "head_roll": beats(0.0, 3, 1.733, 6, -6),
        "kick_hand": [(1.2, 0), (1.45, 0.8), (1.8, 0), (2.4, 0), (2.7, 0.7), (3.1, 0), (3.7, 0)],
        "kick_other": [(1.3, 0), (1.6, 0.8), (1.95, 0), (2.0, 0), (2.35, 0.7), (2.7, 0), (3.7, 0)],
    },
)
_FLOPS_AND_CLAPS = Script(
    5.4,
    {
        "hand": [
            *[(0.0, SWING), (0.5, HANG), (0.9, OPEN), (1.4, SEAT), (2.0, SEAT)],
            *shaken(2.3, 3, 0.34, CLAP_OPEN, CLAP),
            *[(3.6, THIGH), (3.9, THIGH), (4.5, OPEN), (4.9, SWING)],
        ],
        "other": [
            *[(0.0, SWING), (0.5, HANG), (0.95, OPEN), (1.45, SEAT), (2.0, SEAT)],
            *shaken(2.3, 3, 0.34, CLAP_OPEN, CLAP),
            *[(3.6, THIGH), (3.9, THIGH), (4.5, UP), (4.9, SWING)],
        ],
    },
    {
        "seated": [(0.0, 0), (0.55, 0), (1.15, 1), (3.85, 1), (4.4, 0)],
        "rise": [(1.05, 0), (1.35, 0.05), (1.6, 0), (1.8, 0.02), (2.0, 0), (4.3, 0)],
        "heels": [(0.2, 0), (0.45, 16), (0.65, 0), (4.2, 0), (4.5, 22), (4.8, 0), (5.1, 18)],
        "trunk_pitch": [
            *[(0.0, -3), (0.8, 4), (1.4, -14), (2.1, -14), (3.2, -4), (3.7, 8), (4.5, -6)],
        ],
        "trunk_roll": [(0.0, -4), (0.8, 0), *beats(2.3, 2, 0.6, 6, -6), (3.8, 0), (4.7, 4)],
        "head_pitch": [(0.0, -8), (0.9, 2), (1.5, -14), (2.4, -6), (3.7, 0), (4.5, -12)],
        "head_roll": beats(0.2, 3, 1.7, -6, 6),
        "kick_hand": [(1.1, 0), (1.5, 1), (2.0, 0.5), (2.5, 0.8), (3.1, 0.0), (3.8, 0)],
        "kick_other": [(1.2, 0), (1.6, 0.6), (2.0, 1), (2.6, 0.5), (3.2, 0.0), (3.8, 0)],
    },
)
_SITS = Script(
    6.0,
    {
        "hand": [(0.0, HANG), (0.7, HANG), (1.7, THIGH), (4.1, THIGH), (5.2, HANG)],
        "other": [(0.0, HANG), (0.7, HANG), (1.75, THIGH), (4.1, THIGH), (5.25, HANG)],
    },
    {
        "seated": [(0.6, 0), (1.8, 1), (4.2, 1), (5.3, 0)],
        "trunk_pitch": [(0.0, 0), (1.2, 5), (2.1, 1), (3.9, 1), (4.5, 7), (5.4, 0)],
        "head_pitch": [(0.0, 0), (0.7, 7), (1.3, 4), (2.2, 0), (4.2, 2), (5.2, 0)],
        "head_yaw": [(0.0, 0), (0.5, -10), (1.2, -4), (2.4, 10), (3.4, -6), (4.4, 0)],
        "aside": [(0.0, 0.01), (0.6, -0.01), (5.4, -0.005)],
    },
    glances_deg=6.0,
)
_SITS_AND_FOLDS_HANDS = Script(
    6.2,
    {
        "hand": [
            *[(0.0, HANG), (0.7, HANG), (1.7, THIGH), (2.4, LAP_OVER), (4.0, LAP_OVER)],
            *[(4.4, THIGH), (5.4, HANG)],
        ],
        "other": [
            *[(0.0, HANG), (0.7, HANG), (1.7, THIGH), (2.3, LAP_UNDER), (4.0, LAP_UNDER)],
            *[(4.4, THIGH), (5.4, HANG)],
        ],
    },
    {
        "seated": [(0.6, 0), (1.85, 1), (4.4, 1), (5.5, 0)],
        "trunk_pitch": [(0.0, 0), (1.2, 6), (2.2, 0), (4.0, 0), (4.6, 8), (5.6, 0)],
        "head_pitch": [(0.0, 0), (0.7, 6), (1.3, 4), (2.3, 3), (3.4, 0), (4.4, 2), (5.4, 0)],
        "head_yaw": [(0.0, 0), (0.6, 8), (1.4, 2), (2.6, -12), (3.6, 6), (4.6, 0)],
        "aside": [(0.0, -0.01), (0.6, 0.01), (5.6, 0.0)],
    },
    steps=[FootStep("hand", 2.3, 2.75, forward=0.05), FootStep("hand", 3.6, 4.05)],
    glances_deg=6.0,
)
_SINKS = Script(
    8.0,
    {
        "hand": [
            *[(0.0, HANG), (0.6, HANG), (1.6, THIGH), (3.0, THIGH), (3.6, SEAT), (5.2, SEAT)],
            *[(5.9, KNEE), (6.8, KNEE), (7.6, HANG)],
        ],
        "other": [
            *[(0.0, HANG), (0.6, HANG), (1.8, THIGH), (3.2, THIGH), (3.9, SEAT), (5.2, SEAT)],
            *[(5.9, KNEE), (6.8, KNEE), (7.6, HANG)],
        ],
    },
    {
        "seated": [(0.4, 0), (2.5, 1), (5.6, 1), (7.4, 0)],
        "trunk_pitch": [
            *[(0.0, 13), (1.5, 16), (2.8, 20), (3.8, 27), (5.2, 28), (6.0, 24), (7.4, 14)],
        ],
        "trunk_roll": [(0.0, 2), (1.4, -3), (3.0, 2), (6.5, -3)],
        "head_pitch": [(0.0, 20), (1.2, 22), (2.8, 20), (3.8, 32), (5.2, 32), (6.2, 22), (7.4, 20)],
        "head_yaw": [(0.0, 0), (3.0, 6), (4.6, -8), (6.4, 0)],
        "shrug": [(2.4, 0), (2.9, 6), (3.7, -4), (6.0, 0)],
    },
    {"hand": (-0.02, 0.0, 0.0), "other": (-0.02, 0.0, 0.0)},
)
_SINKS_INTO_HANDS = Script(
    8.0,
    {
        "hand": [
            *[(0.0, HANG), (0.6, HANG), (1.8, THIGH), (2.8, THIGH), (3.8, MOUTH), (4.9, MOUTH)],
            *[(5.7, KNEE), (6.7, KNEE), (7.6, HANG)],
        ],
        "other": [
            *[(0.0, HANG), (0.6, HANG), (1.6, SEAT), (2.8, SEAT), (3.5, LAP_UNDER)],
            *[(5.0, LAP_UNDER), (5.7, KNEE), (6.7, KNEE), (7.6, HANG)],
        ],
    },
    {
        "seated": [(0.4, 0), (2.6, 1), (5.6, 1), (7.4, 0)],
        "trunk_pitch": [
            *[(0.0, 13), (1.4, 15), (2.8, 20), (3.8, 30), (4.8, 30), (6.0, 24), (7.4, 14)],
        ],
        "trunk_roll": [(0.0, -2), (1.4, 3), (3.8, 4), (6.5, -2)],
        "head_pitch": [(0.0, 20), (1.2, 22), (2.8, 22), (3.8, 30), (4.8, 30), (6.2, 22), (7.4, 20)],
        "head_yaw": [(0.0, 4), (3.2, -6), (4.2, 4), (4.9, -4), (6.4, 2)],
        "shrug": [(3.4, 0), *beats(3.8, 2, 0.6, 0, 4), (5.4, 0)],
    },
    {"hand": (-0.03, 0.0, 0.0), "other": (-0.02, 0.0, 0.0)},
)
SITTING: dict[Emotion, tuple[Script, Script]] = {
    "angry": (_DROPS_AND_FOLDS, _DROPS_AND_POUNDS),
    "fearful": (_PERCHES, _SHRINKS),
    "happy": (_BOUNCES, _FLOPS_AND_CLAPS),
    "neutral": (_SITS, _SITS_AND_FOLDS_HANDS),
    "sad": (_SINKS, _SINKS_INTO_HANDS),
}
"""Two ways to sit down and get up in each emotion; takes alternate."""


def sit_down_track(
    emotion: Emotion,
    who: Performer,
    *,
    take: int = 0,
    expression: Expression,
    rng: np.random.Generator,
) -> BodyTrack:
    """Sits down on a seat 0.45 m high and 0.40 m behind, stays a moment, and gets up again.

    Args:
        emotion: What is felt.
        who: The performer.
        take: Which of the ways, beginning with this performer's own.
        expression: How strongly it shows.
        rng: Noise of this take.
    """
    script, plain = choose(SITTING, emotion, who, take, expression)
    return act(script, emotion, who, expression=expression, rng=rng, seated=False, plain=plain)
