"""Runs a recognizer over a dataset: a prediction table, whatever happens on the way to it."""

from __future__ import annotations

import dataclasses
import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from tqdm import tqdm

from affectsim_data.recognizers.answer_rows import prediction_row, too_long
from affectsim_data.recognizers.clips import (
    ClipBatch,
    Clips,
    clip_batches,
    clip_keys,
    run_header,
)
from affectsim_data.recognizers.journal import Journal, Key, RunHeader, open_journal
from affectsim_data.recognizers.overlapping import BatchReplies, recognized
from affectsim_data.recognizers.prediction_files import (
    check_suffix,
    header_of,
    read_answers,
    write_answers,
)
from affectsim_data.recognizers.protocol import Recognizer
from affectsim_data.releases.journals import journal_path

__all__ = ["PredictionRun", "predict"]

_FAILURES_TOLD = 5


@dataclasses.dataclass(frozen=True)
class PredictionRun:
    """What became of a run."""

    path: Path
    """The table; holds every answer there is, and no row for a clip without one."""
    num_clips: int
    """Clips asked for: episodes times conditions."""
    num_new: int
    """Answered in this run; the rest had been before, or failed."""
    num_failed: int
    """Without an answer: the next run asks for these alone."""
    failures: tuple[str, ...]
    """The first few, each with its episode, condition and reason."""
    elapsed_s: float
    """Time it took."""

    @property
    def is_complete(self) -> bool:
        """Whether every clip has its answer."""
        return self.num_failed == 0


def predict(
    recognizer: Recognizer,
    dataset: Clips,
    out: str | Path,
    *,
    progress: bool = True,
    overwrite: bool = False,
    batch_size: int | None = None,
    num_workers: int = 0,
) -> PredictionRun:
    """Has a recognizer answer every clip of a dataset, and writes its prediction table.

    Every batch of answers is on disk before the next is taken up, in `OUT.partial.jsonl`. The same
    call goes on from there, or from a table that lacks some clips, and draws only what is missing.
    While a recognizer works on a batch, in a thread of its own, the next one is drawn. The table
    has the order of the dataset; two runs differ in `latency_ms` alone.

    Args:
        recognizer: What answers.
        dataset: One `AffectSimDataset`, or several of one release added up, one per condition.
        out: The table: `.parquet`, `.csv` or `.jsonl`.
        progress: Whether to show a bar and say what was found, on stderr.
        overwrite: Whether to forget the answers that are there.
        batch_size: Clips at once; what the recognizer likes if not given.
        num_workers: Processes that draw; 0 for this one.

    Raises:
        ValueError: The answers there are of another recognizer, release, split or clip; the
            recognizer answers what no recognizer may; the dataset is no one table's.
        BlockingIOError: Another process predicts into this table.
    """
    started = time.perf_counter()
    out = Path(out)
    check_suffix(out)
    size = _positive("batch_size", recognizer.batch_size if batch_size is None else batch_size)
    keys, header = clip_keys(dataset), run_header(_name(recognizer), dataset)
    is_table = out.exists() and not journal_path(out).exists()
    if (
        is_table
        and not overwrite
        and set(keys) <= set(_earlier(out, header, dataset, keys, compare=True))
    ):
        return PredictionRun(out, len(keys), 0, 0, (), time.perf_counter() - started)
    with open_journal(out, header, replaces=overwrite) as journal:
        earlier: Mapping[Key, dict[str, Any]] = {}
        if not journal.replaces:
            # A journal with answers was begun when the table had been compared.
            earlier = _earlier(out, header, dataset, keys, compare=not journal.answered)
        run = _Run(out, recognizer.name, keys, {**earlier, **journal.answered}, journal)
        batches = clip_batches(dataset, run.pending, batch_size=size, num_workers=num_workers)
        run.answer(recognized(recognizer, batches), progress=progress)
        if run.answered:
            write_answers(out, header, run.rows_in_order())
        if not run.failures:
            journal.remove()
    return PredictionRun(
        out,
        num_clips=len(keys),
        num_new=run.num_new,
        num_failed=len(run.failures),
        failures=tuple(run.failures[:_FAILURES_TOLD]),
        elapsed_s=time.perf_counter() - started,
    )


