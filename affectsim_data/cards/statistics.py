"""The tables of a dataset card, as Markdown."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from affectsim_data.cards.facts import Facts
from affectsim_data.cards.markdown import code_span, per_cent, table
from affectsim_data.motions import EMOTIONS
from affectsim_data.schemas import CHALLENGES, FAMILIES

__all__ = [
    "cells_text",
    "count_tables",
    "kind_of",
    "kinds_of",
    "measured_table",
    "scenes_table",
    "splits_table",
]

_FAMILY_TITLES = {
    "action_grounded": "action-grounded",
    "observation_controlled": "observation-controlled",
    "dyadic": "dyadic",
}
_SHARES = ("visible_share_init", "visible_share_ref", "visible_share_mon")
_RINGS = ("d_star_1m", "d_star_3m", "d_star_5m")
_SHORTFALLS_SHOWN = 20


def splits_table(facts: Facts) -> str:
    """Groups and episodes by split and family, as Table 2 of the AffectSim report counts them."""
    header = ["split"]
    for family, counted in zip(FAMILIES, ("performers", "motions", "sequences"), strict=True):
        header += [f"{_FAMILY_TITLES[family]}: {counted}", "episodes"]
    rows: list[list[str | int]] = [
        [split, *_split_counts(_where(facts.episodes, split=split))] for split in facts.splits
    ]
    rows.append(["**total**", *_split_counts(facts.episodes)])
    return table([*header, "all episodes"], rows)


def _split_counts(episodes: pa.Table) -> list[int]:
    grounded, controlled, dyadic = (_where(episodes, family=family) for family in FAMILIES)
    pairs = [dyadic.column(name) for name in ("motion_id", "partner_motion_id")]
    # A sequence is seen twice, once with each of the two as its target.
    sequence = pc.binary_join_element_wise(
        pc.min_element_wise(*pairs), pc.max_element_wise(*pairs), "\n"
    )
    counts = [
        *(_num_distinct(grounded.column("performer_id")), grounded.num_rows),
        *(_num_distinct(controlled.column("motion_id")), controlled.num_rows),
        *(_num_distinct(sequence), dyadic.num_rows),
    ]
    return [*counts, episodes.num_rows]


def _num_distinct(column: pa.ChunkedArray) -> int:
    return int(pc.count_distinct(column).as_py())


def _where(episodes: pa.Table, **values: str) -> pa.Table:
    for name, value in values.items():
        episodes = episodes.filter(pc.equal(episodes.column(name), value))
    return episodes


def count_tables(facts: Facts) -> str:
    """Episodes by emotion and split, by challenge or family, and by action."""
    episodes = facts.episodes
    kinds = kind_of(episodes)
    parts: dict[str, dict[str, pa.Table]] = {
        "split": {split: _where(episodes, split=split) for split in facts.splits},
        "challenge, or family without one": {
            code_span(kind): episodes.filter(pc.equal(kinds, kind)) for kind in kinds_of(kinds)
        },
        "action": {
            code_span(action): _where(episodes, action=action)
            for action in sorted(set(episodes.column("action").to_pylist()))
        },
    }
    return "\n\n".join(
        table(
            [title, *EMOTIONS, "all"],
            [[name, *_emotion_counts(members)] for name, members in part.items()],
        )
        for title, part in parts.items()
    )


def _emotion_counts(episodes: pa.Table) -> list[int]:
    found = episodes.column("emotion").to_pylist()
    return [*(found.count(emotion) for emotion in EMOTIONS), len(found)]


def kind_of(episodes: pa.Table) -> pa.ChunkedArray:
    """The challenge of each episode, its family where it has none."""
    return pc.coalesce(episodes.column("challenge"), episodes.column("family"))


def kinds_of(kinds: pa.ChunkedArray) -> list[str]:
    """Those there are, in the order of the schema."""
    there = set(kinds.unique().to_pylist())
    return [kind for kind in (*FAMILIES, *CHALLENGES) if kind in there]


def measured_table(facts: Facts) -> str:
    """How episodes begin and are seen: medians and means by challenge or family."""
    kinds = kind_of(facts.episodes)
    rows = [
        [code_span(kind), *_measured(facts.episodes.filter(pc.equal(kinds, kind)))]
        for kind in kinds_of(kinds)
    ]
    rows.append(["**all**", *_measured(facts.episodes)])
    header = ["challenge, or family", "distance, median (5 to 95 %)"]
    header += [f"visible at `{name}`" for name in ("p_init", "p_ref", "p_mon")]
    return table([*header, "d\\*(1 m)", "d\\*(3 m)", "d\\*(5 m)"], rows)


def _measured(episodes: pa.Table) -> list[str]:
    distance = episodes.column("initial_distance_m").to_numpy()
    low, median, high = np.quantile(distance, (0.05, 0.5, 0.95))
    shares = [per_cent(_mean(episodes.column(name))) for name in _SHARES]
    rings = [_mean(episodes.column(name)) for name in _RINGS]
    lengths = ["-" if np.isnan(length) else f"{length:.2f} m" for length in rings]
    return [f"{median:.2f} m ({low:.2f} to {high:.2f})", *shares, *lengths]


def _mean(column: pa.ChunkedArray) -> float:
    values = column.drop_null().to_numpy()
    return float(values.mean()) if len(values) else float("nan")


def scenes_table(facts: Facts, *, episodes: bool) -> str:
    """One row per scene: rooms, floor, seats, doors, triangles and, if wanted, episodes."""
    counts = facts.episodes.column("scene_id").value_counts().to_pylist()
    held = {entry["values"]: entry["counts"] for entry in counts}
    header = ["scene", "rooms", "floor for a robot, m²", "seats", "doors", "triangles"]
    rows: list[list[str | int]] = [
        [
            *(code_span(row["scene_id"]), len(row["rooms"]), f"{row['area_m2']:.1f}"),
            *(row["num_seats"], row["num_doors"], row["num_triangles"]),
            *([held.get(row["scene_id"], 0)] if episodes else []),
        ]
        for row in facts.scenes.to_pylist()
    ]
    return table([*header, "episodes"] if episodes else header, rows)


def cells_text(facts: Facts) -> str:
    """Whether the release holds as many episodes as its recipe asks for, and what is missing."""
    cells = facts.cells.to_pylist()
    if not cells:
        return "The release does not say how many episodes its recipe asks for."
    planned, composed = (sum(cell[name] for cell in cells) for name in ("planned", "composed"))
    short = [cell for cell in cells if cell["composed"] < cell["planned"]]
    asked = f"The recipe asks for {planned:,} episodes in {len(cells):,} cells"
    if not short:
        return f"{asked} (split, family, challenge, action, emotion); all are there."
    short.sort(key=lambda cell: cell["composed"] - cell["planned"])
    rows = [
        [
            cell["split"],
            code_span(cell["challenge"] or cell["family"]),
            code_span(cell["action"]),
            cell["emotion"],
            code_span(cell["binding_constraint"] or ""),
            cell["planned"],
            cell["composed"],
        ]
        for cell in short[:_SHORTFALLS_SHOWN]
    ]
    header = ["split", "challenge, or family", "action", "emotion", "failed at"]
    more = len(short) - len(rows)
    rest = f"\n\nand {more:,} more cells." if more else ""
    return (
        f"{asked}; {composed:,} are there. What could not be placed is left out: no threshold is "
        "loosened to fill a cell.\n\n"
        f"{table([*header, 'planned', 'composed'], rows, left=5)}{rest}"
    )
