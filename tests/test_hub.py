"""Releases on the Hub: fetched file by file, pinned, checked, and clear when it cannot be had."""

from __future__ import annotations

import os
import pickle
from pathlib import Path

import pytest
from hub_client import (
    ADDRESS,
    answer_of,
    cache_fixture,  # noqa: F401  # a fixture
    client_environment,
    corrupt,
    hub_fixture,  # noqa: F401  # a fixture
    opened,
    point_at,
    start,
)
from hub_server import COMMIT, Hub, serve_hub

from affectsim_data.errors import CacheError, IntegrityError
from affectsim_data.releases import MANIFEST_NAME, Release, open_release
from affectsim_data.releases.hub import HubStore
from affectsim_data.releases.stores import open_store

MOTIONS = "motions/motions-00004-of-00007.parquet"
TEST_INDEX = "index/test-00000-of-00001.parquet"
TEST_EPISODES = "episodes/test-00000-of-00001.parquet"


@pytest.mark.usefixtures("cache")
@pytest.mark.parametrize("revision", ["", "@main", "@v1", f"@{COMMIT}", "@refs/pr/1"])
def test_every_revision_is_pinned_to_its_commit(hub: Hub, revision: str) -> None:
    hub.revisions["refs/pr/1"] = COMMIT
    store = opened(ADDRESS + revision)
    assert (store.uri, store.commit) == (f"{ADDRESS}@{COMMIT}", COMMIT)
    store.read(MOTIONS)
    assert hub.requests == [
        ("HEAD", revision[1:] or "main", MANIFEST_NAME),
        ("GET", COMMIT, MANIFEST_NAME),
        ("GET", COMMIT, MOTIONS),
    ]


@pytest.mark.usefixtures("cache")
def test_opening_again_asks_only_what_a_name_stands_for(hub: Hub) -> None:
    opened()
    hub.requests.clear()
    assert opened("hf://datasets/affectsim/small@main").commit == COMMIT
    assert hub.requests == [("HEAD", "main", MANIFEST_NAME)]
    hub.requests.clear()
    assert opened(f"{ADDRESS}@{COMMIT}").commit == COMMIT
    assert hub.requests == [], "a commit stands for itself"


@pytest.mark.usefixtures("cache")
def test_a_branch_that_moves_is_followed(hub: Hub) -> None:
    before = opened()
    hub.revisions["main"] = hub.revisions["v0"]
    assert opened().commit == hub.revisions["v0"] != before.commit


@pytest.mark.usefixtures("cache")
def test_only_what_is_needed_is_fetched(hub: Hub) -> None:
    release = Release(opened())
    assert [release.episode("test", i).episode_id for i in (0, 1)] == ["small/4", "small/5"]
    assert hub.fetched() == [MANIFEST_NAME, TEST_EPISODES]
    release.episode_index("test")
    hub.requests.clear()
    again = Release(opened())
    again.episode_table("test")
    again.motion("sway_sad")
    assert hub.fetched() == [MOTIONS], "what is in the cache is not fetched again"


def test_the_hub_and_the_folder_give_the_same(
    cache: Path, hub: Hub, small_release_path: Path
) -> None:
    near, far = open_release(small_release_path), Release(opened())
    assert far.manifest == near.manifest
    for name, entry in near.manifest.files.items():
        assert len(opened().read(name)) == entry.bytes
    assert far.episode_table("test").equals(near.episode_table("test"))
    world = far.world(far.find_episode("small/5"))
    assert (world.scene.scene_id, len(world.people)) == ("crate_room", 2)


def test_is_local_is_what_needs_no_network(cache: Path, hub: Hub) -> None:
    store = opened()
    assert not store.is_local(MOTIONS)
    store.read(MOTIONS)
    assert store.is_local(MOTIONS)
    hub.leave()
    assert len(store.read(MOTIONS)) == store.manifest.files[MOTIONS].bytes


