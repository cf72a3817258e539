"""What a dataset can be asked for: a place in it, several, or a part."""

from __future__ import annotations

import operator
from typing import SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.loaders.places import Place

__all__ = ["as_place", "chosen_rows"]


def as_place(index: SupportsIndex | Place, length: int, name: str) -> Place:
    """A request with a row from 0 up; a plain index is the epoch 0 of the order as it stands.

    Args:
        index: What was asked for; negative rows count from the end.
        length: Of the dataset.
        name: What errors call it.

    Raises:
        IndexError: Outside the dataset.
        TypeError: Neither an integer nor a `Place`.
    """
    try:
        row = operator.index(index.row if isinstance(index, Place) else index)
    except TypeError:
        raise TypeError(
            f"a dataset is asked for an int or a Place, got {index!r}; "
            "dataset.subset(...) takes slices, lists and masks"
        ) from None
    if not -length <= row < length:
        raise IndexError(f"{name} has {length} episodes, got index {row}")
    row %= length
    return index._replace(row=row) if isinstance(index, Place) else Place(row, 0, row)


def chosen_rows(rows: ArrayLike | slice, length: int) -> NDArray[np.int64]:
    """Places from 0 up, `(n,)`, of what `subset` takes.

    Raises:
        IndexError: A place outside the dataset.
        ValueError: Nothing chosen, a mask of another length, or neither places nor a mask.
    """
    if isinstance(rows, slice):
        chosen = np.arange(length)[rows]
    else:
        given = np.asarray(rows)
        if given.ndim != 1 or (given.size and given.dtype.kind not in "iub"):
            raise ValueError(
                f"subset takes places, a slice or a mask, got {given.dtype} of shape {given.shape}"
            )
        if given.dtype == bool and len(given) != length:
            raise ValueError(f"subset: the mask must be ({length},), got {given.shape}")
        chosen = np.flatnonzero(given) if given.dtype == bool else given.astype(np.int64)
    if not len(chosen):
        raise ValueError(f"subset: no episode of {length} is chosen")
    outside = chosen[(chosen < -length) | (chosen >= length)]
    if len(outside):
        raise IndexError(f"subset: the dataset has {length} episodes, got index {outside[0]}")
    return chosen % length
