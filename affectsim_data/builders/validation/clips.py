"""Whether clips begin and last as they must."""

from __future__ import annotations

from affectsim_data.builders.validation.findings import Measure
from affectsim_data.builders.validation.tables import Tables
from affectsim_data.episodes import CLIP_FPS

__all__ = ["check_clips"]

LONGEST_S, FEWEST_FRAMES = 600.0, 2
"""Of a clip: what is longer is no performance, what is shorter no clip."""
_BELOW_ONE = 1.0 - 1e-12


def check_clips(tables: Tables) -> list[Measure]:
    """Phases in [0, D) and lengths of clips of two cycles."""
    duration = tables.episodes.number("duration_s")
    phase = tables.episodes.number("phase_s") / duration
    ids = tables.episode_ids
    shortest = FEWEST_FRAMES / CLIP_FPS
    return [
        Measure.of("phase", ids, phase, low=0.0, high=_BELOW_ONE),
        Measure.of("clip_length", ids, 2.0 * duration, low=shortest, high=LONGEST_S),
    ]
