"""From raw model text to an answer: the rules, in their order."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.evaluation.answers.answer import Answer
from affectsim_data.evaluation.answers.choices import Options, bare_choice, picked_choice
from affectsim_data.evaluation.answers.cleaning import answering_part, is_blank, plain
from affectsim_data.evaluation.answers.prose import weigh_prose
from affectsim_data.evaluation.answers.structured import (
    best_scored,
    json_values,
    listed_scores,
    scores_in,
)
from affectsim_data.evaluation.answers.words import EMOJI

__all__ = ["audit_answers", "parse_answer", "parse_answers"]

_TAG = re.compile(
    r"<\s?(?:final_)?(?:answer|emotion|label|prediction|output|result|final)\s?>", re.IGNORECASE
)
_BOX = re.compile(r"\\boxed\s?\{")
_FINAL = re.compile(
    r"\b(?:final|ultimate) (?:answer|label|emotion|choice|prediction|decision|verdict|"
    r"classification|response)\b(?: would be| will be| is)?\s?[:=-]{0,2}",
    re.IGNORECASE,
)
_ANSWER = re.compile(
    r"\b(?:answer|conclusion|verdict)(?:\s?[:=]+| -{1,2} | (?:is|would be|will be)\b\s?:?)",
    re.IGNORECASE,
)
_FIELD = re.compile(
    r"\b(?:emotions?|emotional state|label|prediction|classification|category|class|mood|feeling|"
    r"result|output|response|choice)(?: (?:displayed|shown|detected|conveyed|is))?"
    r"(?:\s?[:=]+| -{1,2} )",
    re.IGNORECASE,
)
_NOT_THE_FIELD = re.compile(
    r"(?:secondary|second|other|possible|alternative|alternate|next|background|following|five|"
    r"these|of|for|allowed|available|candidate)\s$",
    re.IGNORECASE,
)
_NOTHING = ("no word of the tables", "only repeats the options")
"""Reasons that leave the word to the next rule."""


def parse_answer(text: str | None, *, options: Sequence[str] | None = None) -> Answer:
    """The emotion a raw answer names, or what stands in its place.

    The rules and their order are in docs/answers.md; time grows linearly with the text.

    Args:
        text: As a model said it; `None` counts as empty.
        options: The order letters and numbers count in; that of `EMOTIONS` by default. Options
            an answer lists itself go first.

    Raises:
        ValueError: An option is in no table of words, or there twice.

    Examples:
        >>> parse_answer("Not angry but sad.").label
        'sad'
        >>> parse_answer("B", options=("happy", "neutral")).label
        'neutral'
        >>> parse_answer("Either angry or fearful.").outcome
        'ambiguous'
    """
    order = Options.of(options)
    if text is None:
        return Answer(None, "empty", "no text")
    body = answering_part(text)
    if is_blank(body) and not any(sign in EMOJI for sign in body):
        kind = "no word" if is_blank(text) else "nothing but thinking or marks"
        return Answer(None, "empty", kind)
    return _decided(body, order)


def parse_answers(
    texts: Sequence[str | None], *, options: Sequence[str] | None = None
) -> NDArray[np.int8]:
    """Codes of answers as `ScoredTable.answers` holds them, each distinct text parsed once.

    Examples:
        >>> parse_answers(["happy", "I can't tell.", "happy"]).tolist()
        [2, -1, 2]
    """
    codes: dict[str | None, int] = {}
    for text in texts:
        if text not in codes:
            codes[text] = parse_answer(text, options=options).code
    return np.array([codes[text] for text in texts], dtype=np.int8)


def audit_answers(
    texts: Sequence[str | None], *, options: Sequence[str] | None = None
) -> list[tuple[int, str | None, Answer]]:
    """Distinct texts with how often they came and what they were taken for, the commonest first.

    Examples:
        >>> [(count, said.label) for count, _, said in audit_answers(["sad", "C", "sad"])]
        [(2, 'sad'), (1, 'happy')]
    """
    counts = Counter(texts)
    return [
        (count, text, parse_answer(text, options=options)) for text, count in counts.most_common()
    ]


def _decided(body: str, order: Options) -> Answer:
    """The first rule that applies."""
    text = plain(body)
    return (
        _tagged(body, order)
        or (_by_json(body, order) if body[0] in "{[" else None)
        or _marked(text, _FINAL, "final answer", order)
        or _by_json(body, order)
        or _marked(text, _ANSWER, "answer", order)
        or _in_fields(text, order)
        or _unmarked(text, order)
    )


def _unmarked(text: str, order: Options) -> Answer:
    """A choice, listed scores, or else what the sentences say."""
    scores = listed_scores(text.casefold())
    if scores:
        return best_scored(scores)
    stated, rest = order.stated_in(text)
    choice = bare_choice(rest, stated) or picked_choice(rest, stated)
    if choice is not None:
        return choice
    answer = weigh_prose(rest)
    if rest is not text and answer.outcome in ("other", "empty"):
        return Answer(None, "ambiguous", "only repeats the options")
    return answer


def _tagged(body: str, order: Options) -> Answer | None:
    """What the last `<answer>` or `\\boxed{}` holds."""
    tags = [(found.end(), "<") for found in _TAG.finditer(body)]
    boxes = [(found.end(), "}") for found in _BOX.finditer(body)]
    if not tags and not boxes:
        return None
    begin, sign = max(tags + boxes)
    end = _box_end(body, begin) if sign == "}" else body.find("<", begin)
    held = body[begin : end if end >= 0 else len(body)]
    rule = "boxed" if sign == "}" else "answer tag"
    return _segment(held, rule, order)


def _box_end(body: str, begin: int) -> int:
    depth = 1
    for at in range(begin, len(body)):
        depth += (body[at] == "{") - (body[at] == "}")
        if not depth:
            return at
    return -1


def _marked(text: str, marker: re.Pattern[str], rule: str, order: Options) -> Answer | None:
    """What follows the last marker that has something to say."""
    stated, _ = order.stated_in(text)
    for held in _segments(text, marker):
        if (answer := _segment(held, rule, stated)) is not None:
            return answer
    return None


def _in_fields(text: str, order: Options) -> Answer | None:
    """What fields like `Emotion:` hold; fields that differ are ambiguous."""
    stated, _ = order.stated_in(text)
    answers = [_segment(held, "field", stated) for held in _segments(text, _FIELD)]
    found = {answer.code: answer for answer in answers if answer is not None}
    if len(found) > 1:
        return Answer(None, "ambiguous", "fields that differ")
    return next(iter(found.values()), None)


def _segments(text: str, marker: re.Pattern[str]) -> Iterator[str]:
    """What follows each marker up to the end of its line or the next marker, the last first.

    They do not overlap, so that all of them together are no longer than the text.
    """
    found = [one for one in marker.finditer(text) if _is_field(text, one.start())]
    end = len(text)
    for one in reversed(found):
        held = text[one.end() : end].lstrip(" \n:=->\"'([")
        yield held if held[:1] in ("{",) else held.split("\n", 1)[0]
        end = one.start()


def _is_field(text: str, start: int) -> bool:
    return _NOT_THE_FIELD.search(text, max(0, start - 14), start) is None


def _segment(held: str, rule: str, order: Options) -> Answer | None:
    """The answer in a marked piece of text; `None` if it says nothing the rules know."""
    if is_blank(held) and not any(sign in EMOJI for sign in held):
        return None
    answer = _by_json(held, order) or _by_first_sentence(plain(held), order)
    if answer.reason in _NOTHING:
        return None
    return answer.because(rule)


def _by_first_sentence(text: str, order: Options) -> Answer:
    first = re.split(r"(?<=[a-z])[.;] ", text, maxsplit=1)[0]
    answer = _unmarked(first, order)
    return answer if answer.outcome != "other" or first == text else _unmarked(text, order)


def _by_json(body: str, order: Options) -> Answer | None:
    """What the JSON of an answer says; values that differ are ambiguous."""
    values = json_values(body)
    if values is None:
        return None
    found = {answer.code: answer for answer in (_by_value(value, order) for value in values)}
    if len(found) > 1:
        told = " and ".join(answer.label or str(answer.outcome) for answer in found.values())
        return Answer(None, "ambiguous", f"JSON: {told}")
    return next((answer.because("JSON") for answer in found.values()), None)


def _by_value(value: Any, order: Options) -> Answer:
    if isinstance(value, dict):
        scores = scores_in(value)
        return best_scored(scores) if scores else Answer(None, "other", "no score of an emotion")
    said = "" if value is None else plain(str(value))
    return _unmarked(said, order) if not is_blank(said) else Answer(None, "empty", "empty value")
