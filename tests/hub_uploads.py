"""A Hub one can publish to: what `huggingface_hub` asks for when it makes one commit.

It keeps repositories as the real one does for its readers: a commit appears whole or not at all,
large files are stored by hash before the commit names them, and what is stored can be downloaded
from the same server.
"""

from __future__ import annotations

import base64
import contextlib
import hashlib
import json
import re
import shutil
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast
from urllib.parse import unquote, urlsplit

from hub_server import COMMIT, REPO_ID, Hub, HubHandler

__all__ = ["TOKEN", "UploadHub", "serve_uploads"]

TOKEN = "hf_writer"
"""The one token that may write."""
_JSON = {"Content-Type": "application/json"}


class UploadHub(Hub):
    """The server, its repository, and what was done to it."""

    def __init__(self, folder: Path) -> None:
        """Starts without a dataset; `folder` is where its commits go."""
        super().__init__(folder / "none", UploadHandler)
        self.folder = folder
        self.exists = False
        self.private = False
        self.revisions = {}
        self.tags: dict[str, str] = {}
        self.objects: dict[str, bytes] = {}
        """Large files by hash."""
        self.puts: list[str] = []
        """Hashes of the large files that were sent."""
        self.commits: list[dict[str, Any]] = []
        """Header of each commit, its changed paths as `added` and `deleted`."""
        self.broken_puts = 0
        """So many of the next large files are refused."""
        self.before_commit: list[str] = []
        """Commits somebody else makes right before the next one."""
        self.lock = threading.Lock()

    @property
    def head(self) -> str:
        """The newest commit."""
        return self.revisions["main"]

    def create(self, *, private: bool) -> None:
        """Makes the dataset with the one file every dataset begins with."""
        self.root = self.folder / COMMIT
        self.root.mkdir(parents=True)
        (self.root / ".gitattributes").write_text("*.parquet filter=lfs diff=lfs merge=lfs\n")
        self.exists, self.private, self.revisions = True, private, {"main": COMMIT}
        self.token = TOKEN if private else ""

    def apply(self, lines: list[dict[str, Any]]) -> str:
        """Makes a commit of the lines of a request: a new folder, then the branch points to it."""
        header = lines[0]["value"]
        number = len(self.commits) + 1
        commit = hashlib.sha1(f"{number} {header}".encode()).hexdigest()
        new = Path(shutil.copytree(self.root, self.folder / commit))
        added, deleted = [], []
        for line in lines[1:]:
            path = new / line["value"]["path"]
            if line["key"] == "deletedFile":
                path.unlink()
                deleted.append(line["value"]["path"])
                continue
            path.parent.mkdir(parents=True, exist_ok=True)
            if line["key"] == "lfsFile":
                path.write_bytes(self.objects[line["value"]["oid"]])
            else:
                assert line["key"] == "file"
                path.write_bytes(base64.b64decode(line["value"]["content"]))
            added.append(line["value"]["path"])
        self.commits.append({**header, "added": added, "deleted": deleted})
        self.root, self.revisions = new, {**self.revisions, "main": commit}
        return commit


