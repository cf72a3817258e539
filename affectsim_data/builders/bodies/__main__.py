"""Bakes the shipped avatars from Anny: `python -m affectsim_data.builders.bodies --out FOLDER`.

A tool for maintainers, needs the `build` extra; everybody else reads the GLBs it made.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from affectsim_data.builders.bodies.baking import bake_avatars


def main(arguments: Sequence[str] | None = None) -> None:
    """Bakes all avatars, or those named, into a folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder for the GLBs")
    parser.add_argument("avatars", nargs="*", help="avatars to bake; all by default")
    options: Any = parser.parse_args(arguments)
    bake_avatars(options.out, names=tuple(options.avatars))


if __name__ == "__main__":
    main()
