"""The target sobs into a hand; the partner lays a hand on the shoulder and speaks."""

from __future__ import annotations

from affectsim_data.builders.performances.dyads.interaction import (
    Interaction,
    Look,
    Role,
    Touch,
)
from affectsim_data.builders.performances.scenarios.vocabulary import (
    BELLY,
    FACE,
    HANGING,
    TALK,
    ArmPose,
    Script,
    Shake,
)

__all__ = ["INTERACTION"]

_LAYING = ArmPose((-0.04, -0.04, 0.46), (0.6, -1.0, -0.2), palm_deg=-80.0)
"""Arm out, palm down, to be laid on a shoulder."""
_SPEAKING = TALK.moved(out=0.10, up=-0.02, forward=-0.12)

INTERACTION = Interaction(
    "comfort",
    "neutral",
    Role(
        Script(
            duration_s=9.0,
            plain_s=8.2,
            hand=(
                (0.0, HANGING),
                (0.40, HANGING),
                (1.30, FACE),
                (5.80, FACE),
                (6.60, FACE.moved(out=0.03, up=-0.02)),
                (7.10, FACE.moved(out=0.04, up=-0.03)),
                (8.20, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (1.10, HANGING),
                (2.00, BELLY),
                (6.80, BELLY),
                (8.00, HANGING),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.4, (9.0, 0.0, 0.0)),
                (5.6, (9.0, 0.0, 0.0)),
                (7.0, (3.0, 0.0, 0.0)),
                (8.2, (0.0, 0.0, 0.0)),
            ),
            look=(
                (0.0, (4.0, 0.0, 0.0)),
                (1.3, (16.0, 3.0, 0.0)),
                (5.6, (16.0, 3.0, 0.0)),
                (7.0, (0.0, -6.0, 0.0)),
                (8.2, (4.0, 0.0, 0.0)),
            ),
            pelvis=((0.0, (0.0, 0.0, 0.0)), (2.0, (0.0, -0.02, -0.02)), (6.0, (0.0, -0.02, -0.02))),
            shakes=(
                Shake("trunk_pitch", 1.2, 2.3, 1.4, 3.4, fade_s=0.5),
                Shake("shrug", 3.5, 2.3, 1.4, 3.4, fade_s=0.5),
                Shake("trunk_pitch", 1.1, 2.3, 4.0, 5.6, fade_s=0.5),
                Shake("shrug", 3.0, 2.3, 4.0, 5.6, fade_s=0.5),
                Shake("look_pitch", 3.0, 1.2, 6.9, 8.1),
            ),
        ),
        looks=(Look(((0.0, 0.0), (6.4, 0.0), (7.1, 0.5), (7.5, 0.5), (8.3, 0.0))),),
    ),
    Role(
        Script(
            duration_s=9.0,
            plain_s=8.2,
            hand=(
                (0.0, HANGING),
                (1.10, HANGING),
                (2.00, _LAYING),
                (5.80, _LAYING),
                (6.30, _LAYING.moved(out=0.18, up=0.04, forward=-0.08)),
                (6.90, _LAYING.moved(out=0.18, up=-0.06, forward=-0.18)),
                (7.70, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (2.60, HANGING),
                (3.30, _SPEAKING),
                (4.20, _SPEAKING.moved(out=0.06, up=0.04)),
                (5.20, _SPEAKING),
                (6.40, HANGING),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.1, (3.0, 0.0, 3.0)),
                (2.1, (10.0, -8.0, 3.0)),
                (6.4, (10.0, -8.0, 4.0)),
                (7.6, (0.0, 0.0, 0.0)),
            ),
            look=((0.0, (6.0, 0.0, 4.0)), (2.4, (10.0, 0.0, 12.0)), (6.0, (8.0, 0.0, 12.0))),
            pelvis=((0.0, (0.0, 0.0, 0.0)), (2.2, (0.01, 0.0, 0.03)), (6.2, (0.01, 0.0, 0.03))),
            shakes=(Shake("look_pitch", 3.0, 1.1, 3.2, 5.4),),
        ),
        looks=(Look(((0.0, 0.85),)),),
    ),
    forward_m=0.70,
    side_m=-0.24,
    facing_deg=161.0,
    hands="same",
    touches=(
        Touch(
            "partner",
            "hand",
            "collar",
            "other",
            (0.105, 0.09, 0.0),
            ((0.0, 0.0), (1.30, 0.0), (2.10, 1.0), (6.20, 1.0), (6.85, 0.0)),
        ),
    ),
)
