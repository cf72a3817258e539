"""Sentences in which a model declines, is in doubt, or sees nobody."""

from __future__ import annotations

import re

__all__ = ["declines", "doubts", "sees_nobody"]

_TASKS = (
    r"determined?|identify|identified|identifying|tell|inferr?(?:ed|ing)?|assess(?:ed)?|"
    r"recogni[sz]ed?|assist|help|analy[sz](?:e|ed|ing)|answer(?:ed)?|judged?|classify|classified|"
    r"discern(?:ed)?|interpret(?:ed)?|comment|provide|make|say|said|guess|evaluate|detect|read|"
    r"know|comply|speculate|ascertain(?:ed)?|conclude|recognition|do that|offer|attribute"
)
_DECLINES = re.compile(
    r"\b(?:cannot|can not|can ?' ?t|cant|could not|couldn't|unable to|not able to|"
    r"(?:not|isn't|wasn't) possible to|impossible to|"
    r"do(?:es)?(?: not|n't) have the (?:ability|capability)|won't|"
    r"will not|would not|must decline|i decline|refuse to|not allowed to|not permitted to|"
    r"not appropriate to|not going to|not comfortable|refrain from|incapable of)\b"
    r"(?: [\w']+){0,4}? (?:" + _TASKS + r")\b(?! (?:for )?(?:sure|certain))"
)
_NO_SIGHT = re.compile(
    r"\b(?:cannot|can not|can't|unable to|not able to|"
    r"(?:do not|don't|does not) have the ability to)"
    r"(?: [\w']+){0,2}? (?:view|see|watch|access|process|open|play|analyze)(?: [\w']+){0,3}? "
    r"(?:video|image|picture|photo|frame|clip|visual|file|attachment)s?\b"
)
_DECLINES_FLATLY = re.compile(
    r"\b(?:must decline|i decline|have to decline|i refuse|against (?:my|the) (?:policy|policies)|"
    r"no emotions? (?:can|could) be)"
)
_DOUBTS = re.compile(
    r"\b(?:as an? (?:ai|artificial|(?:large )?language)|i'm sorry|i am sorry|sorry|i apologi[sz]e|"
    r"(?:do not|don't) know|no idea|unknown|unclear|undetermined|indeterminate|inconclusive|"
    r"undeterminable|unidentifiable|uncertain|not (?:sure|certain|clear|determinable)|"
    r"(?:can't|cannot) (?:be (?:sure|certain)|say|tell)|"
    r"insufficient (?:information|evidence|detail|context|data)|"
    r"(?:not|isn't|not have|don't have|doesn't have|lack) (?:enough|sufficient) (?:visual )?"
    r"(?:information|evidence|details?|context|data|cues)|no way to tell|"
    r"(?:difficult|hard|tough|impossible) (?:for me )?(?:to|for)|"
    r"too (?:far|dark|blurry|small|blurred|distant|short|low)\b.{0,40}\bto)\b"
)
_NOBODY = re.compile(
    r"\b(?:no|any) (?:visible )?(?:person|people|human|humans|individual|individuals|figure|"
    r"subject|one)\b|\bnobody\b|\bnot see (?:a|any)(?:one|body| person)|"
    r"\bdon't see a person|\bempty (?:room|kitchen|scene|hallway|corridor|bedroom|space|frame)|"
    r"\b(?:room|scene|frame|video) is empty"
)


def declines(sentence: str) -> int | None:
    """Where a sentence says that no answer will be given, as an offset; `None` if it does not."""
    found = _DECLINES.search(sentence) or _NO_SIGHT.search(sentence)
    found = found or _DECLINES_FLATLY.search(sentence)
    return found.start() if found else None


def doubts(sentence: str) -> str | None:
    """The words by which a sentence apologises or doubts, which alone make a refusal."""
    found = _DOUBTS.search(sentence)
    return found[0] if found else None


def sees_nobody(sentence: str) -> bool:
    """Whether a sentence says that there is nobody to be seen."""
    return _NOBODY.search(sentence) is not None
