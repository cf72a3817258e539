"""Tests of paired conditions: the same episodes, answered from two clips.

A pair whose two clips are the same by construction is a tie whatever the recognizer can do. It is
no evidence either way, and callers leave it out.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from affectsim_data.evaluation.bootstrap import cluster_sums
from affectsim_data.poses import FloatArray

__all__ = ["cluster_permutation", "holm", "mcnemar_exact"]

_MAX_EXACT = 13
"""Clusters up to which all swaps are tried: 4,096 of them."""
_ROUNDING = 1e-9
"""Sums of differences closer than this share of their size are ties."""


def mcnemar_exact(only_first: ArrayLike, only_second: ArrayLike) -> FloatArray:
    """Two-sided p of the exact McNemar test, from counts of pairs that only one got right.

    Twice the smaller tail of the binomial distribution with p = 1/2, at most 1; and 1 where no
    pair disagrees. It takes pairs for independent, which those of one performance are not.

    Examples:
        >>> round(float(mcnemar_exact(1, 5)), 5)  # 2 * (1 + 6) / 2**6
        0.21875
    """
    first, second = np.asarray(only_first, np.int64), np.asarray(only_second, np.int64)
    if (np.minimum(first, second) < 0).any():
        raise ValueError(f"counts of pairs must not be negative, got {first} and {second}")
    tails = special.bdtr(np.minimum(first, second).astype(np.float64), first + second, 0.5)
    p: FloatArray = np.minimum(1.0, 2.0 * tails)
    return p


def cluster_permutation(
    differences: ArrayLike,
    clusters: NDArray[np.int64],
    *,
    num_permutations: int = 2000,
    seed: int = 0,
) -> FloatArray:
    """Two-sided p for no difference on average, swapping the conditions of whole clusters.

    If conditions do not matter, the summed difference of each cluster could as well have the other
    sign. p is the share of sign patterns with a total at least as large as the one there is. Among
    equal totals the one with the larger mean difference per cluster counts as larger: were they
    ties, some 4 % instead of 5 % of studies without a difference would have p below 0.05.

    Args:
        differences: Second condition less first, per episode, `(..., num_episodes)`: for accuracy
            1, 0 or -1.
        clusters: Code of the cluster of each episode, `(num_episodes,)`, from 0.
        num_permutations: Random patterns if there are more than 13 clusters; p is then at least
            1 / (num_permutations + 1). Of fewer clusters all patterns are tried.
        seed: Of random patterns; the same for all rows of differences.

    Returns:
        p, `(...)`; 1 where all differences are 0.
    """
    sizes = np.bincount(clusters)
    num_clusters = len(sizes)
    sums = cluster_sums(differences, clusters) * _tie_breaking(sizes)
    flat = sums.reshape(-1, num_clusters)
    observed = np.abs(flat.sum(axis=1))
    exact = num_clusters <= _MAX_EXACT
    signs = _all_signs(num_clusters) if exact else _some_signs(num_clusters, num_permutations, seed)
    tolerance = _ROUNDING * np.abs(flat).sum(axis=1)
    reached = (np.abs(signs @ flat.T) >= observed - tolerance).sum(axis=0)
    p = reached / len(signs) if exact else (reached + 1) / (len(signs) + 1)
    return np.asarray(p, np.float64).reshape(sums.shape[:-1])


def holm(p_values: ArrayLike) -> FloatArray:
    """p adjusted for their number after Holm, `(n,)`; NaN stays NaN and does not count.

    The smallest of m is multiplied by m, the next by m - 1, and so on, none above 1 or below one
    before it. Rejecting those below 5 % is wrong in any of them at most 5 % of the time.

    Examples:
        >>> holm([0.01, 0.04, 0.03]).round(2).tolist()
        [0.03, 0.06, 0.06]
    """
    p = np.asarray(p_values, np.float64)
    adjusted = np.full(p.shape, np.nan)
    known = np.flatnonzero(~np.isnan(p))
    order = known[np.argsort(p[known], kind="stable")]
    factors = np.arange(len(order), 0, -1)
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(p[order] * factors))
    return adjusted


def _tie_breaking(sizes: NDArray[np.int64]) -> FloatArray:
    """Factors just above 1 that add means of clusters to totals, too little to pass the next."""
    factors: FloatArray = 1.0 + 0.5 / (len(sizes) * np.maximum(sizes, 1))
    return factors


def _all_signs(num_clusters: int) -> FloatArray:
    """Every pattern of signs once, up to reversal, `(2 ** (num_clusters - 1), num_clusters)`."""
    bits = (np.arange(2 ** (num_clusters - 1))[:, None] >> np.arange(num_clusters)) & 1
    signs: FloatArray = np.where(bits == 1, -1.0, 1.0)
    return signs


def _some_signs(num_clusters: int, count: int, seed: int) -> FloatArray:
    """Random patterns of signs, `(count, num_clusters)`."""
    bits = np.random.default_rng(seed).integers(0, 2, (count, num_clusters))
    signs: FloatArray = np.where(bits == 1, -1.0, 1.0)
    return signs
