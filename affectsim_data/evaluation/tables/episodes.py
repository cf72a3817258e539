"""What a release says of the episodes that are scored, as arrays."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from affectsim_data.evaluation.scored import RINGS_M
from affectsim_data.motions import EMOTIONS
from affectsim_data.poses import FloatArray
from affectsim_data.releases import Release
from affectsim_data.releases.filters import Filter, matching
from affectsim_data.releases.joined_splits import split_title
from affectsim_data.releases.splits import SplitBy
from affectsim_data.schemas import SPLITS

__all__ = ["LEFT_OUT", "UNKNOWN", "ScoredEpisodes", "scored_episodes"]

LEFT_OUT, UNKNOWN = -1, -2
"""In place of an episode's place: a filter left it out, or the split has none of that name."""

_FACTORS = (
    *("family", "challenge", "action", "emotion", "scene_id"),
    *("performer_id", "motion_id", "group_id", "placement_id"),
)
_STARTS = ("start_x_m", "start_y_m", "start_z_m")
_RINGS = tuple(name for r in RINGS_M for name in (f"d_star_{r}m", f"d_star_{r}m_null"))


@dataclasses.dataclass(frozen=True)
class ScoredEpisodes:
    """The episodes of a split; fields as in `ScoredTable`."""

    release: Release
    split: str
    split_by: SplitBy
    episode_ids: pa.Array
    truth: NDArray[np.int8]
    factors: Mapping[str, NDArray[np.str_]]
    performances: NDArray[np.int64]
    performers: NDArray[np.int64]
    d_star_m: FloatArray
    ring_empty: NDArray[np.bool_]
    starts_m: FloatArray
    """Where the robot starts, `(num_episodes, 3)`."""
    left_out: pa.Array
    """Identifiers of the other episodes of the split, which a filter left out."""

    @property
    def title(self) -> str:
        """The split, with what it is by unless that is the paper's: `test`, `test by scene`."""
        return split_title(self.split, self.split_by).removeprefix("split ").replace("'", "")

    @property
    def notes(self) -> list[str]:
        """What a reader must know of the choice of episodes."""
        if not len(self.left_out):
            return []
        count = len(self.episode_ids)
        return [f"a filter chose {count:,} of {count + len(self.left_out):,} episodes"]

    def places(self, episode_ids: pa.ChunkedArray) -> NDArray[np.int64]:
        """Places of episodes among these, `LEFT_OUT` or `UNKNOWN` for others, `(n,)`."""
        found = pc.index_in(episode_ids, value_set=self.episode_ids).fill_null(UNKNOWN)
        places: NDArray[np.int64] = found.to_numpy().astype(np.int64)
        if len(self.left_out):
            places[pc.is_in(episode_ids, value_set=self.left_out).to_numpy()] = LEFT_OUT
        return places

    def why_not(self, episode_ids: pa.Array) -> dict[str, str]:
        """Why episodes are not among these, by identifier."""
        example = f"they are called like {self.episode_ids[0].as_py()!r}"
        reasons = dict.fromkeys(
            episode_ids.to_pylist(), f"is not in {self.release.manifest.name}; {example}"
        )
        for split in SPLITS:
            if not self.release.manifest.num_rows("index", split):
                continue
            known = self.release.episode_index(split).column("episode_id")
            there = episode_ids.filter(pc.is_in(episode_ids, value_set=known.combine_chunks()))
            is_of = f"is of split {split!r}, not of {split_title(self.split, self.split_by)}"
            reasons |= dict.fromkeys(there.to_pylist(), is_of)
        return reasons


def scored_episodes(
    release: Release, split: str, split_by: SplitBy, filter: Filter | None
) -> ScoredEpisodes:
    """Reads the episodes of a split, those that match the filter if there is one.

    Raises:
        ValueError: Not a split, the release has no episode in it, or is a partial copy that lacks
            some of its episodes; or the filter is malformed or matches none.
    """
    there = release.split_table(split, split_by)
    columns = ["episode_id", *_FACTORS, *_STARTS, *_RINGS]
    table = there.table(columns)
    if table.num_rows < there.num_episodes:
        raise ValueError(
            f"{release.uri}: this copy holds {table.num_rows} of the {there.num_episodes} episodes "
            f"of {split_title(split, split_by)}; `affectsim download` can add the others"
        )
    # The rows are all there, so that they stand where the index has them.
    chosen = np.ones(table.num_rows, bool) if filter is None else matching(there, filter)
    if not chosen.any():
        raise ValueError(f"filter {filter!r} matches no episode of {split_title(split, split_by)}")
    left_out = _identifiers(table.filter(pa.array(~chosen)))
    table = table.filter(pa.array(chosen))
    factors = {name: _texts(table.column(name)) for name in _FACTORS}
    is_grounded = factors["family"] == "action_grounded"
    # group_id is the performance or sequence itself, but in this family the performer.
    performance = np.where(is_grounded, factors["motion_id"], factors["group_id"])
    d_star = [table.column(f"d_star_{r}m").to_numpy().astype(np.float64) for r in RINGS_M]
    empty = [_texts(table.column(f"d_star_{r}m_null")) == "empty" for r in RINGS_M]
    return ScoredEpisodes(
        release=release,
        split=split,
        split_by=split_by,
        episode_ids=_identifiers(table),
        truth=_codes(factors["emotion"]),
        factors=factors,
        performances=np.unique(performance, return_inverse=True)[1].astype(np.int64),
        performers=np.unique(factors["performer_id"], return_inverse=True)[1].astype(np.int64),
        d_star_m=np.stack(d_star),
        ring_empty=np.stack(empty),
        starts_m=np.stack([table.column(name).to_numpy() for name in _STARTS], axis=1),
        left_out=left_out,
    )


def _identifiers(table: pa.Table) -> pa.Array:
    return pa.array(table.column("episode_id").to_pylist(), pa.string())


def _texts(column: pa.ChunkedArray) -> NDArray[np.str_]:
    """Texts of a column, empty for null."""
    return np.array(column.cast(pa.string()).fill_null("").to_pylist(), np.str_)


def _codes(emotions: NDArray[np.str_]) -> NDArray[np.int8]:
    codes: NDArray[Any] = np.argmax(emotions[:, None] == np.array(EMOTIONS), axis=1)
    return codes.astype(np.int8)
