"""The target points out a way; the partner looks after the hand, and asks back."""

from __future__ import annotations

from affectsim_data.builders.performances.dyads.interaction import (
    Interaction,
    Look,
    Role,
    Spot,
)
from affectsim_data.builders.performances.scenarios.vocabulary import (
    BELLY,
    HANGING,
    TALK,
    ArmPose,
    Script,
    Shake,
)

__all__ = ["INTERACTION"]

_LOW_TALK = TALK.moved(up=-0.03, forward=-0.03)
_BEAT = TALK.moved(out=0.05, up=0.06, forward=0.02)
_AHEAD = ArmPose((0.47, -0.01, 0.20), (0.5, -1.0, -0.3), palm_deg=-70.0)
"""Arm out to the side and ahead, showing the way."""
_AROUND = ArmPose((0.36, 0.02, 0.36), (0.5, -1.0, -0.3), palm_deg=-30.0, bend_deg=10.0)
_FAR = Spot(2.6, 1.5, 0.8)
"""Where the way goes."""

INTERACTION = Interaction(
    "directions",
    "neutral",
    Role(
        Script(
            duration_s=7.6,
            plain_s=7.6,
            hand=(
                (0.0, HANGING),
                (0.40, _LOW_TALK),
                (1.00, _AHEAD),
                (2.30, _AHEAD.moved(up=0.03)),
                (2.80, _AROUND),
                (3.30, _AHEAD.moved(up=0.05)),
                (3.90, _AROUND.moved(out=-0.05)),
                (4.60, _LOW_TALK),
                (5.20, _BEAT),
                (6.00, HANGING),
            ),
            other=((0.0, HANGING),),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.0, (1.0, 16.0, 0.0)),
                (2.4, (1.0, 20.0, 0.0)),
                (3.4, (1.0, 18.0, 0.0)),
                (4.6, (0.0, 4.0, 0.0)),
                (5.8, (0.0, 0.0, 0.0)),
            ),
            shakes=(
                Shake("look_pitch", 4.0, 1.5, 5.0, 5.9),
                Shake("look_pitch", 2.5, 1.3, 0.3, 1.6),
                Shake("hand_up", 0.03, 1.9, 1.0, 2.4),
                Shake("hand_up", 0.03, 1.9, 3.9, 5.7),
            ),
            pelvis=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.4, (0.03, 0.0, 0.0)),
                (3.6, (0.03, 0.0, 0.0)),
                (5.0, (-0.02, 0.0, 0.0)),
            ),
        ),
        looks=(
            Look(
                (
                    (0.0, 0.9),
                    (0.5, 0.9),
                    (0.9, 0.0),
                    (1.7, 0.0),
                    (2.0, 0.9),
                    (2.4, 0.9),
                    (2.8, 0.0),
                    (3.6, 0.0),
                    (4.1, 0.9),
                )
            ),
            Look(
                (
                    (0.0, 0.0),
                    (0.5, 0.0),
                    (0.9, 0.9),
                    (1.7, 0.9),
                    (2.0, 0.0),
                    (2.4, 0.0),
                    (2.8, 0.9),
                    (3.6, 0.9),
                    (4.1, 0.0),
                ),
                at=_FAR,
            ),
        ),
    ),
    Role(
        Script(
            duration_s=7.6,
            plain_s=7.6,
            hand=(
                (0.0, HANGING),
                (4.20, HANGING),
                (4.80, _LOW_TALK.moved(out=0.10, up=0.06)),
                (5.40, _LOW_TALK.moved(out=0.12, up=0.06)),
                (6.10, HANGING),
            ),
            other=((0.0, HANGING), (0.5, BELLY), (6.2, BELLY), (7.0, HANGING)),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.5, (2.0, 22.0, 0.0)),
                (3.9, (2.0, 22.0, 0.0)),
                (5.0, (0.0, 6.0, 0.0)),
                (6.0, (3.0, 0.0, 0.0)),
            ),
            shakes=(
                Shake("look_pitch", 4.5, 1.6, 2.3, 3.0),
                Shake("look_pitch", 5.0, 1.6, 5.4, 6.5),
            ),
            pelvis=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.8, (0.03, 0.0, 0.0)),
                (4.4, (0.02, 0.0, 0.0)),
                (6.0, (-0.02, 0.0, 0.0)),
            ),
        ),
        looks=(
            Look(
                (
                    (0.0, 0.9),
                    (0.9, 0.9),
                    (1.35, 0.0),
                    (2.2, 0.0),
                    (2.5, 0.8),
                    (2.8, 0.8),
                    (3.15, 0.0),
                    (4.1, 0.0),
                    (4.6, 0.9),
                )
            ),
            Look(
                (
                    (0.0, 0.0),
                    (0.9, 0.0),
                    (1.35, 0.9),
                    (2.2, 0.9),
                    (2.5, 0.1),
                    (2.8, 0.1),
                    (3.15, 0.9),
                    (4.1, 0.9),
                    (4.6, 0.0),
                ),
                at=_FAR,
            ),
        ),
    ),
    forward_m=1.05,
    side_m=0.12,
    facing_deg=188.0,
    hands="mirrored",
)
