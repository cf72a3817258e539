"""What an evaluation says: numbers with intervals, ready for a table. Shares are in [0, 1]."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, Literal

__all__ = [
    "AcquisitionSummary",
    "Benefit",
    "Breakdown",
    "ConditionScore",
    "Estimate",
    "Evaluation",
    "GroupMean",
    "ModelCard",
    "PairedTest",
    "ReferenceRow",
    "RingCount",
    "Settings",
    "Subset",
]

Subset = Literal["all", "new_observation"]
"""All episodes, or those in which the policy collected a new clip after its handoff."""


@dataclasses.dataclass(frozen=True)
class Estimate:
    """A number and its confidence interval; NaN for what is undefined or was not asked for.

    Bounds are infinite for a ratio whose denominator may be zero: it can be anything.
    """

    value: float
    low: float = math.nan
    high: float = math.nan

    @property
    def excludes_zero(self) -> bool:
        """Whether the interval is there and lies on one side of zero."""
        return self.low > 0 or self.high < 0


@dataclasses.dataclass(frozen=True)
class ModelCard:
    """A recognizer as tables name it."""

    model: str
    group: str = ""
    """Rows of the tables are gathered by it; empty where nobody said."""
    parameters: str = ""
    """Size, `7B`."""


@dataclasses.dataclass(frozen=True)
class ConditionScore:
    """Recognition quality of a model under a condition."""

    model: str
    condition: str
    subset: Subset
    num_episodes: int
    macro_f1: Estimate
    """Over all episodes: what could not be parsed is wrong."""
    accuracy: Estimate
    macro_f1_valid: float
    """Over the answers that name an emotion only."""
    num_valid: int
    outcomes: Mapping[str, int]
    """How often each of `OUTCOMES` came."""
    recall: Mapping[str, Estimate]
    """By emotion."""
    confusion: tuple[tuple[int, ...], ...]
    """Rows: the truth; columns: the five emotions as answered, and anything else."""
    median_latency_ms: float


@dataclasses.dataclass(frozen=True)
class Benefit:
    """What observation did for a model; NaN where a condition is missing."""

    model: str
    subset: Subset
    gain: Estimate
    """Macro-F1 under a_obs minus p_init."""
    gap: Estimate
    """Macro-F1 under p_ref minus p_init: the observation gap."""
    monitor_gap: Estimate
    """Macro-F1 under p_mon minus p_init."""
    ogr: Estimate
    """Observation gap recovery, gain / gap; NaN unless the gap is positive, and with infinite
    bounds where it may be zero."""
    recovery_rate: Estimate
    """Share of wrong answers under p_init that are right under a_obs."""
    num_initial_errors: int
    e_spl: Mapping[int, Estimate]
    """E-SPL by ring, metres."""


@dataclasses.dataclass(frozen=True)
class PairedTest:
    """Whether a model answers better under `condition` than under p_init, by the same episodes."""

    model: str
    condition: str
    num_pairs: int
    """Episodes whose clips differ; ties by construction are no evidence and are left out."""
    num_tied: int
    """Episodes left out: the very clip of p_init."""
    only_initial: int
    """Right under p_init only."""
    only_condition: int
    """Right under the condition only."""
    mcnemar_p: float
    """Exact, two-sided; takes episodes for independent."""
    permutation_p: float
    """Two-sided, swapping the conditions of whole clusters."""
    mcnemar_holm_p: float
    permutation_holm_p: float
    """The same, adjusted for the number of models after Holm."""
    detectable: float
    """Minimum difference in accuracy among these pairs that so many clusters would show, at 80 %
    power."""


@dataclasses.dataclass(frozen=True)
class Breakdown:
    """Recognition quality within one level of a factor."""

    factor: str
    """family, challenge, action, emotion or scene_id."""
    level: str
    model: str
    condition: str
    num_episodes: int
    num_clusters: int
    macro_f1: Estimate
    """Over the emotions there are in it; for factor emotion the recall."""
    accuracy: Estimate


@dataclasses.dataclass(frozen=True)
class GroupMean:
    """Unweighted means over the models of a group; `group` is empty for all models."""

    group: str
    subset: Subset
    num_models: int
    macro_f1: Mapping[str, Estimate]
    """By condition."""
    recall: Mapping[str, Mapping[str, Estimate]]
    """By condition, by emotion."""
    family_macro_f1: Mapping[str, Mapping[str, Estimate]]
    """By family, by condition."""
    gain: Estimate
    gap: Estimate
    ogr_of_means: Estimate
    """Mean gain over mean gap: one number for the group."""
    mean_ogr: Estimate
    """Mean of the models' own OGR, over those that have one."""
    num_ogr: int
    """Models that have one."""
    recovery_rate: Estimate
    e_spl: Mapping[int, Estimate]
    monitor_gap: Estimate = Estimate(math.nan)
    """Macro-F1 under p_mon minus p_init."""


