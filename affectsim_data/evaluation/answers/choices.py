"""Answers by letter or number, in whatever order the options were given."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence

from affectsim_data.evaluation.answers.answer import Answer
from affectsim_data.evaluation.answers.words import Meaning, meaning_of
from affectsim_data.motions import EMOTIONS

__all__ = ["Options", "bare_choice", "picked_choice"]

_LETTERS = "ABCDEFGHIJ"
_ENTRY = re.compile(r"(?<![\w'])\(?([A-Ja-j]|\d)[).:\]]\s?\(?\"?([A-Za-z]{3,20})\b")
_MIN_STATED = 3
"""Entries a list needs to be taken for the options."""
_MAX_LAST = 6
"""Signs of a last line that is but a letter or a number with its dressing."""
_BARE = re.compile(
    r"\W*(?:(?:so |the |my |final |correct |best |right )*(?:option|choice|answer|letter|number|"
    r"label|class|category|emotion)?(?: is| would be)?)\W*"
    r"(?<!\w)([A-Z]|(?<![-.])\d{1,3}(?:\.\d{1,9})?(?:\s?%|\s?/\s?\d{1,3})?)\W*",
    re.IGNORECASE,
)
_SEVERAL = re.compile(
    r"\W*(?:(?:either|both|option|options|answer|is) )*\W*([A-J]|\d)"
    r"(?:(?:\W{1,4}|\W{0,3}\b(?:or|and)\b\W{0,3})([A-J]|\d))+\W*",
    re.IGNORECASE,
)
_LEADING = re.compile(r"\W*([A-Ja-j]|\d)(?:\s?[).:\]]+|,| -)\s?(?:\(?\"?)(.*)", re.DOTALL)
_LEADING_CLAUSE = re.compile(r"\W*([A-J]) (?:is|seems|would be|because|as|since)\b")
_NEXT_ENTRY = re.compile(r"(?<!\w)\(?[Bb2][).:\]]\s?\w")
_PICKED = re.compile(
    r"\b(?:(?i:options?|choice|letter|number)\s?(?:is |would be |: ?)?\W{0,2}([A-Ja-j]|\d)|"
    r"(?i:answer)\s?(?:is|would be|:)\s?\W{0,2}([A-J]|\d)|"
    r"(?i:choose|pick|select|go with|going with|opt for|choosing|selecting|chose)(?:\s|:\s?)"
    r"(?:the )?\W?([A-J])|"
    r"(?i:is)\s\W{0,2}([A-J])(?=\W{0,3}$)|"
    r"([B-J]) is (?:right|correct|(?:the|my) (?:best|right|correct|most|answer|choice)))"
    r"(?=$|[^\w'])(?! [a-z]+ (?:person|man|woman|figure))",
)


@dataclasses.dataclass(frozen=True)
class Options:
    """The order letters and numbers count in."""

    names: tuple[str, ...]
    """Words of the options, the first being A and 1."""
    known: bool
    """Whether the caller or the answer stated the order; else it is that of `EMOTIONS`."""

    @classmethod
    def of(cls, options: Sequence[str] | None) -> Options:
        """The caller's options, or the five emotions in their order.

        Raises:
            ValueError: An option is in no table of words, is there twice, or there are too many.
        """
        if options is None:
            return cls(EMOTIONS, known=False)
        names = tuple(option.strip().casefold() for option in options)
        unknown = [name for name in names if meaning_of(name) is None]
        if unknown or len(set(names)) < len(names) or not 2 <= len(names) <= len(_LETTERS):
            raise ValueError(
                f"options must be 2 to {len(_LETTERS)} different words of docs/answers.md, "
                f"got {list(options)}" + (f"; unknown: {unknown}" if unknown else "")
            )
        return cls(names, known=True)

    def stated_in(self, text: str) -> tuple[Options, str]:
        """The options an answer lists itself, if it does, and the answer without that list."""
        run: list[re.Match[str]] = []
        for entry in _ENTRY.finditer(text):
            if meaning_of(entry[2].casefold()) is None:
                continue
            if _place(entry[1]) == len(run):
                run.append(entry)
            elif len(run) < _MIN_STATED:
                run = [entry] if _place(entry[1]) == 0 else []
        if len(run) < _MIN_STATED:
            return self, text
        names = tuple(entry[2].casefold() for entry in run)
        ends = [0, *(entry.end() for entry in run)]
        starts = [*(entry.start() for entry in run), len(text)]
        rest = [text[end:start] for end, start in zip(ends, starts, strict=True)]
        return Options(names, known=True), " \n ".join(rest)

    def meaning(self, sign: str) -> Meaning | None:
        """What a letter or number stands for; `None` beyond the last option."""
        place = _place(sign)
        return meaning_of(self.names[place]) if 0 <= place < len(self.names) else None

    def answer(self, sign: str, rule: str) -> Answer:
        """The answer a letter or number gives."""
        meaning = self.meaning(sign)
        order = "options" if self.known else "default order"
        if meaning is None:
            return Answer(None, "other", f"{rule}: {sign!r} is none of the options")
        if meaning == "outside" or meaning == "near":
            name = self.names[_place(sign)]
            return Answer(None, "other", f"{rule}: {sign!r} is {name!r}, none of the five")
        return Answer(meaning, None, f"{rule}: {sign!r} in the {order} is {meaning}")


def bare_choice(text: str, options: Options) -> Answer | None:
    """The answer if the text is nothing but letters or numbers, or begins with one as a choice."""
    lines = text.strip().split("\n")
    line = lines[0][:400]
    if len(line) <= 60:
        if bare := _BARE.fullmatch(line):
            return options.answer(bare[1].upper(), "bare choice")
        if _SEVERAL.fullmatch(line):
            return _several(line, options)
    if clause := _LEADING_CLAUSE.match(line):
        return options.answer(clause[1], "leading choice")
    last = lines[-1][:_MAX_LAST].strip()
    if last == lines[-1].strip() and (bare := _BARE.fullmatch(last)):
        return options.answer(bare[1].upper(), "last line")
    return _leading_choice(line, text, options)


def picked_choice(text: str, options: Options) -> Answer | None:
    """The answer of the last phrase that picks a letter or number: `option B`, `I choose (C)`."""
    picks = list(_PICKED.finditer(text))
    if not picks:
        return None
    last = picks[-1]
    sign = next(part for part in last.groups() if part is not None)
    named = _first_word(text[last.end() : last.end() + 40])
    return _reconciled(sign.upper(), named, options, "choice")


def _several(line: str, options: Options) -> Answer:
    signs = re.findall(r"(?<!\w)(?:[A-Ja-j]|\d)(?!\w)", line)
    meanings = {options.meaning(sign) for sign in signs}
    if len(meanings) == 1:
        return options.answer(signs[0].upper(), "bare choice")
    return Answer(None, "ambiguous", f"several choices: {', '.join(signs)}")


def _leading_choice(line: str, text: str, options: Options) -> Answer | None:
    """`B. sad`, `(C) because ...`; not the first entry of a list of reasons."""
    leading = _LEADING.match(line)
    if leading is None or _NEXT_ENTRY.search(text, leading.end(1) + 1):
        return None
    sign, named = leading[1], _first_word(leading[2])
    if sign == "A" and named is None and line.lstrip("\"'([").startswith("A:"):
        return None  # a question's answer, `A: The person ...`
    if named is None and (sign.isdigit() or sign.islower() or leading[2][:1].isdigit()):
        return None
    return _reconciled(sign.upper(), named, options, "leading choice")


def _first_word(text: str) -> str | None:
    """The first word after a choice, if the tables know it."""
    found = re.match(r"\W{0,4}([A-Za-z]{3,20})\b", text)
    return found[1].casefold() if found and meaning_of(found[1].casefold()) else None


def _reconciled(sign: str, named: str | None, options: Options, rule: str) -> Answer:
    """Letter and word together: they must agree where the order of options is known."""
    meaning = meaning_of(named) if named else None
    if meaning is None or meaning == options.meaning(sign):
        return options.answer(sign, rule)
    if options.known:
        told = f"{sign!r} is {options.meaning(sign)}, the word beside it {named!r}"
        return Answer(None, "ambiguous", f"{rule}: {told}")
    if meaning == "outside" or meaning == "near":
        return Answer(None, "other", f"{rule}: {named!r} is none of the five")
    return Answer(meaning, None, f"{rule}: the word {named!r} beside {sign!r}, order not known")


def _place(sign: str) -> int:
    """Index of a letter or number; -1 for 0 and anything longer."""
    if sign.isdigit():
        return int(sign) - 1 if len(sign) < 4 else -1
    if re.fullmatch(r"[1-9]\.0+", sign):
        return int(sign[0]) - 1
    return _LETTERS.find(sign.upper()) if len(sign) == 1 else -1
