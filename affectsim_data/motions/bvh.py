"""A strict reader of BVH files: any hierarchy, any Euler order, one clear error for a bad file.

Conventions of the format (Meredith & Maddock 2001): channels of a joint are applied in the order
they are listed, so `Zrotation Xrotation Yrotation` is `Rz @ Rx @ Ry`; angles are degrees. Position
channels *replace* the OFFSET of their joint, root or not: adding both makes people 2.8 m tall.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from affectsim_data.motions.bvh_header import BvhError, BvhHeader, read_header
from affectsim_data.poses import (
    FloatArray,
    axis_angle_quaternion,
    quaternion_multiply,
    quaternion_rotate,
)

__all__ = ["BvhClip", "BvhError", "read_bvh"]

MAX_FILE_BYTES = 512 * 2**20
"""Longer than an hour of a 60-joint skeleton at 125 Hz; bounds what a hostile file can allocate."""


@dataclasses.dataclass(frozen=True)
class BvhClip:
    """One BVH file as it is written: its own units, its own skeleton."""

    joint_names: tuple[str, ...]
    """Names, unique, parents before children; end sites are not joints."""
    joint_parents: tuple[int, ...]
    """Index of the parent joint, -1 for the root."""
    offsets: FloatArray
    """OFFSET of each joint in its parent, file units, `(num_joints, 3)`."""
    end_sites: dict[str, tuple[float, float, float]]
    """OFFSET of the end site, file units, by the name of the joint that carries it."""
    channels: tuple[tuple[str, ...], ...]
    """Channel names per joint, in file order."""
    values: FloatArray
    """The MOTION block, `(num_frames, num_channels)`; file units and degrees."""
    frame_time_s: float
    """Seconds between frames."""

    @property
    def num_frames(self) -> int:
        """Frames of the clip."""
        return len(self.values)

    def local_positions(self) -> FloatArray:
        """Joint positions in their parents, file units, `(num_frames, num_joints, 3)`."""
        positions = np.tile(self.offsets, (self.num_frames, 1, 1))
        for joint, start, names in self._columns():
            for column, name in enumerate(names, start):
                if name.endswith("position"):
                    positions[:, joint, "XYZ".index(name[0])] = self.values[:, column]
        return positions

    def local_rotations(self) -> FloatArray:
        """Joint rotations in their parents, unit `wxyz`, `(num_frames, num_joints, 4)`."""
        rotations = np.zeros((self.num_frames, len(self.joint_names), 4))
        rotations[..., 0] = 1.0
        for joint, start, names in self._columns():
            for column, name in enumerate(names, start):
                if name.endswith("rotation"):
                    axis = np.eye(3)["XYZ".index(name[0])]
                    turn = axis_angle_quaternion(axis, np.deg2rad(self.values[:, column]))
                    rotations[:, joint] = quaternion_multiply(rotations[:, joint], turn)
        return rotations

    def world(self) -> tuple[FloatArray, FloatArray]:
        """Joint positions `(num_frames, num_joints, 3)` and rotations `(..., 4)` in file space."""
        positions, rotations = self.local_positions(), self.local_rotations()
        for joint, parent in enumerate(self.joint_parents):
            if parent >= 0:
                turned = quaternion_rotate(rotations[:, parent], positions[:, joint])
                positions[:, joint] = positions[:, parent] + turned
                rotations[:, joint] = quaternion_multiply(rotations[:, parent], rotations[:, joint])
        return positions, rotations

    def _columns(self) -> list[tuple[int, int, tuple[str, ...]]]:
        """Joint index, its first column in `values`, its channel names."""
        starts = np.cumsum([0, *(len(names) for names in self.channels)])
        return [(j, int(starts[j]), names) for j, names in enumerate(self.channels)]


def read_bvh(path: Path | str) -> BvhClip:
    """The clip in a BVH file.

    Raises:
        FileNotFoundError: There is no such file.
        BvhError: Not a complete, consistent BVH file; names file, line or frame, what was
            expected and what was found. It is a ValueError.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"no BVH file at {path}")
    size = path.stat().st_size
    if size > MAX_FILE_BYTES:
        raise BvhError(f"{path}: expected at most {MAX_FILE_BYTES} bytes, got {size}")
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise BvhError(f"{path}: expected text, got binary data at byte {error.start}") from error
    if "\0" in text:
        raise BvhError(f"{path}: expected text, got a NUL byte at byte {text.index(chr(0))}")
    lines = text.splitlines()
    header = read_header(lines, name=str(path))
    return BvhClip(
        joint_names=header.joint_names,
        joint_parents=header.joint_parents,
        offsets=np.array(header.offsets),
        end_sites=header.end_sites,
        channels=header.channels,
        values=_read_values(lines, header, name=str(path)),
        frame_time_s=header.frame_time_s,
    )


def _read_values(lines: list[str], header: BvhHeader, *, name: str) -> FloatArray:
    """The numbers of the MOTION block, checked, `(num_frames, num_channels)`."""
    width = sum(len(names) for names in header.channels)
    rows = [i for i in range(header.first_row, len(lines)) if lines[i] and not lines[i].isspace()]
    if len(rows) != header.num_frames:
        raise BvhError(
            f"{name}: expected {header.num_frames} frames after 'Frames:', got {len(rows)} lines "
            f"of numbers; the file is cut short or its frame count is wrong"
        )
    try:
        values = np.loadtxt([lines[i] for i in rows], np.float64, comments=None, ndmin=2)
    except ValueError:
        values = np.empty((0, 0))
    if values.shape != (header.num_frames, width):
        raise BvhError(_first_bad_row(lines, rows, width, name=name))
    bad = ~np.isfinite(values)
    if bad.any():
        frame, column = (int(i) for i in np.argwhere(bad)[0])
        joint, channel = _column_name(header, column)
        raise BvhError(
            f"{name}: line {rows[frame] + 1}: expected a finite number, got "
            f"{values[frame, column]} in frame {frame}, {channel} of joint {joint!r}"
        )
    return values


def _first_bad_row(lines: list[str], rows: list[int], width: int, *, name: str) -> str:
    """What is wrong with the first line of numbers that is not `width` numbers."""
    for frame, row in enumerate(rows):
        tokens = lines[row].split()
        for token in tokens:
            try:
                float(token)
            except ValueError:
                return f"{name}: line {row + 1}: expected a number in frame {frame}, got {token!r}"
        if len(tokens) != width:
            return (
                f"{name}: line {row + 1}: expected {width} numbers in frame {frame}, one per "
                f"channel, got {len(tokens)}"
            )
    return f"{name}: expected rows of {width} plain decimal numbers after 'Frame Time:'"


def _column_name(header: BvhHeader, column: int) -> tuple[str, str]:
    """Joint and channel of a column of the MOTION block."""
    pairs = [
        (joint, channel)
        for joint, names in zip(header.joint_names, header.channels, strict=True)
        for channel in names
    ]
    return pairs[column]
