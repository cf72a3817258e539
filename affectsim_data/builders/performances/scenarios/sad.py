"""Sadness, standing: the body sinks and closes, moves late, slowly and little."""

from __future__ import annotations

from affectsim_data.builders.performances.scenarios.vocabulary import (
    BOTH_ON_FACE,
    FACE,
    HANGING,
    HUG_OVER,
    HUG_UNDER,
    SUPPORT,
    TEMPLE,
    ArmPose,
    Move,
    Script,
    Shake,
    keys,
)

__all__ = ["SCRIPTS"]

_LIMP = ArmPose((0.03, -0.535, 0.06))
"""Hanging from dropped shoulders."""
_LAP = ArmPose((0.035, -0.26, 0.108), (0.9, 0.2, -0.5), -41.0, -33.0, "thigh")
"""On the thigh of somebody who kneels."""


_MOURN = Script(
    duration_s=8.8,
    plain_s=8.0,
    hand=(
        (0.0, _LIMP),
        (0.6, _LIMP),
        (2.2, FACE),
        (4.0, FACE),
        (4.7, FACE.moved(out=0.04, up=-0.03)),
        (5.4, FACE),
        (6.2, FACE.moved(out=0.02, up=-0.01)),
        (8.0, _LIMP),
    ),
    other=(
        (0.0, _LIMP),
        (1.0, _LIMP),
        (2.7, SUPPORT),
        (6.4, SUPPORT.moved(up=-0.02)),
        (8.1, _LIMP),
    ),
    trunk=keys(
        (0, 2.2, 4.2, 6.2, 8),
        (0, 9, 12, 9, 0),
        (0, 4, 5, 2, 0),
        (0, 2, 3, -2, 0),
    ),
    look=keys(
        (0, 2, 4.2, 6.2, 8),
        (0, 16, 20, 16, 0),
        (0, -4, -6, 4, 0),
        (0, 3, 5, -3, 0),
    ),
    shrug=((0.0, 0.0), (2.4, 5.0), (6.2, 4.0), (8.0, 0.0)),
    pelvis=keys(
        (0, 2.4, 4.4, 6.4, 8.2),
        (0, 0.035, 0.02, -0.035, 0),
        (0, -0.02, -0.03, -0.02, 0),
        (0, 0, 0, 0, 0),
    ),
    shakes=(
        Shake("shrug", 2.6, 1.6, 2.2, 6.3, fade_s=0.8),
        Shake("trunk_pitch", 1.6, 1.6, 2.2, 6.3, fade_s=0.8, shift=0.2),
        Shake("look_pitch", 1.6, 1.6, 2.2, 6.3, fade_s=0.8, shift=0.3),
    ),
)
"""A hand goes to the lowered face, the other arm across the body; sobs, wipes, lets go."""


