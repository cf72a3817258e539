"""The Hub of the tests in a process of its own, at the far end of a slow line.

python -m benchmarks.slow_hub FOLDER [--latency-s S] [--bytes-per-s B]
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import IO, NamedTuple, cast

_ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(_ROOT / "tests"))

from hub_server import REPO_ID, Hub  # noqa: E402 - found by the line above

__all__ = [
    "HUNDRED_MBIT",
    "LATENCY_S",
    "REPO_ID",
    "Counts",
    "SlowHub",
    "hub_environment",
    "slow_hub",
]

HUNDRED_MBIT = 12.5e6
"""Bytes per second."""
LATENCY_S = 0.03
"""From a request to its answer, as over an open connection; handshakes are free here."""


class Counts(NamedTuple):
    """What a server sent so far."""

    requests: int
    bytes: int


class SlowHub:
    """A server that runs, seen from the process that started it."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process
        self.url = self._ask(None)
        """For `HF_ENDPOINT`."""

    def counts(self) -> Counts:
        """Requests answered, redirects included, and bytes of files sent since the start."""
        return Counts(*json.loads(self._ask("counts")))

    def _ask(self, question: str | None) -> str:
        stdin, stdout = cast(IO[str], self._process.stdin), cast(IO[str], self._process.stdout)
        if question is not None:
            stdin.write(f"{question}\n")
            stdin.flush()
        answer = stdout.readline().strip()
        if not answer:
            raise RuntimeError("the server is gone; its own message stands above")
        return answer


@contextlib.contextmanager
def slow_hub(
    root: Path, *, latency_s: float = LATENCY_S, bytes_per_s: float = HUNDRED_MBIT
) -> Iterator[SlowHub]:
    """Serves a folder as the one dataset of a Hub, from a process of its own.

    Args:
        root: Its files.
        latency_s: Time before every answer.
        bytes_per_s: What all connections together get; 0 for as fast as it goes.
    """
    command = [sys.executable, "-m", "benchmarks.slow_hub", str(root)]
    command += ["--latency-s", str(latency_s), "--bytes-per-s", str(bytes_per_s)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, cwd=_ROOT, stdin=pipe, stdout=pipe, text=True) as process:
        try:
            yield SlowHub(process)
        finally:
            cast(IO[str], process.stdin).close()
            process.wait()


@contextlib.contextmanager
def hub_environment(hub: SlowHub, **more: str) -> Iterator[None]:
    """Sends this process and its children to a server, with empty caches of their own.

    The client reads these variables once: to be called before it is imported.
    """
    with tempfile.TemporaryDirectory() as folder:
        names = {"HF_ENDPOINT": hub.url, "HF_HOME": f"{folder}/hf", "HF_HUB_OFFLINE": "0"}
        names |= {f"HF_HUB_DISABLE_{n}": "1" for n in ("XET", "PROGRESS_BARS", "IMPLICIT_TOKEN")}
        names |= {"AFFECTSIM_CACHE": f"{folder}/affectsim"}
        before = dict(os.environ)
        os.environ.update(names | more)
        try:
            yield
        finally:
            os.environ.clear()
            os.environ.update(before)


class _RememberingHub(Hub):
    """Reads every file once, so that a range of a shard costs no more than a small file."""

    def __init__(self, root: Path) -> None:
        super().__init__(root)
        self._payloads: dict[str, bytes | None] = {}

    def payload(self, path: str, *, consume: bool) -> bytes | None:
        if path not in self._payloads:
            self._payloads[path] = super().payload(path, consume=consume)
        return self._payloads[path]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", type=Path)
    parser.add_argument("--latency-s", type=float, default=0.0)
    parser.add_argument("--bytes-per-s", type=float, default=0.0)
    options = parser.parse_args()
    hub = _RememberingHub(options.root)
    hub.latency_s, hub.bytes_per_s = options.latency_s, options.bytes_per_s
    # As on the real one: files are elsewhere, and every GET of one is sent there first.
    hub.storage = hub.other_url
    threading.Thread(target=hub.serve_forever, daemon=True).start()
    print(hub.url, flush=True)
    for _ in sys.stdin:
        print(json.dumps([len(hub.tokens), hub.bytes_sent]), flush=True)
    os._exit(0)


if __name__ == "__main__":
    main()
