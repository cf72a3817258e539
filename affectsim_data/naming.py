"""Objects of the user's by name: `PACKAGE.MODULE:NAME`, from a command line, never from data."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Sequence
from typing import Any

__all__ = ["named_object"]


def named_object(
    path: str, *, what: str, attributes: Sequence[str], protocol: str, **options: Any
) -> Any:
    """A class or function of the user's, called with the options, or an object as it is.

    Args:
        path: `PACKAGE.MODULE:NAME`; the module is imported like any other.
        what: What it should be, for messages: `policy`.
        attributes: What it has to have.
        protocol: Where that is written down, for messages.
        options: For the call.

    Raises:
        ValueError: There is no such thing, or it lacks an attribute.

    Examples:
        >>> named_object("fractions:Fraction", what="number", attributes=["real"], protocol="")
        Fraction(0, 1)
    """
    name, colon, attribute = path.partition(":")
    if not colon or not attribute:
        raise ValueError(f"module: must be module:PACKAGE.MODULE:NAME, got {path!r}")
    try:
        found = getattr(importlib.import_module(name), attribute)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise  # the module is there; something it needs is not
        raise ValueError(
            f"module: there is no module {error.name!r}; is the folder it is in on PYTHONPATH?"
        ) from error
    except AttributeError as error:
        raise ValueError(f"module: {name} has no {attribute!r}") from error
    made = found(**options) if isinstance(found, type) or inspect.isfunction(found) else found
    if lacking := [one for one in attributes if not hasattr(made, one)]:
        raise ValueError(
            f"module: {path} is no {what}, it lacks {', '.join(lacking)}; see {protocol}"
        )
    return made
