"""Cluster bootstrap: laws of its draws, standard errors one can compute, intervals by hand."""

from __future__ import annotations

import hashlib
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

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
from affectsim_data.evaluation.power import mean_standard_error
from affectsim_data.poses import FloatArray

RESAMPLES = 4000


def mean_draws(
    values: FloatArray, clusters: NDArray[np.int64], *, num_resamples: int = RESAMPLES
) -> FloatArray:
    """Means in every draw, `(num_resamples,)`."""
    count = int(clusters.max()) + 1
    weights = resampling_weights(count, num_resamples=num_resamples, seed=0)
    sums = cluster_sums(np.stack([values, np.ones(len(values))]), clusters)
    total, number = resampled(sums, weights).T
    means: FloatArray = total / number
    return means


def clustered(seed: int = 0, *, largest: int = 12) -> tuple[FloatArray, NDArray[np.int64]]:
    """Values that are alike within clusters of unequal size."""
    rng = np.random.default_rng(seed)
    clusters = np.repeat(np.arange(80), rng.integers(1, largest, 80))
    return rng.normal(size=80)[clusters] + rng.normal(size=len(clusters)), clusters


# draws


def test_draws_keep_the_number_of_clusters_and_have_the_variance_of_sampling() -> None:
    strata = np.repeat([0, 1, 2], [5, 20, 2])
    weights = resampling_weights(27, num_resamples=20_000, seed=3, strata=strata)
    for stratum in range(3):
        mine = weights[:, strata == stratum]
        count = mine.shape[1]
        assert np.allclose(mine.sum(axis=1), count)
        # of n - 1 draws among n, rescaled: n / (n - 1) * (1 - 1 / n) = 1
        assert mine.var(axis=0) == pytest.approx(np.ones(count), abs=0.06)


def test_draws_are_equal_for_a_seed_wherever_they_are_made() -> None:
    weights = resampling_weights(
        7, num_resamples=50, seed=11, strata=np.array([0, 0, 0, 1, 1, 1, 1])
    )
    whole = np.rint(weights * 6).astype(np.int8)
    assert np.array_equal(whole / 6, weights)
    assert hashlib.sha256(whole.tobytes()).hexdigest()[:16] == "c402f0c251b7ca05"


def test_a_cluster_alone_in_its_stratum_is_in_every_draw() -> None:
    weights = resampling_weights(3, num_resamples=40, seed=0, strata=np.array([0, 1, 1]))
    assert (weights[:, 0] == 1).all()
    assert (weights[:, 1:] != 1).all()


def test_the_spread_of_a_mean_is_its_cluster_robust_standard_error() -> None:
    values, clusters = clustered()
    spread = mean_draws(values, clusters).std()
    expected = float(mean_standard_error(values, clusters))
    assert spread == pytest.approx(expected, rel=4 / math.sqrt(2 * RESAMPLES))


def test_one_episode_per_cluster_is_the_plain_bootstrap() -> None:
    rng = np.random.default_rng(0)
    values = rng.exponential(size=200)
    draws = mean_draws(values, np.arange(200))
    plain = rng.choice(values, (RESAMPLES, 200)).mean(axis=1)
    assert draws.std() == pytest.approx(plain.std(), rel=0.05)
    assert stats.ks_2samp(draws, plain).pvalue > 0.01


def test_more_episodes_of_the_same_performances_do_not_narrow_the_interval() -> None:
    values, clusters = clustered()
    many, again = np.tile(values, 9), np.tile(clusters, 9)
    assert mean_draws(many, again) == pytest.approx(mean_draws(values, clusters))
    naive = mean_draws(values, np.arange(len(values))).std()
    naive_many = mean_draws(many, np.arange(len(many)), num_resamples=1000).std()
    assert naive_many == pytest.approx(naive / 3, rel=0.1)


@given(st.integers(0, 1000))
@settings(max_examples=10, deadline=None)
def test_the_order_of_episodes_does_not_matter(seed: int) -> None:
    values, clusters = clustered()
    order = np.random.default_rng(seed).permutation(len(values))
    shuffled = mean_draws(values[order], clusters[order], num_resamples=50)
    assert shuffled == pytest.approx(mean_draws(values, clusters, num_resamples=50))


def test_sums_are_the_same_in_one_piece_and_in_many(monkeypatch: pytest.MonkeyPatch) -> None:
    sums = np.random.default_rng(0).integers(0, 9, (3, 5, 20)).astype(np.float64)
    weights = resampling_weights(20, num_resamples=30, seed=0)
    whole = resampled(sums, weights)
    monkeypatch.setattr("affectsim_data.evaluation.bootstrap._CHUNK_NUMBERS", 40)
    assert whole.shape == (30, 3, 5)
    assert resampled(sums, weights) == pytest.approx(whole)
    assert whole[:, 1, 2] == pytest.approx(weights @ sums[1, 2])


# strata and degrees of freedom


def test_strata_are_families_and_emotions_and_small_ones_join_those_of_their_emotion() -> None:
    families = np.repeat(["walk", "walk", "scenario", "scenario", "dyad"], [4, 4, 5, 4, 1])
    emotions = np.repeat(["sad", "happy", "sad", "happy", "sad"], [4, 4, 5, 4, 1])
    sizes = np.repeat([40, 40, 10, 10, 30], [4, 4, 5, 4, 1])
    clusters = np.repeat(np.arange(18), sizes)
    strata = sampling_strata(clusters, families[clusters], emotions[clusters])
    groups = [set(np.flatnonzero(strata == code).tolist()) for code in range(4)]
    assert len(np.unique(strata)) == 4
    for members in ({0, 1, 2, 3, 17}, {4, 5, 6, 7}, {8, 9, 10, 11, 12}, {13, 14, 15, 16}):
        assert members in groups


