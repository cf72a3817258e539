"""How large the local cache of Hub files may become."""

from __future__ import annotations

import os
import re

__all__ = ["LIMIT_VARIABLE", "cache_limit", "parse_bytes"]

LIMIT_VARIABLE = "AFFECTSIM_CACHE_LIMIT"
_DEFAULT_BYTES = 32 * 10**9
_SIZE = re.compile(r"(\d+(?:\.\d+)?)\s*(?:([kmgt])(i?))?b?", re.IGNORECASE | re.ASCII)


def parse_bytes(text: str, *, name: str) -> int:
    """A number of bytes from `"500MB"`, `"20 GB"`, `"1TiB"` or `"1000000"`.

    Args:
        text: A number and its unit; k, M, G, T are powers of 1000, Ki, Mi, Gi, Ti of 1024.
        name: What errors call it.

    Raises:
        ValueError: It is none, or less than a byte.

    Examples:
        >>> parse_bytes("1.5 kB", name="limit"), parse_bytes("2KiB", name="limit")
        (1500, 2048)
    """
    match = _SIZE.fullmatch(text.strip())
    if match:
        number, prefix, binary = match.groups()
        power = " kmgt".index((prefix or " ").lower())
        size = int(float(number) * (1024 if binary else 1000) ** power)
        if size > 0:
            return size
    raise ValueError(
        f"{name} must be a number of bytes above 0 such as 500MB, 20GB or 1TiB, got {text!r}"
    )


def cache_limit() -> int:
    """Bytes the cache may hold: `AFFECTSIM_CACHE_LIMIT`, else 32 GB.

    Raises:
        ValueError: The variable holds no number of bytes.
    """
    text = os.environ.get(LIMIT_VARIABLE)
    return parse_bytes(text, name=LIMIT_VARIABLE) if text else _DEFAULT_BYTES
