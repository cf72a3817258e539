"""Processes that fetch, killed, forked and ended at any moment: the next finds a sound cache."""

from __future__ import annotations

from pathlib import Path

import pytest
from hub_client import (
    ADDRESS,
    answer_of,
    client_environment,
    hub_fixture,  # noqa: F401  # a fixture
    start,
)
from hub_server import Hub

# Children of one process that has imported everything: forty starts would take a minute.
_KILLS = """
import json, os, random, shutil, signal, sys, time
from pathlib import Path
from affectsim_data.releases.stores import open_store
from affectsim_data.releases import hub, hub_repository
import huggingface_hub.file_download, huggingface_hub.errors
address, root, out, rounds = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]), int(sys.argv[4])
cache = Path(os.environ["AFFECTSIM_CACHE"]) / "hub"

def child(work):
    process = os.fork()
    if not process:
        try:
            work()
            os._exit(0)
        except BaseException:
            import traceback
            traceback.print_exc()
            os._exit(1)
    return process

def end_of(process):
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])

def fetch_all():
    store = open_store(address)
    store.prefetch(store.manifest.files)
    for name in store.manifest.files:
        assert store.read(name) == (root / name).read_bytes(), name
        path = out / name
        path.parent.mkdir(parents=True, exist_ok=True)
        store.fetch_to(name, path)
        assert path.read_bytes() == (root / name).read_bytes(), name

def leftovers():
    return [str(path) for folder in (cache, out) for path in folder.rglob("*.partial")]

def clear():
    for folder in (cache, out):
        shutil.rmtree(folder, ignore_errors=True)

for _ in range(2):  # the second knows what there is to know of a first run
    clear()
    began = time.monotonic()
    assert end_of(child(fetch_all)) == 0
takes_s = time.monotonic() - began
moment = random.Random(7)
killed, unfinished, problems = 0, 0, []
for _ in range(rounds):
    clear()
    process = child(fetch_all)
    time.sleep(moment.uniform(0.0, takes_s))
    os.kill(process, signal.SIGKILL)
    killed += end_of(process) == -signal.SIGKILL
    unfinished += bool(leftovers())
    if end_of(child(fetch_all)) != 0:
        problems.append("the next run failed")
    files = [path for path in (cache / "objects").rglob("*") if path.is_file()]
    # The limit is exactly what all files need: nothing left over has pushed any of them out.
    held = sum(path.stat().st_size for path in files)
    if held != int(os.environ["AFFECTSIM_CACHE_LIMIT"]) or leftovers():
        problems.append([held, leftovers()])
print(json.dumps([killed, unfinished, problems]))
"""


def test_killed_at_any_moment_the_next_run_ends_with_the_same_bytes(
    hub: Hub, tmp_path: Path
) -> None:
    hub.bytes_per_s = 2.5e6
    limit = sum(path.stat().st_size for path in hub.root.rglob("*.parquet"))
    environment = client_environment(hub, tmp_path / "cache", AFFECTSIM_CACHE_LIMIT=str(limit))
    arguments = (ADDRESS, str(hub.root), str(tmp_path / "out"), "20")
    killed, unfinished, problems = answer_of(
        start(_KILLS, *arguments, environment=environment), timeout_s=120.0
    )
    assert problems == []
    assert killed >= 10
    assert unfinished >= 2, "files were under way"


_FORKS = """
import json, os, sys, time
from pathlib import Path
from affectsim_data.releases import object_cache
# What threads find out at the start takes long enough for forks to fall into it.
try_lock = object_cache.try_lock
def slow_try_lock(fd, *, shared=False):
    time.sleep(0.05 * shared)
    return try_lock(fd, shared=shared)
object_cache.try_lock = slow_try_lock
from affectsim_data.releases.stores import open_store
store = open_store(sys.argv[1])
root, names = Path(sys.argv[2]), list(store.manifest.files)
store.prefetch(names)
children = []
for number in range(8):
    time.sleep(0.01)
    process = os.fork()
    if not process:
        # The child's own requests, and files its parent is fetching at this moment.
        store.prefetch(names[::-1])
        right = all(store.read(name) == (root / name).read_bytes() for name in names[number:])
        os._exit(0 if right else 1)
    children.append(process)
right = [store.read(name) == (root / name).read_bytes() for name in names]
print(json.dumps([all(right), [os.waitpid(process, 0)[1] for process in children]]))
"""


def test_a_fork_in_the_middle_of_fetching_hangs_nobody(hub: Hub, tmp_path: Path) -> None:
    hub.bytes_per_s, hub.latency_s = 2e6, 0.01
    environment = client_environment(hub, tmp_path)
    client = start(_FORKS, ADDRESS, str(hub.root), environment=environment)
    assert answer_of(client) == [True, [0] * 8]
    names = [name for name in hub.fetched() if name != "MANIFEST.json"]
    assert len(names) == len(set(names)), "nobody fetched what another was fetching"


_EXIT = """
import sys
from affectsim_data.releases.stores import open_store
store = open_store(sys.argv[1])
store.prefetch(store.manifest.files)
if sys.argv[2] == "reading":
    store.read(next(iter(store.manifest.files)))
print("[]")
"""


@pytest.mark.parametrize("doing", ["nothing", "reading"])
def test_a_process_ends_with_files_under_way(hub: Hub, tmp_path: Path, doing: str) -> None:
    hub.bytes_per_s = 1e5 if doing == "reading" else 2e4
    client = start(_EXIT, ADDRESS, doing, environment=client_environment(hub, tmp_path))
    out, err = client.communicate(timeout=30.0)
    assert (client.returncode, out, err) == (0, "[]\n", "")
