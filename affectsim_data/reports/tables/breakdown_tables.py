"""Tables within levels of a factor: family, challenge, action, emotion, scene; rings."""

from __future__ import annotations

from affectsim_data.evaluation.results import Breakdown, Evaluation
from affectsim_data.reports.tables.columns import execution_cells, execution_columns, score_columns
from affectsim_data.reports.tables.model import Cell, Column, Row, Table, number

__all__ = ["breakdown_tables", "ring_table"]

_TOPIC = "By kind of episode"
_FACTORS = {
    "family": "family of episodes",
    "challenge": "observation challenge",
    "action": "action",
    "emotion": "emotion",
    "scene_id": "scene",
}
_NAMES = {"scene_id": "scene"}


def breakdown_tables(evaluation: Evaluation) -> list[Table]:
    """A table for each factor there are results for, of scores and of what the policy did."""
    factors = list(dict.fromkeys(one.factor for one in evaluation.breakdowns))
    tables = [_scores(evaluation, factor) for factor in _FACTORS if factor in factors]
    if any(one.factor for one in evaluation.acquisition):
        tables.append(_acquisition(evaluation))
    return tables


def _scores(evaluation: Evaluation, factor: str) -> Table:
    """A row per level and model, a column per condition."""
    found = {
        (one.level, one.model, one.condition): one
        for one in evaluation.breakdowns
        if one.factor == factor
    }
    pairs = [
        (level, card.model)
        for level in dict.fromkeys(level for level, _, _ in found)
        for card in evaluation.models
    ]
    rows = []
    for level, model in pairs:
        ones = [found.get((level, model, condition)) for condition in evaluation.conditions]
        there = next((one for one in ones if one is not None), None)
        if there is not None:
            keys = (Cell(level), Cell(model))
            counts = (Cell(there.num_episodes), Cell(there.num_clusters))
            rows.append(Row((*keys, *counts, *map(_score_cell, ones))))
    is_recall = factor == "emotion"
    name = _NAMES.get(factor, factor)
    return Table(
        name=f"by_{name}",
        title=f"{'Recall' if is_recall else 'Macro-F1'} (%) by {_FACTORS[factor]}",
        caption=_caption(evaluation, is_recall=is_recall),
        columns=(
            Column(name, name.capitalize()),
            Column("model", "Model"),
            Column("episodes", "Episodes", "count"),
            Column("clusters", "Clusters", "count"),
            *score_columns(evaluation.conditions, digits=1, interval="shown", details=False),
        ),
        rows=(*rows, _chance(evaluation, is_recall=is_recall)),
        num_keys=2,
        topic=_TOPIC,
    )


def _caption(evaluation: Evaluation, *, is_recall: bool) -> str:
    if is_recall:
        return "Share of the episodes of an emotion that were answered rightly, %."
    return (
        "Macro-F1 over the emotions there are in the episodes of a row, %. Chance is that of the "
        f"whole table, {100 * evaluation.chance:.1f} %: where emotions are missing or rows are "
        "few it is another, so these cells bear no marks."
    )


def _score_cell(one: Breakdown | None) -> Cell:
    return number(None if one is None else one.macro_f1)


def _chance(evaluation: Evaluation, *, is_recall: bool) -> Row:
    chance = 0.2 if is_recall else evaluation.chance
    keys = (Cell("Chance (uniform)"), Cell(), Cell(), Cell())
    return Row((*keys, *[Cell(chance)] * len(evaluation.conditions)), "reference")


def _acquisition(evaluation: Evaluation) -> Table:
    rows = [
        Row(
            (
                Cell(_NAMES.get(one.factor, one.factor) or "all"),
                Cell(one.level or None),
                Cell(one.num_episodes),
                Cell(one.new_observations),
                *execution_cells(one),
            )
        )
        for one in evaluation.acquisition
    ]
    return Table(
        name="acquisition",
        title="What the policy did, by kind of episode",
        caption=(
            "Handoff and exhausted budget are shares of episodes, the way before the handoff is "
            "a share of all locomotion, clipped moves are a share of attempted translations. New "
            "clips: episodes in which one was collected after the handoff."
        ),
        columns=(
            Column("factor", "Factor"),
            Column("level", "Level"),
            Column("episodes", "Episodes", "count"),
            Column("new_clips", "New clips", "count"),
            *execution_columns("shown"),
        ),
        rows=tuple(rows),
        num_keys=2,
        topic=_TOPIC,
    )


def ring_table(evaluation: Evaluation) -> Table:
    """Which episodes E-SPL is over."""
    return Table(
        name="rings",
        title="Episodes of E-SPL by ring",
        caption=(
            "E-SPL at a distance is over the episodes whose ring around the person can be reached "
            "on the floor; the others are left out and counted."
        ),
        columns=(
            Column("distance_m", "Ring (m)", "count"),
            Column("valid", "Counted", "count"),
            Column("empty", "Ring empty", "count"),
            Column("unreachable", "Out of reach", "count"),
        ),
        rows=tuple(
            Row(
                tuple(
                    map(Cell, (one.distance_m, one.num_valid, one.num_empty, one.num_unreachable))
                )
            )
            for one in evaluation.rings
        ),
        topic="What observation did",
    )
