"""What an evaluation found, in sentences that claim no more than its intervals do."""

from __future__ import annotations

import math
from collections.abc import Callable

from affectsim_data.evaluation.results import Benefit, Estimate, Evaluation
from affectsim_data.reports.figures.marks import MINUS, has_interval
from affectsim_data.reports.tables.texts import condition_title, shown

__all__ = ["findings"]

_VIEWS = {
    "p_ref": "Seen from the reference view instead of the robot's first pose",
    "p_mon": "Seen by the monitor near the ceiling instead of from the robot's first pose",
    "a_obs": "Seen after active observation instead of from the robot's first pose",
}
_FIELDS: dict[str, Callable[[Benefit], Estimate]] = {
    "p_ref": lambda benefit: benefit.gap,
    "a_obs": lambda benefit: benefit.gain,
    "p_mon": lambda benefit: benefit.monitor_gap,
}


def findings(evaluation: Evaluation) -> tuple[str, ...]:
    """The main finding first, then what else is to be known before reading any number.

    Sentences hold names of models as tables print them: plain text, not yet escaped.
    """
    compared = [one for one in _FIELDS if {one, "p_init"} <= set(evaluation.conditions)]
    told = [_difference(evaluation, condition) for condition in compared]
    told += [_recovered(evaluation)] if {"a_obs", "p_ref"} <= set(compared) else []
    if not compared:
        told = [_levels(evaluation)]
    return (*(one for one in told if one), _against_chance(evaluation))


def _difference(evaluation: Evaluation, condition: str) -> str:
    """What changes between P-Init and a condition: of one model, or the mean of several."""
    found = [
        benefit
        for card in evaluation.models
        if (benefit := evaluation.benefit(card.model)) is not None
        and not math.isnan(_FIELDS[condition](benefit).value)
    ]
    if not found:
        return ""
    if len(found) == 1:
        return _of_one(evaluation, condition, found[0])
    return _of_many(evaluation, condition, found)


def _of_one(evaluation: Evaluation, condition: str, benefit: Benefit) -> str:
    scores = [evaluation.score(benefit.model, one) for one in ("p_init", condition)]
    values = [math.nan if one is None else one.macro_f1.value for one in scores]
    return _change(
        evaluation,
        f"{_VIEWS[condition]}, {_possessive(shown(benefit.model))} Macro-F1",
        (values[0], values[1]),
        _FIELDS[condition](benefit),
    )


def _of_many(evaluation: Evaluation, condition: str, found: list[Benefit]) -> str:
    mean = next((one for one in evaluation.means if (one.group, one.subset) == ("", "all")), None)
    rises = [_FIELDS[condition](one) for one in found]
    counts = _counts(rises)
    if mean is None:
        return f"{_VIEWS[condition]}: {counts}"
    values = [mean.macro_f1.get(one, Estimate(math.nan)).value for one in ("p_init", condition)]
    known = {"p_ref": mean.gap, "a_obs": mean.gain, "p_mon": mean.monitor_gap}
    estimate = known[condition]
    if math.isnan(estimate.value):
        estimate = Estimate(values[1] - values[0])
    subject = f"{_VIEWS[condition]}, the mean Macro-F1 of {mean.num_models} models"
    return f"{_change(evaluation, subject, (values[0], values[1]), estimate)} {counts}"


def _change(
    evaluation: Evaluation, subject: str, values: tuple[float, float], estimate: Estimate
) -> str:
    """A difference worded after its interval: shown, not shown, or without any."""
    before, after = (f"{100 * value:.1f}" for value in values)
    points = _signed(estimate.value)
    interval = _interval(evaluation, estimate)
    if not interval:
        return f"{subject} is {after} % where it was {before} % ({points} points, no interval)."
    if estimate.excludes_zero:
        verb = "rises" if estimate.value > 0 else "falls"
        return f"{subject} {verb} from {before} % to {after} % ({points} points, {interval})."
    return (
        f"{subject} is {after} % where it was {before} % ({points} points, {interval}): the "
        "interval includes 0, so a difference is not shown."
    )


