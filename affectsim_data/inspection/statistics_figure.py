"""What the episodes of a release span, as one figure of six panels."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from affectsim_data.inspection.figures import figure_class
from affectsim_data.inspection.motion_plots import EMOTION_COLORS
from affectsim_data.inspection.statistics import KINDS, episode_kinds, measured_values
from affectsim_data.inspection.statistics_lines import KIND_LABELS
from affectsim_data.motions import EMOTIONS
from affectsim_data.poses import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["statistics_figure"]

_SIZE, _DPI = (7.0, 4.5), 300
"""Inches: the width of two columns of a paper; readable at one, too."""
_INK, _GRID = "#3c3c42", "#e4e4e0"
_STYLES: dict[str, tuple[str, Any]] = {
    "action_grounded": ("#000000", "-"),
    "observation_controlled": ("#7f7f7f", "-"),
    "far_visible": ("#0072b2", "-"),
    "rear_view": ("#e69f00", "--"),
    "partial_occlusion": ("#009e73", "-."),
    "obstacle_detour": ("#d55e00", ":"),
    "dyadic": ("#cc79a7", (0, (5, 1))),
}
"""Colours after Okabe and Ito, told apart by colour-blind readers, and dashes for matplotlib."""
_CONDITIONS = {
    "visible_share_init": ("p_init", "#d55e00", "-"),
    "visible_share_ref": ("p_ref", "#0072b2", "--"),
    "visible_share_mon": ("p_mon", "#7f7f7f", "-."),
}
_RINGS = {1: ("#d55e00", "-"), 3: ("#009e73", "--"), 5: ("#0072b2", "-.")}
_BEARING_BINS, _DISTANCE_BINS = 24, 30
_LOW_QUANTILE = 99.5
"""Axes of lengths end at this percentile: one far start would squeeze the rest."""


def statistics_figure(table: pa.Table, path: Path | str) -> None:
    """Draws emotions, distances, bearings, visible shares, shortest ways and detours.

    Needs no display. The ending of the path says the format: `.png`, `.svg`, `.pdf`.

    Args:
        table: What `affectsim_data.inspection.statistics.chosen_episodes` gave; at least one row.
        path: Where to write; its folder is there.

    Raises:
        ModuleNotFoundError: matplotlib is not installed.
    """
    draw = figure_class("figures of statistics")
    kinds, values = episode_kinds(table), measured_values(table)
    there = [kind for kind in KINDS if (kinds == kind).any()]
    masks = {kind: kinds == kind for kind in there}
    figure = draw(figsize=_SIZE, layout="constrained")
    places = [figure.add_subplot(2, 3, n, polar=n == 3) for n in range(1, 7)]
    emotions = np.array(table.column("emotion").to_pylist())
    bearings = np.radians(table.column("initial_bearing_deg").to_numpy())
    _draw_emotions(places[0], emotions, masks)
    _draw_distances(places[1], values["initial_distance_m"], masks)
    _draw_bearings(places[2], bearings, masks)
    _draw_shares(places[3], values)
    _draw_rings(places[4], values)
    _draw_detours(places[5], values["detour_ratio"], masks)
    titles = ("Emotions", "Initial distance", "Initial bearing", "Visible body", "Way to the ring")
    for letter, place, title in zip("abcdef", places, (*titles, "Detour"), strict=True):
        aside = -0.35 if place is places[2] else 0.0  # where `front` is not in the way
        place.set_title(f"({letter}) {title}", x=aside, y=1.03, fontsize=8, color=_INK, loc="left")
        place.tick_params(labelsize=6.5, colors=_INK, length=2)
        place.xaxis.label.set_fontsize(7)
        place.yaxis.label.set_fontsize(7)
    for place in (places[1], *places[3:]):
        place.grid(color=_GRID, linewidth=0.6)
        place.set_axisbelow(True)
        place.spines[["top", "right"]].set_visible(False)
    _draw_legend(figure, there)
    figure.savefig(path, dpi=_DPI)


def _draw_emotions(
    place: Any, emotions: NDArray[Any], masks: Mapping[str, NDArray[np.bool_]]
) -> None:
    """A bar per kind, its parts as long as the shares of emotions; beside it the count."""
    for row, (_, mask) in enumerate(masks.items()):
        left = 0.0
        for emotion in EMOTIONS:
            share = float((emotions[mask] == emotion).mean())
            place.barh(row, share, left=left, color=EMOTION_COLORS[emotion], height=0.72)
            if share >= 0.12:
                place.text(left + share / 2.0, row, emotion[:3], fontsize=5.5, **_WHITE_MIDDLE)
            left += share
        place.text(1.02, row, f"{int(mask.sum()):,}", fontsize=6.5, va="center", color=_INK)
    place.set_yticks(range(len(masks)), [KIND_LABELS[kind] for kind in masks])
    place.invert_yaxis()
    place.set_xlim(0.0, 1.0)
    place.set_xlabel("share; number of episodes")
    place.spines[["top", "right", "left"]].set_visible(False)


_WHITE_MIDDLE = {"color": "white", "ha": "center", "va": "center"}


def _draw_distances(
    place: Any, distances: FloatArray, masks: Mapping[str, NDArray[np.bool_]]
) -> None:
    edges = np.linspace(0.0, float(np.percentile(distances, _LOW_QUANTILE)), _DISTANCE_BINS + 1)
    for kind, mask in masks.items():
        counts, _ = np.histogram(distances[mask], edges)
        color, style = _STYLES[kind]
        place.stairs(counts / mask.sum(), edges, color=color, linestyle=style, linewidth=1.1)
    place.set_xlabel("robot to person, m")
    place.set_ylabel("share")
    place.set_xlim(0.0, edges[-1])
    place.set_ylim(bottom=0.0)


def _draw_bearings(
    place: Any, bearings: FloatArray, masks: Mapping[str, NDArray[np.bool_]]
) -> None:
    """Seen from above with the person in the middle, who looks up."""
    edges = np.linspace(-np.pi, np.pi, _BEARING_BINS + 1)
    for kind, mask in masks.items():
        counts, _ = np.histogram((bearings[mask] + np.pi) % (2.0 * np.pi) - np.pi, edges)
        # Square roots: areas, not radii, are compared by eye.
        radii = np.sqrt(counts / mask.sum())
        angles = np.repeat(edges, 2)[1:-1]
        closed = np.append(np.repeat(radii, 2), radii[0])
        color, style = _STYLES[kind]
        place.plot(
            np.append(angles, angles[0]), closed, color=color, linestyle=style, linewidth=1.1
        )
    place.set_theta_zero_location("N")
    place.set_xticks(np.radians([0, 90, 180, 270]), ["front", "left", "behind", "right"])
    place.set_yticks([])
    place.grid(color=_GRID, linewidth=0.6)
    place.spines["polar"].set_color(_GRID)


def _draw_shares(place: Any, values: Mapping[str, FloatArray]) -> None:
    for name, (label, color, style) in _CONDITIONS.items():
        _draw_cumulated(place, values[name], label, color, style)
    place.set_xlabel("mean visible share of the body")
    place.set_ylabel("share of episodes below")
    place.set_xlim(-0.02, 1.02)
    place.legend(fontsize=6.5, frameon=False, loc="upper left")


def _draw_rings(place: Any, values: Mapping[str, FloatArray]) -> None:
    ends = [0.5]
    for ring, (color, style) in _RINGS.items():
        lengths = values[f"d_star_{ring}m"]
        missing = float(np.isnan(lengths).mean())
        label = f"{ring} m" + (f" ({missing:.0%} none)" if missing >= 0.005 else "")
        _draw_cumulated(place, lengths[np.isfinite(lengths)], label, color, style)
        ends += (
            np.percentile(lengths[np.isfinite(lengths)], [_LOW_QUANTILE]).tolist()
            if (missing < 1.0)
            else []
        )
    place.set_xlabel("d*(r), m")
    place.set_ylabel("share of episodes below")
    place.set_xlim(0.0, max(ends))
    place.legend(fontsize=6.5, frameon=False, loc="lower right")


def _draw_cumulated(place: Any, values: FloatArray, label: str, color: str, style: str) -> None:
    ordered = np.sort(values)
    below = np.arange(1, len(ordered) + 1) / max(len(ordered), 1)
    place.step(
        ordered, below, where="post", label=label, color=color, linestyle=style, linewidth=1.2
    )


def _draw_detours(place: Any, ratios: FloatArray, masks: Mapping[str, NDArray[np.bool_]]) -> None:
    """A box per kind, whiskers from the 5th to the 95th percentile."""
    for row, (kind, mask) in enumerate(masks.items()):
        there = ratios[mask & np.isfinite(ratios)]
        if not len(there):
            continue
        color = _STYLES[kind][0]
        lines = {"color": color, "linewidth": 1.1}
        place.boxplot(
            there,
            positions=[row],
            widths=0.6,
            whis=(5.0, 95.0),
            showfliers=False,
            orientation="horizontal",
            **{f"{part}props": lines for part in ("box", "whisker", "cap", "median")},
        )
    place.set_yticks(range(len(masks)), [KIND_LABELS[kind] for kind in masks])
    place.set_ylim(len(masks) - 0.5, -0.5)
    place.set_xlabel("way to the 1 m ring / straight line")


def _draw_legend(figure: Figure, kinds: list[str]) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=_STYLES[k][0], linestyle=_STYLES[k][1], label=k.replace("_", " "))
        for k in kinds
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=6, frameon=False, fontsize=6.5)
