"""You learn: act in several episodes at once, at random, and keep what was done.

Every process has its share of the episodes, so none is acted in twice. A random robot rarely hands
off on purpose; what its clips are worth is for a recognizer to say, not for the reward, which is 0.
"""

from __future__ import annotations

import argparse
import functools
from collections import Counter
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AsyncVectorEnv, AutoresetMode

from affectsim_data.simulation import ACTIONS, ENVIRONMENT_ID, Budget

CHANCES = (0.5, 0.2, 0.2, 0.09, 0.01)
"""Of moving, turning left and right, handing off and giving up."""


def make(rank: int, world_size: int, release: str) -> gymnasium.Env[Any, Any]:
    """One environment; called in the process it belongs to."""
    # `gymnasium.make` finds the environment because `affectsim_data.simulation` was imported.
    return gymnasium.make(
        ENVIRONMENT_ID,
        release=release,
        split="test",
        size=112,
        rank=rank,
        world_size=world_size,
        budget=Budget(max_actions=40),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--release", default="mini")
    parser.add_argument("--envs", type=int, default=2)
    parser.add_argument("--steps", type=int, default=150)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()

    makers = [
        functools.partial(make, rank, options.envs, options.release) for rank in range(options.envs)
    ]
    # Contexts of OpenGL do not survive a fork, so processes are started afresh.
    envs = AsyncVectorEnv(makers, context="spawn", autoreset_mode=AutoresetMode.NEXT_STEP)
    rng = np.random.default_rng(options.seed)
    observations, _ = envs.reset(seed=options.seed)
    print({name: (array.shape, str(array.dtype)) for name, array in observations.items()})
    done: Counter[str] = Counter()
    farthest_m = 0.0
    for _ in range(options.steps):
        actions = rng.choice(len(ACTIONS), size=options.envs, p=CHANCES)
        observations, _, terminated, truncated, _ = envs.step(actions)
        # Over and collecting: the clip is complete; over and not: given up.
        collected = observations["collecting"] == 1
        done["collected"] += int((terminated & collected).sum())
        done["given up"] += int((terminated & ~collected).sum())
        done["out of budget"] += int(truncated.sum())
        done["cut short"] += int(observations["clipped"].sum())
        away = np.hypot(*observations["pose"][:, :2].T)
        farthest_m = max(farthest_m, float(away.max()))
    envs.close()
    print(f"{options.envs * options.steps} steps: {dict(done)}; farthest {farthest_m:.2f} m away")


if __name__ == "__main__":
    main()