def _recovered(evaluation: Evaluation) -> str:
    """How much of the gap active observation recovers."""
    if len(evaluation.models) == 1:
        benefit = evaluation.benefit(evaluation.models[0].model)
        ogr = Estimate(math.nan) if benefit is None else benefit.ogr
    else:
        means = [one for one in evaluation.means if (one.group, one.subset) == ("", "all")]
        ogr = means[0].ogr_of_means if means else Estimate(math.nan)
    if math.isnan(ogr.value):
        return (
            "How much of the gap active observation recovers is undefined: the reference view is "
            "not above the first pose."
        )
    text = f"Active observation recovers {100 * ogr.value:.0f} % of the gap to the reference view"
    if ogr.value < 0:
        text = (
            "Active observation recovers nothing of the gap to the reference view: it scores less"
        )
    if not has_interval(ogr) or math.isinf(ogr.low) or math.isinf(ogr.high):
        return f"{text}; the share has no bounded interval."
    low, high = (100 * end for end in (ogr.low, ogr.high))
    text += f" ({_confidence(evaluation)} interval {_end(low, 0)} to {_end(high, 0)} %)"
    return f"{text}." if ogr.excludes_zero else f"{text}; the interval includes 0."


def _levels(evaluation: Evaluation) -> str:
    """Without P-Init there is no difference to tell, only scores."""
    told = []
    for condition in evaluation.conditions:
        scores = [one for one in evaluation.scores if one.condition == condition]
        values = [one.macro_f1.value for one in scores if one.subset == "all"]
        known = [value for value in values if not math.isnan(value)]
        if known:
            span = f"{100 * min(known):.1f}"
            span += f" to {100 * max(known):.1f}" if len(known) > 1 else ""
            told.append(f"{span} % under {shown(condition_title(condition))}")
    if not told:
        return "No model has a score."
    return f"Macro-F1 is {', '.join(told)}. Without P-Init there is nothing to compare these with."


def _against_chance(evaluation: Evaluation) -> str:
    """What guessing scores, and how many scores do not show more than that."""
    text = f"Guessing without looking scores {100 * evaluation.chance:.1f} % on these episodes"
    parts = []
    for condition in evaluation.conditions:
        scores = [one for one in evaluation.scores if one.condition == condition]
        mine = [one.macro_f1 for one in scores if one.subset == "all"]
        weak = [one for one in mine if not _exceeds(one, evaluation.chance)]
        if weak:
            parts.append((shown(condition_title(condition)), len(weak), len(mine)))
    if not parts:
        return f"{text}; every score is above it, with its interval."
    if len(evaluation.models) == 1:
        names = _joined([name for name, _, _ in parts])
        return f"{text}; under {names} the score is not shown to be better than that."
    counts = _joined([f"{weak} of {all_} under {name}" for name, weak, all_ in parts])
    return f"{text}; not shown to be better than that are the scores of {counts}."


def _exceeds(score: Estimate, chance: float) -> bool:
    return score.low > chance


def _counts(rises: list[Estimate]) -> str:
    """How many models score higher and lower, and of how many that is shown."""
    higher, shown_higher = sum(one.value > 0 for one in rises), sum(one.low > 0 for one in rises)
    lower, shown_lower = sum(one.value < 0 for one in rises), sum(one.high < 0 for one in rises)
    number = f"All {len(rises)}" if higher == len(rises) else f"{higher} of {len(rises)}"
    parts = [f"{number} models score higher" if higher else "No model scores higher"]
    if higher:
        parts.append(f"{shown_higher} with an interval above 0")
    if lower:
        parts.append(f"{lower} lower, {shown_lower} with an interval below 0")
    return f"{', '.join(parts)}."


def _joined(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _possessive(name: str) -> str:
    return f"{name}'" if name.endswith("s") else f"{name}'s"


def _interval(evaluation: Evaluation, estimate: Estimate) -> str:
    if not has_interval(estimate):
        return ""
    ends = f"{_end(100 * estimate.low, 1)} to {_end(100 * estimate.high, 1)}"
    return f"{_confidence(evaluation)} interval {ends}"


def _confidence(evaluation: Evaluation) -> str:
    return f"{100 * evaluation.settings.confidence:g} %"


def _end(value: float, digits: int) -> str:
    """The end of an interval with its sign; rounding to nothing leaves no sign."""
    if math.isinf(value):
        return f"{MINUS}∞" if value < 0 else "∞"
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", MINUS)


def _signed(share: float) -> str:
    rounded = round(100 * share, 1) + 0.0
    return f"{rounded:+.1f}".replace("-", MINUS)
