"""Replayable affective episodes whose observation is an experimental variable.

The public names load on first use, so that importing the package opens no display and loads
neither torch nor Rerun.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from affectsim_data.cameras import Camera, CameraTrajectory
    from affectsim_data.episodes import Episode, World
    from affectsim_data.loaders import AffectSimDataset, Clip, Sample, data_loader
    from affectsim_data.motions import EMOTIONS, Motion
    from affectsim_data.observations import Condition, Orbit, PInit, PMon, PRef
    from affectsim_data.releases import Release, open_release

__version__ = "0.1.0"

__all__ = [
    "EMOTIONS",
    "AffectSimDataset",
    "Camera",
    "CameraTrajectory",
    "Clip",
    "Condition",
    "Episode",
    "Motion",
    "Orbit",
    "PInit",
    "PMon",
    "PRef",
    "Release",
    "Sample",
    "World",
    "__version__",
    "data_loader",
    "open_release",
]

_HOMES = {
    "cameras": ("Camera", "CameraTrajectory"),
    "episodes": ("Episode", "World"),
    "loaders": ("AffectSimDataset", "Clip", "Sample", "data_loader"),
    "motions": ("EMOTIONS", "Motion"),
    "observations": ("Condition", "Orbit", "PInit", "PMon", "PRef"),
    "releases": ("Release", "open_release"),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'affectsim_data' has no attribute {name!r}")
    return getattr(importlib.import_module(f"affectsim_data.{_HOME_OF[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
