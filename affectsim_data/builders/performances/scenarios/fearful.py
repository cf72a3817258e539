"""Fear, standing: the body shrinks, draws back from something, and cannot take its eyes off it."""

from __future__ import annotations

from affectsim_data.builders.performances.scenarios.vocabulary import (
    CLASPED,
    CROWN,
    GUARD,
    MOUTH,
    ArmPose,
    Move,
    Script,
    Shake,
    keys,
)

__all__ = ["SCRIPTS"]

_CLOSE = ArmPose((0.065, -0.023, 0.178), (0.62, -1.0, -0.1), 31.0, 24.0, "chest")
"""Hand pressed to the breast."""
_LOWER = _CLOSE.moved(up=-0.09)
"""The other hand, below it."""
_WARD = ArmPose((0.19, 0.06, 0.18), (0.9, -0.5, 0.2), 30.0, -10.0, "head")
"""On the way to the top of the head, round the face."""
_CHIN = ArmPose((0.047, -0.13, 0.115), (0.38, -1.0, -0.18), 35.0, -30.0, "head")
"""Hand at the chin."""
_PUSH = ArmPose((-0.02, 0.0, 0.42), (0.4, -1.0, 0.0), palm_deg=-65.0, bend_deg=-50.0)
"""Palm held out against what comes."""
_STIFF = ArmPose((0.20, -0.40, 0.12), (0.8, -0.2, -1.0), palm_deg=-40.0, bend_deg=-45.0)
"""Arm away from the side, stiff, the fingers spread."""


_SHRINK_BACK = Script(
    duration_s=6.6,
    plain_s=7.0,
    hand=(
        (0.0, _CLOSE),
        (0.35, _CLOSE),
        (0.72, GUARD.moved(up=0.04)),
        (2.2, GUARD),
        (2.6, GUARD.moved(up=-0.10)),
        (3.1, GUARD.moved(up=-0.10)),
        (3.4, GUARD.moved(up=0.05)),
        (4.5, GUARD),
        (5.6, _CLOSE),
    ),
    other=(
        (0.0, _LOWER),
        (0.38, _LOWER),
        (0.8, _PUSH),
        (2.3, _PUSH),
        (3.1, _PUSH.moved(up=-0.08, forward=-0.06)),
        (3.42, _PUSH.moved(up=0.06)),
        (4.4, _PUSH.moved(forward=-0.06)),
        (5.5, _LOWER),
    ),
    trunk=keys(
        (0, 0.4, 0.8, 2.2, 3, 3.42, 4.4, 5.6),
        (2, 3, -22, -16, -6, -22, -14, 4),
        (0, 0, 14, 18, 14, 20, 14, 0),
        (0, 0, 3, 4, 2, 5, 3, 0),
    ),
    look=keys(
        (0, 0.42, 0.9, 1.9, 2.5, 3.1, 3.45, 4.3, 4.9),
        (-6, -10, 2, 2, -8, -8, 4, 0, -6),
        (0, 0, 34, 32, 0, -2, 38, 30, 0),
        (0, 0, 8, 8, 3, 0, 10, 6, 0),
    ),
    shrug=((0.0, 0.0), (0.6, 12.0), (2.2, 9.0), (3.0, 4.0), (3.42, 13.0), (5.5, 0.0)),
    pelvis=keys(
        (0, 0.45, 0.8, 1.7, 2.4, 3, 3.5, 4.4, 5.6),
        (0, 0, 0, 0, 0, 0, 0, 0, 0),
        (0, 0.02, -0.05, -0.08, -0.07, -0.04, -0.12, -0.08, 0),
        (0, 0, -0.07, -0.05, -0.02, 0.02, -0.06, -0.02, 0),
    ),
    moves=(
        Move("hand", 0.5, 0.82, forward=-0.30, heading_deg=8.0),
        Move("other", 0.9, 1.22, forward=-0.34, heading_deg=8.0),
        Move("hand", 1.3, 1.62, forward=-0.52, heading_deg=10.0),
        Move("other", 4.55, 5.0, forward=-0.10, heading_deg=0.0, lift_m=0.04),
        Move("hand", 5.1, 5.55, forward=0.0, lift_m=0.04),
        Move("other", 5.7, 6.1, forward=0.0, lift_m=0.04),
    ),
    shakes=(
        Shake("hand_up", 0.010, 3.4, 1.0, 4.5, fade_s=0.5),
        Shake("other_up", 0.010, 3.4, 1.0, 4.4, fade_s=0.5, shift=0.4),
        Shake("shrug", 1.5, 3.4, 1.0, 4.5, fade_s=0.5),
    ),
)
"""Is startled, stumbles two steps back behind raised arms, and creeps forward again."""


