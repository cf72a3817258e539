"""Releases on the Hub: fetched file by file, pinned, checked, and clear when it cannot be had.

`huggingface_hub` reads its settings when it is imported, so each client is a process of its own.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hub_server import COMMIT, REPO_ID, Hub, serve_hub

from affectsim_data.releases import MANIFEST_NAME
from affectsim_data.releases.stores import open_store

ADDRESS = f"hf://datasets/{REPO_ID}"
MOTIONS = "motions/motions-00004-of-00007.parquet"
TEST_INDEX = "index/test-00000-of-00001.parquet"
TEST_EPISODES = "episodes/test-00000-of-00001.parquet"

_CLIENT = """
import hashlib, json, sys, time
time.sleep = lambda seconds: None  # the client waits between its attempts, we need not
address, steps = sys.argv[1], sys.argv[2].split()
from affectsim_data.releases import open_release
answer = {}
try:
    release = open_release(address)
    answer["uri"] = release.uri
    for step in steps:
        if step == "episodes":
            table = release.episode_table("test")
            answer[step] = [release.episode("test", i).to_row()["episode_id"] for i in range(2)]
        elif step == "motion":
            motion = release.motion("sway_sad")
            answer[step] = hashlib.sha256(motion.joint_rotations.tobytes()).hexdigest()
        elif step == "world":
            world = release.world(release.find_episode("small/5"))
            answer[step] = [world.scene.scene_id, len(world.people)]
        elif step == "pause":
            print("paused", flush=True)
            sys.stdin.readline()
except Exception as error:
    answer |= {"error": type(error).__name__, "message": str(error)}
    for field in ("file", "expected", "got"):
        answer[field] = getattr(error, field, None)
