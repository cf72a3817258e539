"""Puts a script on a body: a performer, at an intensity, with the noise of a take."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.performances.curves import FPS, cycle_phase, noise
from affectsim_data.builders.performances.rig import BodyTrack
from affectsim_data.builders.performances.scenarios.carriage import place_arms, upper_body
from affectsim_data.builders.performances.scenarios.footing import lower_body, settle
from affectsim_data.builders.performances.scenarios.stage import MANNERS, Stage
from affectsim_data.builders.performances.scenarios.vocabulary import Script
from affectsim_data.builders.performances.styles import POSTURES, Performer, blend
from affectsim_data.motions.motion import Emotion

__all__ = ["stage_script"]

_SHORTEST_S, _LONGEST_S = 5.0, 10.0
_RUBATO = 0.007
"""How far a performer is ahead of or behind the script, as a share of it."""
_MOOD = np.array([0.06, 0.06, 0.12])
"""Spread of tempo, reach and of turns, shifts and steps from take to take, as shares."""


def stage_script(
    script: Script,
    emotion: Emotion,
    who: Performer,
    *,
    intensity: float,
    rng: np.random.Generator,
    num_frames: int | None = None,
) -> BodyTrack:
    """A script performed in an emotion's posture and manner.

    Args:
        script: What is done.
        emotion: What is felt.
        who: The performer.
        intensity: 1 is the full style, 0 a plain version of the same.
        rng: Noise of this take.
        num_frames: Length of the cycle at 30 fps, and keys exactly in time; by default the
            script's own length under this performer's tempo, and a free sense of time.
    """
    who = who.feeling(emotion)
    length_s = script.plain_s + intensity * (script.duration_s - script.plain_s)
    mood = np.exp(np.clip(rng.normal(size=3), -2.0, 2.0) * _MOOD)
    if num_frames is None:
        length_s = float(np.clip(length_s / (who.tempo * mood[0]), _SHORTEST_S, _LONGEST_S))
        phase = cycle_phase(round(length_s * FPS))
        rubato = noise(phase, amplitude=_RUBATO, rng=rng, terms=3)
        phase = np.clip(phase + rubato - rubato[0], 0.0, 1.0 - 1e-9)
    else:
        phase, mood = cycle_phase(num_frames), np.ones(3)
    stage = Stage(
        script=script,
        who=who,
        posture=blend(POSTURES[emotion], POSTURES["neutral"], intensity),
        manner=MANNERS[emotion],
        time_s=phase * script.duration_s,
        size=who.reach * (0.68 + 0.32 * intensity) * mood[1],
        amount=(0.55 + 0.45 * intensity) * mood[2],
        rng=rng,
    )
    track = lower_body(stage)
    upper_body(stage, track)
    settle(stage, track)
    place_arms(stage, track)
    return track