_LOOK_AROUND = Script(
    duration_s=7.0,
    plain_s=7.4,
    hand=(
        (0.0, _CHIN),
        (0.45, _CHIN),
        (0.85, _CLOSE.moved(up=0.05)),
        (1.6, _CLOSE.moved(up=0.06)),
        (2.15, MOUTH),
        (3.5, _CHIN),
        (4.25, _CHIN),
        (4.65, _CLOSE.moved(up=0.06)),
        (5.8, _CLOSE.moved(up=0.05)),
        (6.4, _CHIN),
    ),
    other=(
        (0.0, _LOWER),
        (1.8, _LOWER.moved(up=0.01)),
        (3.3, _LOWER),
        (5.0, _LOWER.moved(up=0.02)),
    ),
    trunk=keys(
        (0, 0.6, 0.95, 1.6, 2.3, 3.2, 4.2, 4.75, 5.6, 6.4),
        (6, 6, 3, 7, 3, 8, 8, 1, 6, 7),
        (0, 0, 22, 24, -18, -22, 10, 32, 34, 6),
        (0, 0, 3, 3, -3, -3, 0, 4, 4, 0),
    ),
    look=keys(
        (0, 0.5, 0.75, 1.55, 2, 3.2, 3.7, 4.1, 4.45, 5.6, 6.2),
        (0, 0, -6, -6, -2, -4, 2, 2, -7, -7, 0),
        (0, 0, 62, 58, -50, -60, -12, 10, 88, 84, 5),
        (0, 0, 4, 4, -4, -4, 0, 0, 4, 4, 0),
    ),
    shrug=((0.0, 3.0), (0.75, 9.0), (1.7, 4.0), (2.1, 9.0), (3.5, 3.0), (4.5, 11.0), (6.2, 3.0)),
    pelvis=keys(
        (0, 0.9, 1.8, 2.4, 3.4, 4.7, 5.6),
        (0, -0.04, -0.03, 0.04, 0.02, -0.03, -0.03),
        (-0.02, -0.03, -0.03, -0.04, -0.03, -0.06, -0.05),
        (0, 0, 0, 0, 0, 0, 0),
    ),
    moves=(
        Move("other", 2.45, 2.8, forward=-0.12, heading_deg=-22.0, lift_m=0.04),
        Move("hand", 2.85, 3.15, forward=-0.12, heading_deg=-18.0, lift_m=0.04),
        Move("hand", 4.55, 4.9, forward=-0.14, side=0.05, heading_deg=34.0, lift_m=0.05),
        Move("other", 4.95, 5.3, forward=-0.06, side=0.0, heading_deg=26.0, lift_m=0.04),
        Move("hand", 5.85, 6.2, lift_m=0.04),
        Move("other", 6.25, 6.6, lift_m=0.04),
    ),
    shakes=(
        Shake("look_yaw", 5.0, 1.6, 5.0, 5.8),
        Shake("shrug", 1.2, 3.2, 0.8, 6.2, fade_s=0.6),
    ),
)
"""Arms held close, hunched; turns to sounds on both sides and behind, the feet shuffling."""


