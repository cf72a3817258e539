"""Matplotlib as every picture of this package uses it: no display, no pyplot, the same bytes."""

from __future__ import annotations

import contextlib
import io
import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "GRID",
    "INK",
    "figure_class",
    "neutral_settings",
    "png_bytes",
    "style_axes",
    "svg_bytes",
]

INK, GRID = "#7a7a7a", "#7a7a7a40"
"""A grey of contrast 4 to white and to the Hub's dark page; the background is clear."""
_SVG_FONTS = ["DejaVu Sans", "Verdana", "Arial", "sans-serif"]
_HASH_SALT = "affectsim"
"""Names inside an SVG are hashes with this, not with a random number."""


def figure_class(subject: str) -> type[Figure]:
    """Figures of their own, without pyplot: no display is asked for and none stays open.

    Args:
        subject: What is to be drawn, in the plural: `the pictures of a card`.

    Raises:
        ModuleNotFoundError: matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            f"{subject} need matplotlib, which is not installed; the extra `plots` has it: "
            'python -m pip install "affectsim-data[plots]"',
            name="matplotlib",
        ) from error
    return Figure


@contextlib.contextmanager
def neutral_settings() -> Iterator[None]:
    """Within it figures are the same whatever settings of matplotlib a reader has.

    Text is no formula either, whatever signs stand in it.
    """
    import matplotlib

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams["text.parse_math"] = False
        yield


def png_bytes(figure: Figure, *, dpi: int = 140) -> bytes:
    """The figure as a PNG with a clear background; the same for the same matplotlib."""
    stream = io.BytesIO()
    with warnings.catch_warnings():
        # A name in a script the font lacks shows as boxes here; tables beside it have it in full.
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        # Without the version of matplotlib, which is no part of the picture.
        figure.savefig(stream, dpi=dpi, transparent=True, metadata={"Software": None})
    return stream.getvalue()


def svg_bytes(figure: Figure) -> bytes:
    """The figure as an SVG with a clear background, its text as text."""
    import matplotlib

    settings: dict[Any, Any] = {
        "svg.fonttype": "none",
        "svg.hashsalt": _HASH_SALT,
        "font.family": "sans-serif",
        "font.sans-serif": _SVG_FONTS,
    }
    nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
    stream = io.BytesIO()
    with warnings.catch_warnings(), matplotlib.rc_context(settings):
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        figure.savefig(stream, format="svg", transparent=True, metadata=nothing)
    return stream.getvalue()


def style_axes(axes: Any, *, grid: Literal["x", "y"]) -> None:
    """Grey axes with a faint grid across `grid`, without a box."""
    axes.tick_params(colors=INK, labelsize=9)
    axes.xaxis.label.set(color=INK, fontsize=10)
    axes.yaxis.label.set(color=INK, fontsize=10)
    axes.grid(axis=grid, color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(INK)
