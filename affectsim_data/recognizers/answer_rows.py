"""Answers as rows of a prediction table, checked."""

from __future__ import annotations

from typing import Any

import numpy as np

from affectsim_data.evaluation.tables.files import MAX_TEXT_BYTES
from affectsim_data.motions import EMOTIONS
from affectsim_data.recognizers.journal import Key
from affectsim_data.recognizers.protocol import Reply

__all__ = ["prediction_row", "too_long"]


def too_long(text: str | None) -> str | None:
    """Why no table could hold a text; a model gone astray on one clip need not end a run."""
    if isinstance(text, str) and len(text.encode("utf-8", "replace")) > MAX_TEXT_BYTES:
        return f"an answer of {len(text):,} characters; a table holds {MAX_TEXT_BYTES:,} bytes"
    return None


def prediction_row(
    key: Key, reply: Reply, frames: str, *, latency_ms: float, where: str
) -> dict[str, Any]:
    """The row of an answer, without the column `model`.

    Args:
        key: Episode and condition.
        reply: The answer.
        frames: Hash of the frames it is about.
        latency_ms: Time to it.
        where: What messages call it.

    Raises:
        ValueError: It is no answer: no text and no label, another label, scores that are none.
    """
    text, label, scores = reply.raw_text, reply.label, reply.scores
    if text is None and label is None:
        raise ValueError(f"{where}: a reply needs raw_text, a label or an error, got none")
    if text is not None and not isinstance(text, str):
        raise ValueError(f"{where}: raw_text must be text, got {text!r}")
    if label is not None and label not in EMOTIONS:
        raise ValueError(
            f"{where}: label must be one of {', '.join(EMOTIONS)}, got {label!r}; put free text "
            "into raw_text"
        )
    if scores is not None:
        values = np.asarray(scores, np.float64)
        if values.shape != (len(EMOTIONS),) or not np.isfinite(values).all():
            raise ValueError(
                f"{where}: scores must be {len(EMOTIONS)} finite numbers, got {scores!r}"
            )
        scores = tuple(values.tolist())
    if not (np.isfinite(latency_ms) and latency_ms >= 0):
        raise ValueError(f"{where}: latency_ms must be finite and from 0 up, got {latency_ms!r}")
    return {
        "episode_id": key[0],
        "condition": key[1],
        # Half a surrogate pair, as a cut-off stream may end in, is no text a table can hold.
        "raw_text": text and text.encode("utf-8", "replace").decode(),
        "label": label,
        "scores": None if scores is None else list(scores),
        "latency_ms": float(latency_ms),
        "frames_sha256": frames,
    }