print(json.dumps(answer))
"""


@pytest.fixture
def hub(small_release_path: Path, tmp_path: Path) -> Iterator[Hub]:
    """A Hub that serves a copy of the small release."""
    root = tmp_path / "repository"
    shutil.copytree(small_release_path, root)
    with serve_hub(root) as server:
        yield server


def start_client(
    hub: Hub, cache: Path, *steps: str, address: str = ADDRESS, offline: bool = False
) -> subprocess.Popen[str]:
    """A process that opens a release on the Hub and does some steps with it."""
    environment = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith("HF_") and not name.lower().endswith("_proxy")
    }
    environment |= {"HF_ENDPOINT": hub.url, "HF_HOME": str(cache), "HF_HUB_DISABLE_TELEMETRY": "1"}
    if offline:
        environment["HF_HUB_OFFLINE"] = "1"
    command = [sys.executable, "-c", _CLIENT, address, " ".join(steps)]
    pipe = subprocess.PIPE
    return subprocess.Popen(
        command, env=environment, stdin=pipe, stdout=pipe, stderr=pipe, text=True
    )


def ask(hub: Hub, cache: Path, *steps: str, **options: Any) -> dict[str, Any]:
    """What such a process answers."""
    out, err = start_client(hub, cache, *steps, **options).communicate(timeout=60)
    assert out, err
    answer: dict[str, Any] = json.loads(out.splitlines()[-1])
    return answer


@pytest.mark.parametrize("revision", ["", "@main", "@v1", f"@{COMMIT}"])
def test_every_revision_is_pinned_to_its_commit(hub: Hub, tmp_path: Path, revision: str) -> None:
    answer = ask(hub, tmp_path / "cache", "motion", address=ADDRESS + revision)
    assert answer["uri"] == f"{ADDRESS}@{COMMIT}"
    asked = {(revision, path) for _, revision, path in hub.requests if path != MANIFEST_NAME}
    assert asked == {(COMMIT, MOTIONS)}, "what follows the manifest comes from its commit"


def test_only_what_is_needed_is_fetched(hub: Hub, tmp_path: Path, small_release_path: Path) -> None:
    cache = tmp_path / "cache"
    answer = ask(hub, cache, "episodes")
    assert answer["episodes"] == ["small/4", "small/5"]
    assert hub.fetched() == [MANIFEST_NAME, TEST_INDEX, TEST_EPISODES]
    hub.requests.clear()
    ask(hub, cache, "episodes", "motion")
    assert hub.fetched() == [MOTIONS], "what is in the cache is not fetched again"


def test_the_hub_and_the_folder_give_the_same(
    hub: Hub, tmp_path: Path, small_release_path: Path
) -> None:
    steps = ("episodes", "motion", "world")
    near = ask(hub, tmp_path / "unused", *steps, address=str(small_release_path))
    assert hub.requests == []
    far = ask(hub, tmp_path / "cache", *steps)
    assert {step: far[step] for step in steps} == {step: near[step] for step in steps}


def test_a_full_cache_needs_no_hub(hub: Hub, tmp_path: Path) -> None:
    before = ask(hub, tmp_path / "cache", "episodes", "world")
    hub.requests.clear()
    assert ask(hub, tmp_path / "cache", "episodes", "world", offline=True) == before
    assert hub.requests == []


def test_an_empty_cache_offline_says_so(hub: Hub, tmp_path: Path) -> None:
    answer = ask(hub, tmp_path / "cache", offline=True)
    assert answer["error"] == "FileNotFoundError"
    assert answer["message"] == (
        f"{ADDRESS}@main: MANIFEST.json is not in the local cache and the Hub cannot be reached; "
        "check the network, and HF_HUB_OFFLINE"
    )
    assert hub.requests == []


def test_an_unknown_dataset(hub: Hub, tmp_path: Path) -> None:
    answer = ask(hub, tmp_path / "cache", address="hf://datasets/affectsim/nothing")
    assert answer["error"] == "FileNotFoundError"
    assert (
        "affectsim/nothing@main: no such dataset, or it is private; `hf auth login`"
        in (answer["message"])
    )


def test_an_unknown_revision(hub: Hub, tmp_path: Path) -> None:
    answer = ask(hub, tmp_path / "cache", address=f"{ADDRESS}@v9")
    assert answer["error"] == "FileNotFoundError"
    assert answer["message"] == f"{ADDRESS}@v9: there is no such revision"


def test_a_dataset_that_is_no_release(hub: Hub, tmp_path: Path) -> None:
    (hub.root / MANIFEST_NAME).unlink()
    answer = ask(hub, tmp_path / "cache")
    assert answer["error"] == "FileNotFoundError"
    assert answer["message"] == f"{ADDRESS}@main: has no MANIFEST.json; the release is incomplete"


def test_a_file_the_publisher_forgot(hub: Hub, tmp_path: Path) -> None:
    (hub.root / MOTIONS).unlink()
    answer = ask(hub, tmp_path / "cache", "episodes", "motion")
    assert answer["episodes"] == ["small/4", "small/5"]
    assert answer["error"] == "FileNotFoundError"
    assert f"has no {MOTIONS}; the release is incomplete" in answer["message"]


def corrupt(payload: bytes) -> bytes:
    """The same length, one bit off."""
    middle = len(payload) // 2
    return payload[:middle] + bytes([payload[middle] ^ 1]) + payload[middle + 1 :]


@pytest.mark.parametrize("truncated", [True, False])
def test_a_broken_file_on_the_hub_is_fetched_twice_and_refused(
    hub: Hub, tmp_path: Path, truncated: bool
) -> None:
    whole = (hub.root / MOTIONS).read_bytes()
    broken = whole[:-100] if truncated else corrupt(whole)
    (hub.root / MOTIONS).write_bytes(broken)
    answer = ask(hub, tmp_path / "cache", "motion")
    assert answer["error"] == "IntegrityError"
    assert answer["file"] == f"{ADDRESS}@{COMMIT}/{MOTIONS}"
    if truncated:
        assert answer["expected"] == f"{len(whole)} bytes"
        assert answer["got"] == f"truncated: {len(broken)} bytes"
    else:
        assert answer["expected"].startswith("SHA-256 ")
        assert answer["got"].startswith("SHA-256 ")
    assert "tell the publisher" in answer["message"]
    assert hub.fetched().count(MOTIONS) == 2


def test_a_file_broken_on_the_way_is_fetched_again(hub: Hub, tmp_path: Path) -> None:
    whole = (hub.root / MOTIONS).read_bytes()
    hub.replaced[MOTIONS] = [corrupt(whole), whole]
    answer = ask(hub, tmp_path / "cache", "motion")
    assert "error" not in answer, answer
    assert hub.fetched().count(MOTIONS) == 2


def damage_cache(cache: Path) -> None:
    """Flips a bit of the motions in a client's cache."""
    (path,) = cache.rglob(f"snapshots/*/{MOTIONS}")
    path.write_bytes(corrupt(path.read_bytes()))


