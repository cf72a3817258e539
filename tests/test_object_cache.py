"""The cache of Hub files: by hash, below its limit at all times, whoever uses it at once."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from affectsim_data.errors import CacheError, IntegrityError
from affectsim_data.releases import FileEntry
from affectsim_data.releases.cache_limits import cache_limit, parse_bytes
from affectsim_data.releases.file_locks import exclusive
from affectsim_data.releases.object_cache import CacheBypass, ObjectCache
from affectsim_data.releases.part_files import Delivery

KB = 1000


def payload_of(number: int, size: int = 10 * KB) -> bytes:
    """A content of its own for every number."""
    return np.random.default_rng(number).bytes(size)


def entry_of(payload: bytes) -> FileEntry:
    """What a manifest says of a content."""
    return FileEntry(len(payload), hashlib.sha256(payload).hexdigest(), rows=1)


class Source:
    """Gives a content in pieces, and notes from where it was asked."""

    def __init__(self, payload: bytes, *, piece: int = KB) -> None:
        self.payload, self.piece = payload, piece
        self.starts: list[int] = []

    def __call__(self, start: int) -> Iterator[bytes]:
        self.starts.append(start)
        for first in range(start, len(self.payload), self.piece):
            yield self.payload[first : first + self.piece]


def delivery(payload: bytes, content: Callable[[int], Iterable[bytes]] | None = None) -> Delivery:
    """A file to be had, by default from a source that has it."""
    return Delivery(entry_of(payload), content or Source(payload), label="a/file")


def put(cache: ObjectCache, *payloads: bytes) -> None:
    """Stores contents, a little apart in time."""
    for payload in payloads:
        cache.store(delivery(payload))
        time.sleep(0.002)


def get(cache: ObjectCache, payload: bytes) -> bytes | None:
    """What the cache has for a content."""
    return cache.read(entry_of(payload), label="a/file")


def held_bytes(root: Path) -> int:
    """Bytes of all files, whole and on their way, at one moment: while none comes or goes."""
    with exclusive(root / "size", patience_s=20.0):
        return sum(path.stat().st_size for path in (root / "objects").glob("*/*"))


def refuse_locks(patch: pytest.MonkeyPatch) -> None:
    """Makes every file system one without locks."""

    def refuse(fd: int, operation: int) -> None:
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS))

    patch.setattr(fcntl, "flock", refuse)


@pytest.fixture(params=["with locks", "without locks"])
def locks(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> bool:
    """Both kinds of file system."""
    if request.param == "without locks":
        refuse_locks(monkeypatch)
    return bool(request.param == "with locks")


@given(number=st.integers(1, 10**6), unit=st.sampled_from(["", "k", "M", "G", "T"]))
def test_sizes_are_powers_of_1000_and_1024(number: int, unit: str) -> None:
    power = ["", "k", "M", "G", "T"].index(unit)
    assert parse_bytes(f"{number}{unit}B", name="x") == number * 1000**power
    assert parse_bytes(f" {number} {unit.lower()} ", name="x") == number * 1000**power
    if unit:
        assert parse_bytes(f"{number}{unit}iB", name="x") == number * 1024**power


@pytest.mark.parametrize(
    "text", ["plenty", "-5", "0", "0.1", "1e9", "5 XB", "1 i", "inf", "٣", "B"]
)
def test_what_is_no_size_is_refused(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AFFECTSIM_CACHE_LIMIT", text)
    message = "AFFECTSIM_CACHE_LIMIT must be a number of bytes above 0 such as 500MB, 20GB or 1TiB"
    with pytest.raises(ValueError, match=f"{message}, got '{text}'"):
        cache_limit()


def test_the_limit_is_32_gb_unless_set(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("AFFECTSIM_CACHE_LIMIT", raising=False)
    assert cache_limit() == 32 * 10**9
    monkeypatch.setenv("AFFECTSIM_CACHE_LIMIT", "1.5TiB")
    assert cache_limit() == 3 * 2**39


@pytest.mark.usefixtures("locks")
def test_what_is_stored_is_read_and_nothing_else_is_there(tmp_path: Path) -> None:
    cache, payload = ObjectCache(tmp_path, max_bytes=20 * KB), payload_of(0)
    assert get(cache, payload) is None
    assert not cache.has(entry_of(payload))
    put(cache, payload)
    assert get(cache, payload) == payload
    assert cache.has(entry_of(payload))
    digest = entry_of(payload).sha256
    files = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.*")}
    assert cache.path(entry_of(payload)) == tmp_path / "objects" / digest[:2] / digest
    assert files == set(), "no file on its way, no lock"
    assert int((tmp_path / "size").read_text()) == len(payload)


@pytest.mark.usefixtures("locks")
def test_an_empty_file_is_a_file(tmp_path: Path) -> None:
    cache = ObjectCache(tmp_path, max_bytes=KB)
    put(cache, b"", payload_of(1, KB))
    assert get(cache, b"") == b""


@pytest.mark.usefixtures("locks")
def test_the_least_recently_used_goes_first(tmp_path: Path) -> None:
    payloads = [payload_of(number) for number in range(4)]
    cache = ObjectCache(tmp_path, max_bytes=35 * KB)
    put(cache, *payloads[:3])
    assert get(cache, payloads[0]) == payloads[0]
    put(cache, payloads[3])
    held = [get(cache, payload) is not None for payload in payloads]
    assert held == [True, False, True, True], "the first was read after the second"


def test_a_file_in_use_stays(tmp_path: Path) -> None:
    first, second, third = (payload_of(number) for number in range(3))
    cache = ObjectCache(tmp_path, max_bytes=20 * KB)
    put(cache, first, second)
    with cache.path(entry_of(first)).open("rb") as reader:
        fcntl.flock(reader, fcntl.LOCK_SH)
        put(cache, third)
        assert cache.has(entry_of(first))
        assert not cache.has(entry_of(second))


def test_when_all_are_in_use_the_file_is_not_taken(tmp_path: Path) -> None:
    first, second = payload_of(1), payload_of(2)
    cache = ObjectCache(tmp_path, max_bytes=15 * KB)
    put(cache, first)
    with cache.path(entry_of(first)).open("rb") as reader:
        fcntl.flock(reader, fcntl.LOCK_SH)
        source = Source(second)
        with pytest.raises(CacheBypass, match=r"no room .* for 10000 bytes: all of the 10000"):
            cache.store(delivery(second, source))
        assert source.starts == [], "room comes first"
    assert held_bytes(tmp_path) == len(first), "nothing is left of the attempt"
    put(cache, second)
    assert get(cache, second) == second


def test_a_file_larger_than_the_cache_is_refused(tmp_path: Path) -> None:
    cache = ObjectCache(tmp_path / "cache", max_bytes=9999)
    message = f"a/file has 10000 bytes, .* {tmp_path}/cache may hold: 9999; set AFFECTSIM_CACHE_LIM"
    with pytest.raises(CacheError, match=message):
        put(cache, payload_of(0))
    assert not (tmp_path / "cache").exists()


@pytest.mark.usefixtures("locks")
@pytest.mark.parametrize("broken", [b"", payload_of(9), payload_of(0)[:-1], payload_of(0) + b"x"])
def test_what_is_not_as_promised_is_not_kept(tmp_path: Path, broken: bytes) -> None:
    cache, payload = ObjectCache(tmp_path, max_bytes=20 * KB), payload_of(0)
    with pytest.raises(IntegrityError, match=r"^a/file: expected .*; what the Hub serves is not"):
        cache.store(delivery(payload, Source(broken)))
    assert held_bytes(tmp_path) == 0 == int((tmp_path / "size").read_text())
    put(cache, payload)
    assert get(cache, payload) == payload


@pytest.mark.usefixtures("locks")
def test_a_damaged_file_is_removed_and_counted_off(tmp_path: Path) -> None:
    cache, payload = ObjectCache(tmp_path, max_bytes=20 * KB), payload_of(0)
    put(cache, payload)
    cache.path(entry_of(payload)).write_bytes(payload_of(9))
    with pytest.raises(IntegrityError, match=r"^a/file: expected SHA-256 .* the local copy is dam"):
        get(cache, payload)
    assert get(cache, payload) is None
    assert int((tmp_path / "size").read_text()) == 0


class Cut(Exception):
    """A connection that broke."""


def cut_after(source: Source, num_bytes: int) -> Callable[[int], Iterator[bytes]]:
    """The source, until it breaks."""

    def content(start: int) -> Iterator[bytes]:
        for chunk in source(start):
            if start >= num_bytes:
                raise Cut
            start += len(chunk)
            yield chunk

    return content


def test_a_file_that_was_cut_is_taken_up_where_it_was(tmp_path: Path) -> None:
    cache, payload = ObjectCache(tmp_path, max_bytes=10 * KB), payload_of(0)
    source = Source(payload)
    with pytest.raises(Cut):
        cache.store(delivery(payload, cut_after(source, 4 * KB)))
    assert held_bytes(tmp_path) == 4 * KB == int((tmp_path / "size").read_text())
    cache.store(delivery(payload, source))
    assert source.starts == [0, 4 * KB]
    assert get(cache, payload) == payload
    assert int((tmp_path / "size").read_text()) == len(payload)


def test_without_locks_nothing_is_left_of_a_file_that_was_cut(tmp_path: Path, locks: bool) -> None:
    cache, payload = ObjectCache(tmp_path, max_bytes=10 * KB), payload_of(0)
    with pytest.raises(Cut):
        cache.store(delivery(payload, cut_after(Source(payload), 4 * KB)))
    assert held_bytes(tmp_path) == (4 * KB if locks else 0)


def test_a_beginning_nobody_wants_any_more_makes_room(tmp_path: Path) -> None:
    cache = ObjectCache(tmp_path, max_bytes=10 * KB)
    with pytest.raises(Cut):
        cache.store(delivery(payload_of(0), cut_after(Source(payload_of(0)), 4 * KB)))
    put(cache, payload_of(1))
    assert held_bytes(tmp_path) == 10 * KB


@pytest.mark.parametrize("text", ["", "garbage", "-5", "0", "00000000000000000000\n", "9" * 20])
def test_a_counter_that_is_wrong_is_measured_anew(tmp_path: Path, text: str) -> None:
    put(ObjectCache(tmp_path, max_bytes=25 * KB), payload_of(0), payload_of(1))
    (tmp_path / "size").write_text(text)
    put(ObjectCache(tmp_path, max_bytes=25 * KB), payload_of(2))
    assert held_bytes(tmp_path) == 20 * KB == int((tmp_path / "size").read_text())


def test_a_lower_limit_holds_at_the_next_file(tmp_path: Path) -> None:
    put(ObjectCache(tmp_path, max_bytes=100 * KB), *(payload_of(number) for number in range(9)))
    put(ObjectCache(tmp_path, max_bytes=25 * KB), payload_of(9))
    assert held_bytes(tmp_path) <= 25 * KB


def test_a_file_another_thread_is_fetching_is_waited_for(tmp_path: Path) -> None:
    cache, payload = ObjectCache(tmp_path, max_bytes=20 * KB), payload_of(0)
    begun, go_on = threading.Event(), threading.Event()

    def slowly(start: int) -> Iterator[bytes]:
        yield payload[:KB]
        begun.set()
        assert go_on.wait(10.0)
        yield payload[KB:]

    first = threading.Thread(target=cache.store, args=(delivery(payload, slowly),))
    first.start()
    assert begun.wait(10.0)
    source = Source(payload)
    second = threading.Thread(target=cache.store, args=(delivery(payload, source),))
    second.start()
    second.join(0.1)
    assert second.is_alive()
    go_on.set()
    first.join(10.0)
    second.join(10.0)
    assert source.starts == []
    assert get(cache, payload) == payload


def test_a_process_that_stands_still_is_not_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("affectsim_data.releases.part_files._STALL_S", 0.05)
    cache, payload = ObjectCache(tmp_path, max_bytes=20 * KB), payload_of(0)
    with pytest.raises(Cut):
        cache.store(delivery(payload, cut_after(Source(payload), 4 * KB)))
    (part,) = tmp_path.rglob("*.partial")
    with part.open("rb") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        with pytest.raises(CacheBypass, match=r"another process has not got on .* stopped"):
            put(cache, payload)


def refusing(code: int, *, flags: int) -> Callable[..., Any]:
    """`os.open` on a file system that refuses some ways of opening a file."""
    real = os.open

    def open_(path: Any, how: int, *options: Any) -> int:
        if how & flags:
            raise OSError(code, os.strerror(code), path)
        return real(path, how, *options)

    return open_


def test_a_read_only_cache_gives_what_it_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache, here, elsewhere = ObjectCache(tmp_path, max_bytes=20 * KB), payload_of(0), payload_of(1)
    put(cache, here)
    # As root may write anywhere, the folder only says that it is read-only.
    monkeypatch.setattr(os, "open", refusing(errno.EROFS, flags=os.O_RDWR | os.O_CREAT))

    def keep_times(fd: int) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(os, "utime", keep_times)
    assert get(cache, here) == here
    with pytest.raises(
        CacheBypass, match=f"a/file is not in the cache {tmp_path}, .* AFFECTSIM_CA"
    ):
        put(cache, elsewhere)


def test_a_full_disk_says_so_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache, payload, real = ObjectCache(tmp_path, max_bytes=20 * KB), payload_of(0), os.write

    def write(fd: int, data: bytes) -> int:
        if os.fstat(fd).st_size + len(data) > 5 * KB:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return real(fd, data)

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", write)
        message = f"a/file does not fit on the disk of the cache {tmp_path} .*No space"
        with pytest.raises(CacheError, match=message):
            put(cache, payload)
    assert held_bytes(tmp_path) == 0 == int((tmp_path / "size").read_text())


_HAMMER = """
import errno, fcntl, os, sys
import numpy as np
from pathlib import Path
from test_object_cache import delivery, entry_of, payload_of
from affectsim_data.releases.object_cache import CacheBypass, ObjectCache
root, seed, limit, locks = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
if locks == "without":
    def refuse(fd, operation):
        raise OSError(errno.ENOSYS, "")
    fcntl.flock = refuse
