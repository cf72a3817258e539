"""Vision-language models behind an OpenAI-compatible endpoint, as a recognizer."""

from __future__ import annotations

import time
import weakref
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any, Self

import numpy as np

from affectsim_data.errors import require_extra
from affectsim_data.loaders import Clip, Sample
from affectsim_data.motions import EMOTIONS, Emotion
from affectsim_data.recognizers.endpoint.addresses import find_address
from affectsim_data.recognizers.endpoint.asking import Asker, Outcome, Request
from affectsim_data.recognizers.endpoint.background import BackgroundLoop
from affectsim_data.recognizers.endpoint.client import (
    Client,
    Detail,
    Settings,
    TokenField,
    check_settings,
)
from affectsim_data.recognizers.endpoint.costs import (
    CostEstimate,
    ImageRule,
    Prices,
    Probe,
    estimate_cost,
)
from affectsim_data.recognizers.endpoint.failures import EndpointStoppedError, RequestFailure
from affectsim_data.recognizers.endpoint.frames import data_uri, encode_frames, frames_of
from affectsim_data.recognizers.endpoint.replies import Answer
from affectsim_data.recognizers.endpoint.retrying import Clock, RetryPolicy, SystemClock
from affectsim_data.recognizers.endpoint.tallies import Tally, Usage
from affectsim_data.recognizers.prompts import answer as reply_of
from affectsim_data.recognizers.prompts import prompt_tag, question
from affectsim_data.recognizers.protocol import Reply

__all__ = ["EndpointRecognizer"]

_BATCHES_PER_SLOT = 4
"""Clips of a batch for each request at a time: a slow answer holds up few others."""
_QUALITY = 90
_FEWEST_TOKENS = 10
"""Of an answer, for the estimate: a word, and what ends it."""


