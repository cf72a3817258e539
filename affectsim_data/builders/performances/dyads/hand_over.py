"""The target takes a small thing from a pocket; hands meet, the partner looks at it."""

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
    TALK,
    ArmPose,
    Script,
    Shake,
)

__all__ = ["INTERACTION"]

_LOW_TALK = TALK.moved(up=-0.03, forward=-0.03)
_BEAT = TALK.moved(out=0.05, up=0.06, forward=0.02)
_GIVING = ArmPose((-0.04, -0.28, 0.42), (0.4, -1.0, -0.3), palm_deg=70.0)
_TAKING = ArmPose((-0.04, -0.24, 0.42), (0.5, -1.0, -0.2), palm_deg=-70.0)
_POCKET = ArmPose((0.16, -0.06, 0.10), (0.7, 0.2, -1.0), anchor="pelvis")
_READING = ArmPose((-0.06, -0.18, 0.26), (0.5, -1.0, -0.2), palm_deg=60.0)

INTERACTION = Interaction(
    "hand_over",
    "neutral",
    Role(
        Script(
            duration_s=6.8,
            plain_s=6.8,
            hand=(
                (0.0, HANGING),
                (0.60, _POCKET),
                (0.95, _POCKET),
                (1.45, _READING.moved(up=-0.06)),
                (2.10, _GIVING),
                (2.65, _GIVING),
                (3.05, _GIVING.moved(out=0.04, up=-0.08, forward=-0.14)),
                (3.70, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (3.60, HANGING),
                (4.20, _LOW_TALK),
                (4.70, _BEAT),
                (5.40, HANGING),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.7, (2.0, 8.0, 4.0)),
                (1.5, (3.0, 2.0, 0.0)),
                (2.2, (6.0, -8.0, 0.0)),
                (2.8, (5.0, -8.0, 0.0)),
                (3.8, (0.0, 0.0, 0.0)),
            ),
            look=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.7, (26.0, 14.0, 0.0)),
                (1.3, (28.0, 4.0, 0.0)),
                (2.0, (14.0, 0.0, 0.0)),
            ),
            shakes=(
                Shake("look_pitch", 4.0, 1.6, 4.3, 5.2),
                Shake("other_up", 0.03, 1.9, 3.9, 5.2),
            ),
            pelvis=((0.0, (0.0, 0.0, 0.0)), (2.3, (0.01, 0.0, 0.02)), (4.2, (-0.03, 0.0, 0.0))),
        ),
        looks=(
            Look(
                ((0.0, 0.9), (0.3, 0.9), (0.7, 0.0), (1.6, 0.0), (2.0, 0.2), (2.4, 0.0), (2.9, 0.9))
            ),
            Look(((0.0, 0.0), (1.6, 0.0), (2.1, 0.7), (2.5, 0.8), (2.9, 0.0)), at="hand"),
        ),
    ),
    Role(
        Script(
            duration_s=6.8,
            plain_s=6.8,
            hand=(
                (0.0, HANGING),
                (1.50, HANGING),
                (2.10, _TAKING),
                (2.80, _TAKING),
                (3.40, _READING),
                (4.70, _READING.moved(up=0.03)),
                (5.40, _POCKET),
                (5.70, _POCKET),
                (6.30, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (3.00, HANGING),
                (3.60, _READING.moved(out=0.02, up=-0.03)),
                (4.60, _READING.moved(out=0.03, up=-0.02)),
                (5.40, HANGING),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.5, (0.0, 0.0, 0.0)),
                (2.2, (6.0, -8.0, 0.0)),
                (2.8, (5.0, -6.0, 0.0)),
                (3.6, (4.0, 0.0, 0.0)),
                (5.5, (0.0, 6.0, 3.0)),
            ),
            look=(
                (0.0, (0.0, 0.0, 0.0)),
                (2.8, (16.0, 0.0, 0.0)),
                (3.4, (34.0, 0.0, 0.0)),
                (4.5, (32.0, 0.0, 0.0)),
                (5.0, (0.0, 0.0, 0.0)),
            ),
            shakes=(Shake("look_pitch", 4.5, 1.6, 4.9, 5.8),),
            pelvis=((0.0, (0.0, 0.0, 0.0)), (2.3, (0.01, 0.0, 0.02)), (4.6, (-0.03, 0.0, 0.0))),
        ),
        looks=(
            Look(
                ((0.0, 0.9), (1.2, 0.9), (1.7, 0.0), (4.5, 0.0), (5.0, 0.9), (5.5, 0.5), (6.2, 0.9))
            ),
            Look(((0.0, 0.0), (1.2, 0.0), (1.7, 0.8), (2.6, 0.8), (3.0, 0.0)), at="hand"),
        ),
    ),
    forward_m=1.0,
    hands="mirrored",
    clasps=(
        Clasp(
            "hand",
            "hand",
            ((0.0, Spot(0.12, 1.08, 0.50)),),
            ((0.0, 0.0), (1.70, 0.0), (2.20, 1.0), (2.65, 1.0), (3.10, 0.0)),
        ),
    ),
)
