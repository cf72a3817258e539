"""Statistics of episodes as tables for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from affectsim_data.inspection.statistics import MEASURES
from affectsim_data.motions import EMOTIONS

__all__ = ["KIND_LABELS", "MEASURE_LABELS", "statistics_lines"]

KIND_LABELS: dict[str, str] = {
    "action_grounded": "grounded",
    "observation_controlled": "controlled",
    "far_visible": "far",
    "rear_view": "rear",
    "partial_occlusion": "occlusion",
    "obstacle_detour": "detour",
    "dyadic": "dyadic",
}
"""Short names of what episodes are."""
MEASURE_LABELS: dict[str, str] = {
    "initial_distance_m": "distance, m",
    "initial_bearing_abs_deg": "off the front, deg",
    "visible_share_init": "visible p_init, %",
    "visible_share_ref": "visible p_ref, %",
    "visible_share_mon": "visible p_mon, %",
    "d_star_1m": "d*(1), m",
    "d_star_3m": "d*(3), m",
    "d_star_5m": "d*(5), m",
    "detour_ratio": "detour ratio",
}
"""Names of what is measured, with units."""
_LABEL, _SPREAD, _COUNT = 24, 16, 11
_SHORT_CELLS = 10


def statistics_lines(
    statistics: Mapping[str, Any], cells: Mapping[str, Any] | None = None
) -> list[str]:
    """Tables of counts, of the balance of emotions, and of distributions.

    Args:
        statistics: As of `episode_statistics`.
        cells: As of `cell_counts`.
    """
    found = statistics["distributions"]
    lines = ["", *_scale_lines(statistics["scale"])]
    lines += ["", *_balance_lines(statistics["balance"])]
    lines += ["", *_spread_lines(found["kind"])]
    lines += ["", *_spread_lines(found["split"] | found["all"]), ""]
    lines += _null_lines(statistics["d_star_null"], found["all"]["all"])
    for name, title in (("scenes", "episodes per scene"), ("durations_s", "motions last, s")):
        one = statistics[name]
        lines.append(
            f"{title}: {one['min']:g} to {one['max']:g}, median {one['median']:g}, n {one['n']}"
            if name == "scenes"
            else f"{title}: {one['min']:.1f} to {one['max']:.1f}, median {one['median']:.1f}, "
            f"n {one['n']}"
        )
    return lines + _cell_lines(cells)


def _row(label: str, cells: Sequence[object], width: int) -> str:
    return (label.ljust(_LABEL) + "".join(str(cell).rjust(width) for cell in cells)).rstrip()


def _scale_lines(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    names = ("performers", "motions", "groups", "scenes", "episodes")
    lines = [_row("", ["split", *names], _COUNT + 1)]
    before = ""
    for row in rows:
        label = row["family"] if row["family"] != before else ""
        before = row["family"]
        lines.append(_row(label, [row["split"], *(row[name] for name in names)], _COUNT + 1))
    return lines


def _balance_lines(balance: Mapping[str, Mapping[str, Mapping[str, int]]]) -> list[str]:
    """Emotions per split, kind and action; the last column says how uneven they are."""
    lines = [_row("", [*EMOTIONS, "all", "max/min"], _COUNT)]
    for groups in balance.values():
        for name, counts in groups.items():
            low, high = min(counts.values()), max(counts.values())
            ratio = f"{high / low:.2f}" if low else "-"
            cells = [*counts.values(), sum(counts.values()), ratio]
            lines.append(_row(name, cells, _COUNT))
    return lines


def _spread_lines(groups: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> list[str]:
    """Median and quartiles of what is measured: a row per measure, a column per group."""
    titles = [KIND_LABELS.get(name, name) for name in groups]
    lines = [_row("median (quartiles)", titles, _SPREAD)]
    for measure in MEASURES:
        cells = [_cell(group[measure], measure) for group in groups.values()]
        lines.append(_row(MEASURE_LABELS[measure], cells, _SPREAD))
    return lines


def _cell(spread: Mapping[str, Any], measure: str) -> str:
    if not spread["n"]:
        return "-"
    is_share = measure.startswith("visible")
    factor, digits = (100.0 if is_share else 1.0), int(not (is_share or measure.endswith("deg")))
    values = (factor * spread[name] for name in ("q25", "median", "q75"))
    low, middle, high = (f"{value:.{digits}f}" for value in values)
    return f"{middle} ({low}-{high})"


def _null_lines(
    reasons: Mapping[str, Mapping[str, int]], spreads: Mapping[str, Mapping[str, Any]]
) -> list[str]:
    lines = []
    for name, counts in reasons.items():
        total = spreads[name]["n"] + spreads[name]["missing"]
        if counts:
            listed = ", ".join(f"{count} {reason}" for reason, count in counts.items())
            share = sum(counts.values()) / total
            lines.append(f"{MEASURE_LABELS[name]} is null for {share:.1%}: {listed}")
    return lines


def _cell_lines(cells: Mapping[str, Any] | None) -> list[str]:
    if cells is None or not cells["planned"]:
        return []
    short = cells["short"]
    lines = [f"the recipe asks for {cells['planned']} episodes, there are {cells['composed']}"]
    for row in short[:_SHORT_CELLS]:
        words = [row["split"], row["family"], row["challenge"], row["action"], row["emotion"]]
        where = ", ".join(word for word in words if word)
        why = row["binding_constraint"] or "no reason given"
        lines.append(f"  {where}: {row['composed']} of {row['planned']} ({why})")
    if len(short) > _SHORT_CELLS:
        lines.append(f"  and {len(short) - _SHORT_CELLS} more cells; --json lists them all")
    return lines
