"""What can go wrong with a request, and whom it concerns: the attempt, the clip or the run."""

from __future__ import annotations

import email.utils
import json
import math
import time
from collections.abc import Mapping
from typing import Any, Literal

__all__ = [
    "FILTERED",
    "EndpointStoppedError",
    "RequestFailure",
    "Scope",
    "failure_of_body",
    "failure_of_status",
    "one_line",
    "retry_after_s",
]

Scope = Literal["attempt", "clip", "run"]
"""What is given up: this attempt, this clip, or everything."""

_TRANSIENT = frozenset({408, 409, 425, 429})
_WAYS_OUT = {
    401: "the key is missing or wrong",
    402: "the account has no credit left",
    403: "this key may not use the model",
    404: "no such model, or no such address: most base URLs end in /v1",
    405: "this is no address for chat completions: most base URLs end in /v1",
    413: "the request is too large: send fewer or smaller frames, or a lower JPEG quality",
}
_OF_THE_RUN = frozenset({401, 402, 403, 404, 405})
_OPTIONS = {
    "temperature": "temperature=None leaves it out",
    "seed": "seed=None leaves it out",
    "max_tokens": "token_field='max_completion_tokens' is its other name",
    "max_completion_tokens": "token_field='max_tokens' is its other name",
    "detail": "detail=None leaves it out",
}
"""Our settings that some servers refuse, whatever the clip, and what to do then."""
_FILTERS = frozenset({"content_filter", "content_policy_violation", "moderation_blocked"})
FILTERED = "[cannot answer: refused by the filter of the endpoint]"
"""Stands for an answer that a filter kept back; parsed as a refusal."""
_SHOWN = 300


class EndpointStoppedError(OSError):
    """An endpoint is asked no more; the message says why. Answers so far are kept."""


class RequestFailure(Exception):
    """A request that brought no answer.

    Attributes:
        scope: What is given up.
        rate_limited: Whether all requests should wait, not only this one.
        retry_after_s: How long the server asks to wait.
        is_refusal: Whether a filter declined, which is an answer of a kind.
    """

    def __init__(
        self,
        reason: str,
        *,
        scope: Scope = "attempt",
        rate_limited: bool = False,
        retry_after_s: float | None = None,
        is_refusal: bool = False,
    ) -> None:
        super().__init__(reason)
        self.scope = scope
        self.rate_limited = rate_limited
        self.retry_after_s = retry_after_s
        self.is_refusal = is_refusal


def failure_of_status(status: int, headers: Mapping[str, str], body: bytes) -> RequestFailure:
    """What an answer with another status than 200 means.

    Args:
        status: The status.
        headers: Names in lower case, or of any case that the mapping takes.
        body: As much of it as is worth reading.
    """
    error = _error_of(body)
    said = one_line(_message(error) or body.decode("utf-8", "replace"))
    reason = f"HTTP {status}" + (f": {said}" if said else "")
    if 300 <= status < 400:
        return _redirect(status, headers)
    if status == 429 and error.get("code") == "insufficient_quota":
        return RequestFailure(f"{reason} ({_WAYS_OUT[402]})", scope="run")
    if status in _TRANSIENT or status >= 500:
        wait_s = retry_after_s(headers)
        limited = status == 429 or wait_s is not None
        return RequestFailure(reason, rate_limited=limited, retry_after_s=wait_s)
    if status in (400, 403, 422) and error.get("code") in _FILTERS:
        return RequestFailure(reason, scope="clip", is_refusal=True)
    option = _refused_option(error)
    if option is not None:
        return RequestFailure(f"{reason} ({_OPTIONS[option]})", scope="run")
    if status in _WAYS_OUT:
        reason = f"{reason} ({_WAYS_OUT[status]})"
    return RequestFailure(reason, scope="run" if status in _OF_THE_RUN else "clip")


def failure_of_body(error: Any) -> RequestFailure:
    """What an error means that came with status 200, as routers send them."""
    fields = error if isinstance(error, dict) else {"message": str(error)}
    code = fields.get("code")
    if isinstance(code, int) and 400 <= code < 600:
        return failure_of_status(code, {}, json.dumps({"error": fields}).encode())
    return RequestFailure(f"the server says: {one_line(_message(fields)) or 'error'}")


def retry_after_s(headers: Mapping[str, str], *, now_s: float | None = None) -> float | None:
    """How long a server asks to wait; `None` if it does not, or says it wrongly.

    Args:
        headers: `retry-after-ms`, or `retry-after` in seconds or as a date.
        now_s: Unix time, now if not given.

    Examples:
        >>> retry_after_s({"retry-after": "7"})
        7.0
        >>> retry_after_s({"retry-after": "Thu, 01 Jan 1970 00:01:30 GMT"}, now_s=60.0)
        30.0
    """
    for name, unit_s in (("retry-after-ms", 1e-3), ("retry-after", 1.0)):
        value = headers.get(name, "").strip()
        try:
            wait_s = float(value) * unit_s
        except ValueError:
            continue
        if math.isfinite(wait_s) and wait_s >= 0:
            return wait_s
    try:
        date = email.utils.parsedate_to_datetime(headers.get("retry-after", ""))
        until_s = date.timestamp()
    except (TypeError, ValueError, OverflowError):
        return None
    return max(0.0, until_s - (time.time() if now_s is None else now_s))


def one_line(text: str, *, most: int = _SHOWN) -> str:
    """Text of a server for a message: on one line, printable, not long."""
    shown = "".join(c if c.isprintable() else " " for c in text[: 4 * most])
    shown = " ".join(shown.split())
    return shown if len(shown) <= most else shown[: most - 3] + "..."


def _redirect(status: int, headers: Mapping[str, str]) -> RequestFailure:
    to = one_line(headers.get("location", "").partition("?")[0], most=100)
    return RequestFailure(
        f"HTTP {status}: the server sends us on to {to or 'nowhere'}, which is not followed: "
        "the key is for one address; give that one as the base URL if it is right",
        scope="run",
    )


def _error_of(body: bytes) -> dict[str, Any]:
    """The error object of a body; empty if there is none."""
    try:
        found = json.loads(body)
    except (ValueError, RecursionError):
        return {}
    if isinstance(found, list) and found:
        found = found[0]  # Gemini's endpoint sends a list of one
    if not isinstance(found, dict):
        return {}
    error = found.get("error", found)
    return error if isinstance(error, dict) else {"message": error}


def _message(error: Mapping[str, Any]) -> str:
    found = error.get("message") or error.get("detail") or ""
    return found if isinstance(found, str) else json.dumps(found)


def _refused_option(error: Mapping[str, Any]) -> str | None:
    """The setting of ours that a server says it does not take."""
    param, code = error.get("param"), str(error.get("code"))
    refused = code.startswith("unsupported") or "unsupported" in _message(error).lower()
    return param if refused and isinstance(param, str) and param in _OPTIONS else None
