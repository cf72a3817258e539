"""What a condition is, and the names of the built-in ones."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from affectsim_data.cameras import CameraTrajectory
from affectsim_data.episodes import Episode, World
from affectsim_data.poses import FloatArray

__all__ = ["Condition"]


@runtime_checkable
class Condition(Protocol):
    """How an episode is seen: turns an episode and its world into a camera trajectory."""

    @property
    def name(self) -> str:
        """What samples, files and tables call it."""
        ...

    def trajectory(self, episode: Episode, world: World, time_s: FloatArray) -> CameraTrajectory:
        """Camera poses at motion instants `(num_frames,)`, seconds.

        Instants count from the start of a motion cycle and may run past its end.
        """
        ...
