"""A Hugging Face Hub for one dataset, on this machine: what `hf_hub_download` asks of the real one.

It answers HEAD and GET of `/datasets/ORG/NAME/resolve/REVISION/PATH` with the headers the client
relies on (`X-Repo-Commit`, `ETag`, `X-Linked-Size`, `X-Error-Code`), logs what it was asked, and
misbehaves on demand.
"""

from __future__ import annotations

import contextlib
import hashlib
import socket
import threading
from collections.abc import Iterator, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, cast
from urllib.parse import unquote

__all__ = ["COMMIT", "REPO_ID", "Hub", "HubHandler", "serve_hub"]

REPO_ID = "affectsim/small"
COMMIT = "0123456789abcdef0123456789abcdef01234567"
_OLD_COMMIT = "89abcdef0123456789abcdef0123456789abcdef"


class Hub(ThreadingHTTPServer):
    """The server and what it serves."""

    daemon_threads = True

    def __init__(self, root: Path, handler: type[BaseHTTPRequestHandler] | None = None) -> None:
        super().__init__(("127.0.0.1", 0), handler or HubHandler)
        self.root = root
        self.revisions: dict[str, str] = {"main": COMMIT, "v1": COMMIT, "v0": _OLD_COMMIT}
        """Commit by branch, tag or commit."""
        self.replaced: dict[str, list[bytes]] = {}
        """What to send instead of a file, by path: one after the other, the last for ever."""
        self.cut_short: set[str] = set()
        """Files of which half is sent, after which the server is gone."""
        self.requests: list[tuple[str, str, str]] = []
        """Method, revision and path of each request."""
        self._connections: list[socket.socket] = []

    def get_request(self) -> tuple[socket.socket, Any]:
        """Keeps hold of connections, so that they can be broken."""
        connection, address = super().get_request()
        self._connections.append(connection)
        return connection, address

    def leave(self) -> None:
        """Goes away as a machine does that is switched off."""
        self.shutdown()
        self.server_close()
        for connection in self._connections:
            with contextlib.suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)

    @property
    def url(self) -> str:
        """For `HF_ENDPOINT`."""
        return f"http://127.0.0.1:{self.server_address[1]}"

    def fetched(self) -> list[str]:
        """Paths asked for by GET, in order."""
        return [path for method, _, path in self.requests if method == "GET"]

    def payload(self, path: str, *, consume: bool) -> bytes | None:
        """What to send for a path; `None` if there is no such file."""
        planned = self.replaced.get(path)
        if planned:
            return planned.pop(0) if consume and len(planned) > 1 else planned[0]
        file = self.root / path
        return file.read_bytes() if file.is_file() else None


class HubHandler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, format: str, *args: Any) -> None:
        """Says nothing: requests are in the log of the hub."""

    def do_HEAD(self) -> None:
        self._answer(send_body=False)

    def do_GET(self) -> None:
        self._answer(send_body=True)

    def _answer(self, *, send_body: bool) -> None:
        hub = cast(Hub, self.server)
        prefix = f"/datasets/{REPO_ID}/resolve/"
        if not self.path.startswith(prefix):
            self._refuse("RepoNotFound", 401 if "/resolve/" in self.path else 404)
            return
        revision, _, path = self.path.removeprefix(prefix).partition("/")
        revision, path = unquote(revision), unquote(path)
        hub.requests.append((self.command, revision, path))
        commit = hub.revisions.get(revision, revision if revision == COMMIT else None)
        if commit is None:
            self._refuse("RevisionNotFound", 404)
            return
        payload = hub.payload(path, consume=send_body)
        if payload is None:
            self._refuse("EntryNotFound", 404, {"X-Repo-Commit": commit})
            return
        # Of what the file should be: on the Hub it belongs to the commit, not to what is sent.
        etag = hashlib.sha256((hub.root / path).read_bytes()).hexdigest()
        self.send_response(200)
        self.send_header("X-Repo-Commit", commit)
        self.send_header("X-Linked-Size", str(len(payload)))
        self.send_header("X-Linked-ETag", f'"{etag}"')
        self.send_header("ETag", f'"{etag}"')
        self.send_header("Content-Length", str(len(payload)))
        self.end_headers()
        if send_body and path in hub.cut_short:
            self.wfile.write(payload[: len(payload) // 2])
            self.wfile.flush()
            self.close_connection = True
            hub.leave()
        elif send_body:
            self.wfile.write(payload)

    def _refuse(self, code: str, status: int, headers: Mapping[str, str] | None = None) -> None:
        self.send_response(status)
        for name, value in {"X-Error-Code": code, **(headers or {})}.items():
            self.send_header(name, value)
        self.send_header("Content-Length", "0")
        self.end_headers()


@contextlib.contextmanager
def serve_hub(root: Path) -> Iterator[Hub]:
    """Serves a folder as the one dataset of a Hub."""
    hub = Hub(root)
    thread = threading.Thread(target=hub.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True)
    thread.start()
    try:
        yield hub
    finally:
        hub.leave()
        thread.join()
