"""The same task for many items on several processes, with a progress bar; Ctrl-C ends them all."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, TypeVar

from tqdm import tqdm

__all__ = ["run_parallel"]

_In = TypeVar("_In")
_Out = TypeVar("_Out")

_task: Callable[[Any], Any] | None = None


def _set_task(task: Callable[[Any], Any]) -> None:
    global _task
    _task = task
    # Ctrl-C reaches the whole group; the parent alone answers it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _do_task(item: Any) -> Any:
    assert _task is not None
    return _task(item)


def run_parallel(
    task: Callable[[_In], _Out], items: Sequence[_In], jobs: int, what: str, name: str
) -> Iterator[_Out]:
    """Results of a task in the order of the items, with a progress bar.

    Args:
        task: Called in other processes unless `jobs` is 1; must pickle.
        items: What it is called with.
        jobs: Processes.
        what: Kind of items, for the bar.
        name: What is built, for the bar.
    """
    if not items:
        return
    bar: Iterable[_Out]
    label = f"{name}: {what}"
    if jobs == 1 or len(items) < 2:
        yield from tqdm(map(task, items), total=len(items), desc=label)
        return
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["affectsim_data.builders.building"])
    with ProcessPoolExecutor(
        min(jobs, len(items)), context, initializer=_set_task, initargs=(task,)
    ) as pool:
        bar = tqdm(pool.map(_do_task, items), total=len(items), desc=label)
        yield from bar
