"""Recognizers that look at nothing or only at which clip it is: what any other has to beat."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Sequence

from affectsim_data.loaders import Sample
from affectsim_data.motions import EMOTIONS, Emotion
from affectsim_data.recognizers.frames import frames_sha256
from affectsim_data.recognizers.protocol import Reply

__all__ = ["ConstantRecognizer", "UniformRecognizer"]

_BATCH_SIZE = 16


@dataclasses.dataclass(frozen=True)
class ConstantRecognizer:
    """Always the same emotion."""

    emotion: Emotion
    """Which."""

    @property
    def name(self) -> str:
        """`constant:happy`."""
        return f"constant:{self.emotion}"

    @property
    def batch_size(self) -> int:
        """Any would do."""
        return _BATCH_SIZE

    def recognize(self, samples: Sequence[Sample]) -> list[Reply]:
        """The emotion, as often as there are clips."""
        return [Reply(label=self.emotion)] * len(samples)


@dataclasses.dataclass(frozen=True)
class UniformRecognizer:
    """Any of the five emotions, equally likely; the same for the same frames."""

    seed: int
    """Another seed, other answers."""

    @property
    def name(self) -> str:
        """`uniform:0`."""
        return f"uniform:{self.seed}"

    @property
    def batch_size(self) -> int:
        """Any would do."""
        return _BATCH_SIZE

    def recognize(self, samples: Sequence[Sample]) -> list[Reply]:
        """An emotion by the hash of the frames and the seed."""
        return [Reply(label=self._emotion(frames_sha256(one["video"]))) for one in samples]

    def _emotion(self, frames: str) -> Emotion:
        digest = hashlib.sha256(f"{self.seed} {frames}".encode()).digest()
        return EMOTIONS[int.from_bytes(digest[:8], "little") % len(EMOTIONS)]
