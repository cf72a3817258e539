"""The commands that score predictions: `evaluate` and `report`."""

from __future__ import annotations

import contextlib
import dataclasses
import sys
import threading
from collections.abc import Iterator
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

if TYPE_CHECKING:
    from affectsim_data.evaluation.results import Evaluation
    from affectsim_data.evaluation.scored import ScoredTable
    from affectsim_data.evaluation.tables import Predictions

__all__ = ["Scoring", "evaluate", "report"]

_PATIENCE_S = 2.0
"""After which a step says on stderr what it is doing."""


@dataclasses.dataclass(frozen=True)
class Scoring:
    """What is scored, and how."""

    predictions: tyro.conf.Positional[tuple[Path, ...]]
    """Tables of predictions, Parquet, CSV or JSONL."""
    release: str = "mini"
    """mini, a folder, or hf://datasets/ORG/NAME@REVISION."""
    split: Literal["train", "validation", "test"] = "test"
    """Whose episodes were predicted."""
    split_by: str = "group"
    """What no two splits share: group (performers, performances), scene, or both."""
    where: tuple[str, ...] = ()
    """Only episodes of which all this holds: emotion=sad,angry visible_share_init<0.3"""
    trajectories: tuple[Path, ...] = ()
    """What the policy behind a_obs did: tables of trajectories."""
    policy: str | None = None
    """Whose trajectories, if there are several."""
    cluster: Literal["performance", "performer"] = "performance"
    """What intervals and tests take as a whole."""
    allow_missing: bool = False
    """Count episodes without a prediction as wrong instead of refusing the tables."""
    models_file: Path | None = None
    """CSV with columns model, group, parameters: how tables gather and describe models."""
    resamples: int = 2000
    """Draws of the bootstrap, and swaps of the permutation tests."""
    seed: int = 0
    """Of the draws."""


_Scoring = Annotated[Scoring, tyro.conf.arg(name="")]


def evaluate(scoring: _Scoring, *, brief: bool = False, json: bool = False) -> int:
    """Score prediction tables against a release: Macro-F1 by condition, gaps, tests, breakdowns.

    Nothing is scored before every row of the tables is in order: problems are listed with file and
    row, and the status is 1.

    Args:
        scoring: What is scored.
        brief: Print only the main thing.
        json: Print all results as JSON.
    """
    _, _, found = _evaluated(scoring)
    _print(found, brief=brief, json=json)
    return 0


def report(
    scoring: _Scoring, *, out: Path, overwrite: bool = False, full: bool = False, json: bool = False
) -> int:
    """Score prediction tables and write a report: an HTML page, Markdown, tables and figures.

    Tables are CSV and LaTeX, those of the paper in its layout. Needs the extra `plots`.

    Args:
        scoring: What is scored.
        out: Folder of the report.
        overwrite: Replace a report that is there; what no report wrote is never replaced.
        full: Print all tables, as `evaluate` does, not only the main thing.
        json: Print all results as JSON.
    """
    from affectsim_data.reports.quoting import examples_of
    from affectsim_data.reports.writing import check_report_folder, write_report

    check_report_folder(out, overwrite=overwrite)
    predictions, table, found = _evaluated(scoring)
    with _telling("drawing figures, writing tables"):
        examples = examples_of(predictions, table)
        written = write_report(found, out, examples=examples, overwrite=overwrite)
    _print(found, brief=not full, json=json)
    print(f"{written[0]} and {len(written) - 1} more files beside it", file=sys.stderr)
    return 0


def _evaluated(scoring: Scoring) -> tuple[Predictions, ScoredTable, Evaluation]:
    from affectsim_data.evaluation.evaluating import evaluate as evaluate_table
    from affectsim_data.evaluation.tables import (
        read_predictions,
        read_trajectories,
        score_predictions,
    )
    from affectsim_data.releases import open_release
    from affectsim_data.releases.filters import parse_where
    from affectsim_data.releases.joined_splits import as_split_by
    from affectsim_data.reports.model_cards import read_model_cards

    cards = read_model_cards(scoring.models_file) if scoring.models_file else None
    with _telling("reading tables"):
        predictions = read_predictions(scoring.predictions)
        trajectories = read_trajectories(scoring.trajectories) if scoring.trajectories else None
    with _telling(f"joining predictions with {scoring.release}"):
        table = score_predictions(
            predictions,
            open_release(scoring.release),
            split=scoring.split,
            trajectories=trajectories,
            allow_missing=scoring.allow_missing,
            policy=scoring.policy,
            split_by=as_split_by(scoring.split_by),
            filter=parse_where(scoring.where) if scoring.where else None,
        )
    with _telling(f"drawing {scoring.resamples:,} resamples of {table.num_episodes:,} episodes"):
        found = evaluate_table(
            table,
            cluster=scoring.cluster,
            num_resamples=scoring.resamples,
            num_permutations=scoring.resamples,
            seed=scoring.seed,
            model_cards=cards,
        )
    return predictions, table, found


def _print(found: Evaluation, *, brief: bool, json: bool) -> None:
    if json:
        print(dumps(found.to_json(), indent=2, allow_nan=False))
        return
    from rich.console import Console

    from affectsim_data.reports.page import findings
    from affectsim_data.reports.tables import print_tables

    # Numbers are not coloured for being numbers, nor faces drawn for names of emotions.
    console = Console(highlight=False, markup=False, emoji=False, soft_wrap=False)
    print_tables(found, console, findings=findings(found), brief=brief)


@contextlib.contextmanager
def _telling(step: str) -> Iterator[None]:
    """Says on stderr what is being done if it takes more than two seconds."""
    timer = threading.Timer(_PATIENCE_S, print, [f"{step} ..."], {"file": sys.stderr})
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
