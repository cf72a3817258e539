"""Bytes of Hub files: resumed when cut, waited for when the Hub is busy, never more than asked."""

from __future__ import annotations

import contextlib
import re
import time
from collections.abc import Callable, Generator, Iterator
from typing import Any, TypeVar

from affectsim_data.releases.fork_gate import inside

__all__ = ["hub_headers", "is_offline", "stream", "with_retries"]

_Answer = TypeVar("_Answer")
_BUSY = {408, 429, 500, 502, 503, 504}
_RETRIES = 5
_LONGEST_PAUSE_S = 8.0
_LONGEST_REQUESTED_PAUSE_S = 300.0
_PROGRESS_BYTES = 1 << 16
"""After as many new bytes, a connection that is cut again counts as cut for the first time."""
_USED_UP = re.compile(r";\s*r\s*=\s*0\s*;\s*t\s*=\s*(\d+)", re.ASCII)
"""In `RateLimit` of the Hub: no requests left, and the seconds until there are."""
_CONTENT_RANGE = re.compile(r"bytes (\d+)-\d+/(?:\d+|\*)")


def is_offline() -> bool:
    """Whether `HF_HUB_OFFLINE` forbids every network call."""
    from huggingface_hub import constants

    return bool(constants.HF_HUB_OFFLINE)


def hub_headers() -> dict[str, str]:
    """What every request says: the user's token if there is one, and no compression.

    The client takes the token off a request that is redirected to another host.
    """
    from huggingface_hub.utils import build_hf_headers  # type: ignore[attr-defined]  # lazy

    headers: dict[str, str] = build_hf_headers(library_name="affectsim-data")
    return {**headers, "Accept-Encoding": "identity"}


class _Attempts:
    """How often something may fail that may well work the next time."""

    def __init__(self, retries: int) -> None:
        self._retries = self._left = retries
        self._pause_s = 1.0

    def renew(self) -> None:
        """Starts counting anew, for something has been achieved."""
        self._left, self._pause_s = self._retries, 1.0

    def wait(self, error: Exception) -> None:
        """Waits until it makes sense to try again.

        Raises:
            Exception: The error itself, if trying again is of no use.
        """
        response = getattr(error, "response", None)
        final = response is not None and response.status_code not in _BUSY
        if final or not self._left:
            raise error
        self._left -= 1
        requested = _retry_after(response)
        time.sleep(self._pause_s if requested is None else requested)
        self._pause_s = min(2.0 * self._pause_s, _LONGEST_PAUSE_S)


def _retry_after(response: Any) -> float | None:
    """Seconds a busy Hub asks us to stay away."""
    if response is None:
        return None
    match = _USED_UP.search(response.headers.get("RateLimit", ""))
    text = match[1] if match else response.headers.get("Retry-After", "").strip()
    return min(float(text), _LONGEST_REQUESTED_PAUSE_S) if text.isdecimal() else None


def with_retries(ask: Callable[[], _Answer], *, retries: int = _RETRIES) -> _Answer:
    """What a request answers, repeated while the Hub is busy or the connection fails."""
    attempts = _Attempts(retries)
    while True:
        try:
            with inside():
                return ask()
        except Exception as error:  # what the client's transport raises differs by its version
            attempts.wait(error)


def stream(url: str, start: int, most: int, *, retries: int = _RETRIES) -> Iterator[bytes]:
    """The bytes of a file from `start` to its end, or to just behind the first `most`.

    A connection that is cut is resumed where it broke, whether the server knows ranges or not.

    Args:
        url: Of the file.
        start: Bytes left out at its front.
        most: Bytes the file may have in all; what comes beyond tells that it has more.
        retries: Failures in a row that are borne.
    """
    attempts, place, renewed_at, ranges = _Attempts(retries), start, start, True
    while True:
        try:
            with contextlib.closing(_answer(url, place, ranges=ranges)) as chunks:
                for chunk in chunks:
                    place += len(chunk)
                    if place - renewed_at >= _PROGRESS_BYTES:
                        renewed_at = place
                        attempts.renew()
                    yield chunk
                    if place > most:
                        break
            return
        except _RangeIgnoredError:
            ranges = False
        except Exception as error:
            attempts.wait(error)


class _RangeIgnoredError(Exception):
    """The server does not send the range that was asked for."""


def _answer(url: str, place: int, *, ranges: bool) -> Generator[bytes]:
    """The bytes of a file from a place on, as one connection gives them."""
    from huggingface_hub import constants, get_session, hf_raise_for_status

    asked = place if ranges else 0
    options: dict[str, Any] = {
        "headers": {**hub_headers(), **({"Range": f"bytes={asked}-"} if asked else {})},
        "follow_redirects": True,
        "timeout": constants.HF_HUB_DOWNLOAD_TIMEOUT,
    }
    connection = contextlib.ExitStack()
    try:
        with inside():
            response = connection.enter_context(get_session().stream("GET", url, **options))
            begins = _first_byte(response)
            if asked and begins not in (0, asked):
                raise _RangeIgnoredError
            hf_raise_for_status(response)
            if begins != 0 and not asked:
                raise ConnectionError(f"{url}: the server sends a range nobody asked for")
        left_out, chunks = place - (begins or 0), response.iter_raw()
        while True:
            with inside():
                chunk = next(chunks, b"")
            if not chunk:
                return
            if left_out < len(chunk):
                yield chunk[left_out:]
            left_out = max(left_out - len(chunk), 0)
    finally:
        with inside():
            connection.close()


def _first_byte(response: Any) -> int | None:
    """Place in the file of the first byte of an answer; `None` if the answer is not usable."""
    if response.status_code == 206:
        match = _CONTENT_RANGE.fullmatch(response.headers.get("Content-Range", ""))
        return int(match[1]) if match else None
    return None if response.status_code == 416 else 0