def test_fetch_reports_every_new_byte(cache: Path, hub: Hub, tmp_path: Path) -> None:
    store, counts = opened(), list[int]()
    size = store.manifest.files[MOTIONS].bytes
    store.fetch(MOTIONS, progress=counts.append)
    assert sum(counts) == size
    store.fetch(MOTIONS, progress=counts.append)
    assert sum(counts) == size, "nothing is new the second time"
    hub.cuts[TEST_EPISODES] = [500]
    counts.clear()
    store.fetch(TEST_EPISODES, progress=counts.append)
    assert sum(counts) == store.manifest.files[TEST_EPISODES].bytes
    whole = (hub.root / TEST_INDEX).read_bytes()
    hub.replaced[TEST_INDEX] = [corrupt(whole), whole]
    counts.clear()
    store.fetch_to(TEST_INDEX, tmp_path / "index.parquet", progress=counts.append)
    assert sum(counts) == len(whole)
    assert min(counts) == -len(whole), "what was broken is taken back"


def test_fetch_to_goes_on_where_it_was_and_leaves_the_cache_alone(
    cache: Path, hub: Hub, tmp_path: Path
) -> None:
    store, counts = opened(), list[int]()
    whole = (hub.root / MOTIONS).read_bytes()
    path, partial = tmp_path / "motions.parquet", tmp_path / "motions.parquet.partial"
    partial.write_bytes(whole[:1000])
    before = hub.bytes_sent
    store.fetch_to(MOTIONS, path, progress=counts.append)
    assert path.read_bytes() == whole
    assert sum(counts) == hub.bytes_sent - before == len(whole) - 1000
    assert not partial.exists()
    assert not store.is_local(MOTIONS)
    hub.requests.clear()
    store.fetch_to(MOTIONS, path)
    assert hub.requests == [], "what is there and right stays"
    partial.write_bytes(corrupt(whole)[:-1])
    path.unlink()
    store.fetch_to(MOTIONS, path)
    assert path.read_bytes() == whole, "a beginning that was damaged is not built upon"


_OFFLINE = """
import json, pickle, socket, sys
def refuse(*args, **options):
    raise AssertionError(f"a network call: {args}")
socket.socket.connect = socket.socket.connect_ex = refuse
socket.getaddrinfo = socket.create_connection = socket.gethostbyname = refuse
from affectsim_data.releases import open_release, Release
from affectsim_data.releases.stores import open_store
answers = []
for address in sys.argv[1].split():
    store = open_store(address)
    store.prefetch(list(store.manifest.files))
    release = Release(pickle.loads(pickle.dumps(store)))
    episode, motion = release.episode("test", 1), release.motion("sway_sad")
    answers.append([release.uri, episode.episode_id, motion.emotion])
for step in (lambda: store.read("avatars/avatars-00000-of-00002.parquet"),
             lambda: store.fetch("avatars/avatars-00000-of-00002.parquet"),
             lambda: open_store(sys.argv[2] + "@v1")):
    try:
        step()
    except Exception as error:
        answers.append(f"{type(error).__name__}: {error}")
print(json.dumps(answers))
"""


def test_offline_makes_no_network_call_at_all(cache: Path, hub: Hub) -> None:
    release = Release(opened())
    release.episode("test", 1)
    release.motion("sway_sad")
    hub.requests.clear()
    environment = client_environment(hub, cache, HF_HUB_OFFLINE="1")
    addresses = f"{ADDRESS} {ADDRESS}@main {ADDRESS}@{COMMIT}"
    answers = answer_of(start(_OFFLINE, addresses, ADDRESS, environment=environment))
    assert answers[:3] == 3 * [[f"{ADDRESS}@{COMMIT}", "small/5", "sad"]]
    avatar = f"{COMMIT}: avatars/avatars-00000-of-00002.parquet"
    places = [avatar, avatar, "v1: MANIFEST.json"]
    for answer, place in zip(answers[3:], places, strict=True):
        assert answer == (
            f"FileNotFoundError: {ADDRESS}@{place} is not in the local cache and the Hub cannot "
            "be reached; check the network, and HF_HUB_OFFLINE"
        )
    assert hub.requests == []


_ENDPOINT = """
import json, sys
from affectsim_data.releases import open_release
release = open_release(sys.argv[1])
print(json.dumps([release.uri, release.motion("sway_sad").emotion]))
"""


def test_the_endpoint_is_that_of_the_environment(hub: Hub, tmp_path: Path) -> None:
    hub.token = "hf_secret"
    environment = client_environment(hub, tmp_path, HF_TOKEN="hf_secret")
    answer = answer_of(start(_ENDPOINT, ADDRESS, environment=environment))
    assert answer == [f"{ADDRESS}@{COMMIT}", "sad"]
    assert hub.fetched() == [MANIFEST_NAME, MOTIONS]


