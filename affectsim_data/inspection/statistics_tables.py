"""Statistics of episodes as CSV tables."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
from pyarrow import csv

__all__ = ["write_tables"]


def write_tables(summary: Mapping[str, Any], folder: Path) -> list[Path]:
    """Writes a summary as tables of one fact a row, and says which.

    `scale.csv`, `emotions.csv`, `distributions.csv`, `scenes.csv`, and `cells.csv` where a recipe
    fell short.

    Args:
        summary: As of `release_summary`.
        folder: Is there.
    """
    statistics = summary["statistics"]
    tables: dict[str, list[dict[str, Any]]] = {
        "scale": statistics["scale"],
        "emotions": [
            {"grouped_by": grouped_by, "group": group, "emotion": emotion, "episodes": count}
            for grouped_by, groups in statistics["balance"].items()
            for group, counts in groups.items()
            for emotion, count in counts.items()
        ],
        "distributions": [
            {"grouped_by": grouped_by, "group": group, "measure": measure, **spread}
            for grouped_by, groups in statistics["distributions"].items()
            for group, measures in groups.items()
            for measure, spread in measures.items()
        ],
        "scenes": [
            {"scene_id": scene_id, "episodes": count}
            for scene_id, count in summary["episodes"]["scene_id"].items()
        ],
        "cells": summary["cells"]["short"] if summary["cells"] else [],
    }
    written = []
    for name, rows in tables.items():
        if rows:
            csv.write_csv(pa.Table.from_pylist(rows), folder / f"{name}.csv")
            written.append(folder / f"{name}.csv")
    return written
