"""The table a run fills, as a file; Parquet also says what the run was."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.evaluation.tables import read_predictions, write_predictions
from affectsim_data.recognizers.journal import Key, RunHeader
from affectsim_data.schemas import SCHEMAS

__all__ = ["SUFFIXES", "check_suffix", "header_of", "read_answers", "write_answers"]

SUFFIXES = (".parquet", ".csv", ".jsonl")
_METADATA = b"affectsim_predictions"


def check_suffix(out: Path) -> None:
    """Raises ValueError unless a table can be written there."""
    if out.suffix.lower() not in SUFFIXES:
        raise ValueError(f"{out}: a prediction table is a file in {', '.join(SUFFIXES)}")
    if out.is_dir():
        raise ValueError(f"{out}: is a folder; name a file in it")


def write_answers(out: Path, header: RunHeader, rows: Sequence[dict[str, Any]]) -> None:
    """The table of a run, whole or not there.

    Args:
        out: Where it goes.
        header: Of the run.
        rows: Its rows, without the column `model`.
    """
    full = [{**row, "model": header.model} for row in rows]
    if out.suffix.lower() != ".parquet":
        write_predictions(full, out)
        return
    told = {_METADATA: json.dumps(header.to_json(), sort_keys=True).encode()}
    schema = SCHEMAS["predictions"].with_metadata(told)
    staging = out.with_name(f".{out.name}.{os.getpid()}.partial")
    try:
        with staging.open("wb") as file:
            pq.write_table(pa.Table.from_pylist(full, schema=schema), file, compression="zstd")
            file.flush()
            os.fsync(file.fileno())
        os.replace(staging, out)
    finally:
        staging.unlink(missing_ok=True)


def header_of(out: Path) -> RunHeader | None:
    """What a table says of the run that made it; `None` if it says nothing.

    Raises:
        ValueError: It cannot be read.
    """
    if out.suffix.lower() != ".parquet":
        return None
    try:
        metadata = pq.read_schema(out).metadata or {}
    except pa.ArrowInvalid as error:
        raise ValueError(f"{out}: is no Parquet file: {error}") from error
    if _METADATA not in metadata:
        return None
    try:
        return RunHeader.from_json(json.loads(metadata[_METADATA]))
    except ValueError as error:
        raise ValueError(f"{out}: metadata {_METADATA.decode()!r}: {error}") from error


def read_answers(out: Path, header: RunHeader) -> dict[Key, dict[str, Any]]:
    """Rows of a table without the column `model`, by episode and condition, in its order.

    Raises:
        ValueError: It cannot be read, or holds answers of another recognizer.
    """
    table = read_predictions([out]).table
    others = sorted(set(table.column("model").to_pylist()) - {header.model})
    if others:
        raise ValueError(
            f"{out}: holds predictions of {others[0]!r}, not of {header.model!r}; choose another "
            "--out, or start anew with --overwrite"
        )
    names = [name for name in SCHEMAS["predictions"].names if name != "model"]
    rows = table.select(names).to_pylist()
    return {(row["episode_id"], row["condition"]): row for row in rows}
