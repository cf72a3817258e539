"""What an evaluation with statistics costs: 24 models, 4 conditions, 3,941 episodes, 2,000 draws.

Beside it, in the same run, Macro-F1 alone by other means: the same draws of whole performances
scored by scikit-learn, and the bootstrap of SciPy, which draws single episodes. Both are measured
on a few draws of one model under one condition, multiplied up, and say so.

python -m benchmarks.statistics
"""

from __future__ import annotations

import dataclasses
import json
import resource
import sys
import time
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.parts import Rows, resident_mb, run_part, serve_part

if TYPE_CHECKING:
    from affectsim_data.evaluation.scored import ScoredTable

_MODELS, _DRAWS = 24, 2000
_FEW_DRAWS = 40
"""Draws the others are measured on."""


def statistics() -> Rows:
    """Seconds and megabytes of a whole evaluation, and of Macro-F1 alone by three means."""
    from affectsim_data.evaluation.evaluating import evaluate

    table = _table()
    evaluate(_first_model(table), num_resamples=100, num_permutations=100)  # everything imported
    before = resident_mb()
    rows = [_row("evaluate: all metrics, intervals and tests", lambda: evaluate(table))]
    rows[0]["peak_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3 - before
    times = _MODELS * len(table.conditions) * _DRAWS // _FEW_DRAWS
    rows += [
        _row("Macro-F1 only: its kernels", lambda: _kernels(table)),
        _row("Macro-F1 only: f1_score per draw", lambda: _loop(table), times=times),
        _row("Macro-F1 only: scipy.stats.bootstrap", lambda: _scipy(table), times=times),
    ]
    return rows


def _row(name: str, work: Callable[[], Any], *, times: int = 1) -> dict[str, Any]:
    wall, core = time.perf_counter(), time.process_time()
    work()
    wall, core = time.perf_counter() - wall, time.process_time() - core
    return {
        "what": name,
        "seconds": wall * times,
        "core_seconds": core * times,
        "peak_mb": "",
        "measured_on": "all of it" if times == 1 else f"1 / {times:,} of it",
    }


def _table() -> ScoredTable:
    from affectsim_data.evaluation.simulating import PAPER_SKILLS, paper_plan, simulated_table

    skills = {f"model_{n}": PAPER_SKILLS["open" if n < 19 else "closed"] for n in range(_MODELS)}
    return simulated_table(paper_plan(), skills, np.random.default_rng(0))


def _first_model(table: ScoredTable) -> ScoredTable:
    return dataclasses.replace(
        table,
        models=table.models[:1],
        answers=table.answers[:1],
        was_run=table.was_run[:1],
        latency_ms=table.latency_ms[:1],
    )


def _kernels(table: ScoredTable) -> None:
    """Macro-F1 of every model and condition in every draw."""
    from affectsim_data.evaluation.bootstrap import resampled, resampling_weights
    from affectsim_data.evaluation.confusion import confusion_codes, macro_f1_scores

    num_clusters = int(table.performances.max()) + 1
    weights = resampling_weights(num_clusters, num_resamples=_DRAWS, seed=0)
    for answers in table.answers:
        codes = confusion_codes(table.truth, answers)
        rows = (np.arange(len(codes))[:, None] * 30 + codes) * num_clusters + table.performances
        sums = np.bincount(rows.ravel(), minlength=len(codes) * 30 * num_clusters)
        shape = (len(codes), 5, 6, num_clusters)
        macro_f1_scores(resampled(sums.reshape(shape).astype(np.float64), weights))


def _loop(table: ScoredTable) -> None:
    """Macro-F1 of the first model and condition, episodes of each draw put together again."""
    from sklearn.metrics import f1_score

    rng = np.random.default_rng(0)
    num_clusters = int(table.performances.max()) + 1
    members = [np.flatnonzero(table.performances == code) for code in range(num_clusters)]
    for _ in range(_FEW_DRAWS):
        drawn = rng.integers(0, num_clusters, num_clusters)
        episodes = np.concatenate([members[code] for code in drawn])
        f1_score(
            table.truth[episodes],
            table.answers[0, 0, episodes],
            labels=range(5),
            average="macro",
            zero_division=0,
        )


def _scipy(table: ScoredTable) -> None:
    """The same number of draws of single episodes."""
    from scipy import stats
    from sklearn.metrics import f1_score

    def score(truth: Any, answers: Any) -> Any:
        return f1_score(truth, answers, labels=range(5), average="macro", zero_division=0)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that so few draws are few
        stats.bootstrap(
            (table.truth, table.answers[0, 0]),
            score,
            n_resamples=_FEW_DRAWS,
            paired=True,
            vectorized=False,
            method="percentile",
            rng=np.random.default_rng(0),
        )


PARTS = {"statistics": statistics}

if __name__ == "__main__":
    if len(sys.argv) > 1:
        serve_part(PARTS)
    else:
        print(json.dumps(run_part("benchmarks.statistics", "statistics", cores=2), indent=2))
