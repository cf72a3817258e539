"""One request to an OpenAI-compatible endpoint: sent once, its answer read within bounds."""

from __future__ import annotations

import asyncio
import dataclasses
import hashlib
import importlib
import json
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from affectsim_data.errors import require_extra
from affectsim_data.recognizers.endpoint.addresses import Address
from affectsim_data.recognizers.endpoint.failures import (
    FILTERED,
    RequestFailure,
    failure_of_status,
    one_line,
)
from affectsim_data.recognizers.endpoint.replies import Answer, read_answer

__all__ = ["MAX_RESPONSE_BYTES", "Client", "Detail", "Settings", "TokenField", "check_settings"]

MAX_RESPONSE_BYTES = 4 << 20
"""Of an answer, before it is taken for broken; half a kilobyte is usual."""
_MAX_ERROR_BYTES = 1 << 16
TokenField = Literal["max_tokens", "max_completion_tokens"]
Detail = Literal["auto", "low", "high"]
_OURS = frozenset(
    {"model", "messages", "stream", "n", "temperature", "seed", "max_tokens", "tools"}
    | {"max_completion_tokens"}
)


@dataclasses.dataclass(frozen=True)
class Settings:
    """What is sent with every clip."""

    model: str
    """As the endpoint calls it."""
    temperature: float | None = 0.0
    """`None` leaves it out, for models that take only their own."""
    seed: int | None = 0
    """`None` leaves it out, for endpoints that do not know it."""
    max_tokens: int = 256
    """Of an answer, thinking included."""
    token_field: TokenField = "max_tokens"
    """What the endpoint calls that limit."""
    detail: Detail | None = None
    """How closely OpenAI's models look at a frame; `None` leaves it out."""
    extra_body: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    """More fields of the request, such as `{"reasoning_effort": "low"}`."""

    def body(self, text: str, uris: Sequence[str]) -> dict[str, Any]:
        """The request about one clip: its frames in order, then the question, in one message."""
        options = {
            "temperature": self.temperature,
            "seed": self.seed,
            self.token_field: self.max_tokens,
        }
        return {
            "model": self.model,
            "messages": [{"role": "user", "content": self._content(text, uris)}],
            **{name: value for name, value in options.items() if value is not None},
            **self.extra_body,
        }

    def tags(self) -> list[str]:
        """What is not as usual and changes answers, for the name of the recognizer."""
        usual = Settings(self.model)
        names = ("temperature", "seed", "max_tokens", "detail")
        told = [
            f"{name} {_value_tag(getattr(self, name))}"
            for name in names
            if getattr(self, name) != getattr(usual, name)
        ]
        return [
            *told,
            *(f"{name} {_value_tag(self.extra_body[name])}" for name in sorted(self.extra_body)),
        ]

    def _content(self, text: str, uris: Sequence[str]) -> list[dict[str, Any]]:
        detail = {} if self.detail is None else {"detail": self.detail}
        frames = [{"type": "image_url", "image_url": {"url": uri, **detail}} for uri in uris]
        return [*frames, {"type": "text", "text": text}]


def _value_tag(value: Any) -> str:
    """A value in a name: a word or number as it is, anything longer by its hash."""
    written = value if isinstance(value, str) else json.dumps(value, sort_keys=True)
    if len(written) <= 40 and written.isprintable():
        return written
    return hashlib.sha256(written.encode()).hexdigest()[:8]


def check_settings(settings: Settings) -> None:
    """Raises ValueError unless an endpoint can be asked so."""
    if not settings.model.strip():
        raise ValueError("model must be a name the endpoint knows, got nothing")
    if settings.temperature is not None and not 0 <= settings.temperature <= 2:
        raise ValueError(f"temperature must be 0 to 2 or None, got {settings.temperature}")
    if settings.max_tokens < 1:
        raise ValueError(f"max_tokens must be at least 1, got {settings.max_tokens}")
    try:
        json.dumps(dict(settings.extra_body))
    except (TypeError, ValueError) as error:
        raise ValueError(f"extra_body must be JSON: {error}") from None
    ours = sorted(_OURS & set(settings.extra_body))
    if ours:
        raise ValueError(f"extra_body may not hold {', '.join(ours)}: there are options for that")


