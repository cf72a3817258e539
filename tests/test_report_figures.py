"""Figures of a report: what they show is what was found, whatever was and was not run."""

from __future__ import annotations

import dataclasses
import math
import re
import sys
from typing import Any, Literal
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from evaluation_cases import HOSTILE_NAMES, evaluation_case
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from affectsim_data.evaluation.results import Estimate, Evaluation, ModelCard
from affectsim_data.inspection.figures import neutral_settings, png_bytes, svg_bytes
from affectsim_data.motions import EMOTIONS
from affectsim_data.reports.figures import draw_figures, figure_texts
from affectsim_data.reports.figures.answers import draw_confusions, draw_outcomes
from affectsim_data.reports.figures.diagnostics import draw_families
from affectsim_data.reports.figures.marks import model_labels, points_text
from affectsim_data.reports.figures.models import draw_models
from affectsim_data.reports.figures.recovery import draw_recovery

PASSIVE = ("p_mon", "p_ref", "p_init")


@pytest.fixture(scope="module")
def files() -> dict[str, bytes]:
    return draw_figures(evaluation_case(models=HOSTILE_NAMES[:3], conditions=PASSIVE))


def test_each_figure_comes_as_png_and_svg_and_has_words(files: dict[str, bytes]) -> None:
    evaluation = evaluation_case(models=HOSTILE_NAMES[:3], conditions=PASSIVE)
    names = figure_texts(evaluation)
    assert list(files) == [f"{name}.{kind}" for name in names for kind in ("png", "svg")]
    assert {"models", "recovery", "emotions", "families", "confusions", "outcomes"} == set(names)
    for name, data in files.items():
        if name.endswith("png"):
            assert data.startswith(b"\x89PNG\r\n\x1a\n")
        else:
            assert ElementTree.fromstring(data).tag == "{http://www.w3.org/2000/svg}svg"


def test_the_same_results_give_the_same_bytes() -> None:
    evaluation = evaluation_case(models=("alpha",), conditions=("p_ref", "p_init"))
    first, second = (draw_models(evaluation, Figure, "all") for _ in range(2))
    assert svg_bytes(first) == svg_bytes(second)
    assert png_bytes(first) == png_bytes(second)


def test_names_are_text_and_no_formulas(files: dict[str, bytes]) -> None:
    shown = {
        "".join(one.itertext()).strip()
        for one in ElementTree.fromstring(files["models.svg"]).iter()
        if one.tag.endswith("}text")
    }
    labels = model_labels([ModelCard(name) for name in HOSTILE_NAMES[:3]])
    assert set(labels.values()) <= shown


def test_results_say_which_figures_there_are() -> None:
    active = figure_texts(evaluation_case(models=("alpha",)))
    assert {"models_new_observation", "acquisition"} <= active.keys()
    assert "recovered" in active["recovery"].title
    passive = figure_texts(evaluation_case(models=("alpha",), conditions=PASSIVE))
    assert passive["recovery"].title == "The observation gap"
    alone = figure_texts(evaluation_case(models=("alpha",), conditions=("p_ref", "p_mon")))
    assert "recovery" not in alone


def test_without_matplotlib_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(
        ModuleNotFoundError, match=r"figures of a report need matplotlib.*affectsim-data\[plots\]"
    ):
        draw_figures(evaluation_case(models=("alpha",)))


def marks_of(axes: Any, marker: str) -> list[tuple[float, float]]:
    """Places of single marks of a shape, from top to bottom."""
    found = [
        (float(line.get_xdata()[0]), float(line.get_ydata()[0]))
        for line in axes.lines
        if line.get_marker() == marker and len(line.get_xdata()) == 1
    ]
    return sorted(found, key=lambda place: place[1])


def texts_of(axes: Any) -> list[str]:
    return [text.get_text() for text in axes.texts]


