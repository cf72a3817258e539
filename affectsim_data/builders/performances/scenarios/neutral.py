"""Nothing in particular, standing: upright, easy, even; what people do while they wait or talk."""

from __future__ import annotations

from affectsim_data.builders.performances.scenarios.vocabulary import (
    AKIMBO,
    BROW,
    FOLDED_UNDER,
    HANGING,
    NAPE,
    TALK,
    ArmPose,
    Move,
    Script,
    Shake,
    keys,
)

__all__ = ["SCRIPTS"]

_WATCH = ArmPose((-0.08, -0.14, 0.32), (0.9, -0.7, -0.3), palm_deg=-50.0)
"""The wrist turned up before the breast, to read the time."""
_SLEEVE = ArmPose((-0.01, 0.04, 0.30), (0.73, -0.97, 0.0), 10.0, 20.0, "chest")
"""Hand on the other forearm."""
_FOREARM = ArmPose((-0.01, -0.10, 0.19), (0.8, -0.9, -0.1), 0.0, 0.0, "chest")
_LIFT = ArmPose((0.14, 0.02, 0.24), (1.0, -0.4, 0.0))
"""On the way from below to above the shoulder, before the body."""
_BESIDE = ArmPose((0.28, 0.06, -0.03), (1.0, -0.1, 0.4), 10.0, -25.0, "head")
"""On the way behind the head."""
_SHOW = ArmPose((0.34, 0.0, 0.32), (0.5, -1.0, -0.2), palm_deg=40.0)
"""Arm out to the side and forward, pointing the way with an open hand."""


_EXPLAIN_LIFT = TALK.moved(out=0.06, up=0.05, forward=0.03)
_EXPLAIN = Script(
    duration_s=6.66,
    plain_s=6.66,
    hand=(
        (0.0, HANGING),
        (0.45, HANGING),
        (1.08, TALK),
        (1.44, _EXPLAIN_LIFT),
        (1.89, TALK.moved(up=-0.02)),
        (2.34, _EXPLAIN_LIFT.moved(out=0.04)),
        (2.97, TALK),
        (3.51, _EXPLAIN_LIFT.moved(out=0.08)),
        (4.05, _EXPLAIN_LIFT.moved(out=0.09, up=-0.02)),
        (4.59, TALK),
        (5.49, HANGING),
    ),
    other=(
        (0.0, HANGING),
        (2.61, HANGING),
        (3.06, TALK.moved(up=-0.02)),
        (3.56, _EXPLAIN_LIFT.moved(out=0.08, up=-0.02)),
        (4.05, _EXPLAIN_LIFT.moved(out=0.10, up=-0.04)),
        (4.68, TALK.moved(up=-0.04)),
        (5.67, HANGING),
    ),
    trunk=keys(
        (0, 1.35, 2.43, 3.6, 4.86),
        (0, 1, 1, 3, 0),
        (0, -5, 6, 0, -3),
        (0, 0, 0, 0, 0),
    ),
    look=keys(
        (0, 1.26, 2.34, 3.06, 3.69, 4.14, 5.04, 5.76),
        (0, 2, 0, 2, 5, 0, 4, 0),
        (0, -6, 14, 4, 0, -2, -16, 0),
        (0, 0, 3, 0, -3, 0, 0, 0),
    ),
    pelvis=keys(
        (0, 2.16, 3.24, 5.31),
        (0.035, 0.03, -0.035, -0.03),
        (-0.004, -0.004, -0.004, -0.004),
        (0, 0, 0, 0),
    ),
    moves=(
        Move("hand", 2.48, 2.93, forward=0.10, side=0.03, heading_deg=6.0, lift_m=0.015),
        Move("hand", 5.71, 6.17, lift_m=0.015),
    ),
    shakes=(
        Shake("hand_up", 0.022, 1.5, 1.08, 4.77),
        Shake("hand_palm", 10.0, 1.5, 1.08, 4.77, shift=0.1),
        Shake("other_up", 0.018, 1.5, 3.06, 4.77, shift=0.1),
        Shake("look_pitch", 1.5, 1.5, 1.08, 4.77, shift=0.1),
    ),
)
"""Quiet talk: one hand lifts, palm up, then both; the weight goes to the other foot."""


