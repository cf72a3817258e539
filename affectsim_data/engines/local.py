"""Processes of this machine; none outlives whoever started it, however that ends."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Any, TypeVar

__all__ = ["LocalEngine"]

_In = TypeVar("_In")
_Out = TypeVar("_Out")

_AHEAD = 1
"""Items that wait beside those in work: enough that no worker waits for the next."""

_task: Callable[[Any], Any] | None = None


class LocalEngine:
    """A pool of processes, or none: with one job the task is called right here."""

    def __init__(self, jobs: int | None = None, *, preload: str = "") -> None:
        """Starts nothing yet.

        Args:
            jobs: Processes; one per core if not given.
            preload: Module that is imported once for all processes, so that each starts sooner.

        Raises:
            ValueError: Fewer than one.
        """
        self._jobs = (os.cpu_count() or 1) if jobs is None else jobs
        if self._jobs < 1:
            raise ValueError(f"jobs must be at least 1, got {self._jobs}")
        self._preload = [preload] if preload else []
        self._pool: ProcessPoolExecutor | None = None
        self._lifeline: Connection | None = None
        self._pool_task: object = None

    def run(self, task: Callable[[_In], _Out], items: Iterable[_In]) -> Iterator[tuple[int, _Out]]:
        """As `Engine.run` says.

        Raises:
            ChildProcessError: A worker died: killed, or out of memory.
        """
        if self._jobs == 1:
            yield from enumerate(map(task, items))
            return
        pool = self._pool_of(task)
        places: dict[Future[Any], int] = {}
        left = enumerate(items)
        try:
            while True:
                while len(places) < self._jobs + _AHEAD:
                    place, item = next(left, (-1, None))
                    if place < 0:
                        break
                    places[pool.submit(_do_task, item)] = place
                if not places:
                    return
                for future in wait(places, return_when=FIRST_COMPLETED).done:
                    yield places.pop(future), future.result()
        except BrokenProcessPool as error:
            raise ChildProcessError(
                "a worker process died: it was killed, or memory ran out; with fewer --jobs "
                "less of it is needed"
            ) from error

    def _pool_of(self, task: Callable[[Any], Any]) -> ProcessPoolExecutor:
        """A pool whose workers have the task."""
        if self._pool is None or self._pool_task is not task:
            self._end()
            context = multiprocessing.get_context("forkserver")
            context.set_forkserver_preload(self._preload)
            ending, self._lifeline = context.Pipe(duplex=False)
            self._pool_task = task
            self._pool = ProcessPoolExecutor(
                self._jobs, context, initializer=_start_worker, initargs=(task, ending)
            )
        return self._pool

    def _end(self) -> None:
        if self._lifeline is not None:
            self._lifeline.close()
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)
        self._pool, self._lifeline, self._pool_task = None, None, None

    def __enter__(self) -> LocalEngine:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._end()


def _start_worker(task: Callable[[Any], Any], ending: Connection) -> None:
    global _task
    _task = task
    # Ctrl-C reaches the whole group; the parent alone answers it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_die_with, args=(ending,), daemon=True).start()


def _die_with(ending: Connection) -> None:
    """Ends this process when the other end of the pipe is closed, be it by kill -9 of its owner."""
    with contextlib.suppress(EOFError, OSError):
        ending.recv_bytes()
    os._exit(1)


def _do_task(item: Any) -> Any:
    assert _task is not None
    return _task(item)
