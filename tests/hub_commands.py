"""Processes that run `affectsim` commands against a Hub on this machine.

`huggingface_hub` reads its settings when it is imported, so each setting needs a process.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

from hub_server import Hub

__all__ = ["Client", "client_environment"]

_CODE = """
import contextlib, io, json, sys, time
time.sleep = lambda seconds: None  # the client waits between its attempts, we need not
from affectsim_data.cli import main
for line in sys.stdin:
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main(json.loads(line))
    print(json.dumps([status, out.getvalue(), err.getvalue()]), flush=True)
"""


def client_environment(hub: Hub, home: Path) -> dict[str, str]:
    """Variables of a process that takes `hub` for the Hub and knows nothing of the caller's.

    Its caches, and as it has none the user's token, are below `home`.
    """
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("HF_", "AFFECTSIM_")) and not name.lower().endswith("_proxy")
    }
    kept |= {"HF_ENDPOINT": hub.url, "HF_HOME": str(home / "hf")}
    kept |= {"HF_HUB_DISABLE_TELEMETRY": "1", "HF_HUB_DISABLE_XET": "1"}
    return {**kept, "AFFECTSIM_CACHE": str(home / "affectsim")}


class Client:
    """A process that runs commands one after the other."""

    def __init__(self, hub: Hub, home: Path, **environment: str) -> None:
        """Starts it.

        Args:
            hub: What it takes for the Hub.
            home: Folder of its caches.
            environment: More variables.
        """
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(
            [sys.executable, "-c", _CODE],
            env={**client_environment(hub, home), **environment},
            stdin=pipe,
            stdout=pipe,
            text=True,
        )

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *error: object) -> None:
        self._process.kill()
        self._process.communicate()

    def run(self, *arguments: object) -> tuple[int, str, str]:
        """Exit status, output and errors of a command."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        print(json.dumps([str(one) for one in arguments]), file=self._process.stdin, flush=True)
        status, out, err = json.loads(self._process.stdout.readline())
        return status, out, err
