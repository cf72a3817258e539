"""Prediction tables: read, and checked as far as that goes without a release."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from affectsim_data.evaluation.tables.files import Columns
from affectsim_data.evaluation.tables.problems import Places, Problems, quoted
from affectsim_data.evaluation.tables.reading import (
    ReadTable,
    entries_where,
    read_table_files,
)
from affectsim_data.motions import EMOTIONS

__all__ = ["CONDITIONS", "KEY", "Predictions", "combined_codes", "read_predictions"]

CONDITIONS = ("p_mon", "p_ref", "p_init", "a_obs")
"""Conditions of the protocol, in the order of the paper's tables."""
KEY = ("episode_id", "condition", "model")
"""What no two rows share."""
_COLUMNS = Columns(
    "predictions",
    required=KEY,
    any_of=("raw_text", "label"),
    aliases={"frames_sha": "frames_sha256"},
)
_ALIKE = 0.8
"""Likeness, by difflib, from which a condition is taken for a slip of the pen."""


@dataclasses.dataclass(frozen=True)
class Predictions:
    """Rows of prediction tables that hold together."""

    table: pa.Table
    """Columns of the contract, `SCHEMAS["predictions"]`."""
    places: Places
    """File and row of each."""
    notes: tuple[str, ...] = ()
    """What was passed over."""

    @property
    def models(self) -> tuple[str, ...]:
        """Recognizers, in the order of first appearance."""
        return tuple(pc.unique(self.table.column("model")).to_pylist())

    @property
    def conditions(self) -> tuple[str, ...]:
        """Conditions of the protocol in the paper's order, then others by name."""
        found = set(pc.unique(self.table.column("condition")).to_pylist())
        return (*(one for one in CONDITIONS if one in found), *sorted(found - {*CONDITIONS}))


def read_predictions(paths: Sequence[Path]) -> Predictions:
    """Reads prediction tables, Parquet, CSV or JSONL by suffix, and checks every row.

    Columns that must be there: `episode_id`, `condition`, `model`, and `raw_text` or `label`. The
    hash of the frames may be called `frames_sha256` or `frames_sha`. An empty label is none.

    Raises:
        TableProblems: Something is wrong; lists all of it, over all files, with file and row.
        ValueError: No file is given.
    """
    read = read_table_files(paths, _COLUMNS)
    table, places, problems = read.table, read.places, read.problems
    table = _empty_labels_as_null(table)
    _check_names(table, places, problems)
    _check_answers(table, read)
    _check_numbers(table, places, problems)
    _check_duplicates(table, places, problems)
    problems.raise_if_any()
    return Predictions(table.cast(_COLUMNS.schema), places, read.notes)


def combined_codes(table: pa.Table, names: Sequence[str]) -> NDArray[np.int64]:
    """A number per row that rows share if they agree in these columns, `(num_rows,)`."""
    codes = np.zeros(table.num_rows, np.int64)
    for name in names:
        encoded = table.column(name).dictionary_encode().combine_chunks()
        indices = encoded.indices.fill_null(-1).to_numpy(zero_copy_only=False)
        codes = codes * (len(encoded.dictionary) + 1) + indices + 1
        # Kept small, so that no product of many columns wraps round.
        codes = np.unique(codes, return_inverse=True)[1].astype(np.int64)
    return codes


def _empty_labels_as_null(table: pa.Table) -> pa.Table:
    label = table.column("label")
    is_empty = pc.equal(label, "")
    place = table.schema.get_field_index("label")
    return table.set_column(
        place, "label", pc.if_else(is_empty, pa.scalar(None, pa.string()), label)
    )


def _per_value(
    column: pa.ChunkedArray, wrong: Callable[[str], str]
) -> tuple[NDArray[np.int64], Callable[[int], str]]:
    """Entries whose value `wrong` has a reason against, and that reason by entry."""
    reasons = {
        value: reason
        for value in pc.unique(column.drop_null()).to_pylist()
        if value and (reason := wrong(value))
    }
    entries = entries_where(pc.is_in(column, value_set=pa.array(list(reasons), pa.string())))
    return entries, lambda entry: reasons[column[entry].as_py()]