@dataclasses.dataclass(frozen=True)
class AcquisitionSummary:
    """How a policy behaved over episodes; for the whole table, or a level of a factor."""

    policy: str
    factor: str
    """Empty for all episodes, else family, challenge, action, emotion or scene_id."""
    level: str
    num_episodes: int
    stable_handoff: Estimate
    """Share of episodes."""
    mean_path_m: Estimate
    path_before_handoff: Estimate
    """Share of all locomotion."""
    budget_exhausted: Estimate
    """Share of episodes."""
    clipped: Estimate
    """Share of attempted translations."""
    new_observations: int
    """Episodes with a clip collected after the handoff."""


@dataclasses.dataclass(frozen=True)
class RingCount:
    """Episodes E-SPL at a distance is over, and those it leaves out."""

    distance_m: int
    num_valid: int
    num_empty: int
    num_unreachable: int


@dataclasses.dataclass(frozen=True)
class ReferenceRow:
    """What answering without looking scores on this table: its expected Macro-F1."""

    name: str
    macro_f1: float


@dataclasses.dataclass(frozen=True)
class Settings:
    """How intervals and tests were made."""

    cluster: str
    """performance or performer."""
    num_clusters: int
    confidence: float
    num_resamples: int
    num_permutations: int
    seed: int
    interval: str
    """The kind of bootstrap interval."""


@dataclasses.dataclass(frozen=True)
class Evaluation:
    """All results of an evaluation."""

    release: str
    split: str
    num_episodes: int
    settings: Settings
    models: tuple[ModelCard, ...]
    conditions: tuple[str, ...]
    scores: tuple[ConditionScore, ...]
    benefits: tuple[Benefit, ...]
    tests: tuple[PairedTest, ...]
    breakdowns: tuple[Breakdown, ...]
    means: tuple[GroupMean, ...]
    acquisition: tuple[AcquisitionSummary, ...]
    """Empty without trajectories."""
    rings: tuple[RingCount, ...]
    references: tuple[ReferenceRow, ...]
    """Constant answers, uniform guessing, guessing by the prior."""
    chance: float
    """Expected Macro-F1 of uniform guessing on this table: what a score is to be held against."""
    notes: tuple[str, ...]

    def score(self, model: str, condition: str, subset: Subset = "all") -> ConditionScore | None:
        """The score of a model under a condition, or `None` if it was not run under it."""
        key = (model, condition, subset)
        return next(
            (one for one in self.scores if (one.model, one.condition, one.subset) == key), None
        )

    def benefit(self, model: str, subset: Subset = "all") -> Benefit | None:
        """What observation did for a model, or `None` if it has no such entry."""
        return next(
            (one for one in self.benefits if (one.model, one.subset) == (model, subset)), None
        )

    def to_json(self) -> dict[str, Any]:
        """Everything as JSON knows it; NaN becomes null."""
        plain = _plain(dataclasses.asdict(self))
        assert isinstance(plain, dict)
        return plain


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(one) for one in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
