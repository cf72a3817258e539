"""Recognizes a batch while the next one is drawn."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Future
from threading import Thread

from affectsim_data.recognizers.clips import ClipBatch
from affectsim_data.recognizers.protocol import Recognizer, Reply

__all__ = ["BatchReplies", "recognized"]


@dataclasses.dataclass(frozen=True)
class BatchReplies:
    """What a recognizer said to the clips of a batch."""

    replies: Sequence[Reply]
    """As it gave them, one per clip if all is well."""
    elapsed_s: float
    """Time it took over them."""


def recognized(
    recognizer: Recognizer, batches: Iterable[ClipBatch]
) -> Iterator[tuple[ClipBatch, BatchReplies]]:
    """Answers to batches, in order; the next batch is drawn while one is recognized.

    Drawing stays in the calling thread, which the renderer belongs to.
    """
    source = iter(batches)
    working: tuple[ClipBatch, Future[BatchReplies]] | None = None
    while True:
        try:
            batch = next(source, None)
        except Exception:
            if working is not None:  # a clip that cannot be drawn costs no answer
                yield working[0], working[1].result()
            raise
        if working is not None:
            yield working[0], working[1].result()
        if batch is None:
            return
        working = batch, _in_background(recognizer, batch)


def _in_background(recognizer: Recognizer, batch: ClipBatch) -> Future[BatchReplies]:
    future: Future[BatchReplies] = Future()

    def work() -> None:
        started = time.perf_counter()
        try:
            replies = recognizer.recognize(batch.samples)
            future.set_result(BatchReplies(replies, time.perf_counter() - started))
        except BaseException as error:
            future.set_exception(error)

    # A daemon: who interrupts a run need not wait for a far endpoint to answer.
    Thread(target=work, name="recognizer", daemon=True).start()
    return future
