"""Points the installed Hub client at a server of ours: in this process, or in one of its own."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hub_server import REPO_ID, Hub, serve_hub

from affectsim_data.releases.hub import HubStore
from affectsim_data.releases.stores import open_store

__all__ = [
    "ADDRESS",
    "answer_of",
    "cache_fixture",
    "client_environment",
    "corrupt",
    "hub_fixture",
    "opened",
    "point_at",
    "start",
]

ADDRESS = f"hf://datasets/{REPO_ID}"


@pytest.fixture(name="hub")
def hub_fixture(small_release_path: Path, tmp_path: Path) -> Iterator[Hub]:
    """A Hub that serves a copy of the small release."""
    root = tmp_path / "repository"
    shutil.copytree(small_release_path, root)
    with serve_hub(root) as server:
        yield server


@pytest.fixture(name="cache")
def cache_fixture(hub: Hub, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Cache of this process, which is a client of that Hub."""
    folder = tmp_path / "cache"
    point_at(hub, folder, monkeypatch)
    return folder


def opened(address: str = ADDRESS) -> HubStore:
    """The store of an address."""
    store = open_store(address)
    assert isinstance(store, HubStore)
    return store


def point_at(hub: Hub, cache: Path, patch: pytest.MonkeyPatch) -> list[float]:
    """Makes this process a client of a server with a cache of its own.

    The client reads its settings when it is imported; here they are set after that.

    Returns:
        The waits between attempts, in seconds, which nobody waits.
    """
    from huggingface_hub import constants

    waits: list[float] = []
    patch.setattr(constants, "ENDPOINT", hub.url)
    template = hub.url + "/{repo_id}/resolve/{revision}/{filename}"
    patch.setattr(constants, "HUGGINGFACE_CO_URL_TEMPLATE", template)
    patch.setattr(constants, "HF_TOKEN_PATH", str(cache / "token"))
    for name in ("HF_TOKEN", "HUGGING_FACE_HUB_TOKEN", "AFFECTSIM_CACHE_LIMIT"):
        patch.delenv(name, raising=False)
    patch.setenv("AFFECTSIM_CACHE", str(cache))
    clock = types.SimpleNamespace(sleep=waits.append)
    patch.setattr("affectsim_data.releases.fetching.time", clock)
    return waits


def client_environment(hub: Hub, cache: Path, **settings: str) -> dict[str, str]:
    """Environment of a client process."""
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith("HF_") and not name.lower().endswith("_proxy")
    }
    own = {"HF_ENDPOINT": hub.url, "HF_HOME": str(cache / "hf"), "AFFECTSIM_CACHE": str(cache)}
    return {**kept, **own, **settings}


def start(code: str, *arguments: str, environment: dict[str, str]) -> subprocess.Popen[str]:
    """A client process."""
    pipe = subprocess.PIPE
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.Popen(
        command, env=environment, stdin=pipe, stdout=pipe, stderr=pipe, text=True
    )


def answer_of(client: subprocess.Popen[str], *, words: str = "", timeout_s: float = 60.0) -> Any:
    """The JSON document a client process prints last."""
    out, err = client.communicate(words, timeout=timeout_s)
    assert out, err
    return json.loads(out.splitlines()[-1])


def corrupt(payload: bytes) -> bytes:
    """The same length, one bit off."""
    middle = len(payload) // 2
    return payload[:middle] + bytes([payload[middle] ^ 1]) + payload[middle + 1 :]
