"""The HIERARCHY block and the two header lines of the MOTION block of a BVH file."""

from __future__ import annotations

import dataclasses
import math
from typing import NoReturn

__all__ = ["BvhError", "BvhHeader", "read_header"]

MAX_JOINTS = 512
MAX_FRAMES = 2_000_000
CHANNELS = tuple(f"{axis}{kind}" for kind in ("position", "rotation") for axis in "XYZ")


class BvhError(ValueError):
    """A file is not a complete, consistent BVH file."""


@dataclasses.dataclass(frozen=True)
class BvhHeader:
    """All of a BVH file but its numbers; fields as in `BvhClip`."""

    joint_names: tuple[str, ...]
    joint_parents: tuple[int, ...]
    offsets: tuple[tuple[float, float, float], ...]
    end_sites: dict[str, tuple[float, float, float]]
    channels: tuple[tuple[str, ...], ...]
    num_frames: int
    frame_time_s: float
    first_row: int
    """Index of the first line after `Frame Time:`."""


@dataclasses.dataclass
class _Tokens:
    """Words of a file with the lines they stand on, read one after the other."""

    name: str
    words: list[tuple[str, int]]
    at: int = 0

    def next(self, wanted: str) -> str:
        if self.at >= len(self.words):
            line = self.words[-1][1] if self.words else 0
            raise BvhError(
                f"{self.name}: line {line}: expected {wanted}, got the end of the hierarchy"
            )
        self.at += 1
        return self.words[self.at - 1][0]

    def keyword(self, *wanted: str) -> str:
        word = self.next(" or ".join(wanted))
        if word.upper() not in wanted:
            self.fail(" or ".join(wanted), word)
        return word.upper()

    def number(self, wanted: str) -> float:
        word = self.next(wanted)
        try:
            value = float(word)
        except ValueError:
            self.fail(wanted, word)
        if not math.isfinite(value):
            self.fail(f"{wanted} that is finite", word)
        return value

    def offset(self) -> tuple[float, float, float]:
        self.keyword("OFFSET")
        x, y, z = (self.number("a number after OFFSET") for _ in range(3))
        return x, y, z

    def fail(self, wanted: str, got: str) -> NoReturn:
        line = self.words[self.at - 1][1]
        raise BvhError(f"{self.name}: line {line}: expected {wanted}, got {got[:80]!r}")


def read_header(lines: list[str], *, name: str) -> BvhHeader:
    """The header of a BVH file given as lines.

    Raises:
        BvhError: The header is not one; the message starts with `name`.
    """
    motion = next((i for i, line in enumerate(lines) if line.strip().upper() == "MOTION"), None)
    if motion is None:
        raise BvhError(f"{name}: expected a MOTION block, got none in {len(lines)} lines")
    words = [(word, i + 1) for i, line in enumerate(lines[:motion]) for word in line.split()]
    tokens = _Tokens(name, words)
    tokens.keyword("HIERARCHY")
    tokens.keyword("ROOT")
    joints = _Joints()
    _read_joints(tokens, joints)
    if tokens.at != len(words):
        tokens.next("MOTION")
        tokens.fail("MOTION (one ROOT per file)", words[tokens.at - 1][0])
    num_frames, frame_time_s, first_row = _read_timing(lines, motion + 1, name=name)
    return BvhHeader(
        tuple(joints.names),
        tuple(joints.parents),
        tuple(joints.offsets),
        joints.end_sites,
        tuple(joints.channels),
        num_frames,
        frame_time_s,
        first_row,
    )


@dataclasses.dataclass
class _Joints:
    """Joints read so far."""

    names: list[str] = dataclasses.field(default_factory=list)
    parents: list[int] = dataclasses.field(default_factory=list)
    offsets: list[tuple[float, float, float]] = dataclasses.field(default_factory=list)
    channels: list[tuple[str, ...]] = dataclasses.field(default_factory=list)
    end_sites: dict[str, tuple[float, float, float]] = dataclasses.field(default_factory=dict)


def _read_joints(tokens: _Tokens, joints: _Joints) -> None:
    """Reads the root, whose keyword has just been read, and all below it; no recursion, so that
    a deep hierarchy cannot exhaust the stack."""
    open_joints = [_read_joint(tokens, joints, parent=-1)]
    while open_joints:
        word = tokens.keyword("JOINT", "END", "}")
        if word == "JOINT":
            open_joints.append(_read_joint(tokens, joints, parent=open_joints[-1]))
        elif word == "END":
            tokens.keyword("SITE")
            tokens.keyword("{")
            joints.end_sites[joints.names[open_joints[-1]]] = tokens.offset()
            tokens.keyword("}")
        else:
            open_joints.pop()


def _read_joint(tokens: _Tokens, joints: _Joints, *, parent: int) -> int:
    """Reads name, offset and channels of one joint; gives its index."""
    joint = tokens.next("a joint name")
    if joint in joints.names:
        tokens.fail("joint names that differ", joint)
    if len(joints.names) >= MAX_JOINTS:
        tokens.fail(f"at most {MAX_JOINTS} joints", joint)
    tokens.keyword("{")
    offset = tokens.offset()
    tokens.keyword("CHANNELS")
    count = tokens.next("the number of channels")
    if count not in {str(n) for n in range(7)}:
        tokens.fail(f"0 to 6 channels for joint {joint!r}", count)
    channels: list[str] = []
    for _ in range(int(count)):
        channel = tokens.next("a channel name")
        if channel not in CHANNELS:
            tokens.fail(f"one of {', '.join(CHANNELS)} for joint {joint!r}", channel)
        if channel in channels:
            tokens.fail(f"channels that differ for joint {joint!r}", channel)
        channels.append(channel)
    joints.names.append(joint)
    joints.parents.append(parent)
    joints.offsets.append(offset)
    joints.channels.append(tuple(channels))
    return len(joints.names) - 1


def _read_timing(lines: list[str], at: int, *, name: str) -> tuple[int, float, int]:
    """Number of frames, seconds between frames, index of the first line of numbers."""
    found: list[str] = []
    for key in ("Frames:", "Frame Time:"):
        while at < len(lines) and not lines[at].strip():
            at += 1
        line = lines[at].strip() if at < len(lines) else "the end of the file"
        if not line.lower().startswith(key.lower()):
            raise BvhError(f"{name}: line {at + 1}: expected {key!r}, got {line[:80]!r}")
        found.append(line[len(key) :].strip())
        at += 1
    count, step = found
    if not count.isascii() or not count.isdigit() or not 1 <= int(count[:12]) <= MAX_FRAMES:
        raise BvhError(f"{name}: expected 1 to {MAX_FRAMES} after 'Frames:', got {count[:80]!r}")
    try:
        frame_time_s = float(step)
    except ValueError:
        frame_time_s = math.nan
    if not 1e-4 <= frame_time_s <= 10.0:
        raise BvhError(
            f"{name}: expected 0.0001 to 10 seconds after 'Frame Time:', got {step[:80]!r}"
        )
    return int(count), frame_time_s, at
