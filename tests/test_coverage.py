"""Intervals and tests keep their promise on the paper's clusters; those over episodes do not."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from affectsim_data.evaluation.coverage import measure_coverage, measure_errors
from affectsim_data.evaluation.simulating import PAPER_SKILLS, Skill, paper_plan

REPEATS = 1500
"""Standard error of a coverage of 95 %, or an error of 5 %: 0.6 points."""


def skill(group: str) -> Skill:
    """A recognizer of the paper's quality, a fifth of whose noise is the performance's own."""
    return dataclasses.replace(PAPER_SKILLS[group], correlation=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("group", ["open", "closed"])
def test_cluster_intervals_hold_the_truth_19_times_of_20(group: str) -> None:
    coverage = measure_coverage(paper_plan(), skill(group), num_repeats=REPEATS, seed=1)
    for metric in ("macro_f1", "gain", "gap", "ogr", "recall"):
        assert 0.93 <= coverage[metric] <= 0.97, f"{metric}: {coverage}"


@pytest.mark.slow
def test_tests_of_whole_performances_err_once_in_20_and_mcnemar_more() -> None:
    rates = []
    for group in ("open", "closed"):
        signal = {**skill(group).signal, "a_obs": skill(group).signal["p_init"]}
        nothing = dataclasses.replace(skill(group), signal=signal)
        errors = measure_errors(paper_plan(), nothing, num_repeats=REPEATS, seed=2)
        rates.append([errors.permutation, errors.interval, errors.mcnemar])
    permutation, gain, mcnemar = np.mean(rates, axis=0)
    assert 0.04 <= permutation <= 0.06, rates
    assert 0.04 <= gain <= 0.06, rates
    assert mcnemar > 0.1, rates


@pytest.mark.slow
def test_intervals_over_episodes_hold_it_less_often_than_they_say() -> None:
    coverage = measure_coverage(
        paper_plan(), skill("open"), unit="episode", num_repeats=300, num_resamples=200, seed=3
    )
    for metric in ("macro_f1", "gain", "gap", "ogr"):
        assert 0.65 <= coverage[metric] <= 0.91, f"{metric}: {coverage}"
