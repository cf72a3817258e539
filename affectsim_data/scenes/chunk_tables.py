"""The chunks of a scene as arrays of its GLB, which parse faster than lists of numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.glb import GlbBuilder, GlbFile
from affectsim_data.scenes.chunks import Chunks

__all__ = ["chunks_from_glb", "chunks_to_glb"]

_NUMBERS = ("surface", "first", "count")
_BOXES = ("low", "high")
_SOLIDS = ("solid_low", "solid_high")


def chunks_to_glb(builder: GlbBuilder, chunks: Chunks) -> dict[str, int]:
    """Adds the table to a GLB; returns the accessor of each column.

    glTF has neither signed 32-bit integers nor infinity: `room` counts from 1 with 0 for none,
    and `solid` tells which chunks have a box around their solids.
    """
    table = {name: builder.accessor(getattr(chunks, name).astype("<u4")) for name in _NUMBERS}
    table["room"] = builder.accessor((chunks.room + 1).astype("<u4"))
    solid = np.isfinite(np.concatenate([chunks.solid_low, chunks.solid_high], axis=1)).all(axis=1)
    table["solid"] = builder.accessor(solid.astype("u1"))
    for name in (*_BOXES, *_SOLIDS):
        box = getattr(chunks, name).astype("<f4")
        if name in _SOLIDS:
            box[~solid] = 0.0
        table[name] = builder.accessor(box)
    return table


def chunks_from_glb(glb: GlbFile, table: Any) -> Chunks:
    """Reads what `chunks_to_glb` wrote.

    Raises:
        ValueError: A column is missing, or of another type.
    """
    if not isinstance(table, Mapping):
        raise ValueError(f"chunks must be a table of accessors, got {type(table).__name__}")
    numbers = {name: _column(glb, table, name, "<u4") for name in (*_NUMBERS, "room")}
    for name, values in numbers.items():
        if len(values) and int(values.max()) >= 2**31:
            raise ValueError(f"chunks: {name} must be below 2**31, got {int(values.max())}")
    boxes = {name: _column(glb, table, name, "<f4") for name in (*_BOXES, *_SOLIDS)}
    solid = _column(glb, table, "solid", "|u1") > 0
    lengths = {len(column) for column in (*numbers.values(), *boxes.values(), solid)}
    if len(lengths) != 1:
        raise ValueError(f"chunks: columns must be equally long, got lengths {sorted(lengths)}")
    low, high = (boxes[name].astype(np.float64) for name in _BOXES)
    solid_low, solid_high = (
        np.where(solid[:, None], boxes[name].astype(np.float64), endless)
        for name, endless in zip(_SOLIDS, (-np.inf, np.inf), strict=True)
    )
    surface, first, count, room = (values.astype(np.int32) for values in numbers.values())
    return Chunks(surface, first, count, room - 1, low, high, solid_low, solid_high)


def _column(glb: GlbFile, table: Mapping[str, Any], name: str, dtype: str) -> NDArray[Any]:
    if name not in table:
        raise ValueError(f"chunks: there is no column {name}")
    values = glb.array(table[name])
    width = 2 if dtype == "<f4" else 1
    if values.dtype.str != dtype or values.ndim != width:
        raise ValueError(
            f"chunks: {name} must be {np.dtype(dtype)} of {width} axes, "
            f"got {values.dtype} of shape {values.shape}"
        )
    return values
