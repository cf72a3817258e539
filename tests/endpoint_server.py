"""An OpenAI-compatible endpoint on this machine that does as a test says, and keeps what it got.

Clips are told apart by the grey of their first frame, so that answers can be held against clips in
whatever order requests come: `grey_clip(3)` is clip 3 to the server.
"""

from __future__ import annotations

import asyncio
import base64
import contextlib
import dataclasses
import json
import sys
import threading
import time
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, cast

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from affectsim_data.loaders import Sample

__all__ = [
    "Act",
    "Endpoint",
    "FakeClock",
    "Seen",
    "answer",
    "answer_number",
    "boast",
    "completion",
    "drip",
    "echo_key",
    "fail",
    "flood",
    "grey_clip",
    "hang_up",
    "send",
    "serve_endpoint",
    "stall",
]

_GREY_STEP = 5


def grey_clip(number: int, *, num_frames: int = 2, side: int = 16) -> Sample:
    """A clip that the server knows the number of, 0 to 50."""
    video = torch.full((num_frames, 3, side, side), _GREY_STEP * number, dtype=torch.uint8)
    return cast(Sample, {"video": video})


class FakeClock:
    """Time that passes only where somebody sleeps, and then at once."""

    def __init__(self) -> None:
        self.slept_s: list[float] = []
        self._now_s = 1000.0

    def now_s(self) -> float:
        return self._now_s

    async def sleep(self, duration_s: float) -> None:
        self.slept_s.append(duration_s)
        self._now_s += duration_s
        await asyncio.sleep(0)


@dataclasses.dataclass(frozen=True)
class Seen:
    """One request as it came."""

    path: str
    headers: dict[str, str]
    """Names in lower case."""
    body: dict[str, Any]

    @property
    def content(self) -> list[dict[str, Any]]:
        """Parts of the one message."""
        return cast(list[dict[str, Any]], self.body["messages"][0]["content"])

    @property
    def question(self) -> str:
        """The text among them."""
        return str(next(part["text"] for part in self.content if part["type"] == "text"))

    @property
    def frames(self) -> list[NDArray[np.uint8]]:
        """The pictures among them, RGB, in order."""
        urls = [part["image_url"]["url"] for part in self.content if part["type"] == "image_url"]
        return [_decoded(url) for url in urls]

    @property
    def clip(self) -> int:
        """Number of the clip."""
        return round(float(self.frames[0].mean()) / _GREY_STEP)


def _decoded(url: str) -> NDArray[np.uint8]:
    head, _, data = url.partition(",")
    assert head == "data:image/jpeg;base64"
    encoded = np.frombuffer(base64.b64decode(data, validate=True), np.uint8)
    decoded = cv2.imdecode(encoded, cv2.IMREAD_COLOR)
    assert decoded is not None
    return np.asarray(decoded[:, :, ::-1], np.uint8)


def completion(text: str | None = "happy", **changed: Any) -> dict[str, Any]:
    """A completion; `message`, `finish_reason` and `usage` may be changed or, by None, left out."""
    message = changed.pop("message", {"role": "assistant", "content": text})
    choice = {"index": 0, "message": message, "finish_reason": changed.pop("finish_reason", "stop")}
    usage = changed.pop(
        "usage", {"prompt_tokens": 100, "completion_tokens": 2, "total_tokens": 102}
    )
    return {"id": "x", "object": "chat.completion", "choices": [choice], "usage": usage, **changed}


Act = Callable[["_Handler", Seen], None]
"""What to do with one request."""


