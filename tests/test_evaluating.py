"""A whole evaluation against the plain metrics, brute force and laws."""

from __future__ import annotations

import dataclasses
import json
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scored_cases import only, scored_table
from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]  # has no types

from affectsim_data.evaluation import (
    emotion_spl,
    macro_f1,
    observation_gap_recovery,
    path_efficiency,
    per_class_recall,
    recovery_rate,
)
from affectsim_data.evaluation.bootstrap import (
    cluster_sums,
    degrees_of_freedom,
    interval,
    ratio_interval,
    resampled,
    resampling_weights,
    sampling_strata,
)
from affectsim_data.evaluation.confusion import confusion_codes, macro_f1_scores
from affectsim_data.evaluation.drawing import Drawing
from affectsim_data.evaluation.evaluating import evaluate
from affectsim_data.evaluation.results import Evaluation, ModelCard, Subset
from affectsim_data.evaluation.scored import OUTCOMES, RINGS_M, ScoredTable, outcome_code
from affectsim_data.evaluation.subsets import SubsetDraws
from affectsim_data.motions import EMOTIONS

NAN = math.nan
SUBSETS: tuple[Subset, ...] = ("all", "new_observation")


def evaluated(table: ScoredTable, **options: Any) -> Evaluation:
    return evaluate(table, **{"num_resamples": 200, "num_permutations": 200, **options})


def names_of(codes: NDArray[np.int8]) -> list[str]:
    """Labels as a user has them; what is no emotion gets the name of its outcome."""
    return [EMOTIONS[code] if code >= 0 else OUTCOMES[-1 - code] for code in codes]


def subset_of(table: ScoredTable, subset: Subset) -> NDArray[np.bool_]:
    assert table.acquisitions is not None
    return table.acquisitions.acquired if subset != "all" else np.ones(table.num_episodes, bool)


@pytest.fixture(scope="module")
def table() -> ScoredTable:
    return scored_table(models=("alpha", "beta", "gamma"))


@pytest.fixture(scope="module")
def evaluation(table: ScoredTable) -> Evaluation:
    return evaluated(table)


@pytest.mark.parametrize("subset", SUBSETS)
def test_scores_are_those_of_the_plain_functions(
    table: ScoredTable, evaluation: Evaluation, subset: Subset
) -> None:
    where = subset_of(table, subset)
    labels = names_of(table.truth[where])
    for model, name in enumerate(table.models):
        for place, condition in enumerate(table.conditions):
            codes = table.answers[model, place, where]
            answers = names_of(codes)
            score = evaluation.score(name, condition, subset)
            assert score is not None
            assert score.macro_f1.value == pytest.approx(macro_f1(labels, answers), abs=1e-12)
            assert score.accuracy.value == pytest.approx(np.equal(labels, answers).mean())
            recall = {emotion: one.value for emotion, one in score.recall.items()}
            assert recall == pytest.approx(per_class_recall(labels, answers))
            valid = codes >= 0
            kept = [np.array(values)[valid] for values in (labels, answers)]
            assert score.macro_f1_valid == pytest.approx(macro_f1(*kept))
            assert (score.num_valid, score.num_episodes) == (valid.sum(), where.sum())
            assert score.outcomes == {one: (codes == outcome_code(one)).sum() for one in OUTCOMES}
            assert np.sum(score.confusion) == where.sum()
            assert score.median_latency_ms == np.median(table.latency_ms[model, place, where])
            for one in (score.macro_f1, score.accuracy, *score.recall.values()):
                assert one.low < one.value < one.high