@pytest.mark.parametrize(
    ("conditions", "field", "head"),
    [(None, "gain", "A-Obs − P-Init"), (PASSIVE, "gap", "P-Ref − P-Init")],  # noqa: RUF001
)
def test_models_stand_sorted_with_their_scores_and_differences(
    conditions: tuple[str, ...] | None, field: Literal["gain", "gap"], head: str
) -> None:
    names = ("alpha", "beta", "gamma", "delta")
    evaluation = (
        evaluation_case(models=names)
        if conditions is None
        else evaluation_case(models=names, conditions=conditions)
    )
    [axes] = draw_models(evaluation, Figure, "all").axes
    rows = [label.get_text() for label in axes.get_yticklabels()]

    def score(name: str, condition: str) -> float:
        found = evaluation.score(name, condition)
        assert found is not None
        return 100 * found.macro_f1.value

    assert rows == sorted(names, key=lambda name: -score(name, "p_ref"))
    for marker, condition in (("|", "p_ref"), ("o", "p_init")):
        places = [x for x, _ in marks_of(axes, marker)]
        np.testing.assert_allclose(places, [score(name, condition) for name in rows])
    benefits = [evaluation.benefit(name) for name in rows]
    expected = [points_text(getattr(benefit, field)) for benefit in benefits]
    assert texts_of(axes)[: len(rows)] == expected
    assert texts_of(axes)[-1].startswith(head)
    lines: list[Any] = list(axes.lines)
    assert [19.87, 19.87] in [pytest.approx(list(line.get_xdata())) for line in lines]


def test_groups_have_panels_and_missing_runs_no_marks() -> None:
    evaluation = evaluation_case(
        groups={"alpha": "open", "beta": "closed", "gamma": "open"}, without=[("gamma", "p_ref")]
    )
    panels = draw_models(evaluation, Figure, "all").axes
    assert [axes.get_title(loc="left") for axes in panels] == ["open", "closed"]
    assert [len(marks_of(axes, "|")) for axes in panels] == [1, 1]
    assert [len(marks_of(axes, "o")) for axes in panels] == [2, 1]


@pytest.mark.parametrize("count", [1, 7, 60])
def test_text_never_overlaps(count: int) -> None:
    names = [f"organisation-{place}/{'family-of-models-' * 2}{place}b-it" for place in range(count)]
    few = evaluation_case(models=names[:2])
    # Sixty rows out of two: the drawing is under test, not the numbers.
    evaluation = dataclasses.replace(
        few,
        models=tuple(map(ModelCard, names)),
        scores=tuple(_copies(few.scores, names)),
        benefits=tuple(_copies(few.benefits, names)),
    )
    figures = [draw_models(evaluation, Figure, "all")]
    figures += [draw_recovery(evaluation, Figure)] if count < 60 else []
    for figure in figures:
        canvas: Any = FigureCanvasAgg(figure)
        canvas.draw()
        renderer = canvas.get_renderer()
        boxes = [
            text.get_window_extent(renderer)
            for axes in figure.axes
            for text in [*axes.get_yticklabels(), *axes.texts, axes.xaxis.label]
            if text.get_visible() and text.get_text()
        ]
        page = figure.bbox.padded(1.0)
        for place, box in enumerate(boxes):
            assert page.contains(box.x0, box.y0)
            assert page.contains(box.x1, box.y1)
            assert not any(_meet(box, other) for other in boxes[place + 1 :])


def _copies(found: Any, names: list[str]) -> list[Any]:
    mine = [one for one in found if one.model == names[0]]
    return [dataclasses.replace(one, model=name) for name in names for one in mine]


def _meet(one: Any, other: Any) -> bool:
    """Whether boxes share more than the half pixel of a rounding."""
    wide = min(one.x1, other.x1) - max(one.x0, other.x0)
    high = min(one.y1, other.y1) - max(one.y0, other.y0)
    return bool(wide > 0.5 and high > 0.5)


def with_ogr(*ratios: Estimate) -> Evaluation:
    """An evaluation whose models recover these shares."""
    evaluation = evaluation_case(models=[f"model_{place}" for place in range(len(ratios))])
    ogr = {f"model_{place}": ratio for place, ratio in enumerate(ratios)}
    benefits = [dataclasses.replace(one, ogr=ogr[one.model]) for one in evaluation.benefits]
    return dataclasses.replace(evaluation, benefits=tuple(benefits))


