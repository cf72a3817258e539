"""Evaluations as people read them: tables in a terminal, Markdown, CSV, LaTeX, figures, a page."""