def test_a_damaged_cache_mends_itself(hub: Hub, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    before = ask(hub, cache, "motion")
    damage_cache(cache)
    hub.requests.clear()
    assert ask(hub, cache, "motion") == before
    assert hub.fetched() == [MOTIONS]
    hub.requests.clear()
    assert ask(hub, cache, "motion") == before
    assert hub.fetched() == []


def test_a_damaged_cache_offline_is_named(hub: Hub, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    ask(hub, cache, "motion")
    damage_cache(cache)
    answer = ask(hub, cache, "motion", offline=True)
    assert answer["error"] == "IntegrityError"
    assert answer["file"].endswith(MOTIONS)
    assert "the local copy is damaged and the Hub cannot be reached" in answer["message"]


def test_a_manifest_that_is_cut_short(hub: Hub, tmp_path: Path) -> None:
    text = (hub.root / MANIFEST_NAME).read_bytes()
    (hub.root / MANIFEST_NAME).write_bytes(text[: len(text) // 2])
    answer = ask(hub, tmp_path / "cache")
    assert answer["error"] == "ValueError"
    assert f"{ADDRESS}@{COMMIT}/{MANIFEST_NAME}: not JSON" in answer["message"]


def test_a_hub_that_goes_away_between_files(hub: Hub, tmp_path: Path) -> None:
    client = start_client(hub, tmp_path / "cache", "episodes", "pause", "motion")
    assert client.stdout is not None
    assert client.stdout.readline() == "paused\n"
    hub.leave()
    out, err = client.communicate("\n", timeout=60)
    answer = json.loads(out.splitlines()[-1])
    assert answer["episodes"] == ["small/4", "small/5"], err
    assert answer["error"] == "FileNotFoundError"
    assert f"{MOTIONS} is not in the local cache and the Hub cannot be reached" in answer["message"]


def test_a_hub_that_goes_away_in_the_middle_of_a_file(hub: Hub, tmp_path: Path) -> None:
    hub.cut_short.add(MOTIONS)
    cache = tmp_path / "cache"
    answer = ask(hub, cache, "episodes", "motion")
    assert answer["episodes"] == ["small/4", "small/5"]
    assert answer["error"] == "ConnectionError"
    assert f"fetching {MOTIONS} failed" in answer["message"]
    # Half a file is not taken for the file later.
    with serve_hub(hub.root) as again:
        assert "error" not in ask(again, cache, "motion")


@pytest.mark.parametrize(
    "address",
    ["hf://affectsim/small", "hf://datasets/small", "hf://datasets/a/b/c", "hf:datasets/a/b"],
)
def test_malformed_addresses_are_refused(address: str) -> None:
    with pytest.raises(ValueError, match=f"'{address}': expected hf://datasets/ORG/NAME@REVISION"):
        open_store(address)


def test_names_the_hub_does_not_allow_are_refused(hub: Hub, tmp_path: Path) -> None:
    answer = ask(hub, tmp_path / "cache", address="hf://datasets/../..")
    assert answer["error"] == "ValueError"
    assert answer["message"].startswith("hf://datasets/../..@main: ")
    assert hub.requests == []