@pytest.mark.parametrize("subset", SUBSETS)
def test_benefits_are_those_of_the_plain_functions(
    table: ScoredTable, evaluation: Evaluation, subset: Subset
) -> None:
    assert table.acquisitions is not None
    where = subset_of(table, subset)
    labels = names_of(table.truth[where])
    for model, name in enumerate(table.models):
        answers = {
            condition: names_of(table.answers[model, place, where])
            for place, condition in enumerate(table.conditions)
        }
        score = {condition: macro_f1(labels, given) for condition, given in answers.items()}
        benefit = evaluation.benefit(name, subset)
        assert benefit is not None
        assert benefit.gain.value == pytest.approx(score["a_obs"] - score["p_init"])
        assert benefit.gap.value == pytest.approx(score["p_ref"] - score["p_init"])
        assert benefit.monitor_gap.value == pytest.approx(score["p_mon"] - score["p_init"])
        ogr = observation_gap_recovery(
            initial=score["p_init"], reference=score["p_ref"], active=score["a_obs"]
        )
        assert benefit.ogr.value == pytest.approx(ogr)
        expected = recovery_rate(labels, answers["p_init"], answers["a_obs"])
        assert benefit.recovery_rate.value == pytest.approx(expected)
        assert benefit.num_initial_errors == np.not_equal(labels, answers["p_init"]).sum()
        path = table.acquisitions.path_length_m[where]
        for place, ring in enumerate(RINGS_M):
            spl = emotion_spl(labels, answers["a_obs"], path, table.d_star_m[place, where])
            assert benefit.e_spl[ring].value == pytest.approx(spl)


def test_breakdowns_are_those_of_the_plain_functions(
    table: ScoredTable, evaluation: Evaluation
) -> None:
    levels = {(one.factor, one.level) for one in evaluation.breakdowns}
    assert len(levels) == 3 + 4 + 3 + 5 + 5
    assert len(evaluation.breakdowns) == len(levels) * table.was_run.size
    for one in evaluation.breakdowns:
        where = table.factors[one.factor] == one.level
        place = table.models.index(one.model), table.conditions.index(one.condition)
        labels, answers = names_of(table.truth[where]), names_of(table.answers[place][where])
        accuracy = np.equal(labels, answers).mean()
        assert one.accuracy.value == pytest.approx(accuracy)
        if one.factor == "emotion":
            assert one.macro_f1 == one.accuracy
        else:
            # Emotions that are not there have F1 0, so only the number of terms differs.
            mean = macro_f1(labels, answers) * 5 / len(set(labels))
            assert one.macro_f1.value == pytest.approx(mean)
        assert one.num_episodes == where.sum()
        assert one.num_clusters == len(np.unique(table.performances[where]))
    families = dict.fromkeys(one.level for one in evaluation.breakdowns if one.factor == "family")
    assert list(families) == ["action_grounded", "observation_controlled", "dyadic"]


def test_every_draw_is_the_metric_of_the_reweighted_table(table: ScoredTable) -> None:
    drawing = Drawing.of(table, "performance", num_resamples=100, confidence=0.95, seed=3)
    where = table.factors["challenge"] != "rear_view"
    draws = SubsetDraws.of(table, drawing, "all", where)
    assert table.acquisitions is not None
    right = table.answers == table.truth
    wrong = ~right[:, 2]
    efficiency = path_efficiency(table.acquisitions.path_length_m, table.d_star_m)
    for row in (0, 1, 57):
        weights = drawing.weights[row, drawing.clusters] * where
        cells = confusion_codes(table.truth, table.answers[1, 3])
        confusion = np.bincount(cells, weights, minlength=30).reshape(5, 6).astype(np.float64)
        assert draws.macro_f1[row, 1, 3] == pytest.approx(float(macro_f1_scores(confusion)))
        recall = np.diag(confusion) / confusion.sum(axis=1)
        np.testing.assert_allclose(draws.recall[row, 1, 3], recall)
        assert draws.accuracy[row, 1, 3] == pytest.approx(np.diag(confusion).sum() / weights.sum())
        rates = (wrong * right[:, 3] * weights).sum(axis=1) / (wrong * weights).sum(axis=1)
        np.testing.assert_allclose(draws.recovery_rate[row], rates)
        valid = weights * ~np.isnan(efficiency[0])
        spl = (np.nan_to_num(efficiency[0]) * right[:, 3] * valid).sum(axis=1) / valid.sum()
        np.testing.assert_allclose(draws.e_spl[row, 0], spl, rtol=1e-4)
    assert (draws.macro_f1[1:] != draws.macro_f1[0]).any()


