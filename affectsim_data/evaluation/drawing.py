"""The sample and its draws side by side, so that every number and its interval is one formula.

Arrays have a first axis of `1 + num_resamples`: row 0 is the sample itself, the others are draws of
its clusters. A metric is computed on all rows alike; row 0 is then its value, and the others its
spread. All models, conditions and metrics share the draws, which keeps their differences paired.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from affectsim_data.evaluation.bootstrap import (
    check_clusters,
    cluster_sums,
    degrees_of_freedom,
    effective_clusters,
    interval,
    ratio_interval,
    resampled,
    resampling_weights,
    sampling_strata,
    share_interval,
)
from affectsim_data.evaluation.results import Estimate
from affectsim_data.evaluation.scored import ScoredTable
from affectsim_data.poses import FloatArray

__all__ = ["Bounds", "ClusterLevel", "Drawing", "Support"]

ClusterLevel = Literal["performance", "performer"]
_STEP = 2.0**-16
"""Weights and sums of lengths are rounded to it in draws, by less than a hundred-thousandth:
products and their sums are then exact, in whatever order threads add them up."""


@dataclasses.dataclass(frozen=True)
class Support:
    """How much there is behind a number: what its interval is scaled by."""

    degrees: float
    """Degrees of freedom; 0 where there are too few clusters for an interval."""
    size: float
    """Clusters of equal size that would tell as much."""


@dataclasses.dataclass(frozen=True)
class Bounds:
    """Values with their intervals, arrays of one shape."""

    value: FloatArray
    low: FloatArray
    high: FloatArray

    def at(self, *place: int) -> Estimate:
        """The estimate at a place."""
        return Estimate(float(self.value[place]), float(self.low[place]), float(self.high[place]))


@dataclasses.dataclass(frozen=True)
class Drawing:
    """Clusters of episodes, and how much each counts in the sample and in every draw."""

    clusters: NDArray[np.int64]
    """Code of the cluster of each episode, `(num_episodes,)`, from 0."""
    strata: NDArray[np.int64]
    """Code of the stratum of each cluster, `(num_clusters,)`."""
    weights: FloatArray
    """`(1 + num_resamples, num_clusters)`; row 0 is ones."""
    confidence: float
    """Of the intervals."""

    @classmethod
    def of(
        cls,
        table: ScoredTable,
        level: ClusterLevel,
        *,
        num_resamples: int,
        confidence: float,
        seed: int,
    ) -> Drawing:
        """Draws for the episodes of a table, within strata of family and emotion.

        Raises:
            ValueError: There are too few performers to say anything about others.
        """
        codes = table.performances if level == "performance" else table.performers
        names, clusters = np.unique(codes, return_inverse=True)
        if level == "performer":
            check_clusters(len(names), level)
        strata = sampling_strata(clusters, table.factors["family"], table.factors["emotion"])
        draws = resampling_weights(
            len(names), num_resamples=num_resamples, seed=seed, strata=strata
        )
        weights = np.concatenate([np.ones((1, len(names))), _rounded(draws)])
        return cls(clusters, strata, weights, confidence)

    @property
    def num_clusters(self) -> int:
        """Clusters of the sample."""
        return len(self.strata)

    def num_clusters_of(self, where: NDArray[np.bool_]) -> int:
        """Clusters with an episode of `where`, `(num_episodes,)`."""
        return len(np.unique(self.clusters[where]))

    def support(self, where: NDArray[np.bool_]) -> Support:
        """What stands behind a number over the episodes of `where`, `(num_episodes,)`."""
        clusters = self.clusters[where]
        return Support(degrees_of_freedom(clusters, self.strata), effective_clusters(clusters))

    def counts(
        self, groups: NDArray[np.int64], episodes: NDArray[np.int64], num_groups: int
    ) -> FloatArray:
        """How many entries each group has, `(1 + num_resamples, num_groups)`.

        Args:
            groups: Code of the group of each entry.
            episodes: Place of the episode of each entry.
            num_groups: Groups.
        """
        used, local = np.unique(self.clusters[episodes], return_inverse=True)
        places = groups * len(used) + local
        table = np.bincount(places, minlength=num_groups * len(used)).reshape(num_groups, len(used))
        return self.weights[:, used] @ table.T.astype(np.float64)

    def sums(self, values: NDArray[np.generic]) -> FloatArray:
        """Sums over episodes of values `(..., num_episodes)`, `(1 + num_resamples, ...)`."""
        by_cluster = cluster_sums(values, self.clusters, self.num_clusters)
        sums = resampled(_rounded(by_cluster), self.weights)
        sums[0] = by_cluster.sum(axis=-1)
        return sums

    def bounds(
        self,
        rows: FloatArray,
        support: Support,
        *,
        within: tuple[float, float] = (-math.inf, math.inf),
    ) -> Bounds:
        """Of differences and lengths, from rows `(1 + num_resamples, ...)`.

        Args:
            rows: The sample and its draws.
            support: What stands behind them.
            within: Least and greatest value there can be; no bound lies beyond.
        """
        known = ~np.isnan(rows[0])
        low, high = interval(
            rows[0][known],
            rows[1:, known],
            confidence=self.confidence,
            degrees=support.degrees,
        )
        return _spread_out(rows[0], known, np.clip(low, *within), np.clip(high, *within))

    def score_bounds(self, rows: FloatArray, support: Support) -> Bounds:
        """Of Macro-F1, which is in [0, 1] but no share of episodes."""
        return self.bounds(rows, support, within=(0.0, 1.0))

    def share_bounds(self, rows: FloatArray, support: Support) -> Bounds:
        """Of shares in [0, 1], from rows `(1 + num_resamples, ...)`."""
        known = ~np.isnan(rows[0])
        low, high = share_interval(
            rows[0][known],
            rows[1:, known],
            size=support.size,
            confidence=self.confidence,
            degrees=support.degrees,
        )
        return _spread_out(rows[0], known, low, high)

    def ratio_bounds(self, top: FloatArray, bottom: FloatArray, support: Support) -> Bounds:
        """Of top / bottom: NaN unless the bottom is positive, infinite where it may be zero."""
        value = np.full(top.shape[1:], math.nan)
        known = (bottom[0] > 0) & ~np.isnan(top[0])
        value[known] = top[0][known] / bottom[0][known]
        low, high = ratio_interval(
            top[0][known],
            bottom[0][known],
            top[1:, known],
            bottom[1:, known],
            confidence=self.confidence,
            degrees=support.degrees,
        )
        return _spread_out(value, known, low, high)


def _spread_out(
    value: FloatArray, known: NDArray[np.bool_], low: FloatArray, high: FloatArray
) -> Bounds:
    """Bounds of the known values, put in their places among all."""
    bounds = np.full((2, *value.shape), math.nan)
    bounds[0, known], bounds[1, known] = low, high
    return Bounds(value, bounds[0], bounds[1])


def _rounded(values: FloatArray) -> FloatArray:
    rounded: FloatArray = np.rint(values / _STEP) * _STEP
    return rounded
