"""One episode under several conditions, drawn once for sheets and recordings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from affectsim_data.episodes import Episode, World
from affectsim_data.loaders import Clip, clip_spec, resolve_condition
from affectsim_data.observations import Condition, Orbit
from affectsim_data.render import Renderer

__all__ = ["SHOWN_CONDITIONS", "condition_title", "draw_views"]

SHOWN_CONDITIONS: tuple[str | Condition, ...] = (
    "p_init",
    "p_ref",
    "p_mon",
    Orbit(distance_m=2.0, azimuth_deg=135.0),
)
"""What sheets and recordings show: the three stored conditions and a counterfactual one."""

_TITLES = {
    "p_init": "P-Init (robot's first pose)",
    "p_ref": "P-Ref (reference observer)",
    "p_mon": "P-Mon (room monitor)",
}


def condition_title(condition: Condition) -> str:
    """A heading a reader understands."""
    if isinstance(condition, Orbit):
        return f"Orbit ({condition.distance_m:g} m, {condition.azimuth_deg:g}\N{DEGREE SIGN})"
    return _TITLES.get(condition.name, condition.name)


def draw_views(
    episode: Episode,
    world: World,
    renderer: Renderer,
    *,
    conditions: Sequence[str | Condition] = SHOWN_CONDITIONS,
    clip: Clip,
) -> dict[str, NDArray[np.uint8]]:
    """RGB frames `(num_frames, height, width, 3)` of an episode, by condition name."""
    views = {}
    for item in conditions:
        condition = resolve_condition(item)
        spec, _ = clip_spec(episode, world, condition, clip)
        views[condition.name] = renderer.render(spec).rgb
    return views