_WAIT = Script(
    duration_s=7.02,
    plain_s=7.02,
    hand=(
        (0.0, HANGING),
        (1.26, HANGING),
        (1.89, FOLDED_UNDER.moved(up=-0.07)),
        (2.43, FOLDED_UNDER.moved(up=-0.07)),
        (3.69, FOLDED_UNDER.moved(up=-0.07)),
        (4.41, AKIMBO),
        (6.03, AKIMBO),
        (6.66, HANGING),
    ),
    other=(
        (0.0, HANGING),
        (1.17, HANGING),
        (1.8, _WATCH),
        (2.88, _WATCH.moved(up=0.01)),
        (3.78, _WATCH.moved(up=-0.02)),
        (4.5, HANGING),
    ),
    trunk=keys(
        (0, 0.9, 1.98, 3.06, 4.14, 5.13, 6.3),
        (0, -1, 3, 2, 0, -1, 0),
        (0, 10, 0, 0, 0, -12, 0),
        (0, 0, 0, 0, 0, 0, 0),
    ),
    look=keys(
        (0, 0.72, 1.35, 2.07, 2.97, 3.69, 4.86, 5.67, 6.48),
        (0, -2, -2, 30, 30, 0, -2, -2, 0),
        (0, 42, 42, -8, -8, 0, -44, -44, 0),
        (0, 0, 0, 0, 0, 0, 0, 0, 0),
    ),
    pelvis=keys(
        (0, 2.52, 3.96, 6.12),
        (0.05, 0.045, -0.05, -0.045),
        (-0.01, -0.01, -0.01, -0.01),
        (0, 0, 0, 0),
    ),
    moves=(
        Move("hand", 3.83, 4.28, side=0.05, heading_deg=8.0, lift_m=0.015),
        Move("hand", 6.44, 6.89, lift_m=0.015),
    ),
)
"""Waits: weight on one leg, looks down the way, reads the time, folds the arms a while."""


_LOOK_UP = Script(
    duration_s=7.02,
    plain_s=7.02,
    hand=(
        (0.0, HANGING),
        (1.71, HANGING),
        (2.16, _LIFT),
        (2.61, BROW),
        (4.59, BROW),
        (5.04, _LIFT),
        (5.67, HANGING),
    ),
    other=(
        (0.0, HANGING),
        (0.45, HANGING),
        (1.08, AKIMBO),
        (5.04, AKIMBO),
        (5.85, HANGING),
    ),
    trunk=keys(
        (0, 1.08, 2.16, 3.06, 4.41, 5.58),
        (0, -3, -2, 0, 0, 0),
        (0, -8, 0, 12, -14, 0),
        (0, 0, 0, 0, 0, 0),
    ),
    look=keys(
        (0, 0.9, 1.53, 2.34, 2.97, 3.51, 4.32, 4.95, 5.85),
        (0, -24, -26, -4, -4, -4, -5, -3, 0),
        (0, -26, -10, 8, 34, 28, -36, -30, 0),
        (0, 0, 0, 0, 0, 0, 0, 0, 0),
    ),
    pelvis=keys(
        (0, 1.08, 3.06, 4.5),
        (0, -0.03, 0.04, -0.03),
        (-0.004, -0.004, -0.004, -0.004),
        (0, 0, 0, 0),
    ),
    moves=(
        Move("other", 3.69, 4.09, heading_deg=-16.0, forward=0.05, lift_m=0.015),
        Move("hand", 4.19, 4.59, heading_deg=-12.0, forward=0.03, lift_m=0.015),
        Move("hand", 5.49, 5.89, lift_m=0.015),
        Move("other", 6.03, 6.44, lift_m=0.015),
    ),
)
"""Looks about a place at leisure, a hand over the eyes against the light."""


