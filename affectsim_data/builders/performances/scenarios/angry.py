"""Anger, standing: the body leans in, widens its stance, strikes and stops hard."""

from __future__ import annotations

from affectsim_data.builders.performances.scenarios.vocabulary import (
    AKIMBO,
    FIST_HIGH,
    FOLDED_OVER,
    FOLDED_UNDER,
    POINT,
    ArmPose,
    Move,
    Script,
    Shake,
    keys,
)

__all__ = ["SCRIPTS"]

_FIST = ArmPose((0.14, -0.46, 0.10), (0.8, 0.0, -0.8), palm_deg=-20.0, bend_deg=15.0)
"""Arm tense at the side, the elbow bent and out."""
_COCKED = ArmPose((0.10, -0.05, 0.14), (0.7, -0.3, -1.0), palm_deg=-40.0)
"""Drawn back beside the shoulder."""
_STRIKE = ArmPose((0.0, -0.22, 0.38), (0.7, -0.6, -0.4), palm_deg=-30.0, bend_deg=15.0)
_SCOLD = ArmPose((-0.02, -0.30, 0.42), (0.8, -0.4, -0.6), palm_deg=-60.0, bend_deg=10.0)
"""Pointing at the floor before the other's feet."""
_SCOLD_UP = ArmPose((0.02, -0.08, 0.34), (0.8, -0.5, -0.5), palm_deg=-50.0, bend_deg=-20.0)
_WAG = ArmPose((0.06, 0.14, 0.28), (0.4, -1.0, 0.0), palm_deg=-60.0)
_CUT_IN = ArmPose((-0.22, -0.10, 0.34), (0.8, -0.4, 0.0), palm_deg=-70.0)
_CUT_OUT = ArmPose((0.40, -0.16, 0.26), (0.6, -0.6, -0.6), palm_deg=-80.0)
_FLUNG = ArmPose((0.30, 0.34, 0.16), (1.0, -0.5, -0.2), palm_deg=10.0, bend_deg=-30.0)
"""Thrown up and out, palms up."""
_SLAP = ArmPose((0.10, -0.50, 0.10), (0.6, -0.2, -1.0))


_THREATEN = Script(
    duration_s=5.8,
    plain_s=7.2,
    stance=1.1,
    hand=(
        (0.0, _FIST),
        (0.45, _COCKED),
        (0.8, POINT),
        (1.2, POINT),
        (1.42, _COCKED.moved(up=0.08)),
        (1.66, POINT.moved(up=0.04)),
        (2.1, POINT.moved(up=0.02)),
        (2.6, FIST_HIGH),
        (3.7, FIST_HIGH),
        (4.0, _STRIKE),
        (4.5, _STRIKE.moved(up=-0.03)),
        (5.2, _FIST),
    ),
    other=(
        (0.0, _FIST),
        (0.8, _FIST.moved(forward=-0.10, up=0.06)),
        (2.2, _FIST),
        (2.7, _FIST.moved(up=0.14, forward=0.14)),
        (4.0, _FIST.moved(up=0.08, forward=0.06)),
        (5.2, _FIST),
    ),
    trunk=keys(
        (0, 0.4, 0.8, 1.2, 1.42, 1.68, 2.1, 2.6, 3.65, 3.95, 4.5, 5.3),
        (0, -4, 9, 8, 1, 12, 10, -5, -3, 18, 14, 0),
        (0, 16, -16, -14, 6, -18, -14, 14, 12, -14, -9, 0),
        (0, 0, 0, 0, 0, 0, 0, 4, 4, -3, 0, 0),
    ),
    look=keys(
        (0, 0.8, 1.45, 1.7, 2.6, 3.95, 5.2),
        (2, 5, -3, 7, -2, 12, 2),
        (0, -3, 3, -3, 5, -3, 0),
        (0, 0, 0, 0, 5, 0, 0),
    ),
    shrug=((0.0, 0.0), (2.6, 6.0), (3.9, -2.0), (5.0, 0.0)),
    pelvis=keys(
        (0, 0.4, 0.85, 2.1, 2.6, 3.7, 3.97, 4.4, 5.3),
        (0, 0, 0, 0, 0, 0, 0, 0, 0),
        (0, -0.02, -0.01, -0.01, 0.02, 0.02, -0.06, -0.03, 0),
        (0, -0.05, 0.07, 0.06, -0.03, -0.02, 0.07, 0.04, 0),
    ),
    moves=(
        Move("hand", 0.40, 0.78, forward=0.34, lift_m=0.09),
        Move("other", 2.05, 2.45, forward=0.34, lift_m=0.08),
        Move("hand", 4.45, 4.85, forward=0.0),
        Move("other", 4.95, 5.4, forward=0.0),
    ),
    shakes=(
        Shake("hand_forward", 0.065, 2.4, 2.65, 3.65),
        Shake("hand_up", 0.03, 2.4, 2.65, 3.65, shift=0.25),
        Shake("look_yaw", 5.0, 2.6, 2.7, 3.6),
    ),
)
"""Steps up, jabs a finger twice, shakes a raised fist and strikes down."""


