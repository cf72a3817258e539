"""What sentences come to: the emotion they commit to most, or why there is none."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence

from affectsim_data.evaluation.answers.answer import Answer
from affectsim_data.evaluation.answers.cues import BARE_FILLERS, HEAD_ENDS, SUBJECTS, TURNS
from affectsim_data.evaluation.answers.mentions import Mention, Weight, mentions_in
from affectsim_data.evaluation.answers.refusals import declines, doubts, sees_nobody
from affectsim_data.evaluation.answers.sentences import Sentence, sentences_of
from affectsim_data.evaluation.answers.words import EMOJI
from affectsim_data.motions import EMOTIONS
from affectsim_data.motions.motion import Emotion

__all__ = ["weigh_prose"]

_CORRECTS = re.compile(
    r"(?:^|[,.-] )(?:wait|hmm , wait|no|nope|actually|correction|rather)(?= ?(?:,|-|:|\.|$))|"
    r"\b(?:scratch that|on second thoughts?|i mean|i meant|on the contrary|wait ,? ?actually|"
    r"let me correct|correction)\b|^(?:wait|actually)\b"
)
_MAX_HEAD = 3
"""Fillers before a word that still opens its sentence."""


@dataclasses.dataclass(frozen=True)
class _Said:
    """One sentence with what it says."""

    sentence: Sentence
    mentions: tuple[Mention, ...]
    declined: bool
    doubt: str | None

    @property
    def affirmed(self) -> list[Mention]:
        """Mentions neither denied nor listed."""
        return [mention for mention in self.mentions if mention.weight > Weight.DENIED]


def weigh_prose(text: str) -> Answer:
    """The answer plain sentences give; always one, `other` if they name no emotion."""
    said = [_said(sentence) for sentence in sentences_of(text)]
    said = _without_vertical_list(said)
    said = _after_correction(said)
    mentions = _with_heads(said)
    affirmed = [mention for mention in mentions if mention.weight > Weight.DENIED]
    labels = [mention for mention in affirmed if mention.meaning in EMOTIONS]
    if any(one.declined for one in said):
        labels = [m for m in labels if m.stated or m.weight >= Weight.CONCLUDED]
        if not labels:
            return Answer(None, "refusal", "declines to name an emotion")
    others = [mention for mention in affirmed if mention.meaning == "outside"]
    if labels:
        return _most_committed(labels, others)
    return _without_label(said, mentions, text)


def _said(sentence: Sentence) -> _Said:
    mentions = mentions_in(sentence)
    start = declines(sentence.text)
    if start is not None:
        # Not denied, though `cannot` denies: `cannot tell if happy or sad` says nothing of them.
        reach = _declined_reach(sentence, start)
        mentions = [
            dataclasses.replace(mention, weight=Weight.LISTED)
            if mention.place in reach
            else mention
            for mention in mentions
        ]
    return _Said(sentence, tuple(mentions), start is not None, doubts(sentence.text))


def _declined_reach(sentence: Sentence, start: int) -> range:
    """Places from a refusal up to the `but` after it."""
    first = sentence.text.count(" ", 0, start)
    ends = (
        at
        for at in range(first, len(sentence.tokens))
        if sentence.tokens[at] in TURNS or _begins_anew(sentence.tokens, at)
    )
    return range(first, next(ends, len(sentence.tokens)))


def _begins_anew(tokens: tuple[str, ...], at: int) -> bool:
    """Whether a comma begins a clause with a subject of its own."""
    return tokens[at] == "," and bool(SUBJECTS & set(tokens[at + 1 : at + 2]))


def _without_vertical_list(said: list[_Said]) -> list[_Said]:
    """Lines that each hold one label, four labels or more in a row: the options again."""
    kept: list[_Said] = []
    run: list[_Said] = []
    for one in [*said, None]:
        if one is not None and len(one.affirmed) == 1 and _is_bare(one):
            run.append(one)
            continue
        names = {mention.meaning for line in run for mention in line.affirmed}
        kept += [_listed(line) for line in run] if len(names) >= 4 else run
        run = []
        if one is not None:
            kept.append(one)
    return kept


def _listed(line: _Said) -> _Said:
    mentions = tuple(dataclasses.replace(m, weight=Weight.LISTED) for m in line.mentions)
    return dataclasses.replace(line, mentions=mentions)


def _is_bare(one: _Said) -> bool:
    """Whether a sentence is a label with nothing but fillers."""
    known = {mention.place for mention in one.mentions}
    return all(
        at in known or token in BARE_FILLERS or token.isdigit() or not token[0].isalnum()
        for at, token in enumerate(one.sentence.tokens)
    )


def _after_correction(said: list[_Said]) -> list[_Said]:
    """From the last correction on, if an emotion is affirmed after it."""
    for index in range(len(said) - 1, -1, -1):
        one = said[index]
        ends = [found.end() for found in _CORRECTS.finditer(one.sentence.text)]
        if not ends:
            continue
        place = one.sentence.text.count(" ", 0, ends[-1])
        after = [mention for mention in one.mentions if mention.place > place]
        rest = [dataclasses.replace(one, mentions=tuple(after)), *said[index + 1 :]]
        if any(later.affirmed for later in rest):
            return rest
    return said


def _with_heads(said: Sequence[_Said]) -> list[Mention]:
    """All mentions, those that stand alone in or at the head of the first or last raised."""
    told = [one for one in said if one.mentions]
    mentions: list[Mention] = []
    for one in told:
        first, last = one is said[0], one is said[-1]
        alone = (first or last) and _is_bare(one)
        for mention in one.mentions:
            hedged = mention.weight <= Weight.HEDGED
            if not hedged and (alone or (first and _is_head(one, mention))):
                mention = dataclasses.replace(mention, weight=Weight.ALONE)
            mentions.append(mention)
    return mentions


def _is_head(one: _Said, mention: Mention) -> bool:
    """Whether a mention opens its sentence and what follows is the reason for it."""
    tokens = one.sentence.tokens
    before = tokens[: min(mention.place, _MAX_HEAD + 1)]
    if len(before) > _MAX_HEAD or not all(token in BARE_FILLERS for token in before):
        return False
    after = tokens[mention.place + 1] if mention.place + 1 < len(tokens) else ","
    following = one.sentence.meanings[mention.place + 2 : mention.place + 3]
    return after in HEAD_ENDS and not any(following)


def _most_committed(labels: list[Mention], others: list[Mention]) -> Answer:
    """The one label of the highest weight; several are ambiguous, a weightier outsider wins."""
    weight = max(mention.weight for mention in labels)
    names = sorted({m.meaning for m in labels if m.weight == weight})
    words = ", ".join(sorted({repr(m.word) for m in labels if m.weight == weight}))
    above = max((mention.weight for mention in others), default=Weight.DENIED)
    if above > weight and (weight == Weight.HEDGED or above >= Weight.CONCLUDED):
        word = next(mention.word for mention in others if mention.weight == above)
        return Answer(None, "other", f"commits to {word!r}, none of the five")
    if len(names) > 1:
        return Answer(None, "ambiguous", f"{words} equally {weight.name.lower()}")
    label: Emotion = EMOTIONS[EMOTIONS.index(names[0])]
    return Answer(label, None, f"{words} {weight.name.lower()}")


def _without_label(said: Sequence[_Said], mentions: Sequence[Mention], text: str) -> Answer:
    """What sentences come to that affirm none of the five."""
    denied = {m.meaning for m in mentions if m.weight == Weight.DENIED} & set(EMOTIONS)
    listed = {m.meaning for m in mentions if m.weight == Weight.LISTED} & set(EMOTIONS)
    doubt = next((one.doubt for one in said if one.doubt), None)
    affirmed = [mention for mention in mentions if mention.weight > Weight.DENIED]
    outside = next((mention.word for mention in affirmed if mention.meaning == "outside"), None)
    left = [emotion for emotion in EMOTIONS if emotion not in denied]
    if len(left) == 1 and not affirmed:
        return Answer(left[0], None, "all others denied")
    if outside is not None:
        return Answer(None, "other", f"{outside!r} is none of the five")
    if doubt is not None:
        return Answer(None, "refusal", f"{doubt!r} and no emotion")
    if listed:
        return Answer(None, "ambiguous", "only repeats the options")
    if affirmed:
        return Answer(None, "other", f"{affirmed[0].word!r} decides nothing")
    if denied:
        return Answer(None, "other", f"only denies: {', '.join(sorted(denied))}")
    if any(sees_nobody(one.sentence.text) for one in said):
        return Answer(None, "other", "sees nobody")
    return _by_emoji(text)


def _by_emoji(text: str) -> Answer:
    names = sorted({EMOJI[sign] for sign in text if sign in EMOJI})
    if len(names) > 1:
        return Answer(None, "ambiguous", f"emoji of {', '.join(names)}")
    if names:
        return Answer(EMOTIONS[EMOTIONS.index(names[0])], None, "emoji")
    return Answer(None, "other", "no word of the tables")
