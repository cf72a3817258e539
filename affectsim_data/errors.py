"""Errors a caller may want to catch; the rest is ValueError, KeyError or FileNotFoundError."""

from __future__ import annotations

import importlib
from types import ModuleType

__all__ = [
    "CacheError",
    "ForkedContextError",
    "IntegrityError",
    "MissingExtraError",
    "RendererUnavailableError",
    "require_extra",
]


class IntegrityError(ValueError):
    """A release file is not what its manifest says.

    Attributes:
        file: Path of the file inside the release.
        expected: What the manifest promises.
        got: What is there.
    """

    def __init__(self, file: str, *, expected: str, got: str, remedy: str) -> None:
        super().__init__(f"{file}: expected {expected}, got {got}; {remedy}")
        self.file = file
        self.expected = expected
        self.got = got
        self.remedy = remedy

    def __reduce__(self) -> tuple[object, ...]:
        return (_integrity_error, (self.file, self.expected, self.got, self.remedy))


def _integrity_error(file: str, expected: str, got: str, remedy: str) -> IntegrityError:
    return IntegrityError(file, expected=expected, got=got, remedy=remedy)


class CacheError(OSError):
    """The local cache of Hub files cannot take a file; the message says why and what to change."""


class MissingExtraError(ImportError):
    """An optional dependency is not installed; the message names the extra that brings it."""


class RendererUnavailableError(RuntimeError):
    """No headless OpenGL context could be opened; the message says how to mend it."""


class ForkedContextError(RuntimeError):
    """A renderer opened before `fork` was used after it; OpenGL contexts do not survive a fork."""


def require_extra(module: str, *, extra: str) -> ModuleType:
    """The imported module, or an error that names the extra to install.

    Args:
        module: Dotted module name, for example `"av"`.
        extra: Name of the extra in `pyproject.toml` that brings it.

    Raises:
        MissingExtraError: The module is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        message = (
            f"this needs {module!r}, which is not installed: pip install 'affectsim-data[{extra}]'"
        )
        raise MissingExtraError(message) from error
