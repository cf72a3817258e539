"""Metrics on plain label names: by hand, against scikit-learn, and against SPL of habitat-lab."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.metrics import confusion_matrix as sklearn_confusion
from sklearn.metrics import f1_score, recall_score

import affectsim_data.evaluation
from affectsim_data.evaluation import (
    active_gain,
    confusion_matrix,
    emotion_spl,
    macro_f1,
    observation_gap_recovery,
    path_efficiency,
    per_class_recall,
    recovery_rate,
)
from affectsim_data.motions import EMOTIONS

NAN = math.nan
LABELS = st.sampled_from(EMOTIONS)
ANSWERS = st.one_of(
    LABELS, st.sampled_from([None, "", "refusal", "Happy", "happy ", "disgusted", 3, NAN])
)
PAIRS = st.lists(st.tuples(LABELS, ANSWERS), min_size=1, max_size=40)
WAYS = st.one_of(st.just(0.0), st.floats(0.0, 30.0, allow_subnormal=False))


def sixth(answers: list[Any]) -> list[str]:
    """Answers as scikit-learn takes them: all that is no emotion is one label more."""
    return [one if isinstance(one, str) and one in EMOTIONS else "else" for one in answers]


@given(PAIRS)
def test_macro_f1_and_recall_are_those_of_scikit_learn(pairs: list[tuple[str, Any]]) -> None:
    truth, answers = [one for one, _ in pairs], [other for _, other in pairs]
    names, given_names = list(EMOTIONS), sixth(answers)
    expected = f1_score(truth, given_names, labels=names, average="macro", zero_division=0)
    assert macro_f1(truth, answers) == pytest.approx(expected, abs=1e-12)
    recalls = recall_score(truth, given_names, labels=names, average=None, zero_division=np.nan)
    np.testing.assert_allclose(list(per_class_recall(truth, answers).values()), recalls)
    counts = sklearn_confusion(truth, given_names, labels=[*EMOTIONS, "else"])
    np.testing.assert_array_equal(confusion_matrix(truth, answers), counts[:5])


def habitat_spl(success: bool, shortest: float, path: float) -> float:
    """SPL of an episode as habitat-lab defines it; it divides by 0 where both ways are 0."""
    return float(success) * (shortest / max(shortest, path))


@given(st.lists(st.tuples(LABELS, ANSWERS, WAYS, WAYS), min_size=1, max_size=30))
def test_e_spl_is_the_spl_of_habitat(rows: list[tuple[str, Any, float, float]]) -> None:
    truth, answers, paths, shortest = map(list, zip(*rows, strict=True))
    expected = [
        float(answer == label) if way == best == 0 else habitat_spl(answer == label, best, way)
        for label, answer, way, best in rows
    ]
    assert emotion_spl(truth, answers, paths, shortest) == pytest.approx(np.mean(expected))


def test_e_spl_leaves_out_rings_that_are_not_there() -> None:
    truth, paths = ["sad", "sad", "happy"], [2.0, 1.0, 1.0]
    assert emotion_spl(truth, truth, paths, [1.0, NAN, 2.0]) == 0.75
    assert math.isnan(emotion_spl(truth, truth, paths, [NAN, NAN, NAN]))


def test_efficiency_without_a_way() -> None:
    assert path_efficiency(0.0, 0.0) == 1
    assert path_efficiency(1.0, 0.0) == 0
    assert path_efficiency(0.0, 1.0) == 1
    assert math.isnan(path_efficiency(0.0, NAN))


def test_constant_answers_on_a_balanced_table_score_a_fifteenth() -> None:
    truth = list(EMOTIONS) * 8
    for emotion in EMOTIONS:
        assert macro_f1(truth, [emotion] * len(truth)) == pytest.approx(1 / 15)


def test_macro_f1_by_hand() -> None:
    truth = ["angry", "angry", "fearful", "happy", "neutral", "sad"]
    answers = ["angry", "sad", "fearful", None, "sad", "sad"]
    # angry 2/3, fearful 1, happy 0, neutral 0, sad 2 / (1 + 3)
    assert macro_f1(truth, answers) == pytest.approx((2 / 3 + 1 + 0 + 0 + 0.5) / 5)
    assert macro_f1(np.array(truth), np.array(truth)) == 1
    assert math.isnan(macro_f1([], []))


@given(PAIRS, st.randoms())
def test_order_does_not_matter_and_saying_nothing_never_helps(
    pairs: list[tuple[str, Any]], random: Any
) -> None:
    truth, answers = [one for one, _ in pairs], [other for _, other in pairs]
    score = macro_f1(truth, answers)
    shuffled = random.sample(pairs, len(pairs))
    assert macro_f1(*map(list, zip(*shuffled, strict=True))) == score
    silent = [answer if answer == label else None for label, answer in pairs]
    assert 0 <= score <= macro_f1(truth, silent) <= 1


@given(st.lists(st.tuples(LABELS, ANSWERS, ANSWERS), min_size=1, max_size=40))
def test_recovery_rate_counts_errors_mended(rows: list[tuple[str, Any, Any]]) -> None:
    truth, initial, active = map(list, zip(*rows, strict=True))
    mended = [after == label for label, before, after in rows if before != label]
    rate = recovery_rate(truth, initial, active)
    assert math.isnan(rate) if not mended else rate == pytest.approx(np.mean(mended))


def test_gap_recovery_is_not_clipped() -> None:
    assert observation_gap_recovery(initial=0.25, reference=0.5, active=0.25) == 0
    assert observation_gap_recovery(initial=0.25, reference=0.5, active=0.5) == 1
    assert observation_gap_recovery(initial=0.25, reference=0.5, active=0.75) == 2
    assert observation_gap_recovery(initial=0.25, reference=0.5, active=0.0) == -1


@pytest.mark.parametrize("reference", [0.25, 0.125, NAN])
def test_gap_recovery_needs_a_gap(reference: float) -> None:
    assert math.isnan(observation_gap_recovery(initial=0.25, reference=reference, active=0.5))


def test_gain_is_signed() -> None:
    assert active_gain(initial=0.5, active=0.25) == -0.25


def test_what_is_wrong_with_the_input_is_said() -> None:
    with pytest.raises(ValueError, match=r"labels\[1\] must be one of angry, .*, got 'Sad'"):
        macro_f1(["sad", "Sad"], ["sad", "sad"])
    with pytest.raises(ValueError, match="one value per episode, got labels 2, predictions 1"):
        per_class_recall(["sad", "sad"], ["sad"])
    with pytest.raises(ValueError, match="got labels 1, initial 1, active 2"):
        recovery_rate(["sad"], ["sad"], ["sad", "sad"])
    with pytest.raises(ValueError, match=r"path_length_m\[1\] must be a length in metres, got nan"):
        emotion_spl(["sad"] * 2, ["sad"] * 2, [1.0, NAN], [1.0, 1.0])
    with pytest.raises(ValueError, match=r"d_star_m\[0\] must be a length in metres, got -1"):
        path_efficiency([1.0], [-1.0])


def test_all_names_are_there() -> None:
    for name in affectsim_data.evaluation.__all__:
        assert hasattr(affectsim_data.evaluation, name)
