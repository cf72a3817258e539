"""What an answer came to."""

from __future__ import annotations

import dataclasses

from affectsim_data.evaluation.scored import Outcome, outcome_code
from affectsim_data.motions import EMOTIONS
from affectsim_data.motions.motion import Emotion

__all__ = ["Answer"]


@dataclasses.dataclass(frozen=True)
class Answer:
    """A label or an outcome, never both, and why."""

    label: Emotion | None
    """The emotion named; `None` if none was."""
    outcome: Outcome | None
    """What stands in its place; `None` if an emotion was named."""
    reason: str
    """The rule that decided and the words it decided on, for whoever audits."""

    def __post_init__(self) -> None:
        if (self.label is None) == (self.outcome is None):
            raise ValueError(
                f"an answer is a label or an outcome, got {self.label!r} and {self.outcome!r}"
            )

    @property
    def code(self) -> int:
        """As `ScoredTable.answers` holds it: the index of the emotion or an `outcome_code`."""
        if self.label is not None:
            return EMOTIONS.index(self.label)
        assert self.outcome is not None
        return outcome_code(self.outcome)

    def because(self, rule: str) -> Answer:
        """The same answer, the rule that led to it said first."""
        return dataclasses.replace(self, reason=f"{rule}: {self.reason}")
