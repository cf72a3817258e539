"""Answers a page quotes."""

from __future__ import annotations

import dataclasses

__all__ = ["Example"]


@dataclasses.dataclass(frozen=True)
class Example:
    """An answer of a model and how it was read."""

    episode_id: str
    model: str
    condition: str
    truth: str
    """The emotion acted."""
    answer: str
    """The emotion or outcome it was parsed to."""
    raw_text: str
    """What the model said; a page cuts it."""