rng = np.random.default_rng(seed)
cache = ObjectCache(root, max_bytes=limit)
payloads = [payload_of(number, size=1000 * (1 + number % 10)) for number in range(30)]
count = fetched = past = 0
while count < 80:
    payload = payloads[rng.integers(len(payloads))]
    found = cache.read(entry_of(payload), label="x")
    if found is None:
        try:
            cache.store(delivery(payload))
            fetched += 1
        except CacheBypass:
            past += 1
        continue
    assert found == payload
    count += 1
print(fetched, past)
"""


def test_two_processes_under_a_limit_smaller_than_what_they_need(
    tmp_path: Path, locks: bool
) -> None:
    limit, most, clients = 40 * KB, 0, []
    kind = "with" if locks else "without"
    (tmp_path / "objects").mkdir()
    for seed in (1, 2):
        command = [sys.executable, "-c", _HAMMER, str(tmp_path), str(seed), str(limit), kind]
        clients.append(subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE))
    while any(client.poll() is None for client in clients):
        most = max(most, held_bytes(tmp_path))
        time.sleep(0.005)
    for client in clients:
        out, err = client.communicate()
        assert client.returncode == 0, err.decode()
        assert int(out.split()[0]) > 50, "the limit was felt"
    assert 0.5 * limit < most <= limit
    assert held_bytes(tmp_path) <= int((tmp_path / "size").read_text()) <= limit
    assert not list(tmp_path.rglob("*.partial"))
