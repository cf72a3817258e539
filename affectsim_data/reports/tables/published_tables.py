"""The paper's own rows in its layout, quoted: they were measured on other episodes than ours."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

from affectsim_data.evaluation.published import (
    PUBLISHED,
    PUBLISHED_EXECUTION,
    PUBLISHED_SUBSETS,
    PUBLISHED_VALID_RINGS,
    PublishedMean,
    PublishedRow,
    PublishedSubset,
    published_means,
)
from affectsim_data.evaluation.scored import RINGS_M
from affectsim_data.reports.tables.columns import change_column, execution_columns, score_columns
from affectsim_data.reports.tables.model import Cell, Column, Row, Table

__all__ = ["published_tables"]

_TOPIC = "The paper's own rows"
_CONDITIONS = ("p_mon", "p_ref", "p_init", "a_obs")
_CHANCE = 0.2
"""Of uniform guessing among five emotions, about: the paper's test split is nearly balanced."""
_QUOTED = (
    "Quoted from the paper, not to be compared with other tables here: measured on other scenes, "
    "motions and bodies."
)
_MODEL = (Column("model", "Model"), Column("parameters", "Size"))
_ACCESS = {"open": "Open-source (19)", "closed": "Closed-source (5)"}
_SUBSETS = {"all": "Complete test set", "new_observation": "New-observation subset"}


def published_tables() -> list[Table]:
    """Tables 3 to 6 of the paper, with its numbers."""
    return [_main_results(), _new_observations(), _recovery_efficiency(), _execution()]


def _main_results() -> Table:
    below = sum(row.macro_f1["p_init"] < 100 * _CHANCE for row in PUBLISHED)
    ratios = [f"{mean.ogr_of_means:.3f} for the {mean.name}" for mean in published_means()]
    return Table(
        name="published_main_results",
        title="The paper's Macro-F1 (%) by observation condition",
        caption=(
            f"{_QUOTED} Table 3, 3,941 episodes. Chance is that of guessing uniformly, about "
            f"20 %: {below} of the {len(PUBLISHED)} scores under P-Init are below it. Bold: A-Obs "
            "where it is above P-Init."
        ),
        columns=(
            *_MODEL,
            *_without_intervals(score_columns(_CONDITIONS)),
            *_without_intervals([change_column("gain", digits=2, interval="kept")]),
        ),
        rows=(
            *_rows(_scores),
            Row((Cell("Chance (uniform)"), Cell(), *[Cell(_CHANCE)] * 4, Cell()), "reference"),
        ),
        notes=(f"Observation gap recovery of the means: {'; '.join(ratios)}.",),
        num_keys=2,
        topic=_TOPIC,
    )


def _scores(one: PublishedRow | PublishedMean) -> list[Cell]:
    improved = one.macro_f1["a_obs"] > one.macro_f1["p_init"]
    cells = [
        Cell(one.macro_f1[name] / 100, best=improved and name == "a_obs") for name in _CONDITIONS
    ]
    return [*cells, Cell(one.gain / 100)]


def _rows(cells: Callable[[PublishedRow | PublishedMean], list[Cell]]) -> list[Row]:
    """Models by group; the means of the open-source and the closed-source ones behind theirs."""
    opened, closed, everything = published_means()
    rows: list[Row] = []
    for access, mean in (("open", opened), ("closed", closed)):
        group = ""
        for row in PUBLISHED:
            if row.access != access:
                continue
            if row.group != group:
                group = row.group
                rows.append(Row((Cell(group),), "heading"))
            rows.append(Row((Cell(row.model), Cell(row.parameters or None), *cells(row))))
        rows.append(Row((Cell(mean.name), Cell(), *cells(mean)), "mean"))
    return [*rows, Row((Cell(everything.name), Cell(), *cells(everything)), "mean")]


def _without_intervals(columns: Sequence[Column]) -> list[Column]:
    """The paper gives none."""
    return [dataclasses.replace(column, interval="none") for column in columns]


def _new_observations() -> Table:
    def cells(one: PublishedSubset) -> tuple[Cell, ...]:
        return (
            Cell(_ACCESS[one.access]),
            Cell(_SUBSETS[one.subset]),
            Cell(one.num_episodes),
            Cell(one.p_init / 100),
            Cell(one.a_obs / 100, best=True),
            Cell(one.gain / 100, best=True),
        )

    chance = (Cell("Chance (uniform)"), Cell(), Cell(), Cell(_CHANCE), Cell(_CHANCE), Cell())
    return Table(
        name="published_new_observations",
        title="The paper's complete test set and new-observation subset",
        caption=f"{_QUOTED} Table 4: mean Macro-F1 (%).",
        columns=(
            Column("group", "Model group"),
            Column("subset", "Episodes of"),
            Column("episodes", "Episodes", "count"),
            *_without_intervals(score_columns(("p_init", "a_obs"))),
            *_without_intervals([change_column("gain", digits=2, interval="kept")]),
        ),
        rows=(*[Row(cells(one)) for one in PUBLISHED_SUBSETS], Row(chance, "reference")),
        num_keys=2,
        topic=_TOPIC,
    )


def _recovery_efficiency() -> Table:
    def cells(one: PublishedRow | PublishedMean) -> list[Cell]:
        return [Cell(one.recovery_rate / 100), *[Cell(one.e_spl[ring] / 100) for ring in RINGS_M]]

    counts = [f"{count:,} at {ring} m" for ring, count in PUBLISHED_VALID_RINGS.items()]
    return Table(
        name="published_recovery_efficiency",
        title="The paper's recovery rate and E-SPL (%)",
        caption=f"{_QUOTED} Table 5. Episodes with a ring to reach: {', '.join(counts)}.",
        columns=(
            *_MODEL,
            Column("recovery_rate", "Recovery rate", "percent", digits=2),
            *[
                Column(f"e_spl_{ring}m", f"E-SPL @{ring} m", "percent", digits=2)
                for ring in RINGS_M
            ],
        ),
        rows=tuple(_rows(cells)),
        num_keys=2,
        topic=_TOPIC,
    )


def _execution() -> Table:
    one = PUBLISHED_EXECUTION
    return Table(
        name="published_execution",
        title="What the paper's policy did",
        caption=f"{_QUOTED} Table 6.",
        columns=(
            Column("episodes", "Episodes", "count"),
            *_without_intervals(execution_columns("kept")),
        ),
        rows=(
            Row(
                (
                    Cell(one.num_episodes),
                    Cell(one.stable_handoff / 100),
                    Cell(one.mean_path_m),
                    Cell(one.path_before_handoff / 100),
                    Cell(one.budget_exhausted / 100),
                    Cell(one.clipped / 100),
                )
            ),
        ),
        topic=_TOPIC,
    )
