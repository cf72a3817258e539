"""Descriptors of motions as distributions, one panel a descriptor, one colour an emotion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from affectsim_data.inspection.figures import figure_class
from affectsim_data.inspection.motion_summary import descriptor_label, motion_descriptors
from affectsim_data.motions import EMOTIONS
from affectsim_data.motions.descriptors import MAIN_DESCRIPTORS
from affectsim_data.releases import Release

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["EMOTION_COLORS", "motion_plot"]

EMOTION_COLORS: dict[str, str] = {
    "angry": "#d55e00",
    "fearful": "#cc79a7",
    "happy": "#e69f00",
    "neutral": "#7f7f7f",
    "sad": "#0072b2",
}
"""After Okabe and Ito: told apart by colour-blind readers, too."""
_MARKERS = "osD^vPX*<>"
_COLUMNS, _PANEL = 5, (3.0, 2.9)
_INK, _GRID = "#3c3c42", "#e4e4e0"


def motion_plot(
    source: Release | pa.Table,
    path: Path | str,
    *,
    descriptors: Sequence[str] = MAIN_DESCRIPTORS,
) -> None:
    """Draws descriptors by emotion: boxes of the quartiles, a mark per motion, a shape per action.

    Needs no display. The ending of the path says the format: `.png`, `.svg`, `.pdf`.

    Args:
        source: A release, or what `motion_descriptors` gave for it.
        path: Where to write; its folder is there.
        descriptors: Columns to draw.

    Raises:
        ModuleNotFoundError: matplotlib is not installed.
        KeyError: There is no such descriptor.
    """
    draw = figure_class("plots of motions")
    table = motion_descriptors(source) if isinstance(source, Release) else source
    unknown = [name for name in descriptors if name not in table.column_names]
    if unknown:
        raise KeyError(f"no descriptors {unknown}; docs/descriptors.md lists them")
    columns = min(_COLUMNS, len(descriptors))
    rows = math.ceil(len(descriptors) / columns)
    size = (columns * _PANEL[0], rows * _PANEL[1] + 0.7)
    figure = draw(figsize=size, layout="constrained")
    panels = np.atleast_1d(figure.subplots(rows, columns)).ravel()
    emotions = np.array(table.column("emotion").to_pylist())
    actions = np.array(table.column("action").to_pylist())
    for panel, name in zip(panels, descriptors, strict=False):
        _draw_panel(panel, table.column(name).to_numpy(), emotions, actions)
        panel.set_title(descriptor_label(name), fontsize=12, color=_INK)
    for panel in panels[len(descriptors) :]:
        panel.set_visible(False)
    _draw_legend(figure, sorted(set(actions)))
    figure.savefig(path, dpi=120)


def _draw_panel(panel: Any, values: np.ndarray, emotions: np.ndarray, actions: np.ndarray) -> None:
    present = [emotion for emotion in EMOTIONS if emotion in emotions]
    marker_of = dict(zip(sorted(set(actions)), _MARKERS * len(actions), strict=False))
    for place, emotion in enumerate(present):
        color = EMOTION_COLORS[emotion]
        mine = np.flatnonzero((emotions == emotion) & np.isfinite(values))
        if not len(mine):
            continue
        # Spread by rank, not by chance: the same table draws the same picture.
        aside = 0.28 * (2.0 * np.mod(np.arange(len(mine)) * 0.618034, 1.0) - 1.0)
        for action in sorted(set(actions[mine])):
            those = actions[mine] == action
            panel.plot(
                place + aside[those],
                values[mine][those],
                marker_of[action],
                color=color,
                alpha=0.45,
                markersize=4,
                markeredgewidth=0,
            )
        panel.boxplot(
            values[mine],
            positions=[place],
            widths=0.62,
            showfliers=False,
            medianprops={"color": _INK, "linewidth": 1.8},
            boxprops={"color": color, "linewidth": 1.5},
            whiskerprops={"color": color, "linewidth": 1.2},
            capprops={"color": color, "linewidth": 1.2},
        )
    panel.set_xticks(range(len(present)), present, fontsize=10, rotation=30, ha="right")
    panel.set_xlim(-0.6, len(present) - 0.4)
    panel.tick_params(axis="y", labelsize=10, colors=_INK)
    panel.grid(axis="y", color=_GRID)
    panel.set_axisbelow(True)
    panel.spines[["top", "right"]].set_visible(False)


def _draw_legend(figure: Figure, actions: Sequence[str]) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], marker=marker, linestyle="", color=_INK, alpha=0.6, label=action)
        for action, marker in zip(actions, _MARKERS * len(actions), strict=False)
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=6, frameon=False, fontsize=11)
