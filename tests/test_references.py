"""Scores of answers that do not look: exact expectations against cases by hand and simulation."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from affectsim_data.evaluation import macro_f1
from affectsim_data.evaluation.confusion import macro_f1_scores
from affectsim_data.evaluation.published import PUBLISHED
from affectsim_data.evaluation.references import (
    chance_macro_f1,
    expected_macro_f1,
    reference_rows,
)
from affectsim_data.motions import EMOTIONS


def balanced(count: int) -> NDArray[np.int8]:
    return np.resize(np.arange(5, dtype=np.int8), count)


def test_constant_answers_score_what_macro_f1_says() -> None:
    truth = np.array([0, 0, 0, 1, 2, 2, 4], np.int8)
    rows = {row.name: row.macro_f1 for row in reference_rows(truth)}
    names = [EMOTIONS[code] for code in truth]
    for emotion in EMOTIONS:
        expected = macro_f1(names, [emotion] * len(names))
        assert rows[f"constant:{emotion}"] == pytest.approx(expected)
    assert list(rows)[5:] == ["uniform", "prior"]


def test_the_expectation_is_that_of_all_answers_there_are() -> None:
    truth, shares = [0, 0, 2, 4], np.array([0.5, 0.0, 0.25, 0.0, 0.25])
    names = [EMOTIONS[code] for code in truth]
    expected = sum(
        np.prod(shares[list(codes)]) * macro_f1(names, [EMOTIONS[code] for code in codes])
        for codes in itertools.product(range(5), repeat=len(truth))
    )
    counts = np.bincount(truth, minlength=5)
    assert expected_macro_f1(counts, shares) == pytest.approx(expected, abs=1e-12)


def test_the_expectation_is_the_mean_of_simulated_guesses() -> None:
    counts, rng = np.array([700, 300, 50, 20, 10]), np.random.default_rng(0)
    shares = counts / counts.sum()
    tables = [rng.multinomial(count, [*shares, 0.0], 4000) for count in counts]
    scores = macro_f1_scores(np.stack(tables, axis=1).astype(np.float64))
    error = scores.std() / np.sqrt(len(scores))
    assert expected_macro_f1(counts, shares) == pytest.approx(scores.mean(), abs=4 * error)


def test_on_a_balanced_table() -> None:
    rows = {row.name: row.macro_f1 for row in reference_rows(balanced(4000))}
    assert rows["constant:sad"] == pytest.approx(1 / 15)
    assert rows["uniform"] == pytest.approx(0.2, abs=1e-4)
    assert rows["prior"] == pytest.approx(rows["uniform"])


def test_twenty_of_the_papers_models_start_below_chance() -> None:
    chance = 100 * chance_macro_f1(balanced(3941))
    assert sum(row.macro_f1["p_init"] < chance for row in PUBLISHED) == 20