def test_intervals_are_those_of_whole_confusions_by_the_kernels(
    table: ScoredTable, evaluation: Evaluation
) -> None:
    clusters = table.performances
    strata = sampling_strata(clusters, table.factors["family"], table.factors["emotion"])
    weights = resampling_weights(60, num_resamples=200, seed=0, strata=strata)
    cells = confusion_codes(table.truth, table.answers[0])[:, None] == np.arange(30)[:, None]
    scores = macro_f1_scores(resampled(cluster_sums(cells, clusters), weights).reshape(-1, 4, 5, 6))
    point = macro_f1_scores(cells.sum(axis=-1).reshape(4, 5, 6).astype(np.float64))
    degrees = degrees_of_freedom(clusters, strata)
    low, high = interval(point, scores, degrees=degrees)
    for place, condition in enumerate(table.conditions):
        score = evaluation.score("alpha", condition)
        assert score is not None
        bounds = (score.macro_f1.low, score.macro_f1.high)
        assert bounds == pytest.approx((low[place], high[place]), abs=1e-5)
    benefit = evaluation.benefit("alpha")
    assert benefit is not None
    gain, gap = (scores[:, place] - scores[:, 2] for place in (3, 1))
    low, high = ratio_interval(point[3] - point[2], point[1] - point[2], gain, gap, degrees=degrees)
    ogr = (benefit.ogr.low, benefit.ogr.high)
    assert ogr == pytest.approx((float(low), float(high)), abs=1e-4)


def reordered(table: ScoredTable, episodes: NDArray[np.int64], models: list[int]) -> ScoredTable:
    """The table with its episodes and models in another order."""
    assert table.acquisitions is not None
    acquired = {
        field.name: getattr(table.acquisitions, field.name)[episodes]
        for field in dataclasses.fields(table.acquisitions)
        if field.name != "policy"
    }
    return dataclasses.replace(
        table,
        episode_ids=table.episode_ids[episodes],
        truth=table.truth[episodes],
        factors={name: values[episodes] for name, values in table.factors.items()},
        performances=table.performances[episodes],
        performers=table.performers[episodes],
        models=tuple(table.models[one] for one in models),
        answers=table.answers[models][..., episodes],
        was_run=table.was_run[models],
        latency_ms=table.latency_ms[models][..., episodes],
        same_frames=table.same_frames[:, episodes],
        d_star_m=table.d_star_m[:, episodes],
        ring_empty=table.ring_empty[:, episodes],
        acquisitions=dataclasses.replace(table.acquisitions, **acquired),
    )


def flat(value: Any, path: str = "") -> dict[str, Any]:
    """Leaves of JSON by path; entries of lists go by what they are about, not by their place."""
    if isinstance(value, dict):
        return {k: v for key, one in value.items() for k, v in flat(one, f"{path}/{key}").items()}
    if isinstance(value, list):
        keys = ("model", "condition", "subset", "factor", "level", "group", "name", "distance_m")
        leaves: dict[str, Any] = {}
        for place, one in enumerate(value):
            mark = str([one.get(key) for key in keys]) if isinstance(one, dict) else str(place)
            leaves |= flat(one, f"{path}[{mark}]")
        return leaves
    return {path: value}


def test_order_of_episodes_and_models_changes_nothing(
    table: ScoredTable, evaluation: Evaluation
) -> None:
    shuffled = np.random.default_rng(0).permutation(table.num_episodes)
    other = evaluated(reordered(table, shuffled, [2, 0, 1])).to_json()
    mine = evaluation.to_json()
    for unordered in ("models", "notes"):
        del mine[unordered], other[unordered]
    first, second = flat(mine), flat(other)
    assert first.keys() == second.keys()
    assert len(first) > 2000
    for path, value in first.items():
        close = pytest.approx(value, rel=1e-9, abs=1e-12) if isinstance(value, float) else value
        assert second[path] == close, path


def test_the_same_seed_gives_the_same_bytes_on_any_number_of_threads(table: ScoredTable) -> None:
    texts = []
    for threads in (1, 2):
        with threadpool_limits(threads):
            texts.append(json.dumps(evaluated(table, seed=5).to_json()))
    assert texts[0] == texts[1]
    other = evaluated(table, seed=6)
    assert json.dumps(other.to_json()) != texts[0]
    assert other.scores[0].macro_f1.value == json.loads(texts[0])["scores"][0]["macro_f1"]["value"]


