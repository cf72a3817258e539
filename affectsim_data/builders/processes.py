"""The same task for many items, in order and with a progress bar, on processes of this machine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from tqdm import tqdm

from affectsim_data.engines.local import LocalEngine
from affectsim_data.engines.protocol import in_order

__all__ = ["PRELOADED", "run_parallel"]

PRELOADED = "affectsim_data.builders.stages"
"""What processes that build import before they start."""

_In = TypeVar("_In")
_Out = TypeVar("_Out")


def run_parallel(
    task: Callable[[_In], _Out],
    items: Sequence[_In],
    jobs: int,
    what: str,
    name: str,
) -> Iterator[_Out]:
    """Results of a task in the order of the items, with a progress bar.

    Args:
        task: Called in other processes unless `jobs` is 1; must pickle.
        items: What it is called with.
        jobs: Processes.
        what: Kind of items, for the bar.
        name: What is built, for the bar.
    """
    with LocalEngine(min(jobs, len(items)) or 1, preload=PRELOADED) as engine:
        results = in_order(engine.run(task, items))
        yield from tqdm(results, total=len(items), desc=f"{name}: {what}")
