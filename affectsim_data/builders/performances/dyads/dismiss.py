"""The target waves the partner off, turns away, arms folded, and comes back to wave again."""

from __future__ import annotations

from affectsim_data.builders.performances.dyads.interaction import (
    Interaction,
    Look,
    Role,
)
from affectsim_data.builders.performances.scenarios.vocabulary import (
    FOLDED_OVER,
    FOLDED_UNDER,
    HANGING,
    OPEN,
    STOP,
    TALK,
    Move,
    Script,
    Shake,
)

__all__ = ["INTERACTION"]

_FENDING = STOP.moved(out=0.04, up=-0.16, forward=-0.10)
"""Palm held low before the chest."""
_SWEEP = TALK.moved(out=-0.20, up=0.12, forward=0.04).turned(-60.0, 20.0)
_FLUNG = OPEN.moved(out=0.05, up=0.05).turned(-40.0, -30.0)

INTERACTION = Interaction(
    "dismiss",
    "neutral",
    Role(
        Script(
            duration_s=7.4,
            plain_s=8.4,
            hand=(
                (0.0, HANGING),
                (0.32, _SWEEP),
                (0.56, _FLUNG),
                (0.80, _SWEEP),
                (1.04, _FLUNG),
                (1.28, _SWEEP),
                (1.52, _FLUNG),
                (1.95, HANGING.moved(up=0.08, forward=0.05)),
                (2.50, FOLDED_OVER),
                (4.40, FOLDED_OVER),
                (4.74, _SWEEP),
                (4.98, _FLUNG),
                (5.22, _SWEEP),
                (5.46, _FLUNG),
                (5.80, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (1.60, HANGING.moved(up=0.06)),
                (2.55, FOLDED_UNDER),
                (4.60, FOLDED_UNDER),
                (5.50, HANGING.moved(up=0.06)),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.32, (5.0, -10.0, 0.0)),
                (0.56, (7.0, 8.0, 0.0)),
                (0.80, (4.0, -10.0, 0.0)),
                (1.04, (8.0, 8.0, 0.0)),
                (1.28, (4.0, -10.0, 0.0)),
                (1.52, (8.0, 8.0, 0.0)),
                (2.50, (-3.0, 0.0, 0.0)),
                (4.40, (-2.0, 0.0, 0.0)),
                (4.80, (3.0, 12.0, 0.0)),
                (5.10, (4.0, 22.0, 0.0)),
                (5.80, (0.0, 0.0, 0.0)),
            ),
            look=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.40, (0.0, -5.0, 0.0)),
                (2.00, (-4.0, -28.0, 0.0)),
                (4.30, (-6.0, -12.0, 0.0)),
                (4.80, (0.0, 42.0, 0.0)),
                (5.30, (0.0, 20.0, 0.0)),
                (5.90, (0.0, 0.0, 0.0)),
            ),
            shakes=(
                Shake("look_yaw", 9.0, 1.6, 2.6, 4.1),
                Shake("shrug", 4.0, 0.6, 2.7, 4.3),
            ),
            moves=(
                Move("other", 1.45, 1.85, heading_deg=-50.0, lift_m=0.07),
                Move("hand", 1.80, 2.25, heading_deg=-105.0, lift_m=0.07),
                Move("other", 2.20, 2.55, heading_deg=-105.0),
                Move("hand", 5.20, 5.60, heading_deg=-55.0, lift_m=0.07),
                Move("other", 5.55, 6.00, heading_deg=0.0, lift_m=0.07),
                Move("hand", 5.95, 6.30, heading_deg=0.0),
            ),
        ),
        looks=(Look(((0.0, 0.9), (1.4, 0.9), (1.9, 0.0), (6.0, 0.0), (6.6, 0.9))),),
    ),
    Role(
        Script(
            duration_s=7.4,
            plain_s=8.4,
            hand=(
                (0.0, HANGING),
                (0.70, HANGING),
                (1.20, _FENDING.moved(up=-0.04)),
                (1.80, TALK),
                (2.50, OPEN.moved(out=-0.08)),
                (3.00, TALK.moved(forward=0.10, up=0.06)),
                (3.60, OPEN),
                (4.20, OPEN.moved(up=-0.04)),
                (5.00, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (1.60, HANGING),
                (2.50, OPEN.moved(out=-0.08, up=-0.06)),
                (3.10, TALK),
                (3.60, OPEN.moved(up=-0.02)),
                (4.20, OPEN.moved(up=-0.06)),
                (5.00, HANGING),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.8, (-5.0, 0.0, 0.0)),
                (1.6, (-2.0, 4.0, 0.0)),
                (2.6, (6.0, -4.0, 0.0)),
                (3.4, (6.0, 4.0, 3.0)),
                (4.6, (0.0, 0.0, 0.0)),
                (5.4, (5.0, 0.0, 0.0)),
                (6.6, (0.0, 0.0, 0.0)),
            ),
            shrug=((0.0, 0.0), (3.3, 0.0), (3.7, 14.0), (4.1, 12.0), (4.7, -3.0), (6.0, 0.0)),
            look=(
                (0.0, (0.0, 0.0, 0.0)),
                (4.6, (0.0, 0.0, 0.0)),
                (5.2, (22.0, 10.0, 0.0)),
                (5.9, (20.0, 8.0, 0.0)),
            ),
            shakes=(Shake("look_pitch", 3.0, 1.6, 1.8, 3.2),),
            pelvis=((0.0, (0.0, 0.0, 0.0)), (2.6, (0.0, 0.0, 0.03)), (4.8, (0.03, 0.0, -0.02))),
        ),
        looks=(Look(((0.0, 0.9), (4.4, 0.9), (4.9, 0.0), (5.9, 0.0), (6.5, 0.9))),),
    ),
    forward_m=1.15,
)
