"""Makes the environment known to gymnasium by name, where gymnasium is installed.

Gymnasium has had no plugins since 1.0: a package registers its environments when it is imported.
"""

from __future__ import annotations

import importlib.util

__all__ = ["ENVIRONMENT_ID", "register_environment"]

ENVIRONMENT_ID = "AffectSim/ActiveObservation-v0"
"""What `gymnasium.make` takes."""


def register_environment() -> None:
    """Registers the environment unless it is, or there is no gymnasium to tell; loads no code."""
    if importlib.util.find_spec("gymnasium") is None:
        return
    from gymnasium.envs.registration import register, registry

    if ENVIRONMENT_ID not in registry:
        register(
            id=ENVIRONMENT_ID, entry_point="affectsim_data.simulation.environment:AffectSimEnv"
        )
