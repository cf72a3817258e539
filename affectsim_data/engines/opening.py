"""Engines by name."""

from __future__ import annotations

from typing import Literal, get_args

from affectsim_data.engines.local import LocalEngine
from affectsim_data.engines.protocol import Engine
from affectsim_data.engines.ray_cluster import RayEngine

__all__ = ["ENGINES", "EngineName", "open_engine"]

EngineName = Literal["local", "ray"]
ENGINES: tuple[EngineName, ...] = get_args(EngineName)


def open_engine(
    name: EngineName,
    *,
    jobs: int | None = None,
    address: str | None = None,
    preload: str = "",
) -> Engine:
    """An engine.

    Args:
        name: `local` for processes of this machine, `ray` for a Ray cluster.
        jobs: Items in work at once; one per core if not given.
        address: Of the Ray cluster; none starts one on this machine.
        preload: Module that processes of this machine import before they start.

    Raises:
        ImportError: Ray is asked for and not installed.
        ValueError: There is no such engine, or an address and no Ray to use it.
    """
    if name not in ENGINES:
        raise ValueError(f"engine must be one of {', '.join(ENGINES)}, got {name!r}")
    if name == "ray":
        return RayEngine(address, jobs)
    if address is not None:
        raise ValueError("--ray-address is for --engine ray")
    return LocalEngine(jobs, preload=preload)
