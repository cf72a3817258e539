"""Worker processes that end when the process that started them does, however that ends."""

from __future__ import annotations

import multiprocessing
import os
import threading
from collections.abc import Callable
from multiprocessing.connection import wait

__all__ = ["WorkerStart"]


class WorkerStart:
    """A DataLoader's `worker_init_fn`: has the worker leave with its parent, then runs the user's.

    PyTorch's workers notice that their parent is gone by the process that adopts them. Those of a
    forkserver are its children, and it stays for as long as they do: after a `kill -9` of a
    training run both would wait for ever.
    """

    def __init__(self, user_init: Callable[[int], None] | None = None) -> None:
        self._user_init = user_init

    def __call__(self, worker_id: int) -> None:
        """Called in the worker before its first sample."""
        parent = multiprocessing.parent_process()
        if parent is not None:
            threading.Thread(target=_leave_with, args=(parent.sentinel,), daemon=True).start()
        if self._user_init is not None:
            self._user_init(worker_id)


def _leave_with(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)