class EndpointRecognizer:
    """Asks any OpenAI-compatible vision endpoint what emotion is seen in clips."""

    def __init__(
        self,
        model: str,
        *,
        base_url: str | None = None,
        api_key: str | None = None,
        api_key_env: str = "OPENAI_API_KEY",
        concurrency: int = 8,
        timeout_s: float = 120.0,
        options: Sequence[Emotion] = EMOTIONS,
        quality: int = _QUALITY,
        max_side: int | None = None,
        detail: Detail | None = None,
        temperature: float | None = 0.0,
        seed: int | None = 0,
        max_tokens: int = 256,
        token_field: TokenField | None = None,
        extra_body: Mapping[str, Any] | None = None,
        prices: Prices | None = None,
        max_cost_usd: float | None = None,
        policy: RetryPolicy | None = None,
        rng: np.random.Generator | None = None,
        clock: Clock | None = None,
    ) -> None:
        """Nothing is sent before `recognize` or `probe` is called.

        Args:
            model: As the endpoint calls it.
            base_url: For example `http://localhost:8000/v1`; if not given, the environment variable
                `OPENAI_BASE_URL`, else OpenAI's own.
            api_key: The key; better left to the environment.
            api_key_env: The environment variable that holds it.
            concurrency: Requests at a time.
            timeout_s: For one answer, from sending to its last byte.
            options: The five emotions in the order of their letters.
            quality: Of JPEG, 1 to 100.
            max_side: Pixels; larger frames are made smaller.
            detail: How closely OpenAI's models look.
            temperature: 0 for the most probable answer; `None` leaves it to the endpoint.
            seed: For endpoints that know it; `None` leaves it out.
            max_tokens: Of an answer, thinking included.
            token_field: What the endpoint calls that limit; if not given, what OpenAI calls it now
                for OpenAI, and the older `max_tokens` for all others.
            extra_body: More fields of the request, such as `{"reasoning_effort": "low"}`.
            prices: What the endpoint charges.
            max_cost_usd: Nothing more is asked once this would be exceeded, by this object.
            policy: When to ask again.
            rng: Draws waiting times, which no answer depends on.
            clock: Time, for tests.

        Raises:
            ValueError: An option is out of range, the URL is none, or a key is missing.
            MissingExtraError: The extra `vlm` is not installed.
        """
        if not 1 <= quality <= 100:
            raise ValueError(f"quality must be 1 to 100, got {quality}")
        if max_side is not None and max_side < 8:
            raise ValueError(f"max_side must be at least 8 pixels, got {max_side}")
        if concurrency < 1 or not timeout_s > 0:
            raise ValueError(
                "concurrency must be at least 1 and timeout_s positive, got "
                f"{concurrency} and {timeout_s}"
            )
        self._address = find_address(base_url, api_key, api_key_env=api_key_env)
        field: TokenField = "max_completion_tokens" if self._address.is_openai else "max_tokens"
        self._settings = Settings(
            model,
            temperature,
            seed,
            max_tokens,
            token_field or field,
            detail,
            dict(extra_body or {}),
        )
        check_settings(self._settings)
        self._options, self._quality, self._max_side = tuple(options), quality, max_side
        self._tag = prompt_tag(self._options)
        self._concurrency, self._timeout_s = concurrency, timeout_s
        self._prices, self._tally = prices, Tally(prices, max_cost_usd)
        self._policy = RetryPolicy() if policy is None else policy
        self._clock = SystemClock() if clock is None else clock
        self._rng = np.random.default_rng() if rng is None else rng
        require_extra("openai", extra="vlm")
        self._work: _Work | None = None

    def __repr__(self) -> str:
        return f"EndpointRecognizer({self.name!r}, base_url={self._address.base_url!r})"

    @property
    def name(self) -> str:
        """`openai:MODEL`, the prompt, and whatever else is not as usual and changes answers."""
        frames = [f"quality {self._quality}"] if self._quality != _QUALITY else []
        if self._max_side is not None:
            frames.append(f"max_side {self._max_side}")
        told = ", ".join([self._tag, *frames, *self._settings.tags()])
        return f"openai:{self._settings.model} ({told})"

    @property
    def batch_size(self) -> int:
        """Clips it likes to be given at once: a few for each request at a time."""
        return _BATCHES_PER_SLOT * self._concurrency

    @property
    def usage(self) -> Usage:
        """What requests have taken so far."""
        return self._tally.usage()

    def request_body(self, sample: Sample) -> dict[str, Any]:
        """What is sent about a clip, as JSON; nothing is sent.

        Raises:
            ValueError: The sample has no frames.
        """
        encoded = encode_frames(frames_of(sample), quality=self._quality, max_side=self._max_side)
        text = question(self._options, num_frames=len(encoded))
        return self._settings.body(text, [data_uri(jpeg) for jpeg in encoded])

    def estimate(
        self,
        num_clips: int,
        sample: Sample,
        *,
        image_rule: ImageRule = "tiles",
        tokens_per_image: int | None = None,
        tokens_per_answer: int = _FEWEST_TOKENS,
        latency_s: float = 3.0,
        probe: Probe | None = None,
    ) -> CostEstimate:
        """What asking about clips like this one should take; nothing is sent. See `estimate_cost`.

        Args:
            num_clips: How many.
            sample: One of them; its frames are encoded to see how large they are.
            image_rule: How the model counts the tokens of a frame.
            tokens_per_image: Their number, where it is known.
            tokens_per_answer: Tokens of thinking and answer.
            latency_s: Time to one answer.
            probe: What one request took, from `probe`.
        """
        encoded = encode_frames(frames_of(sample), quality=self._quality, max_side=self._max_side)
        return estimate_cost(
            num_clips,
            self._clip(sample),
            self._prices,
            concurrency=self._concurrency,
            image_rule=image_rule,
            tokens_per_image=tokens_per_image,
            tokens_per_answer=tokens_per_answer,
            latency_s=latency_s,
            bytes_per_frame=sum(map(len, encoded)) / len(encoded),
            probe=probe,
        )

    def probe(self, sample: Sample) -> Probe:
        """Asks about one clip, once, to learn tokens and latency; the answer is not kept.

        Raises:
            EndpointStoppedError: No answer came.
        """
        body = self.request_body(sample)
        started_s = time.perf_counter()
        try:
            answer = self._working().ask(body)
        except RequestFailure as failure:
            raise EndpointStoppedError(self._where(str(failure))) from None
        return Probe(time.perf_counter() - started_s, answer.tokens_in, answer.tokens_out)

    def recognize(self, samples: Sequence[Sample]) -> list[Reply]:
        """Answers to clips, in their order; a reply with `error` where there is none.

        Raises:
            ValueError: A sample has no frames; nothing was asked then.
            EndpointStoppedError: Nothing is asked any more, because the endpoint refuses all
                requests, fails for clip after clip, or costs too much. Clips of a batch that were
                answered before that are returned, and the next call raises.
        """
        requests = [self._request(sample) for sample in samples]
        try:
            outcomes = self._working().ask_all(requests)
        except EndpointStoppedError as error:
            raise EndpointStoppedError(self._where(str(error))) from None
        return [self._reply(outcome) for outcome in outcomes]

    def close(self) -> None:
        """Closes connections; the next call opens new ones."""
        if self._work is not None:
            self._work.close()
            self._work = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _working(self) -> _Work:
        if self._work is None:
            client = Client(self._address, timeout_s=self._timeout_s, connections=self._concurrency)
            asker = Asker(
                client,
                concurrency=self._concurrency,
                policy=self._policy,
                tally=self._tally,
                clock=self._clock,
                rng=self._rng,
            )
            self._work = _Work(client, asker)
            # Not bound to this object, which could never be freed then.
            weakref.finalize(self, self._work.close)
        return self._work

    def _request(self, sample: Sample) -> Request:
        frames_of(sample)  # raises before anything is sent
        estimate = estimate_cost(1, self._clip(sample), tokens_per_answer=_FEWEST_TOKENS)
        return Request(lambda: self.request_body(sample), (estimate.tokens_in, estimate.tokens_out))

    def _clip(self, sample: Sample) -> Clip:
        num_frames, height, width, _ = frames_of(sample).shape
        longest = max(height, width)
        scale = 1.0 if self._max_side is None else min(1.0, self._max_side / longest)
        return Clip(num_frames, round(width * scale), round(height * scale))

    def _reply(self, outcome: Outcome) -> Reply:
        if outcome.answer is None:
            return Reply(error=outcome.error)
        return reply_of(outcome.answer.text, self._options, latency_ms=outcome.latency_ms)

    def _where(self, reason: str) -> str:
        return f"{self._settings.model} at {self._address.base_url}: {reason}"


class _Work:
    """What is there while requests are made: a thread, its connections, and who asks."""

    def __init__(self, client: Client, asker: Asker) -> None:
        self._client = client
        self._asker = asker
        self._loop = BackgroundLoop()

    def ask(self, body: Mapping[str, Any]) -> Answer:
        return self._loop.run(self._client.ask(body))

    def ask_all(self, requests: Sequence[Request]) -> list[Outcome]:
        return self._loop.run(self._asker.ask_all(requests))

    def close(self) -> None:
        if not self._loop.is_closed:
            self._loop.run(self._client.close())
            self._loop.close()
