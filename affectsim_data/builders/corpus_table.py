"""What is said of single files of a corpus beside their names: in a table, or in the recipe."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from affectsim_data.builders.corpus_recipe import CorpusRecipe

__all__ = ["FileTable", "read_file_table"]

MAX_TABLE_BYTES = 64 * 2**20


class FileTable:
    """Named groups of files, by path in the corpus, by name, or by name without its suffix."""

    def __init__(self, rows: Mapping[str, Mapping[str, str]], note: str = "") -> None:
        self._rows = rows
        self._used: set[str] = set()
        self.note = note
        """Why there is less than might be, for messages."""

    def groups(self, relative: str) -> Mapping[str, str]:
        """What the table says of the file at a path in the corpus; empty if nothing."""
        name = PurePosixPath(relative)
        for key in (relative, name.name, name.stem):
            if key in self._rows:
                self._used.add(key)
                return self._rows[key]
        return {}

    @property
    def unused(self) -> tuple[str, ...]:
        """Files named in the table that nobody asked for, in its order."""
        return tuple(key for key in self._rows if key not in self._used)


def read_file_table(recipe: CorpusRecipe, source: Path) -> FileTable:
    """The recipe's `[files]`, over the rows of its `table`.

    Args:
        recipe: Says where the table is.
        source: Folder of the corpus.

    Raises:
        FileNotFoundError: The recipe names a table and needs labels, and the table is not there.
        ValueError: A row does not fit; names file and row.
    """
    rows: dict[str, dict[str, str]] = {}
    note = ""
    if recipe.table:
        places = [source / recipe.table, Path(recipe.recipe_path).parent / recipe.table]
        path = next((place for place in places if place.is_file()), None)
        if path is not None:
            rows = _read_rows(path)
        elif recipe.unlabelled == "error":
            raise FileNotFoundError(
                f"{recipe.recipe_path}: expected the table {recipe.table!r} in {source} or beside "
                "the recipe, got nothing there"
            )
        else:
            note = f"there is no {recipe.table} in {source}"
    for key, groups in recipe.files.items():
        if not isinstance(groups, Mapping):
            raise ValueError(
                f"{recipe.recipe_path}: [files] {key!r} must be a table such as "
                f'{{ style = "angry" }}, got {groups!r}'
            )
        rows[key] = {**rows.get(key, {}), **{name: str(value) for name, value in groups.items()}}
    return FileTable(rows, note)


def _read_rows(path: Path) -> dict[str, dict[str, str]]:
    """Groups by file of a CSV or TSV table; empty cells say nothing."""
    if path.stat().st_size > MAX_TABLE_BYTES:
        raise ValueError(f"{path}: expected at most {MAX_TABLE_BYTES} bytes")
    try:
        lines = path.read_bytes().decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: expected UTF-8 text, got byte {error.start} that is none") from (
            error
        )
    delimiter = "\t" if path.suffix.lower() == ".tsv" else ","
    try:
        cells = [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=delimiter)]
    except csv.Error as error:
        raise ValueError(f"{path}: no table: {error}") from error
    columns = cells[0] if cells else []
    if "file" not in columns or len(set(columns)) != len(columns):
        raise ValueError(
            f"{path}: expected a first line of columns that differ, one of them 'file', "
            f"got {columns}"
        )
    rows: dict[str, dict[str, str]] = {}
    for number, row in enumerate(cells[1:], 2):
        if not any(row):
            continue
        if len(row) != len(columns):
            raise ValueError(
                f"{path}: row {number}: expected {len(columns)} cells, got {len(row)}: {row}"
            )
        groups = dict(zip(columns, row, strict=True))
        file = groups.pop("file").replace("\\", "/").removeprefix("./")
        if not file or file in rows:
            what = f"{file!r} twice" if file else "no file"
            raise ValueError(f"{path}: row {number}: expected a file of its own, got {what}")
        rows[file] = {name: value for name, value in groups.items() if value}
    return rows
