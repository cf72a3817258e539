"""Figures of a report, PNG for files and SVG for a page; drawing needs the extra `plots`."""

from affectsim_data.reports.figures.drawing import FigureText, draw_figures, figure_texts

__all__ = ["FigureText", "draw_figures", "figure_texts"]
