"""Paired tests against brute force, and adjustments worked by hand."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from affectsim_data.evaluation.significance import cluster_permutation, holm, mcnemar_exact


@given(st.integers(0, 60), st.integers(0, 60))
def test_mcnemar_is_the_two_sided_binomial_test(first: int, second: int) -> None:
    total, less = first + second, min(first, second)
    tail = sum(math.comb(total, k) for k in range(less + 1)) / 2**total
    p = float(mcnemar_exact(first, second))
    assert p == pytest.approx(min(1.0, 2 * tail))
    if total:
        assert p == pytest.approx(stats.binomtest(first, total).pvalue)
    assert p == mcnemar_exact(second, first)


def test_mcnemar_takes_arrays_and_thousands_of_pairs() -> None:
    p = mcnemar_exact([[0, 5], [900, 1500]], [[0, 5], [1100, 1500]])
    assert p[0].tolist() == [1.0, 1.0]
    assert p[1, 0] == pytest.approx(stats.binomtest(900, 2000).pvalue)
    assert p[1, 1] == 1.0
    with pytest.raises(ValueError, match="must not be negative"):
        mcnemar_exact(-1, 4)


def test_few_clusters_are_swapped_in_every_way_and_means_break_ties() -> None:
    rng = np.random.default_rng(0)
    clusters = rng.integers(0, 8, 60)
    sizes = np.bincount(clusters)
    differences = rng.integers(-1, 2, (3, 60))
    sums = np.array([[row[clusters == code].sum() for code in range(8)] for row in differences])

    def rank(signs: tuple[int, ...], row: NDArray[np.int64]) -> tuple[int, float]:
        total, means = int(np.dot(signs, row)), float(np.dot(signs, row / sizes))
        return abs(total), round(means * np.sign(total) if total else abs(means), 9)

    ties = 0
    for row, p in zip(sums, cluster_permutation(differences, clusters), strict=True):
        ranks = [rank(signs, row) for signs in itertools.product((1, -1), repeat=8)]
        observed = rank((1,) * 8, row)
        assert p == np.mean([one >= observed for one in ranks])
        ties += sum(one[0] == observed[0] and one[1] < observed[1] for one in ranks)
    assert ties > 0


def test_random_swaps_come_close_to_all_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(1)
    clusters = np.arange(120) % 12
    differences = (rng.random(120) < 0.35).astype(float) - (rng.random(120) < 0.2)
    exact = float(cluster_permutation(differences, clusters))
    monkeypatch.setattr("affectsim_data.evaluation.significance._MAX_EXACT", 0)
    near = float(cluster_permutation(differences, clusters, num_permutations=20_000, seed=5))
    assert 0.01 < exact < 0.9
    assert near == pytest.approx(exact, abs=4 * math.sqrt(exact * (1 - exact) / 20_000))


def test_no_difference_gives_1_and_p_never_gets_below_what_the_swaps_allow() -> None:
    clusters = np.repeat(np.arange(30), 4)
    rows = np.stack([np.zeros(120), np.ones(120)])
    p = cluster_permutation(rows, clusters, num_permutations=499)
    assert p.tolist() == [1.0, pytest.approx(1 / 500)]
    six = np.repeat(np.arange(6), 4)
    assert float(cluster_permutation(np.ones(24), six)) == 2 / 64


def test_one_performance_repeated_is_one_piece_of_evidence() -> None:
    differences = np.r_[np.ones(40), np.zeros(60)]  # 40 pairs better, all of one performance
    clusters = np.r_[np.zeros(40, np.int64), 1 + np.arange(60) % 20]
    assert float(cluster_permutation(differences, clusters)) == 1.0
    assert float(mcnemar_exact(0, 40)) < 1e-11


def test_the_side_and_the_order_of_episodes_do_not_matter() -> None:
    rng = np.random.default_rng(2)
    clusters, differences = rng.integers(0, 40, 300), rng.integers(-1, 2, 300) + 0.125
    order = rng.permutation(300)
    p = cluster_permutation(differences, clusters)
    assert cluster_permutation(-differences, clusters) == p
    assert cluster_permutation(differences[order], clusters[order]) == p
    assert cluster_permutation(1e6 * differences, clusters) == p


def test_holm_by_hand() -> None:
    # sorted 0.005 0.01 0.03 0.04: times 4, 3, 2, 1 = 0.02 0.03 0.06 0.04 -> 0.06
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.5, 0.6]).tolist() == [1.0, 1.0]
    assert holm([0.02, 0.02]) == pytest.approx([0.04, 0.04])
    assert holm([]).shape == (0,)


def test_holm_leaves_out_what_was_not_tested() -> None:
    adjusted = holm([0.03, math.nan, 0.01])
    assert adjusted[[0, 2]] == pytest.approx([0.03, 0.02])
    assert math.isnan(adjusted[1])


@given(st.lists(st.floats(0, 1), min_size=1, max_size=30))
def test_holm_is_between_the_p_and_bonferronis_and_keeps_their_order(p: list[float]) -> None:
    adjusted, values = holm(p), np.array(p)
    assert (adjusted >= values).all()
    assert (adjusted <= np.minimum(1, len(p) * values)).all()
    assert (np.diff(adjusted[np.argsort(values, kind="stable")]) >= 0).all()
