"""Both wave, step in and shake hands, the target with both, and step back laughing."""

from __future__ import annotations

from affectsim_data.builders.performances.dyads.interaction import (
    Clasp,
    Interaction,
    Look,
    Role,
    Spot,
    Touch,
)
from affectsim_data.builders.performances.scenarios.vocabulary import (
    OPEN,
    ArmPose,
    Move,
    Script,
    Shake,
)

__all__ = ["INTERACTION"]

_LIGHT = ArmPose((0.10, -0.32, 0.22), (0.8, -0.5, -0.8))
"""Elbow bent, hand before the hip."""
_SHAKING = ArmPose((-0.10, -0.26, 0.36), (0.35, -1.0, -0.25), palm_deg=5.0)
_WAVE_IN = ArmPose((0.12, 0.32, 0.14), (1.0, -0.6, -0.1), palm_deg=-70.0, bend_deg=-15.0)
_WAVE_OUT = _WAVE_IN.moved(out=0.18)
_CLASP_ARM = ArmPose((0.0, -0.22, 0.42), (0.6, -0.8, -0.2), palm_deg=-20.0)

INTERACTION = Interaction(
    "greet",
    "happy",
    Role(
        Script(
            duration_s=7.6,
            plain_s=8.2,
            deep=True,
            hand=(
                (0.0, _LIGHT),
                (0.45, _WAVE_OUT),
                (0.72, _WAVE_IN),
                (0.98, _WAVE_OUT),
                (1.24, _WAVE_IN),
                (1.50, _WAVE_OUT),
                (2.00, _LIGHT),
                (2.60, _SHAKING),
                (4.40, _SHAKING),
                (5.00, _LIGHT),
                (5.60, OPEN.moved(out=-0.10)),
                (6.40, OPEN.moved(out=-0.08, up=0.04)),
                (7.10, _LIGHT),
            ),
            other=(
                (0.0, _LIGHT),
                (2.50, _LIGHT),
                (3.00, _CLASP_ARM),
                (4.20, _CLASP_ARM),
                (4.90, _LIGHT),
                (5.65, OPEN.moved(out=-0.06)),
                (6.30, OPEN.moved(out=-0.06, up=0.03)),
                (7.10, _LIGHT),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (0.50, (-4.0, 6.0, -5.0)),
                (1.40, (-4.0, 5.0, -4.0)),
                (2.60, (8.0, -5.0, 0.0)),
                (3.00, (12.0, 3.0, 0.0)),
                (4.20, (12.0, 3.0, 0.0)),
                (5.00, (0.0, 0.0, 0.0)),
                (5.70, (-8.0, 0.0, 3.0)),
                (6.30, (-8.0, 0.0, -3.0)),
            ),
            look=((0.0, (0.0, 0.0, 0.0)), (0.6, (-3.0, 0.0, 6.0)), (2.8, (0.0, 0.0, 4.0))),
            shakes=(
                Shake("look_pitch", 4.0, 2.2, 2.7, 4.2),
                Shake("pelvis_up", 0.012, 2.2, 2.7, 4.2),
                Shake("shrug", 3.0, 3.4, 5.0, 6.4),
            ),
            heels=((0.0, (0.0, 0.0)), (0.5, (16.0, 16.0)), (1.3, (14.0, 14.0)), (1.6, (0.0, 0.0))),
            moves=(
                Move("other", 1.60, 2.00, forward=0.28),
                Move("hand", 1.95, 2.40, forward=0.28),
                Move("hand", 4.70, 5.15),
                Move("other", 5.10, 5.55),
            ),
        ),
        looks=(Look(((0.0, 0.9),)),),
    ),
    Role(
        Script(
            duration_s=7.6,
            plain_s=8.2,
            deep=True,
            hand=(
                (0.0, _LIGHT),
                (0.50, _LIGHT),
                (0.95, _WAVE_OUT.moved(up=-0.06)),
                (1.25, _WAVE_IN.moved(up=-0.06)),
                (1.55, _WAVE_OUT.moved(up=-0.06)),
                (2.05, _LIGHT),
                (2.60, _SHAKING),
                (4.40, _SHAKING),
                (5.00, _LIGHT),
            ),
            other=(
                (0.0, _LIGHT),
                (2.80, _LIGHT),
                (5.40, _LIGHT),
                (5.80, OPEN.moved(out=-0.10, up=-0.06)),
                (6.40, OPEN.moved(out=-0.10, up=-0.08)),
                (7.10, _LIGHT),
            ),
            trunk=(
                (0.0, (0.0, 0.0, 0.0)),
                (1.00, (-3.0, 5.0, -4.0)),
                (2.60, (7.0, -6.0, 0.0)),
                (4.20, (7.0, -4.0, 0.0)),
                (5.20, (-5.0, 0.0, 0.0)),
                (6.20, (2.0, 0.0, 3.0)),
            ),
            shakes=(
                Shake("look_pitch", 4.0, 2.2, 3.0, 4.4),
                Shake("shrug", 3.0, 3.4, 5.2, 6.6),
                Shake("trunk_pitch", 1.5, 3.4, 5.2, 6.6),
            ),
            moves=(
                Move("hand", 1.75, 2.15, forward=0.28),
                Move("other", 2.10, 2.50, forward=0.28),
                Move("other", 4.80, 5.25),
                Move("hand", 5.20, 5.65),
            ),
        ),
        looks=(Look(((0.0, 0.9),)),),
    ),
    forward_m=1.40,
    hands="right",
    clasps=(
        Clasp(
            "hand",
            "hand",
            (
                (0.0, Spot(0.0, 1.08, 0.70)),
                (2.70, Spot(0.0, 1.10, 0.70)),
                (2.92, Spot(0.0, 1.02, 0.70)),
                (3.14, Spot(0.0, 1.12, 0.70)),
                (3.36, Spot(0.0, 1.02, 0.70)),
                (3.58, Spot(0.0, 1.12, 0.70)),
                (3.80, Spot(0.0, 1.03, 0.70)),
                (4.05, Spot(0.0, 1.08, 0.70)),
            ),
            ((0.0, 0.0), (2.20, 0.0), (2.65, 1.0), (4.20, 1.0), (4.60, 0.0)),
        ),
    ),
    touches=(
        Touch(
            "target",
            "other",
            "elbow",
            "hand",
            (0.17, 0.045, 0.0),
            ((0.0, 0.0), (2.65, 0.0), (3.05, 1.0), (4.10, 1.0), (4.55, 0.0)),
        ),
    ),
)
