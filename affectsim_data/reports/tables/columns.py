"""Columns that several tables have: Macro-F1 by condition, emotions, what a policy did."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from affectsim_data.evaluation.results import AcquisitionSummary
from affectsim_data.reports.tables.model import Cell, Column, number
from affectsim_data.reports.tables.texts import MINUS, condition_title

__all__ = ["change_column", "execution_cells", "execution_columns", "score_columns"]

_VIEWS = {
    "p_mon": "Monitor view",
    "p_ref": "Reference view",
    "p_init": "Initial view",
    "a_obs": "Active view",
}
_CHANGES = {
    "gap": ("p_ref", "Gap"),
    "monitor_gap": ("p_mon", "Monitor gap"),
    "gain": ("a_obs", "Gain"),
}


def score_columns(
    conditions: Iterable[str],
    *,
    digits: int = 2,
    interval: Literal["kept", "shown"] = "kept",
    details: bool = True,
) -> list[Column]:
    """A column of shares per condition, Macro-F1 or recall.

    Names of columns are ours: conditions of the user's are numbered.
    """
    return [
        Column(
            name=condition if condition in _VIEWS else f"condition_{place + 1}",
            title=condition_title(condition),
            kind="percent",
            detail=_VIEWS.get(condition, "") if details else "",
            digits=digits,
            interval=interval,
            from_data=condition not in _VIEWS,
        )
        for place, condition in enumerate(conditions)
    ]


def change_column(
    change: Literal["gap", "monitor_gap", "gain"],
    *,
    digits: int,
    interval: Literal["kept", "shown"],
) -> Column:
    """A column of differences to p_init, in percentage points."""
    condition, title = _CHANGES[change]
    detail = f"{condition_title(condition)} {MINUS}\N{NO-BREAK SPACE}P-Init"
    return Column(change, f"{title}\N{NO-BREAK SPACE}(pp)", "points", detail, digits, interval)


def execution_columns(interval: Literal["kept", "shown"]) -> list[Column]:
    """Columns of what a policy did, in the order of the paper's Table 6."""
    return [
        Column("stable_handoff", "Stable handoff", "percent", "% episodes", 2, interval),
        Column("mean_path_m", "Mean path", "metres", "m/episode", 2, interval),
        Column("path_before_handoff", "Path before handoff", "percent", "% way", 1, interval),
        Column("budget_exhausted", "Budget exhausted", "percent", "% episodes", 2, interval),
        Column("clipped", "Clipped moves", "percent", "% attempts", 2, interval),
    ]


def execution_cells(one: AcquisitionSummary) -> list[Cell]:
    """The cells of `execution_columns`."""
    return [
        number(one.stable_handoff),
        number(one.mean_path_m),
        number(one.path_before_handoff),
        number(one.budget_exhausted),
        number(one.clipped),
    ]
