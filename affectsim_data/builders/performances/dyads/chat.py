"""Quiet talk in turns: one gestures a little, the other nods, weight shifts follow each other."""

from __future__ import annotations

from affectsim_data.builders.performances.dyads.interaction import (
    Interaction,
    Look,
    Role,
)
from affectsim_data.builders.performances.scenarios.vocabulary import (
    BELLY,
    HANGING,
    TALK,
    Script,
    Shake,
)

__all__ = ["INTERACTION"]

_LOW_TALK = TALK.moved(up=-0.03, forward=-0.03)
_BEAT = TALK.moved(out=0.05, up=0.06, forward=0.02)

INTERACTION = Interaction(
    "chat",
    "neutral",
    Role(
        Script(
            duration_s=8.0,
            plain_s=8.0,
            hand=(
                (0.0, HANGING),
                (0.30, HANGING),
                (0.90, _LOW_TALK),
                (1.40, _BEAT),
                (1.90, _LOW_TALK),
                (2.40, _BEAT.moved(out=0.04)),
                (2.90, _LOW_TALK),
                (3.60, HANGING),
            ),
            other=(
                (0.0, HANGING),
                (1.60, HANGING),
                (2.20, _LOW_TALK.moved(up=-0.04)),
                (2.70, _BEAT.moved(up=-0.04)),
                (3.50, HANGING),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.2, (2.0, 4.0, 0.0)),
                (2.6, (2.0, -3.0, 0.0)),
                (4.5, (-2.0, 0.0, 2.0)),
                (6.5, (-1.0, 3.0, 0.0)),
            ),
            shakes=(
                Shake("look_pitch", 2.5, 1.3, 0.7, 2.9),
                Shake("hand_up", 0.03, 1.9, 0.9, 3.2),
                Shake("other_up", 0.03, 1.9, 2.1, 3.1),
                Shake("look_pitch", 4.5, 1.6, 4.9, 5.8),
                Shake("look_pitch", 4.5, 1.6, 6.7, 7.4),
            ),
            look=((0.0, (0.0, 0.0, 0.0)), (1.7, (4.0, 16.0, 0.0)), (2.3, (0.0, 0.0, 0.0))),
            pelvis=(
                (0.0, (0.025, 0.0, 0.0)),
                (3.0, (0.02, 0.0, 0.0)),
                (4.3, (-0.03, 0.0, 0.0)),
                (6.8, (-0.02, 0.0, 0.0)),
            ),
        ),
        looks=(Look(((0.0, 0.9), (1.3, 0.9), (1.7, 0.3), (2.2, 0.9))),),
    ),
    Role(
        Script(
            duration_s=8.0,
            plain_s=8.0,
            hand=(
                (0.0, HANGING),
                (3.60, HANGING),
                (4.20, _LOW_TALK),
                (4.70, _BEAT.moved(up=0.02)),
                (5.20, _LOW_TALK.moved(out=0.04)),
                (5.70, _BEAT),
                (6.20, _LOW_TALK),
                (6.90, HANGING),
            ),
            other=((0.0, BELLY), (3.40, BELLY), (4.40, HANGING), (6.60, HANGING), (7.50, BELLY)),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.5, (-2.0, -2.0, 0.0)),
                (3.9, (0.0, 0.0, 0.0)),
                (4.8, (3.0, 4.0, 0.0)),
                (6.0, (2.0, -3.0, 0.0)),
            ),
            shakes=(
                Shake("look_pitch", 4.5, 1.6, 1.3, 2.1),
                Shake("look_pitch", 4.5, 1.6, 2.9, 3.7),
                Shake("look_pitch", 2.5, 1.3, 4.1, 6.3),
                Shake("hand_up", 0.03, 1.8, 4.3, 6.5),
            ),
            look=((0.0, (0.0, 0.0, 0.0)), (4.9, (3.0, -16.0, 0.0)), (5.5, (0.0, 0.0, 0.0))),
            pelvis=(
                (0.0, (0.025, 0.0, 0.0)),
                (3.4, (0.02, 0.0, 0.0)),
                (4.7, (-0.03, 0.0, 0.0)),
                (7.1, (-0.02, 0.0, 0.0)),
            ),
        ),
        looks=(Look(((0.0, 0.9), (4.5, 0.9), (4.9, 0.3), (5.4, 0.9))),),
    ),
    forward_m=1.15,
)
