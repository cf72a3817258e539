"""Reads how tables gather and describe models: a CSV of names, groups and sizes."""

from __future__ import annotations

import csv
from pathlib import Path

from affectsim_data.evaluation.results import ModelCard

__all__ = ["read_model_cards"]

_REQUIRED, _OPTIONAL = "model", ("group", "parameters")


def read_model_cards(path: Path) -> dict[str, ModelCard]:
    """Model cards by name, from a CSV file with the columns model, group, parameters.

    Either of the last two may be missing, and cells may be empty.

    Raises:
        ValueError: A column is unknown or missing, a row has no model or too many cells, or a model
            comes twice; says where.
        FileNotFoundError: There is no such file.
    """
    if not path.is_file():
        raise FileNotFoundError(f"{path}: no such file; it should list model, group, parameters")
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            return _cards(csv.DictReader(file, strict=True), path)
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"{path}: is no CSV in UTF-8: {error}") from error


def _cards(reader: csv.DictReader[str], path: Path) -> dict[str, ModelCard]:
    names = reader.fieldnames or []
    wanted = (_REQUIRED, *_OPTIONAL)
    if _REQUIRED not in names or not set(names) <= set(wanted) or len(set(names)) < len(names):
        raise ValueError(
            f"{path}: must have the columns {', '.join(wanted)}, the first at least; "
            f"got {', '.join(map(repr, names)) or 'none'}"
        )
    cards: dict[str, ModelCard] = {}
    for row in reader:
        where = f"{path}, line {reader.line_num}"
        model = row[_REQUIRED]
        if None in row:
            raise ValueError(f"{where}: has more cells than there are columns")
        if not model:
            raise ValueError(f"{where}: names no model")
        if model in cards:
            raise ValueError(f"{where}: model {model!r} is there twice")
        cards[model] = ModelCard(model, row.get("group") or "", row.get("parameters") or "")
    return cards
