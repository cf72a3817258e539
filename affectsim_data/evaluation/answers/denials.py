"""Which of the emotions a sentence names it denies."""

from __future__ import annotations

from affectsim_data.evaluation.answers.cues import (
    AND,
    BREAKS,
    COPULAS,
    DENIALS_AFTER,
    FINITE,
    NO,
    NOT,
    OR,
    PARTICIPLES,
    PARTNERS,
    RULES_OUT,
    UNSURE,
)
from affectsim_data.evaluation.answers.sentences import Sentence

__all__ = ["REACH", "clause_of", "denied_after", "denied_before"]

REACH = 6
"""Tokens after a word in which it can still be denied or weighed."""


def denied_before(sentence: Sentence, groups: list[list[int]], inside: set[int]) -> set[int]:
    """Places in reach of a `not`, `no`, `than` and their kin before them."""
    tokens = sentence.tokens
    in_list = {at for group in groups if _has_conjunction(tokens, group) for at in _span(group)}
    denied: set[int] = set()
    kind, since, so_much = "", -1, False
    for at, token in enumerate(tokens):
        started = _denial(tokens, at)
        if started:
            if not (started == "than" and kind == "less"):
                kind, since, so_much = started, at, False
            else:
                kind = ""
        elif kind:
            if token == "much" and tokens[at - 1] == "so":
                so_much = True
            if _ends_denial(tokens, at, kind, since, inside, in_list, so_much=so_much):
                kind = ""
        if kind and sentence.meanings[at] is not None:
            denied.add(at)
    return denied


def _span(group: list[int]) -> range:
    return range(group[0], group[-1] + 1)


def _has_conjunction(tokens: tuple[str, ...], group: list[int]) -> bool:
    return bool((AND | OR) & set(tokens[group[0] : group[-1]]))


def _denial(tokens: tuple[str, ...], at: int) -> str:
    """The kind of denial a token begins, or nothing."""
    token = tokens[at]
    following = tokens[at + 1 : at + 4]
    after = following[0] if following else ""
    if token in NOT or token.endswith("n't"):
        if after in {"only", "just", "merely", "simply", "sure", "certain", "so", "be", "to"}:
            return "not" if after in {"so", "be", "to"} and not _is_unsure(following) else ""
        return "" if _is_unsure(following) else "not"
    if token in NO:
        if after in {"doubt", "question", ",", "wonder"} or "doubt" in following[:2]:
            return ""
        return "no" if token != "free" or after == "of" else ""
    if token in RULES_OUT and (after == "out" or token.startswith("exclud")):
        return "no"
    if token == "less" and after != "likely":
        return "less"
    if token == "than":
        return "" if tokens[at - 1] in {"other", "more"} and at else "than"
    return "than" if PARTNERS.get(token) == after != "" else ""


def _is_unsure(following: tuple[str, ...]) -> bool:
    """`can't be certain`, `not sure`: doubt, which denies nothing."""
    return bool(UNSURE & set(following[:2]))


def _ends_denial(
    tokens: tuple[str, ...],
    at: int,
    kind: str,
    since: int,
    inside: set[int],
    in_list: set[int],
    *,
    so_much: bool,
) -> bool:
    """Whether a denial begun at `since` no longer reaches what follows this token."""
    token = tokens[at]
    if token == "but" and tokens[at - 1] == "anything":
        return False
    if token == "so" and tokens[at + 1 : at + 2] == ("much",):
        return False
    if token == "as":
        return so_much
    if token == "-":
        return at > since + 1
    if token in BREAKS:
        return True
    if token == ",":
        return at not in in_list and not (at in inside and kind == "no")
    if token in AND:
        return at not in inside
    if token in FINITE and at - since > 2:
        return tokens[at - 1] not in {"to", "that", "which", "or"}
    return token in PARTICIPLES and kind == "not" and at - since > 2


def denied_after(sentence: Sentence, groups: list[list[int]]) -> set[int]:
    """Places denied by what follows them: `anger is unlikely`, `fear can be ruled out`."""
    denied: set[int] = set()
    tokens = sentence.tokens
    for group in groups:
        reach = tokens[group[-1] + 1 : group[-1] + 1 + REACH]
        # `... can be ruled out, and so can fear`.
        if denied and group[0] > 1 and tokens[group[0] - 2] == "so":
            denied.update(group)
            continue
        if any(sentence.meanings[group[-1] + 1 : group[-1] + 1 + REACH]):
            continue
        if reach and reach[0] in COPULAS and DENIALS_AFTER & set(clause_of(reach)):
            denied.update(group)
    return denied


def clause_of(tokens: tuple[str, ...]) -> tuple[str, ...]:
    """Tokens up to the next comma or conjunction."""
    ends = (at for at, token in enumerate(tokens) if token in BREAKS or token in {",", "and"})
    return tokens[: next(ends, len(tokens))]
