"""Which code this is: results are the same only where the same code makes them."""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path

import affectsim_data
from affectsim_data.content import content_path

__all__ = ["code_fingerprint"]


@functools.cache
def code_fingerprint() -> str:
    """Of the package's code and of what lies in `builders/`: recipes, homes, bodies."""
    digest = hashlib.sha256()
    package = Path(affectsim_data.__file__).parent
    for root, pattern in ((package, "*.py"), (content_path("builders"), "*")):
        for path in sorted(path for path in root.rglob(pattern) if path.is_file()):
            digest.update(path.relative_to(root).as_posix().encode() + b"\0")
            digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()
