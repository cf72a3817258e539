"""The partner looms with a raised fist; the target shrinks, arms over the head, peeks, shrinks."""

from __future__ import annotations

from affectsim_data.builders.performances.dyads.interaction import (
    Interaction,
    Look,
    Role,
)
from affectsim_data.builders.performances.scenarios.vocabulary import (
    AKIMBO,
    CLASPED,
    CROWN,
    FIST_HIGH,
    GUARD,
    HANGING,
    POINT,
    ArmPose,
    Move,
    Script,
    Shake,
)

__all__ = ["INTERACTION"]

_LOWERED = ArmPose((0.14, -0.20, 0.24), (0.9, -0.7, -0.4))
_READY = HANGING.moved(up=0.20, forward=0.16)
"""Arms drawn up a little, as the anxious hold them."""

INTERACTION = Interaction(
    "cower",
    "angry",
    Role(
        Script(
            duration_s=7.2,
            plain_s=6.6,
            hand=(
                (0.0, _READY),
                (0.75, _READY),
                (1.15, GUARD.moved(up=0.06)),
                (1.50, CROWN),
                (3.10, CROWN),
                (3.60, GUARD.moved(up=-0.04)),
                (4.05, GUARD),
                (4.45, CROWN),
                (5.60, CROWN),
                (6.20, CLASPED),
                (6.90, _READY),
            ),
            other=(
                (0.0, _READY),
                (0.75, _READY),
                (1.10, GUARD),
                (1.45, CROWN.moved(forward=0.04)),
                (3.15, CROWN.moved(forward=0.04)),
                (3.60, GUARD.moved(up=-0.10)),
                (4.05, GUARD.moved(up=-0.04)),
                (4.40, CROWN.moved(forward=0.04)),
                (5.60, CROWN.moved(forward=0.04)),
                (6.20, CLASPED),
                (6.90, _READY),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.75, (0.0, 0.0, 0.0)),
                (1.10, (-8.0, 10.0, 0.0)),
                (1.60, (26.0, 16.0, 4.0)),
                (3.10, (28.0, 16.0, 4.0)),
                (3.70, (12.0, 8.0, 0.0)),
                (4.05, (10.0, 8.0, 0.0)),
                (4.50, (32.0, 18.0, 5.0)),
                (5.50, (32.0, 18.0, 5.0)),
                (6.40, (8.0, 4.0, 0.0)),
            ),
            look=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.05, (0.0, 6.0, 0.0)),
                (1.55, (50.0, 22.0, 6.0)),
                (3.10, (52.0, 22.0, 6.0)),
                (3.65, (4.0, 0.0, 0.0)),
                (4.05, (0.0, 0.0, 0.0)),
                (4.50, (58.0, 24.0, 6.0)),
                (5.50, (56.0, 24.0, 6.0)),
                (6.30, (26.0, 8.0, 0.0)),
            ),
            shrug=((0.0, 0.0), (1.1, 10.0), (5.6, 12.0), (6.6, 2.0)),
            pelvis=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.80, (0.0, 0.0, 0.0)),
                (1.60, (0.0, -0.13, -0.02)),
                (3.10, (0.0, -0.13, -0.02)),
                (3.70, (0.0, -0.07, -0.02)),
                (4.10, (0.0, -0.07, -0.02)),
                (4.55, (0.0, -0.18, -0.02)),
                (5.50, (0.0, -0.18, -0.02)),
                (6.50, (0.0, -0.03, 0.0)),
            ),
            shakes=(
                Shake("trunk_roll", 1.2, 6.0, 1.6, 3.2),
                Shake("trunk_roll", 1.4, 6.0, 4.4, 5.8),
            ),
            moves=(
                Move("other", 0.90, 1.25, forward=-0.18),
                Move("hand", 1.20, 1.55, forward=-0.14),
                Move("hand", 6.05, 6.45),
                Move("other", 6.40, 6.85),
            ),
        ),
        looks=(Look(((0.0, 0.6), (1.0, 0.8), (1.3, 0.0), (6.6, 0.0), (7.0, 0.5))),),
    ),
    Role(
        Script(
            duration_s=7.2,
            plain_s=6.6,
            hand=(
                (0.0, HANGING),
                (0.20, HANGING),
                (0.50, _LOWERED),
                (0.85, FIST_HIGH.moved(up=0.10)),
                (1.70, FIST_HIGH.moved(up=0.06)),
                (1.95, FIST_HIGH.moved(up=-0.06, forward=0.08)),
                (2.20, FIST_HIGH.moved(up=0.06)),
                (2.45, FIST_HIGH.moved(up=-0.06, forward=0.08)),
                (2.90, POINT.moved(up=-0.16, forward=-0.14)),
                (3.50, POINT.moved(up=-0.16, forward=-0.16)),
                (4.00, FIST_HIGH.moved(up=0.12)),
                (4.90, FIST_HIGH.moved(up=0.08)),
                (5.40, _LOWERED),
                (5.90, AKIMBO),
                (6.20, AKIMBO),
                (6.90, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (0.75, HANGING.moved(out=0.06, up=0.10, forward=0.08)),
                (2.60, HANGING.moved(out=0.06, up=0.10, forward=0.08)),
                (5.10, HANGING.moved(out=0.06, up=0.10, forward=0.08)),
                (5.70, AKIMBO),
                (6.20, AKIMBO),
                (6.90, HANGING),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.75, (4.0, 12.0, 0.0)),
                (1.95, (9.0, 4.0, 0.0)),
                (2.20, (5.0, 10.0, 0.0)),
                (2.45, (9.0, 4.0, 0.0)),
                (3.20, (8.0, -8.0, 0.0)),
                (4.00, (3.0, 14.0, 0.0)),
                (4.60, (9.0, 6.0, 0.0)),
                (5.60, (0.0, 0.0, 0.0)),
            ),
            shakes=(Shake("look_pitch", 3.0, 2.0, 2.7, 3.6), Shake("hand_up", 0.02, 4.0, 4.1, 5.0)),
            moves=(
                Move("hand", 0.30, 0.75, forward=0.20),
                Move("other", 0.70, 1.10, forward=0.16),
                Move("other", 5.50, 5.95),
                Move("hand", 5.90, 6.35),
            ),
        ),
        looks=(Look(((0.0, 0.95),)),),
    ),
    forward_m=1.15,
)
