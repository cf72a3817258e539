"""Joy, standing: the body opens and rises, springs from the feet, and moves in rounds."""

from __future__ import annotations

from affectsim_data.builders.performances.scenarios.vocabulary import (
    BELLY,
    HEART,
    OPEN,
    OVERHEAD,
    THIGH,
    ArmPose,
    Hop,
    Move,
    Script,
    Shake,
    keys,
)

__all__ = ["SCRIPTS"]

_READY = ArmPose((0.10, -0.30, 0.24), (0.8, -0.5, -0.8))
"""Elbow bent, hand before the hip, light."""
_WAVE = ArmPose((0.20, 0.34, 0.12), (1.0, -0.6, -0.1), palm_deg=-60.0)
_SPREAD = ArmPose((0.44, 0.10, 0.16), (0.8, -0.8, -0.4), palm_deg=60.0)
_CLAP = ArmPose((0.05, 0.047, 0.323), (0.92, -0.79, 0.0), 6.0, -43.0, "chest")
_CLAP_HIGH = ArmPose((0.045, 0.239, 0.227), (0.87, -0.41, 0.37), 18.0, -42.0, "head")
_SWING_UP = ArmPose((0.10, -0.02, 0.27), (0.6, -1.0, -0.3), palm_deg=10.0)
_SWING_DOWN = ArmPose((0.16, -0.34, 0.06), (0.7, -0.1, -1.0))


_CELEBRATE_HIGH = OVERHEAD
_CELEBRATE_ARMS = (
    (0.0, _READY),
    (0.35, _READY.moved(up=-0.14, forward=-0.10)),
    (0.57, ArmPose((0.14, 0.06, 0.34), (1.0, -0.4, -0.1), palm_deg=-15.0)),
    (0.75, _CELEBRATE_HIGH),
    (1.05, _CELEBRATE_HIGH.moved(out=0.05, up=-0.10)),
    (1.35, _CELEBRATE_HIGH),
    (1.75, _CELEBRATE_HIGH.moved(out=0.05, up=-0.12)),
    (2.2, _CELEBRATE_HIGH.moved(up=-0.02)),
    (2.9, _CELEBRATE_HIGH.moved(out=0.06, up=-0.04)),
    (3.5, _SPREAD.moved(up=0.06)),
    (4.2, _SPREAD.moved(up=0.02)),
    (5.2, _READY),
)
_CELEBRATE = Script(
    duration_s=5.8,
    plain_s=7.0,
    hand=_CELEBRATE_ARMS,
    other=tuple((time + 0.04, pose) for time, pose in _CELEBRATE_ARMS),
    trunk=keys(
        (0, 0.38, 0.8, 1.12, 1.45, 1.9, 2.3, 2.9, 3.6, 4.3, 5.2),
        (0, 14, -7, 3, -7, 0, -6, -6, -9, -9, 0),
        (0, 0, 0, 0, 0, 0, 8, -8, 12, -10, 0),
        (0, 0, 0, 0, 0, 0, 4, -4, 3, -2, 0),
    ),
    look=keys(
        (0, 0.38, 0.8, 1.9, 2.3, 2.9, 3.5, 4.2, 5.2),
        (2, 10, -18, -12, -16, -16, -6, -6, 2),
        (0, 0, 0, 0, 16, -16, 28, -26, 0),
        (0, 0, 0, 0, 5, -5, 4, -4, 0),
    ),
    pelvis=keys(
        (0, 0.38, 0.75, 1.9, 2.3, 2.9, 3.6, 4.3, 5.1),
        (0, 0, 0, 0, 0.06, -0.06, 0.05, -0.05, 0),
        (0, -0.12, 0.02, -0.02, 0, 0, 0, 0, -0.02),
        (0, -0.03, 0, 0, 0, 0, 0.02, 0.02, 0),
    ),
    hops=(Hop(0.68, 0.96, 0.085), Hop(1.32, 1.6, 0.085)),
    moves=(
        Move("hand", 3.05, 3.4, side=0.16, forward=0.12, heading_deg=14.0),
        Move("other", 3.75, 4.05, side=0.08, forward=0.10, heading_deg=-10.0),
        Move("hand", 4.4, 4.75),
        Move("other", 4.85, 5.2),
    ),
    shakes=(
        Shake("hand_up", 0.05, 2.0, 1.9, 3.1),
        Shake("other_up", 0.05, 2.0, 1.9, 3.1, shift=0.5),
    ),
)
"""Crouches and throws both arms up, hops twice, pumps the fists, opens to everybody."""


