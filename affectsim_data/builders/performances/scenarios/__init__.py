"""Standing performances that express an emotion with the whole body, by name.

Every emotion has the same number of them, so a take number says nothing of the emotion. What is
done is a `Script` (`vocabulary`; one module an emotion), put on a performer by `staging`.
"""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.performances.rig import BodyTrack
from affectsim_data.builders.performances.scenarios import angry, fearful, happy, neutral, sad
from affectsim_data.builders.performances.scenarios.staging import stage_script
from affectsim_data.builders.performances.scenarios.vocabulary import Script
from affectsim_data.builders.performances.styles import Performer
from affectsim_data.motions.motion import Emotion, emotion_label

__all__ = ["NUM_SCENARIOS", "SCENARIOS", "scenario_track"]

_SCRIPTS: dict[Emotion, dict[str, Script]] = {
    "angry": angry.SCRIPTS,
    "fearful": fearful.SCRIPTS,
    "happy": happy.SCRIPTS,
    "neutral": neutral.SCRIPTS,
    "sad": sad.SCRIPTS,
}
SCENARIOS: dict[Emotion, tuple[str, ...]] = {
    emotion: tuple(scripts) for emotion, scripts in _SCRIPTS.items()
}
"""Names of the performances of each emotion, in the order of their take numbers."""
NUM_SCENARIOS = len(SCENARIOS["neutral"])
"""Performances of each emotion."""


def scenario_track(
    emotion: Emotion,
    take: int,
    who: Performer,
    *,
    intensity: float,
    rng: np.random.Generator,
) -> tuple[str, BodyTrack]:
    """One standing performance of 5 to 10 s at 30 fps, a closed cycle: its name and its track.

    Args:
        emotion: What is felt.
        take: Which of `SCENARIOS[emotion]`.
        who: The performer.
        intensity: 1 is the full style; towards 0 the same is done in a neutral posture, smaller
            and more evenly.
        rng: Noise of this take.

    Raises:
        ValueError: Not one of the emotions, or not one of the takes.
    """
    emotion_label(emotion)
    names = SCENARIOS[emotion]
    if not 0 <= take < len(names):
        listed = ", ".join(f"{index} {name}" for index, name in enumerate(names))
        raise ValueError(f"take of a {emotion} scenario must be one of {listed}, got {take}")
    script = _SCRIPTS[emotion][names[take]]
    return names[take], stage_script(script, emotion, who, intensity=intensity, rng=rng)
