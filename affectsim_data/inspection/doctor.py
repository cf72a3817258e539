"""Says what renders here, what is missing and how to mend it."""

from __future__ import annotations

import importlib.util
import platform
import sys
from importlib import metadata

import affectsim_data
from affectsim_data.errors import RendererUnavailableError

__all__ = ["examine"]

_EXTRAS = {"video": "av", "plots": "matplotlib", "ktx2": "opengl_basisu", "build": "anny"}


def examine(*, device: int | None = None) -> tuple[list[str], bool]:
    """Lines of a report, and whether everything that is required works."""
    packages = ("torch", "numpy", "pyarrow", "moderngl", "rerun-sdk", "huggingface-hub")
    lines = [
        f"affectsim-data {affectsim_data.__version__}, Python {platform.python_version()}, "
        f"{platform.system()} {platform.machine()}",
        *(f"  {package:16} {_version(package)}" for package in packages),
    ]
    rays = "Embree" if importlib.util.find_spec("embreex") else "trimesh (slow: no embreex wheel)"
    lines.append(f"  {'ray casting':16} {rays}")
    for extra, module in _EXTRAS.items():
        there = importlib.util.find_spec(module) is not None
        state = "installed" if there else f"not installed: pip install 'affectsim-data[{extra}]'"
        lines.append(f"  {'extra ' + extra:16} {state}")
    gl_lines, works = _examine_gl(device)
    return lines + gl_lines, works


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return f"missing: {sys.executable} -m pip install {package}"


def _examine_gl(device: int | None) -> tuple[list[str], bool]:
    from affectsim_data.render.device import describe_device, draw_triangle

    try:
        info = describe_device(device)
        image = draw_triangle(device)
    except RendererUnavailableError as error:
        return ["rendering: NOT WORKING", f"  {error}"], False
    kind = "software, on the CPU" if info.software else "hardware"
    lines = [
        "rendering",
        f"  {'device':16} {info.renderer} ({kind})",
        f"  {'vendor':16} {info.vendor}",
        f"  {'OpenGL':16} {info.version}",
        f"  {'EGL':16} {info.egl_version}, {info.egl_vendor}; device {info.device} of "
        f"{info.num_devices}",
        f"  {'largest texture':16} {info.max_texture_size} pixels",
    ]
    drawn = image.reshape(-1, image.shape[-1]).max(axis=0).max() > 0
    lines.append(
        f"  {'test triangle':16} {'drawn' if drawn else 'BLANK: the driver draws nothing'}"
    )
    if info.software:
        lines.append("  no GPU driver in use; on a machine with one, see docs/performance.md")
    return lines, bool(drawn)
