"""Work that is done ahead of need, in threads that come and go."""

from __future__ import annotations

import collections
import contextlib
import os
import threading
from collections.abc import Callable, Iterable

__all__ = ["Prefetcher"]

_NUM_THREADS = 16
"""Files are small: most of the time of a request goes by before its first byte."""
_LONGEST_QUEUE = 512


class Prefetcher:
    """Does something with names in the background, in the order they came in, each once.

    What fails there fails again, in the open, when it is asked for. Of more than 512 names waiting
    the oldest are forgotten. Threads start with the first name and end with the last, so that
    nothing is left to stop; a forked child starts with none.
    """

    def __init__(self, work: Callable[[str], object]) -> None:
        self._work = work
        self._reset()

    def _reset(self) -> None:
        self._process = os.getpid()
        self._lock = threading.Lock()
        self._waiting: collections.OrderedDict[str, None] = collections.OrderedDict()
        self._busy: set[str] = set()
        self._num_threads = 0

    def add(self, names: Iterable[str]) -> None:
        """Puts names at the end of the queue, unless they are in it or under way."""
        if self._process != os.getpid():
            self._reset()
        with self._lock:
            self._waiting.update((name, None) for name in names if name not in self._busy)
            while len(self._waiting) > _LONGEST_QUEUE:
                self._waiting.popitem(last=False)
            for _ in range(min(len(self._waiting), _NUM_THREADS) - self._num_threads):
                # No new thread at the end of the interpreter, and then none is needed.
                with contextlib.suppress(RuntimeError):
                    threading.Thread(target=self._run, name="prefetch", daemon=True).start()
                    self._num_threads += 1

    def forget(self, name: str) -> None:
        """Takes a name out of the queue, for somebody is at it himself."""
        if self._process != os.getpid():
            self._reset()
        with self._lock:
            self._waiting.pop(name, None)

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._waiting:
                    self._num_threads -= 1
                    return
                name, _ = self._waiting.popitem(last=False)
                self._busy.add(name)
            # Whoever reads the file meets the error again, where it can be handled.
            with contextlib.suppress(Exception):
                self._work(name)
            with self._lock:
                self._busy.discard(name)
