"""`stay` and `random`: policies that do not look, below which none should fall."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.cameras import Camera
from affectsim_data.simulation.actions import Action
from affectsim_data.simulation.policies.protocol import Decision
from affectsim_data.simulation.running import Observation

__all__ = ["RandomPolicy", "StayPolicy"]

_MOVES: tuple[Action, ...] = ("move_forward", "move_forward", "turn_left", "turn_right")
"""Each as likely as the others: half of the time it goes ahead."""
_DEFAULT_STEPS = 40


@dataclasses.dataclass(frozen=True)
class StayPolicy:
    """Hands off at once and never moves: what it acquires is P-Init."""

    name: str = "stay"

    def reset(self, camera: Camera, *, seed: int) -> None:
        """Nothing to forget."""

    def act(self, observation: Observation) -> Decision:
        """The handoff, then waiting."""
        return Decision("stop" if observation.collecting else "hand_off")


class RandomPolicy:
    """Goes about at random, hands off after so many steps and stays there."""

    def __init__(self, num_steps: int = _DEFAULT_STEPS) -> None:
        """Decides how far it goes.

        Args:
            num_steps: Actions before the handoff.

        Raises:
            ValueError: Fewer than none.
        """
        if num_steps < 0:
            raise ValueError(
                f"random: steps before the handoff must be at least 0, got {num_steps}"
            )
        self._num_steps = self._left = num_steps
        self._rng = np.random.default_rng(0)

    @property
    def name(self) -> str:
        """`random`, or `random:STEPS` with another number of steps."""
        usual = self._num_steps == _DEFAULT_STEPS
        return "random" if usual else f"random:{self._num_steps}"

    def reset(self, camera: Camera, *, seed: int) -> None:
        """Begins its random numbers anew."""
        self._rng, self._left = np.random.default_rng(seed), self._num_steps

    def act(self, observation: Observation) -> Decision:
        """Any of three moves, the handoff, then waiting."""
        if observation.collecting:
            return Decision("stop")
        if not self._left:
            return Decision("hand_off")
        self._left -= 1
        return Decision(_MOVES[self._rng.integers(len(_MOVES))])
