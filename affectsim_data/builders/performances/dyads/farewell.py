"""Hand in hand; the target lets go slowly, the partner steps back and waves, the head sinks."""

from __future__ import annotations

from affectsim_data.builders.performances.dyads.interaction import (
    Clasp,
    Interaction,
    Look,
    Role,
    Spot,
)
from affectsim_data.builders.performances.scenarios.vocabulary import (
    HANGING,
    HEART,
    TALK,
    ArmPose,
    Move,
    Script,
    Shake,
)

__all__ = ["INTERACTION"]

_HOLDING = ArmPose((-0.03, -0.34, 0.32), (0.4, -1.0, -0.4), palm_deg=70.0)
_HELD = ArmPose((-0.03, -0.30, 0.34), (0.5, -1.0, -0.3), palm_deg=-70.0)

INTERACTION = Interaction(
    "farewell",
    "sad",
    Role(
        Script(
            duration_s=9.4,
            plain_s=8.6,
            deep=True,
            hand=(
                (0.0, HANGING),
                (0.30, HANGING),
                (1.40, _HOLDING),
                (5.00, _HOLDING.moved(forward=0.04)),
                (5.70, _HOLDING.moved(up=-0.06, forward=0.02)),
                (7.20, HEART),
                (7.80, HEART),
                (9.00, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (0.50, HANGING),
                (1.60, _HOLDING),
                (3.60, _HOLDING),
                (4.80, HANGING),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.5, (3.0, 0.0, 0.0)),
                (4.6, (4.0, -5.0, 0.0)),
                (5.8, (6.0, -8.0, 0.0)),
                (7.4, (8.0, 0.0, 3.0)),
                (8.8, (0.0, 0.0, 0.0)),
            ),
            look=(
                (0.0, (2.0, 0.0, 0.0)),
                (1.5, (8.0, 0.0, 4.0)),
                (3.4, (0.0, 0.0, 6.0)),
                (5.6, (2.0, 0.0, 0.0)),
                (7.2, (16.0, 8.0, 0.0)),
                (8.4, (14.0, 6.0, 0.0)),
            ),
            shakes=(
                Shake("trunk_pitch", 0.9, 2.2, 6.8, 8.4, fade_s=0.4),
                Shake("shrug", 2.5, 2.2, 6.8, 8.4, fade_s=0.4),
                Shake("look_yaw", 4.0, 0.8, 2.0, 3.6, fade_s=0.5),
            ),
        ),
        looks=(
            Look(
                (
                    (0.0, 0.0),
                    (1.8, 0.1),
                    (2.6, 0.6),
                    (3.6, 0.6),
                    (4.4, 0.1),
                    (5.2, 0.4),
                    (6.0, 0.4),
                    (6.9, 0.0),
                )
            ),
        ),
    ),
    Role(
        Script(
            duration_s=9.4,
            plain_s=8.6,
            deep=True,
            hand=(
                (0.0, HANGING),
                (0.70, HANGING),
                (1.50, _HELD),
                (4.80, _HELD.moved(forward=0.08)),
                (5.50, _HELD.moved(up=0.06, forward=-0.08)),
                (6.60, TALK.moved(out=0.06, up=0.16).turned(-60.0)),
                (7.00, TALK.moved(out=0.10, up=0.17).turned(-60.0)),
                (7.40, TALK.moved(out=0.05, up=0.16).turned(-60.0)),
                (8.40, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (0.80, HANGING),
                (1.70, _HELD),
                (3.60, _HELD),
                (4.70, HANGING),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.6, (-6.0, 0.0, 0.0)),
                (4.4, (-6.0, -4.0, 0.0)),
                (6.2, (-10.0, 0.0, 0.0)),
                (7.6, (-8.0, 3.0, 0.0)),
                (8.6, (0.0, 0.0, 0.0)),
            ),
            look=((0.0, (-6.0, 0.0, 0.0)), (3.0, (-10.0, 0.0, -6.0)), (7.0, (-12.0, 0.0, 0.0))),
            shakes=(Shake("look_pitch", 3.0, 1.1, 2.2, 3.8),),
            moves=(
                Move("other", 5.00, 5.60, forward=-0.20),
                Move("hand", 5.55, 6.20, forward=-0.18),
                Move("hand", 7.70, 8.30),
                Move("other", 8.20, 8.80),
            ),
        ),
        looks=(Look(((0.0, 0.3), (1.6, 0.8), (7.4, 0.8), (8.4, 0.3))),),
    ),
    forward_m=0.92,
    hands="mirrored",
    clasps=(
        Clasp(
            "hand",
            "hand",
            (
                (0.0, Spot(0.13, 0.98, 0.46)),
                (2.2, Spot(0.13, 1.02, 0.46)),
                (4.4, Spot(0.13, 1.00, 0.46)),
                (5.3, Spot(0.12, 1.00, 0.52)),
            ),
            ((0.0, 0.0), (0.80, 0.0), (1.60, 1.0), (5.00, 1.0), (5.80, 0.0)),
        ),
        Clasp(
            "other",
            "other",
            ((0.0, Spot(-0.13, 0.98, 0.46)), (2.2, Spot(-0.13, 1.02, 0.46))),
            ((0.0, 0.0), (1.00, 0.0), (1.80, 1.0), (3.50, 1.0), (4.30, 0.0)),
        ),
    ),
)
