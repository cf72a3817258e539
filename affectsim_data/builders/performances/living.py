"""What every living body does beside its task: breathes, sways, looks about, trembles."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.performances.curves import FPS, follow, keyframes, noise, wave
from affectsim_data.builders.performances.rig import SIDES, BodyTrack
from affectsim_data.builders.performances.styles import Performer, Posture
from affectsim_data.poses import FloatArray

__all__ = ["breathe", "glances", "limit_head", "sway", "tremble"]

_HEAD_LIMIT = np.deg2rad(68.0)
_TREMOR_HZ = 5.0
_HOLD = 0.7
"""Share of the time between two glances in which the eyes rest."""


def breathe(track: BodyTrack, posture: Posture) -> None:
    """Chest and shoulders rise with every breath, a whole number of them a cycle."""
    count = len(track.shrug)
    turns = max(round(count / FPS * posture.breath_hz), 1)
    breath = wave(np.arange(count) / count, turns, 0.3)
    rise = np.deg2rad(posture.breath_deg) * breath
    track.trunk_turn[:, 0] -= rise
    track.head_turn[:, 0] += 0.6 * rise
    track.shrug += 0.8 * rise


def sway(
    track: BodyTrack, phase: FloatArray, who: Performer, rng: np.random.Generator, *, seated: bool
) -> None:
    """Small wandering of pelvis, trunk and head, more in people who never stand still."""
    ground = 0.0 if seated else 0.007 * who.sway
    track.pelvis_position[:, 0] += noise(phase, amplitude=ground, rng=rng)
    track.pelvis_position[:, 2] += noise(phase, amplitude=ground, rng=rng)
    for axis, size in enumerate((0.8, 1.0, 0.9)):
        size = np.deg2rad(size) * who.sway
        track.trunk_turn[:, axis] += noise(phase, amplitude=size, rng=rng)
        track.head_turn[:, axis] += noise(phase, amplitude=1.5 * size, rng=rng)


def glances(phase: FloatArray, count: int, rng: np.random.Generator) -> FloatArray:
    """Where the eyes go, -1 to 1, `(n,)`: `count` looks to alternate sides, held, then quickly on.

    The first looks ahead.
    """
    keys: list[tuple[float, float]] = [(0.0, 0.0), (_HOLD / (count + 1), 0.0)]
    way = rng.choice([-1.0, 1.0])
    for index in range(1, count + 1):
        start = (index + rng.uniform(-0.12, 0.12)) / (count + 1)
        target = way * rng.uniform(0.55, 1.0) * (1.0 if rng.random() < 0.8 else 0.15)
        keys += [(start, target), (start + _HOLD / (count + 1), target * rng.uniform(0.8, 1.0))]
        way = -way
    return follow(keyframes(phase, keys), hz=2.5, damping=0.8)


def tremble(
    track: BodyTrack, phase: FloatArray, amplitude: float, rng: np.random.Generator
) -> None:
    """Hands shake at some 5 Hz, `amplitude` metres; arms reach for shaking places."""
    slowest = max(round(_TREMOR_HZ * len(phase) / FPS), 1)
    for side in SIDES:
        shake = [noise(phase, amplitude=amplitude, rng=rng, slowest=slowest) for _ in range(3)]
        shaken = np.stack(shake, axis=1) * [0.5, 0.6, 0.5]
        track.wrists[side] = track.wrists[side] + shaken
        if side in track.contacts:
            track.contacts[side].position = track.contacts[side].position + shaken


def limit_head(track: BodyTrack) -> None:
    """Keeps the head within what a neck can turn, softly."""
    for axis in range(3):
        turn = track.head_turn[:, axis]
        track.head_turn[:, axis] = _HEAD_LIMIT * np.tanh(turn / _HEAD_LIMIT)
