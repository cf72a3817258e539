"""What a recognizer is: clips in, answers out."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Protocol

from affectsim_data.loaders import Sample

__all__ = ["Recognizer", "Reply"]


@dataclasses.dataclass(frozen=True)
class Reply:
    """What a recognizer says of one clip."""

    raw_text: str | None = None
    """As a model said it; parsed when the table is evaluated."""
    label: str | None = None
    """One of the five emotions, from a recognizer that answers in labels."""
    scores: tuple[float, ...] | None = None
    """One per emotion, in label order."""
    latency_ms: float | None = None
    """Time to this answer; the runner's own measure, shared by the batch, if not told."""
    error: str | None = None
    """Why there is no answer: nothing is written for the clip, and the next run asks again."""


class Recognizer(Protocol):
    """Anything that names the emotion seen in clips."""

    @property
    def name(self) -> str:
        """What stands in the column `model`: the recognizer and its configuration."""
        ...

    @property
    def batch_size(self) -> int:
        """Clips it likes to be given at once."""
        ...

    def recognize(self, samples: Sequence[Sample]) -> Sequence[Reply]:
        """Answers to clips, in their order.

        Args:
            samples: As `AffectSimDataset` yields them; `video` is uint8
                `(num_frames, 3, height, width)`. Nothing but `video`, `depth`, `intrinsics` and
                `time_s` may be looked at: the rest says what the answer is.
        """
        ...