_FREEZE_ARMS = (
    (0.0, _CLOSE),
    (0.4, _CLOSE),
    (0.62, _STIFF.moved(up=0.14, forward=0.10)),
    (1.0, _STIFF),
    (3.9, _STIFF.moved(up=-0.02)),
    (4.12, _STIFF.moved(up=0.12, forward=0.08)),
    (4.5, _STIFF.moved(up=0.03)),
    (5.2, _STIFF),
    (6.1, _CLOSE),
)
_FREEZE = Script(
    duration_s=6.6,
    plain_s=7.2,
    hand=_FREEZE_ARMS,
    other=tuple(
        (time + 0.02, _LOWER if pose == _CLOSE else pose.moved(up=0.02))
        for time, pose in _FREEZE_ARMS
    ),
    stance=0.75,
    trunk=keys(
        (0, 0.4, 0.65, 1.1, 3.9, 4.15, 4.8, 6.1),
        (4, 4, -18, -14, -12, -22, -14, 4),
        (0, 0, 0, 0, 0, -4, -3, 0),
        (0, 0, 0, 0, 0, 0, 0, 0),
    ),
    look=keys(
        (0, 0.4, 0.65, 1.5, 2.1, 2.5, 3.2, 3.85, 4.1, 5, 6),
        (0, 0, -16, -14, -12, -12, -12, -12, -18, -12, 0),
        (0, 0, 0, 0, 42, 42, -40, -40, 0, 0, 0),
        (0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0),
    ),
    shrug=((0.0, 0.0), (0.4, 0.0), (0.62, 16.0), (3.9, 10.0), (4.12, 18.0), (5.0, 9.0), (6.1, 0.0)),
    pelvis=keys(
        (0, 0.4, 0.62, 1, 3.9, 4.12, 4.7, 6.1),
        (0, 0, 0, 0, 0, 0, 0, 0),
        (0, -0.02, 0.07, 0.04, 0.04, 0.07, 0.03, 0),
        (0, 0, -0.05, -0.04, -0.03, -0.06, -0.03, 0),
    ),
    moves=(
        Move("hand", 0.5, 0.74, forward=-0.16, lift_m=0.04),
        Move("other", 0.85, 1.12, forward=-0.16, lift_m=0.04),
        Move("other", 4.05, 4.3, forward=-0.30, lift_m=0.04),
        Move("hand", 5.2, 5.6, lift_m=0.04),
        Move("other", 5.7, 6.15, lift_m=0.04),
    ),
    shakes=(
        Shake("hand_up", 0.010, 4.2, 0.8, 5.4, fade_s=0.4),
        Shake("other_up", 0.010, 4.2, 0.8, 5.4, fade_s=0.4, shift=0.3),
        Shake("trunk_yaw", 0.8, 4.2, 0.8, 5.4, fade_s=0.4),
        Shake("look_roll", 1.0, 4.2, 0.8, 5.4, fade_s=0.4),
    ),
)
"""Starts, stands stiff and trembling, peeks to both sides without moving, starts again."""


_COVER = Script(
    duration_s=6.8,
    plain_s=7.2,
    deep=True,
    hand=(
        (0.0, _CLOSE),
        (0.35, _CLOSE),
        (0.6, _WARD),
        (0.9, CROWN),
        (4.6, CROWN.moved(up=-0.01)),
        (5.1, _WARD),
        (5.9, _CLOSE),
    ),
    other=(
        (0.0, _LOWER),
        (0.32, _LOWER),
        (0.55, _WARD),
        (0.85, CROWN.moved(up=0.03)),
        (2.2, CROWN.moved(up=0.03)),
        (2.5, _WARD),
        (2.9, GUARD.moved(up=0.05)),
        (3.2, GUARD.moved(up=0.05)),
        (3.42, _WARD),
        (3.7, CROWN.moved(up=0.03)),
        (4.5, CROWN.moved(up=0.02)),
        (5.0, _WARD),
        (5.8, _LOWER),
    ),
    trunk=keys(
        (0, 0.35, 0.95, 2.2, 2.8, 3.25, 3.65, 4.7, 5.8),
        (4, -4, 36, 38, 22, 22, 40, 34, 6),
        (0, 0, 8, 9, -4, -5, 9, 6, 0),
        (0, 0, 3, 3, 0, 0, 3, 0, 0),
    ),
    look=keys(
        (0, 0.35, 0.9, 2.2, 2.75, 3.25, 3.6, 4.6, 5.2, 5.8, 6.4),
        (-6, -16, 52, 54, 0, 0, 56, 36, -4, -4, -6),
        (0, 0, 12, 12, -18, -22, 14, 4, 30, -24, 0),
        (0, 0, 6, 6, 0, 0, 6, 0, 0, 0, 0),
    ),
    shrug=((0.0, 0.0), (0.8, 12.0), (4.6, 10.0), (5.8, 0.0)),
    pelvis=keys(
        (0, 0.35, 0.95, 2.2, 2.8, 3.25, 3.65, 4.6, 5.8),
        (0, 0, 0, 0, 0, 0, 0, 0, 0),
        (0, 0.01, -0.26, -0.27, -0.2, -0.2, -0.29, -0.24, 0),
        (0, -0.02, -0.02, -0.02, 0, 0, -0.02, 0, 0),
    ),
    moves=(
        Move("other", 0.45, 0.8, forward=-0.24, heading_deg=6.0),
        Move("other", 5.3, 5.8, lift_m=0.04),
    ),
    shakes=(
        Shake("trunk_pitch", 1.0, 3.4, 1.0, 4.8, fade_s=0.5),
        Shake("shrug", 1.5, 3.4, 1.0, 4.8, fade_s=0.5, shift=0.3),
    ),
)
"""Ducks, both arms over the head; peeks out from under them, ducks again, rises warily."""


