"""The partner tells a joke; the target laughs, bends, slaps a thigh, touches the partner's arm."""

from __future__ import annotations

from affectsim_data.builders.performances.dyads.interaction import (
    Interaction,
    Look,
    Role,
    Touch,
)
from affectsim_data.builders.performances.scenarios.vocabulary import (
    BELLY,
    HANGING,
    OPEN,
    TALK,
    ArmPose,
    Move,
    Script,
    Shake,
)

__all__ = ["INTERACTION"]

_LIGHT = ArmPose((0.10, -0.32, 0.22), (0.8, -0.5, -0.8))
"""Elbow bent, hand before the hip."""
_SLAP = HANGING.moved(up=0.16, forward=0.16)

INTERACTION = Interaction(
    "joke",
    "happy",
    Role(
        Script(
            duration_s=7.4,
            plain_s=7.8,
            deep=True,
            hand=(
                (0.0, _LIGHT),
                (2.50, _LIGHT.moved(up=0.02)),
                (3.05, TALK.moved(up=0.10)),
                (3.45, _SLAP),
                (3.70, TALK.moved(up=0.02)),
                (3.95, _SLAP),
                (4.40, TALK.moved(up=0.05, forward=0.10).turned(-40.0)),
                (5.40, TALK.moved(up=0.05, forward=0.10).turned(-40.0)),
                (5.80, TALK.moved(out=0.14, up=0.12, forward=-0.06)),
                (6.50, _LIGHT),
            ),
            other=(
                (0.0, _LIGHT),
                (2.70, _LIGHT),
                (3.30, BELLY),
                (5.60, BELLY),
                (6.40, _LIGHT),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.0, (4.0, 4.0, 3.0)),
                (2.5, (5.0, -3.0, 0.0)),
                (2.95, (-12.0, 0.0, 0.0)),
                (3.45, (20.0, 6.0, 0.0)),
                (4.10, (24.0, 4.0, 0.0)),
                (4.60, (19.0, -10.0, 0.0)),
                (5.30, (16.0, -10.0, 0.0)),
                (6.10, (-6.0, 0.0, 0.0)),
                (6.80, (0.0, 0.0, 0.0)),
            ),
            look=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.2, (0.0, 0.0, 8.0)),
                (2.4, (0.0, 0.0, 4.0)),
                (2.95, (-22.0, 0.0, 0.0)),
                (3.5, (26.0, 8.0, 4.0)),
                (4.2, (26.0, 6.0, -4.0)),
                (4.9, (0.0, 0.0, -6.0)),
                (6.1, (-12.0, 0.0, 0.0)),
            ),
            pelvis=(
                (0.0, (0.0, 0.0, 0.0)),
                (2.95, (0.0, 0.0, 0.0)),
                (3.6, (0.0, -0.06, -0.03)),
                (4.2, (0.0, -0.06, -0.03)),
                (4.6, (0.0, -0.02, 0.03)),
                (5.3, (0.0, -0.01, 0.04)),
                (6.1, (0.03, 0.0, 0.0)),
            ),
            moves=(
                Move("hand", 3.70, 4.10, forward=0.28),
                Move("other", 4.05, 4.40, forward=0.28),
                Move("other", 5.55, 6.00),
                Move("hand", 5.95, 6.40),
            ),
            shakes=(
                Shake("trunk_pitch", 2.6, 3.6, 2.9, 6.4),
                Shake("shrug", 4.0, 3.6, 2.9, 6.4),
                Shake("hand_up", 0.015, 3.6, 2.9, 6.2),
                Shake("other_up", 0.015, 3.6, 2.9, 6.2),
                Shake("look_pitch", 3.0, 1.6, 0.6, 2.2),
            ),
        ),
        looks=(
            Look(
                (
                    (0.0, 0.9),
                    (2.6, 0.9),
                    (2.95, 0.0),
                    (4.3, 0.0),
                    (4.8, 0.9),
                    (5.6, 0.9),
                    (6.1, 0.2),
                    (6.8, 0.9),
                )
            ),
        ),
    ),
    Role(
        Script(
            duration_s=7.4,
            plain_s=7.8,
            hand=(
                (0.0, _LIGHT),
                (0.35, TALK),
                (0.75, TALK.moved(out=0.10, up=0.10)),
                (1.15, TALK.moved(out=-0.02)),
                (1.55, OPEN),
                (1.95, TALK.moved(up=0.05)),
                (2.35, OPEN.moved(out=0.05, up=0.16)),
                (2.75, OPEN.moved(out=0.05, up=0.12)),
                (3.30, TALK.moved(up=0.06, forward=-0.08)),
                (4.30, TALK),
                (5.90, TALK),
                (6.80, _LIGHT),
            ),
            other=(
                (0.0, _LIGHT),
                (0.60, TALK),
                (1.05, TALK.moved(out=0.08, up=0.08)),
                (1.55, OPEN.moved(up=-0.04)),
                (2.00, TALK),
                (2.35, OPEN.moved(out=0.05, up=0.14)),
                (2.75, OPEN.moved(out=0.05, up=0.10)),
                (3.50, BELLY),
                (5.20, BELLY),
                (6.20, _LIGHT),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.6, (6.0, 6.0, 0.0)),
                (1.4, (5.0, -6.0, 0.0)),
                (2.0, (8.0, 4.0, 0.0)),
                (2.4, (-6.0, 0.0, 0.0)),
                (3.4, (7.0, 0.0, 0.0)),
                (4.4, (3.0, 0.0, 3.0)),
                (5.6, (-3.0, 0.0, 0.0)),
            ),
            look=((0.0, (0.0, 0.0, 0.0)), (3.2, (8.0, 0.0, 6.0)), (4.2, (-8.0, 0.0, -4.0))),
            shakes=(
                Shake("look_pitch", 3.5, 1.8, 0.3, 2.3),
                Shake("trunk_pitch", 1.6, 3.4, 3.2, 5.8),
                Shake("shrug", 3.0, 3.4, 3.2, 5.8),
            ),
            pelvis=((0.0, (0.0, 0.0, 0.0)), (1.5, (0.03, 0.0, 0.01)), (4.5, (-0.02, 0.0, 0.01))),
        ),
        looks=(Look(((0.0, 0.9), (3.0, 0.8), (4.0, 0.7), (5.0, 0.9))),),
    ),
    forward_m=0.99,
    hands="mirrored",
    touches=(
        Touch(
            "target",
            "hand",
            "elbow",
            "hand",
            (0.15, 0.05, 0.0),
            ((0.0, 0.0), (4.05, 0.0), (4.50, 1.0), (5.35, 1.0), (5.90, 0.0)),
        ),
    ),
)
