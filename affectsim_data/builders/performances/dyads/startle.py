"""The partner leaps up with raised arms; the target starts, backs off and calms down."""

from __future__ import annotations

from affectsim_data.builders.performances.dyads.interaction import (
    Interaction,
    Look,
    Role,
)
from affectsim_data.builders.performances.scenarios.vocabulary import (
    BELLY,
    CLASPED,
    GUARD,
    HANGING,
    HEART,
    OVERHEAD,
    TALK,
    ArmPose,
    Hop,
    Move,
    Script,
    Shake,
)

__all__ = ["INTERACTION"]

_READY = HANGING.moved(up=0.20, forward=0.16)
"""Arms drawn up a little, as the anxious hold them."""
_RISING = ArmPose((0.10, -0.06, 0.34), (0.8, -1.0, -0.2), palm_deg=-50.0)
_CLAW = OVERHEAD.moved(out=0.02, up=-0.08, forward=0.14).turned(-80.0, 15.0)
_SLOUCH = HANGING.moved(up=0.06, forward=0.08)

INTERACTION = Interaction(
    "startle",
    "happy",
    Role(
        Script(
            duration_s=6.4,
            plain_s=6.0,
            hand=(
                (0.0, _READY),
                (1.15, _READY),
                (1.50, GUARD),
                (2.40, GUARD.moved(up=-0.03)),
                (3.20, HEART),
                (4.60, HEART),
                (5.60, _READY),
            ),
            other=(
                (0.0, _READY),
                (1.15, _READY),
                (1.48, GUARD.moved(up=-0.06, forward=0.03)),
                (2.50, GUARD.moved(up=-0.08)),
                (3.60, CLASPED),
                (4.80, CLASPED),
                (5.70, _READY),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.15, (0.0, 0.0, 0.0)),
                (1.50, (-22.0, -14.0, -5.0)),
                (2.40, (-12.0, -10.0, -4.0)),
                (3.30, (4.0, 0.0, 0.0)),
                (4.80, (6.0, 0.0, 0.0)),
            ),
            look=(
                (0.0, (6.0, 0.0, 0.0)),
                (0.4, (8.0, 20.0, 0.0)),
                (0.9, (6.0, 12.0, 0.0)),
                (1.5, (8.0, -22.0, -8.0)),
                (2.1, (6.0, -14.0, -5.0)),
                (3.3, (20.0, 0.0, 0.0)),
                (4.2, (24.0, 0.0, 0.0)),
                (5.2, (4.0, 0.0, 0.0)),
            ),
            shrug=((0.0, 0.0), (1.15, 0.0), (1.45, 14.0), (2.4, 10.0), (3.6, 0.0)),
            pelvis=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.15, (0.0, 0.0, 0.0)),
                (1.45, (0.0, -0.09, -0.04)),
                (2.40, (0.0, -0.06, -0.02)),
                (3.60, (0.0, -0.01, 0.0)),
            ),
            shakes=(
                Shake("trunk_pitch", 2.5, 1.7, 3.2, 5.2),
                Shake("shrug", 3.0, 1.7, 3.2, 5.2),
                Shake("look_yaw", 4.0, 4.0, 1.6, 2.6),
            ),
            moves=(
                Move("hand", 1.28, 1.55, forward=-0.26, lift_m=0.09),
                Move("other", 1.50, 1.80, forward=-0.28, lift_m=0.08),
                Move("hand", 5.00, 5.45),
                Move("other", 5.40, 5.85),
            ),
        ),
        looks=(Look(((0.0, 0.0), (1.2, 0.0), (2.2, 0.8), (3.0, 0.8), (3.4, 0.0), (5.2, 0.7))),),
    ),
    Role(
        Script(
            duration_s=6.4,
            plain_s=6.0,
            hand=(
                (0.0, _SLOUCH),
                (0.55, HANGING.moved(up=0.22, forward=0.20)),
                (0.80, HANGING.moved(up=0.20, forward=0.16)),
                (0.96, _RISING),
                (1.16, _CLAW),
                (1.70, _CLAW.moved(up=-0.05)),
                (2.30, TALK.moved(up=0.10, forward=0.05)),
                (2.90, BELLY),
                (4.10, BELLY),
                (4.60, TALK.moved(up=0.14, forward=0.04)),
                (5.00, TALK.moved(up=0.06)),
                (5.80, _SLOUCH),
            ),
            other=(
                (0.0, _SLOUCH),
                (0.60, HANGING.moved(up=0.22, forward=0.20)),
                (0.80, HANGING.moved(up=0.20, forward=0.16)),
                (0.96, _RISING),
                (1.16, _CLAW),
                (1.70, _CLAW.moved(up=-0.07)),
                (2.60, HANGING.moved(out=0.08, up=0.10, forward=0.12)),
                (4.30, HANGING.moved(out=0.06, up=0.06, forward=0.10)),
                (5.20, _SLOUCH),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.70, (14.0, 0.0, 0.0)),
                (1.12, (-2.0, 0.0, 0.0)),
                (1.60, (3.0, 0.0, 0.0)),
                (2.20, (-10.0, 0.0, 3.0)),
                (3.00, (12.0, 4.0, 0.0)),
                (4.00, (8.0, -3.0, 0.0)),
                (5.20, (0.0, 0.0, 0.0)),
            ),
            look=((0.0, (0.0, 0.0, 0.0)), (2.2, (-12.0, 0.0, 0.0)), (3.0, (12.0, 0.0, 0.0))),
            pelvis=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.75, (0.0, -0.10, 0.0)),
                (1.0, (0.0, 0.0, 0.02)),
                (1.6, (0.0, -0.04, 0.0)),
                (2.4, (0.0, 0.0, 0.0)),
            ),
            shakes=(
                Shake("trunk_pitch", 2.5, 3.6, 2.1, 4.3),
                Shake("shrug", 4.0, 3.6, 2.1, 4.3),
            ),
            moves=(
                Move("hand", 0.95, 1.20, forward=0.24, lift_m=0.03),
                Move("other", 0.95, 1.20, forward=0.24, lift_m=0.03),
                Move("hand", 4.50, 4.95),
                Move("other", 4.90, 5.35),
            ),
            hops=(Hop(0.96, 1.19, 0.05),),
        ),
        looks=(Look(((0.0, 0.9), (1.9, 0.9), (2.3, 0.2), (3.1, 0.2), (3.8, 0.9))),),
    ),
    forward_m=1.35,
)