_GREET = Script(
    duration_s=6.4,
    plain_s=7.0,
    hand=(
        (0.0, _READY),
        (0.25, _READY.moved(up=-0.06)),
        (0.75, _WAVE),
        (2.75, _WAVE),
        (3.35, _SPREAD),
        (4.2, _SPREAD.moved(up=0.03)),
        (4.75, HEART),
        (5.4, HEART),
        (6.05, _READY),
    ),
    other=(
        (0.0, _READY),
        (0.8, _READY.moved(out=0.10, up=0.06)),
        (2.6, _READY.moved(out=0.10, up=0.06)),
        (3.3, _SPREAD.moved(up=0.02)),
        (4.25, _SPREAD.moved(up=-0.02)),
        (5.0, _READY.moved(out=0.06)),
    ),
    trunk=keys(
        (0, 0.3, 0.8, 1.6, 2.5, 3.3, 4.2, 4.8, 5.4, 6),
        (0, 5, -3, -2, -3, -9, -8, 8, 9, 0),
        (0, -4, 6, 5, 6, 0, 0, -4, -4, 0),
        (0, 0, -7, -3, -7, 0, 0, 3, 3, 0),
    ),
    look=keys(
        (0, 0.75, 1.7, 2.6, 3.3, 4.2, 4.8, 5.4),
        (4, -3, -3, -3, -6, -5, 12, 8),
        (0, 0, 0, 0, 0, 0, 0, 0),
        (0, 6, -4, 6, 0, -6, 6, 6),
    ),
    heels=(
        (0.0, (0.0, 0.0)),
        (0.45, (0.0, 0.0)),
        (0.85, (20.0, 20.0)),
        (1.2, (6.0, 6.0)),
        (1.55, (20.0, 20.0)),
        (1.9, (6.0, 6.0)),
        (2.25, (20.0, 20.0)),
        (2.7, (0.0, 0.0)),
    ),
    pelvis=keys(
        (0, 0.4, 0.85, 1.2, 1.55, 1.9, 2.25, 2.75, 3.4, 4.2, 4.9, 5.5),
        (0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0),
        (0, -0.04, 0.045, -0.01, 0.045, -0.01, 0.045, -0.02, 0, 0, -0.04, -0.03),
        (0, 0, 0.05, 0.04, 0.05, 0.04, 0.05, 0, 0.03, 0.03, 0, 0),
    ),
    moves=(
        Move("other", 2.9, 3.25, forward=0.22),
        Move("hand", 3.4, 3.75, forward=0.22),
        Move("other", 4.45, 4.8, forward=0.0),
        Move("hand", 5.5, 5.85, forward=0.0),
    ),
    shakes=(
        Shake("hand_out", 0.12, 1.35, 0.75, 2.85),
        Shake("hand_bend", 18.0, 1.35, 0.75, 2.85, shift=0.15),
    ),
)
"""Waves with the whole arm, up on the toes, then opens both arms and lays a hand on the heart."""


