"""Standard errors by hand, detectable differences in simulation, and simulated answers."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from affectsim_data.evaluation.bootstrap import effective_clusters
from affectsim_data.evaluation.confusion import confusion_codes, macro_f1_scores
from affectsim_data.evaluation.coverage import measure_coverage
from affectsim_data.evaluation.power import mean_standard_error, minimum_detectable_effect
from affectsim_data.evaluation.significance import cluster_permutation
from affectsim_data.evaluation.simulating import (
    PAPER_SKILLS,
    Plan,
    Skill,
    expected_confusions,
    paper_plan,
    simulated_answers,
    simulated_table,
)


def test_the_standard_error_of_equal_clusters_is_that_of_their_means() -> None:
    rng = np.random.default_rng(0)
    values = rng.normal(size=(2, 20, 5))
    clusters = np.repeat(np.arange(20), 5)
    expected = values.mean(axis=2).std(axis=1, ddof=1) / math.sqrt(20)
    assert mean_standard_error(values.reshape(2, 100), clusters) == pytest.approx(expected)


def test_the_standard_error_of_single_episodes_is_the_usual_one() -> None:
    values = np.random.default_rng(0).normal(size=50)
    expected = values.std(ddof=1) / math.sqrt(50)
    assert float(mean_standard_error(values, np.arange(50))) == pytest.approx(expected)
    assert math.isnan(float(mean_standard_error(values, np.zeros(50, np.int64))))


def test_what_is_said_to_be_detectable_is_detected_in_four_of_five_studies() -> None:
    rng = np.random.default_rng(0)
    clusters = np.repeat(np.arange(60), rng.integers(2, 20, 60))
    count = len(clusters)

    def studies(effect: float) -> np.ndarray:
        own = rng.normal(size=(1500, 60))[:, clusters]
        return own + rng.normal(size=(1500, count)) + effect

    error = float(np.median(mean_standard_error(studies(0.0), clusters)))
    effect = float(minimum_detectable_effect(error, degrees=effective_clusters(clusters) - 1))
    p = cluster_permutation(studies(effect), clusters, num_permutations=499)
    assert 0.76 <= (p <= 0.05).mean() <= 0.84  # standard error of 1,500 studies: 0.01


def test_more_power_and_stricter_tests_need_larger_effects() -> None:
    usual = minimum_detectable_effect([0.01, 0.02], degrees=50)
    assert usual[1] == pytest.approx(2 * usual[0])
    assert minimum_detectable_effect(0.01, degrees=50, power=0.9) > usual[0]
    assert minimum_detectable_effect(0.01, degrees=50, alpha=0.01) > usual[0]
    assert minimum_detectable_effect(0.01, degrees=5) > usual[0]
    with pytest.raises(ValueError, match="power must be between 0 and 1, got 80"):
        minimum_detectable_effect(0.01, degrees=50, power=80)


def test_the_papers_plan_has_its_numbers() -> None:
    plan = paper_plan()
    families, counts = np.unique(plan.families, return_counts=True)
    episodes = [int(plan.sizes[plan.families == family].sum()) for family in families]
    assert dict(
        zip(families.tolist(), zip(counts.tolist(), episodes, strict=True), strict=True)
    ) == {
        "action_grounded": (70, 2899),
        "observation_controlled": (84, 832),
        "dyadic": (7, 210),
    }
    assert int(plan.fallback.sum()) == 2060
    assert np.ptp(np.bincount(plan.truth)) <= 2


@pytest.mark.parametrize(
    ("group", "means"),
    [("open", (10.31, 15.56, 9.89, 11.70)), ("closed", (24.44, 30.78, 22.61, 24.26))],
)
def test_paper_skills_score_the_papers_means(group: str, means: tuple[float, ...]) -> None:
    scores = macro_f1_scores(expected_confusions(paper_plan(), PAPER_SKILLS[group]))
    assert 100 * scores == pytest.approx(means, abs=0.02)


def test_answers_are_as_frequent_as_expected() -> None:
    plan, skill = paper_plan(), PAPER_SKILLS["closed"]
    answers = simulated_answers(plan, skill, np.random.default_rng(0), num_repeats=40)
    codes = confusion_codes(plan.episode_truth, answers)
    counts = np.stack([(codes == cell).mean(axis=(0, 2)) for cell in range(30)], axis=-1)
    expected = expected_confusions(plan, skill).reshape(4, 30) / len(plan.fallback)
    assert counts == pytest.approx(expected, abs=0.006)


def test_answers_agree_within_performances_as_much_as_asked() -> None:
    plan = Plan.even({"dyadic": (200, 2000)}, rng=np.random.default_rng(0))

    def agreement(correlation: float) -> float:
        skill = Skill({"p_init": 0.5}, correlation=correlation)
        right = simulated_answers(plan, skill, np.random.default_rng(1))[0, 0] == plan.episode_truth
        shares = right.reshape(200, 10).mean(axis=1)
        return float(shares.var() / (right.mean() * (1 - right.mean()) / 10))

    assert agreement(0.0) == pytest.approx(1.0, abs=0.3)  # binomial
    assert agreement(0.3) > 1.5
    assert agreement(1.0) == pytest.approx(10.0)  # all ten alike


def test_a_simulated_table_has_its_ties() -> None:
    plan = Plan.even({"dyadic": (10, 80)}, fallback=0.5, rng=np.random.default_rng(0))
    table = simulated_table(plan, PAPER_SKILLS, np.random.default_rng(0))
    initial, active = table.condition_index("p_init"), table.condition_index("a_obs")
    assert initial is not None
    assert active is not None
    same = table.same_frames[active]
    assert same.sum() == 40
    assert table.same_frames[initial].all()
    assert (table.answers[:, active, same] == table.answers[:, initial, same]).all()
    with pytest.raises(ValueError, match=r"signals of \('p_mon', 'p_ref', 'p_init', 'a_obs'\)"):
        simulated_table(
            plan, {**PAPER_SKILLS, "x": Skill({"p_init": 0.0})}, np.random.default_rng(0)
        )


def test_plans_and_skills_are_checked() -> None:
    plan = paper_plan()
    with pytest.raises(ValueError, match=r"fallback must be \(3941,\), got \(2,\)"):
        dataclasses.replace(plan, fallback=np.zeros(2, bool))
    with pytest.raises(ValueError, match=r"correlation must be in \[0, 1\], got 2"):
        Skill({"p_init": 0.0}, correlation=2)
    with pytest.raises(ValueError, match="p_init, p_ref, a_obs; no p_ref"):
        measure_coverage(plan, Skill({"p_init": 0.0}))
