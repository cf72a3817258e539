"""The partner brings it out haltingly; the target steps back, sinks, hides the face."""

from __future__ import annotations

from affectsim_data.builders.performances.dyads.interaction import (
    Interaction,
    Look,
    Role,
)
from affectsim_data.builders.performances.scenarios.vocabulary import (
    BELLY,
    FACE,
    HANGING,
    HEART,
    MOUTH,
    OPEN,
    TALK,
    ArmPose,
    Script,
    Shake,
)

__all__ = ["INTERACTION"]

_HOLDING = ArmPose((-0.03, -0.34, 0.32), (0.4, -1.0, -0.4), palm_deg=70.0)

INTERACTION = Interaction(
    "bad_news",
    "neutral",
    Role(
        Script(
            duration_s=8.8,
            plain_s=8.0,
            hand=(
                (0.0, HANGING),
                (1.90, HANGING),
                (2.80, MOUTH),
                (3.40, FACE),
                (6.20, FACE),
                (7.00, HEART),
                (8.20, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (2.60, HANGING),
                (3.60, BELLY),
                (6.60, BELLY),
                (7.80, HANGING),
            ),
            trunk=(
                (0.0, (-7.0, 0.0, 0.0)),
                (1.7, (-7.0, 0.0, 0.0)),
                (2.3, (-10.0, 5.0, 0.0)),
                (3.8, (14.0, 6.0, 2.0)),
                (6.0, (15.0, 6.0, 2.0)),
                (7.4, (2.0, 0.0, 0.0)),
                (8.3, (-7.0, 0.0, 0.0)),
            ),
            look=(
                (0.0, (-12.0, 0.0, 0.0)),
                (1.7, (-12.0, 0.0, 0.0)),
                (2.4, (-6.0, 14.0, 0.0)),
                (3.6, (16.0, 10.0, 0.0)),
                (6.0, (18.0, 8.0, 0.0)),
                (7.4, (4.0, 0.0, 0.0)),
            ),
            pelvis=(
                (0.0, (0.0, 0.0, 0.0)),
                (2.2, (0.0, 0.0, -0.03)),
                (3.9, (0.0, -0.09, -0.03)),
                (6.0, (0.0, -0.10, -0.03)),
                (7.6, (0.0, -0.01, 0.0)),
            ),
            shakes=(
                Shake("look_yaw", 8.0, 0.9, 2.3, 4.6, fade_s=0.5),
                Shake("trunk_pitch", 1.0, 2.2, 4.2, 6.0, fade_s=0.4),
                Shake("shrug", 3.0, 2.2, 4.2, 6.0, fade_s=0.4),
            ),
        ),
        looks=(Look(((0.0, 0.6), (2.0, 0.7), (2.4, 0.0), (7.4, 0.0), (8.3, 0.5))),),
    ),
    Role(
        Script(
            duration_s=8.8,
            plain_s=8.0,
            hand=(
                (0.0, HANGING),
                (0.60, HEART.moved(up=-0.04)),
                (1.10, TALK),
                (1.70, OPEN.moved(out=-0.10, up=-0.06)),
                (2.40, TALK),
                (3.20, HANGING.moved(up=0.08, forward=0.10)),
                (4.20, _HOLDING.moved(up=0.08, forward=0.02)),
                (5.60, _HOLDING.moved(up=0.07, forward=0.02)),
                (6.60, HEART),
                (7.20, HEART),
                (8.20, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (1.00, HANGING),
                (1.70, OPEN.moved(out=-0.12, up=-0.10)),
                (2.50, TALK.moved(up=-0.04)),
                (3.40, HANGING),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.7, (2.0, -4.0, 0.0)),
                (1.7, (6.0, 3.0, 0.0)),
                (3.2, (3.0, 0.0, 0.0)),
                (4.4, (11.0, -6.0, 3.0)),
                (5.6, (10.0, -5.0, 3.0)),
                (7.0, (2.0, 0.0, 0.0)),
            ),
            look=((0.0, (16.0, 10.0, 0.0)), (0.6, (18.0, 12.0, 0.0)), (1.3, (4.0, 0.0, 4.0))),
            shakes=(
                Shake("look_pitch", 3.0, 1.2, 1.0, 2.4),
                Shake("look_yaw", 5.0, 0.9, 4.2, 5.6, fade_s=0.4),
            ),
            pelvis=(
                (0.0, (0.02, 0.0, 0.0)),
                (2.2, (0.0, 0.0, 0.01)),
                (4.6, (-0.01, 0.0, 0.04)),
                (6.6, (0.02, 0.0, 0.0)),
            ),
        ),
        looks=(Look(((0.0, 0.1), (0.6, 0.1), (1.2, 0.9), (6.4, 0.9), (7.6, 0.5))),),
    ),
    forward_m=1.08,
    hands="mirrored",
)