def test_clusters_with_all_emotions_are_one_stratum() -> None:
    clusters = np.repeat(np.arange(8), 5)
    emotions = np.tile(["angry", "fearful", "happy", "neutral", "sad"], 8)
    assert np.ptp(sampling_strata(clusters, emotions)) == 0


def test_where_all_strata_are_small_there_is_one() -> None:
    names = np.array(["a", "b", "c"])
    assert sampling_strata(np.arange(3), names).tolist() == [0, 0, 0]


def test_degrees_of_freedom_count_equal_clusters_and_leave_out_strata() -> None:
    clusters = np.repeat(np.arange(10), 7)
    assert effective_clusters(clusters) == pytest.approx(10)
    assert degrees_of_freedom(clusters, np.repeat([0, 1], 5)) == pytest.approx(8)
    assert degrees_of_freedom(clusters, np.arange(10)) == 1
    assert degrees_of_freedom(clusters[:35], np.zeros(10, np.int64)) == 0  # five of them


def test_five_performers_are_refused_with_the_reason_and_a_way_out() -> None:
    check_clusters(6, "performer")
    with pytest.raises(
        ValueError, match=r"^5 performers cannot .* at least 6 .* below 0\.062; take perf"
    ):
        check_clusters(5, "performer")
    with pytest.raises(ValueError, match=r"^1 performance cannot .* below 1$"):
        check_clusters(1, "performance")


# intervals


def test_an_interval_is_standard_errors_by_students_t() -> None:
    draws = np.array([[0.1], [0.3]])  # deviation 0.1
    low, high = interval([0.2], draws, degrees=10)
    assert low[0] == pytest.approx(0.2 - 2.2281389 * 0.1)
    assert high[0] == pytest.approx(0.2 + 2.2281389 * 0.1)
    narrow = interval([0.2], draws, confidence=0.5, degrees=10)
    assert low[0] < narrow[0][0] < narrow[1][0] < high[0]


def test_nothing_is_bounded_without_degrees_of_freedom_or_draws_that_are_defined() -> None:
    draws = np.random.default_rng(0).uniform(size=(100, 3))
    draws[:4, 1] = draws[:6, 2] = np.nan
    for bounds in (interval([0.5] * 3, draws), share_interval([0.5] * 3, draws, size=9)):
        for bound in bounds:
            assert np.isnan(bound).tolist() == [False, False, True]
    assert np.isnan(interval([0.5] * 3, draws, degrees=0)).all()
    assert np.isnan(interval(np.nan, draws[:, 0])).all()


def test_a_share_has_wilsons_interval_with_as_many_episodes_as_its_error_tells() -> None:
    share, error = 0.2, math.sqrt(0.2 * 0.8 / 50)  # as of 50 independent episodes
    draws = np.array([share - error, share + error])
    low, high = share_interval(share, draws, size=7)
    wilson = stats.binomtest(10, 50).proportion_ci(0.95, method="wilson")
    assert (float(low), float(high)) == pytest.approx((wilson.low, wilson.high))


def test_a_share_of_nothing_is_not_certain() -> None:
    low, high = share_interval([0.0, 1.0], np.array([[0.0, 1.0]] * 9), size=20)
    none = stats.binomtest(0, 20).proportion_ci(0.95, method="wilson")
    assert low.tolist() == pytest.approx([0.0, 1 - none.high])
    assert high.tolist() == pytest.approx([none.high, 1.0])


@given(st.floats(0, 1), st.floats(1e-6, 0.5), st.floats(1, 100))
def test_a_share_stays_within_0_and_1_and_its_interval(
    share: float, error: float, degrees: float
) -> None:
    draws = np.array([share - error, share + error])
    low, high = share_interval(share, draws, size=10, degrees=degrees)
    assert 0 <= low <= share + 1e-12
    assert share - 1e-12 <= high <= 1


def gains_and_gaps(gap: float, *, seed: int = 0) -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    common = rng.normal(size=RESAMPLES)
    gains = 0.02 + 0.004 * (common + rng.normal(size=RESAMPLES))
    return gains, gap + 0.004 * (common + rng.normal(size=RESAMPLES))


def test_a_ratio_is_bounded_where_the_interval_of_the_difference_touches_zero() -> None:
    gains, gaps = gains_and_gaps(0.06)
    low, high = ratio_interval(0.02, 0.06, gains, gaps, degrees=30)
    assert 0.1 < low < 0.02 / 0.06 < high < 0.6
    for ratio, side in ((float(low), 0), (float(high), 1)):
        bounds = interval(0.02 - ratio * 0.06, gains - ratio * gaps, degrees=30)
        assert float(bounds[side]) == pytest.approx(0, abs=1e-12)


def test_a_ratio_is_unbounded_where_the_gap_may_be_zero_and_undefined_where_it_is_not_there() -> (
    None
):
    gains, gaps = gains_and_gaps(0.01)  # its interval is about 0.01 +- 0.011
    low, high = ratio_interval(0.02, 0.01, gains, gaps)
    assert (float(low), float(high)) == (-math.inf, math.inf)
    assert np.isnan(ratio_interval(0.02, 0.0, gains, gaps - 0.01)).all()
    assert np.isnan(ratio_interval(0.02, -0.01, gains, gaps - 0.02)).all()


def test_a_ratio_without_spread_is_a_point() -> None:
    low, high = ratio_interval(0.02, 0.08, np.full(9, 0.02), np.full(9, 0.08))
    assert (float(low), float(high)) == pytest.approx((0.25, 0.25))