_REFUSE = Script(
    duration_s=6.4,
    plain_s=7.4,
    hand=(
        (0.0, _FIST),
        (0.25, _FIST.moved(out=0.06, up=0.05)),
        (0.7, FOLDED_OVER),
        (3.6, FOLDED_OVER),
        (4.05, _CUT_IN),
        (4.3, _CUT_OUT),
        (4.6, _CUT_OUT),
        (4.85, _CUT_IN.moved(up=-0.05)),
        (5.1, _CUT_OUT.moved(up=-0.06)),
        (5.5, _CUT_OUT.moved(up=-0.10)),
        (6.0, _FIST),
    ),
    other=(
        (0.0, _FIST),
        (0.25, _FIST.moved(out=0.06, up=0.05)),
        (0.65, FOLDED_UNDER),
        (3.7, FOLDED_UNDER),
        (4.2, _FIST.moved(up=0.08)),
        (5.6, _FIST),
    ),
    trunk=keys(
        (0, 0.3, 0.75, 2, 2.6, 3.5, 4, 4.32, 4.6, 4.85, 5.12, 5.5, 6.1),
        (0, 6, -7, -8, -6, -7, 2, 10, 9, 5, 12, 9, 0),
        (0, 0, 0, 0, -22, -24, -14, 16, 12, -6, 16, 8, 0),
        (0, 0, 0, 0, 0, 0, 0, 2, 2, 0, 2, 0, 0),
    ),
    look=keys(
        (0, 0.75, 1.9, 2.4, 3.4, 3.9, 4.32, 5.4, 6),
        (2, -7, -5, -9, -9, 0, 7, 7, 2),
        (0, 0, 0, -68, -70, -4, 0, 0, 0),
        (0, 0, 0, 0, 0, 0, 0, 0, 0),
    ),
    shrug=((0.0, 0.0), (0.7, 5.0), (3.6, 4.0), (4.3, 0.0)),
    pelvis=keys(
        (0, 0.8, 2.2, 3.5, 4.3, 5.5),
        (0, 0, 0.03, 0, 0, 0),
        (0, 0.01, 0.01, 0.01, -0.02, -0.02),
        (0, -0.04, -0.03, -0.03, 0.06, 0.05),
    ),
    moves=(
        Move("hand", 2.25, 2.6, heading_deg=-38.0, side=-0.03, forward=0.05),
        Move("other", 2.55, 2.9, heading_deg=-38.0, side=-0.03, forward=0.0),
        Move("other", 3.55, 3.85, heading_deg=0.0),
        Move("hand", 3.85, 4.2, forward=0.24, lift_m=0.11),
        Move("hand", 5.55, 6.0),
    ),
    shakes=(
        Shake("look_yaw", 17.0, 1.7, 0.8, 2.15, fade_s=0.2),
        Shake("look_yaw", 9.0, 2.2, 4.2, 5.4),
        Shake("trunk_yaw", 3.0, 1.7, 0.8, 2.15),
    ),
)
"""Folds the arms, shakes the head, turns away; then cuts the air with a flat hand."""


