"""The target points, advances a step and drives the partner back one."""

from __future__ import annotations

from affectsim_data.builders.performances.dyads.interaction import (
    Interaction,
    Look,
    Role,
)
from affectsim_data.builders.performances.scenarios.vocabulary import (
    AKIMBO,
    HANGING,
    HEART,
    OPEN,
    POINT,
    STOP,
    Move,
    Script,
    Shake,
)

__all__ = ["INTERACTION"]

_STAB = POINT.moved(up=-0.10, forward=-0.16)
"""Where a pointing hand draws back to before it points again."""
_FENDING = STOP.moved(out=0.04, up=-0.16, forward=-0.10)
"""Palm held low before the chest."""

INTERACTION = Interaction(
    "accuse",
    "fearful",
    Role(
        Script(
            duration_s=6.6,
            plain_s=7.6,
            hand=(
                (0.0, HANGING),
                (0.30, HANGING),
                (0.75, POINT.moved(up=0.04)),
                (1.15, _STAB),
                (1.40, POINT),
                (1.65, _STAB),
                (1.90, POINT),
                (2.15, _STAB),
                (2.40, POINT.moved(up=0.05)),
                (3.10, POINT.moved(up=0.03)),
                (3.60, AKIMBO),
                (4.15, AKIMBO),
                (4.45, _STAB),
                (4.70, POINT),
                (4.95, _STAB),
                (5.15, POINT),
                (6.00, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (0.6, HANGING.moved(out=0.05, up=0.06, forward=-0.02)),
                (3.0, HANGING.moved(out=0.05, up=0.06, forward=-0.02)),
                (3.60, AKIMBO),
                (5.20, AKIMBO),
                (6.00, HANGING),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.75, (9.0, -12.0, 0.0)),
                (1.15, (5.0, -6.0, 0.0)),
                (1.40, (11.0, -12.0, 0.0)),
                (1.65, (6.0, -6.0, 0.0)),
                (1.90, (11.0, -12.0, 0.0)),
                (2.15, (6.0, -6.0, 0.0)),
                (2.40, (12.0, -13.0, 0.0)),
                (3.60, (3.0, 0.0, 0.0)),
                (4.65, (10.0, -10.0, 0.0)),
                (5.20, (9.0, -9.0, 0.0)),
                (6.20, (0.0, 0.0, 0.0)),
            ),
            shakes=(
                Shake("look_pitch", 3.5, 2.0, 0.9, 2.8),
                Shake("hand_up", 0.03, 3.2, 1.0, 3.3),
                Shake("hand_up", 0.03, 3.2, 4.5, 5.5),
                Shake("look_yaw", 8.0, 1.7, 3.3, 4.4),
            ),
            moves=(
                Move("hand", 0.45, 0.85, forward=0.26),
                Move("other", 0.80, 1.20, forward=0.26),
                Move("other", 5.30, 5.75, forward=0.0),
                Move("hand", 5.70, 6.15, forward=0.0),
            ),
        ),
        looks=(Look(((0.0, 0.95),)),),
    ),
    Role(
        Script(
            duration_s=6.6,
            plain_s=7.6,
            hand=(
                (0.0, HANGING.moved(up=0.05, forward=0.05)),
                (0.85, HANGING.moved(up=0.05, forward=0.05)),
                (1.30, _FENDING.moved(up=0.06)),
                (2.90, _FENDING),
                (3.40, HEART),
                (3.90, OPEN.moved(out=-0.10, up=-0.08)),
                (4.60, OPEN.moved(out=-0.10, up=-0.10)),
                (5.00, _FENDING),
                (5.50, _FENDING.moved(up=-0.05)),
                (6.20, HANGING.moved(up=0.05, forward=0.05)),
            ),
            other=(
                (0.0, HANGING.moved(up=0.05, forward=0.05)),
                (0.95, HANGING.moved(up=0.05, forward=0.05)),
                (1.40, _FENDING),
                (2.90, _FENDING.moved(up=-0.06)),
                (3.90, OPEN.moved(out=-0.10, up=-0.12)),
                (4.60, OPEN.moved(out=-0.10, up=-0.12)),
                (5.05, _FENDING.moved(up=-0.02)),
                (5.50, _FENDING.moved(up=-0.08)),
                (6.20, HANGING.moved(up=0.05, forward=0.05)),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.7, (0.0, 0.0, 0.0)),
                (1.3, (-16.0, 6.0, 3.0)),
                (2.8, (-14.0, 8.0, 3.0)),
                (3.6, (-6.0, 0.0, 0.0)),
                (5.0, (-12.0, -4.0, 0.0)),
                (6.2, (0.0, 0.0, 0.0)),
            ),
            shrug=((0.0, 0.0), (1.3, 6.0), (2.8, 5.0), (3.9, 12.0), (4.5, 10.0), (6.2, 0.0)),
            look=((0.0, (0.0, 0.0, 0.0)), (2.1, (14.0, 12.0, 0.0)), (2.7, (14.0, 12.0, 0.0))),
            shakes=(Shake("look_yaw", 8.0, 2.0, 3.4, 4.6),),
            moves=(
                Move("other", 0.80, 1.15, forward=-0.26),
                Move("hand", 1.10, 1.50, forward=-0.26),
                Move("hand", 5.55, 6.00, forward=0.0),
                Move("other", 5.95, 6.40, forward=0.0),
            ),
        ),
        looks=(Look(((0.0, 0.9), (1.9, 0.9), (2.3, 0.2), (2.8, 0.2), (3.2, 0.9))),),
    ),
    forward_m=1.28,
)
