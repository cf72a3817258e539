"""How many candidates each constraint leaves, and which one left none."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

__all__ = ["Ledger"]


class Ledger:
    """Counts candidates after each constraint, in the order the constraints are first met."""

    def __init__(self, counts: Mapping[str, int] | None = None) -> None:
        """Goes on from counts made before."""
        self.counts: dict[str, int] = dict(counts or {})

    def note(self, constraint: str, count: int) -> None:
        """That many more candidates meet a constraint."""
        self.counts[constraint] = self.counts.get(constraint, 0) + int(count)

    def keep(
        self, constraint: str, candidates: NDArray[np.intp], holds: NDArray[np.bool_]
    ) -> NDArray[np.intp]:
        """Those of some candidates, `(n,)`, for which a constraint holds, `(n,)`; counts them."""
        kept = candidates[holds]
        self.note(constraint, len(kept))
        return kept

    @property
    def binding(self) -> str:
        """The first constraint that no candidate meets; the last one there is if all are met."""
        unmet = [name for name, count in self.counts.items() if count == 0]
        return unmet[0] if unmet else next(reversed(self.counts), "candidates")
