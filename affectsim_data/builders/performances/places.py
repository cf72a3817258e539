"""Places of hands that everybody knows: on the thighs, at the mouth, folded, thrown up."""

from __future__ import annotations

from affectsim_data.builders.performances.arms import Place

__all__ = [
    "AKIMBO",
    "BELLY",
    "BROW",
    "CHIN",
    "CLAP",
    "CLAP_OPEN",
    "CLASPED_OVER",
    "CLASPED_UNDER",
    "FIST_HIGH",
    "FOLDED_OVER",
    "FOLDED_UNDER",
    "GUARD",
    "HANG",
    "HUG_OVER",
    "HUG_UNDER",
    "KNEE",
    "LAP_OVER",
    "LAP_UNDER",
    "MOUTH",
    "OPEN",
    "POINT",
    "SEAT",
    "SWING",
    "TALK",
    "THIGH",
    "THROWN",
    "UP",
    "WAVE_IN",
    "WAVE_OUT",
]

_BACK = (0.45, -0.4, -1.0)
_DOWN = (0.5, -1.0, -0.1)
_WIDE = (1.0, -0.5, -0.4)

HANG = Place("shoulder", (0.06, -0.525, 0.05), (0.3, -0.2, -1.0), 10.0, 8.0)
SWING = Place("shoulder", (0.10, -0.42, 0.30), _BACK, 10.0)
AKIMBO = Place("belly", (0.27, -0.05, 0.02), (1.0, -0.2, -0.5), -40.0, 35.0)
TALK = Place("shoulder", (0.02, -0.28, 0.28), _BACK, 45.0)
OPEN = Place("shoulder", (0.14, -0.24, 0.31), _BACK, 85.0, -10.0)
THIGH = Place("thigh", (0.01, 0.11, 0.27), _BACK, -55.0, -15.0)
KNEE = Place("thigh", (0.03, 0.115, 0.35), _WIDE, -70.0, 10.0)
LAP_OVER = Place("seat", (0.05, 0.115, 0.27), _WIDE, -20.0, 20.0)
LAP_UNDER = Place("seat", (0.03, 0.085, 0.23), _WIDE, -20.0, 20.0)
SEAT = Place("seat", (0.27, -0.03, -0.02), (0.3, 0.1, -1.0), 0.0, -55.0)
BELLY = Place("belly", (0.03, 0.0, 0.19), _WIDE, -10.0, 45.0)
FOLDED_OVER = Place("chest", (-0.03, -0.08, 0.215), _WIDE, -40.0, 20.0)
FOLDED_UNDER = Place("chest", (-0.02, -0.13, 0.18), _WIDE, -40.0, 20.0)
HUG_OVER = Place("chest", (-0.08, -0.05, 0.215), (0.6, -1.0, 0.0), -20.0, 35.0)
HUG_UNDER = Place("chest", (-0.07, -0.11, 0.18), (0.6, -1.0, 0.0), -20.0, 35.0)
MOUTH = Place("head", (0.0, -0.15, 0.15), _DOWN, 60.0, 25.0)
CHIN = Place("head", (0.02, -0.17, 0.14), _DOWN, 40.0, 20.0)
BROW = Place("head", (0.03, -0.08, 0.18), _DOWN, 60.0, 35.0)
GUARD = Place("shoulder", (-0.06, 0.10, 0.30), _DOWN, -50.0, -30.0)
POINT = Place("shoulder", (-0.04, -0.02, 0.53), _BACK, -40.0)
FIST_HIGH = Place("shoulder", (0.10, 0.10, 0.24), (0.9, -0.7, -0.2), 10.0)
THROWN = Place("shoulder", (0.26, 0.10, 0.27), (0.6, -1.0, -0.2), 80.0, -25.0)
UP = Place("shoulder", (0.18, 0.45, 0.10), (1.0, -0.1, 0.1), -20.0)
WAVE_IN = Place("shoulder", (0.04, 0.30, 0.20), (1.0, -0.7, 0.0), -50.0)
WAVE_OUT = Place("shoulder", (0.27, 0.30, 0.17), (1.0, -0.7, 0.0), -50.0)
CLAP = Place("chest", (0.045, 0.0, 0.33), _WIDE, 0.0)
CLAP_OPEN = Place("chest", (0.19, 0.01, 0.30), _WIDE, 0.0)
CLASPED_OVER = Place("seat", (0.03, 0.03, 0.20), (0.8, -0.3, -0.7), 0.0, 30.0)
CLASPED_UNDER = Place("seat", (0.03, 0.01, 0.165), (0.8, -0.3, -0.7), 0.0, 30.0)