def test_equal_answers_are_no_gain_and_no_evidence(table: ScoredTable) -> None:
    answers = table.answers.copy()
    answers[:, 1] = answers[:, 2]
    found = evaluated(dataclasses.replace(table, answers=answers))
    for benefit in found.benefits:
        assert (benefit.gap.value, benefit.gap.low, benefit.gap.high) == (0, 0, 0)
        assert math.isnan(benefit.ogr.value)
        assert math.isnan(benefit.ogr.low)
    for test in found.tests:
        if test.condition == "p_ref":
            assert (test.only_initial, test.only_condition) == (0, 0)
            assert (test.mcnemar_p, test.permutation_p, test.permutation_holm_p) == (1, 1, 1)
            assert test.num_pairs == table.num_episodes
    assert any("have no OGR" in note for note in found.notes)


def test_fallback_alone_is_no_gain(table: ScoredTable) -> None:
    assert table.acquisitions is not None
    answers, same = table.answers.copy(), table.same_frames.copy()
    answers[:, 3] = answers[:, 2]
    same[3] = True
    never = dataclasses.replace(table.acquisitions, acquired=np.zeros(table.num_episodes, bool))
    found = evaluated(
        dataclasses.replace(table, answers=answers, same_frames=same, acquisitions=never)
    )
    assert {benefit.subset for benefit in found.benefits} == {"all"}
    assert [benefit.gain.value for benefit in found.benefits] == [0, 0, 0]
    assert [benefit.recovery_rate.value for benefit in found.benefits] == [0, 0, 0]
    for test in found.tests:
        if test.condition == "a_obs":
            assert (test.num_pairs, test.num_tied) == (0, table.num_episodes)
            assert (test.mcnemar_p, test.permutation_p) == (1, 1)
            assert math.isnan(test.detectable)
    assert any("no new observation" in note for note in found.notes)


def test_ties_by_construction_are_left_out(table: ScoredTable, evaluation: Evaluation) -> None:
    for test in evaluation.tests:
        model, place = table.models.index(test.model), table.conditions.index(test.condition)
        pairs = ~table.same_frames[place]
        before = (table.answers[model, 2] == table.truth)[pairs]
        after = (table.answers[model, place] == table.truth)[pairs]
        assert test.num_pairs == pairs.sum()
        assert test.num_pairs + test.num_tied == table.num_episodes
        assert (test.only_initial, test.only_condition) == (
            (before & ~after).sum(),
            (after & ~before).sum(),
        )
        assert 0 < test.detectable < 0.3
    for condition in ("p_mon", "p_ref", "a_obs"):
        tests = [test for test in evaluation.tests if test.condition == condition]
        for kind in ("mcnemar", "permutation"):
            found = sorted(
                (getattr(test, f"{kind}_p"), getattr(test, f"{kind}_holm_p")) for test in tests
            )
            least = 0.0
            for place, (plain, adjusted) in enumerate(found):
                least = max(least, min(1.0, (len(tests) - place) * plain))
                assert adjusted == pytest.approx(least)
    clear = {test.model for test in evaluation.tests if test.permutation_holm_p < 0.05}
    assert clear == set(table.models)


def test_means_over_groups(table: ScoredTable) -> None:
    cards = {"alpha": ModelCard("alpha", "open", "7B"), "gamma": ModelCard("gamma", "open")}
    found = evaluated(table, model_cards={**cards, "delta": ModelCard("delta")})
    assert [card.group for card in found.models] == ["open", "", "open"]
    means = {(one.group, one.subset): one for one in found.means}
    assert list(means) == [(group, subset) for subset in SUBSETS for group in ("", "open")]
    for (group, subset), mean in means.items():
        models = [name for name in table.models if not group or name in cards]
        benefits = [one for name in models if (one := found.benefit(name, subset))]
        scores = [score for name in models if (score := found.score(name, "p_ref", subset))]
        assert mean.num_models == mean.num_ogr == len(models)
        assert mean.macro_f1["p_ref"].value == pytest.approx(
            np.mean([one.macro_f1.value for one in scores])
        )
        assert mean.recall["p_ref"]["sad"].value == pytest.approx(
            np.mean([one.recall["sad"].value for one in scores])
        )
        gain = np.mean([one.gain.value for one in benefits])
        gap = np.mean([one.gap.value for one in benefits])
        assert (mean.gain.value, mean.gap.value) == pytest.approx((gain, gap))
        monitor_gap = np.mean([one.monitor_gap.value for one in benefits])
        assert mean.monitor_gap.value == pytest.approx(monitor_gap)
        assert mean.monitor_gap.low < monitor_gap < mean.monitor_gap.high
        assert mean.ogr_of_means.value == pytest.approx(gain / gap)
        own = [one.ogr.value for one in benefits]
        assert mean.mean_ogr.value == pytest.approx(np.mean(own))
        assert mean.e_spl[3].value == pytest.approx(
            np.mean([one.e_spl[3].value for one in benefits])
        )
        assert mean.ogr_of_means.low < mean.ogr_of_means.value < mean.ogr_of_means.high
    family = [
        one.macro_f1.value
        for one in found.breakdowns
        if (one.level, one.condition) == ("dyadic", "a_obs")
    ]
    overall = means["", "all"].family_macro_f1["dyadic"]["a_obs"].value
    assert overall == pytest.approx(np.mean(family))
    assert any("without predictions: delta" in note for note in found.notes)


