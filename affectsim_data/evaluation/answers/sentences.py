"""Sentences of an answer as words and signs, without set phrases that mean something else."""

from __future__ import annotations

import dataclasses
import re

from affectsim_data.evaluation.answers.words import Meaning, meaning_of

__all__ = ["Sentence", "sentences_of"]

_TOKEN = re.compile(r"\d+(?:\.\d+)?|[^\W\d_]+(?:'[^\W\d_]+)?|[^\w\s]|\n")
_ENDS = frozenset(".!?;\n")
_HIDDEN = re.compile(
    r"\b(?:(?:be|am|are|i'm|i'd be|we're|very|more than) (?:happy|glad|pleased) to\b|"
    r"(?:happy|glad) to (?:help|assist|describe|discuss|answer|provide|look)|"
    r"(?:i'm|i am|we're) (?:afraid|sorry)\b|sad(?:ly)? to say|^sadly ?,|"
    r"neutral(?:ly)? ?(?:-? ?(?:colou?r(?:ed)?s?|tones?|toned|background|wall|walls|paint|lighting|"
    r"light|setting|environment|room|clothing|clothes|shades?|palette|backdrop)\b)|"
    r"happy (?:birthday|hour|holidays)|joy ?sticks?|feel free)",
    re.MULTILINE,
)
_NO_EMOTION = re.compile(
    r"\b(?:no|without|without any|lack of|absence of|lacks|lacking|devoid of|free of|"
    r"does not (?:show|express|display|convey)|doesn't (?:show|express|display|convey)|not any)"
    r"(?: any| a| strong| particular| specific| special| pronounced| intense| overt){0,3}"
    r" (?:emotions?|emotional (?:expression|content|display|charge))\b"
    r"(?! (?:other|except|but|can|could|is|was|are)\b)"
)


@dataclasses.dataclass(frozen=True)
class Sentence:
    """One sentence or line."""

    tokens: tuple[str, ...]
    """Words and signs in lower case, without the sign that ends it."""
    meanings: tuple[Meaning | None, ...]
    """What each token stands for."""
    asks: bool
    """Whether it ends in a question mark."""
    text: str
    """The tokens with a space between."""


def sentences_of(text: str) -> list[Sentence]:
    """Sentences of plain text, those without words left out."""
    lowered = _HIDDEN.sub(" ", text.casefold())
    # `no emotion` is a way to say neutral and must not negate what follows.
    lowered = _NO_EMOTION.sub(" emotionless ", lowered)
    sentences: list[Sentence] = []
    tokens: list[str] = []
    for found in _TOKEN.finditer(lowered):
        token = found[0]
        if token not in _ENDS:
            tokens.append(token)
            continue
        _close(sentences, tokens, asks=token == "?")
        tokens = []
    _close(sentences, tokens, asks=False)
    return sentences


def _close(sentences: list[Sentence], tokens: list[str], *, asks: bool) -> None:
    if any(token[0].isalnum() for token in tokens):
        meanings = tuple(
            meaning_of(token) or meaning_of(token[:-2])
            if token.endswith("'s")
            else meaning_of(token)
            for token in tokens
        )
        sentences.append(Sentence(tuple(tokens), meanings, asks, " ".join(tokens)))
