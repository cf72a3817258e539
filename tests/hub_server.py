"""A Hugging Face Hub for one dataset, on this machine, with the routes the client and we ask for.

- HEAD and GET of `/datasets/ORG/NAME/resolve/REVISION/PATH`, with ranges, ETag, `X-Repo-Commit`,
  `X-Linked-Size` and `X-Error-Code`; GET may be redirected to a storage host, as on the real one
- `/api/datasets/ORG/NAME`, `revision`, `tree` and `paths-info`, as `HfFileSystem` needs them

It logs what it was asked, and is slow, busy, forgetful or wrong on demand.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import re
import socket
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, Literal, cast
from urllib.parse import parse_qs, unquote, urlsplit

__all__ = ["COMMIT", "REPO_ID", "Hub", "HubHandler", "serve_hub"]

REPO_ID = "affectsim/small"
COMMIT = "0123456789abcdef0123456789abcdef01234567"
_OLD_COMMIT = "89abcdef0123456789abcdef0123456789abcdef"
_PIECE, _PIECE_OF_FAST = 1 << 12, 1 << 16


class Hub(ThreadingHTTPServer):
    """The server and what it serves."""

    daemon_threads = True
    request_queue_size = 128

    def __init__(self, root: Path, handler: type[BaseHTTPRequestHandler] | None = None) -> None:
        super().__init__(("127.0.0.1", 0), handler or HubHandler)
        self.root = root
        self.revisions: dict[str, str] = {"main": COMMIT, "v1": COMMIT, "v0": _OLD_COMMIT}
        """Commit by branch, tag or commit."""
        self.replaced: dict[str, list[bytes]] = {}
        """What to send instead of a file, by path: one after the other, the last for ever."""
        self.cut_short: set[str] = set()
        """Files of which half is sent, after which the server is gone."""
        self.cuts: dict[str, list[int]] = {}
        """Bytes after which the next answers with a file are cut off, by path."""
        self.refusals: dict[str, list[tuple[int, dict[str, str]]]] = {}
        """Status and headers of the next answers instead of a file, by path."""
        self.ranges: Literal["kept", "ignored", "wrong"] = "kept"
        """What becomes of a range that is asked for: `wrong` starts elsewhere, and says so."""
        self.storage = ""
        """Where files are redirected to, if anywhere: another name of this server."""
        self.token = ""
        """Without it there is no dataset."""
        self.latency_s = 0.0
        """Before every answer."""
        self.bytes_per_s = 0.0
        """Over all connections; 0 for as fast as it goes."""
        self.bytes_sent = 0
        """Of files, over all connections."""
        self.requests: list[tuple[str, str, str]] = []
        """Method, revision and path of each request; the revision of storage is empty."""
        self.tokens: list[tuple[str, str]] = []
        """Host and authorization of each request."""
        self._connections: list[socket.socket] = []
        self._sending = threading.Lock()
        self._free_at = 0.0

    def get_request(self) -> tuple[socket.socket, Any]:
        """Keeps hold of connections, so that they can be broken."""
        connection, address = super().get_request()
        self._connections.append(connection)
        return connection, address

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Says nothing of clients that go away; other errors are those of the tests' own code."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)

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

    @property
    def other_url(self) -> str:
        """The same under another host name, for `storage`."""
        return f"http://localhost:{self.server_address[1]}"

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

    def etag(self, path: str) -> str:
        """Hash of what a file should be: on the Hub it belongs to the commit, not to the answer."""
        file = self.root / path
        return _sha256(file, file.stat().st_mtime_ns)

    def wait_for_line(self, count: int) -> None:
        """Waits until a number of bytes has gone through, at the speed of the line."""
        with self._sending:
            self.bytes_sent += count
            if not self.bytes_per_s:
                return
            self._free_at = max(self._free_at, time.monotonic()) + count / self.bytes_per_s
            free_at = self._free_at
        time.sleep(max(0.0, free_at - time.monotonic()))


@functools.lru_cache(maxsize=1 << 16)
def _sha256(file: Path, mtime_ns: int) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


class HubHandler(BaseHTTPRequestHandler):
    """Answers requests; a subclass may add routes and hand the rest to this one."""

    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True

    @property
    def hub(self) -> Hub:
        """The server."""
        return cast(Hub, self.server)

    def log_message(self, format: str, *args: Any) -> None:
        """Says nothing: requests are in the log of the hub."""

    def do_HEAD(self) -> None:
        self.answer()

    def do_GET(self) -> None:
        self.answer()

    def do_POST(self) -> None:
        self.answer()

    def answer(self) -> None:
        """Answers any request."""
        hub, token = self.hub, self.headers.get("Authorization", "")
        time.sleep(hub.latency_s)
        hub.tokens.append((self.headers.get("Host", "").split(":")[0], token))
        path = unquote(urlsplit(self.path).path)
        api, files, storage = f"/api/datasets/{REPO_ID}", f"/datasets/{REPO_ID}/resolve/", "/cdn/"
        if path.startswith(storage):
            self._send_stored(path.removeprefix(storage))
        elif hub.token and token != f"Bearer {hub.token}":
            self.refuse(401, "RepoNotFound")
        elif path.startswith(files):
            # Split before unquoting: a revision may have a slash.
            revision, _, name = self.path.removeprefix(files).partition("/")
            self._send_file(unquote(revision), unquote(urlsplit(name).path))
        elif path == api or path.startswith(api + "/"):
            self._send_facts(path.removeprefix(api).strip("/"))
        else:
            self.refuse(401 if "/resolve/" in path else 404, "RepoNotFound")

    def commit_of(self, revision: str) -> str | None:
        """The commit a revision stands for; refuses the request if there is none."""
        known = self.hub.revisions
        commit = known.get(revision, revision if revision in known.values() else None)
        if commit is None:
            self.refuse(404, "RevisionNotFound")
        return commit

    def _send_file(self, revision: str, path: str) -> None:
        hub, get = self.hub, self.command == "GET"
        hub.requests.append((self.command, revision, path))
        commit = self.commit_of(revision)
        if commit is None:
            return
        if hub.refusals.get(path):
            status, headers = hub.refusals[path].pop(0)
            self.refuse(status, "", headers)
            return
        payload = hub.payload(path, consume=get and not hub.storage)
        if payload is None:
            self.refuse(404, "EntryNotFound", {"X-Repo-Commit": commit})
            return
        facts = {"X-Repo-Commit": commit, "X-Linked-Size": str(len(payload))}
        facts["X-Linked-ETag"] = facts["ETag"] = f'"{hub.etag(path)}"'
        if hub.storage:
            self.refuse(302, "", {**facts, "Location": f"{hub.storage}/cdn/{path}"})
        else:
            self._send_bytes(path, payload, facts)

    def _send_stored(self, path: str) -> None:
        self.hub.requests.append((self.command, "", path))
        payload = self.hub.payload(path, consume=True)
        if payload is None:
            self.refuse(404, "")
        else:
            self._send_bytes(path, payload, {"ETag": f'"{self.hub.etag(path)}"'})

    def _send_bytes(self, path: str, payload: bytes, headers: Mapping[str, str]) -> None:
        """A file or the range of it that was asked for."""
        hub, start, end = self.hub, 0, len(payload)
        asked = re.fullmatch(r"bytes=(\d+)-(\d*)", self.headers.get("Range", ""))
        if asked and hub.ranges != "ignored":
            start = int(asked[1]) if hub.ranges == "kept" else int(asked[1]) // 2
            end = min(end, int(asked[2]) + 1) if asked[2] else end
            if start >= len(payload):
                self.refuse(416, "", {"Content-Range": f"bytes */{len(payload)}"})
                return
            self.send_response(206)
            self.send_header("Content-Range", f"bytes {start}-{end - 1}/{len(payload)}")
        else:
            self.send_response(200)
        sent = {**headers, "Accept-Ranges": "bytes", "Content-Length": str(end - start)}
        for name, value in sent.items():
            self.send_header(name, value)
        self.end_headers()
        if self.command == "GET":
            self._send_body(path, payload[start:end])

    def _send_body(self, path: str, body: bytes) -> None:
        hub, cuts = self.hub, self.hub.cuts.get(path)
        cut = min(cuts.pop(0), len(body)) if cuts else len(body)
        if path in hub.cut_short:
            cut = len(body) // 2
        pieces = memoryview(body)[:cut]
        size = _PIECE if 0 < hub.bytes_per_s < 5e6 else _PIECE_OF_FAST
        with contextlib.suppress(ConnectionError):
            for first in range(0, cut, size):
                piece = pieces[first : first + size]
                hub.wait_for_line(len(piece))
                self.wfile.write(piece)
        if cut < len(body):
            self.close_connection = True
        if path in hub.cut_short:
            hub.leave()

    def _send_facts(self, what: str) -> None:
        """What the API says of the dataset; `what` is `KIND/REVISION[/FOLDER]` or nothing."""
        kind, _, rest = what.partition("/")
        revision, _, folder = rest.partition("/")
        commit = self.commit_of(revision or "main")
        if commit is None:
            return
        if kind in ("", "revision"):
            facts = {"id": REPO_ID, "sha": commit, "private": False, "tags": [], "downloads": 0}
            self.send_json({**facts, "likes": 0, "lastModified": "2024-01-01T00:00:00.000Z"})
        elif kind == "tree":
            files = sorted(self.hub.root.joinpath(folder).rglob("*"))
            names = [path.relative_to(self.hub.root).as_posix() for path in files]
            self.send_json([fact for name in names for fact in self._path_facts(name)])
        elif kind == "paths-info":
            body = self.rfile.read(int(self.headers.get("Content-Length", 0))).decode()
            form = "json" not in self.headers.get("Content-Type", "")
            names = parse_qs(body).get("paths", []) if form else json.loads(body)["paths"]
            self.send_json([fact for name in names for fact in self._path_facts(name)])
        else:
            self.refuse(404, "")

    def _path_facts(self, name: str) -> list[dict[str, Any]]:
        path = self.hub.root / name
        if path.is_dir():
            return [{"type": "directory", "path": name, "oid": "0" * 40, "size": 0}]
        if not path.is_file():
            return []
        size, etag = path.stat().st_size, self.hub.etag(name)
        lfs = {"oid": etag, "size": size, "pointerSize": 134}
        return [{"type": "file", "path": name, "oid": etag[:40], "size": size, "lfs": lfs}]

    def send_json(self, document: Any) -> None:
        """Answers with a document."""
        body = json.dumps(document).encode()
        self.send_response(200)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def refuse(self, status: int, code: str, headers: Mapping[str, str] | None = None) -> None:
        """Answers without a body."""
        self.send_response(status)
        for name, value in {"X-Error-Code": code, **(headers or {})}.items():
            if value:
                self.send_header(name, value)
        self.send_header("Content-Length", "0")
        self.end_headers()


@contextlib.contextmanager
def serve_hub(root: Path, handler: type[BaseHTTPRequestHandler] | None = None) -> Iterator[Hub]:
    """Serves a folder as the one dataset of a Hub."""
    hub = Hub(root, handler)
    thread = threading.Thread(target=hub.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True)
    thread.start()
    try:
        yield hub
    finally:
        hub.leave()
        thread.join()