class UploadHandler(HubHandler):
    """Adds the routes of publishing to those of reading."""

    @property
    def hub(self) -> UploadHub:
        """The server."""
        return cast(UploadHub, self.server)

    def do_PUT(self) -> None:
        self.answer()

    def answer(self) -> None:
        """Answers any request."""
        path = unquote(urlsplit(self.path).path)
        api = f"/api/datasets/{REPO_ID}"
        if self.command in ("POST", "PUT") and not path.startswith(f"{api}/paths-info"):
            self._answer_writing(path, api, self._body())
        elif path in (api, f"{api}/refs") and self.hub.exists:
            self._send_state(path.removeprefix(api))
        else:
            super().answer()

    def _body(self) -> bytes:
        if self.headers.get("Transfer-Encoding") != "chunked":
            return self.rfile.read(int(self.headers.get("Content-Length", 0)))
        pieces = []
        while size := int(self.rfile.readline(), 16):
            pieces.append(self.rfile.read(size))
            self.rfile.readline()
        self.rfile.readline()
        return b"".join(pieces)

    def _answer_writing(self, path: str, api: str, body: bytes) -> None:
        self.hub.requests.append((self.command, "", path))
        if path.startswith("/lfs/"):
            self._store(path.removeprefix("/lfs/"), body)  # a signed address needs no token
        elif self.headers.get("Authorization") != f"Bearer {TOKEN}":
            self._fail(403 if self.headers.get("Authorization") else 401, "not yours")
        elif path == "/api/validate-yaml":
            self._validate_card(json.loads(body)["content"])
        elif path == "/api/repos/create":
            self._create(json.loads(body))
        elif not self.hub.exists:
            self.refuse(404, "RepoNotFound")
        elif path.startswith(f"{api}/preupload/"):
            self.send_json({"files": [self._mode(file) for file in json.loads(body)["files"]]})
        elif path == f"/datasets/{REPO_ID}.git/info/lfs/objects/batch":
            objects = [self._action(one) for one in json.loads(body)["objects"]]
            self.send_json({"transfer": "basic", "objects": objects})
        elif path == "/verify":
            known = json.loads(body)
            same = len(self.hub.objects.get(known["oid"], b"")) == known["size"]
            self.refuse(200 if same else 422, "")
        elif path == f"{api}/commit/main":
            self._commit([json.loads(line) for line in body.splitlines()])
        elif path.startswith(f"{api}/tag/"):
            self._tag(path.removeprefix(f"{api}/tag/"), json.loads(body)["tag"])
        else:
            self.refuse(404, "")

    def _send_state(self, what: str) -> None:
        hub = self.hub
        hub.requests.append((self.command, "", what))
        if hub.token and self.headers.get("Authorization") != f"Bearer {hub.token}":
            self.refuse(401, "RepoNotFound")
        elif what == "/refs":
            tags = [
                {"name": name, "ref": f"refs/tags/{name}", "targetCommit": commit}
                for name, commit in hub.tags.items()
            ]
            main = {"name": "main", "ref": "refs/heads/main", "targetCommit": hub.head}
            self.send_json({"branches": [main], "converts": [], "tags": tags})
        else:
            facts = {"id": REPO_ID, "sha": hub.head, "private": hub.private, "tags": []}
            self.send_json({**facts, "downloads": 0, "likes": 0})

    def _fail(self, status: int, message: str) -> None:
        body = json.dumps({"error": message, "errors": [{"message": message}]}).encode()
        self.send_response(status)
        for name, value in {**_JSON, "X-Error-Message": message}.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def _validate_card(self, text: str) -> None:
        if re.match(r"---\npretty_name: .+\n(?s:.*?)\n?---\n", text):
            self.send_json({"errors": [], "warnings": []})
        else:
            self._fail(400, "no front matter")

    def _create(self, wish: dict[str, Any]) -> None:
        repo_id = f"{wish['organization']}/{wish['name']}"
        if repo_id != REPO_ID or wish["type"] != "dataset":
            self._fail(403, "you may not create that")
        elif self.hub.exists:
            body = json.dumps({"url": f"{self.hub.url}/datasets/{REPO_ID}", "error": "exists"})
            self.send_response(409)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body.encode())
        else:
            private = wish.get("visibility") == "private" or bool(wish.get("private"))
            self.hub.create(private=private)
            self.send_json({"url": f"{self.hub.url}/datasets/{REPO_ID}"})

    def _mode(self, file: dict[str, Any]) -> dict[str, Any]:
        """How a file is to be sent, and the hash of what is there under its name."""
        large = file["path"].endswith(".parquet")
        there, oid = self.hub.root / file["path"], None
        if there.is_file():
            content = there.read_bytes()
            blob = b"blob %d\0" % len(content) + content
            oid = hashlib.sha256(content).hexdigest() if large else hashlib.sha1(blob).hexdigest()
        mode = "lfs" if large else "regular"
        return {"path": file["path"], "uploadMode": mode, "shouldIgnore": False, "oid": oid}

    def _action(self, one: dict[str, Any]) -> dict[str, Any]:
        if one["oid"] in self.hub.objects:
            return one
        upload = {"href": f"{self.hub.url}/lfs/{one['oid']}"}
        return {**one, "actions": {"upload": upload, "verify": {"href": f"{self.hub.url}/verify"}}}

    def _store(self, oid: str, content: bytes) -> None:
        hub = self.hub
        with hub.lock:
            broken, hub.broken_puts = hub.broken_puts > 0, max(0, hub.broken_puts - 1)
        if broken:
            self._fail(400, "storage is out of order")
        elif hashlib.sha256(content).hexdigest() != oid:
            self._fail(400, "hash differs")
        else:
            hub.objects[oid] = content
            hub.puts.append(oid)
            self.refuse(200, "")

    def _commit(self, lines: list[dict[str, Any]]) -> None:
        hub = self.hub
        for message in hub.before_commit:
            hub.apply([{"key": "header", "value": {"summary": message}}])
        hub.before_commit.clear()
        if lines[0]["value"].get("parentCommit", hub.head) != hub.head:
            self._fail(412, "the branch has moved")
            return
        commit = hub.apply(lines)
        url = f"{hub.url}/datasets/{REPO_ID}/commit/{commit}"
        self.send_json({"success": True, "commitOid": commit, "commitUrl": url})

    def _tag(self, revision: str, name: str) -> None:
        hub = self.hub
        if name in hub.tags:
            self._fail(409, "the tag exists")
            return
        hub.tags[name] = hub.revisions.get(revision, revision)
        hub.revisions = {**hub.revisions, name: hub.tags[name]}
        self.refuse(200, "")


@contextlib.contextmanager
def serve_uploads(folder: Path) -> Iterator[UploadHub]:
    """Serves a Hub without any dataset yet."""
    hub = UploadHub(folder)
    thread = threading.Thread(target=hub.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True)
    thread.start()
    try:
        yield hub
    finally:
        hub.leave()
        thread.join()
