"""The built-in release `mini`: built on first use, kept in the user's cache."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

from filelock import FileLock

from affectsim_data.content import content_path
from affectsim_data.releases.manifest import MANIFEST_NAME

__all__ = ["BUILTIN_RELEASES", "builtin_release_path", "cache_folder"]

BUILTIN_RELEASES = ("mini",)


def cache_folder() -> Path:
    """Where built releases are kept: `AFFECTSIM_CACHE`, else `affectsim` in the XDG cache."""
    default = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache") / "affectsim"
    return Path(os.environ.get("AFFECTSIM_CACHE") or default).expanduser()


def builtin_release_path(name: str) -> Path:
    """Folder of a built-in release, built now unless this very version built it before.

    Several processes may ask at once: one builds, the others wait for it.

    Raises:
        RuntimeError: The build failed; its own message stands above.
    """
    folder = cache_folder() / "releases" / f"{name}-{_fingerprint()}"
    if not (folder / MANIFEST_NAME).is_file():
        folder.parent.mkdir(parents=True, exist_ok=True)
        with FileLock(folder.parent / f".{folder.name}.lock"):
            if not (folder / MANIFEST_NAME).is_file():
                _build(name, folder)
    return folder


def _build(name: str, folder: Path) -> None:
    """Runs `affectsim build` in a process of its own.

    Builders stand above releases, and the build starts workers, which a user's script without a
    main guard could not.
    """
    command = [sys.executable, "-m", "affectsim_data", "build", name, "--out", str(folder)]
    package_parent = str(Path(__file__).resolve().parents[2])
    path = os.pathsep.join(filter(None, [package_parent, os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        command, env={**os.environ, "PYTHONPATH": path}, stdout=subprocess.DEVNULL, check=False
    )
    if done.returncode:
        raise RuntimeError(
            f"building the release {name!r} failed with exit status {done.returncode}; "
            f"run `affectsim build {name} --out FOLDER` to see why"
        )


def _fingerprint() -> str:
    """Of all the code and data a built-in release depends on."""
    package, recipes = Path(__file__).parents[1], content_path("builders")
    digest = hashlib.sha256()
    for root, pattern in ((package, "*.py"), (recipes, "*")):
        for path in sorted(path for path in root.rglob(pattern) if path.is_file()):
            digest.update(path.relative_to(root).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:12]