@pytest.mark.usefixtures("cache")
def test_a_copy_in_another_process_asks_nobody(hub: Hub) -> None:
    store = opened()
    store.read(MOTIONS)
    hub.revisions["main"] = hub.revisions["v0"]
    hub.requests.clear()
    copy = pickle.loads(pickle.dumps(store))
    assert (copy.uri, copy.manifest) == (store.uri, store.manifest)
    assert copy.read(MOTIONS) == store.read(MOTIONS)
    assert hub.requests == []
    assert len(pickle.dumps(store)) < 1000, "the manifest stays where it is"


def test_a_hub_out_of_reach_leaves_what_is_here(cache: Path, hub: Hub) -> None:
    opened().read(MOTIONS)
    hub.leave()
    with pytest.warns(UserWarning, match=f"{ADDRESS}@main: the Hub cannot be reached .*{COMMIT}"):
        store = opened()
    assert store.uri == f"{ADDRESS}@{COMMIT}"
    assert len(store.read(MOTIONS)) == store.manifest.files[MOTIONS].bytes
    missing = f"{COMMIT}: {TEST_INDEX} is not in the local cache and the Hub cannot be reached"
    with pytest.raises(FileNotFoundError, match=missing):
        store.read(TEST_INDEX)


@pytest.mark.usefixtures("cache")
def test_a_hub_out_of_order_leaves_what_is_here(hub: Hub) -> None:
    opened()
    hub.refusals[MANIFEST_NAME] = [(503, {})]
    with pytest.warns(UserWarning, match="cannot be reached"):
        assert opened().commit == COMMIT
    assert hub.refusals[MANIFEST_NAME] == [], "asked once"


