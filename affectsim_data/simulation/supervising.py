"""A policy in a process of its own: one that hangs or dies costs its own episode only."""

from __future__ import annotations

import contextlib
import math
import multiprocessing
import signal
import time
from collections.abc import Iterator
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from types import TracebackType
from typing import Any

import pyarrow as pa

from affectsim_data.schemas import SCHEMAS
from affectsim_data.simulation.acting import (
    Asking,
    Broken,
    Ended,
    Failed,
    Job,
    Message,
    Note,
    act_on_request,
)
from affectsim_data.simulation.recording import EpisodeRecord

__all__ = ["EpisodeProcess"]

_GRACE_S = 1.0
"""Beyond its time, until a policy that does not come back is ended."""
_LOOK_S = 0.25
"""How often the notes are read while an episode goes on; more would keep this process busy."""


class _DiedError(Exception):
    """The process is gone; says how."""


class EpisodeProcess:
    """A process that acts in one episode after the other; a new one takes the place of a lost one.

    It keeps its scenes and its renderer, so episodes of a scene should follow each other.
    """

    def __init__(self, job: Job) -> None:
        """Starts nothing yet."""
        self.job = job
        self._process: BaseProcess | None = None
        self._connection: Connection | None = None
        self._notes: Connection | None = None

    def record(self, place: int) -> EpisodeRecord:
        """What became of the episode at a place of the split.

        A process that dies in an episode may have died of something else, short memory say: it is
        given a second chance. One that hangs is not.

        Raises:
            ChildProcessError: No process comes up at all.
            Exception: What is wrong with the release, the renderer or the policy as a whole.
        """
        for chance in (1, 2):
            try:
                return self._ask(place)
            except _DiedError as error:
                self.close()
                if chance == 2:
                    return self._failed([], place, str(error))
        raise AssertionError("not reached")

    def _ask(self, place: int) -> EpisodeRecord:
        connection, notes = self._connected()
        rows: list[dict[str, Any]] = []
        until_s = math.inf
        self._send(connection, place)
        while True:
            message = self._receive(connection, _LOOK_S)
            # Read until nothing is left, even when all is over: the next episode's follow.
            for note in _read(notes):
                # When it has answered, it draws, or reads a scene: that takes as long as it takes.
                until_s = note.until_s if isinstance(note, Asking) else math.inf
                rows += note.rows if isinstance(note, Asking) else []
            if isinstance(message, Ended):
                return self._ended(message, place)
            if isinstance(message, Failed):
                return self._failed(message.rows, place, message.reason)
            if time.monotonic() > until_s + _GRACE_S:
                self.close()
                limit = f"{self.job.max_policy_time_s:g} s"
                return self._failed(rows, place, f"took more than {limit} to decide; was ended")

    def _ended(self, message: Ended, place: int) -> EpisodeRecord:
        episode_id = self.job.episodes.episode(place).episode_id
        rows = pa.Table.from_pylist(message.rows, schema=SCHEMAS["trajectories"])
        return EpisodeRecord(episode_id, self.job.name, message.outcome, rows)

    def _failed(self, rows: list[dict[str, Any]], place: int, reason: str) -> EpisodeRecord:
        episode = self.job.episodes.episode(place)
        return EpisodeRecord.of_failure(rows, reason, episode, policy=self.job.name)

    def _connected(self) -> tuple[Connection, Connection]:
        """The lines to a process that is ready: for messages and for notes."""
        if self._connection is not None and self._notes is not None:
            return self._connection, self._notes
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._notes, their_notes = context.Pipe(duplex=False)
        self._process = context.Process(
            target=act_on_request, args=(self.job, theirs, their_notes), daemon=True
        )
        with _without_interrupts():
            self._process.start()
        theirs.close()
        their_notes.close()
        try:
            self._receive(self._connection, None)
        except _DiedError as error:
            self.close()
            raise ChildProcessError(
                f"a process for {self.job.name!r} does not start: {error}"
            ) from error
        return self._connection, self._notes

    def _send(self, connection: Connection, place: int) -> None:
        try:
            connection.send(place)
        except (BrokenPipeError, ConnectionResetError):
            raise _DiedError(self._how_it_died()) from None

    def _receive(self, connection: Connection, patience_s: float | None) -> Message | None:
        """The next message, `None` if patience ran out."""
        try:
            if not connection.poll(patience_s):
                return None
            message: Message = connection.recv()
        except (EOFError, ConnectionResetError, BrokenPipeError):
            raise _DiedError(self._how_it_died()) from None
        if isinstance(message, Broken):
            self.close()
            raise message.error
        return message

    def _how_it_died(self) -> str:
        assert self._process is not None
        self._process.join()
        status = self._process.exitcode or 0
        how = f"killed by {signal.Signals(-status).name}" if status < 0 else f"status {status}"
        return f"its process died twice in this episode: {how}"

    def close(self) -> None:
        """Ends the process, whatever it is about."""
        for line in (self._connection, self._notes):
            if line is not None:
                line.close()
        if self._process is not None:
            if self._process.pid is not None:  # else it did not even start
                self._process.kill()
                self._process.join()
            self._process.close()
        self._process, self._connection, self._notes = None, None, None

    def __enter__(self) -> EpisodeProcess:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _read(notes: Connection) -> Iterator[Note]:
    """What has been written until now."""
    with contextlib.suppress(EOFError, ConnectionResetError):  # the other line tells of the end
        while notes.poll():
            yield notes.recv()


@contextlib.contextmanager
def _without_interrupts() -> Iterator[None]:
    """Ctrl-C waits until this is over, and never reaches a process that is started meanwhile."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
