"""Equal rows of an array found by sorting its columns; `numpy.unique(axis=0)` is slower."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["unique_rows"]


def unique_rows(*columns: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First row of every different row, and for every row which of those it equals.

    Args:
        columns: Of equal length `(n,)`; at least one. They must not hold nan.

    Returns:
        Row numbers `(num_different,)` in the order of the sorted rows, and places in them `(n,)`.
    """
    order = np.lexsort(columns[::-1])
    new = np.zeros(len(order), bool)
    new[:1] = True
    for column in columns:
        ordered = column[order]
        new[1:] |= ordered[1:] != ordered[:-1]
    group = np.cumsum(new) - 1
    which = np.empty(len(order), np.int64)
    which[order] = group
    # lexsort is stable, so the first of a run is the first in the array.
    return order[new].astype(np.int64), which