_REBUKE = Script(
    duration_s=5.6,
    plain_s=7.0,
    hand=(
        (0.0, _SCOLD_UP),
        (0.25, _SCOLD),
        (0.55, _SCOLD),
        (0.78, _SCOLD_UP),
        (0.98, _SCOLD),
        (1.2, _SCOLD),
        (1.42, _SCOLD_UP),
        (1.62, _SCOLD),
        (1.95, _SCOLD),
        (2.4, _WAG),
        (3.55, _WAG.moved(up=0.03)),
        (3.85, _SCOLD_UP.moved(up=0.1)),
        (4.08, _SCOLD),
        (4.7, _SCOLD),
        (5.3, _SCOLD_UP.moved(up=-0.04)),
    ),
    other=((0.0, AKIMBO), (2.8, AKIMBO)),
    trunk=keys(
        (0, 0.27, 0.78, 1, 1.42, 1.65, 1.95, 2.4, 3.5, 3.85, 4.1, 4.7, 5.3),
        (5, 14, 8, 16, 8, 17, 15, 0, 2, -3, 19, 15, 5),
        (4, -9, 2, -9, 2, -10, -9, 4, 4, 8, -10, -8, 3),
        (0, 0, 0, 0, 0, 0, 0, -3, -3, 0, 0, 0, 0),
    ),
    look=keys(
        (0, 0.3, 0.78, 1, 1.42, 1.65, 2.3, 3.6, 4.1, 4.7),
        (3, 12, 2, 13, 2, 14, -2, -2, 16, 10),
        (0, -3, 0, -3, 0, -3, 3, 3, 0, 0),
        (0, 0, 0, 0, 0, 0, -6, -6, 0, 0),
    ),
    pelvis=keys(
        (0, 0.3, 1.9, 2.4, 3.5, 4.1, 4.8),
        (0, 0, 0, -0.02, -0.02, 0, 0),
        (0, -0.02, -0.02, 0, 0, -0.04, -0.02),
        (0, 0.04, 0.05, 0, 0, 0.05, 0.03),
    ),
    moves=(
        Move("hand", 0.02, 0.3, forward=0.16, lift_m=0.06),
        Move("hand", 3.72, 4.05, forward=0.2, lift_m=0.14),
        Move("hand", 4.9, 5.35),
    ),
    shakes=(
        Shake("hand_out", 0.05, 2.6, 2.4, 3.6),
        Shake("hand_palm", 15.0, 2.6, 2.4, 3.6, shift=0.1),
        Shake("look_yaw", 6.0, 2.6, 2.4, 3.6),
    ),
)
"""Points at the floor again and again, wags a finger, points down once more and stamps."""


_THROW_UP_HANDS_ARMS = (
    (0.0, _SLAP),
    (0.2, _SLAP.moved(out=0.02, up=0.12, forward=0.10)),
    (0.5, _FLUNG),
    (0.95, _FLUNG.moved(up=-0.02)),
    (1.3, _SLAP),
    (2.7, _SLAP),
    (2.95, _SLAP.moved(out=0.02, up=0.14, forward=0.12)),
    (3.25, _FLUNG.moved(up=0.04)),
    (3.5, _FLUNG.moved(up=-0.08)),
    (3.75, _FLUNG.moved(up=0.03)),
    (4.05, _FLUNG.moved(up=-0.04)),
    (4.4, _STRIKE.moved(out=0.06)),
    (4.8, _STRIKE.moved(out=0.06)),
    (5.5, _SLAP),
)
_THROW_UP_HANDS = Script(
    duration_s=6.0,
    plain_s=7.2,
    hand=_THROW_UP_HANDS_ARMS,
    other=_THROW_UP_HANDS_ARMS,
    trunk=keys(
        (0, 0.2, 0.55, 1, 1.35, 2.2, 2.9, 3.3, 4.05, 4.4, 4.85, 5.5),
        (0, 9, -11, -8, 6, 4, 10, -12, -7, 17, 13, 0),
        (0, 0, 0, 0, 14, 6, 0, 0, 0, 0, 0, 0),
        (0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0),
    ),
    look=keys(
        (0, 0.5, 0.95, 1.3, 2.1, 2.6, 3.25, 4, 4.4, 5.3),
        (2, -22, -18, 6, 6, 2, -20, -16, 9, 2),
        (0, 0, 0, 40, 34, 0, 0, 0, 0, 0),
        (0, 0, 0, 0, 0, 0, 0, 0, 0, 0),
    ),
    shrug=((0.0, 0.0), (0.5, 10.0), (1.3, 0.0), (2.8, 0.0), (3.25, 11.0), (4.3, 0.0)),
    pelvis=keys(
        (0, 0.2, 0.55, 1.3, 2.9, 3.3, 4.4, 5.4),
        (0, 0, 0, 0, 0, 0, 0, 0),
        (0, -0.04, 0.015, -0.01, -0.05, 0.015, -0.06, 0),
        (0, 0, 0.03, 0, 0, 0.03, 0.04, 0),
    ),
    moves=(
        Move("hand", 1.1, 1.45, side=0.22, forward=0.05, heading_deg=35.0),
        Move("other", 1.5, 1.85, side=0.22, forward=0.05, heading_deg=35.0),
        Move("other", 2.15, 2.5, side=0.0, heading_deg=0.0),
        Move("hand", 2.55, 2.9, side=0.0, heading_deg=0.0),
        Move("hand", 4.02, 4.4, forward=0.12, lift_m=0.18),
        Move("hand", 5.0, 5.45),
    ),
    shakes=(Shake("look_yaw", 10.0, 2.0, 3.2, 4.2), Shake("look_yaw", 7.0, 2.0, 0.5, 1.1)),
)
"""Flings both arms up, turns aside and back in a short pace, flings them again, stamps."""


