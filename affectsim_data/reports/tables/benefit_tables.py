"""Tables of what observation did: gaps, gains and recoveries with intervals, and their tests."""

from __future__ import annotations

import dataclasses
import math

from affectsim_data.evaluation.results import Benefit, Estimate, Evaluation, GroupMean, PairedTest
from affectsim_data.reports.tables.columns import change_column
from affectsim_data.reports.tables.gathering import (
    find_mean,
    gathered,
    model_columns,
    model_keys,
)
from affectsim_data.reports.tables.model import Cell, Column, Row, Table, number
from affectsim_data.reports.tables.texts import condition_title

__all__ = ["benefit_tables"]

_TOPIC = "What observation did"


@dataclasses.dataclass(frozen=True)
class _Measure:
    """A number of a `Benefit`, and the conditions it needs beside p_init."""

    column: Column
    conditions: tuple[str, ...]


_MEASURES = (
    _Measure(change_column("gap", digits=1, interval="shown"), ("p_ref",)),
    _Measure(
        change_column("monitor_gap", digits=1, interval="shown"),
        ("p_mon",),
    ),
    _Measure(change_column("gain", digits=1, interval="shown"), ("a_obs",)),
    _Measure(Column("ogr", "OGR", "ratio", "gain / gap", 2, "shown"), ("p_ref", "a_obs")),
    _Measure(
        Column("recovery_rate", "Recovery rate", "percent", "% of errors", 1, "shown"), ("a_obs",)
    ),
)


def benefit_tables(evaluation: Evaluation) -> list[Table]:
    """Gaps and recoveries, and the tests of conditions against P-Init."""
    measures = [one for one in _MEASURES if set(one.conditions) <= set(evaluation.conditions)]
    if "p_init" not in evaluation.conditions or not measures:
        return []
    tables = [_benefits(evaluation, measures)]
    if evaluation.tests:
        tables.append(_tests(evaluation))
    return tables


def _benefits(evaluation: Evaluation, measures: list[_Measure]) -> Table:
    with_errors = "a_obs" in evaluation.conditions
    errors = Column("initial_errors", "Errors", "count", "under P-Init")

    def cells(one: Benefit | GroupMean | None) -> list[Cell]:
        found = [_cell(one, measure, evaluation) for measure in measures]
        count = one.num_initial_errors if isinstance(one, Benefit) else None
        return found + [Cell(count)] * with_errors

    with_ogr = any(one.column.name == "ogr" for one in measures)
    return Table(
        name="benefits",
        title="Gaps, gains and recovery",
        caption=(
            "Differences of Macro-F1 in percentage points"
            + (
                ". OGR, the observation gap recovery, is gain over gap: 0 if moving was of no use, "
                "1 if it reached the reference view; it may lie outside. The recovery rate is the "
                "share of wrong answers under P-Init that are right under A-Obs."
                if with_errors
                else "."
            )
        ),
        columns=(
            *model_columns(evaluation),
            *[one.column for one in measures],
            *[errors] * with_errors,
        ),
        rows=(
            *gathered(evaluation, lambda card: cells(evaluation.benefit(card.model)), cells),
            *(_mean_ratios(evaluation, measures, with_errors) if with_ogr else ()),
        ),
        notes=(
            ("OGR in a row of means is the ratio of the mean gain to the mean gap.",)
            if with_ogr and evaluation.means
            else ()
        ),
        num_keys=len(model_columns(evaluation)),
        topic=_TOPIC,
    )


def _cell(one: Benefit | GroupMean | None, measure: _Measure, evaluation: Evaluation) -> Cell:
    name = measure.column.name
    if isinstance(one, GroupMean):
        if name == "ogr" and not math.isnan(one.gap.value):
            return _ratio(one.ogr_of_means)
        return number(one.ogr_of_means if name == "ogr" else getattr(one, name), why="a")
    ran = (
        [evaluation.score(one.model, name) for name in ("p_init", *measure.conditions)]
        if one
        else []
    )
    if one is None or None in ran:
        return number(None)
    return _ratio(one.ogr) if name == "ogr" else number(getattr(one, name))


def _ratio(ogr: Estimate) -> Cell:
    """OGR: without a value if the gap is not positive, marked if its interval has no bounds."""
    cell = number(ogr, why="b")
    is_bounded = math.isfinite(ogr.low) and math.isfinite(ogr.high)
    return cell if cell.is_undefined or is_bounded else dataclasses.replace(cell, mark="e")


def _mean_ratios(evaluation: Evaluation, measures: list[_Measure], with_errors: bool) -> list[Row]:
    """The other mean OGR: of the ratios, over the models that have one."""
    mean = find_mean(evaluation, "")
    if mean is None or len(evaluation.models) < 2:
        return []
    name = f"All models: mean of OGR ({mean.num_ogr} of {mean.num_models} have one)"
    cells = [_ratio(mean.mean_ogr) if one.column.name == "ogr" else Cell() for one in measures]
    return [Row((*model_keys(evaluation, name), *cells, *[Cell()] * with_errors), "mean")]


def _by_condition(evaluation: Evaluation) -> list[PairedTest]:
    """Tests of a condition together: they are what Holm adjusts for one another."""
    order = list(dict.fromkeys(test.condition for test in evaluation.tests))
    return sorted(evaluation.tests, key=lambda test: order.index(test.condition))


def _tests(evaluation: Evaluation) -> Table:
    def row(test: PairedTest) -> Row:
        values = (test.mcnemar_p, test.mcnemar_holm_p, test.permutation_p, test.permutation_holm_p)
        counts = (test.num_pairs, test.num_tied, test.only_initial, test.only_condition)
        return Row(
            (
                Cell(condition_title(test.condition)),
                Cell(test.model),
                *[Cell(count) for count in counts],
                *[number(Estimate(value)) for value in values],
                number(Estimate(test.detectable)),
            )
        )

    settings = evaluation.settings
    return Table(
        name="tests",
        title="Tests against P-Init",
        caption=(
            "Whether a model answers differently under a condition than under P-Init, by the same "
            "episodes. Pairs whose clips are the same by construction are left out. McNemar's "
            "exact test takes episodes for independent, which they are not where one performance "
            f"is replayed in many; the permutation test swaps whole {settings.cluster}s and is the "
            "one to trust. Holm: adjusted for the number of models. Detectable: the difference in "
            f"accuracy that {settings.num_clusters:,} {settings.cluster}s would show with 80 % "
            "power."
        ),
        columns=(
            Column("condition", "Condition"),
            Column("model", "Model"),
            Column("pairs", "Pairs", "count"),
            Column("tied", "Same clip", "count"),
            Column("only_initial", "Right only", "count", "P-Init"),
            Column("only_condition", "Right only", "count", "condition"),
            Column("mcnemar_p", "McNemar", "p", "p"),
            Column("mcnemar_holm_p", "McNemar", "p", "Holm"),
            Column("permutation_p", "Permutation", "p", "p"),
            Column("permutation_holm_p", "Permutation", "p", "Holm"),
            Column("detectable", "Detectable", "percent", "pp"),
        ),
        rows=tuple(map(row, _by_condition(evaluation))),
        num_keys=2,
        topic=_TOPIC,
    )
