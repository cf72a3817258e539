"""Asking about many clips at once: bounded, patient, and stopped when it makes no sense."""

from __future__ import annotations

import asyncio
import dataclasses
import logging
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from affectsim_data.recognizers.endpoint.client import Client
from affectsim_data.recognizers.endpoint.failures import EndpointStoppedError, RequestFailure
from affectsim_data.recognizers.endpoint.replies import Answer
from affectsim_data.recognizers.endpoint.retrying import Breaker, Clock, Gate, RetryPolicy
from affectsim_data.recognizers.endpoint.tallies import Tally

__all__ = ["Asker", "Outcome", "Request"]

_log = logging.getLogger(__name__)


@dataclasses.dataclass(frozen=True)
class Request:
    """One clip to ask about."""

    body: Callable[[], Mapping[str, Any]]
    """Makes what is sent, when it is its turn."""
    expected_tokens: tuple[int, int]
    """In and out, as estimated."""


@dataclasses.dataclass(frozen=True)
class Outcome:
    """What became of a clip: an answer, or the reason why there is none."""

    answer: Answer | None = None
    latency_ms: float | None = None
    """Of the request that was answered."""
    error: str | None = None


class Asker:
    """Asks an endpoint about clips until it is told to stop, or has reason to."""

    def __init__(
        self,
        client: Client,
        *,
        concurrency: int,
        policy: RetryPolicy,
        tally: Tally,
        clock: Clock,
        rng: np.random.Generator,
    ) -> None:
        self._client = client
        self._concurrency = concurrency
        self._policy = policy
        self._tally = tally
        self._clock = clock
        self._rng = rng
        self._gate = Gate(clock, rng)
        self._breaker = Breaker(policy.max_failures)
        self._stopped_because = ""
        self._stopped, self._ended = asyncio.Event(), asyncio.Event()

    async def ask_all(self, requests: Sequence[Request]) -> list[Outcome]:
        """What became of each clip, in their order.

        Raises:
            EndpointStoppedError: Nothing is asked any more, and of these clips none was answered.
        """
        slots = asyncio.Semaphore(self._concurrency)

        async def ask_in_turn(request: Request) -> Outcome:
            async with slots:
                return await self._ask(request)

        async with asyncio.TaskGroup() as group:
            tasks = [group.create_task(ask_in_turn(request)) for request in requests]
        outcomes = [task.result() for task in tasks]
        if self._stopped_because and not any(outcome.answer for outcome in outcomes):
            raise EndpointStoppedError(self._stopped_because)
        return outcomes

    async def _ask(self, request: Request) -> Outcome:
        """Asks about one clip as often as the policy allows."""
        started_s, attempts, body = self._clock.now_s(), 0, request.body()
        while (set_aside_usd := await self._admitted(request)) is not None:
            attempts += 1
            if attempts > 1:
                self._tally.count("repeats")
            found = await self._send(body, set_aside_usd)
            if isinstance(found, Outcome):
                self._breaker.succeed()
                return found
            try:
                await self._wait_after(found, attempts, self._clock.now_s() - started_s)
            except RequestFailure as final:
                return self._give_up(final)
        self._tally.count("failed")
        return Outcome(error=f"not asked: {self._stopped_because}")

    async def _send(
        self, body: Mapping[str, Any], set_aside_usd: float
    ) -> Outcome | RequestFailure:
        """One request."""
        sent_s, answer = time.perf_counter(), None
        try:
            answer = await self._client.ask(body)
        except RequestFailure as failure:
            return failure
        finally:
            self._tally.end(set_aside_usd, answer)
            self._ended.set()
        return Outcome(answer, latency_ms=1e3 * (time.perf_counter() - sent_s))

    async def _admitted(self, request: Request) -> float | None:
        """Waits until a request may be made; USD set aside for it, or `None` if it may not be."""
        while await self._may_ask():
            set_aside_usd = self._tally.begin(request.expected_tokens)
            if set_aside_usd is not None:
                return set_aside_usd
            if not self._tally.is_working:
                self._stop(self._tally.out_of_money())
                return None
            # Requests on their way may cost less than was set aside for them.
            self._ended.clear()
            await self._ended.wait()
        return None

    async def _may_ask(self) -> bool:
        """Waits with all others while the server asks for it; whether to ask at all."""
        while not self._stopped_because:
            wait_s = self._gate.wait_s()
            if not wait_s:
                return True
            await self._pause(wait_s)
        return False

    async def _wait_after(self, failure: RequestFailure, attempts: int, elapsed_s: float) -> None:
        """Waits before the next attempt, or raises RequestFailure if there is none."""
        wait_s = self._policy.wait_s(failure, attempts=attempts, elapsed_s=elapsed_s, rng=self._rng)
        _log.info("attempt %d failed, next in %.1f s: %s", attempts, wait_s, failure)
        if failure.rate_limited:
            self._gate.close_for(wait_s)
        else:
            await self._pause(wait_s)

    async def _pause(self, duration_s: float) -> None:
        """Sleeps, or less if asking is stopped meanwhile."""
        sleeping = asyncio.ensure_future(self._clock.sleep(duration_s))
        stopping = asyncio.ensure_future(self._stopped.wait())
        try:
            await asyncio.wait({sleeping, stopping}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            sleeping.cancel()
            stopping.cancel()

    def _give_up(self, failure: RequestFailure) -> Outcome:
        """Notes that a clip has no answer, and stops if that is one too many."""
        self._tally.count("failed")
        because = str(failure)
        if failure.scope == "run":
            self._stop(because)
        elif (broken := self._breaker.fail(because)) is not None:
            self._stop(broken)
        return Outcome(error=because)

    def _stop(self, reason: str) -> None:
        if not self._stopped_because:
            self._stopped_because = reason
            self._stopped.set()