_LAUGH_SLAP = THIGH
_LAUGH_OFF = ArmPose((0.14, -0.20, 0.26), (0.9, -0.1, -0.8))
_LAUGH = Script(
    duration_s=6.2,
    plain_s=7.0,
    hand=(
        (0.0, BELLY.moved(up=0.05, forward=0.06)),
        (0.5, _LAUGH_OFF.moved(up=0.08)),
        (0.95, _LAUGH_SLAP),
        (1.15, _LAUGH_SLAP),
        (1.4, _LAUGH_OFF),
        (1.66, _LAUGH_SLAP),
        (1.9, _LAUGH_SLAP),
        (2.2, _LAUGH_OFF.moved(up=0.06)),
        (2.46, _LAUGH_SLAP),
        (2.9, _LAUGH_SLAP),
        (3.6, OPEN.moved(up=0.06)),
        (4.9, OPEN.moved(up=0.02)),
        (5.6, BELLY.moved(up=0.05, forward=0.06)),
    ),
    other=((0.0, BELLY), (1.0, BELLY.moved(up=0.01)), (3.6, BELLY.moved(up=0.02))),
    trunk=keys(
        (0, 0.45, 1, 1.4, 1.7, 2.15, 2.5, 2.9, 3.7, 4.3, 4.9, 5.7),
        (-2, -12, 42, 32, 44, 34, 46, 38, -15, -16, -12, -2),
        (0, 0, 6, 2, 8, 2, 8, 4, 10, -8, 4, 0),
        (0, 0, 0, 0, 0, 0, 0, 0, 4, -4, 2, 0),
    ),
    look=keys(
        (0, 0.45, 1, 1.45, 1.75, 2.9, 3.7, 4.3, 4.9, 5.7),
        (-4, -22, 44, 26, 44, 36, -36, -38, -28, -4),
        (0, 0, 0, 0, 0, 0, 6, -6, 0, 0),
        (0, 0, 4, -4, 4, 0, 6, -6, 4, 0),
    ),
    shrug=((0.0, 0.0), (0.5, 6.0), (1.0, 0.0), (3.6, 6.0), (5.0, 4.0), (5.7, 0.0)),
    pelvis=keys(
        (0, 0.45, 1, 1.4, 1.7, 2.15, 2.5, 2.95, 3.7, 4.9, 5.6),
        (0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0),
        (0, 0.01, -0.09, -0.05, -0.1, -0.06, -0.11, -0.06, 0, 0, 0),
        (0, 0, 0, 0, 0, 0, 0, 0, 0.06, 0.06, 0),
    ),
    moves=(
        Move("hand", 3.0, 3.35, side=0.06, forward=-0.14, heading_deg=8.0),
        Move("hand", 5.05, 5.45),
    ),
    shakes=(
        Shake("shrug", 4.0, 2.8, 0.9, 5.3),
        Shake("trunk_pitch", 2.2, 2.8, 0.9, 5.3, shift=0.2),
        Shake("look_pitch", 2.5, 2.8, 0.9, 5.3, shift=0.4),
    ),
)
"""Bends with laughter and slaps the thigh, a hand on the belly; leans back, shoulders shaking."""