def _check_names(table: pa.Table, places: Places, problems: Problems) -> None:
    for name in KEY:
        entries, describe = _per_value(table.column(name), _spaces_around)
        problems.add_entries(f"{name} with white space around it", entries, places, describe)
    entries, describe = _per_value(table.column("condition"), _misspelt_condition)
    problems.add_entries("condition is misspelt", entries, places, describe)
    entries, describe = _per_value(table.column("label"), _wrong_label)
    problems.add_entries("label is none of the five emotions", entries, places, describe)


def _spaces_around(value: str) -> str:
    return f"got {quoted(value)}" if value != value.strip() else ""


def _misspelt_condition(value: str) -> str:
    """Why a condition is taken for a slip of the pen; empty if it is one, or the user's own."""
    if value.strip() in CONDITIONS:
        return ""
    letters = "".join(filter(str.isalnum, value.lower()))
    for known in CONDITIONS:
        if letters and letters in (known.replace("_", ""), known[2:]):
            return f"got {quoted(value)}; did you mean {known}?"
    if value.startswith(CONDITIONS):
        return ""  # p_ref_2m: a condition of the user's, named after the one it is like
    near = difflib.get_close_matches(value.lower(), CONDITIONS, n=1, cutoff=_ALIKE)
    if near:
        return (
            f"got {quoted(value)}; did you mean {near[0]}? A condition of your own needs a name "
            "less like it"
        )
    return ""


def _wrong_label(value: str) -> str:
    if value in EMOTIONS:
        return ""
    plain = value.strip().lower()
    if plain in EMOTIONS:
        return f"got {quoted(value)}; write {plain!r}"
    return (
        f"got {quoted(value)}; expected {', '.join(EMOTIONS)} or nothing: put free text into "
        "raw_text"
    )


def _check_answers(table: pa.Table, read: ReadTable) -> None:
    """An empty text is an answer, the empty one; nothing at all is none."""
    neither = pc.and_(pc.is_null(table.column("raw_text")), pc.is_null(table.column("label")))
    entries = np.setdiff1d(entries_where(neither), read.bad_entries("label", "raw_text"))
    read.problems.add_entries(
        "neither label nor raw_text",
        entries,
        read.places,
        lambda _: (
            "expected one of the five emotions as label or the answer as raw_text; if the model "
            'said nothing, raw_text is the empty text (in CSV: "", with the quotes)'
        ),
    )


def _check_numbers(table: pa.Table, places: Places, problems: Problems) -> None:
    latency = table.column("latency_ms")
    values: NDArray[Any] = latency.fill_null(0.0).to_numpy()
    entries = np.flatnonzero(~(np.isfinite(values) & (values >= 0)))
    problems.add_entries(
        "latency_ms is no time",
        entries,
        places,
        lambda entry: f"expected a finite number from 0, or nothing, got {values[entry]:g}",
    )
    scores = table.column("scores").combine_chunks()
    scores = scores if isinstance(scores, pa.Array) else pa.concat_arrays(scores.chunks)
    sizes: NDArray[Any] = (
        pc.list_value_length(scores).fill_null(len(EMOTIONS)).to_numpy(zero_copy_only=False)
    )
    flat: NDArray[Any] = pc.list_flatten(scores).to_numpy(zero_copy_only=False)  # null is NaN
    parents: NDArray[Any] = pc.list_parent_indices(scores).to_numpy(zero_copy_only=False)
    wrong = np.union1d(np.flatnonzero(sizes != len(EMOTIONS)), parents[~np.isfinite(flat)])
    problems.add_entries(
        "scores are not five numbers",
        wrong.astype(np.int64),
        places,
        lambda entry: (
            f"expected a finite number per emotion, {', '.join(EMOTIONS)}, or nothing, "
            f"got {quoted(scores[entry].as_py())}"
        ),
    )


def _check_duplicates(table: pa.Table, places: Places, problems: Problems) -> None:
    whole = np.logical_and.reduce([table.column(name).is_valid().to_numpy() for name in KEY])
    entries = np.flatnonzero(whole)
    codes = combined_codes(table.select(KEY).take(pa.array(entries)), KEY)
    _, first, inverse = np.unique(codes, return_index=True, return_inverse=True)
    earlier = entries[first[inverse]]

    def describe(entry: int) -> str:
        episode, condition, model = (quoted(table.column(name)[entry].as_py()) for name in KEY)
        where = places.name(int(earlier[np.searchsorted(entries, entry)]))
        return f"episode {episode}, condition {condition}, model {model} is already in {where}"

    problems.add_entries("rows there twice", entries[earlier != entries], places, describe)
