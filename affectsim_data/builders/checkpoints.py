"""The folder a build works in, beside what it makes: units that are done, so that none is redone.

.NAME.partial/
    BUILD.json                       what is built here: a hash of all that decides it
    lock                             held by the one process that builds here
    motions/00012-KEY-HASH.parquet   units, each written whole or not at all
    scenes/... episodes/...
    release/                         the release while it is written
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import shutil
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, get_type_hints

from affectsim_data.builders.units import pack_unit, unpack_unit
from affectsim_data.releases.file_locks import opened, try_lock

__all__ = ["Checkpoints", "Unit", "result_type", "staging_folder", "unit_key"]

_ABOUT = "BUILD.json"
_LOCK = "lock"
_FORMAT = 1
_DIGITS = 16
"""Of a hash in a file's name."""


class Checkpoints:
    """The units of one build that are done; a context manager that holds the folder's lock.

    Leaving it without an error removes the folder. Leaving it by an error does so too, unless
    something is in it that the same command would use again, and then says so. What a `ValueError`
    or a `FileNotFoundError` names is wrong with the recipe or what it reads: nothing made of that
    is of use.
    """

    def __init__(
        self, out: Path, fingerprint: str, *, say: Callable[[str], None] = lambda _: None
    ) -> None:
        """Touches nothing yet.

        Args:
            out: Where the release will be.
            fingerprint: Of all that decides what is built.
            say: Called with a line when something is found here.
        """
        self.folder = staging_folder(out)
        self.keep = False
        """Whether a `ValueError` leaves the units, too: another option goes on from them."""
        self._out = out.resolve()
        self._fingerprint = fingerprint
        self._say = say
        self._stack = contextlib.ExitStack()
        self._there: dict[str, dict[str, Path]] = {}

    def __enter__(self) -> Checkpoints:
        """Takes the folder, and empties it of what another build left.

        Raises:
            BlockingIOError: Another process builds here.
        """
        self._out.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.ExitStack() as stack:
            stack.enter_context(self._locked())
            self._stack = stack.pop_all()
        about = {"format": _FORMAT, "fingerprint": self._fingerprint}
        done = self.done()
        if self._about() == about:
            if done:
                self._say(f"{self._out}: going on; done before: {done}")
            return self
        if done:
            self._say(
                f"{self.folder}: left by a build of another recipe, source or version; "
                "starting anew"
            )
        self._clear()
        _write(self.folder / _ABOUT, json.dumps(about, indent=2).encode())
        return self

    def done(self) -> str:
        """How many units of each stage are here, in words; empty for none."""
        counts = Counter(path.parent.name for path in self.folder.glob("*/*-*-*.parquet"))
        return ", ".join(f"{count} {stage}" for stage, count in counts.items())

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        useless = isinstance(error, ValueError | FileNotFoundError) and not self.keep
        done = "" if error is None or useless else self.done()
        if done:
            self._say(
                f"{self._out}: {done} are done; the same command goes on from there "
                f"(remove {self.folder} to start anew)"
            )
        else:
            shutil.rmtree(self.folder, ignore_errors=True)
        self._stack.close()

    @contextlib.contextmanager
    def _locked(self) -> Iterator[None]:
        """The lock; that of a folder which was removed meanwhile is none."""
        path = self.folder / _LOCK
        while True:
            self.folder.mkdir(exist_ok=True)
            with contextlib.ExitStack() as stack:
                try:
                    lock = stack.enter_context(opened(path, os.O_RDWR | os.O_CREAT))
                except FileNotFoundError:
                    continue
                if try_lock(lock) is False:
                    raise BlockingIOError(
                        f"{self._out}: another build writes there now; wait for it, or choose "
                        "another --out"
                    )
                if _is_at(lock, path):
                    yield
                    return

    def _about(self) -> Any:
        try:
            return json.loads((self.folder / _ABOUT).read_bytes())
        except (FileNotFoundError, ValueError):
            return None

    def _clear(self) -> None:
        for path in self.folder.iterdir():
            if path.is_dir():
                shutil.rmtree(path)
            elif path.name != _LOCK:
                path.unlink()

    def units(self, stage: str, keys: Sequence[str], kind: Any) -> list[Unit]:
        """The units of a stage, done or not.

        Args:
            stage: Its name, that of a folder.
            keys: What each unit is made of, see `unit_key`.
            kind: Type of their results.
        """
        folder = self.folder / stage
        if stage not in self._there:
            folder.mkdir(exist_ok=True)
            self._there[stage] = _whole_files(folder)
        names = [f"{place:05d}-{key[:_DIGITS]}" for place, key in enumerate(keys)]
        return [Unit(folder, name, kind, self._there[stage].get(name)) for name in names]


class Unit:
    """A unit of a build, of which there may be a result."""

    def __init__(self, folder: Path, name: str, kind: Any, path: Path | None) -> None:
        self._folder = folder
        self._name = name
        self._kind = kind
        self._path = path

    @property
    def is_done(self) -> bool:
        """Whether there is a result."""
        return self._path is not None

    def write(self, result: Any) -> None:
        """Stores the result; from here on no kill can lose it."""
        payload = pack_unit(result)
        path = self._folder / f"{self._name}-{_digest(payload)}.parquet"
        _write(path, payload)
        self._path = path

    def read(self) -> Any:
        """The result as it is stored, no matter which run made it."""
        assert self._path is not None
        return unpack_unit(self._path.read_bytes(), self._kind)


def staging_folder(out: Path) -> Path:
    """Where a build of `out` keeps what it needs until it is over."""
    out = out.resolve()
    return out.parent / f".{out.name}.partial"


def unit_key(*parts: object) -> str:
    """Names what a unit is made of: a hash of the parts' representations, which must tell all."""
    return hashlib.sha256("\0".join(map(repr, parts)).encode()).hexdigest()


def result_type(task: Callable[..., Any]) -> Any:
    """What a function, or a partial one, says it returns."""
    return get_type_hints(getattr(task, "func", task))["return"]


def _whole_files(folder: Path) -> dict[str, Path]:
    """Files of units by name; those whose bytes are not what their name promises are removed."""
    whole: dict[str, Path] = {}
    for path in sorted(folder.iterdir()):
        name, _, digest = path.stem.rpartition("-")
        if path.suffix == ".parquet" and digest == _digest(path.read_bytes()):
            whole[name] = path
        else:
            path.unlink()
    return whole


def _is_at(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False


def _digest(payload: bytes) -> str:
    return hashlib.sha256(payload).hexdigest()[:_DIGITS]


def _write(path: Path, payload: bytes) -> None:
    """A file, whole or not there; should the power fail, at worst it is not there."""
    half = path.with_name(f"{path.name}.tmp")
    with half.open("wb") as stream:
        stream.write(payload)
        stream.flush()
        os.fsync(stream.fileno())
    os.replace(half, path)
