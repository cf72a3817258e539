"""The licence of a dataset, from the file that states it."""

from __future__ import annotations

import re
from pathlib import Path

__all__ = ["folder_licence"]

_NAMES = ("LICENSE", "LICENCE", "COPYING")
_READ_BYTES = 4096
_KNOWN = (
    (r"CC[ -]BY[ -]NC[ -]SA[ -]4|NonCommercial-ShareAlike 4\.0", "CC-BY-NC-SA-4.0"),
    (r"CC[ -]BY[ -]NC[ -]ND[ -]4|NonCommercial-NoDerivatives 4\.0", "CC-BY-NC-ND-4.0"),
    (r"CC[ -]BY[ -]NC[ -]4|Attribution-NonCommercial 4\.0", "CC-BY-NC-4.0"),
    (r"CC[ -]BY[ -]SA[ -]4|Attribution-ShareAlike 4\.0", "CC-BY-SA-4.0"),
    (r"CC[ -]BY[ -]4|Attribution 4\.0", "CC-BY-4.0"),
    (r"CC0", "CC0-1.0"),
    (r"Apache License\s+Version 2\.0", "Apache-2.0"),
    (r"MIT License|Permission is hereby granted, free of charge, to any person obtaining a copy\s+"
     r"of this software", "MIT"),
    (r"Redistribution and use in source and binary forms", "BSD-3-Clause"),
)  # fmt: skip


def folder_licence(root: Path) -> str:
    """SPDX id of the licence in a folder's `LICENSE` file; empty if there is none.

    A text that is not known gives `LicenseRef-` and the name of the file.
    """
    files = sorted(
        path for path in root.iterdir() if path.is_file() and path.stem.upper() in _NAMES
    )
    for path in files:
        with path.open("rb") as stream:
            text = stream.read(_READ_BYTES).decode("utf-8", errors="replace")
        for pattern, spdx in _KNOWN:
            if re.search(pattern, text, re.IGNORECASE):
                return spdx
        return f"LicenseRef-{re.sub('[^A-Za-z0-9.-]', '-', path.name)}"
    return ""
