"""Pictures of a dataset card: what a release holds, drawn to read in light and in dark."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pyarrow.compute as pc

from affectsim_data.cards.facts import Facts
from affectsim_data.cards.statistics import kind_of, kinds_of
from affectsim_data.inspection.figures import INK, figure_class, png_bytes, style_axes
from affectsim_data.motions import EMOTIONS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["PLOT_TITLES", "draw_plots"]

PLOT_TITLES = {
    "emotions.png": "Episodes by challenge or family, parted by emotion",
    "distances.png": "Distance from the robot's start to the person, by challenge or family",
    "visibility.png": "Visible share of the body under p_init, p_ref and p_mon",
}
"""Names of the files, with what they show."""
_COLORS = ("#d55e00", "#cc79a7", "#e69f00", "#8c8c8c", "#0072b2")
"""Of the emotions, after Okabe and Ito: told apart by colour-blind readers, too."""
_VIEW_COLORS = {"p_init": "#e69f00", "p_ref": "#009e73", "p_mon": "#56b4e9"}
_BIN_M = 0.25
"""Width of a bar of the distances."""


def draw_plots(facts: Facts) -> dict[str, bytes]:
    """PNG files by name; the same release and matplotlib give the same bytes.

    Raises:
        ModuleNotFoundError: matplotlib is not installed.
    """
    draw = figure_class("the pictures of a card")
    figures = {
        "emotions.png": _emotions(facts, draw),
        "distances.png": _distances(facts, draw),
        "visibility.png": _visibility(facts, draw),
    }
    return {name: png_bytes(figure) for name, figure in figures.items()}


def _emotions(facts: Facts, draw: type[Figure]) -> Figure:
    """Bars of each challenge or family, a piece per emotion."""
    kinds = kind_of(facts.episodes)
    names = kinds_of(kinds)
    figure = draw(figsize=(7.2, 0.9 + 0.42 * len(names)), layout="constrained")
    axes = figure.subplots()
    left = np.zeros(len(names))
    for emotion, color in zip(EMOTIONS, _COLORS, strict=True):
        mine = pc.equal(facts.episodes.column("emotion"), emotion)
        counts = np.array([pc.sum(pc.and_(mine, pc.equal(kinds, name))).as_py() for name in names])
        axes.barh(names, counts, left=left, color=color, label=emotion, height=0.72)
        left += counts
    for place, total in enumerate(left):
        axes.annotate(
            f"{total:,.0f}",
            (total, place),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
            color=INK,
            fontsize=9,
        )
    axes.invert_yaxis()
    axes.set_xlim(0, 1.1 * max(left))
    axes.xaxis.set_major_formatter("{x:,.0f}")
    axes.set_xlabel("episodes")
    style_axes(axes, grid="x")
    _legend(figure, len(EMOTIONS))
    return figure


def _distances(facts: Facts, draw: type[Figure]) -> Figure:
    """A histogram of start distances per challenge or family, one below the other."""
    kinds = kind_of(facts.episodes)
    names = kinds_of(kinds)
    distance = facts.episodes.column("initial_distance_m").to_numpy()
    edges = np.arange(0.0, np.ceil(distance.max()) + _BIN_M, _BIN_M)
    figure = draw(figsize=(7.2, 0.6 + 0.62 * len(names)), layout="constrained")
    panels = np.atleast_1d(figure.subplots(len(names), 1, sharex=True))
    for panel, name in zip(panels, names, strict=True):
        mine = pc.equal(kinds, name).to_numpy(zero_copy_only=False)
        panel.hist(distance[mine], bins=edges, color="#0072b2")
        panel.set_yticks([])
        panel.set_ylabel(name, rotation=0, ha="right", va="center")
        style_axes(panel, grid="x")
        panel.spines["left"].set_visible(False)
    panels[-1].set_xlim(0.0, edges[-1])
    panels[-1].set_xlabel("distance from the robot's start to the person, m")
    return figure


def _visibility(facts: Facts, draw: type[Figure]) -> Figure:
    """A histogram of visible shares per condition, side by side."""
    figure = draw(figsize=(7.2, 2.5), layout="constrained")
    panels = figure.subplots(1, len(_VIEW_COLORS), sharey=True)
    edges = np.linspace(0.0, 1.0, 21)
    for panel, (view, color) in zip(panels, _VIEW_COLORS.items(), strict=True):
        share = facts.episodes.column(f"visible_share_{view.removeprefix('p_')}").to_numpy()
        weights = np.full(len(share), 100.0 / len(share))
        panel.hist(share, bins=edges, weights=weights, color=color)
        panel.axvline(share.mean(), color=INK, linewidth=1.4, linestyle="--")
        panel.set_title(f"{view}, mean {share.mean():.2f}", fontsize=10, color=INK)
        panel.set_xlim(0.0, 1.0)
        style_axes(panel, grid="y")
    panels[0].set_ylabel("episodes, %")
    panels[1].set_xlabel("visible share of the body")
    return figure


def _legend(figure: Figure, columns: int) -> None:
    figure.legend(
        loc="outside upper center", ncols=columns, frameon=False, labelcolor=INK, fontsize=10
    )
