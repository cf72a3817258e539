"""Tables of recognition quality: the summary, outcomes of answers, recalls, confusions."""

from __future__ import annotations

from collections.abc import Sequence

from affectsim_data.evaluation.results import (
    ConditionScore,
    Estimate,
    Evaluation,
    GroupMean,
    ModelCard,
)
from affectsim_data.evaluation.scored import OUTCOMES
from affectsim_data.motions import EMOTIONS
from affectsim_data.reports.tables.columns import change_column, score_columns
from affectsim_data.reports.tables.gathering import (
    above_chance,
    chance_row,
    gathered,
    model_columns,
    needs,
    with_best,
)
from affectsim_data.reports.tables.model import Cell, Column, Row, Table, number
from affectsim_data.reports.tables.texts import condition_title

__all__ = ["quality_tables", "summary_table"]

_TOPIC = "Recognition quality"


def summary_table(evaluation: Evaluation) -> Table:
    """The main thing in one table: Macro-F1 by condition with intervals, gap and gain."""
    conditions = evaluation.conditions
    with_gap = {"p_init", "p_ref"} <= set(conditions)
    with_gain = {"p_init", "a_obs"} <= set(conditions)

    def changes(gap: Estimate | None, gain: Estimate | None) -> list[Cell]:
        gaps = [needs(gap, "p_init", "p_ref", of=evaluation, why="a")] * with_gap
        return gaps + [needs(gain, "p_init", "a_obs", of=evaluation, why="a")] * with_gain

    def scores(found: Sequence[Estimate | None]) -> list[Cell]:
        return with_best([above_chance(one, evaluation.chance) for one in found])

    def entry(card: ModelCard) -> list[Cell]:
        found = [evaluation.score(card.model, name) for name in conditions]
        benefit = evaluation.benefit(card.model)
        pair = (benefit.gap, benefit.gain) if benefit else (None, None)
        return [*scores([one.macro_f1 if one else None for one in found]), *changes(*pair)]

    def mean(group: GroupMean) -> list[Cell]:
        found = [group.macro_f1.get(name) for name in conditions]
        return [*scores(found), *changes(group.gap, group.gain)]

    gap = change_column("gap", digits=1, interval="shown")
    gain = change_column("gain", digits=1, interval="shown")
    return Table(
        name="summary",
        title="Macro-F1 (%) with intervals",
        caption=(
            f"Macro-F1 (%) over {evaluation.num_episodes:,} episodes with "
            f"{100 * evaluation.settings.confidence:g} % intervals; chance is "
            f"{100 * evaluation.chance:.1f} %. Bold: the best of the row."
        ),
        columns=(
            *model_columns(evaluation),
            *score_columns(conditions, digits=1, interval="shown", details=False),
            *[gap] * with_gap,
            *[gain] * with_gain,
        ),
        rows=(
            *gathered(evaluation, entry, mean),
            chance_row(evaluation, len(conditions), with_gap + with_gain),
        ),
        num_keys=len(model_columns(evaluation)),
        topic="Summary",
    )


def quality_tables(evaluation: Evaluation) -> list[Table]:
    """Outcomes of answers, recalls by emotion, confusions."""
    return [_answers(evaluation), _recalls(evaluation), _confusions(evaluation)]


def _by_condition(evaluation: Evaluation) -> list[ConditionScore]:
    """Scores over all episodes, model by model in the order of the tables."""
    found = [
        evaluation.score(card.model, condition)
        for card in evaluation.models
        for condition in evaluation.conditions
    ]
    return [score for score in found if score is not None]


def _keys(score: ConditionScore) -> tuple[Cell, Cell]:
    return Cell(score.model), Cell(condition_title(score.condition))


def _answers(evaluation: Evaluation) -> Table:
    columns = (
        Column("model", "Model"),
        Column("condition", "Condition"),
        Column("episodes", "Episodes", "count"),
        Column("valid", "Valid", "count", "name an emotion"),
        *[Column(outcome, outcome.capitalize(), "count") for outcome in OUTCOMES],
        Column("macro_f1", "Macro-F1", "percent", "%, all answers", 1, "shown"),
        Column("macro_f1_valid", "Macro-F1", "percent", "%, valid only"),
        Column("accuracy", "Accuracy", "percent", "%, all answers", 1, "shown"),
        Column("latency_ms", "Latency", "milliseconds", "ms, median"),
    )
    rows = [
        Row(
            (
                *_keys(score),
                Cell(score.num_episodes),
                Cell(score.num_valid),
                *[Cell(score.outcomes.get(outcome, 0)) for outcome in OUTCOMES],
                above_chance(score.macro_f1, evaluation.chance),
                number(Estimate(score.macro_f1_valid)),
                number(score.accuracy),
                number(Estimate(score.median_latency_ms), why="g"),
            )
        )
        for score in _by_condition(evaluation)
    ]
    chance = Cell(evaluation.chance)
    counts = [Cell()] * (2 + len(OUTCOMES))
    return Table(
        name="answers",
        title="What the answers were",
        caption=(
            "Answers that name an emotion, and what the others were. All of them count: one that "
            "names no emotion is wrong. Macro-F1 over the valid answers alone stands beside it; a "
            "model that answers only what it is sure of looks better there."
        ),
        columns=columns,
        rows=(
            *rows,
            Row(
                (
                    Cell("Chance (uniform)"),
                    Cell(),
                    *counts,
                    chance,
                    chance,
                    Cell(),
                    Cell(),
                ),
                "reference",
            ),
        ),
        num_keys=2,
        topic=_TOPIC,
    )


def _recalls(evaluation: Evaluation) -> Table:
    rows = [
        Row((*_keys(score), *[number(score.recall.get(emotion)) for emotion in EMOTIONS]))
        for score in _by_condition(evaluation)
    ]
    chance = Row(
        (Cell("Chance (uniform)"), Cell(), *[Cell(1 / len(EMOTIONS))] * len(EMOTIONS)),
        "reference",
    )
    return Table(
        name="recall",
        title="Recall (%) by emotion",
        caption=(
            "Share of the episodes of an emotion that were answered rightly, %. A constant answer "
            "has 100 in one column and 0 in the others."
        ),
        columns=(
            Column("model", "Model"),
            Column("condition", "Condition"),
            *[
                Column(emotion, emotion.capitalize(), "percent", "", 1, "shown")
                for emotion in EMOTIONS
            ],
        ),
        rows=(*rows, chance),
        num_keys=2,
        topic=_TOPIC,
    )


def _confusions(evaluation: Evaluation) -> Table:
    answers = [*EMOTIONS, "other"]
    rows = [
        Row((*_keys(score), Cell(emotion), *[Cell(count) for count in counts]))
        for score in _by_condition(evaluation)
        for emotion, counts in zip(EMOTIONS, score.confusion, strict=True)
    ]
    return Table(
        name="confusions",
        title="What was answered for what",
        caption="Counts of answers (columns) by what was true; other: named no emotion.",
        columns=(
            Column("model", "Model"),
            Column("condition", "Condition"),
            Column("truth", "Truth"),
            *[Column(f"answered_{name}", name.capitalize(), "count") for name in answers],
        ),
        rows=tuple(rows),
        num_keys=3,
        topic=_TOPIC,
    )
