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
from affectsim_data.releases.release import Release

__all__ = ["held_rows", "select_rows", "selection_fingerprint"]

_LISTED = 10


def select_rows(
    release: Release,
    split: str,
    *,
    filter: Filter | None = None,
    episodes: Iterable[str] | None = None,
    exclude: Iterable[str] | None = None,
) -> NDArray[np.int64]:
    """Places in a split's table of the episodes that are meant, `(num_selected,)`, at least one.

    Args:
        release: The release, or a partial copy of one.
        split: `train`, `validation` or `test`.
        filter: Comparisons of columns, see `affectsim_data.releases.filters`.
        episodes: Only these, in this order; else the table's order.
        exclude: All but these.

    Raises:
        ValueError: Not a split; a malformed filter; an identifier that is not in the split or
            stands in `episodes` twice; or no episode is left.
    """
    held = held_rows(release, split)
    if filter is None and episodes is None and exclude is None:
        return held
    rows = held if episodes is None else _rows_of(release, split, episodes, "episodes", once=True)
    chosen = np.ones(release.num_episodes(split), bool)
    if exclude is not None:
        chosen[_rows_of(release, split, exclude, "exclude")] = False
    if filter is not None:
        there = np.zeros_like(chosen)
        there[held] = True
        matched = matching(release, split, filter) & there
        if not matched.any():
            raise ValueError(
                f"{release.uri}: no episode of split {split!r} matches filter {filter!r}; "
                f"there are {values_there_are(release, [split], filter)}"
            )
        chosen &= matched
    rows = rows[chosen[rows]]
    if not len(rows):
        raise ValueError(
            f"{release.uri}: filter, episodes and exclude together leave no episode of the "
            f"{len(held)} in split {split!r}"
        )
    return rows


def held_rows(release: Release, split: str) -> NDArray[np.int64]:
    """Places of all episodes of a split that can be drawn; a partial copy lacks some, `(n,)`.

    Raises:
        ValueError: Not a split, or the release has no episode in it.
    """
    scenes = release.manifest.scene_ids(split)
    if scenes is None:
        return np.arange(release.num_episodes(split))
    inside = np.flatnonzero(matching(release, split, [("scene_id", "in", sorted(scenes))]))
    return np.intersect1d(inside, release.split_table(split).held_rows)


def selection_fingerprint(release: Release, split: str, rows: ArrayLike) -> str:
    """SHA-256 of the release's content, the split and the ordered places in it, hexadecimal.

    The same episodes in the same order have the same one, however they were chosen and wherever
    the release lies.
    """
    digest = hashlib.sha256(f"{release.content_sha256}\n{split}\n".encode())
    digest.update(np.asarray(rows).astype("<i8").tobytes())
    return digest.hexdigest()


def _rows_of(
    release: Release, split: str, ids: Iterable[str], argument: str, *, once: bool = False
) -> NDArray[np.int64]:
    """Places of identifiers, in their order."""
    wanted = ids if isinstance(ids, str) else list(ids)
    if isinstance(wanted, str) or not all(isinstance(one, str) for one in wanted):
        raise ValueError(f"{argument} must be a list of episode ids, got {wanted!r}")
    known = release.episode_index(split).column("episode_id").combine_chunks()
    found = pc.index_in(pa.array(wanted, pa.string()), value_set=known)
    held = set(held_rows(release, split).tolist())
    rows = found.to_pylist()
    unknown = [name for name, row in zip(wanted, rows, strict=True) if row not in held]
    if unknown:
        raise ValueError(
            f"{argument}: {len(unknown)} of {len(wanted)} are not in split {split!r} of "
            f"{release.uri}, whose ids look like {known[0].as_py()!r}: {_listed(unknown)}"
        )
    repeated = [name for name, count in Counter(wanted).items() if count > 1]
    if once and repeated:
        raise ValueError(f"{argument}: {len(repeated)} are named twice: {_listed(repeated)}")
    return np.array(rows, np.int64)


def _listed(names: Collection[str]) -> str:
    shown = ", ".join(repr(name) for name in list(names)[:_LISTED])
    return shown + (", ..." if len(names) > _LISTED else "")
