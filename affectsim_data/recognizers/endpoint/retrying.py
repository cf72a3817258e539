"""When a request is made again: waiting, waiting together, and giving up."""

from __future__ import annotations

import asyncio
import dataclasses
import time
from typing import Protocol

import numpy as np

from affectsim_data.recognizers.endpoint.failures import RequestFailure

__all__ = ["Breaker", "Clock", "Gate", "RetryPolicy", "SystemClock"]

_LONGEST_EXPONENT = 30
_SPREAD_S = 0.5
"""Over which requests set out that have waited together."""


class Clock(Protocol):
    """Time, and the passing of it."""

    def now_s(self) -> float:
        """Since some instant in the past; never goes back."""
        ...

    async def sleep(self, duration_s: float) -> None:
        """Returns when that time has passed."""
        ...


class SystemClock:
    """The time of this machine."""

    def now_s(self) -> float:
        """Since the machine started."""
        return time.monotonic()

    async def sleep(self, duration_s: float) -> None:
        """Lets other requests go on meanwhile."""
        await asyncio.sleep(duration_s)


@dataclasses.dataclass(frozen=True)
class RetryPolicy:
    """How often and how long a clip is asked about, and when nothing is asked any more."""

    max_attempts: int = 6
    """Requests about one clip."""
    base_s: float = 1.0
    """Longest wait after the first failure; doubles with each further one."""
    cap_s: float = 60.0
    """Longest wait that we choose; a server may ask for more."""
    deadline_s: float = 900.0
    """From the first request about a clip; no wait ends after that."""
    max_failures: int = 20
    """Clips in a row without an answer, after which the endpoint is taken for broken."""

    def __post_init__(self) -> None:
        if self.max_attempts < 1 or self.max_failures < 1:
            raise ValueError(
                "max_attempts and max_failures must be at least 1, got "
                f"{self.max_attempts} and {self.max_failures}"
            )
        if not (self.base_s >= 0 and self.cap_s >= 0 and self.deadline_s > 0):
            raise ValueError(
                "base_s and cap_s must not be negative and deadline_s must be positive, got "
                f"{self.base_s}, {self.cap_s} and {self.deadline_s}"
            )

    def wait_s(
        self, failure: RequestFailure, *, attempts: int, elapsed_s: float, rng: np.random.Generator
    ) -> float:
        """How long to wait after a failed attempt before the next one.

        Uniform between 0 and `base_s * 2 ** (attempts - 1)`, at most `cap_s`: requests that failed
        together come back apart. What a server asks for comes on top of the shortest of these.

        Args:
            failure: Why the attempt failed.
            attempts: Requests about the clip so far.
            elapsed_s: Since the first of them.
            rng: Draws the wait.

        Raises:
            RequestFailure: There is no next attempt; it says why, and what is given up.
        """
        if failure.scope != "attempt":
            raise failure
        if attempts >= self.max_attempts:
            tried = "once" if attempts == 1 else f"{attempts} times"
            raise RequestFailure(f"{failure}; asked {tried}", scope="clip")
        asked_s = failure.retry_after_s
        if asked_s is not None and asked_s > self.deadline_s:
            raise RequestFailure(
                f"{failure}; the server asks to wait {asked_s:,.0f} s, longer than the "
                f"{self.deadline_s:g} s a clip may take: run again then",
                scope="run",
            )
        longest_s = min(self.cap_s, self.base_s * 2.0 ** min(attempts - 1, _LONGEST_EXPONENT))
        wait_s = float(rng.uniform(0.0, longest_s))
        if asked_s is not None:
            wait_s = asked_s + min(wait_s, self.base_s)
        if elapsed_s + wait_s > self.deadline_s:
            raise RequestFailure(
                f"{failure}; asked {attempts} times in {elapsed_s:.0f} s", scope="clip"
            )
        return wait_s


class Gate:
    """Closed for all requests while the server asks for fewer of them."""

    def __init__(self, clock: Clock, rng: np.random.Generator) -> None:
        self._clock = clock
        self._rng = rng
        self._opens_at_s = -np.inf

    def close_for(self, duration_s: float) -> None:
        """Closes for at least a time from now."""
        self._opens_at_s = max(self._opens_at_s, self._clock.now_s() + duration_s)

    def wait_s(self) -> float:
        """How long to wait before asking again whether it is open; 0 if it is."""
        left_s = float(self._opens_at_s - self._clock.now_s())
        return left_s + float(self._rng.uniform(0.0, _SPREAD_S)) if left_s > 0 else 0.0


class Breaker:
    """Counts clips in a row that got no answer."""

    def __init__(self, max_failures: int) -> None:
        self._max_failures = max_failures
        self._failures = 0

    def succeed(self) -> None:
        """A clip was answered."""
        self._failures = 0

    def fail(self, reason: str) -> str | None:
        """A clip was given up; why nothing should be asked any more, if so."""
        self._failures += 1
        if self._failures < self._max_failures:
            return None
        return f"{self._failures} clips in a row got no answer, the last because: {reason}"
