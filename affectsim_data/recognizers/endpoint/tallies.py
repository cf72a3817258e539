"""What a run over an endpoint has taken so far, and whether it may go on."""

from __future__ import annotations

import collections
import dataclasses

from affectsim_data.recognizers.endpoint.costs import Prices
from affectsim_data.recognizers.endpoint.replies import Answer

__all__ = ["Tally", "Usage"]


@dataclasses.dataclass(frozen=True)
class Usage:
    """Counts over a run: a prediction table has no place for them."""

    requests: int = 0
    """Sent, repeats included."""
    repeats: int = 0
    """Of these, sent again after a failure."""
    answered: int = 0
    """Clips with an answer."""
    failed: int = 0
    """Clips without one."""
    refused: int = 0
    """Answers by which a model or a filter declined."""
    truncated: int = 0
    """Answers that a limit of length ended; their text is kept as far as it came."""
    tokens_in: int = 0
    """As the endpoint counted them."""
    tokens_out: int = 0
    """As the endpoint counted them."""
    uncounted: int = 0
    """Answers of which the endpoint did not tell the tokens; they are not in the numbers above."""
    cost_usd: float | None = None
    """Of the tokens above, and for uncounted answers as estimated; `None` without prices."""

    def lines(self) -> list[str]:
        """For people, a line each."""
        lines = [
            f"answered  {self.answered:,}: {self.refused:,} refusals, {self.truncated:,} cut short",
            f"failed    {self.failed:,}",
            f"requests  {self.requests:,}, {self.repeats:,} of them repeats",
            f"tokens    {self.tokens_in:,} in, {self.tokens_out:,} out",
        ]
        if self.uncounted:
            lines[-1] += f"; not told for {self.uncounted:,} answers"
        if self.cost_usd is not None:
            lines.append(f"cost      {self.cost_usd:,.4f} USD")
        return lines


class Tally:
    """Adds up what requests take, and says when money runs out."""

    def __init__(self, prices: Prices | None, max_cost_usd: float | None) -> None:
        if max_cost_usd is not None and prices is None:
            raise ValueError("max_cost_usd needs prices: what the endpoint charges for tokens")
        if max_cost_usd is not None and not max_cost_usd >= 0:
            raise ValueError(f"max_cost_usd must be 0 or more, got {max_cost_usd}")
        self._prices = prices
        self._max_cost_usd = max_cost_usd
        self._counts: collections.Counter[str] = collections.Counter()
        self._cost_usd = 0.0
        self._in_work, self._in_work_usd = 0, 0.0

    @property
    def is_working(self) -> bool:
        """Whether a request is on its way."""
        return self._in_work > 0

    def usage(self) -> Usage:
        """All so far."""
        return Usage(**self._counts, cost_usd=None if self._prices is None else self._cost_usd)

    def count(self, name: str) -> None:
        """Counts one more of a field of `Usage`."""
        self._counts[name] += 1

    def begin(self, expected: tuple[int, int]) -> float | None:
        """Sets money aside for a request.

        Args:
            expected: Its tokens in and out as estimated.

        Returns:
            USD set aside, for `end`; `None` if that is more than there is.
        """
        cost_usd = self._expected_usd(expected)
        limit_usd = self._max_cost_usd
        if limit_usd is not None and self._cost_usd + self._in_work_usd + cost_usd > limit_usd:
            return None
        self._in_work += 1
        self._in_work_usd += cost_usd
        self._counts["requests"] += 1
        return cost_usd

    def end(self, set_aside_usd: float, answer: Answer | None) -> None:
        """Takes what a request cost; nothing, as far as we know, without an answer."""
        self._in_work -= 1
        self._in_work_usd -= set_aside_usd
        if answer is None:
            return
        self._counts["answered"] += 1
        self._counts["refused"] += answer.is_refusal
        self._counts["truncated"] += answer.is_truncated
        if answer.tokens_in is None or answer.tokens_out is None:
            self._counts["uncounted"] += 1
            self._cost_usd += set_aside_usd
            return
        self._counts["tokens_in"] += answer.tokens_in
        self._counts["tokens_out"] += answer.tokens_out
        if self._prices is not None:
            self._cost_usd += self._prices.cost(answer.tokens_in, answer.tokens_out)

    def out_of_money(self) -> str:
        """Why no request may be made any more."""
        return (
            f"{self._cost_usd:.2f} of {self._max_cost_usd:.2f} USD are spent, and the next request "
            "might pass the limit; run again with another max_cost_usd to go on"
        )

    def _expected_usd(self, expected: tuple[int, int]) -> float:
        """By the answers so far, once there are any."""
        if self._prices is None:
            return 0.0
        counted = self._counts["answered"] - self._counts["uncounted"]
        if not counted:
            return self._prices.cost(*expected)
        mean_in = self._counts["tokens_in"] / counted
        return self._prices.cost(mean_in, self._counts["tokens_out"] / counted)
