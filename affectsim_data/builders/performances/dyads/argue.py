"""Both gesture in turns and talk across each other; the target is the louder."""

from __future__ import annotations

from affectsim_data.builders.performances.dyads.interaction import (
    Interaction,
    Look,
    Role,
)
from affectsim_data.builders.performances.scenarios.vocabulary import (
    AKIMBO,
    FIST_HIGH,
    FOLDED_OVER,
    FOLDED_UNDER,
    HANGING,
    HEART,
    OPEN,
    POINT,
    STOP,
    TALK,
    Move,
    Script,
    Shake,
)

__all__ = ["INTERACTION"]

_STAB = POINT.moved(up=-0.10, forward=-0.16)
"""Where a pointing hand draws back to before it points again."""
_CHOP_UP = FIST_HIGH.moved(out=-0.02, up=-0.12)
_CHOP_DOWN = TALK.moved(up=0.04).turned(0.0)
_FENDING = STOP.moved(out=0.04, up=-0.16, forward=-0.10)
"""Palm held low before the chest."""

INTERACTION = Interaction(
    "argue",
    "angry",
    Role(
        Script(
            duration_s=7.4,
            plain_s=8.4,
            hand=(
                (0.0, HANGING),
                (0.45, POINT),
                (0.70, _STAB),
                (0.95, POINT),
                (1.20, _STAB),
                (1.45, POINT),
                (1.85, _CHOP_UP),
                (2.15, _CHOP_DOWN),
                (2.50, _CHOP_UP),
                (2.80, _CHOP_DOWN),
                (3.40, AKIMBO),
                (4.80, AKIMBO),
                (5.10, _STAB),
                (5.40, STOP),
                (5.70, OPEN),
                (6.05, POINT),
                (6.30, _STAB),
                (6.50, POINT),
                (7.10, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (1.45, HANGING),
                (1.85, _CHOP_UP),
                (2.15, _CHOP_DOWN),
                (2.50, _CHOP_UP),
                (2.80, _CHOP_DOWN),
                (3.40, AKIMBO),
                (6.60, AKIMBO),
                (7.20, HANGING),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.45, (9.0, -10.0, 0.0)),
                (0.70, (4.0, -4.0, 0.0)),
                (0.95, (10.0, -10.0, 0.0)),
                (1.20, (4.0, -4.0, 0.0)),
                (1.45, (10.0, -10.0, 0.0)),
                (1.85, (-3.0, 0.0, 0.0)),
                (2.15, (10.0, 0.0, 0.0)),
                (2.50, (-3.0, 0.0, 0.0)),
                (2.80, (11.0, 0.0, 0.0)),
                (3.40, (-2.0, 5.0, 0.0)),
                (5.00, (0.0, 4.0, 0.0)),
                (5.40, (7.0, -6.0, 0.0)),
                (6.50, (10.0, -9.0, 0.0)),
            ),
            shakes=(
                Shake("look_yaw", 9.0, 1.7, 3.5, 5.0),
                Shake("look_pitch", 3.0, 2.0, 0.3, 2.9),
                Shake("hand_up", 0.03, 3.2, 0.4, 1.7),
                Shake("hand_up", 0.03, 3.2, 5.9, 6.8),
                Shake("look_pitch", 3.0, 2.0, 5.4, 6.8),
            ),
            pelvis=((0.0, (0.0, 0.0, 0.0)), (1.2, (0.01, -0.01, 0.02)), (3.6, (-0.03, 0.0, -0.02))),
            moves=(
                Move("other", 1.60, 2.10, lift_m=0.10),
                Move("other", 2.25, 2.75, lift_m=0.10),
            ),
        ),
        looks=(Look(((0.0, 0.9),)),),
    ),
    Role(
        Script(
            duration_s=7.4,
            plain_s=8.4,
            hand=(
                (0.0, HANGING),
                (0.75, FOLDED_OVER),
                (2.60, FOLDED_OVER),
                (3.20, OPEN),
                (3.55, HEART),
                (3.95, OPEN.moved(up=0.08)),
                (4.30, TALK),
                (4.60, TALK.moved(up=0.12)),
                (4.90, TALK),
                (5.70, _FENDING),
                (6.60, _FENDING.moved(up=-0.05)),
                (7.20, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (0.80, FOLDED_UNDER),
                (2.60, FOLDED_UNDER),
                (3.20, OPEN.moved(up=-0.05)),
                (3.70, TALK),
                (4.00, OPEN),
                (4.60, TALK.moved(up=0.05)),
                (5.75, _FENDING.moved(up=-0.04)),
                (6.60, _FENDING.moved(up=-0.08)),
                (7.20, HANGING),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.8, (-12.0, 8.0, 0.0)),
                (2.4, (-14.0, 8.0, 0.0)),
                (3.2, (2.0, -5.0, 0.0)),
                (4.6, (4.0, 5.0, 0.0)),
                (5.7, (-12.0, 4.0, 0.0)),
                (6.8, (-6.0, 0.0, 0.0)),
            ),
            shakes=(
                Shake("look_yaw", 8.0, 1.4, 1.1, 2.4),
                Shake("look_pitch", 3.0, 1.8, 3.2, 5.0),
                Shake("hand_up", 0.03, 2.6, 3.3, 5.1),
                Shake("other_up", 0.03, 2.6, 3.3, 5.0, shift=0.2),
            ),
            pelvis=((0.0, (0.0, 0.0, 0.0)), (1.5, (0.03, 0.0, -0.02)), (4.0, (-0.01, -0.01, 0.02))),
        ),
        looks=(Look(((0.0, 0.9), (1.6, 0.9), (2.0, 0.4), (2.5, 0.9))),),
    ),
    forward_m=1.25,
)
