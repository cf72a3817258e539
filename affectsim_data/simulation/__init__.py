"""Active observation: a robot that acts in an episode to see better.

Where gymnasium is installed, importing this makes `AffectSim/ActiveObservation-v0` known to it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from affectsim_data.simulation.actions import ACTIONS, Action, Budget
from affectsim_data.simulation.registering import ENVIRONMENT_ID, register_environment
from affectsim_data.simulation.running import EpisodeRun, Observation

if TYPE_CHECKING:
    from affectsim_data.simulation.environment import AffectSimEnv

__all__ = [
    "ACTIONS",
    "ENVIRONMENT_ID",
    "Action",
    "AffectSimEnv",
    "Budget",
    "EpisodeRun",
    "Observation",
    "register_environment",
]

register_environment()


def __getattr__(name: str) -> Any:
    # Policies and recordings need no gymnasium; only the environment does.
    if name != "AffectSimEnv":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from affectsim_data.simulation.environment import AffectSimEnv

    return AffectSimEnv
