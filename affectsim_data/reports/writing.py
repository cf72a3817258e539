"""A report as a folder: HTML, Markdown, tables as CSV and LaTeX, figures, all results as JSON."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from affectsim_data import __version__
from affectsim_data.evaluation.results import Evaluation
from affectsim_data.reports.document import report_markdown
from affectsim_data.reports.figures import draw_figures
from affectsim_data.reports.page import Example, page_text
from affectsim_data.reports.tables import csv_table, latex_table, tables_of

__all__ = ["check_report_folder", "write_report"]

_LIST_NAME, _KIND = "report.json", "affectsim report"
"""The list of a report's files, by which it is known."""


def write_report(
    evaluation: Evaluation,
    folder: Path,
    *,
    examples: Sequence[Example] = (),
    overwrite: bool = False,
) -> list[Path]:
    """Writes a report, whole or not at all; the same results give the same bytes.

    Names of files are ours, whatever models are called.

    Args:
        evaluation: What was found.
        folder: Where it goes; made with the folders above it.
        examples: Answers that the page quotes.
        overwrite: Whether it may replace a report that is there.

    Returns:
        The files, `report.html` first.

    Raises:
        FileExistsError: See `check_report_folder`.
        ModuleNotFoundError: matplotlib is not installed.
    """
    folder = folder.expanduser().resolve()
    check_report_folder(folder, overwrite=overwrite)
    files = _files(evaluation, examples)
    hashes = {name: hashlib.sha256(data).hexdigest() for name, data in sorted(files.items())}
    listed = {"kind": _KIND, "code_version": __version__, "files": hashes}
    files[_LIST_NAME] = (json.dumps(listed, indent=2) + "\n").encode()
    _put(folder, files)
    return [folder / name for name in files]


def check_report_folder(folder: Path, *, overwrite: bool) -> None:
    """Whether a report may be written there; asked before the work, and once more after it.

    Raises:
        FileExistsError: There is a report and `overwrite` is not set, or there is something that
            no report wrote, or somebody edited; that is never replaced.
    """
    folder = folder.expanduser().resolve()
    if not folder.exists() or (folder.is_dir() and not any(folder.iterdir())):
        return
    listed = _listed(folder)
    if listed is None:
        raise FileExistsError(f"{folder}: exists and is no report; choose another --out")
    # What is read from the list is only compared; nothing is deleted by its names.
    there = {
        path.relative_to(folder).as_posix(): path
        for path in sorted(folder.rglob("*"))
        if path.is_symlink() or not path.is_dir()
    }
    for name, path in there.items():
        if name != _LIST_NAME and (path.is_symlink() or listed.get(name) != _sha256(path)):
            raise FileExistsError(
                f"{path}: is not as a report left it; move it away, or choose another --out"
            )
    if not overwrite:
        raise FileExistsError(f"{folder}: holds a report already; add --overwrite")


def _listed(folder: Path) -> dict[str, str] | None:
    """Files of the report in a folder by name, with their hashes; `None` if it holds none."""
    try:
        found = json.loads((folder / _LIST_NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    if not isinstance(found, dict) or found.get("kind") != _KIND:
        return None
    files = found.get("files")
    return files if isinstance(files, dict) else None


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _files(evaluation: Evaluation, examples: Sequence[Example]) -> dict[str, bytes]:
    """Everything but the list, by name."""
    tables = tables_of(evaluation)
    figures = draw_figures(evaluation)
    texts = {
        "report.html": page_text(evaluation, tables, figures, examples=examples),
        "report.md": report_markdown(evaluation, tables, figures),
        "evaluation.json": json.dumps(evaluation.to_json(), indent=2, allow_nan=False) + "\n",
        **{f"tables/{table.name}.csv": csv_table(table) for table in tables},
        **{f"tables/{table.name}.tex": latex_table(table) for table in tables},
    }
    files = {name: text.encode() for name, text in texts.items()}
    pictures = {name: data for name, data in figures.items() if name.endswith(".png")}
    return files | {f"figures/{name}": data for name, data in pictures.items()}


def _put(folder: Path, files: Mapping[str, bytes]) -> None:
    """Writes beside the folder and changes places at the end."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    aside = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
    staged, old = aside / "new", aside / "old"
    try:
        for name, data in files.items():
            path = staged / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        if folder.exists():
            os.replace(folder, old)
        try:
            os.replace(staged, folder)
        except BaseException:
            if old.exists():
                os.replace(old, folder)
            raise
    finally:
        shutil.rmtree(aside)
