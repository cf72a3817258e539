"""Whether intervals and tests keep their promise on a plan, measured on simulated studies."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from affectsim_data.evaluation.bootstrap import (
    degrees_of_freedom,
    effective_clusters,
    interval,
    ratio_interval,
    resampled,
    resampling_weights,
    sampling_strata,
    share_interval,
)
from affectsim_data.evaluation.confusion import (
    accuracies,
    confusion_codes,
    macro_f1_scores,
    recalls,
)
from affectsim_data.evaluation.scored import NUM_COLUMNS
from affectsim_data.evaluation.significance import cluster_permutation, mcnemar_exact
from affectsim_data.evaluation.simulating import (
    Plan,
    Skill,
    expected_confusions,
    simulated_answers,
)
from affectsim_data.motions import EMOTIONS
from affectsim_data.poses import FloatArray

__all__ = ["STUDY_METRICS", "ErrorRates", "StudyMetric", "measure_coverage", "measure_errors"]

StudyMetric = Literal["macro_f1", "gain", "gap", "ogr", "accuracy", "recall"]
STUDY_METRICS: tuple[StudyMetric, ...] = get_args(StudyMetric)
"""Macro-F1, accuracy and recall are those under p_init, recall that of the first emotion."""
_CONDITIONS = ("p_init", "p_ref", "a_obs")
_CELLS = len(EMOTIONS) * NUM_COLUMNS
_BATCH_ROWS = 4000
"""Clusters of all studies that are resampled at a time."""


@dataclasses.dataclass(frozen=True)
class ErrorRates:
    """Share of studies in which a_obs and p_init are called different at 5 %, by test."""

    permutation: float
    """Swapping whole clusters."""
    interval: float
    """The cluster interval of the gain in Macro-F1 excludes 0."""
    mcnemar: float
    """Taking episodes for independent."""


def measure_coverage(
    plan: Plan,
    skill: Skill,
    *,
    unit: Literal["performance", "episode"] = "performance",
    num_repeats: int = 1000,
    num_resamples: int = 500,
    seed: int = 0,
) -> Mapping[StudyMetric, float]:
    """Share of simulated studies whose 95 % interval holds the truth, by metric.

    Its standard error is `sqrt(p (1 - p) / num_repeats)`: 0.7 points at 95 % and 1,000 studies.

    Args:
        plan: Performances and episodes.
        skill: Of the recognizer; needs p_init, p_ref and a_obs.
        unit: What intervals are from: whole performances, or naively single episodes.
        num_repeats: Studies.
        num_resamples: Draws of each.
        seed: Of studies and draws.
    """
    study = _Study.of(plan, skill, unit)
    truth = _metrics(expected_confusions(plan, study.skill))
    rng = np.random.default_rng(seed)
    held = []
    for start in range(0, num_repeats, study.batch):
        count = min(study.batch, num_repeats - start)
        answers = simulated_answers(plan, study.skill, rng, num_repeats=count)
        low, high = study.intervals(answers, num_resamples=num_resamples, seed=seed + start)
        held.append(np.where(np.isnan(low), np.nan, (low <= truth) & (truth <= high)))
    shares = np.nanmean(np.concatenate(held), axis=0)
    return dict(zip(STUDY_METRICS, shares.tolist(), strict=True))


def measure_errors(
    plan: Plan,
    skill: Skill,
    *,
    num_repeats: int = 1000,
    num_resamples: int = 500,
    seed: int = 0,
) -> ErrorRates:
    """Share of simulated studies in which each test finds a_obs and p_init different, at 5 %.

    With equal signals under both this is the type I error, else the power. Tests leave out episodes
    of fallback; the gain is over all, as in the protocol.
    """
    study = _Study.of(plan, skill, "performance")
    rng = np.random.default_rng(seed)
    fresh = ~plan.fallback
    clusters = np.unique(plan.clusters[fresh], return_inverse=True)[1]
    found = []
    for start in range(0, num_repeats, study.batch):
        count = min(study.batch, num_repeats - start)
        answers = simulated_answers(plan, study.skill, rng, num_repeats=count)
        right = (answers == plan.episode_truth)[..., fresh]
        before, after = right[:, 0], right[:, 2]
        permuted = cluster_permutation(
            after.astype(np.float64) - before,
            clusters,
            num_permutations=num_resamples,
            seed=seed + start,
        )
        low, high = study.intervals(answers, num_resamples=num_resamples, seed=seed + start)
        mcnemar = mcnemar_exact((before & ~after).sum(axis=1), (after & ~before).sum(axis=1))
        gain = STUDY_METRICS.index("gain")
        outside = (low[:, gain] > 0) | (high[:, gain] < 0)
        found.append(np.stack([permuted <= 0.05, outside, mcnemar <= 0.05]))
    return ErrorRates(*np.concatenate(found, axis=1).mean(axis=1).tolist())


@dataclasses.dataclass(frozen=True)
class _Study:
    """What all simulated studies of a plan have in common."""

    plan: Plan
    skill: Skill
    clusters: NDArray[np.int64]
    strata: NDArray[np.int64]

    @classmethod
    def of(cls, plan: Plan, skill: Skill, unit: Literal["performance", "episode"]) -> _Study:
        missing = [name for name in _CONDITIONS if name not in skill.signal]
        if missing:
            raise ValueError(f"the signal must be of {', '.join(_CONDITIONS)}; no {missing[0]}")
        only = {name: skill.signal[name] for name in _CONDITIONS}
        clusters = plan.clusters if unit == "performance" else np.arange(len(plan.clusters))
        emotions = np.array(EMOTIONS)[plan.episode_truth]
        strata = sampling_strata(clusters, plan.episode_families, emotions)
        return cls(plan, dataclasses.replace(skill, signal=only), clusters, strata)

    @property
    def batch(self) -> int:
        return max(1, _BATCH_ROWS // len(self.strata))

    def intervals(
        self, answers: NDArray[np.int8], *, num_resamples: int, seed: int
    ) -> tuple[FloatArray, FloatArray]:
        """Bounds of every metric, `(num_repeats, num_metrics)` each."""
        num_clusters = len(self.strata)
        codes = confusion_codes(self.plan.episode_truth, answers)
        rows = np.arange(codes.shape[0] * codes.shape[1]).reshape(*codes.shape[:2], 1) * _CELLS
        places = (rows + codes) * num_clusters + self.clusters
        size = rows.size * _CELLS * num_clusters
        sums = np.bincount(places.ravel(), minlength=size).astype(np.float64)
        shape = (*codes.shape[:2], len(EMOTIONS), NUM_COLUMNS)
        sums = sums.reshape(*shape, num_clusters)
        weights = resampling_weights(
            num_clusters, num_resamples=num_resamples, seed=seed, strata=self.strata
        )
        return self._bounds(_metrics(sums.sum(axis=-1)), _metrics(resampled(sums, weights)))

    def _bounds(self, point: FloatArray, draws: FloatArray) -> tuple[FloatArray, FloatArray]:
        first = self.clusters[self.plan.episode_truth == 0]
        everything = degrees_of_freedom(self.clusters, self.strata)
        low, high = interval(point, draws, degrees=everything)
        gain, gap, ogr = (STUDY_METRICS.index(name) for name in ("gain", "gap", "ogr"))
        low[:, ogr], high[:, ogr] = ratio_interval(
            point[:, gain], point[:, gap], draws[..., gain], draws[..., gap], degrees=everything
        )
        for name, clusters in (("accuracy", self.clusters), ("recall", first)):
            place = STUDY_METRICS.index(name)
            low[:, place], high[:, place] = share_interval(
                point[:, place],
                draws[..., place],
                size=effective_clusters(clusters),
                degrees=degrees_of_freedom(clusters, self.strata),
            )
        return low, high


def _metrics(confusions: FloatArray) -> FloatArray:
    """`STUDY_METRICS` of confusions `(..., 3, 5, 6)` under `_CONDITIONS`, `(..., 6)`."""
    scores = macro_f1_scores(confusions)
    initial = confusions[..., 0, :, :]
    gain, gap = scores[..., 2] - scores[..., 0], scores[..., 1] - scores[..., 0]
    ratio = np.divide(gain, gap, out=np.full(gap.shape, np.nan), where=gap > 0)
    rows = (scores[..., 0], gain, gap, ratio, accuracies(initial), recalls(initial)[..., 0])
    return np.stack(rows, axis=-1)