def test_a_gap_that_may_be_zero_leaves_ogr_unbounded(table: ScoredTable) -> None:
    answers = table.answers.copy()
    answers[0, 1] = answers[0, 2]
    lost = np.flatnonzero(answers[0, 1] != table.truth)[:3]
    answers[0, 1, lost] = table.truth[lost]
    found = evaluated(dataclasses.replace(table, answers=answers))
    vague, clear = found.benefit("alpha"), found.benefit("beta")
    assert vague is not None
    assert clear is not None
    assert vague.gap.value > 0
    assert not vague.gap.excludes_zero
    assert (vague.ogr.low, vague.ogr.high) == (-math.inf, math.inf)
    assert clear.ogr.low < clear.ogr.value < clear.ogr.high < math.inf
    mean = found.means[0]
    assert (mean.mean_ogr.low, mean.mean_ogr.high) == (-math.inf, math.inf)
    assert mean.ogr_of_means.low < mean.ogr_of_means.value < mean.ogr_of_means.high < math.inf
    assert (
        "The OGR of alpha has no bounds at 95% confidence: the gap it divides by may be zero."
        in found.notes
    )


def test_a_negative_gap_has_no_ogr_and_is_not_in_the_mean(table: ScoredTable) -> None:
    answers = table.answers.copy()
    answers[0, 1:3] = answers[0, 2:0:-1]
    found = evaluated(dataclasses.replace(table, answers=answers))
    own = [one.ogr.value for one in found.benefits if one.subset == "all"]
    assert [math.isnan(one) for one in own] == [True, False, False]
    mean = found.means[0]
    assert mean.num_ogr == 2
    assert mean.mean_ogr.value == pytest.approx(np.mean(own[1:]))
    assert mean.ogr_of_means.value == pytest.approx(mean.gain.value / mean.gap.value)
    note = "alpha has no OGR: Macro-F1 under p_ref is not above p_init."
    assert note in found.notes


def test_acquisition_by_hand(table: ScoredTable, evaluation: Evaluation) -> None:
    acquired = table.acquisitions
    assert acquired is not None
    overall, *levels = evaluation.acquisition
    assert overall.factor == overall.level == ""
    for one in (overall, *levels):
        where = np.ones(table.num_episodes, bool)
        if one.factor:
            where = table.factors[one.factor] == one.level
        assert one.num_episodes == where.sum()
        assert one.stable_handoff.value == pytest.approx(acquired.handed_off[where].mean())
        assert one.mean_path_m.value == pytest.approx(acquired.path_length_m[where].mean())
        before = acquired.path_before_handoff_m[where].sum() / acquired.path_length_m[where].sum()
        assert one.path_before_handoff.value == pytest.approx(before)
        clipped = acquired.num_clipped[where].sum() / acquired.num_translations[where].sum()
        assert one.clipped.value == pytest.approx(clipped)
        assert one.new_observations == acquired.acquired[where].sum()
    assert overall.stable_handoff.value + overall.budget_exhausted.value == pytest.approx(1)
    assert {one.level for one in levels if one.factor == "challenge"} == {
        "far_visible", "rear_view", "partial_occlusion", "obstacle_detour"
    }  # fmt: skip


def test_rings_count_what_e_spl_leaves_out(table: ScoredTable, evaluation: Evaluation) -> None:
    for place, ring in enumerate(evaluation.rings):
        assert ring.distance_m == RINGS_M[place]
        assert ring.num_valid == (~np.isnan(table.d_star_m[place])).sum()
        assert ring.num_empty == table.ring_empty[place].sum() > 0
        assert ring.num_valid + ring.num_empty + ring.num_unreachable == table.num_episodes


