"""What a study can show: the smallest difference its clusters would make visible."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from affectsim_data.evaluation.bootstrap import cluster_sums
from affectsim_data.poses import FloatArray

__all__ = ["mean_standard_error", "minimum_detectable_effect"]


def mean_standard_error(differences: ArrayLike, clusters: NDArray[np.int64]) -> FloatArray:
    """Standard error of the mean of `differences` `(..., num_episodes)` by clusters, `(...)`.

    With K clusters, d_c the sum over cluster c and m_c its episodes,
    `sqrt(K / (K - 1) * sum((d_c - m_c * mean)^2)) / num_episodes`; NaN for fewer than two clusters.

    Examples:
        >>> clusters = np.array([0, 0, 1, 1])
        >>> float(mean_standard_error([1.0, 1.0, 0.0, 0.0], clusters))  # two clusters: 1 and 0
        0.5
        >>> float(mean_standard_error([1.0, 0.0, 1.0, 0.0], clusters))  # two alike
        0.0
    """
    array = np.asarray(differences, np.float64)
    sizes = np.bincount(clusters)
    residuals = cluster_sums(array, clusters) - sizes * array.mean(axis=-1, keepdims=True)
    used = np.count_nonzero(sizes)
    inflation = used / (used - 1) if used > 1 else np.nan
    error: FloatArray = np.sqrt(inflation * (residuals**2).sum(axis=-1)) / array.shape[-1]
    return error


def minimum_detectable_effect(
    standard_error: ArrayLike, *, degrees: float, power: float = 0.8, alpha: float = 0.05
) -> FloatArray:
    """Smallest true difference that a study would show with this power, `(...)`.

    The standard error times the sum of two quantiles of Student's t: that of the two-sided test,
    and that of the power. With many clusters, alpha 5 % and power 80 % this is 2.80.

    Args:
        standard_error: Of the difference: `mean_standard_error` for accuracy, the standard
            deviation of bootstrap draws for anything else.
        degrees: Degrees of freedom: about the number of effective clusters less one.
        power: Chance that the study shows the difference.
        alpha: Level of the test.

    Examples:
        >>> round(float(minimum_detectable_effect(1.0, degrees=1e6)), 2)
        2.8
    """
    for name, share in (("power", power), ("alpha", alpha)):
        if not 0 < share < 1:
            raise ValueError(f"{name} must be between 0 and 1, got {share}")
    factor = stats.t.ppf(1 - alpha / 2, degrees) + stats.t.ppf(power, degrees)
    effect: FloatArray = np.asarray(standard_error, np.float64) * factor
    return effect