_PLEAD_CLASP = CLASPED.moved(up=0.04)
_PLEAD_AWAY = ArmPose((0.06, 0.02, 0.36), (0.5, -1.0, 0.0), palm_deg=-65.0, bend_deg=-45.0)
_PLEAD_ARMS = (
    (0.0, _PLEAD_CLASP),
    (0.8, _PLEAD_CLASP.moved(up=0.05, forward=0.03)),
    (2.0, _PLEAD_CLASP),
    (2.5, _PLEAD_AWAY),
    (3.9, _PLEAD_AWAY.moved(forward=-0.04)),
    (4.5, _PLEAD_CLASP.moved(up=0.08)),
    (5.6, _PLEAD_CLASP.moved(up=0.04)),
)
_PLEAD = Script(
    duration_s=6.4,
    plain_s=7.0,
    hand=_PLEAD_ARMS,
    other=_PLEAD_ARMS,
    trunk=keys(
        (0, 0.9, 2, 2.45, 3.9, 4.6, 5.6),
        (6, 12, 8, -16, -12, 14, 12),
        (0, 0, 0, 8, -6, 0, 0),
        (0, 0, 0, 0, 0, 0, 0),
    ),
    look=keys(
        (0, 0.9, 2, 2.5, 3.8, 4.6, 5.4),
        (-14, -10, -14, -2, -2, 18, -6),
        (0, 0, 0, 16, -10, 0, 0),
        (0, 5, 0, 0, 0, 0, -4),
    ),
    shrug=((0.0, 3.0), (0.9, 7.0), (2.0, 3.0), (2.5, 12.0), (3.9, 9.0), (4.6, 4.0)),
    pelvis=keys(
        (0, 0.9, 2, 2.5, 3.9, 4.6, 5.6),
        (0, 0, 0, 0, 0, 0, 0),
        (-0.03, -0.07, -0.03, -0.05, -0.06, -0.13, -0.09),
        (0, 0.02, 0, -0.06, -0.04, 0, 0),
    ),
    moves=(
        Move("other", 2.05, 2.4, forward=-0.22, lift_m=0.05),
        Move("hand", 2.5, 2.85, forward=-0.36, lift_m=0.05),
        Move("other", 3.0, 3.35, forward=-0.40, lift_m=0.05),
        Move("hand", 4.3, 4.75, forward=-0.12, lift_m=0.04),
        Move("other", 4.9, 5.3, lift_m=0.04),
        Move("hand", 5.45, 5.85, lift_m=0.04),
    ),
    shakes=(
        Shake("look_yaw", 12.0, 1.5, 2.4, 4.0),
        Shake("hand_up", 0.022, 1.7, 0.3, 2.1),
        Shake("other_up", 0.022, 1.7, 0.3, 2.1),
        Shake("hand_up", 0.022, 1.7, 4.5, 6.2),
        Shake("other_up", 0.022, 1.7, 4.5, 6.2),
        Shake("hand_out", 0.03, 1.5, 2.5, 4.0),
        Shake("other_out", 0.03, 1.5, 2.5, 4.0),
    ),
)
"""Hands clasped before the breast, begging, backing off; shows the palms: no, please no."""


SCRIPTS = {
    "shrink_back": _SHRINK_BACK,
    "look_around": _LOOK_AROUND,
    "freeze": _FREEZE,
    "cover": _COVER,
    "plead": _PLEAD,
}