_CLENCH_UP = ArmPose((0.10, 0.14, 0.22), (0.9, -0.5, -0.3), palm_deg=-10.0, bend_deg=15.0)
_CLENCH_POUND = _STRIKE.moved(up=-0.02)
_CLENCH_ARMS = (
    (0.0, _FIST),
    (0.4, _FIST.moved(up=0.05, out=0.03)),
    (1.9, _FIST.moved(up=0.06, out=0.03)),
    (2.3, _CLENCH_UP),
    (2.52, _CLENCH_POUND),
    (2.75, _CLENCH_POUND),
    (3.0, _CLENCH_UP.moved(up=0.02)),
    (3.22, _CLENCH_POUND),
    (3.45, _CLENCH_POUND),
    (3.75, _CLENCH_UP.moved(up=0.06)),
    (3.98, _CLENCH_POUND.moved(up=-0.04)),
    (4.4, _CLENCH_POUND.moved(up=-0.05)),
    (5.0, _FIST),
)
_CLENCH = Script(
    duration_s=5.6,
    plain_s=7.0,
    hand=_CLENCH_ARMS,
    other=tuple((time + 0.03, pose) for time, pose in _CLENCH_ARMS),
    stance=1.1,
    trunk=keys(
        (0, 0.45, 1.8, 2.25, 2.54, 2.98, 3.24, 3.72, 4, 4.45, 5.1),
        (2, 7, 9, -6, 16, -3, 17, -7, 22, 18, 2),
        (0, 0, 0, 0, 0, 4, -3, 0, 0, 0, 0),
        (0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0),
    ),
    look=keys(
        (0, 0.5, 1.8, 2.25, 2.54, 3, 3.24, 3.72, 4, 4.6),
        (2, 9, 9, -8, 10, -4, 10, -9, 16, 8),
        (0, 0, 0, 0, 0, 0, 0, 0, 0, 0),
        (0, 0, 0, 0, 0, 0, 0, 0, 0, 0),
    ),
    shrug=((0.0, 2.0), (0.5, 9.0), (1.9, 10.0), (2.5, 0.0), (4.4, 0.0)),
    pelvis=keys(
        (0, 0.5, 2.25, 2.54, 3, 3.24, 3.72, 4, 4.5, 5.2),
        (0, 0, 0, 0, 0, 0, 0, 0, 0, 0),
        (0, -0.02, 0.01, -0.06, 0, -0.06, 0.01, -0.09, -0.05, 0),
        (0, 0, -0.03, 0.04, -0.01, 0.04, -0.03, 0.04, 0.02, 0),
    ),
    moves=(
        Move("other", 1.98, 2.5, forward=0.14, lift_m=0.15),
        Move("other", 4.7, 5.15),
    ),
    shakes=(
        Shake("hand_up", 0.012, 5.0, 0.5, 1.95),
        Shake("other_up", 0.012, 5.0, 0.5, 1.95, shift=0.4),
        Shake("look_yaw", 6.0, 2.5, 0.6, 1.9),
        Shake("trunk_yaw", 2.0, 2.5, 0.6, 1.9, shift=0.3),
    ),
)
"""Fists at the sides, every muscle tense, shaking; then pounds the air, head thrust out."""


SCRIPTS = {
    "threaten": _THREATEN,
    "refuse": _REFUSE,
    "rebuke": _REBUKE,
    "throw_up_hands": _THROW_UP_HANDS,
    "clench": _CLENCH,
}
