"""Sitting: what people do on a seat in each emotion."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.performances.acting import act, choose
from affectsim_data.builders.performances.places import (
    BELLY,
    BROW,
    CHIN,
    CLAP,
    CLAP_OPEN,
    FIST_HIGH,
    FOLDED_OVER,
    FOLDED_UNDER,
    GUARD,
    HUG_OVER,
    HUG_UNDER,
    KNEE,
    LAP_OVER,
    LAP_UNDER,
    MOUTH,
    OPEN,
    POINT,
    SEAT,
    TALK,
    THIGH,
    THROWN,
    UP,
    WAVE_IN,
    WAVE_OUT,
)
from affectsim_data.builders.performances.rig import BodyTrack
from affectsim_data.builders.performances.scripts import FootStep, Script, Tap, beats, shaken
from affectsim_data.builders.performances.styles import Expression, Performer
from affectsim_data.motions.motion import Emotion

__all__ = ["SEATED", "seated_track"]

_POUNDS = Script(
    5.0,
    {
        "hand": [
            *[(0.0, KNEE), (0.7, KNEE), (1.0, FIST_HIGH), (1.2, KNEE), (1.5, KNEE)],
            *[(1.8, FIST_HIGH), (2.0, KNEE), (2.6, KNEE), (2.95, POINT), (3.2, TALK)],
            *[(3.4, POINT), (3.6, TALK), (3.8, POINT), (4.1, POINT), (4.6, KNEE)],
        ],
        "other": [(0.0, KNEE), (3.0, KNEE)],
    },
    {
        "trunk_pitch": [
            *[(0.0, 16), (0.9, 8), (1.2, 22), (1.5, 17), (1.75, 8), (2.0, 24)],
            *[(2.6, 16), (2.95, 24), (3.2, 20), (3.4, 25), (3.6, 20), (3.8, 25), (4.6, 16)],
        ],
        "trunk_yaw": [(0.0, 0), (2.7, 4), (2.95, -14), (4.1, -12), (4.6, 0)],
        "head_pitch": [(0.0, -6), (1.2, 2), (1.6, -8), (2.0, 2), (2.6, -8), (4.2, -10)],
        "head_yaw": [(2.7, 0), (2.95, 10), (4.1, 8), *beats(4.3, 1, 0.5, -8, 8), (4.9, 0)],
        "shrug": [(0.0, 5)],
    },
    {"hand": (0.07, 0.0, 0.0), "other": (0.07, -0.06, 0.0)},
    steps=[FootStep("other", 1.65, 2.0, lift_m=0.09)],
)
_FUMES = Script(
    5.2,
    {
        "hand": [
            *[(0.0, FOLDED_OVER), (2.3, FOLDED_OVER), (2.65, THROWN), (2.95, THROWN)],
            *[(3.2, KNEE), (3.6, KNEE), (4.2, FOLDED_OVER)],
        ],
        "other": [
            *[(0.0, FOLDED_UNDER), (2.3, FOLDED_UNDER), (2.7, THROWN), (2.95, THROWN)],
            *[(3.25, KNEE), (3.5, KNEE), (4.1, FOLDED_UNDER)],
        ],
    },
    {
        "trunk_pitch": [(0.0, -4), (2.2, -6), (2.6, 6), (3.2, 18), (3.7, 14), (4.3, -4)],
        "trunk_yaw": [(0.0, 6), (2.2, 6), (2.6, 0), (4.0, 0)],
        "head_pitch": [(0.0, 8), (2.4, 6), (2.7, -8), (3.2, 2), (4.2, 8)],
        "head_yaw": [
            *[(0.0, 28), (0.8, 28), (1.05, -12), *beats(1.2, 2, 0.5, -14, 10), (2.3, 0)],
            *[*beats(2.6, 2, 0.5, -10, 10), (4.0, 0), (4.4, 28)],
        ],
        "shrug": [(0.0, 6)],
    },
    {"hand": (0.03, 0.08, 0.0), "other": (0.04, -0.05, 0.0)},
    taps=[Tap("hand", 3.0, -16.0, 0.0, 2.3), Tap("hand", 3.0, -16.0, 3.7, 5.2)],
)
_PERCHES = Script(
    5.8,
    {
        "hand": [
            *[(0.0, LAP_OVER), (0.8, LAP_OVER), (1.3, MOUTH), (3.0, MOUTH), (3.35, LAP_OVER)],
            *[(3.6, LAP_OVER), (3.8, GUARD), (4.3, GUARD), (5.0, LAP_OVER)],
        ],
        "other": [
            *[(0.0, LAP_UNDER), (0.9, LAP_UNDER), (1.5, BELLY), (3.0, BELLY), (3.3, LAP_UNDER)],
            *[(3.6, LAP_UNDER), (3.85, GUARD), (4.2, GUARD), (5.0, LAP_UNDER)],
        ],
    },
    {
        "trunk_pitch": [(0.0, 20), (1.2, 24), (3.6, 20), (3.82, -10), (4.4, -6), (5.1, 20)],
        "trunk_yaw": [(3.6, 0), (3.85, -10), (4.4, -12), (5.1, 0)],
        "head_pitch": [(0.0, -4), (1.4, 4), (3.6, -6), (3.82, 12), (4.4, 6), (5.1, -4)],
        "head_yaw": [(3.6, 0), (3.85, 18), (4.4, 16), (5.1, 0)],
        "shrug": [(0.0, 2), (3.6, 2), (3.8, 10), (4.4, 8), (5.2, 2)],
        "forward": [(0.0, 0.07), (3.6, 0.07), (3.85, 0.0), (4.5, 0.02), (5.2, 0.07)],
    },
    {"hand": (-0.02, -0.16, 22.0), "other": (-0.03, -0.14, 14.0)},
    taps=[Tap("hand", 4.2, 14.0, 0.0, 3.6), Tap("hand", 4.2, 14.0, 4.6, 5.8)],
    glances_deg=48.0,
)
_HUGS = Script(
    5.6,
    {
        "hand": [(0.0, HUG_OVER), (2.6, HUG_OVER), (3.1, MOUTH), (4.2, MOUTH), (4.8, HUG_OVER)],
        "other": [(0.0, HUG_UNDER), (3.0, HUG_UNDER)],
    },
    {
        "trunk_pitch": beats(0.0, 5, 1.12, 18, 27),
        "head_pitch": [*beats(0.1, 5, 1.12, 2, -3)],
        "shrug": [(0.0, 3), (2.6, 5)],
        "forward": [(0.0, 0.04)],
    },
    {"hand": (-0.07, 0.02, 0.0), "other": (-0.14, -0.10, 26.0)},
    taps=[Tap("other", 4.0, 8.0, 0.0, 5.6)],
    glances_deg=40.0,
)
_CHEERS = Script(
    5.2,
    {
        "hand": [
            *[(0.0, THIGH), (0.5, THIGH), (0.95, UP), (1.2, OPEN), (1.5, UP), (1.8, UP)],
            *shaken(2.3, 4, 0.34, CLAP_OPEN, CLAP),
            *[(3.9, THIGH), (4.1, TALK), (4.3, THIGH)],
        ],
        "other": [
            *[(0.0, THIGH), (0.5, THIGH), (1.0, UP), (1.25, OPEN), (1.55, UP), (1.8, UP)],
            *shaken(2.3, 4, 0.34, CLAP_OPEN, CLAP),
            *[(3.9, THIGH), (4.15, TALK), (4.35, THIGH)],
        ],
    },
    {
        "trunk_pitch": [
            *[(0.0, -4), (0.5, 6), (0.95, -12), (1.8, -12), (2.6, 0), (3.9, 8), (4.6, -4)],
        ],
        "trunk_roll": [(0.0, 0), *beats(2.3, 2, 0.8, 7, -7), (4.2, 0)],
        "head_pitch": [(0.0, -6), (0.5, 2), (1.0, -14), (1.8, -12), (2.8, -4), (4.0, 2), (4.6, -8)],
        "head_roll": [*beats(0.0, 3, 1.733, 6, -6)],
        "rise": [(0.4, 0), *beats(0.8, 3, 0.4, 0.035, 0.0), (2.2, 0), (5.0, 0)],
        "kick_hand": [(0.6, 0), (1.0, 1), (1.3, 0.1), (1.6, 1), (2.0, 0), (5.0, 0)],
        "kick_other": [(0.7, 0), (1.3, 1), (1.6, 0.1), (1.9, 1), (2.3, 0), (5.0, 0)],
    },
    {"hand": (0.03, 0.10, 0.0), "other": (0.03, 0.06, 0.0)},
)
_LAUGHS = Script(
    5.2,
    {
        "hand": [
            *[(0.0, SEAT), (0.6, SEAT), *shaken(1.1, 3, 0.42, WAVE_OUT, WAVE_IN), (2.7, OPEN)],
            *[(3.0, THIGH), (3.2, OPEN), (3.45, THIGH), (3.65, OPEN), (3.9, THIGH), (4.6, SEAT)],
        ],
        "other": [(0.0, SEAT), (2.4, SEAT), (2.9, BELLY), (4.0, BELLY), (4.6, SEAT)],
    },
    {
        "trunk_pitch": [
            *[(0.0, -13), (1.0, -10), (2.4, -12), *beats(2.8, 3, 0.42, 16, 7), (4.6, -13)],
        ],
        "trunk_roll": [(0.0, 4), (1.2, 8), (2.4, 4), (3.2, -4), (4.4, 2)],
        "head_pitch": [(0.0, -4), (1.1, -10), (2.3, -16), *beats(2.8, 3, 0.42, 4, -6), (4.6, -4)],
        "head_roll": beats(0.0, 3, 1.733, 7, -7),
        "rise": [(2.6, 0.0), *beats(2.8, 3, 0.42, 0.0, 0.02), (4.2, 0.0)],
    },
    {"hand": (0.03, 0.24, -24.0), "other": (-0.02, 0.20, -20.0)},
    taps=[Tap("hand", 2.0, -14.0, 0.0, 5.2)],
)
_EXPLAINS = Script(
    6.0,
    {
        "hand": [
            *[(0.0, THIGH), (0.7, THIGH), (1.4, TALK), (2.0, OPEN), (2.6, TALK), (3.2, OPEN)],
            *[(4.1, THIGH)],
        ],
        "other": [(0.0, THIGH), (2.0, THIGH), (2.7, LAP_UNDER), (4.2, LAP_UNDER), (5.0, THIGH)],
    },
    {
        "trunk_pitch": [(0.0, 3), (1.6, 6), (3.4, 5), (4.6, 2)],
        "trunk_yaw": [(0.0, 0), (1.8, 4), (3.4, 3), (4.8, -3)],
        "head_pitch": [(0.0, 0), *beats(1.4, 2, 0.9, 0, 5), (3.6, 0), (5.0, 3)],
        "head_yaw": [(0.0, -4), (1.6, 6), (3.6, 4), (4.8, -14), (5.6, -8)],
    },
    {"hand": (0.0, 0.03, 0.0)},
    glances_deg=8.0,
)
_THINKS = Script(
    6.2,
    {
        "hand": [(0.0, LAP_OVER), (0.9, LAP_OVER), (1.8, CHIN), (3.6, CHIN), (4.5, LAP_OVER)],
        "other": [(0.0, LAP_UNDER), (3.0, LAP_UNDER)],
    },
    {
        "trunk_pitch": [(0.0, 2), (1.8, 9), (3.6, 8), (4.6, 2)],
        "trunk_roll": [(0.0, 0), (1.9, 3), (3.6, 3), (4.6, -1)],
        "head_pitch": [(0.0, 2), (1.9, 8), (3.0, 2), (3.7, 5), (4.8, 0)],
        "head_yaw": [(0.0, 8), (1.6, 10), (2.6, -14), (3.6, -10), (4.8, 4)],
    },
    {"other": (-0.01, 0.05, 0.0)},
    glances_deg=8.0,
)
_GRIEVES = Script(
    7.0,
    {
        "hand": [(0.0, THIGH), (1.0, THIGH), (2.3, BROW), (4.6, BROW), (5.8, THIGH)],
        "other": [(0.0, THIGH), (3.0, THIGH)],
    },
    {
        "trunk_pitch": [(0.0, 24), (2.4, 33), (3.4, 31), (4.4, 34), (5.8, 25)],
        "trunk_roll": [(0.0, 0), (2.4, 4), (4.6, 3), (6.0, -1)],
        "head_pitch": [(0.0, 24), (2.4, 30), (3.4, 28), (4.4, 31), (5.8, 25)],
        "head_yaw": [(0.0, 0), (2.8, -4), (3.6, 4), (4.4, -4), (5.6, 0)],
        "shrug": [(2.2, 0), *beats(2.6, 3, 0.6, 0, 4), (5.0, 0)],
    },
    {"hand": (-0.03, -0.06, 0.0), "other": (-0.04, -0.03, 0.0)},
)
_SIGHS = Script(
    7.2,
    {
        "hand": [(0.0, LAP_OVER), (3.0, LAP_OVER), (4.0, MOUTH), (4.6, BROW), (5.8, LAP_OVER)],
        "other": [(0.0, LAP_UNDER), (3.0, LAP_UNDER)],
    },
    {
        "trunk_pitch": [(0.0, 22), (1.2, 15), (2.6, 28), (4.4, 29), (6.0, 23)],
        "trunk_roll": [(0.0, -3), (2.0, 2), (4.4, 3), (6.0, -3)],
        "head_pitch": [(0.0, 22), (1.2, 6), (2.6, 29), (4.4, 27), (6.0, 23)],
        "head_yaw": [(0.0, 10), (1.2, 4), (2.6, -6), (4.6, -4), (6.0, 10)],
        "head_roll": [(0.0, 6), (1.4, 0), (3.0, 7), (6.0, 6)],
        "shrug": [(0.0, 0), (1.1, 7), (2.0, -3), (4.0, 0)],
    },
    {"hand": (-0.06, -0.10, 12.0), "other": (-0.03, -0.04, 0.0)},
)
SEATED: dict[Emotion, tuple[Script, Script]] = {
    "angry": (_POUNDS, _FUMES),
    "fearful": (_PERCHES, _HUGS),
    "happy": (_CHEERS, _LAUGHS),
    "neutral": (_EXPLAINS, _THINKS),
    "sad": (_GRIEVES, _SIGHS),
}
"""Two ways to sit in each emotion; takes alternate."""


def seated_track(
    emotion: Emotion,
    who: Performer,
    *,
    take: int = 0,
    expression: Expression,
    rng: np.random.Generator,
) -> BodyTrack:
    """Sitting on a seat 0.45 m high, the pelvis over the origin.

    Args:
        emotion: What is felt.
        who: The performer.
        take: Which of the ways, beginning with this performer's own.
        expression: How strongly it shows.
        rng: Noise of this take.
    """
    script, plain = choose(SEATED, emotion, who, take, expression)
    return act(script, emotion, who, expression=expression, rng=rng, seated=True, plain=plain)
