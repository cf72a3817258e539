"""Keeps a fork from happening while another thread is inside the HTTP client.

A child inherits every lock as it is at that moment, and no thread that would ever release it.
"""

from __future__ import annotations

import contextlib
import logging  # noqa: F401  # its hooks must be older: a thread inside may want to log
import os
import sys
import threading
from collections.abc import Iterator

__all__ = ["inside"]

_LONGEST_WAIT_S = 30.0
"""Longer than a step of the client may take by its own time limits."""


class _Gate:
    def __init__(self) -> None:
        self.condition = threading.Condition()
        self.inside: set[int] = set()
        self.closed = False


_gate = _Gate()


@contextlib.contextmanager
def inside() -> Iterator[None]:
    """For one step with the client: a fork waits for its end, and it for the end of a fork."""
    gate, me = _gate, threading.get_ident()
    with gate.condition:
        gate.condition.wait_for(lambda: not gate.closed)
        gate.inside.add(me)
    try:
        yield
    finally:
        with gate.condition:
            gate.inside.discard(me)
            gate.condition.notify_all()


def _before_fork() -> None:
    # Kept until after the fork, so that no other thread can step inside.
    _gate.condition.acquire()
    _gate.closed = True
    me = threading.get_ident()
    _gate.condition.wait_for(lambda: _gate.inside <= {me}, timeout=_LONGEST_WAIT_S)


def _after_in_parent() -> None:
    _gate.closed = False
    _gate.condition.notify_all()
    _gate.condition.release()


def _after_in_child() -> None:
    global _gate
    _gate = _Gate()
    # Its connections belong to the parent; old versions of the client do not see to it themselves.
    close = getattr(sys.modules.get("huggingface_hub.utils._http"), "close_session", None)
    if close is not None:
        close()


os.register_at_fork(
    before=_before_fork, after_in_parent=_after_in_parent, after_in_child=_after_in_child
)
