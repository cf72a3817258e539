"""Conditions and clips by name: the presets in `loaders/*.toml`."""

from __future__ import annotations

import dataclasses
import tomllib
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from affectsim_data.content import content_names, content_path
from affectsim_data.observations import AObs, Condition, Orbit, PInit, PMon, PRef, RecordedRuns

__all__ = ["Clip", "condition_names", "is_recorded", "resolve_clip", "resolve_condition"]

_CONDITION_TYPES: dict[str, type[PInit | PRef | PMon | Orbit | AObs]] = {
    "PInit": PInit,
    "PRef": PRef,
    "PMon": PMon,
    "Orbit": Orbit,
    "AObs": AObs,
}
MAX_CLIP_FRAMES = 100_000


@dataclasses.dataclass(frozen=True)
class Clip:
    """Which frames of the 30 fps grid a recognizer sees, and how large."""

    num_frames: int | Literal["all"]
    """Evenly spaced frames, or every frame."""
    width: int
    """Pixels."""
    height: int
    """Pixels."""
    name: str = "custom"
    """What samples call it."""

    def __post_init__(self) -> None:
        allowed = self.num_frames == "all" or (
            isinstance(self.num_frames, int) and 1 <= self.num_frames <= MAX_CLIP_FRAMES
        )
        if not allowed:
            raise ValueError(
                f"clip {self.name!r}: num_frames must be 1 to {MAX_CLIP_FRAMES} or 'all', "
                f"got {self.num_frames!r}"
            )

    def frame_indices(self, num_grid_frames: int) -> NDArray[np.int64]:
        """Frames of the grid, `round(linspace(0, N - 1, n))`, `(n,)`.

        Examples:
            >>> Clip(num_frames=4, width=8, height=8).frame_indices(10).tolist()
            [0, 3, 6, 9]
        """
        if self.num_frames == "all":
            return np.arange(num_grid_frames)
        return np.round(np.linspace(0, num_grid_frames - 1, self.num_frames)).astype(np.int64)


def _read_presets(kind: str) -> dict[str, dict[str, Any]]:
    presets = {}
    for name in content_names("loaders", ".toml"):
        with content_path("loaders", f"{name}.toml").open("rb") as stream:
            preset = tomllib.load(stream)
        if preset.pop("kind") == kind:
            presets[name] = preset
    return presets


def condition_names() -> list[str]:
    """Names of the conditions with a preset."""
    return list(_read_presets("condition"))


def is_recorded(condition: str | Condition) -> bool:
    """Whether a condition is the name of a preset that shows recorded trajectories."""
    if not isinstance(condition, str):
        return False
    return _read_presets("condition").get(condition, {}).get("type") == AObs.__name__


def resolve_condition(
    condition: str | Condition, *, trajectories: RecordedRuns | None = None
) -> Condition:
    """A condition object, from itself or from the name of a preset.

    Args:
        condition: Either.
        trajectories: What was recorded, for a preset that shows it.

    Raises:
        ValueError: Neither, or nothing recorded for a preset that needs it.
    """
    if not isinstance(condition, str):
        if not isinstance(condition, Condition):
            raise ValueError(f"a condition has a name and a trajectory method, got {condition!r}")
        return condition
    presets = _read_presets("condition")
    if condition not in presets:
        raise ValueError(
            f"condition must be one of {', '.join(presets)} or an object such as "
            f"Orbit(distance_m=2.0, azimuth_deg=90.0), got {condition!r}"
        )
    preset = presets[condition]
    kind = preset.pop("type")
    if kind != AObs.__name__:
        return _CONDITION_TYPES[kind](**preset)
    if trajectories is None:
        raise ValueError(
            f"condition {condition!r} shows what a policy recorded: give AffectSimDataset "
            "trajectories='T.parquet', or AObs(RecordedRuns.from_parquet('T.parquet')) as condition"
        )
    return AObs(trajectories, **preset)


def resolve_clip(clip: str | Clip) -> Clip:
    """A clip, from itself or from the name of a preset.

    Raises:
        ValueError: Neither.
    """
    if isinstance(clip, Clip):
        return clip
    presets = _read_presets("clip")
    if clip not in presets:
        raise ValueError(f"clip must be a Clip or one of {', '.join(presets)}, got {clip!r}")
    return Clip(**presets[clip], name=clip)
