"""Which files a part of a release consists of, and how many of them are here already."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from affectsim_data.releases.joined_splits import split_title, splits_there
from affectsim_data.releases.partial import SceneChoice
from affectsim_data.releases.release import Release
from affectsim_data.releases.selection import held_rows
from affectsim_data.releases.splits import SplitBy
from affectsim_data.releases.stores import Store
from affectsim_data.schemas import ASSET_TABLES, SPLITS, Split

__all__ = ["Plan", "Selection", "TableShare", "files_of", "format_bytes", "make_plan", "select"]

_CORE_TABLES = ("index", "episodes", *ASSET_TABLES)
_LISTED = 20


@dataclasses.dataclass(frozen=True)
class Selection:
    """A part of a release: the episodes of some splits and scenes, and what drawing them needs.

    A split by scene is one of scenes: all stored splits, and the scenes whose split it is.
    """

    splits: tuple[Split, ...]
    """Stored splits whose episodes are in it."""
    scene_ids: tuple[str, ...] | None = None
    """Scenes whose episodes are in it; `None` for all."""
    tables: tuple[str, ...] | None = None
    """Tables beside episodes and assets, such as trajectories; `None` for all there are."""

    @property
    def scene_choice(self) -> SceneChoice:
        """Its scenes by split."""
        return dict.fromkeys(self.splits, self.scene_ids)


@dataclasses.dataclass(frozen=True)
class TableShare:
    """Files of one table that are in a selection."""

    files: int
    bytes: int
    local_files: int
    """Those of them that are here already."""
    local_bytes: int

    def to_json(self) -> dict[str, int]:
        """Counts and bytes, with what is left to fetch."""
        return {
            **dataclasses.asdict(self),
            "fetch_files": self.files - self.local_files,
            "fetch_bytes": self.bytes - self.local_bytes,
        }


@dataclasses.dataclass(frozen=True)
class Plan:
    """What fetching a selection would do."""

    uri: str
    """The release; on the Hub, with the commit."""
    selection: Selection
    tables: Mapping[str, TableShare]
    """By table, in the order in which a reader needs them."""

    @property
    def total(self) -> TableShare:
        """All tables together."""
        rows = [dataclasses.astuple(share) for share in self.tables.values()]
        return TableShare(*(sum(column) for column in zip(*rows, strict=True)))

    def to_json(self) -> dict[str, Any]:
        """The plan as `affectsim plan --json` prints it."""
        scenes = self.selection.scene_ids
        return {
            "uri": self.uri,
            "splits": list(self.selection.splits),
            "scene_ids": None if scenes is None else list(scenes),
            "tables": {name: share.to_json() for name, share in self.tables.items()},
            "total": self.total.to_json(),
        }


def select(
    release: Release,
    *,
    splits: Sequence[str] = (),
    split_by: SplitBy = "group",
    scene_ids: Sequence[str] = (),
    tables: Sequence[str] | None = None,
) -> Selection:
    """A part of a release by the names a user gives.

    Args:
        release: The release, or a partial copy of one.
        splits: Splits to have; all that are there if empty.
        split_by: What no two of them share; see `Release.split_table`.
        scene_ids: Scenes to have; all if empty.
        tables: Tables to have beside episodes and assets; all if `None`.

    Raises:
        ValueError: There is no such split, no such scene, or no episode of the splits in a scene.
    """
    if split_by != "group" and splits:
        return _select_joined(release, splits, split_by, scene_ids, tables)
    manifest = release.manifest
    held = splits_there(release)
    for split in splits:
        if split not in held:
            if split in SPLITS and manifest.partial_of is not None:
                raise ValueError(manifest.partial_of.lacks(split, folder=release.uri))
            raise ValueError(f"{release.uri}: no split {split!r}; it has {', '.join(held)}")
    chosen = tuple(split for split in held if split in splits or not splits)
    extra = None if tables is None else tuple(tables)
    if not scene_ids:
        return Selection(chosen, None, extra)
    scenes = tuple(sorted(set(scene_ids)))
    inside = _splits_inside(release, chosen, scenes)
    if splits and (empty := [split for split in chosen if split not in inside]):
        raise ValueError(
            f"{release.uri}: no episode of {', '.join(empty)} is in {', '.join(scenes)}"
        )
    return Selection(inside, scenes, extra)


def _select_joined(
    release: Release,
    splits: Sequence[str],
    split_by: SplitBy,
    scene_ids: Sequence[str],
    tables: Sequence[str] | None,
) -> Selection:
    """A part of a release by splits it does not store."""
    if split_by == "both" and len(splits) > 1:
        raise ValueError(
            f"--split-by both takes one split at a time, got {', '.join(splits)}; "
            "a second download into the same folder adds to it"
        )
    found: set[str] = set()
    for split in splits:
        rows = held_rows(release, split, split_by)
        scenes = release.split_table(split, split_by).index.column("scene_id").take(pa.array(rows))
        found.update(pc.unique(scenes.cast(pa.string())).to_pylist())
    if unknown := sorted(set(scene_ids) - found):
        titles = ", ".join(split_title(split, split_by) for split in splits)
        raise ValueError(
            f"{release.uri}: no episode of {titles} is in {', '.join(unknown)}; "
            f"scenes with episodes: {_listed(found)}"
        )
    chosen = tuple(sorted(set(scene_ids) or found))
    # Every stored split, as to find the episodes of a scene its index is needed.
    stored = splits_there(release)
    if split_by == "both":
        stored = tuple(split for split in stored if split in splits)
    return Selection(stored, chosen, None if tables is None else tuple(tables))


def files_of(release: Release, selection: Selection) -> list[str]:
    """Files of the manifest that a selection consists of, in the manifest's order.

    A selection of everything is every file, also of assets that no episode names.
    """
    manifest = release.manifest
    everything = {split for split in SPLITS if manifest.num_rows("index", split)}
    whole = selection.scene_ids is None and everything == set(selection.splits)
    if whole and selection.tables is None:
        return list(manifest.files)
    needed = set(_extra_files(manifest.files, selection))
    for split in selection.splits:
        needed.update(manifest.table_files("index", split))
        needed.update(release.episode_files(split, _rows_in(release, split, selection.scene_ids)))
    if whole:
        for table in ASSET_TABLES:
            needed.update(manifest.table_files(table))
    return [name for name in manifest.files if name in needed]


def make_plan(release: Release, store: Store, selection: Selection) -> Plan:
    """What fetching a selection would do now; `store` is where the release's files are."""
    manifest = release.manifest
    counts: dict[str, list[int]] = {table: [0, 0, 0, 0] for table in _CORE_TABLES}
    for name in files_of(release, selection):
        size = manifest.files[name].bytes
        local = store.is_local(name)
        row = counts.setdefault(name.split("/")[0], [0, 0, 0, 0])
        for place, value in enumerate((1, size, int(local), size * local)):
            row[place] += value
    return Plan(release.uri, selection, {table: TableShare(*row) for table, row in counts.items()})