_COLLAPSE = Script(
    duration_s=9.8,
    plain_s=9.0,
    deep=True,
    hand=(
        (0.0, _LIMP),
        (0.9, _LIMP),
        (2.0, _LAP.moved(up=0.05)),
        (3.4, _LAP),
        (6.0, _LAP),
        (7.6, _LAP.moved(up=0.02)),
        (9.0, _LIMP),
    ),
    other=(
        (0.0, _LIMP),
        (1.1, _LIMP),
        (2.6, _LAP.moved(up=0.05)),
        (3.6, _LAP),
        (6.0, _LAP),
        (7.0, _LAP.moved(up=0.05)),
        (8.7, _LIMP),
    ),
    trunk=keys(
        (0, 1.6, 2.8, 4, 5.6, 6.6, 7.6, 9),
        (0, 14, 16, 24, 26, 18, 22, 0),
        (0, 0, 0, 2, -2, 0, 0, 0),
        (0, 0, 0, 0, 0, 0, 0, 0),
    ),
    look=keys(
        (0, 1.6, 4, 5.6, 6.8, 9),
        (0, 14, 28, 30, 10, 0),
        (0, 0, 4, -4, 0, 0),
        (0, 0, 2, -2, 0, 0),
    ),
    pelvis=keys(
        (0, 0.5, 1.2, 2.3, 3.2, 4.1, 5.7, 6.5, 7.4, 8.5, 9.2),
        (0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0),
        (0, -0.01, -0.11, -0.41, -0.42, -0.55, -0.56, -0.42, -0.41, -0.09, 0),
        (0, 0, 0.04, 0.2, 0.2, 0.1, 0.1, 0.2, 0.2, 0.04, 0),
    ),
    kneel=(
        (0.0, (0.0, 0.0)),
        (1.0, (0.0, 0.0)),
        (2.2, (1.0, 0.0)),
        (2.5, (1.0, 0.0)),
        (3.1, (1.0, 1.0)),
        (6.5, (1.0, 1.0)),
        (7.0, (1.0, 0.0)),
        (7.5, (1.0, 0.0)),
        (8.7, (0.0, 0.0)),
    ),
    heels=(
        (0.0, (0.0, 0.0)),
        (0.95, (0.0, 0.0)),
        (2.3, (78.0, 0.0)),
        (2.5, (80.0, 0.0)),
        (3.2, (82.0, 80.0)),
        (6.4, (82.0, 80.0)),
        (7.2, (80.0, 0.0)),
        (7.4, (76.0, 0.0)),
        (8.6, (0.0, 0.0)),
    ),
    moves=(
        Move("hand", 0.5, 1.0, forward=-0.42, lift_m=0.04),
        Move("other", 2.45, 3.15, forward=-0.42, lift_m=0.02),
        Move("other", 6.5, 7.2, forward=0.0, lift_m=0.05),
        Move("hand", 8.65, 9.2, forward=0.0, lift_m=0.04),
    ),
    shakes=(
        Shake("shrug", 2.2, 1.3, 3.8, 6.2, fade_s=0.8),
        Shake("trunk_pitch", 1.3, 1.3, 3.8, 6.2, fade_s=0.8, shift=0.2),
    ),
)
"""Sinks on one knee, then on both, sits back, head down, arms limp; gets up again slowly."""


_DESPAIR = Script(
    duration_s=8.6,
    plain_s=8.0,
    hand=(
        (0.0, _LIMP),
        (0.5, _LIMP),
        (2.0, TEMPLE),
        (5.2, TEMPLE),
        (6.1, BOTH_ON_FACE),
        (6.9, BOTH_ON_FACE.moved(up=-0.05)),
        (8.0, _LIMP),
    ),
    other=(
        (0.0, _LIMP),
        (0.7, _LIMP),
        (2.2, TEMPLE),
        (5.2, TEMPLE.moved(up=0.01)),
        (6.1, BOTH_ON_FACE),
        (6.9, BOTH_ON_FACE.moved(up=-0.05)),
        (8.1, _LIMP),
    ),
    trunk=keys(
        (0, 1.9, 3.6, 5, 6.4, 8),
        (0, -4, 14, 17, 10, 0),
        (0, 0, 0, 0, 0, 0),
        (0, 0, 3, -3, 0, 0),
    ),
    look=keys(
        (0, 1.9, 3.4, 5, 6.4, 8),
        (0, -10, 16, 18, 12, 0),
        (0, 0, 0, 0, 0, 0),
        (0, 0, 4, -4, 0, 0),
    ),
    shrug=((0.0, 0.0), (2.0, 6.0), (5.0, 6.0), (7.8, 0.0)),
    pelvis=keys(
        (0, 2, 3.8, 5.2, 7.2),
        (0, 0, 0.03, -0.03, 0),
        (0, 0, -0.06, -0.07, -0.02),
        (0, 0.02, 0, 0, 0),
    ),
    moves=(
        Move("hand", 2.5, 3.2, forward=-0.14, lift_m=0.03),
        Move("hand", 7.3, 8.0, lift_m=0.03),
    ),
    shakes=(Shake("look_yaw", 15.0, 0.55, 2.2, 5.9, fade_s=0.9),),
)
"""Both hands to the head, which shakes slowly; bends under it; hands slide down the face."""


