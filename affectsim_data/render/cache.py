"""A cache of device buffers, bounded by bytes, keyed by the identity of what was uploaded."""

from __future__ import annotations

import weakref
from collections import OrderedDict
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

__all__ = ["BufferCache", "Buffers"]


class Buffers(Protocol):
    """What the cache holds."""

    num_bytes: int

    def release(self) -> None:
        """Frees the device memory."""
        ...


B = TypeVar("B", bound=Buffers)


class BufferCache(Generic[B]):
    """Least recently used first out; an entry also goes when the object it was made from dies.

    Identity, because hashing a scene costs more than drawing it. A weak reference tells a dead
    object from a new one at the same address, and keeps no scene alive.
    """

    def __init__(self, max_bytes: int) -> None:
        self.max_bytes = max_bytes
        self._entries: OrderedDict[int, tuple[weakref.ref[object], B]] = OrderedDict()

    @property
    def num_bytes(self) -> int:
        """Device memory in use."""
        return sum(buffers.num_bytes for _, buffers in self._entries.values())

    def __len__(self) -> int:
        return len(self._entries)

    def get(self, source: object, upload: Callable[[], B]) -> B:
        """The buffers of `source`; the one asked for last is kept even if it alone is too big."""
        self._drop_dead()
        entry = self._entries.get(id(source))
        if entry is None:
            entry = (weakref.ref(source), upload())
            self._entries[id(source)] = entry
        self._entries.move_to_end(id(source))
        return entry[1]

    def trim(self) -> None:
        """Frees what is over the bound; called between clips, when nothing is in use."""
        while len(self._entries) > 1 and self.num_bytes > self.max_bytes:
            _, (_, buffers) = self._entries.popitem(last=False)
            buffers.release()

    def clear(self) -> None:
        """Frees everything."""
        while self._entries:
            _, (_, buffers) = self._entries.popitem()
            buffers.release()

    def _drop_dead(self) -> None:
        # Done here and not in a weakref callback: that may run on any thread, without the context.
        for key in [key for key, (source, _) in self._entries.items() if source() is None]:
            self._entries.pop(key)[1].release()
