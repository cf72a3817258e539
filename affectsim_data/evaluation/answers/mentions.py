"""What a sentence says of the emotions it names: denied, listed, hedged, said, concluded."""

from __future__ import annotations

import dataclasses
import itertools
from enum import IntEnum

from affectsim_data.evaluation.answers.cues import (
    AND,
    COPULAS,
    FILLERS,
    LASTING,
    LIST_CUES,
    OR,
    RANKED,
    SAYING,
    STATING,
    STRONG,
    STRONG_AFTER,
    WEAK,
)
from affectsim_data.evaluation.answers.denials import (
    REACH,
    clause_of,
    denied_after,
    denied_before,
)
from affectsim_data.evaluation.answers.sentences import Sentence
from affectsim_data.evaluation.answers.words import Meaning, meaning_of

__all__ = ["Mention", "Weight", "mentions_in"]


class Weight(IntEnum):
    """How far a sentence commits to an emotion it names."""

    LISTED = -1
    """One of the options, repeated."""
    DENIED = 0
    HEDGED = 1
    SAID = 2
    """Named somewhere in a sentence."""
    STATED = 3
    """Said of the person: `looks sad`, `the emotion is anger`."""
    CONCLUDED = 4
    """Weighed or concluded: `mostly`, `overall`, `therefore`, `I would say`."""
    ALONE = 5
    """The whole of a first or last sentence, or its head: `Sad: the shoulders ...`."""


@dataclasses.dataclass(frozen=True)
class Mention:
    """An emotion named in a sentence."""

    meaning: Meaning
    """What the word stands for."""
    word: str
    """The word."""
    place: int
    """Its place among the tokens of the sentence."""
    weight: Weight
    """How far the sentence commits to it."""
    stated: bool
    """Whether it is said of the person, hedged or not."""


_MIN_LISTED = 4
"""Emotions in one enumeration that make it a repetition of the options."""


_MAX_SHORT = 4
"""Tokens of a sentence too short to say anything else."""


def mentions_in(sentence: Sentence) -> list[Mention]:
    """Emotions named in a sentence, in its order."""
    places = [at for at, meaning in enumerate(sentence.meanings) if meaning is not None]
    if not places:
        return []
    groups = _groups(sentence, places)
    inside = {at for group in groups for at in range(group[0], group[-1] + 1)}
    denied = denied_before(sentence, groups, inside) | denied_after(sentence, groups)
    listed = {at for group in groups if _is_listed(sentence, group) for at in group}
    # A denied list still denies: `no anger, fear, joy or sadness`.
    given = dict.fromkeys(listed, Weight.LISTED) | dict.fromkeys(denied, Weight.DENIED)
    levels = _levels(sentence, inside)
    strong = _strong_after(sentence, groups)
    stated = _stated(sentence, places)
    mentions = []
    for at in places:
        meaning = sentence.meanings[at]
        assert meaning is not None
        weight = Weight.CONCLUDED if at in strong else levels[at]
        if weight == Weight.SAID and at in stated:
            weight = Weight.STATED
        if sentence.asks:
            weight = min(weight, Weight.HEDGED)
        weight = given.get(at, weight)
        mentions.append(Mention(meaning, sentence.tokens[at], at, weight, at in stated))
    return mentions


def _stated(sentence: Sentence, places: list[int]) -> set[int]:
    """Places of what is said of the person: behind a verb of seeming, or before a copula."""
    tokens = sentence.tokens
    if len(tokens) <= _MAX_SHORT:
        return set(places)
    stating = (at for at, token in enumerate(tokens) if token in STATING or token.endswith("'s"))
    first = next(stating, len(tokens))
    return {at for at in places if at > first or COPULAS & set(tokens[at + 1 : at + 2])}


def _groups(sentence: Sentence, places: list[int]) -> list[list[int]]:
    """Places of words enumerated together: `anger, fear, or even sadness`."""
    groups = [[places[0]]]
    links = FILLERS | AND | OR | {",", "-", "[", "]", "nor", "either"}
    for before, at in itertools.pairwise(places):
        between = sentence.tokens[before + 1 : at]
        joined = {",", *AND, *OR} & set(between) or len(groups[-1]) >= _MIN_LISTED - 1
        again = any(sentence.meanings[at] == sentence.meanings[one] for one in groups[-1][-8:])
        if len(between) <= 6 and joined and not again and links.issuperset(between):
            groups[-1].append(at)
        else:
            groups.append([at])
    return groups


def _is_listed(sentence: Sentence, group: list[int]) -> bool:
    """Whether an enumeration repeats the options rather than answers."""
    names = {sentence.meanings[at] for at in group} - {"near", "outside"}
    if len(names) >= _MIN_LISTED:
        return True
    cue = sentence.asks or bool(LIST_CUES & set(sentence.tokens[max(0, group[0] - 8) : group[0]]))
    return len(names) == _MIN_LISTED - 1 and cue


def _strong_after(sentence: Sentence, groups: list[list[int]]) -> set[int]:
    """Places weighed by what follows them: `sadness is the stronger emotion`."""
    strong: set[int] = set()
    for group in groups:
        begin = group[-1] + 1
        clause = clause_of(sentence.tokens[begin : begin + REACH])
        likely = {"more", "most"} & set(clause) and "likely" in clause
        if not any(sentence.meanings[begin : begin + len(clause)]) and (
            likely or STRONG_AFTER & set(clause)
        ):
            strong.update(group)
    return strong


def _levels(sentence: Sentence, inside: set[int]) -> list[Weight]:
    """Weight of each place by the last hedge or conclusion before it in its clause."""
    levels: list[Weight] = []
    level = Weight.SAID
    tokens = sentence.tokens
    for at, token in enumerate(tokens):
        if (
            token == "but"
            or token == "however"
            or (
                token in {",", "(", ")", "-"}
                and at not in inside
                and not (at and tokens[at - 1] in LASTING)
            )
        ):
            level = Weight.SAID
        level = _raised(tokens, at, level)
        levels.append(level)
    return levels


def _raised(tokens: tuple[str, ...], at: int, level: Weight) -> Weight:
    token = tokens[at]
    before = tokens[at - 1] if at else ""
    if token == "likely" and before in {"more", "most"}:
        return Weight.CONCLUDED
    if token == "more" and at + 1 < len(tokens) and meaning_of(tokens[at + 1]):
        return Weight.CONCLUDED
    if token == "likely" and before == "less":
        return Weight.HEDGED
    if token == "first" and before != "at":
        return level
    if token == "second":
        return Weight.HEDGED if RANKED & set(tokens[at + 1 : at + 2]) else level
    if token in STRONG or (token in SAYING and before in {"would", "i'd", "i", "can", "i'll"}):
        return Weight.CONCLUDED
    if token == "so" and (at == 0 or before == ","):
        return Weight.CONCLUDED
    return Weight.HEDGED if token in WEAK else level