class _Run:
    """Answers as they come in."""

    def __init__(
        self,
        out: Path,
        model: str,
        keys: Sequence[Key],
        answered: dict[Key, dict[str, Any]],
        journal: Journal,
    ) -> None:
        self.pending = [row for row, key in enumerate(keys) if key not in answered]
        self.answered = answered
        self.failures: list[str] = []
        self.num_new = 0
        self._out, self._model, self._keys, self._journal = out, model, keys, journal

    def answer(self, batches: Iterable[tuple[ClipBatch, BatchReplies]], *, progress: bool) -> None:
        """Takes in batch after batch; says what is kept if that does not come to its end."""
        total = len(self._keys)
        before = total - len(self.pending)
        if progress and before:
            torn = "; the last batch was half-written, and is asked again" * self._journal.torn
            _say(f"{self._out}: going on; {before:,} of {total:,} are answered{torn}")
        bar = tqdm(total=total, initial=before, desc=self._model, unit="clip", disable=not progress)
        try:
            with bar:
                for batch, answer in batches:
                    self._take(batch, answer)
                    bar.set_postfix(failed=len(self.failures), refresh=False)
                    bar.update(len(batch.keys))
        except BaseException:
            if progress and self._journal.answered:
                _say(
                    f"{self._out}: {before + self.num_new:,} of {total:,} are answered, kept in "
                    f"{self._journal.path.name}; without overwrite the next run goes on from there"
                )
            raise

    def _take(self, batch: ClipBatch, answer: BatchReplies) -> None:
        """Keeps the answers of a batch that are answers."""
        if len(answer.replies) != len(batch.keys):
            raise ValueError(
                f"{self._model}: gave {len(answer.replies)} replies to {len(batch.keys)} clips, "
                f"the first of episode {batch.keys[0][0]!r} under {batch.keys[0][1]}"
            )
        rows = []
        share_ms = answer.elapsed_s * 1000.0 / len(batch.keys)
        for key, reply, frames in zip(batch.keys, answer.replies, batch.frames_sha256, strict=True):
            where = f"{self._model}, episode {key[0]!r} under {key[1]}"
            if (error := reply.error or too_long(reply.raw_text)) is not None:
                self.failures.append(f"{key[0]} under {key[1]}: {error}")
                continue
            latency_ms = share_ms if reply.latency_ms is None else reply.latency_ms
            rows.append(prediction_row(key, reply, frames, latency_ms=latency_ms, where=where))
        self._journal.add(rows)
        self.answered.update(((row["episode_id"], row["condition"]), row) for row in rows)
        self.num_new += len(rows)

    def rows_in_order(self) -> list[dict[str, Any]]:
        """All rows: of the clips asked for in their order, then of those asked for earlier."""
        asked = [self.answered[key] for key in self._keys if key in self.answered]
        wanted = set(self._keys)
        return asked + [row for key, row in self.answered.items() if key not in wanted]


def _earlier(
    out: Path, header: RunHeader, dataset: Clips, keys: Sequence[Key], *, compare: bool
) -> Mapping[Key, dict[str, Any]]:
    """Answers that stand in the table already, made as this run would make them.

    Raises:
        ValueError: They are of another run.
    """
    if not out.exists():
        return {}
    answers = read_answers(out, header)
    if not compare:
        return answers
    found = header_of(out)
    if found is not None:
        header.check(found, file=out)
        return answers
    # No file but Parquet says how its clips were drawn; so one of them is drawn again.
    known = next((row for row, key in enumerate(keys) if key in answers), None)
    if known is not None:
        told = answers[keys[known]]["frames_sha256"]
        drawn = next(clip_batches(dataset, [known], batch_size=1)).frames_sha256[0]
        if told != drawn:
            raise ValueError(
                f"{out}: episode {keys[known][0]!r} under {keys[known][1]} was answered from other "
                f"frames: frames_sha256 is {told}, that of the clip is {drawn}; choose another "
                "--out, or start anew with --overwrite"
            )
    return answers


def _name(recognizer: Recognizer) -> str:
    name = recognizer.name
    if not isinstance(name, str) or not name.strip():
        raise ValueError(f"a recognizer needs a name, which says its configuration, got {name!r}")
    return name


def _positive(name: str, value: int) -> int:
    if not isinstance(value, int) or value < 1:
        raise ValueError(f"{name} must be a number of clips from 1 up, got {value!r}")
    return value


def _say(line: str) -> None:
    tqdm.write(line, file=sys.stderr)
