"""Trajectories that a release carries: `trajectories/POLICY-SPLIT.parquet`, and adding some."""

from __future__ import annotations

import dataclasses
import os
import re
from collections.abc import Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from affectsim_data.releases.manifest import MANIFEST_NAME, FileEntry, Manifest, sha256_of
from affectsim_data.releases.release import Release
from affectsim_data.releases.stores import FolderStore
from affectsim_data.schemas import SCHEMAS, SPLITS, Split, check_table

__all__ = [
    "add_trajectories",
    "file_stem",
    "recorded_files",
    "recorded_policies",
    "recorded_runs",
    "sha256_without_trajectories",
]

_NAME = re.compile(rf"trajectories/(.+?)-({'|'.join(SPLITS)})(?:-\d+-of-\d+)?\.parquet")
_ROWS_IN_GROUP = 1 << 16


def recorded_policies(manifest: Manifest) -> list[str]:
    """Policies with trajectories in a release, as its files call them, sorted."""
    return sorted({policy for policy, _ in recorded_files(manifest).values()})


def recorded_files(manifest: Manifest) -> dict[str, tuple[str, str]]:
    """Policy, as the file calls it, and split of every file of trajectories, by path."""
    found = {name: _NAME.fullmatch(name) for name in manifest.table_files("trajectories")}
    return {name: (match[1], match[2]) for name, match in found.items() if match}


def recorded_runs(
    release: Release, splits: Sequence[str], policy: str | None = None
) -> tuple[pa.Table, str]:
    """Trajectories that a release carries, and the name of the first file they are in.

    Args:
        release: The release.
        splits: Stored splits whose episodes are meant.
        policy: Whose trajectories; may be left out where the release has those of one.

    Raises:
        ValueError: There are none, or those of several policies and none is named.
    """
    there = recorded_policies(release.manifest)
    if not there:
        raise ValueError(
            f"{release.uri}: carries no trajectories; make some with `affectsim acquire` and give "
            "the table: trajectories='T.parquet'"
        )
    listed = ", ".join(map(repr, there))
    if policy is None and len(there) > 1:
        raise ValueError(
            f"{release.uri}: carries trajectories of {len(there)} policies, {listed}; say which is "
            "meant with policy=..., or give a table: trajectories='T.parquet'"
        )
    stem = there[0] if policy is None else file_stem(policy)
    files = recorded_files(release.manifest)
    names = [name for name, (of, split) in files.items() if of == stem and split in splits]
    if not names:
        splits_there = sorted({split for of, split in files.values() if of == stem})
        raise ValueError(
            f"{release.uri}: carries no trajectories of {policy or stem!r} in "
            f"{', '.join(splits)}, but of {listed if stem not in there else splits_there}; give a "
            "table: trajectories='T.parquet'"
        )
    return pa.concat_tables([release.recorded_table(name) for name in names]), (
        f"{release.uri}/{names[0]}"
    )


def sha256_without_trajectories(release: Release) -> str:
    """Names the content that policies act in, which trajectories put into a release leave alone."""
    carried = recorded_files(release.manifest)
    if not carried or release.manifest.partial_of is not None:
        return release.content_sha256
    files = {name: one for name, one in release.manifest.files.items() if name not in carried}
    return dataclasses.replace(release.manifest, files=files).sha256


def add_trajectories(folder: Path, table: Path) -> list[str]:
    """Puts a trajectory table into a release: a file per policy and split, and its manifest anew.

    The manifest names the content of a release: after this it is another one, and tokens and
    tables that name the old one no longer go with it.

    Args:
        folder: Of the whole release.
        table: A Parquet file of the contract's table `trajectories`.

    Returns:
        Files that were added or replaced, by their paths in the release.

    Raises:
        ValueError: Not such a table, a partial copy, or an episode is not in the release.
    """
    store = FolderStore(folder)
    release, manifest = Release(store), store.manifest
    if manifest.partial_of is not None:
        raise ValueError(f"{folder}: is a part of a release; add trajectories to the whole")
    try:
        check_table(pq.read_schema(table), "trajectories", file=str(table))
        # Without what the table says of its run, which was over one split of them.
        rows = pq.read_table(table, columns=SCHEMAS["trajectories"].names)
        rows = rows.replace_schema_metadata()
    except (pa.ArrowException, OSError) as error:
        raise ValueError(f"{table}: cannot be read as Parquet: {error}") from None
    parts: dict[Split, pa.Table] = {}
    for split in SPLITS:
        if manifest.num_rows("index", split):
            ids = release.episode_index(split).column("episode_id").combine_chunks()
            parts[split] = rows.filter(pc.is_in(rows.column("episode_id"), value_set=ids))
    left = rows.num_rows - sum(part.num_rows for part in parts.values())
    if left:
        raise ValueError(f"{table}: {left:,} rows are of episodes that are not in {folder}")
    added: dict[str, FileEntry] = {}
    for split, part in parts.items():
        added |= _write_split(folder, part, split)
    files = dict(sorted({**manifest.files, **added}.items()))
    changed = dataclasses.replace(manifest, files=files)
    half = folder / f".{MANIFEST_NAME}.tmp"
    half.write_text(changed.to_json(), encoding="utf-8")
    os.replace(half, folder / MANIFEST_NAME)
    return list(added)


def _write_split(folder: Path, rows: pa.Table, split: Split) -> dict[str, FileEntry]:
    """Files of one split, by path; each in place once it is whole."""
    written = {}
    for policy in sorted(pc.unique(rows.column("policy")).to_pylist()):
        name = f"trajectories/{file_stem(policy)}-{split}.parquet"
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        half = path.with_name(f".{path.name}.tmp")
        mine = rows.filter(pc.equal(rows.column("policy"), policy)).combine_chunks()
        pq.write_table(mine, half, compression="zstd", row_group_size=_ROWS_IN_GROUP)
        os.replace(half, path)
        written[name] = FileEntry(path.stat().st_size, sha256_of(path), mine.num_rows)
    return written


def file_stem(policy: str) -> str:
    """What files call a policy: only characters that are safe everywhere."""
    return re.sub(r"[^A-Za-z0-9_.+-]+", "_", policy).strip(".-") or "policy"
