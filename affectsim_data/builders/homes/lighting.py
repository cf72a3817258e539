"""Light of homes: see `affectsim_data.builders.lighting`."""

from __future__ import annotations

from affectsim_data.builders.lighting import Lamp, WindowLight

__all__ = ["Lamp", "WindowLight"]