def format_bytes(count: float) -> str:
    """A number of bytes for people.

    Examples:
        >>> format_bytes(12), format_bytes(2_340_000), format_bytes(32e9)
        ('12 B', '2.3 MB', '32.0 GB')
    """
    for unit in ("B", "kB", "MB", "GB"):
        if abs(count) < 1000:
            return f"{count:.0f} B" if unit == "B" else f"{count:.1f} {unit}"
        count /= 1000
    return f"{count:.1f} TB"


def _splits_inside(
    release: Release, splits: Sequence[Split], scene_ids: Sequence[str]
) -> tuple[Split, ...]:
    """Those of some splits with an episode in some scenes; all of these must have episodes."""
    there = {
        split: set(pc.unique(_scenes_of(release, split, held_rows(release, split))).to_pylist())
        for split in splits
    }
    known = set[str]().union(*there.values())
    if unknown := sorted(set(scene_ids) - known):
        raise ValueError(
            f"{release.uri}: no episode of {', '.join(splits)} is in {', '.join(unknown)}; "
            f"scenes with episodes: {_listed(known)}"
        )
    return tuple(split for split in splits if there[split] & set(scene_ids))


def _listed(scene_ids: Collection[str]) -> str:
    more = f" and {len(scene_ids) - _LISTED} more" if len(scene_ids) > _LISTED else ""
    return ", ".join(sorted(scene_ids)[:_LISTED]) + more


def _rows_in(release: Release, split: str, scene_ids: tuple[str, ...] | None) -> NDArray[np.int64]:
    """Places of the episodes of a split that are in some scenes, and here, `(num_chosen,)`."""
    rows = held_rows(release, split)
    if scene_ids is None:
        return rows
    inside = pc.is_in(_scenes_of(release, split, rows), value_set=pa.array(scene_ids))
    return np.compress(inside.to_numpy(), rows)


def _scenes_of(release: Release, split: str, rows: NDArray[np.int64]) -> pa.ChunkedArray:
    return release.episode_index(split).column("scene_id").take(pa.array(rows)).cast(pa.string())


def _extra_files(names: Iterable[str], selection: Selection) -> list[str]:
    """Files `TABLE/WHAT-SPLIT.parquet` of the tables beside the core ones."""
    splits = "|".join(selection.splits)
    stem = re.compile(rf"(?:.*-)?(?:{splits})(?:-\d+-of-\d+)?\.parquet")
    found = []
    for name in names:
        table, _, file = name.partition("/")
        wanted = selection.tables is None or table in selection.tables
        if table not in _CORE_TABLES and wanted and stem.fullmatch(file):
            found.append(name)
    return found
