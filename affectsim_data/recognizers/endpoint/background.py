"""An event loop beside the caller, so that connections stay open from one batch to the next."""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import threading
from collections.abc import Coroutine
from typing import TypeVar

__all__ = ["BackgroundLoop"]

_Result = TypeVar("_Result")
_PATIENCE_S = 5.0
"""For requests to be broken off."""


class BackgroundLoop:
    """Runs coroutines in a thread of its own; works in notebooks too, which have a loop already."""

    def __init__(self) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, name="endpoint", daemon=True)
        self._thread.start()

    def run(self, work: Coroutine[object, object, _Result]) -> _Result:
        """The result of a coroutine. An interrupt of the caller breaks it off."""
        future = asyncio.run_coroutine_threadsafe(work, self._loop)
        try:
            return future.result()
        except BaseException:
            if future.cancel():
                self._let_tasks_end()
            raise

    @property
    def is_closed(self) -> bool:
        """Whether the thread has ended, or is about to with the process."""
        return self._loop.is_closed() or not self._thread.is_alive()

    def close(self) -> None:
        """Ends the thread."""
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(_PATIENCE_S)

    def _run(self) -> None:
        try:
            self._loop.run_forever()
        finally:
            self._loop.run_until_complete(self._loop.shutdown_asyncgens())
            self._loop.close()

    def _let_tasks_end(self) -> None:
        async def others() -> None:
            tasks = asyncio.all_tasks() - {asyncio.current_task()}
            if tasks:
                await asyncio.wait(tasks, timeout=_PATIENCE_S)

        waiting = asyncio.run_coroutine_threadsafe(others(), self._loop)
        with contextlib.suppress(concurrent.futures.TimeoutError):
            waiting.result(_PATIENCE_S)