_SIGH = Script(
    duration_s=8.8,
    plain_s=7.8,
    hand=((0.0, _LIMP), (1.3, HANGING.moved(out=0.02)), (2.6, _LIMP), (6.0, _LIMP)),
    other=((0.0, _LIMP), (1.3, HANGING.moved(out=0.02)), (2.6, _LIMP), (6.0, _LIMP)),
    trunk=keys(
        (0, 1.3, 1.6, 2.9, 5, 6.6, 8.2),
        (0, -11, -10, 9, 8, 9, 0),
        (0, 0, 0, 4, 14, -8, 0),
        (0, 0, 0, 3, 4, -3, 0),
    ),
    look=keys(
        (0, 1.3, 1.6, 2.9, 4.8, 6.6, 8.2),
        (0, -30, -28, 14, 14, 15, 0),
        (0, 0, 0, 4, 26, -16, 0),
        (0, 0, 0, 4, 6, -6, 0),
    ),
    shrug=((0.0, 0.0), (1.3, 13.0), (1.7, 12.0), (2.8, -5.0), (7.0, -3.0)),
    pelvis=keys(
        (0, 1.4, 2.9, 4.9, 6.7, 8.2),
        (0, 0, -0.03, 0.045, -0.04, 0),
        (0, 0.012, -0.025, -0.03, -0.025, 0),
        (0, 0, 0, 0, 0, 0),
    ),
    moves=(
        Move("hand", 3.3, 4.3, side=0.12, forward=0.12, heading_deg=16.0, lift_m=0.012),
        Move("other", 4.6, 5.5, side=0.05, forward=0.10, heading_deg=12.0, lift_m=0.012),
        Move("hand", 6.0, 6.9, lift_m=0.012),
        Move("other", 7.2, 8.1, lift_m=0.012),
    ),
)
"""Breathes in deeply, lets the shoulders fall, looks at the floor, drags a foot aside and back."""


_SELF_EMBRACE = Script(
    duration_s=9.0,
    plain_s=8.0,
    stance=0.85,
    hand=(
        (0.0, HUG_OVER),
        (2.5, HUG_OVER.moved(up=0.01)),
        (5.0, HUG_OVER.moved(up=0.03)),
        (7.0, HUG_OVER.moved(up=0.01)),
    ),
    other=(
        (0.0, HUG_UNDER),
        (3.0, HUG_UNDER.moved(up=0.01)),
        (6.0, HUG_UNDER),
    ),
    trunk=keys(
        (0, 1.8, 3.6, 5.4, 7.2),
        (6, 8, 10, 14, 10),
        (0, 4, -4, 4, -4),
        (0, 6, -6, 6, -6),
    ),
    look=keys(
        (0, 1.9, 3.7, 5.5, 7.3),
        (8, 10, 12, 18, 12),
        (0, 6, -6, 6, -6),
        (0, 9, -9, 9, -9),
    ),
    shrug=((0.0, 8.0), (4.5, 11.0), (6.5, 9.0)),
    pelvis=keys(
        (0, 1.8, 3.6, 5.4, 7.2),
        (0, 0.05, -0.05, 0.05, -0.05),
        (-0.02, -0.025, -0.03, -0.04, -0.03),
        (0, 0, 0, 0, 0),
    ),
    shakes=(Shake("shrug", 1.8, 1.4, 4.4, 7.4, fade_s=0.9),),
)
"""Wraps both arms round the own body, sinks over them and sways, alone."""


SCRIPTS = {
    "mourn": _MOURN,
    "collapse": _COLLAPSE,
    "despair": _DESPAIR,
    "sigh": _SIGH,
    "self_embrace": _SELF_EMBRACE,
}