class Endpoint(ThreadingHTTPServer):
    """The server."""

    daemon_threads = True
    request_queue_size = 64

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.next_acts: list[Act] = []
        """For the next requests, one each."""
        self.acts: dict[int, list[Act]] = {}
        """For the next requests about a clip, by its number."""
        self.usual: Act = answer()
        """For all others."""
        self.seen: list[Seen] = []
        self.in_flight = 0
        self.most_in_flight = 0
        self.released = threading.Event()
        """Ends all stalls, with the test."""
        self._lock = threading.Lock()

    @property
    def url(self) -> str:
        """For `base_url`."""
        return f"http://127.0.0.1:{self.server_address[1]}/v1"

    def asked(self) -> list[int]:
        """Clips that were asked about, repeats included, in no certain order."""
        return sorted(seen.clip for seen in self.seen)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Says nothing of clients that go away."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)

    @contextlib.contextmanager
    def counted(self, seen: Seen) -> Iterator[Act]:
        """What to do with a request, which is in flight meanwhile."""
        with self._lock:
            self.seen.append(seen)
            self.in_flight += 1
            self.most_in_flight = max(self.most_in_flight, self.in_flight)
            if self.next_acts:
                act = self.next_acts.pop(0)
            elif self.acts and self.acts.get(seen.clip):
                act = self.acts[seen.clip].pop(0)
            else:
                act = self.usual
        try:
            yield act
        finally:
            with self._lock:
                self.in_flight -= 1


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True

    @property
    def endpoint(self) -> Endpoint:
        """The server."""
        return cast(Endpoint, self.server)

    def log_message(self, format: str, *args: Any) -> None:
        """Says nothing."""

    def do_GET(self) -> None:
        self._act({})

    def do_POST(self) -> None:
        length = int(self.headers.get("Content-Length", "0"))
        self._act(json.loads(self.rfile.read(length)))

    def _act(self, body: dict[str, Any]) -> None:
        headers = {name.lower(): value for name, value in self.headers.items()}
        seen = Seen(self.path, headers, body)
        with self.endpoint.counted(seen) as act:
            act(self, seen)

    def send(
        self, status: int, content: bytes, headers: dict[str, str], *, cut_to: int | None = None
    ) -> None:
        """Sends an answer; with `cut_to` so many bytes of it, and then goes away."""
        self.send_response(status)
        for name, value in {"Content-Type": "application/json", **headers}.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content if cut_to is None else content[:cut_to])
        if cut_to is not None:
            self.wfile.flush()
            self.close_connection = True


def answer(text: str | None = "happy", *, after_s: float = 0.0, **changed: Any) -> Act:
    """Answers as models do."""

    def act(handler: _Handler, seen: Seen) -> None:
        handler.endpoint.released.wait(after_s)
        handler.send(200, json.dumps(completion(text, **changed)).encode(), {})

    return act


def answer_number() -> Act:
    """Answers with the number of the clip."""

    def act(handler: _Handler, seen: Seen) -> None:
        handler.send(200, json.dumps(completion(f"clip {seen.clip}")).encode(), {})

    return act


def fail(status: int, message: str = "", *, headers: Any = None, **error: Any) -> Act:
    """Answers with an error."""

    def act(handler: _Handler, seen: Seen) -> None:
        body = json.dumps({"error": {"message": message, **error}}).encode()
        handler.send(status, body, dict(headers or {}))

    return act


def send(
    content: bytes, content_type: str = "application/json", *, cut_to: int | None = None
) -> Act:
    """Answers with these bytes, or the first of them."""

    def act(handler: _Handler, seen: Seen) -> None:
        handler.send(200, content, {"Content-Type": content_type}, cut_to=cut_to)

    return act


def boast(size: int) -> Act:
    """Says that so many bytes will come; none do."""

    def act(handler: _Handler, seen: Seen) -> None:
        handler.send_response(200)
        handler.send_header("Content-Length", str(size))
        handler.end_headers()
        handler.endpoint.released.wait(20.0)

    return act


def echo_key(status: int) -> Act:
    """Answers with an error that repeats the key, as some do."""

    def act(handler: _Handler, seen: Seen) -> None:
        message = f"bad key: {seen.headers['authorization']}"
        handler.send(status, json.dumps({"error": {"message": message}}).encode(), {})

    return act


def stall() -> Act:
    """Takes the request and says nothing until the test is over."""

    def act(handler: _Handler, seen: Seen) -> None:
        handler.endpoint.released.wait(20.0)
        handler.close_connection = True

    return act


def hang_up() -> Act:
    """Takes the request and closes the connection."""

    def act(handler: _Handler, seen: Seen) -> None:
        handler.close_connection = True

    return act


def drip(*, every_s: float = 0.02) -> Act:
    """Sends a byte now and then: no single read takes long, and the answer never ends."""

    def act(handler: _Handler, seen: Seen) -> None:
        handler.send_response(200)
        handler.send_header("Content-Length", "100000")
        handler.end_headers()
        while not handler.endpoint.released.is_set():
            handler.wfile.write(b" ")
            time.sleep(every_s)

    return act


def flood(*, status: int = 200, headers: Any = None) -> Act:
    """Sends without an end and without saying how much."""

    def act(handler: _Handler, seen: Seen) -> None:
        handler.send_response(status)
        for name, value in dict(headers or {}).items():
            handler.send_header(name, value)
        handler.send_header("Connection", "close")
        handler.end_headers()
        while not handler.endpoint.released.is_set():
            handler.wfile.write(b" " * (1 << 20))

    return act


@contextlib.contextmanager
def serve_endpoint() -> Iterator[Endpoint]:
    """The server, running."""
    with Endpoint() as endpoint:
        thread = threading.Thread(target=endpoint.serve_forever, args=(0.02,), daemon=True)
        thread.start()
        try:
            yield endpoint
        finally:
            endpoint.released.set()
            endpoint.shutdown()
            thread.join(5.0)
