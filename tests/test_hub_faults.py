"""A Hub that is slow, busy, cut off or wrong, and files that are fetched ahead of need."""

from __future__ import annotations

import threading
import time
import warnings
from pathlib import Path

import pytest
from hub_client import (
    cache_fixture,  # noqa: F401  # a fixture
    hub_fixture,  # noqa: F401  # a fixture
    opened,
    point_at,
)
from hub_server import Hub

from affectsim_data.errors import CacheError
from affectsim_data.releases.hub import HubStore
from affectsim_data.releases.prefetching import Prefetcher

MOTIONS = "motions/motions-00004-of-00007.parquet"


@pytest.fixture
def waits(hub: Hub, cache: Path, monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Waits between attempts, in seconds, which are not waited for."""
    return point_at(hub, cache, monkeypatch)


def whole(hub: Hub, name: str = MOTIONS) -> bytes:
    """What a file should be."""
    return (hub.root / name).read_bytes()


@pytest.mark.parametrize(
    ("refusals", "expected"),
    [
        ([(429, {"Retry-After": "7"})], [7.0]),
        ([(429, {"Retry-After": "1000000"})], [300.0]),
        ([(429, {"RateLimit": '"resolvers";r=0;t=55'})], [55.0]),
        ([(429, {"RateLimit": '"resolvers";r=12;t=55'})], [1.0]),
        ([(429, {"Retry-After": "Wed, 21 Oct 2015 07:28:00 GMT"})], [1.0]),
        ([(500, {}), (502, {}), (503, {}), (504, {}), (408, {})], [1.0, 2.0, 4.0, 8.0, 8.0]),
    ],
)
def test_a_busy_hub_is_asked_again_later(
    hub: Hub,
    waits: list[float],
    refusals: list[tuple[int, dict[str, str]]],
    expected: list[float],
) -> None:
    store = opened()
    hub.refusals[MOTIONS] = list(refusals)
    assert store.read(MOTIONS) == whole(hub)
    assert waits == expected


def test_a_hub_that_stays_busy_is_given_up(hub: Hub, waits: list[float]) -> None:
    store = opened()
    hub.refusals[MOTIONS] = [(500, {})] * 7
    with pytest.raises(ConnectionError, match=f"fetching {MOTIONS} failed: .*500"):
        store.read(MOTIONS)
    assert len(waits) == 5
    assert len(hub.refusals[MOTIONS]) == 1


def test_opening_waits_for_a_busy_hub_too(hub: Hub, waits: list[float]) -> None:
    hub.refusals["MANIFEST.json"] = [(503, {}), (429, {"Retry-After": "2"})]
    opened()
    assert waits == [1.0, 2.0]


def test_a_refusal_is_final(hub: Hub, waits: list[float]) -> None:
    store = opened()
    hub.refusals[MOTIONS] = [(403, {})]
    with pytest.raises(ConnectionError, match="403"):
        store.read(MOTIONS)
    assert waits == []


@pytest.mark.parametrize("cuts", [[0], [1], [5000, 1, 0, 700]])
def test_a_connection_that_is_cut_is_resumed_at_the_byte(
    hub: Hub, waits: list[float], cuts: list[int]
) -> None:
    store, before = opened(), hub.bytes_sent
    hub.cuts[MOTIONS] = list(cuts)
    assert store.read(MOTIONS) == whole(hub)
    assert hub.bytes_sent - before == len(whole(hub)), "no byte comes twice"
    assert len(waits) == len(cuts)


@pytest.mark.usefixtures("waits")
@pytest.mark.parametrize("ranges", ["ignored", "wrong"])
def test_a_server_without_ranges_breaks_nothing(hub: Hub, ranges: str) -> None:
    store = opened()
    hub.ranges = "wrong" if ranges == "wrong" else "ignored"
    hub.cuts[MOTIONS] = [5000, 7000]
    assert store.read(MOTIONS) == whole(hub)
    assert hub.fetched().count(MOTIONS) <= 5


@pytest.mark.usefixtures("waits")
def test_a_beginning_longer_than_what_the_hub_has_is_thrown_away(hub: Hub, tmp_path: Path) -> None:
    store, content = opened(), whole(hub)
    (tmp_path / "file.partial").write_bytes(content[:8000])
    hub.replaced[MOTIONS] = [content[:4000], content[:4000], content]
    store.fetch_to(MOTIONS, tmp_path / "file")
    assert (tmp_path / "file").read_bytes() == content


def test_cuts_without_end_are_given_up(hub: Hub, waits: list[float]) -> None:
    store = opened()
    hub.cuts[MOTIONS] = [10] * 100
    with pytest.raises(ConnectionError, match=f"fetching {MOTIONS} failed"):
        store.read(MOTIONS)
    assert len(waits) == 5


@pytest.mark.usefixtures("waits")
def test_a_server_that_falls_silent_is_given_up(hub: Hub, monkeypatch: pytest.MonkeyPatch) -> None:
    store = opened()
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_DOWNLOAD_TIMEOUT", 0.02)
    hub.latency_s = 0.5
    with pytest.raises(FileNotFoundError, match="the Hub cannot be reached"):
        store.read(MOTIONS)


@pytest.mark.usefixtures("cache")
def test_two_threads_fetch_a_file_once(hub: Hub) -> None:
    store, found = opened(), list[bytes]()
    hub.latency_s = 0.05
    threads = [threading.Thread(target=lambda: found.append(store.read(MOTIONS))) for _ in "1234"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20.0)
    assert found == [whole(hub)] * 4
    assert hub.fetched().count(MOTIONS) == 1


def until_local(store: HubStore, *names: str) -> None:
    """Waits until files have come in the background."""
    deadline = time.monotonic() + 20.0
    while not all(store.is_local(name) for name in names):
        assert time.monotonic() < deadline
        time.sleep(0.005)


@pytest.mark.usefixtures("cache")
def test_what_is_prefetched_is_here_when_it_is_read(hub: Hub) -> None:
    store = opened()
    names = list(store.manifest.files)
    store.prefetch(names + names)
    until_local(store, *names)
    hub.requests.clear()
    assert [store.read(name) for name in names] == [whole(hub, name) for name in names]
    assert hub.requests == []


@pytest.mark.usefixtures("cache")
def test_reading_what_is_under_way_waits_for_it(hub: Hub) -> None:
    store = opened()
    hub.latency_s = 0.05
    store.prefetch(store.manifest.files)
    for name in store.manifest.files:
        assert store.read(name) == whole(hub, name)
    asked = hub.fetched()[1:]
    assert sorted(asked) == sorted(store.manifest.files), "each once"


def test_what_fails_in_the_background_fails_where_it_is_read(hub: Hub, waits: list[float]) -> None:
    store = opened()
    (hub.root / MOTIONS).unlink()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        store.prefetch([MOTIONS])
        with pytest.raises(FileNotFoundError, match=f"has no {MOTIONS}"):
            store.read(MOTIONS)


def test_a_cache_that_cannot_be_written_is_read_past(hub: Hub, cache: Path) -> None:
    """It is a file, not a folder, as even root cannot write into that."""
    cache.mkdir()
    (cache / "hub").write_text("in the way")
    store = opened()
    with pytest.raises(CacheError, match=r"cannot be written to .*; set AFFECTSIM_CACHE to a fold"):
        store.fetch(MOTIONS)
    with pytest.warns(UserWarning, match=r"cannot be written to .*; reading past the cache"):
        assert store.read(MOTIONS) == whole(hub)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert store.read(MOTIONS) == whole(hub), "said once"


class Clerk:
    """Work that waits until it may be done, and notes what was done."""

    def __init__(self) -> None:
        self.done: list[str] = []
        self.may_work = threading.Event()
        self.lock = threading.Lock()
        self.busy = self.most_busy = 0

    def __call__(self, name: str) -> None:
        with self.lock:
            self.busy += 1
            self.most_busy = max(self.busy, self.most_busy)
        assert self.may_work.wait(10.0)
        with self.lock:
            self.busy -= 1
            self.done.append(name)
        if name == "bad":
            raise ValueError(name)


def settle(before: set[threading.Thread]) -> None:
    """Waits for the end of the threads that are not of before."""
    for thread in set(threading.enumerate()) - before:
        thread.join(10.0)
        assert not thread.is_alive()


def test_each_name_is_worked_on_once_and_the_oldest_are_forgotten() -> None:
    clerk, before = Clerk(), set(threading.enumerate())
    prefetcher = Prefetcher(clerk)
    prefetcher.add(["first", "bad", *(f"{number}" for number in range(14))])
    while clerk.busy < 16:
        time.sleep(0.001)
    prefetcher.add(["first", *(f"late {number}" for number in range(600)), "late 599"])
    prefetcher.forget("late 590")
    clerk.may_work.set()
    settle(before)
    late = [name for name in clerk.done if name.startswith("late")]
    assert sorted(late) == sorted(f"late {number}" for number in range(88, 600) if number != 590)
    assert len(clerk.done) == 16 + 511
    assert clerk.most_busy == 16


def test_threads_end_with_the_work_and_start_with_it() -> None:
    clerk, before = Clerk(), set(threading.enumerate())
    clerk.may_work.set()
    prefetcher = Prefetcher(clerk)
    for number in range(3):
        prefetcher.add([str(number)])
        settle(before)
    assert clerk.done == ["0", "1", "2"]
