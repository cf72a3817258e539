"""Predictions beside the truth: what the metrics and their statistics are computed from."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from affectsim_data.motions import EMOTIONS

__all__ = [
    "NUM_COLUMNS",
    "OUTCOMES",
    "RINGS_M",
    "Acquisitions",
    "Outcome",
    "ScoredTable",
    "outcome_code",
]

Outcome = Literal["refusal", "ambiguous", "empty", "other", "missing"]
OUTCOMES: tuple[Outcome, ...] = get_args(Outcome)
"""What stands where no emotion was named; `missing`: allowed to, and counted as wrong."""
NUM_COLUMNS = len(EMOTIONS) + 1
"""Columns of a confusion: the five emotions, and anything else."""
RINGS_M = (1, 3, 5)
"""Distances of the rings E-SPL refers to, metres."""


def outcome_code(outcome: Outcome) -> int:
    """How an outcome that is no emotion stands in `ScoredTable.answers`: -1, -2, ...

    Examples:
        >>> outcome_code("refusal"), outcome_code("missing")
        (-1, -5)
    """
    return -1 - OUTCOMES.index(outcome)


@dataclasses.dataclass(frozen=True)
class Acquisitions:
    """What a policy did in each episode, from its trajectory; arrays `(num_episodes,)`."""

    policy: str
    """Name of the policy."""
    path_length_m: NDArray[np.float64]
    """Way over the floor, from start to the end of the episode."""
    path_before_handoff_m: NDArray[np.float64]
    """The part of it before the handoff; all of it where there was none."""
    num_steps: NDArray[np.int64]
    """Actions."""
    planner_calls: NDArray[np.int64]
    """Calls of the planner."""
    num_translations: NDArray[np.int64]
    """Attempts to move forward."""
    num_clipped: NDArray[np.int64]
    """Those cut short."""
    handed_off: NDArray[np.bool_]
    """Whether it came to a stable handoff."""
    acquired: NDArray[np.bool_]
    """Whether a new clip was collected after it; elsewhere a_obs is the paired p_init clip."""
    budget_exhausted: NDArray[np.bool_]
    """Whether it ended because actions or planner calls ran out."""


@dataclasses.dataclass(frozen=True)
class ScoredTable:
    """Every model's answer about every episode under every condition, with what is known of these.

    `answers` holds the index of an emotion, or a negative `outcome_code`.
    """

    release: str
    """Where the episodes come from."""
    split: str
    """Their split."""
    episode_ids: NDArray[np.str_]
    """`(num_episodes,)`, in the order of the release."""
    truth: NDArray[np.int8]
    """Index of the emotion, `(num_episodes,)`."""
    factors: Mapping[str, NDArray[np.str_]]
    """`(num_episodes,)` each: family, challenge (empty outside its family), action, emotion,
    scene_id, performer_id, motion_id, group_id, placement_id."""
    performances: NDArray[np.int64]
    """Code of the performance each episode replays, `(num_episodes,)`, from 0: the clusters."""
    performers: NDArray[np.int64]
    """Code of the performer, `(num_episodes,)`, from 0."""
    models: tuple[str, ...]
    """Recognizers, in the order of first appearance."""
    conditions: tuple[str, ...]
    """Conditions any of them was run under: p_mon, p_ref, p_init, a_obs, then others by name."""
    answers: NDArray[np.int8]
    """`(num_models, num_conditions, num_episodes)`."""
    was_run: NDArray[np.bool_]
    """`(num_models, num_conditions)`: whether there are predictions at all."""
    latency_ms: NDArray[np.float32]
    """`(num_models, num_conditions, num_episodes)`, NaN where not told."""
    same_frames: NDArray[np.bool_]
    """`(num_conditions, num_episodes)`: the clip is that of p_init by construction (fallback, or
    equal hashes of frames); such a tie is no evidence. All true for p_init itself."""
    d_star_m: NDArray[np.float64]
    """`(len(RINGS_M), num_episodes)`, NaN where the ring is empty or out of reach."""
    ring_empty: NDArray[np.bool_]
    """`(len(RINGS_M), num_episodes)`: NaN above because the ring is empty, not unreachable."""
    acquisitions: Acquisitions | None = None
    """What the policy behind a_obs did; `None` without trajectories."""
    notes: tuple[str, ...] = ()
    """What a reader of the result must know: predictions missing, answers that differ for equal
    frames, ..."""

    def __post_init__(self) -> None:
        counts = (len(self.models), len(self.conditions), len(self.episode_ids))
        expected: dict[str, tuple[int, ...]] = {
            "truth": counts[2:],
            "performances": counts[2:],
            "performers": counts[2:],
            "answers": counts,
            "was_run": counts[:2],
            "latency_ms": counts,
            "same_frames": counts[1:],
            "d_star_m": (len(RINGS_M), counts[2]),
            "ring_empty": (len(RINGS_M), counts[2]),
        }
        for name, shape in expected.items():
            array: NDArray[Any] = getattr(self, name)
            if array.shape != shape:
                raise ValueError(f"{name} must be {shape}, got {array.shape}")

    @property
    def num_episodes(self) -> int:
        """Episodes of the table."""
        return len(self.episode_ids)

    def condition_index(self, condition: str) -> int | None:
        """Place of a condition, or `None` if nothing was run under it."""
        return self.conditions.index(condition) if condition in self.conditions else None
