"""Numbers and names as people read them; names come from data and stay one plain, visible line."""

from __future__ import annotations

import math
import unicodedata

from affectsim_data.reports.tables.model import Cell, Column, Mark

__all__ = [
    "DASH",
    "MINUS",
    "cell_text",
    "condition_title",
    "interval_text",
    "mark_text",
    "one_line",
    "shown",
]

DASH = "\N{EN DASH}"
MINUS = "\N{MINUS SIGN}"
_MAX_NAME = 60
_RAISED = str.maketrans("abcdefg", "ᵃᵇᶜᵈᵉᶠᵍ")
_HIDDEN = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})
"""Categories of characters that steer a terminal, turn the direction of text or cannot be seen."""
_CONDITIONS = {"p_mon": "P-Mon", "p_ref": "P-Ref", "p_init": "P-Init", "a_obs": "A-Obs"}


def one_line(text: str) -> str:
    r"""Text from data as one line in which every character can be seen.

    Examples:
        >>> one_line("a\tb\n c"), one_line("\x1b[31mred"), one_line("evil\u202egnp")
        ('a b c', '[U+001B][31mred', 'evil[U+202E]gnp')
    """
    line = " ".join(text.split())
    return "".join(
        f"[U+{ord(letter):04X}]"
        if unicodedata.category(letter) in _HIDDEN or letter in "\u2800\u3164\u115f\u1160\uffa0"
        else letter
        for letter in line
    )


def shown(text: str) -> str:
    """Text from data as tables print it: one line; of a long one the beginning and the end.

    Examples:
        >>> shown("x" * 100)
        'xxxxxxxxxxxxxxxxxxxxxxxxxxxxx…xxxxxxxxxxxxxxxxxxxxxxxxxxxxxx'
    """
    line = one_line(text)
    if len(line) <= _MAX_NAME:
        return line
    half = (_MAX_NAME - 1) // 2
    return f"{line[:half]}…{line[half + 1 - _MAX_NAME :]}"


def condition_title(condition: str) -> str:
    """A condition as the paper writes it; one of the user's as it is."""
    return _CONDITIONS.get(condition, condition)


def cell_text(cell: Cell, column: Column) -> str:
    """What stands in a cell, without its interval and its mark.

    Examples:
        >>> cell_text(Cell(0.1281), Column("a_obs", "A-Obs", "percent", digits=2))
        '12.81'
        >>> cell_text(Cell(0.0006), Column("gain", "Gain", "points", digits=2))
        '+0.06'
        >>> cell_text(Cell(3941), Column("episodes", "Episodes", "count"))
        '3,941'
    """
    if cell.value is None:
        return ""
    if isinstance(cell.value, str):
        return shown(cell.value)
    if cell.is_undefined:
        return DASH
    return _number(float(cell.value), column)


def interval_text(cell: Cell, column: Column) -> str:
    """The interval of a cell, `[10.1, 14.6]`; empty where there is none or it is not shown."""
    bounds = (cell.low, cell.high)
    if column.interval != "shown" or cell.is_undefined or any(map(math.isnan, bounds)):
        return ""
    return f"[{', '.join(_number(bound, column, signed=False) for bound in bounds)}]"


def _number(value: float, column: Column, *, signed: bool = True) -> str:
    kind, digits = column.kind, column.digits
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    if kind == "p":
        return "<0.001" if value < 0.001 else f"{value:.3f}"
    if kind in ("count", "milliseconds"):
        return f"{value:,.0f}".replace("-", MINUS)
    scaled = 100.0 * value if kind in ("percent", "points") else value
    rounded = round(scaled, digits) + 0.0  # no negative zero
    sign = "+" if kind == "points" and signed and rounded > 0 else ""
    return f"{sign}{rounded:.{digits}f}".replace("-", MINUS)


def mark_text(mark: Mark) -> str:
    """A mark as it stands behind a number."""
    return mark.translate(_RAISED)
