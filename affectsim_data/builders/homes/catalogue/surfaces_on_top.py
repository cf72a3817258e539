"""Where one sits and puts things on a model, found by rays from above."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.homes.pieces import LocalSeat, Top
from affectsim_data.poses import FloatArray
from affectsim_data.visibility import RayCaster

__all__ = ["HeightMap", "height_map", "seats_on", "top_of"]

_CELL_M = 0.025
_SEAT_HEIGHTS = (0.33, 0.56)
"""A sitter's thighs are level on seats of these heights, metres."""
_LEVEL_M = 0.045
"""Cushions bulge by this much."""
_PLACE_M = 0.52
"""Width of a place on a sofa or bench."""
_PILLOW_M = 0.45
_LEAST_DEPTH_M, _LEAST_WIDTH_M = 0.26, 0.28


@dataclasses.dataclass(frozen=True, eq=False)
class HeightMap:
    """Height of the first thing a ray from above meets, over a grid on the plan."""

    heights: FloatArray
    """Metres, `-inf` where there is nothing, `(num_z, num_x)`."""
    xs: FloatArray
    """Middles of the columns, metres, `(num_x,)`."""
    zs: FloatArray
    """Middles of the rows, metres, `(num_z,)`."""


def height_map(
    positions: FloatArray, faces: NDArray[np.int64], size: tuple[float, float, float]
) -> HeightMap:
    """Looks down on a piece of that width, depth and height."""
    width, depth, _ = size
    xs = _middles(width)
    zs = _middles(depth)
    top = float(positions[:, 1].max()) + 1.0
    origins = np.zeros((len(zs), len(xs), 3))
    origins[..., 0], origins[..., 1], origins[..., 2] = xs[None, :], top, zs[:, None]
    way = RayCaster(positions, faces).distance(origins, np.array([0.0, -1.0, 0.0]))
    return HeightMap(top - way, xs, zs)


def _middles(length: float) -> FloatArray:
    count = max(int(np.ceil(length / _CELL_M)), 1)
    return (np.arange(count) + 0.5) / count * length - length / 2.0


def seats_on(view: HeightMap, *, places: bool) -> tuple[LocalSeat, ...]:
    """The places to sit on a piece; none if nothing on it is a seat.

    Args:
        view: The piece from above.
        places: Whether there may be more than one, side by side.
    """
    heights = view.heights
    low = (heights >= _SEAT_HEIGHTS[0]) & (heights <= _SEAT_HEIGHTS[1])
    if low.sum() * _CELL_M**2 < _LEAST_DEPTH_M * _LEAST_WIDTH_M:
        return ()
    counts, edges = np.histogram(heights[low], bins=np.arange(_SEAT_HEIGHTS[0], 0.575, 0.015))
    peak = float(edges[counts.argmax()]) + 0.0075
    seat = np.abs(heights - peak) <= _LEVEL_M
    # Cushions and pillows interrupt a seat.
    deep = _closed(seat.sum(axis=0) * _CELL_M >= _LEAST_DEPTH_M, _PILLOW_M if places else 0.0)
    columns = _widest_run(deep)
    if columns is None:
        return ()
    left, right = view.xs[columns[0]] - _CELL_M / 2, view.xs[columns[1]] + _CELL_M / 2
    if right - left < _LEAST_WIDTH_M:
        return ()
    number = max(int((right - left + 0.06) / _PLACE_M), 1) if places else 1
    middles = left + (np.arange(number) + 0.5) / number * (right - left)
    found = [_seat_at(view, seat, float(x), (right - left) / number, peak) for x in middles]
    return tuple(one for one in found if one is not None)


def _closed(flags: NDArray[np.bool_], length: float) -> NDArray[np.bool_]:
    """With gaps of up to `length` metres between true ones filled."""
    places = np.flatnonzero(flags)
    filled = flags.copy()
    for first, second in itertools.pairwise(places):
        if (second - first) * _CELL_M <= length:
            filled[first:second] = True
    return filled


def _widest_run(flags: NDArray[np.bool_]) -> tuple[int, int] | None:
    """First and last place of the longest row of true."""
    steps = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    starts, ends = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    if not len(starts):
        return None
    best = int((ends - starts).argmax())
    return int(starts[best]), int(ends[best]) - 1


def _seat_at(
    view: HeightMap, seat: NDArray[np.bool_], x: float, width: float, peak: float
) -> LocalSeat | None:
    """The seat around `x`: from its front edge back to whatever rises there."""
    near = np.abs(view.xs - x) <= min(width / 2.0, 0.15)
    rows = _widest_run(seat[:, near].mean(axis=1) >= 0.6)
    if rows is None:
        return None
    back, front = (float(view.zs[rows[0]]) - _CELL_M / 2, float(view.zs[rows[1]]) + _CELL_M / 2)
    depth = front - back
    if depth < _LEAST_DEPTH_M:
        return None
    within = seat & near[None, :]
    height = float(np.median(view.heights[within])) if within.any() else peak
    edge = float(np.clip(0.3 * depth, 0.12, 0.2))
    return LocalSeat((x, height, front - edge), round(depth, 3), edge=edge)


def top_of(view: HeightMap, *, height: float | None) -> Top | None:
    """The level surface things may be put on: the highest large one, or the one at `height`."""
    heights = np.where(np.isfinite(view.heights), view.heights, 0.0)
    if height is None:
        counts, edges = np.histogram(
            heights, bins=np.arange(0.1, max(heights.max(), 0.1) + 0.03, 0.01)
        )
        large = counts >= 0.3 * heights.size
        if not large.any():
            return None
        height = float(edges[np.flatnonzero(large)[-1]]) + 0.005
    level = np.abs(heights - height) <= 0.012
    if not level.any():
        return None
    for share in np.arange(1.0, 0.29, -0.05):
        columns = np.abs(view.xs) <= share * np.abs(view.xs).max()
        rows = np.abs(view.zs) <= share * np.abs(view.zs).max()
        if level[np.ix_(rows, columns)].mean() >= 0.97:
            width, depth = np.ptp(view.xs[columns]), np.ptp(view.zs[rows])
            y = float(np.median(heights[level]))
            return Top(y, float(width), float(depth)) if min(width, depth) > 0.15 else None
    return None
