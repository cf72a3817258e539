"""Answers in JSON, whole, dressed or cut off, and scores listed per emotion."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

from affectsim_data.evaluation.answers.answer import Answer
from affectsim_data.evaluation.answers.words import Meaning, meaning_of
from affectsim_data.motions.motion import Emotion

__all__ = ["best_scored", "json_values", "listed_scores", "scores_in"]

_KEYS = (
    "final_answer",
    "final_emotion",
    "final_label",
    "answer",
    "emotion",
    "predicted_emotion",
    "dominant_emotion",
    "primary_emotion",
    "main_emotion",
    "overall_emotion",
    "emotion_label",
    "emotional_state",
    "label",
    "prediction",
    "predicted_label",
    "class",
    "category",
    "classification",
    "choice",
    "option",
    "mood",
    "feeling",
    "result",
    "output",
    "response",
    "emotions",
    "emotion_id",
)
"""Fields that hold the answer, the more telling first."""
_NAME_KEYS = (*_KEYS, "name", "value")
_SCORE_KEYS = ("score", "probability", "confidence", "prob", "likelihood", "percentage", "weight")
_MAX_FAILURES = 8
"""Tries at text that begins like JSON and is none; each may cost its whole length."""
_MAX_DEPTH = 12
_FIELD = re.compile(
    r"[\"']?(\b[A-Za-z_]{2,24})[\"']?\s?:\s?(?:\"([^\"\n]{0,200})\"?|'([^'\n]{0,200})'?|"
    r"([\w. ]{1,60}))"
)
_GRADES = {
    **dict.fromkeys(("no", "none", "false", "absent", "unlikely"), 0.0),
    "low": 0.1,
    **dict.fromkeys(("medium", "moderate"), 0.5),
    "high": 0.9,
    **dict.fromkeys(("yes", "true", "present"), 1.0),
}
_VALUE = r"(\d{1,3}(?:\.\d{1,9})?|" + "|".join(_GRADES) + r")(?![\w.])"
_WORD_FIRST = re.compile(r"\b([a-z]{3,20})\s?[:=|(-]\s?\(?" + _VALUE)
_SCORE_FIRST = re.compile(r"\b(\d{1,3}(?:\.\d{1,9})?)\s?%\s?(?:is\s)?([a-z]{3,20})\b")
_WORD_THEN_NUMBER = re.compile(r"\b([a-z]{3,20}) (\d{1,3}(?:\.\d{1,9})?)(?=[,;\n]|$)")
_MIN_NUMBERED = 4
"""Emotions with a bare number behind them that make a list of scores."""
_WORD_THEN_PERCENT = re.compile(r"\b([a-z]{3,20}) (\d{1,3}(?:\.\d{1,9})?) ?%")
_BOX = r"(\[[x✓✔ ]\]|[☑✅✓✔☐✗✘❌⬜])"
_TICK_FIRST = re.compile(_BOX + r" ?([a-z]{3,20})\b")
_TICK_LAST = re.compile(r"\b([a-z]{3,20}) ?[:-]? ?" + _BOX)
_TICKS = ("[x]", "[✓]", "[✔]", "☑", "✅", "✓", "✔")


def json_values(text: str) -> list[Any] | None:
    """What the JSON in a text gives as the answer, object by object; `None` without JSON.

    A value is a string, a number, `None`, or a mapping of emotion words to scores. Broken and
    cut-off JSON is read field by field.
    """
    begin = min((at for at in (text.find("{"), text.find("[")) if at >= 0), default=-1)
    if text[:1] == '"' and text[-1:] == '"' and begin < 0 and len(text) > 2:
        return [text[1:-1]]
    if begin < 0:
        return None
    values = [value for found in _decoded(text, begin) for value in _answers_in(found, 0)]
    if values:
        return values
    return _fields(text[text.find("{") :]) if "{" in text else None


def scores_in(value: dict[Any, Any]) -> dict[Meaning, float]:
    """Scores by emotion, from a mapping of words to numbers, percentages or yes and no."""
    scores: dict[Meaning, float] = {}
    for key, score in value.items():
        meaning = meaning_of(str(key).strip().casefold())
        number = _number(score)
        if meaning is not None and number is not None:
            scores[meaning] = max(number, scores.get(meaning, number))
    return scores


def listed_scores(text: str) -> dict[Meaning, float]:
    """Scores written out in prose or a table, `happy: 0.7`, `70% happy`, `[x] happy`; else empty.

    The text is in lower case. One scored emotion alone is no list.
    """
    pairs = [(found[1], found[2]) for found in _WORD_FIRST.finditer(text)]
    pairs += [(found[2], found[1]) for found in _SCORE_FIRST.finditer(text)]
    if len(scores_in(_first_of_each(pairs))) < 2:
        pairs += [(found[1], found[2]) for found in _WORD_THEN_PERCENT.finditer(text)]
    scores = scores_in(_first_of_each(pairs))
    if len(scores) < 2:
        scores = scores_in(_ticked(text))
    if len(scores) < 2:
        numbered = [(found[1], found[2]) for found in _WORD_THEN_NUMBER.finditer(text)]
        scores = scores_in(_first_of_each(numbered))
        return scores if len(scores) >= _MIN_NUMBERED else {}
    return scores if len(scores) >= 2 else {}


def best_scored(scores: dict[Meaning, float]) -> Answer:
    """The emotion with the highest score; `ambiguous` if it shares it with another."""
    best = max(scores.values())
    names = sorted(name for name, score in scores.items() if score == best)
    said = ", ".join(f"{name} {score:g}" for name, score in scores.items())
    if len(names) > 1:
        return Answer(None, "ambiguous", f"equal scores ({said})")
    name: Meaning = names[0]
    if name == "outside" or name == "near":
        return Answer(None, "other", f"the highest score is of none of the five ({said})")
    label: Emotion = name
    return Answer(label, None, f"highest score ({said})")


def _ticked(text: str) -> dict[str, bool]:
    """Words with a box before or, if the first box stands there, behind them."""
    before, behind = _TICK_FIRST.search(text), _TICK_LAST.search(text)
    if before and (behind is None or before.start() < behind.start()):
        return {found[2]: found[1] in _TICKS for found in _TICK_FIRST.finditer(text)}
    return {found[1]: found[2] in _TICKS for found in _TICK_LAST.finditer(text)}


def _first_of_each(pairs: list[tuple[str, str]]) -> dict[str, str]:
    kept: dict[str, str] = {}
    for word, score in pairs:
        kept.setdefault(word, score)
    return kept


def _number(score: object) -> float | None:
    """A score as a number; `None` for anything else and NaN."""
    if isinstance(score, str):
        said = score.strip().rstrip("%").strip().casefold()
        if said in _GRADES:
            return _GRADES[said]
        if not re.fullmatch(r"\d{1,12}(?:\.\d{1,18})?", said):
            return None
        return float(said)
    if isinstance(score, (bool, int, float)) and score == score and abs(score) < 1e12:
        return float(score)
    return None


def _decoded(text: str, begin: int) -> Iterator[Any]:
    """Objects and lists of a text, one after the other."""
    decoder = json.JSONDecoder()
    failures = 0
    start = re.compile(r"[{\[]")
    found = start.search(text, begin)
    while found and failures < _MAX_FAILURES:
        try:
            value, end = decoder.raw_decode(text, found.start())
            yield value
        except (ValueError, RecursionError):
            failures += 1
            end = found.start() + 1
        found = start.search(text, end)


def _answers_in(value: Any, depth: int) -> list[Any]:
    """What a decoded value answers: the first telling field, or those of what it holds."""
    if depth > _MAX_DEPTH:
        return []
    if isinstance(value, list):
        return _answers_of_list(value, depth)
    if not isinstance(value, dict):
        return []
    fields = {str(key).strip().casefold().replace(" ", "_"): held for key, held in value.items()}
    for key in _KEYS:
        if key in fields and (held := _held(fields[key], depth)):
            return held
    if len(scores_in(value)) >= 2 or (len(value) == 1 and scores_in(value)):
        return [value]
    parts = {key: _score_of(held) for key, held in value.items() if isinstance(held, dict)}
    if len(scores_in(parts)) >= 2:
        return [parts]
    inner = [answer for held in value.values() for answer in _answers_in(held, depth + 1)]
    return inner if inner or value else [""]


def _score_of(fields: dict[Any, Any]) -> Any:
    """The score among the fields said of one emotion."""
    return next((fields[key] for key in _SCORE_KEYS if key in fields), None)


def _held(value: Any, depth: int) -> list[Any]:
    """The answer a telling field holds."""
    if isinstance(value, (dict, list)):
        return _answers_in(value, depth + 1)
    return [value]


def _answers_of_list(value: list[Any], depth: int) -> list[Any]:
    scored: dict[Any, Any] = {}
    for entry in value:
        fields = entry if isinstance(entry, dict) else {}
        name = next((fields[key] for key in _NAME_KEYS if isinstance(fields.get(key), str)), None)
        score = _score_of(fields)
        if name is not None and score is not None:
            scored[name] = score
    if len(scored) > 1 and len(scored) == len(value):
        return [scored]
    answers = [entry for entry in value if isinstance(entry, str)]
    return answers + [answer for entry in value for answer in _answers_in(entry, depth + 1)]


def _fields(text: str) -> list[Any] | None:
    """The most telling field of text that looks like JSON and cannot be decoded."""
    fields: dict[str, str] = {}
    for found in _FIELD.finditer(text):
        value = next((part for part in found.groups()[1:] if part is not None), "")
        fields[found[1].casefold()] = value
    chosen = next((fields[key] for key in _KEYS if key in fields), None)
    if chosen is not None:
        return [chosen]
    return [dict(fields)] if len(scores_in(fields)) >= 2 else None