def test_recovery_says_what_is_undefined_and_what_leaves_the_axis() -> None:
    evaluation = with_ogr(
        Estimate(math.nan),
        Estimate(0.5, 0.2, 0.8),
        Estimate(0.4, -math.inf, math.inf),
        Estimate(37.0),
        Estimate(-0.25, -0.5, 3.0),
    )
    left, right = draw_recovery(evaluation, Figure).axes
    rows = [label.get_text() for label in left.get_yticklabels()]
    said = dict(zip(rows, texts_of(right), strict=False))
    assert [said[f"model_{place}"] for place in range(5)] == [
        *("undefined", "0.50", "0.40", "37.00", "−0.25")  # noqa: RUF001
    ]
    drawn = {rows[round(y)]: x for x, y in marks_of(right, "D")}
    assert drawn == {"model_1": 0.5, "model_2": 0.4, "model_4": -0.25}
    assert [rows[round(y)] for _, y in marks_of(right, "<")] == ["model_2"]
    assert {rows[round(y)] for _, y in marks_of(right, ">")} == {"model_2", "model_3", "model_4"}
    assert right.get_xlim()[1] < 2.1


def test_families_and_challenges_are_those_there_are() -> None:
    evaluation = evaluation_case(models=("alpha",))
    axes = draw_families(evaluation, Figure).axes
    words = [[text.get_text().split("\n(")[0] for text in one.get_xticklabels()] for one in axes]
    assert words == [
        ["action\ngrounded", "observation\ncontrolled", "dyadic"],
        ["far\nvisible", "rear\nview", "partial\nocclusion", "obstacle\ndetour"],
    ]
    kept = [one for one in evaluation.breakdowns if one.factor != "challenge"]
    [alone] = draw_families(dataclasses.replace(evaluation, breakdowns=tuple(kept)), Figure).axes
    assert alone.get_xlabel() == "family"


def test_confusions_are_shares_of_the_true_emotion() -> None:
    evaluation = evaluation_case(models=("alpha", "beta"), conditions=("p_init",))
    [axes] = draw_confusions(evaluation, Figure).axes
    shares = []
    for name in ("alpha", "beta"):
        score = evaluation.score(name, "p_init")
        assert score is not None
        counts = np.array(score.confusion)
        shares.append(100 * counts / counts.sum(axis=1, keepdims=True))
    expected = [f"{value:.0f}" for value in np.mean(shares, axis=0).ravel()]
    assert texts_of(axes) == expected
    assert [label.get_text() for label in axes.get_yticklabels()] == list(EMOTIONS)


def test_bars_of_answers_fill_the_axis_where_there_are_answers() -> None:
    evaluation = evaluation_case(models=("alpha", "beta"), without=[("beta", "p_ref")])
    figure = draw_outcomes(evaluation, Figure)
    for axes in figure.axes:
        lengths = np.zeros(2)
        rectangles: list[Any] = list(axes.patches)
        for bar in rectangles:
            if bar.get_height() == pytest.approx(0.7):  # not the tint of a row
                lengths[round(bar.get_y() + 0.35)] += bar.get_width()
        missing = axes.get_title() == "P-Ref"
        np.testing.assert_allclose(lengths, [100, 0 if missing else 100])


@settings(max_examples=40)
@given(st.lists(st.text(max_size=80), min_size=1, max_size=12, unique=True))
def test_labels_are_short_visible_and_unlike(names: list[str]) -> None:
    labels = model_labels([ModelCard(name, parameters="7B") for name in names])
    assert len(set(labels.values())) == len(names)
    for label in labels.values():
        assert 0 < len(label) <= 40
        assert not re.search(r"[\x00-\x1f\x7f-\x9f\u202a-\u202e]", label)


def test_settings_of_the_reader_leave_figures_as_they_are() -> None:
    evaluation = evaluation_case(models=("$x$",), conditions=("p_init",))

    def drawn() -> bytes:
        with neutral_settings():
            return svg_bytes(draw_models(evaluation, Figure, "all"))

    expected = drawn()
    assert b">$x$</text>" in expected
    mine: dict[Any, Any] = {"axes.facecolor": "black", "font.size": 20, "lines.linewidth": 9}
    with matplotlib.rc_context(mine):
        assert drawn() == expected
        assert matplotlib.rcParams["font.size"] == 20
