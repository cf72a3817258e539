"""The text of OBJ files as arrays, without a Python loop over its lines."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray

__all__ = ["ObjText", "numbers", "words"]

IntArray = NDArray[np.int64]
_LONGEST_NUMBER = 40
_NEWLINE, _SPACE = 10, 32


@dataclasses.dataclass(frozen=True)
class ObjText:
    """An OBJ's bytes and where its lines begin and end."""

    data: bytes
    starts: IntArray
    """First byte of every line that is not blank, after its indent, `(num_lines,)`."""
    ends: IntArray
    """One past its last byte."""
    bytes_: NDArray[np.uint8]
    """`data` as an array."""

    @classmethod
    def from_bytes(cls, payload: bytes) -> ObjText:
        """Splits into lines; a backslash at the end of a line joins the next to it.

        Raises:
            ValueError: It is not text.
        """
        if b"\0" in payload[:4096]:
            raise ValueError("an OBJ is text, got binary data")
        data = payload.replace(b"\r\n", b"\n").replace(b"\r", b"\n").replace(b"\\\n", b"  ") + b"\n"
        array = np.frombuffer(data, np.uint8)
        ends = np.flatnonzero(array == _NEWLINE)
        begins = np.concatenate([[0], ends[:-1] + 1])
        solid = np.flatnonzero(array > _SPACE)
        place = np.searchsorted(solid, begins)
        real = place < len(solid)
        starts = np.full(len(begins), len(data))
        starts[real] = solid[place[real]]
        kept = starts < ends
        return cls(data, starts[kept], ends[kept], array)

    def lines_of(self, keyword: bytes) -> IntArray:
        """Numbers of the lines that begin with `keyword` and white space."""
        found = np.ones(len(self.starts), bool)
        last = len(self.data) - 1
        for k, letter in enumerate(keyword):
            found &= self.bytes_[np.minimum(self.starts + k, last)] == letter
        after = self.bytes_[np.minimum(self.starts + len(keyword), last)]
        return np.flatnonzero(found & (after <= _SPACE))

    def text_of(self, lines: IntArray, keyword: bytes) -> list[bytes]:
        """What follows the keyword on each line."""
        skip = len(keyword)
        return [
            self.data[start + skip : end].strip()
            for start, end in zip(self.starts[lines], self.ends[lines], strict=True)
        ]

    def joined(self, lines: IntArray, keyword: bytes) -> NDArray[np.uint8]:
        """What follows the keyword on those lines, one after the other, newlines kept."""
        marks = np.zeros(len(self.data) + 1, np.int8)
        # Lines do not overlap, so sums of these marks are 0 or 1.
        marks[self.starts[lines] + len(keyword)] += 1
        marks[self.ends[lines] + 1] -= 1
        inside = np.cumsum(marks[:-1], dtype=np.int8).astype(bool)
        chosen: NDArray[np.uint8] = self.bytes_[inside]
        return chosen


def words(text: NDArray[np.uint8]) -> tuple[IntArray, IntArray]:
    """First byte of every word, and the number of the line it stands on."""
    solid = text > _SPACE
    starts = np.flatnonzero(solid & ~np.concatenate([[False], solid[:-1]]))
    line_ends = np.flatnonzero(text == _NEWLINE)
    return starts, np.searchsorted(line_ends, starts)


def numbers(text: bytes, *, what: str) -> FloatArray:
    """All numbers of a text, `(n,)`.

    Raises:
        ValueError: A word is not a number; the message names `what`.
    """
    found = text.split()
    if not found:
        return np.zeros(0)
    if max(map(len, found)) > _LONGEST_NUMBER:
        raise ValueError(f"{what}: a number has more than {_LONGEST_NUMBER} characters")
    try:
        return np.array(found).astype(np.float64)
    except ValueError as error:
        raise ValueError(f"{what}: {error}") from error
