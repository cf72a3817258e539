"""Episodes of the small release in which policies act, and nothing is drawn unless asked for."""

from __future__ import annotations

import math

from affectsim_data.cameras import Camera
from affectsim_data.releases import Release
from affectsim_data.render import Renderer
from affectsim_data.simulation.actions import Budget
from affectsim_data.simulation.blind import BlindRenderer
from affectsim_data.simulation.running import EpisodeRun

CAMERA = Camera(width=8, height=8, hfov=math.radians(60.0))


def make_run(
    small: Release,
    policy: str,
    *,
    index: int = 0,
    renderer: Renderer | None = None,
    camera: Camera = CAMERA,
    budget: Budget | None = None,
) -> EpisodeRun:
    """An episode of the small release's test split that draws nothing."""
    episode = small.episode("test", index)
    return EpisodeRun(
        episode,
        small.world(episode),
        small.navmesh(episode.scene_id),
        BlindRenderer() if renderer is None else renderer,
        policy=policy,
        camera=camera,
        budget=budget,
    )