class Client:
    """Asks an endpoint, each time once. Belongs to the event loop it is first used in."""

    def __init__(self, address: Address, *, timeout_s: float, connections: int) -> None:
        """No connection is made yet.

        Raises:
            MissingExtraError: The client library is not installed.
        """
        openai = require_extra("openai", extra="vlm")
        self._openai: Any = openai
        self._address = address
        self._timeout_s = timeout_s
        http = openai.DefaultAsyncHttpxClient(
            follow_redirects=False,
            limits=_http_library(openai).Limits(max_connections=connections),
            event_hooks={"response": [_check_status]},
        )
        self._http_error: type[Exception] = _http_library(openai).HTTPError
        self._client = openai.AsyncOpenAI(
            api_key=address.api_key,
            base_url=address.base_url,
            max_retries=0,
            timeout=timeout_s,
            http_client=http,
            # Compressed, a small answer could unfold to any size.
            default_headers={"Accept-Encoding": "identity"},
        )

    async def ask(self, body: Mapping[str, Any]) -> Answer:
        """The answer to one request.

        Raises:
            RequestFailure: There is none; it says why, and whom that concerns.
        """
        try:
            async with asyncio.timeout(self._timeout_s):
                return await self._ask(body)
        except RequestFailure as failure:
            if failure.is_refusal:
                return Answer(FILTERED, is_refusal=True, tokens_in=0, tokens_out=0)
            raise self._shown(failure) from None
        except (TimeoutError, self._openai.APITimeoutError):
            raise RequestFailure(f"no answer within {self._timeout_s:g} s") from None
        except (self._openai.APIConnectionError, self._http_error, OSError) as error:
            raise self._shown(RequestFailure(f"no connection: {_cause(error)}")) from None

    async def _ask(self, body: Mapping[str, Any]) -> Answer:
        completions = self._client.chat.completions.with_streaming_response
        own = {name: body[name] for name in ("model", "messages")}
        rest = {name: value for name, value in body.items() if name not in own}
        async with completions.create(**own, extra_body=rest) as response:
            content = await _read(response, MAX_RESPONSE_BYTES)
            answer = read_answer(content, response.headers.get("content-type", ""))
        return dataclasses.replace(answer, text=self._address.without_key(answer.text))

    def _shown(self, failure: RequestFailure) -> RequestFailure:
        reason = self._address.without_key(str(failure))
        return RequestFailure(
            reason,
            scope=failure.scope,
            rate_limited=failure.rate_limited,
            retry_after_s=failure.retry_after_s,
        )

    async def close(self) -> None:
        """Closes all connections."""
        await self._client.close()


async def _check_status(response: Any) -> None:
    """Raises RequestFailure, having read a little of the body, unless the status is 200.

    As a hook of the HTTP library: the client library would read the body of an error whole.
    """
    if response.status_code == 200:
        return
    body = b""
    async for chunk in response.aiter_bytes():
        body += chunk
        if len(body) > _MAX_ERROR_BYTES:
            break
    raise failure_of_status(response.status_code, response.headers, body[:_MAX_ERROR_BYTES])


async def _read(response: Any, most: int) -> bytes:
    """The body of a response, if it is not longer than it may be."""
    declared = response.headers.get("content-length", "")
    parts, size = [], int(declared) if declared.isdecimal() else 0
    if size <= most:
        size = 0
        async for chunk in response.iter_bytes():
            parts.append(chunk)
            size += len(chunk)
            if size > most:
                break
    if size > most:
        raise RequestFailure(f"the answer is longer than {most >> 20} MB", scope="clip")
    return b"".join(parts)


def _http_library(openai: Any) -> Any:
    """The HTTP library below the client library: httpx, or httpx2 in later versions."""
    bases = openai.DefaultAsyncHttpxClient.__mro__
    found = next(base for base in bases if base.__name__ == "AsyncClient")
    return importlib.import_module(found.__module__.partition(".")[0])


def _cause(error: BaseException) -> str:
    """The innermost reason, which the layers above hide behind "Connection error."."""
    while error.__cause__ is not None:
        error = error.__cause__
    text = one_line(str(error), most=160)
    return f"{type(error).__name__}" + (f" ({text})" if text else "")
