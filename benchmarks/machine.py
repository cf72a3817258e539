"""What a result was measured on: every number is published with it."""

from __future__ import annotations

import os
import platform
from pathlib import Path

import affectsim_data

__all__ = ["describe_machine"]


def describe_machine() -> dict[str, str | int]:
    """CPU model, cores, GL renderer and versions."""
    from affectsim_data.render.device import describe_device

    device = describe_device()
    return {
        "cpu": _cpu_model(),
        "cores": len(os.sched_getaffinity(0)),
        "gl_renderer": device.renderer,
        "gl_version": device.version,
        "python": platform.python_version(),
        "affectsim_data": affectsim_data.__version__,
    }


def _cpu_model() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()
