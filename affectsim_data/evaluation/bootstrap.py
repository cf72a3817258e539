"""Cluster bootstrap: intervals from whole performances drawn again, not from single episodes.

Episodes that replay one performance are answered alike, so they are kept together. A draw is a
weight for every cluster, and whatever is a function of sums over episodes is one of weighted sums
over clusters: one matrix product for all models, conditions and draws. Intervals are those that
held in simulation on the paper's clusters; docs/statistics.md has the measurement.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from affectsim_data.poses import FloatArray

__all__ = [
    "INTERVAL_NAME",
    "MIN_CLUSTERS",
    "check_clusters",
    "cluster_sums",
    "degrees_of_freedom",
    "effective_clusters",
    "interval",
    "ratio_interval",
    "resampled",
    "resampling_weights",
    "sampling_strata",
    "share_interval",
]

MIN_CLUSTERS = 6
"""Fewer give no interval: swapping the conditions of 5 clusters cannot come below p = 2 / 32."""
INTERVAL_NAME = "t interval, standard error by cluster bootstrap within strata"
"""The kind of interval, for reports."""
_MIN_STRATUM = 4
"""Clusters a stratum needs to be drawn from by itself."""
_MAX_UNDEFINED = 0.05
"""Share of undefined draws an interval tolerates."""
_CHUNK_NUMBERS = 1 << 22
"""Cluster sums that are copied at a time."""


def check_clusters(num_clusters: int, level: Literal["performance", "performer"]) -> None:
    """Raises an error where there are too few clusters for an interval.

    Raises:
        ValueError: If there are fewer than `MIN_CLUSTERS`.
    """
    if num_clusters < MIN_CLUSTERS:
        smallest = min(1.0, 2.0 ** (1 - num_clusters))
        way_out = "; take performances as clusters" if level == "performer" else ""
        raise ValueError(
            f"{num_clusters} {level}{'' if num_clusters == 1 else 's'} cannot be the clusters of "
            f"intervals and tests, at least {MIN_CLUSTERS} are needed: so few say next to nothing "
            f"about others, and however clear the difference, no p could be below {smallest:.2g}"
            f"{way_out}"
        )


def resampling_weights(
    num_clusters: int, *, num_resamples: int, seed: int, strata: NDArray[np.int64] | None = None
) -> FloatArray:
    """How much every cluster counts in every draw, `(num_resamples, num_clusters)`.

    Of the K clusters of a stratum K - 1 are drawn with replacement and count K / (K - 1) each:
    then the spread of draws is that of sampling, not (K - 1) / K of its variance (Rao and Wu 1988).
    Made from random integers only, so equal for a seed on any machine.

    Args:
        num_clusters: Clusters.
        num_resamples: Draws.
        seed: Of the draws.
        strata: Code of the stratum of each cluster, `(num_clusters,)`; one stratum if not given.
            A cluster alone in its stratum counts 1 in every draw.
    """
    rng = np.random.default_rng(seed)
    codes = np.zeros(num_clusters, np.int64) if strata is None else strata
    weights = np.ones((num_resamples, num_clusters))
    for stratum in np.unique(codes):
        members = np.flatnonzero(codes == stratum)
        count = len(members)
        if count < 2:
            continue
        picks = rng.integers(0, count, (num_resamples, count - 1))
        places = picks + count * np.arange(num_resamples)[:, None]
        drawn = np.bincount(places.ravel(), minlength=num_resamples * count)
        weights[:, members] = drawn.reshape(num_resamples, count) * (count / (count - 1))
    return weights


def sampling_strata(
    clusters: NDArray[np.int64], *factors: NDArray[np.str_], min_clusters: int = _MIN_STRATUM
) -> NDArray[np.int64]:
    """Stratum of each cluster, `(num_clusters,)`: what a study fixes, like families and emotions.

    A split has so many performances of each family and emotion by design. Drawing them from all
    at once would add a spread of these numbers that no new study would have.

    Args:
        clusters: Code of the cluster of each episode, `(num_episodes,)`, from 0.
        factors: Level of each episode, `(num_episodes,)` each, the most important factor last. A
            cluster whose episodes differ in one has a level of its own there.
        min_clusters: A stratum with fewer joins one that shares as many of the last factors as any
            does, and of these the one whose clusters are most nearly as large.
    """
    sizes = np.bincount(clusters)
    levels = [np.zeros(len(sizes), np.int64)]
    levels += [_common_level(clusters, factor) for factor in reversed(factors)]
    keys, strata, counts = np.unique(
        np.stack(levels, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    mean_sizes = np.bincount(strata, sizes) / counts
    shared = np.cumprod(keys[:, None] == keys, axis=2).sum(axis=2)
    unlike = np.abs(np.log(np.maximum(mean_sizes, 1)[:, None] / np.maximum(mean_sizes, 1)))
    large = counts >= min_clusters
    if not large.any():
        return np.zeros(len(sizes), np.int64)
    joined = np.arange(len(keys))
    for small in np.flatnonzero(~large):
        order = np.lexsort((unlike[small], -shared[small], ~large))
        joined[small] = order[0]
    return np.unique(joined[strata], return_inverse=True)[1]


def _common_level(clusters: NDArray[np.int64], factor: NDArray[np.str_]) -> NDArray[np.int64]:
    """Code of the level all episodes of a cluster have, `(num_clusters,)`; -1 if they differ."""
    codes = np.unique(factor, return_inverse=True)[1]
    lowest = np.full(int(clusters.max()) + 1, len(factor))
    highest = np.full(len(lowest), -1)
    np.minimum.at(lowest, clusters, codes)
    np.maximum.at(highest, clusters, codes)
    return np.where(lowest == highest, lowest, -1)


def cluster_sums(
    values: ArrayLike, clusters: NDArray[np.int64], num_clusters: int | None = None
) -> FloatArray:
    """Sums of `values` `(..., num_episodes)` over the episodes of each cluster, `(..., K)`.

    Args:
        values: Numbers or truth values.
        clusters: Code of the cluster of each episode, `(num_episodes,)`, from 0.
        num_clusters: K; as many as the codes tell if not given.

    Examples:
        >>> cluster_sums([1, 2, 4], np.array([0, 1, 0])).tolist()
        [5.0, 2.0]
    """
    array = np.asarray(values, np.float64)
    count = int(clusters.max()) + 1 if num_clusters is None else num_clusters
    flat = array.reshape(-1, array.shape[-1])
    places = np.arange(len(flat))[:, None] * count + clusters
    sums = np.bincount(places.ravel(), flat.ravel(), minlength=len(flat) * count)
    return np.asarray(sums, np.float64).reshape(*array.shape[:-1], count)


def resampled(sums: FloatArray, weights: FloatArray) -> FloatArray:
    """Sums over all episodes in every draw, `(num_resamples, ...)`, from cluster sums `(..., K)`.

    Beside its result it takes a few tens of megabytes, however many sums there are.
    """
    shape, count = sums.shape[:-1], sums.shape[-1]
    total = math.prod(shape)
    flat = sums.reshape(total, count)
    drawn = np.empty((len(weights), total))
    step = max(1, _CHUNK_NUMBERS // count)
    for start in range(0, total, step):
        part = slice(start, start + step)
        drawn[:, part] = weights @ flat[part].T
    return drawn.reshape(len(weights), *shape)


def effective_clusters(clusters: NDArray[np.int64]) -> float:
    """How many clusters of equal size would tell as much, after Kish: (sum m)^2 / sum m^2.

    Examples:
        >>> effective_clusters(np.array([0, 0, 1, 1]))
        2.0
        >>> round(effective_clusters(np.array([0, 0, 0, 1])), 3)
        1.6
    """
    sizes = np.bincount(clusters).astype(np.float64)
    return float(sizes.sum() ** 2 / (sizes**2).sum()) if sizes.any() else 0.0


def degrees_of_freedom(clusters: NDArray[np.int64], strata: NDArray[np.int64]) -> float:
    """Degrees of freedom of numbers over some episodes; 0 below `MIN_CLUSTERS` clusters.

    Args:
        clusters: Code of the cluster of these episodes, `(num_episodes,)`.
        strata: Code of the stratum of each cluster of the table, `(num_clusters,)`.

    Returns:
        Effective clusters less the strata they are from, at least 1.
    """
    used = np.unique(clusters)
    if len(used) < MIN_CLUSTERS:
        return 0.0
    return max(1.0, effective_clusters(clusters) - len(np.unique(strata[used])))


def interval(
    point: ArrayLike, draws: FloatArray, *, confidence: float = 0.95, degrees: float = math.inf
) -> tuple[FloatArray, FloatArray]:
    """Bounds of a score or a difference: as many standard errors either way as Student's t says.

    Args:
        point: The numbers, `(...)`.
        draws: The same in every draw, `(num_resamples, ...)`.
        confidence: How often the interval shall hold the truth.
        degrees: Degrees of freedom of the standard error; 0 for none.

    Returns:
        Lower and upper bounds, `(...)` each; NaN where the number is NaN, in more than 5 % of the
        draws too, or has no degrees of freedom.
    """
    value = np.asarray(point, np.float64)
    half = _critical(confidence, degrees) * _spread(draws)
    return value - half, value + half


def share_interval(
    point: ArrayLike,
    draws: FloatArray,
    *,
    size: float,
    confidence: float = 0.95,
    degrees: float = math.inf,
) -> tuple[FloatArray, FloatArray]:
    """Bounds of a share in [0, 1]: Wilson's, with as many episodes as its standard error tells.

    A recall of 1 % or a share of 0 has a lopsided interval, which `interval` misses.

    Args:
        point: The shares, `(...)`: a recall, an accuracy, a recovery rate, E-SPL.
        draws: The same in every draw, `(num_resamples, ...)`.
        size: Effective clusters; they stand for the episodes where no draw differs.
        confidence: How often the interval shall hold the truth.
        degrees: Degrees of freedom of the standard error; 0 for none.

    Returns:
        Lower and upper bounds in [0, 1], NaN as in `interval`.
    """
    share = np.asarray(point, np.float64)
    variance = _covariance(draws, draws)
    spread = share * (1 - share)
    varies = (variance > 1e-18) & (spread > 0)
    count = np.divide(spread, variance, out=np.full(variance.shape, float(size)), where=varies)
    square = _critical(confidence, degrees) ** 2 / np.maximum(count, 1.0)
    middle = (share + square / 2) / (1 + square)
    half = np.sqrt(square * spread + square**2 / 4) / (1 + square)
    unknown = np.isnan(variance)
    low = np.where(unknown, np.nan, np.clip(middle - half, 0.0, 1.0))
    return low, np.where(unknown, np.nan, np.clip(middle + half, 0.0, 1.0))


def ratio_interval(
    numerator: ArrayLike,
    denominator: ArrayLike,
    numerator_draws: FloatArray,
    denominator_draws: FloatArray,
    *,
    confidence: float = 0.95,
    degrees: float = math.inf,
) -> tuple[FloatArray, FloatArray]:
    """Bounds of a ratio of differences, like OGR, after Fieller.

    It holds the ratios r for which the interval of numerator - r denominator holds 0. Where the
    interval of the denominator holds 0 the ratio can be anything, and the bounds are infinite.

    Args:
        numerator: Gains, `(...)`.
        denominator: Gaps, `(...)`.
        numerator_draws: The same in every draw, `(num_resamples, ...)`.
        denominator_draws: Likewise, from the same draws.
        confidence: How often the interval shall hold the truth.
        degrees: Degrees of freedom of the standard errors; 0 for none.

    Returns:
        Lower and upper bounds; NaN unless the denominator is positive, or as in `interval`.
    """
    top, bottom = np.asarray(numerator, np.float64), np.asarray(denominator, np.float64)
    square = _critical(confidence, degrees) ** 2
    a = bottom**2 - square * _covariance(denominator_draws, denominator_draws)
    b = top * bottom - square * _covariance(numerator_draws, denominator_draws)
    c = top**2 - square * _covariance(numerator_draws, numerator_draws)
    bounded = a > 0
    root = np.sqrt(np.maximum(b**2 - a * c, 0.0))
    divisor = np.where(bounded, a, 1.0)
    low = np.where(bounded, (b - root) / divisor, -np.inf)
    high = np.where(bounded, (b + root) / divisor, np.inf)
    unknown = ~(bottom > 0) | np.isnan(a + b + c)
    return np.where(unknown, np.nan, low), np.where(unknown, np.nan, high)


def _critical(confidence: float, degrees: float) -> float:
    """Quantile of Student's t; NaN without degrees of freedom."""
    return float(stats.t.ppf((1 + confidence) / 2, degrees)) if degrees > 0 else math.nan


def _spread(draws: FloatArray) -> FloatArray:
    """Standard deviation of draws, `(...)`; NaN where too many are undefined."""
    spread: FloatArray = np.sqrt(_covariance(draws, draws))
    return spread


def _covariance(first: FloatArray, second: FloatArray) -> FloatArray:
    """Covariance of draws, `(...)`, over those in which both are defined; NaN if too few are."""
    unknown = np.isnan(first) | np.isnan(second)
    known = np.maximum((~unknown).sum(axis=0), 1)
    deviations = []
    for draws in (first, second):
        numbers = np.where(unknown, 0.0, draws)
        deviations.append(np.where(unknown, 0.0, numbers - numbers.sum(axis=0) / known))
    product: FloatArray = (deviations[0] * deviations[1]).sum(axis=0) / known
    return np.where(unknown.mean(axis=0) > _MAX_UNDEFINED, np.nan, product)