_DIRECT = Script(
    duration_s=6.66,
    plain_s=6.66,
    hand=(
        (0.0, HANGING),
        (0.36, HANGING),
        (1.17, _SHOW),
        (2.07, _SHOW.moved(up=0.02)),
        (2.7, _SHOW.moved(out=-0.22, up=-0.06, forward=0.06)),
        (3.33, _SHOW.moved(out=-0.30, up=-0.02, forward=0.10)),
        (3.87, TALK),
        (4.32, TALK.moved(up=0.03)),
        (4.77, _SHOW.moved(up=-0.02)),
        (5.22, _SHOW.moved(up=-0.02)),
        (6.03, HANGING),
    ),
    other=(
        (0.0, HANGING),
        (3.42, HANGING),
        (3.96, TALK.moved(up=-0.06)),
        (4.5, TALK.moved(up=-0.06)),
        (5.4, HANGING),
    ),
    trunk=keys(
        (0, 1.17, 2.07, 3.24, 4.05, 4.86, 5.85),
        (0, 0, 0, 1, 2, 0, 0),
        (0, 16, 15, -4, 0, 13, 0),
        (0, 2, 2, 0, 0, 2, 0),
    ),
    look=keys(
        (0, 0.9, 1.53, 2.07, 2.97, 3.69, 3.96, 4.23, 4.68, 5.4, 5.76, 6.12),
        (0, -1, -1, 0, -1, 0, 8, 0, -1, 0, 6, 0),
        (0, 46, 46, 4, 22, 0, 0, 0, 40, 4, 0, 0),
        (0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0),
    ),
    pelvis=keys(
        (0, 1.17, 2.16, 3.6, 4.95, 5.94),
        (0, 0.045, 0.04, -0.02, 0.04, 0),
        (-0.004, -0.004, -0.004, -0.004, -0.004, -0.004),
        (0, 0, 0, 0, 0, 0),
    ),
    moves=(
        Move("hand", 0.54, 0.95, side=0.05, heading_deg=22.0, lift_m=0.015),
        Move("hand", 5.67, 6.08, lift_m=0.015),
    ),
    shakes=(
        Shake("hand_forward", 0.025, 1.4, 1.08, 2.25),
        Shake("hand_up", 0.02, 1.4, 3.78, 5.31),
        Shake("hand_bend", 12.0, 1.4, 1.08, 5.31, shift=0.1),
    ),
)
"""Shows somebody the way: points aside with the whole arm, traces a bend, nods, points again."""


_ADJUST = Script(
    duration_s=7.2,
    plain_s=7.2,
    hand=(
        (0.0, HANGING),
        (0.36, HANGING),
        (0.99, _SLEEVE.moved(up=-0.02)),
        (2.34, _SLEEVE.moved(up=-0.02)),
        (3.24, AKIMBO),
        (3.6, AKIMBO),
        (4.15, _LIFT),
        (4.6, _BESIDE),
        (5.05, NAPE),
        (5.5, NAPE),
        (5.9, _BESIDE),
        (6.3, _LIFT),
        (6.9, HANGING),
    ),
    other=(
        (0.0, HANGING),
        (0.27, HANGING),
        (0.9, _FOREARM),
        (2.43, _FOREARM),
        (3.15, AKIMBO),
        (5.67, AKIMBO),
        (6.39, HANGING),
    ),
    trunk=keys(
        (0, 1.08, 2.34, 3.24, 3.96, 4.86, 5.76, 6.57),
        (0, 3, 3, -4, -4, 0, 0, 0),
        (0, -5, -5, 0, 6, 4, -4, 0),
        (0, 0, 0, 0, 0, -3, -2, 0),
    ),
    look=keys(
        (0, 0.81, 2.25, 3.15, 3.96, 4.68, 5.49, 6.48),
        (0, 28, 26, 0, -2, 6, 4, 0),
        (0, -14, -12, 0, 24, 0, -22, 0),
        (0, 0, 0, 0, 0, -6, -6, 0),
    ),
    pelvis=keys(
        (0, 2.34, 3.42, 5.58, 6.66),
        (0.03, 0.03, -0.045, -0.04, 0.03),
        (-0.004, -0.004, -0.008, -0.008, -0.004),
        (0, 0, 0, 0, 0),
    ),
    moves=(
        Move("hand", 2.97, 3.38, side=0.06, heading_deg=6.0, lift_m=0.015),
        Move("hand", 6.21, 6.62, lift_m=0.015),
    ),
    shakes=(
        Shake("hand_out", 0.03, 1.0, 1.08, 2.34),
        Shake("hand_up", 0.012, 1.0, 4.68, 5.58),
    ),
)
"""Tugs a sleeve straight, rubs the forearm, sets the hands on the hips, rubs the neck."""


SCRIPTS = {
    "explain": _EXPLAIN,
    "wait": _WAIT,
    "look_up": _LOOK_UP,
    "direct": _DIRECT,
    "adjust": _ADJUST,
}
