"""Brings raw model text to the part that answers: no thinking, no turns, no dressing."""

from __future__ import annotations

import re
import unicodedata

__all__ = ["answering_part", "is_blank", "plain"]

_SIGNS = str.maketrans(
    {
        **dict.fromkeys("\u2018\u2019\u201b\u2032\u0060\u00b4", "'"),
        **dict.fromkeys("\u201c\u201d\u201e\u201f\u2033\u00ab\u00bb", '"'),
        **dict.fromkeys("\u2013\u2014\u2015\u2212", " - "),
        **dict.fromkeys("→⇒➜", ":"),
        # Soft hyphen, marks of zero width, direction and variation: seen by nobody.
        **dict.fromkeys("\u00ad\u200b\u200c\u200d\u200e\u200f\u2060\ufeff\ufe0e\ufe0f", ""),
    }
)
_THINKING = re.compile(
    r"[<\[◁]\s?(/?)\s?(?:seed:)?(?:think|thinking|thoughts?|reasoning|analysis|reflection|"
    r"scratchpad|cot)\s?[>\]▷]|<\|(begin|end)_of_thought\|>",
    re.IGNORECASE,
)
_FINAL_CHANNEL = re.compile(r"<\|channel\|>\s?final\s?(?:<\|message\|>)?", re.IGNORECASE)
_BARE_FINAL_CHANNEL = re.compile(r"assistant\s?final")
_BARE_ANALYSIS = re.compile(r"\s*analysis(?=[A-Z])")
_SPECIAL = re.compile(
    r"<\|[^|<>]{1,40}\|>|</?s>|<(?:end_of_turn|start_of_turn|eos|bos|pad|image|video|unk)>|"
    r"\[/?INST\]",
    re.IGNORECASE,
)
_ASSISTANT = re.compile(r"(?:^|[\s>])(?:assistant\s?:|assistant\n|model\n)", re.IGNORECASE)
_NEXT_TURN = re.compile(r"^(?:question|user|human|q)\s?:", re.IGNORECASE | re.MULTILINE)
_LATEX = re.compile(r"\\(?:textbf|textit|text|mathrm|mathbf|mathit|mbox|emph|displaystyle)\s?")
_FENCE = re.compile(r"'''(?:json|python|text|yaml|xml)?")
_LINE_DRESS = re.compile(r"^[#>•·▪*+\s]{1,12}", re.MULTILINE)
_BLANK_CATEGORIES = ("P", "Z", "C", "Sk", "Sm", "Sc")


def answering_part(text: str) -> str:
    """Text after thinking, of the model's own turn, with even white space and plain signs.

    Case, braces and quotes are kept: letters and JSON are still to be read. Empty if a thinking
    block was begun and never left.
    """
    text = unicodedata.normalize("NFKC", text).translate(_SIGNS)
    text = _after_channels(_without_thinking(text))
    text = _own_turn(_SPECIAL.sub("\n", text))
    return _LATEX.sub("", _FENCE.sub("\n", text)).strip()


def plain(text: str) -> str:
    """Without Markdown's stars, bars under words and marks at the beginning of lines."""
    text = text.replace("*", "").replace("_", " ").replace("~~", "")
    return _even(_LINE_DRESS.sub("", text))


def is_blank(text: str) -> bool:
    """Whether nothing but space and punctuation is left."""
    return all(unicodedata.category(sign).startswith(_BLANK_CATEGORIES) for sign in text)


def _even(text: str) -> str:
    """One space between words, one line end between lines: no pattern meets a long run."""
    lines = (" ".join(line.split()) for line in text.splitlines())
    return "\n".join(line for line in lines if line)


def _without_thinking(text: str) -> str:
    """What stands outside of thinking blocks; an end without a beginning ends all before it."""
    kept: list[str] = []
    position, thinking = 0, False
    for tag in _THINKING.finditer(text):
        closes = tag[1] == "/" or tag[2] == "end"
        if closes and not thinking:
            kept.clear()
        elif not closes and not thinking:
            kept.append(text[position : tag.start()])
        thinking = not closes
        position = tag.end()
    if not thinking:
        kept.append(text[position:])
    return _even("\n".join(kept))


def _after_channels(text: str) -> str:
    """The final channel of models that speak in channels; nothing if they never came to it."""
    if "<|channel|>" in text:
        finals = list(_FINAL_CHANNEL.finditer(text))
        return text[finals[-1].end() :] if finals else ""
    if _BARE_ANALYSIS.match(text):
        finals = list(_BARE_FINAL_CHANNEL.finditer(text))
        return text[finals[-1].end() :] if finals else ""
    return text


def _own_turn(text: str) -> str:
    """From the last sign of the assistant's turn up to a next question it made up itself."""
    text = _even(text)
    turns = list(_ASSISTANT.finditer(text))
    if turns and not is_blank(text[turns[-1].end() :]):
        text = text[turns[-1].end() :].strip()
    return text[: _next_turn(text)]


def _next_turn(text: str) -> int:
    """Where a question follows that nobody asked; a prompt repeated at the beginning is none."""
    first: str | None = None
    for turn in _NEXT_TURN.finditer(text):
        if turn.start() == 0:
            first = turn[0].casefold()
        elif first is None or turn[0].casefold() == first:
            return turn.start()
    return len(text)
