"""Which episodes of a split are meant, and what identifies that ordered list of episodes."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Collection, Iterable

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import ArrayLike, NDArray

from affectsim_data.releases.filters import Filter, matching, values_there_are
from affectsim_data.releases.joined_splits import split_title
from affectsim_data.releases.release import Release
from affectsim_data.releases.splits import EpisodeTable, SplitBy

__all__ = ["held_rows", "select_rows", "selection_fingerprint"]

_LISTED = 10


def select_rows(
    release: Release,
    split: str,
    *,
    split_by: SplitBy = "group",
    filter: Filter | None = None,
    episodes: Iterable[str] | None = None,
    exclude: Iterable[str] | None = None,
) -> NDArray[np.int64]:
    """Places in a split's table of the episodes that are meant, `(num_selected,)`, at least one.

    Args:
        release: The release, or a partial copy of one.
        split: `train`, `validation` or `test`.
        split_by: What no two splits share: `group`, `scene` or `both`; see `Release.split_table`.
        filter: Comparisons of columns, see `affectsim_data.releases.filters`.
        episodes: Only these, in this order; else the table's order.
        exclude: All but these.

    Raises:
        ValueError: Not a split; a malformed filter; an identifier that is not in the split or
            stands in `episodes` twice; or no episode is left.
    """
    table, title = release.split_table(split, split_by), split_title(split, split_by)
    held, where = table.drawable_rows, f"{title} of {release.uri}"
    if filter is None and episodes is None and exclude is None:
        return held
    rows = held if episodes is None else _rows_of(table, where, episodes, "episodes", once=True)
    chosen = np.ones(table.num_episodes, bool)
    if exclude is not None:
        chosen[_rows_of(table, where, exclude, "exclude")] = False
    if filter is not None:
        there = np.zeros_like(chosen)
        there[held] = True
        matched = matching(table, filter) & there
        if not matched.any():
            raise ValueError(
                f"{release.uri}: no episode of {title} matches filter {filter!r}; "
                f"there are {values_there_are([table], filter)}"
            )
        chosen &= matched
    rows = rows[chosen[rows]]
    if not len(rows):
        raise ValueError(
            f"{release.uri}: filter, episodes and exclude together leave no episode of the "
            f"{len(held)} in {title}"
        )
    return rows


def held_rows(release: Release, split: str, split_by: SplitBy = "group") -> NDArray[np.int64]:
    """Places of all episodes of a split that can be drawn; a partial copy lacks some, `(n,)`.

    Raises:
        ValueError: Not a split, or the release has no episode in it.
    """
    return release.split_table(split, split_by).drawable_rows


def selection_fingerprint(
    release: Release, split: str, rows: ArrayLike, *, split_by: SplitBy = "group"
) -> str:
    """SHA-256 of the release's content, the split and the ordered places in it, hexadecimal.

    The same episodes of a split in the same order have the same one, however they were chosen and
    wherever the release lies.
    """
    # The split by group goes by its name alone: tokens and logs of it name no other.
    name = split if split_by == "group" else f"{split} by {split_by}"
    digest = hashlib.sha256(f"{release.content_sha256}\n{name}\n".encode())
    digest.update(np.asarray(rows).astype("<i8").tobytes())
    return digest.hexdigest()


def _rows_of(
    table: EpisodeTable, where: str, ids: Iterable[str], argument: str, *, once: bool = False
) -> NDArray[np.int64]:
    """Places of identifiers, in their order; `where` is what messages call the table."""
    wanted = ids if isinstance(ids, str) else list(ids)
    if isinstance(wanted, str) or not all(isinstance(one, str) for one in wanted):
        raise ValueError(f"{argument} must be a list of episode ids, got {wanted!r}")
    known = table.index.column("episode_id").combine_chunks()
    found = pc.index_in(pa.array(wanted, pa.string()), value_set=known)
    held = set(table.drawable_rows.tolist())
    rows = found.to_pylist()
    unknown = [name for name, row in zip(wanted, rows, strict=True) if row not in held]
    if unknown:
        raise ValueError(
            f"{argument}: {len(unknown)} of {len(wanted)} are not in {where}, "
            f"whose ids look like {known[0].as_py()!r}: {_listed(unknown)}"
        )
    repeated = [name for name, count in Counter(wanted).items() if count > 1]
    if once and repeated:
        raise ValueError(f"{argument}: {len(repeated)} are named twice: {_listed(repeated)}")
    return np.array(rows, np.int64)


def _listed(names: Collection[str]) -> str:
    shown = ", ".join(repr(name) for name in list(names)[:_LISTED])
    return shown + (", ..." if len(names) > _LISTED else "")
