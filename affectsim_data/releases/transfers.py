"""Does something with many files at once: in threads, with one progress bar, all failures told."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed

from tqdm import tqdm

__all__ = ["Progress", "Work", "failure_list", "transfer"]

Progress = Callable[[int], None]
"""Called with numbers of new bytes."""
Work = Callable[[str, Progress], None]
"""What is done with a file; reports its bytes as they come."""
_HOPELESS = 32
"""Failures in a row after which the rest is not tried: the network or the disk is gone."""
_LISTED = 20


class _StoppedError(BaseException):
    """Ends work under way when the user interrupts; not an Exception, so that nothing retries."""


class _Effort:
    """What all threads share: the bar in bytes, and whether going on makes sense."""

    def __init__(self, total: int, label: str) -> None:
        self._bar = tqdm(total=total, desc=label, unit="B", unit_scale=True)
        self._lock = threading.Lock()
        self._failed_in_a_row = 0
        self.stopped = False

    @property
    def is_hopeless(self) -> bool:
        """Whether so many failed one after the other that the rest would too."""
        return self._failed_in_a_row >= _HOPELESS

    def add(self, count: int) -> None:
        """Counts bytes."""
        if self.stopped:
            raise _StoppedError
        with self._lock:
            self._bar.update(count)

    def ended(self, *, well: bool) -> None:
        """Counts files that failed one after the other."""
        with self._lock:
            self._failed_in_a_row = 0 if well else self._failed_in_a_row + 1

    def close(self) -> None:
        """Leaves the bar as it stands."""
        self._bar.close()


def transfer(
    sizes: Mapping[str, int], work: Work, *, jobs: int, label: str
) -> dict[str, OSError | ValueError]:
    """Does `work` with every file, several at a time; one that fails does not stop the others.

    Args:
        sizes: Bytes of each file, by name.
        work: Called in a thread, with the name and where to report bytes; its `OSError` and
            `ValueError` are kept, any other error is raised here.
        jobs: Files at a time.
        label: What the bar says.

    Returns:
        The errors, by name; files not tried because of 32 failures in a row are among them.

    Raises:
        KeyboardInterrupt: The user's; work under way ends first, what is done stays done.
    """
    if jobs < 1:
        raise ValueError(f"jobs must be at least 1, got {jobs}")
    effort = _Effort(sum(sizes.values()), label)
    pool = ThreadPoolExecutor(min(jobs, max(1, len(sizes))), thread_name_prefix="transfer")
    try:
        futures = {pool.submit(_run, n, size, work, effort): n for n, size in sizes.items()}
        failures: dict[str, OSError | ValueError] = {}
        for future in as_completed(futures):
            try:
                future.result()
            except (OSError, ValueError) as error:
                failures[futures[future]] = error
        return failures
    except BaseException:
        effort.stopped = True
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        effort.close()


def _run(name: str, size: int, work: Work, effort: _Effort) -> None:
    if effort.is_hopeless:
        raise ConnectionError(f"{name}: not tried, as so many before it failed")
    counted = 0

    def progress(count: int) -> None:
        nonlocal counted
        counted += count
        effort.add(count)

    try:
        work(name, progress)
    except Exception:
        effort.ended(well=False)
        effort.add(-counted)
        raise
    effort.ended(well=True)
    # Bytes that were here before are not reported; those fetched twice are, twice.
    effort.add(size - counted)


def failure_list(failures: Mapping[str, Exception]) -> str:
    """The failures as lines of an error message, in the order of the names, at most 20."""
    lines = [str(failures[name]) for name in sorted(failures)]
    more = [f"and {len(lines) - _LISTED} more"] if len(lines) > _LISTED else []
    return "".join(f"\n  {line}" for line in [*lines[:_LISTED], *more])
