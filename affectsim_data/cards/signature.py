"""The last line of a generated card: tells it from one that somebody wrote or edited."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import re

__all__ = ["Signature", "read_signature", "signed"]

_SIGNATURE = re.compile(r"\n<!-- written by affectsim card (\{.*\}) -->\n\Z")


@dataclasses.dataclass(frozen=True)
class Signature:
    """What the writer of a card was told, so that the card can be written anew."""

    contact: str | None = None
    """Whom to tell of misuse."""
    published: str | None = None
    """Day of publication, `YYYY-MM-DD`."""


def signed(text: str, signature: Signature) -> str:
    """A card with its last line."""
    entries = {**dataclasses.asdict(signature), "sha256": _sha256(text)}
    # Nothing in it may end the comment.
    line = json.dumps(entries).replace("-", "\\u002d").replace(">", "\\u003e")
    return f"{text}\n<!-- written by affectsim card {line} -->\n"


def read_signature(text: str) -> Signature | None:
    """The signature of a generated card; `None` if somebody wrote or edited it."""
    match = _SIGNATURE.search(text)
    if match is None:
        return None
    try:
        entries = json.loads(match[1])
    except ValueError:
        return None
    if entries.pop("sha256", "") != _sha256(text[: match.start()]):
        return None
    names = {field.name for field in dataclasses.fields(Signature)}
    return Signature(**entries) if entries.keys() == names else None


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
