"""Predictions in, numbers out: parsing of answers, metrics, statistics.

The metrics need NumPy only; what reads tables and evaluates them loads on first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from affectsim_data.evaluation.metrics import (
    active_gain,
    confusion_matrix,
    emotion_spl,
    macro_f1,
    observation_gap_recovery,
    path_efficiency,
    per_class_recall,
    recovery_rate,
)
from affectsim_data.evaluation.results import Estimate, Evaluation
from affectsim_data.evaluation.scored import ScoredTable

if TYPE_CHECKING:
    from affectsim_data.evaluation.answers import parse_answer
    from affectsim_data.evaluation.evaluating import evaluate
    from affectsim_data.evaluation.tables import (
        TableProblems,
        read_predictions,
        read_trajectories,
        score_predictions,
        write_predictions,
    )

__all__ = [
    "Estimate",
    "Evaluation",
    "ScoredTable",
    "TableProblems",
    "active_gain",
    "confusion_matrix",
    "emotion_spl",
    "evaluate",
    "macro_f1",
    "observation_gap_recovery",
    "parse_answer",
    "path_efficiency",
    "per_class_recall",
    "read_predictions",
    "read_trajectories",
    "recovery_rate",
    "score_predictions",
    "write_predictions",
]

_HOME_OF = {
    "TableProblems": "tables",
    "evaluate": "evaluating",
    "parse_answer": "answers",
    "read_predictions": "tables",
    "read_trajectories": "tables",
    "score_predictions": "tables",
    "write_predictions": "tables",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'affectsim_data.evaluation' has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME_OF[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
