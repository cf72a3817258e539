"""What still cameras saw of scenes without people: kept, because datasets come back to them."""

from __future__ import annotations

import dataclasses
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["MAX_BYTES", "Background", "BackgroundCache"]

MAX_BYTES = 96 * 2**20
"""Some fifty views of 224 x 224: every monitor of a few homes, and the starts of a small split."""


@dataclasses.dataclass
class Background:
    """A scene from one still camera."""

    tile: Any
    """Framebuffer with its samples, on the device."""
    rgb: NDArray[np.uint8]
    """Resolved, `(height, width, 3)`."""
    depth: NDArray[np.float32]
    """Resolved, metres, `(height, width)`."""
    free: Callable[[Any], None]
    """Frees a framebuffer with what is attached to it."""

    @property
    def num_bytes(self) -> int:
        """Of the device and of the process; a sample has 4 bytes of colour and 4 of depth."""
        samples = int(self.tile.width * self.tile.height)
        return 8 * samples + self.rgb.nbytes + self.depth.nbytes


class BackgroundCache:
    """Least recently used out first, up to a number of bytes."""

    def __init__(self, max_bytes: int) -> None:
        self._max_bytes = max_bytes
        self._entries: OrderedDict[Hashable, Background] = OrderedDict()
        self.num_bytes = 0

    def get(self, key: Hashable, draw: Callable[[], Background]) -> Background:
        """The background of `key`, drawn if it is not there; the newest is always kept."""
        if key not in self._entries:
            drawn = draw()
            self._entries[key] = drawn
            self.num_bytes += drawn.num_bytes
            while self.num_bytes > self._max_bytes and len(self._entries) > 1:
                self._drop(next(iter(self._entries)))
        self._entries.move_to_end(key)
        return self._entries[key]

    def clear(self) -> None:
        """Frees everything."""
        for key in list(self._entries):
            self._drop(key)

    def _drop(self, key: Hashable) -> None:
        entry = self._entries.pop(key)
        self.num_bytes -= entry.num_bytes
        entry.free(entry.tile)
