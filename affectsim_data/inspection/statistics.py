"""What the episodes of a release span: counts, balance of emotions, distances, angles, shares.

Everything is plain numbers and texts, fit for JSON.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from affectsim_data.motions import EMOTIONS
from affectsim_data.poses import FloatArray
from affectsim_data.releases import Release
from affectsim_data.releases.splits import SplitBy
from affectsim_data.schemas import CHALLENGES, FAMILIES, SCHEMAS, SPLITS

__all__ = [
    "KINDS",
    "MEASURES",
    "cell_counts",
    "chosen_episodes",
    "episode_kinds",
    "episode_statistics",
    "measured_values",
]

KINDS: tuple[str, ...] = ("action_grounded", "observation_controlled", *CHALLENGES, "dyadic")
"""What an episode is, in one word: its challenge, or its family where that has none."""
MEASURES: tuple[str, ...] = (
    "initial_distance_m",
    "initial_bearing_abs_deg",
    "visible_share_init",
    "visible_share_ref",
    "visible_share_mon",
    "d_star_1m",
    "d_star_3m",
    "d_star_5m",
    "detour_ratio",
)
"""What distributions are given of. The bearing is folded: 0 in front of the target, 180 behind. The
detour ratio is the way to the 1 m ring as a share of the straight line to it."""
_COLUMNS = (
    *("split", "family", "challenge", "action", "emotion", "scene_id", "group_id"),
    *("performer_id", "motion_id", "partner_performer_id", "partner_motion_id", "duration_s"),
    *("initial_distance_m", "initial_bearing_deg"),
    *("visible_share_init", "visible_share_ref", "visible_share_mon"),
    *(f"d_star_{r}m{end}" for r in (1, 3, 5) for end in ("", "_null")),
)
_RING_M = 1.1
"""Outer edge of the 1 m ring, which is 0.2 m wide."""
_MIN_STRAIGHT_M = 0.25
"""From starts nearer to the ring than a step of the robot, a ratio of ways says nothing."""


def chosen_episodes(
    release: Release, chosen: Mapping[str, NDArray[np.int64]], *, split_by: SplitBy = "group"
) -> pa.Table:
    """What statistics need to know of the episodes at some places, one row each.

    Args:
        release: The release, or a partial copy of one.
        chosen: Places by split.
        split_by: What these splits are by; the column `split` says their names.
    """
    schema = pa.schema([SCHEMAS["episodes"].field(name) for name in _COLUMNS])
    tables = [schema.empty_table()]
    for split, rows in chosen.items():
        source = release.split_table(split, split_by)
        # In a partial copy the table lacks rows of the split.
        table = source.table(_COLUMNS).take(np.searchsorted(source.held_rows, rows))
        names = pa.array([split]).take(pa.array(np.zeros(len(rows), np.int64)))
        tables.append(table.set_column(0, schema.field(0), names))
    return pa.concat_tables(tables)


def episode_kinds(table: pa.Table) -> NDArray[Any]:
    """What each episode is, one of `KINDS`, `(num_episodes,)`."""
    return np.array(pc.coalesce(table.column("challenge"), table.column("family")).to_pylist())


def measured_values(table: pa.Table) -> dict[str, FloatArray]:
    """Values of `MEASURES`, `(num_episodes,)` each, nan where there is none."""
    bearing = table.column("initial_bearing_deg").to_numpy()
    values = {
        name: table.column(name).to_numpy().astype(np.float64)
        for name in MEASURES
        if name in table.column_names
    }
    straight = values["initial_distance_m"] - _RING_M
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(straight >= _MIN_STRAIGHT_M, values["d_star_1m"] / straight, np.nan)
    folded = np.abs((bearing + 180.0) % 360.0 - 180.0)
    values |= {"initial_bearing_abs_deg": folded, "detour_ratio": ratio}
    return {name: values[name] for name in MEASURES}


def episode_statistics(table: pa.Table) -> dict[str, Any]:
    """Counts and distributions of episodes.

    `scale` is a row per family and split as in a paper's table; `balance` counts emotions per
    split, kind and action; `distributions` has, of all and per split and kind, for each of
    `MEASURES` how many episodes have a value, how many have none, mean, range and quartiles;
    `d_star_null` why a shortest way is missing; `scenes` and `durations_s` say how episodes are
    spread over scenes, and how long the motions are that occur.

    Args:
        table: What `chosen_episodes` gave.
    """
    kinds, values = episode_kinds(table), measured_values(table)
    groups = {"split": _strings(table, "split"), "kind": kinds}
    distributions = {"all": {"all": _spreads(values, np.ones(len(kinds), bool))}}
    for name, words in groups.items():
        distributions[name] = {
            word: _spreads(values, words == word) for word in _in_order(words.tolist())
        }
    emotions = _strings(table, "emotion")
    balance = {
        name: _balance(words, emotions)
        for name, words in (*groups.items(), ("action", _strings(table, "action")))
    }
    per_scene = Counter(_strings(table, "scene_id").tolist())
    longest = table.group_by("motion_id").aggregate([("duration_s", "max")])
    return {
        "scale": _scale(table),
        "balance": balance,
        "distributions": distributions,
        "d_star_null": {
            f"d_star_{r}m": dict(
                sorted(Counter(table.column(f"d_star_{r}m_null").drop_null().to_pylist()).items())
            )
            for r in (1, 3, 5)
        },
        "scenes": _spread(np.array(list(per_scene.values()), np.float64)),
        "durations_s": _spread(longest.column("duration_s_max").to_numpy()),
    }


def cell_counts(release: Release, splits: Sequence[str]) -> dict[str, Any]:
    """Episodes the recipe asks for and those there are, and every cell that is short.

    Args:
        release: The release.
        splits: Splits by group.
    """
    rows = [row for split in splits for row in release.cells(split).to_pylist()]
    return {
        "planned": sum(row["planned"] for row in rows),
        "composed": sum(row["composed"] for row in rows),
        "short": [row for row in rows if row["composed"] < row["planned"]],
    }


def _scale(table: pa.Table) -> list[dict[str, Any]]:
    """Performers, motions, groups, scenes and episodes per family and split, and in all."""
    families, splits = _strings(table, "family"), _strings(table, "split")
    rows = []
    for family in FAMILIES:
        present = [split for split in SPLITS if (splits[families == family] == split).any()]
        for split in (*present, "total") if present else ():
            mask = (families == family) & ((splits == split) | (split == "total"))
            part = table.filter(pa.array(mask))
            rows.append(
                {
                    "family": family,
                    "split": split,
                    "performers": _distinct(part, "performer_id", "partner_performer_id"),
                    "motions": _distinct(part, "motion_id", "partner_motion_id"),
                    "groups": _distinct(part, "group_id"),
                    "scenes": _distinct(part, "scene_id"),
                    "episodes": part.num_rows,
                }
            )
    return rows


def _distinct(table: pa.Table, *names: str) -> int:
    """How many different words there are in some columns together."""
    return len(set[str]().union(*(_strings(table, name) for name in names)) - {""})


def _balance(words: NDArray[Any], emotions: NDArray[Any]) -> dict[str, dict[str, int]]:
    counts = Counter(zip(words.tolist(), emotions.tolist(), strict=True))
    return {
        word: {emotion: counts[word, emotion] for emotion in EMOTIONS}
        for word in _in_order(words.tolist())
    }


def _in_order(words: Sequence[str]) -> list[str]:
    """Each word once, as the schemas order them; others behind, by name."""
    known = (*SPLITS, *KINDS)
    there = set(words)
    return [word for word in known if word in there] + sorted(there - set(known))


def _spreads(values: Mapping[str, FloatArray], mask: NDArray[np.bool_]) -> dict[str, Any]:
    return {name: _spread(column[mask]) for name, column in values.items()}


def _spread(values: FloatArray) -> dict[str, float | int | None]:
    """Number, missing, mean, range and quartiles of values of which nan are missing."""
    there = values[np.isfinite(values)]
    found: dict[str, float | int | None] = {"n": len(there), "missing": len(values) - len(there)}
    names = ("mean", "min", "q25", "median", "q75", "max")
    if not len(there):
        return found | dict.fromkeys(names)
    low, q25, median, q75, high = np.percentile(there, [0, 25, 50, 75, 100]).tolist()
    spread = (float(there.mean()), low, q25, median, q75, high)
    return found | dict(zip(names, spread, strict=True))


def _strings(table: pa.Table, name: str) -> NDArray[Any]:
    """A column of texts, null as an empty one, `(num_episodes,)`."""
    return np.array(table.column(name).fill_null("").to_pylist(), dtype=object)
