"""Who may use a renderer: the process and thread that opened it; and how a fork is survived.

A forked child inherits the memory of the driver but none of its threads, so drawing there would
wait forever. Mesa's software driver can be shut down right before the fork and opened again on
both sides afterwards, which costs some 20 ms a side and makes a stock `DataLoader` work. That needs
every renderer of the process to belong to the forking thread; otherwise, and for drivers of real
GPUs, renderers are left alone and refuse to work in the child.
"""

from __future__ import annotations

import os
import threading
import weakref
from typing import Protocol, runtime_checkable

from affectsim_data.errors import ForkedContextError
from affectsim_data.render.egl import FORK_REMEDY, terminate_displays

__all__ = ["Owner", "Suspendable", "survive_forks"]


class Owner:
    """The process and thread a renderer belongs to."""

    def __init__(self) -> None:
        self._pid = os.getpid()
        self._thread = threading.get_ident()

    @property
    def is_here(self) -> bool:
        """Whether the caller is it."""
        return self._pid == os.getpid() and self._thread == threading.get_ident()

    def check(self) -> None:
        """Raises unless the caller is it.

        Raises:
            ForkedContextError: In a child forked from the owner.
            RuntimeError: On another thread.
        """
        if self._pid != os.getpid():
            raise ForkedContextError(
                f"this renderer was opened in process {self._pid} and cannot be used after a fork "
                f"in process {os.getpid()}; {FORK_REMEDY}"
            )
        if self._thread != threading.get_ident():
            raise RuntimeError(
                "a renderer draws only on the thread that opened it; open one per process and "
                "hand the clips over, or use worker processes"
            )


@runtime_checkable
class Suspendable(Protocol):
    """A renderer as a fork sees it."""

    @property
    def is_open(self) -> bool:
        """Whether it holds a context."""
        ...

    @property
    def can_suspend(self) -> bool:
        """Whether its driver can be shut down by the calling thread."""
        ...

    def suspend(self) -> None:
        """Gives up the context, to be opened again by the next clip, in whichever process."""
        ...


_renderers: weakref.WeakSet[Suspendable] = weakref.WeakSet()
_hooked = False


def survive_forks(renderer: Suspendable | None = None) -> None:
    """Has displays shut down before this process forks, `renderer` suspended, where it is safe."""
    global _hooked
    if renderer is not None:
        _renderers.add(renderer)
    if not _hooked and hasattr(os, "register_at_fork"):
        os.register_at_fork(before=_suspend_all)
        _hooked = True


def _suspend_all() -> None:
    holding = [renderer for renderer in _renderers if renderer.is_open]
    # A display may serve several of them, so it is all or none. With none open there may still be
    # a display, with threads that a child would miss.
    if all(renderer.can_suspend for renderer in holding):
        for renderer in holding:
            renderer.suspend()
        terminate_displays()
