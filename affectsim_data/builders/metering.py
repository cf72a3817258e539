"""What the stages of a build cost: units, seconds, memory of all its processes."""

from __future__ import annotations

import contextlib
import dataclasses
import os
import threading
import time
from collections.abc import Iterator
from pathlib import Path

__all__ = ["Meter", "StageCost"]

_PERIOD_S = 0.5
_PROC = Path("/proc")


@dataclasses.dataclass(frozen=True)
class StageCost:
    """What one stage cost."""

    name: str
    units: int
    """Made in it."""
    resumed: int
    """Units that an earlier run had made."""
    seconds: float
    peak_bytes: int
    """Most memory in use at once, of this process and its children together; 0 if unknown.

    What several share counts once.
    """

    @property
    def units_per_s(self) -> float:
        """Of the units made."""
        return self.units / max(self.seconds, 1e-9)


class Meter:
    """Measures stages; a context manager that watches the memory while it lasts."""

    def __init__(self) -> None:
        self.costs: list[StageCost] = []
        """Of the stages that are over."""
        self._made = 0
        self._resumed = 0
        self._peak = 0
        self._over = threading.Event()
        self._watch = threading.Thread(target=self._watch_memory, daemon=True)

    def add(self, made: int, resumed: int = 0) -> None:
        """Counts units of the current stage."""
        self._made += made
        self._resumed += resumed

    def count(self, made: int) -> None:
        """Says how many units the stage makes, whatever it was done in."""
        self._made = made

    @contextlib.contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Everything in here belongs to a stage."""
        self._made = self._resumed = 0
        self._peak = used_bytes()
        start = time.perf_counter()
        yield
        seconds = time.perf_counter() - start
        peak = max(self._peak, used_bytes())
        self.costs.append(StageCost(name, self._made, self._resumed, seconds, peak))

    def _watch_memory(self) -> None:
        while not self._over.wait(_PERIOD_S):
            self._peak = max(self._peak, used_bytes())

    def __enter__(self) -> Meter:
        self._watch.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._watch.join()


def used_bytes() -> int:
    """Memory of this process and all below it (proportional set size); 0 where Linux is not."""
    children: dict[int, list[int]] = {}
    for entry in _PROC.iterdir() if _PROC.is_dir() else ():
        if entry.name.isdigit():
            with contextlib.suppress(OSError, ValueError, IndexError):
                # The name, in brackets, may hold anything.
                parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
                children.setdefault(parent, []).append(int(entry.name))
    total, waiting = 0, [os.getpid()]
    while waiting:
        process = waiting.pop()
        waiting += children.get(process, [])
        with contextlib.suppress(OSError, ValueError, IndexError):
            text = (_PROC / str(process) / "smaps_rollup").read_text()
            total += 1024 * int(text.partition("Pss:")[2].split()[0])
    return total
