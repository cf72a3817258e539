"""Pictures of a dataset card: what a release holds, drawn to read in light and in dark."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow.compute as pc

from affectsim_data.cards.facts import Facts
from affectsim_data.cards.statistics import kind_of, kinds_of
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
_INK, _GRID = "#7a7a7a", "#7a7a7a40"
"""A grey of contrast 4 to white and to the Hub's dark page; the background is clear."""
_DPI = 140
_BIN_M = 0.25
"""Width of a bar of the distances."""


def draw_plots(facts: Facts) -> dict[str, bytes]:
    """PNG files by name; the same release and matplotlib give the same bytes.

    Raises:
        ModuleNotFoundError: matplotlib is not installed.
    """
    figure_class = _figure_class()
    figures = {
        "emotions.png": _emotions(facts, figure_class),
        "distances.png": _distances(facts, figure_class),
        "visibility.png": _visibility(facts, figure_class),
    }
    return {name: _png(figure) for name, figure in figures.items()}


def _figure_class() -> type[Figure]:
    """Figures of their own, without pyplot: no display is asked for and none stays open."""
    try:
        from matplotlib.figure import Figure
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            "the pictures of a card need matplotlib, which is not installed; the extra `plots` "
            'has it: python -m pip install "affectsim-data[plots]"',
            name="matplotlib",
        ) from error
    return Figure


def _png(figure: Figure) -> bytes:
    stream = io.BytesIO()
    # Without the version of matplotlib, which is no part of the picture.
    figure.savefig(stream, dpi=_DPI, transparent=True, metadata={"Software": None})
    return stream.getvalue()


def _emotions(facts: Facts, figure_class: type[Figure]) -> Figure:
    """Bars of each challenge or family, a piece per emotion."""
    kinds = kind_of(facts.episodes)
    names = kinds_of(kinds)
    figure = figure_class(figsize=(7.2, 0.9 + 0.42 * len(names)), layout="constrained")
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
            color=_INK,
            fontsize=9,
        )
    axes.invert_yaxis()
    axes.set_xlim(0, 1.1 * max(left))
    axes.xaxis.set_major_formatter("{x:,.0f}")
    axes.set_xlabel("episodes")
    _style(axes, grid="x")
    _legend(figure, len(EMOTIONS))
    return figure


def _distances(facts: Facts, figure_class: type[Figure]) -> Figure:
    """A histogram of start distances per challenge or family, one below the other."""
    kinds = kind_of(facts.episodes)
    names = kinds_of(kinds)
    distance = facts.episodes.column("initial_distance_m").to_numpy()
    edges = np.arange(0.0, np.ceil(distance.max()) + _BIN_M, _BIN_M)
    figure = figure_class(figsize=(7.2, 0.6 + 0.62 * len(names)), layout="constrained")
    panels = np.atleast_1d(figure.subplots(len(names), 1, sharex=True))
    for panel, name in zip(panels, names, strict=True):
        mine = pc.equal(kinds, name).to_numpy(zero_copy_only=False)
        panel.hist(distance[mine], bins=edges, color="#0072b2")
        panel.set_yticks([])
        panel.set_ylabel(name, rotation=0, ha="right", va="center")
        _style(panel, grid="x")
        panel.spines["left"].set_visible(False)
    panels[-1].set_xlim(0.0, edges[-1])
    panels[-1].set_xlabel("distance from the robot's start to the person, m")
    return figure


def _visibility(facts: Facts, figure_class: type[Figure]) -> Figure:
    """A histogram of visible shares per condition, side by side."""
    figure = figure_class(figsize=(7.2, 2.5), layout="constrained")
    panels = figure.subplots(1, len(_VIEW_COLORS), sharey=True)
    edges = np.linspace(0.0, 1.0, 21)
    for panel, (view, color) in zip(panels, _VIEW_COLORS.items(), strict=True):
        share = facts.episodes.column(f"visible_share_{view.removeprefix('p_')}").to_numpy()
        weights = np.full(len(share), 100.0 / len(share))
        panel.hist(share, bins=edges, weights=weights, color=color)
        panel.axvline(share.mean(), color=_INK, linewidth=1.4, linestyle="--")
        panel.set_title(f"{view}, mean {share.mean():.2f}", fontsize=10, color=_INK)
        panel.set_xlim(0.0, 1.0)
        _style(panel, grid="y")
    panels[0].set_ylabel("episodes, %")
    panels[1].set_xlabel("visible share of the body")
    return figure


def _style(axes: Any, *, grid: str) -> None:
    axes.tick_params(colors=_INK, labelsize=9)
    axes.xaxis.label.set(color=_INK, fontsize=10)
    axes.yaxis.label.set(color=_INK, fontsize=10)
    axes.grid(axis=grid, color=_GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(_INK)


def _legend(figure: Figure, columns: int) -> None:
    figure.legend(
        loc="outside upper center", ncols=columns, frameon=False, labelcolor=_INK, fontsize=10
    )
