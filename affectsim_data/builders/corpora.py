"""Reads a motion corpus the way its recipe says: labels, performers, units and joints are data."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from affectsim_data.builders.corpus_import import (
    FailedFile,
    Imported,
    import_file,
    read_source,
    stature_m,
)
from affectsim_data.builders.corpus_recipe import CorpusRecipe, load_recipe
from affectsim_data.builders.corpus_scan import (
    CorpusFile,
    CorpusScan,
    LeftOut,
    raise_problems,
    scan_corpus,
)
from affectsim_data.builders.pairing import import_clip
from affectsim_data.builders.processes import run_parallel
from affectsim_data.motions.motion import Motion

__all__ = [
    "CorpusFile",
    "CorpusReading",
    "CorpusRecipe",
    "CorpusScan",
    "FailedFile",
    "Imported",
    "LeftOut",
    "import_clip",
    "import_file",
    "load_recipe",
    "read_corpus",
    "read_source",
    "scan_corpus",
    "stature_m",
]

Progress = Callable[[str], None]


@dataclasses.dataclass(frozen=True)
class CorpusReading:
    """What came out of a corpus."""

    recipe: CorpusRecipe
    scan: CorpusScan
    motions: tuple[Motion, ...]
    """In the order of paths; a partner after its target."""
    failures: tuple[FailedFile, ...]
    """Files that were taken but could not be read; of a pair, the target's."""

    def complete(self) -> tuple[Motion, ...]:
        """The motions, if every file could be read.

        Raises:
            ValueError: Some could not: up to 20 of them with their reasons.
        """
        raise_problems(self.recipe.name, [failure.reason for failure in self.failures])
        return self.motions

    def summary(self) -> str:
        """Counts in a line."""
        read, failed = len(self.motions), len(self.failures)
        return f"{self.recipe.name}: {read} motions read, {failed} failed; {self.scan.summary()}"


def read_corpus(
    recipe: Path | str | Mapping[str, Any] | CorpusRecipe,
    source: Path | str,
    *,
    progress: Progress | None = None,
    jobs: int = 1,
) -> CorpusReading:
    """The motions of a corpus, retargeted, at the recipe's rate, closed into cycles.

    A file that cannot be read becomes a `FailedFile` and the others are read all the same; whoever
    calls decides, for instance with `CorpusReading.complete`.

    Args:
        recipe: A recipe, its tables, the path of its TOML file, or its name in `builders/`.
        source: The folder the user downloaded.
        progress: Called with a line per hundred files, and with the counts at the end.
        jobs: Processes.

    Raises:
        FileNotFoundError: The folder is missing, or holds no file of this corpus.
        ValueError: The recipe does not fit the folder: all that is wrong, up to 20 by name.
    """
    if not isinstance(recipe, CorpusRecipe):
        recipe = load_recipe(recipe)
    report = progress or (lambda _: None)
    scan = scan_corpus(recipe, source)
    clips = scan.clips()
    task = functools.partial(_motions_or_failure, recipe)
    results: Iterable[tuple[Motion, ...] | FailedFile] = map(task, clips)
    if jobs > 1:
        results = run_parallel(task, clips, jobs, "files", recipe.name)
    motions: list[Motion] = []
    failures: list[FailedFile] = []
    for number, result in enumerate(results, 1):
        if isinstance(result, FailedFile):
            failures.append(result)
        else:
            motions += result
        if number % 100 == 0:
            report(f"{recipe.name}: {number} of {len(clips)} files")
    reading = CorpusReading(recipe, scan, tuple(motions), tuple(failures))
    report(reading.summary())
    return reading


def _motions_or_failure(
    recipe: CorpusRecipe, files: Sequence[CorpusFile]
) -> tuple[Motion, ...] | FailedFile:
    try:
        return tuple(one.motion for one in import_clip(recipe, files))
    except ValueError as error:
        return FailedFile(files[0].path, files[0].relative, str(error))
