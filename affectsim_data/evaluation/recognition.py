"""Recognition quality of every model under every condition, in the sample and in every draw."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from affectsim_data.evaluation.drawing import Drawing
from affectsim_data.evaluation.scored import ScoredTable
from affectsim_data.motions import EMOTIONS
from affectsim_data.poses import FloatArray

__all__ = ["Recognition", "recognition_in"]


@dataclasses.dataclass(frozen=True)
class Recognition:
    """Counts all metrics of recognition follow from; first axis as in `Drawing`, R draws."""

    hits: FloatArray
    """Right answers by emotion, `(1 + R, num_models, num_conditions, 5)`; NaN where not run."""
    named: FloatArray
    """Answers that name the emotion, right or wrong, of the same shape."""
    present: FloatArray
    """Episodes of the emotion, `(1 + R, 1, 1, 5)`."""

    def macro_f1(self, *, among_present: bool = False) -> FloatArray:
        """Macro-F1, `(1 + R, num_models, num_conditions)`.

        Args:
            among_present: Average over the emotions that there are, not over all five.
        """
        both = self.present + self.named
        scores = np.divide(2 * self.hits, both, out=np.zeros(both.shape), where=both != 0)
        if among_present:
            there = self.present > 0
            means = _ratio((scores * there).sum(axis=-1), there.sum(axis=-1))
        else:
            means = scores.sum(axis=-1) / len(EMOTIONS)
        return np.where(self.present.sum(axis=-1) > 0, means, math.nan)

    def accuracy(self) -> FloatArray:
        """Share of right answers, `(1 + R, num_models, num_conditions)`."""
        return _ratio(self.hits.sum(axis=-1), self.present.sum(axis=-1))

    def recall(self) -> FloatArray:
        """Share of right answers by emotion, `(1 + R, num_models, num_conditions, 5)`."""
        return _ratio(self.hits, self.present)


def recognition_in(table: ScoredTable, drawing: Drawing, where: NDArray[np.bool_]) -> Recognition:
    """Counts over the episodes of `where`, `(num_episodes,)`."""
    episodes = np.flatnonzero(where)
    answers, truth = table.answers[..., episodes], table.truth[episodes]
    cells, kinds = table.was_run.size, len(EMOTIONS)
    flat = answers.reshape(cells, len(episodes))
    groups = np.arange(cells)[:, None] * kinds + flat
    there = np.broadcast_to(episodes, flat.shape)
    right, parsed = flat == truth, flat >= 0
    shape = (-1, *table.was_run.shape, kinds)
    hits = drawing.counts(groups[right], there[right], cells * kinds).reshape(shape)
    named = drawing.counts(groups[parsed], there[parsed], cells * kinds).reshape(shape)
    present = drawing.counts(truth.astype(np.int64), episodes, kinds)[:, None, None]
    hits[:, ~table.was_run] = math.nan
    named[:, ~table.was_run] = math.nan
    return Recognition(hits, named, present)


def _ratio(top: FloatArray, bottom: NDArray[np.generic]) -> FloatArray:
    """Their ratio, NaN where the bottom is 0."""
    shape = np.broadcast_shapes(top.shape, bottom.shape)
    out: FloatArray = np.divide(
        top, bottom, out=np.full(shape, math.nan), where=np.broadcast_to(bottom, shape) != 0
    )
    return out