def test_missing_conditions_leave_numbers_undefined(table: ScoredTable) -> None:
    found = evaluated(only(table, "p_ref", "p_init"))
    for benefit in found.benefits:
        assert benefit.gap.excludes_zero
        for missing in (benefit.gain, benefit.ogr, benefit.recovery_rate, *benefit.e_spl.values()):
            assert math.isnan(missing.value)
    assert found.acquisition == ()
    assert {test.condition for test in found.tests} == {"p_ref"}
    alone = evaluated(only(table, "p_ref"))
    assert alone.tests == ()
    assert math.isnan(alone.benefits[0].gap.value)
    assert alone.benefits[0].num_initial_errors == 0
    assert any("Nothing was run under p_init" in note for note in alone.notes)


def test_a_model_that_was_not_run_is_left_out_of_means(table: ScoredTable) -> None:
    was_run = table.was_run.copy()
    was_run[1, 3] = False
    found = evaluated(dataclasses.replace(table, was_run=was_run))
    assert found.score("beta", "a_obs") is None
    benefit = found.benefit("beta")
    assert benefit is not None
    assert math.isnan(benefit.gain.value)
    assert benefit.gap.value > 0
    others = [one.macro_f1.value for one in found.scores if one.condition == "a_obs"]
    assert found.means[0].macro_f1["a_obs"].value == pytest.approx(np.mean(others[:2]))
    assert found.means[0].num_ogr == 2
    assert "beta was not run under a_obs: means under it are over the others." in found.notes


def test_without_trajectories_there_is_no_e_spl(table: ScoredTable) -> None:
    found = evaluated(dataclasses.replace(table, acquisitions=None))
    assert found.acquisition == ()
    assert math.isnan(found.benefits[0].e_spl[1].value)
    assert not math.isnan(found.benefits[0].gain.value)
    assert {score.subset for score in found.scores} == {"all"}


def test_performers_are_clusters_only_if_there_are_six(table: ScoredTable) -> None:
    found = evaluated(table, cluster="performer")
    assert found.settings.num_clusters == 7
    assert any("rough" in note for note in found.notes)
    with pytest.raises(ValueError, match="2 performers cannot be the clusters"):
        evaluated(dataclasses.replace(table, performers=table.performers % 2), cluster="performer")


def test_few_performances_give_numbers_without_intervals() -> None:
    found = evaluated(scored_table(num_performances=5))
    assert found.scores[0].macro_f1.value > 0
    assert math.isnan(found.scores[0].macro_f1.low)
    assert math.isnan(found.benefits[0].ogr.low)
    assert any("no intervals: 5 clusters" in note for note in found.notes)


def test_an_absent_emotion_is_said(table: ScoredTable) -> None:
    there = np.flatnonzero(table.truth != EMOTIONS.index("sad"))
    found = evaluated(reordered(table, there, [0, 1, 2]))
    score = found.scores[0]
    assert math.isnan(score.recall["sad"].value)
    assert "No episode is sad" in found.notes[0]
    for one in found.breakdowns:
        if one.factor == "family":
            where = there[table.factors["family"][there] == one.level]
            place = table.models.index(one.model), table.conditions.index(one.condition)
            expected = macro_f1(names_of(table.truth[where]), names_of(table.answers[place][where]))
            assert one.macro_f1.value == pytest.approx(expected * 5 / 4)
    assert found.chance < 0.2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"cluster": "scene"}, "cluster must be performance or performer, got 'scene'"),
        ({"num_resamples": 10}, "num_resamples must be at least 100, got 10"),
        ({"num_permutations": 0}, "num_permutations must be at least 100, got 0"),
        ({"confidence": 95}, r"confidence must be in \(0, 1\), for example 0.95, got 95"),
    ],
)
def test_arguments_out_of_range(table: ScoredTable, options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        evaluated(table, **options)


def test_nothing_to_evaluate(table: ScoredTable) -> None:
    with pytest.raises(ValueError, match="nothing to evaluate: 360 episodes, 3 models"):
        evaluated(dataclasses.replace(table, was_run=np.zeros_like(table.was_run)))