def test_an_empty_cache_offline_says_so(
    cache: Path, hub: Hub, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_OFFLINE", True)
    with pytest.raises(FileNotFoundError) as caught:
        opened()
    assert str(caught.value) == (
        f"{ADDRESS}@main: MANIFEST.json is not in the local cache and the Hub cannot be reached; "
        "check the network, and HF_HUB_OFFLINE"
    )
    assert hub.requests == []


@pytest.mark.usefixtures("cache")
def test_an_unknown_dataset() -> None:
    message = "affectsim/nothing@main: no such dataset, or it is private; `hf auth login`"
    with pytest.raises(FileNotFoundError, match=message):
        opened("hf://datasets/affectsim/nothing")


@pytest.mark.usefixtures("cache")
def test_a_private_dataset_needs_the_users_token(hub: Hub, monkeypatch: pytest.MonkeyPatch) -> None:
    hub.token = "hf_secret"
    with pytest.raises(FileNotFoundError, match="no such dataset, or it is private"):
        opened()
    monkeypatch.setenv("HF_TOKEN", "hf_secret")
    opened().read(MOTIONS)


@pytest.mark.usefixtures("cache")
def test_a_gated_dataset_says_whom_to_ask(hub: Hub) -> None:
    hub.refusals[MANIFEST_NAME] = [(403, {"X-Error-Code": "GatedRepo"})]
    with pytest.raises(FileNotFoundError, match="@main: its authors want to be asked"):
        opened()


@pytest.mark.usefixtures("cache")
def test_the_token_goes_to_no_other_host(hub: Hub, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HF_TOKEN", "hf_secret")
    hub.token, hub.storage = "hf_secret", hub.other_url
    store = opened()
    hub.cuts[MOTIONS] = [1000]
    assert store.read(MOTIONS) == (hub.root / MOTIONS).read_bytes()
    assert {host for host, _ in hub.tokens} == {"127.0.0.1", "localhost"}
    assert {token for host, token in hub.tokens if host == "127.0.0.1"} == {"Bearer hf_secret"}
    assert {token for host, token in hub.tokens if host == "localhost"} == {""}


@pytest.mark.usefixtures("cache")
def test_an_unknown_revision() -> None:
    with pytest.raises(FileNotFoundError, match=f"{ADDRESS}@v9: there is no such revision$"):
        opened(f"{ADDRESS}@v9")


@pytest.mark.usefixtures("cache")
def test_a_dataset_that_is_no_release(hub: Hub) -> None:
    (hub.root / MANIFEST_NAME).unlink()
    message = f"{ADDRESS}@main: has no MANIFEST.json; the release is incomplete"
    with pytest.raises(FileNotFoundError, match=message):
        opened()


@pytest.mark.usefixtures("cache")
def test_a_file_the_publisher_forgot(hub: Hub) -> None:
    (hub.root / MOTIONS).unlink()
    with pytest.raises(FileNotFoundError, match=f"has no {MOTIONS}; the release is incomplete"):
        opened().read(MOTIONS)


@pytest.mark.usefixtures("cache")
@pytest.mark.parametrize("kind", ["short", "long", "wrong"])
def test_a_broken_file_on_the_hub_is_fetched_twice_and_refused(hub: Hub, kind: str) -> None:
    whole = (hub.root / MOTIONS).read_bytes()
    broken = {"short": whole[:-100], "long": whole + b"more", "wrong": corrupt(whole)}[kind]
    (hub.root / MOTIONS).write_bytes(broken)
    with pytest.raises(IntegrityError, match="tell the publisher") as caught:
        opened().read(MOTIONS)
    error = caught.value
    assert error.file == f"{ADDRESS}@{COMMIT}/{MOTIONS}"
    if kind == "wrong":
        assert error.expected.startswith("SHA-256 ")
        assert error.got.startswith("SHA-256 ")
    else:
        length = f"truncated: {len(broken)}" if kind == "short" else f"more than {len(whole)}"
        assert (error.expected, error.got) == (f"{len(whole)} bytes", f"{length} bytes")
    assert hub.fetched().count(MOTIONS) == 2


@pytest.mark.usefixtures("cache")
def test_a_file_that_never_ends_is_read_no_further_than_it_should_be(hub: Hub) -> None:
    store = opened()
    hub.replaced[MOTIONS] = [bytes(20_000_000)]
    hub.bytes_sent = 0
    with pytest.raises(IntegrityError, match="more than"):
        store.read(MOTIONS)
    assert hub.bytes_sent < 12_000_000, "what the sockets hold twice, and no more"


@pytest.mark.usefixtures("cache")
def test_a_file_broken_on_the_way_is_fetched_again(hub: Hub) -> None:
    whole = (hub.root / MOTIONS).read_bytes()
    hub.replaced[MOTIONS] = [corrupt(whole), whole]
    assert opened().read(MOTIONS) == whole
    assert hub.fetched().count(MOTIONS) == 2


def damage(cache: Path, store: HubStore, name: str = MOTIONS) -> Path:
    """Flips a bit of a file in a client's cache."""
    (path,) = cache.rglob(store.manifest.files[name].sha256)
    path.write_bytes(corrupt(path.read_bytes()))
    return path


def test_a_damaged_cache_mends_itself(cache: Path, hub: Hub) -> None:
    store = opened()
    before = store.read(MOTIONS)
    path = damage(cache, store)
    hub.requests.clear()
    assert store.read(MOTIONS) == before == path.read_bytes()
    assert hub.fetched() == [MOTIONS]
    hub.requests.clear()
    assert store.read(MOTIONS) == before
    assert hub.requests == []


def test_a_damaged_cache_out_of_reach_is_named(cache: Path, hub: Hub) -> None:
    store = opened()
    store.read(MOTIONS)
    damage(cache, store)
    hub.leave()
    with pytest.raises(IntegrityError, match="the local copy is damaged and the Hub cannot be"):
        store.read(MOTIONS)


def test_a_damaged_manifest_in_the_cache_is_fetched_again(cache: Path, hub: Hub) -> None:
    before = opened().manifest
    (path,) = (cache / "hub" / "manifests").rglob("*.json")
    path.write_bytes(path.read_bytes()[:-10])
    assert opened().manifest == before
    assert hub.fetched() == [MANIFEST_NAME] * 2


@pytest.mark.usefixtures("cache")
def test_a_manifest_that_is_cut_short(hub: Hub) -> None:
    text = (hub.root / MANIFEST_NAME).read_bytes()
    (hub.root / MANIFEST_NAME).write_bytes(text[: len(text) // 2])
    with pytest.raises(ValueError, match=f"{ADDRESS}@{COMMIT}/{MANIFEST_NAME}: not JSON"):
        opened()


@pytest.mark.usefixtures("cache")
def test_a_manifest_without_end_is_refused(hub: Hub, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in ("manifest", "hub_repository"):
        monkeypatch.setattr(f"affectsim_data.releases.{module}.MAX_MANIFEST_BYTES", 1000)
    hub.replaced[MANIFEST_NAME] = [bytes(20_000_000)]
    with pytest.raises(ValueError, match="larger than 1000 bytes; not a manifest"):
        opened()
    assert hub.bytes_sent < 6_000_000


@pytest.mark.usefixtures("cache")
def test_a_server_that_is_no_hub(hub: Hub) -> None:
    hub.revisions["main"] = "../../elsewhere"
    with pytest.raises(ConnectionError, match=r"X-Repo-Commit is '../../elsewhere'; is HF_ENDPOI"):
        opened()


@pytest.mark.usefixtures("cache")
def test_a_hub_that_goes_away_in_the_middle_of_a_file(
    hub: Hub, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = opened()
    hub.cut_short.add(MOTIONS)
    with pytest.raises(ConnectionError, match=f"fetching {MOTIONS} failed"):
        store.read(MOTIONS)
    assert not store.is_local(MOTIONS)
    whole = (hub.root / MOTIONS).read_bytes()
    with serve_hub(hub.root) as again:
        point_at(again, cache, monkeypatch)
        assert store.read(MOTIONS) == whole
        assert again.bytes_sent == len(whole) - len(whole) // 2, "the first half is not lost"


@pytest.mark.parametrize(
    "address",
    ["hf://affectsim/small", "hf://datasets/small", "hf://datasets/a/b/c", "hf:datasets/a/b"],
)
def test_malformed_addresses_are_refused(address: str) -> None:
    with pytest.raises(ValueError, match=f"'{address}': expected hf://datasets/ORG/NAME@REVISION"):
        open_store(address)


def test_names_the_hub_does_not_allow_are_refused(cache: Path, hub: Hub) -> None:
    with pytest.raises(ValueError, match=r"^hf://datasets/\.\./\.\.@main: "):
        opened("hf://datasets/../..")
    assert hub.requests == []
    assert not cache.exists()


@pytest.mark.usefixtures("cache", "hub")
def test_a_limit_that_is_no_size_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AFFECTSIM_CACHE_LIMIT", "plenty")
    with pytest.raises(
        ValueError, match=r"AFFECTSIM_CACHE_LIMIT must be a number of bytes .*'plen"
    ):
        opened()


@pytest.mark.usefixtures("cache", "hub")
def test_a_file_larger_than_the_limit_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AFFECTSIM_CACHE_LIMIT", "2kB")
    store = opened()
    size = store.manifest.files[MOTIONS].bytes
    message = f"{MOTIONS} has {size} bytes, more than .* 2000; set AFFECTSIM_CACHE_LIMIT to more"
    with pytest.raises(CacheError, match=message):
        store.read(MOTIONS)


@pytest.mark.skipif(
    not (os.environ.get("HF_TOKEN") and os.environ.get("AFFECTSIM_TEST_HUB_REPO")),
    reason="set HF_TOKEN and AFFECTSIM_TEST_HUB_REPO=hf://datasets/ORG/NAME@REVISION",
)
def test_the_real_hub_gives_what_its_manifest_says(tmp_path: Path) -> None:
    """In a process of its own, which the guard of the tests against the network does not reach."""
    address = os.environ["AFFECTSIM_TEST_HUB_REPO"]
    environment = {**os.environ, "AFFECTSIM_CACHE": str(tmp_path)}
    online = answer_of(start(_REAL, address, environment=environment), timeout_s=300.0)
    assert online["uri"].startswith(address.split("@")[0] + "@")
    assert online["error"] == f"FileNotFoundError: {address.split('@')[0]}@no-such-revision: "
    offline = answer_of(start(_REAL, address, environment={**environment, "HF_HUB_OFFLINE": "1"}))
    assert offline["sizes"] == online["sizes"]


_REAL = """
import json, sys
from affectsim_data.releases.stores import open_store
store = open_store(sys.argv[1])
names = sorted(store.manifest.files, key=lambda name: store.manifest.files[name].bytes)[:5]
store.prefetch(names)
answer = {"uri": store.uri, "sizes": [len(store.read(name)) for name in names]}
try:
    open_store(sys.argv[1].split("@")[0] + "@no-such-revision")
except Exception as error:
    answer["error"] = f"{type(error).__name__}: {error}"
print(json.dumps(answer))
"""
