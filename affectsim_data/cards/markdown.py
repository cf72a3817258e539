"""Markdown of text that comes from data: names, licences and recipes stay text, never markup."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence

__all__ = ["code_block", "code_span", "linked", "per_cent", "plain", "table"]

_MARKUP = re.compile(r"([\\`*_\[\]~|$!@^=])")
"""What begins markup inside a line, here and in the dialects of GitHub and the Hub."""
_CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2066-\u2069\ufeff]")
"""Control characters, those that turn the direction of text, and those nobody sees."""
_URL = re.compile(r"https?://[\w.~%#?=&:/-]*[\w~%#=&/-]", re.ASCII)


def plain(text: str) -> str:
    r"""A line of text that Markdown shows as it is.

    Examples:
        >>> plain("a *b*\n# <i>c</i>")
        'a \\*b\\* # &lt;i&gt;c&lt;/i&gt;'
        >>> plain("# no heading"), plain("1. no list")
        ('\\# no heading', '1\\. no list')
    """
    return _escaped_start(_escaped(_line(text)))


def linked(text: str) -> str:
    r"""A line of text as it is, with its web addresses as links.

    Examples:
        >>> linked("*See* https://example.org/a_b.")
        '\\*See\\* <https://example.org/a_b>.'
    """
    line, pieces, end = _line(text), [], 0
    for match in _URL.finditer(line):
        pieces += [_escaped(line[end : match.start()]), f"<{match[0]}>"]
        end = match.end()
    return _escaped_start("".join([*pieces, _escaped(line[end:])]))


def _line(text: str) -> str:
    return " ".join(_CONTROL.sub(" ", text).split())


def _escaped(line: str) -> str:
    return _MARKUP.sub(r"\\\1", html.escape(line, quote=False))


def _escaped_start(line: str) -> str:
    """Not a heading, not a list."""
    return re.sub(r"^(\d+)([.)])", r"\1\\\2", re.sub(r"^([#+-])", r"\\\1", line))


def code_span(text: str) -> str:
    r"""A line of text as code; may stand in a table.

    Examples:
        >>> code_span("rear_view")
        '`rear_view`'
        >>> code_span("a`b|c")
        '`` a`b\\|c ``'
    """
    line = _line(text).replace("|", r"\|")
    if not line:
        return ""
    fence = "`" * (_longest_run(line) + 1)
    pad = " " if "`" in line else ""
    return f"{fence}{pad}{line}{pad}{fence}"


def code_block(text: str, language: str) -> str:
    """Text as a block of code that nothing in it can end."""
    fence = "`" * max(3, _longest_run(text) + 1)
    return f"{fence}{language}\n{_CONTROL.sub(' ', text).rstrip()}\n{fence}"


def _longest_run(text: str) -> int:
    return max((len(run) for run in re.findall("`+", text)), default=0)


def table(header: Sequence[str], rows: Sequence[Sequence[str | int]], *, left: int = 1) -> str:
    """A table; the thousands of whole numbers are parted.

    Args:
        header: Names of the columns.
        rows: Cells, Markdown already.
        left: How many columns are aligned left; the others, right.
    """
    marks = ["---" if place < left else "---:" for place in range(len(header))]
    cells = [[f"{cell:,}" if isinstance(cell, int) else cell for cell in row] for row in rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in [list(header), marks, *cells])


def per_cent(share: float) -> str:
    """A share in per cent, or a dash where there is none.

    Examples:
        >>> per_cent(0.254), per_cent(float("nan"))
        ('25 %', '-')
    """
    return "-" if share != share else f"{100.0 * share:.0f} %"