def _applaud() -> Script:
    """Claps before the chest, bouncing; claps above the head, swaying from foot to foot."""
    rate = 1.75
    arms: list[tuple[float, ArmPose]] = [(0.0, _CLAP.moved(out=0.10))]
    arms += [(0.3 + n / rate, _CLAP) for n in range(4)]
    arms += [(0.3 + (n + 0.5) / rate, _CLAP.moved(out=0.12, forward=-0.02)) for n in range(4)]
    arms += [(3.1 + n / rate, _CLAP_HIGH) for n in range(3)]
    arms += [(3.1 + (n + 0.5) / rate, _CLAP_HIGH.moved(out=0.11, up=-0.02)) for n in range(3)]
    arms += [(5.1, _SPREAD.moved(up=0.08)), (5.6, _CLAP.moved(out=0.10, up=-0.04))]
    beats = tuple((0.3 + (n + 0.5 * m) / rate, 16.0 * m) for n in range(4) for m in (0, 1))
    return Script(
        duration_s=6.0,
        plain_s=7.0,
        hand=tuple(arms),
        other=tuple(arms),
        trunk=keys(
            (0, 0.9, 1.5, 2.1, 2.7, 3.2, 3.75, 4.3, 4.9, 5.5),
            (0, 2, 0, 2, 0, -7, -7, -7, -6, 0),
            (0, 5, -5, 5, 0, 6, -6, 6, 0, 0),
            (0, 4, -4, 4, 0, 7, -7, 7, 0, 0),
        ),
        look=keys(
            (0, 0.9, 1.5, 2.1, 3.1, 3.75, 4.3, 5.3),
            (0, 0, 0, 0, -12, -12, -12, 0),
            (0, 8, -8, 8, 0, 0, 0, 0),
            (0, 5, -5, 5, 5, -5, 5, 0),
        ),
        heels=(*((time, (pitch, pitch)) for time, pitch in beats), (2.7, (0.0, 0.0))),
        pelvis=(
            (0.0, (0.0, -0.01, 0.0)),
            *((time, (0.0, 0.0026 * pitch - 0.015, 0.002 * pitch)) for time, pitch in beats),
            (2.7, (0.0, -0.02, 0.0)),
            (3.2, (0.08, 0.0, 0.0)),
            (3.75, (-0.08, 0.0, 0.0)),
            (4.3, (0.08, 0.0, 0.0)),
            (5.0, (0.0, 0.0, 0.0)),
        ),
        moves=(
            Move("hand", 2.55, 2.85, side=0.10),
            Move("other", 3.2, 3.5, side=0.0, lift_m=0.09),
            Move("other", 4.3, 4.6, side=0.0, lift_m=0.09),
            Move("hand", 4.9, 5.25),
        ),
    )


def _dance() -> Script:
    """Steps from side to side, hips and shoulders swaying, arms swinging up in turn."""
    beat = 0.75
    hand: list[tuple[float, ArmPose]] = []
    other: list[tuple[float, ArmPose]] = []
    trunk: list[tuple[float, tuple[float, float, float]]] = []
    look: list[tuple[float, tuple[float, float, float]]] = []
    pelvis: list[tuple[float, tuple[float, float, float]]] = []
    for count in range(8):
        at, way = beat * count + 0.3, 1.0 if count % 2 == 0 else -1.0
        high = 0.16 if count >= 4 else 0.0
        up = _SWING_UP.moved(up=high * 2.0, out=high * 0.6)
        hand.append((at, up if way > 0 else _SWING_DOWN))
        other.append((at + 0.03, _SWING_DOWN if way > 0 else up))
        trunk.append((at, (-1.0, -12.0 * way, -6.0 * way)))
        look.append((at + 0.08, (-2.0, 10.0 * way, 8.0 * way)))
        pelvis.append((at, (0.075 * way, 0.0, 0.0)))
        pelvis.append((at + beat / 2.0, (0.0, -0.055, 0.0)))
    moves = []
    for count in range(4):
        start = 2.0 * beat * count
        moves += [
            Move("hand", start - 0.05 if count else start + 0.02, start + 0.25, side=0.26),
            Move("other", start + 0.37, start + 0.62, side=0.26, lift_m=0.05),
            Move("other", start + 0.72, start + 0.98, side=0.0),
            Move("hand", start + 1.1, start + 1.36, side=0.0, lift_m=0.05),
        ]
    return Script(
        duration_s=8.0 * beat,
        plain_s=7.2,
        hand=tuple(hand),
        other=tuple(other),
        trunk=tuple(trunk),
        look=tuple(look),
        pelvis=tuple(pelvis),
        moves=tuple(moves),
        shakes=(Shake("look_pitch", 4.0, 1.0 / beat, 0.2, 5.9, shift=0.2),),
    )


SCRIPTS = {
    "celebrate": _CELEBRATE,
    "greet": _GREET,
    "laugh": _LAUGH,
    "applaud": _applaud(),
    "dance": _dance(),
}
