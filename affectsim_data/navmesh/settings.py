"""What a navmesh is built for, and how finely."""

from __future__ import annotations

import dataclasses
import math

__all__ = ["Settings"]


@dataclasses.dataclass(frozen=True)
class Settings:
    """What a navmesh was built for and how finely."""

    agent_radius: float = 0.3
    """Metres."""
    agent_height: float = 1.5
    """Metres."""
    max_climb: float = 0.2
    """Highest step, metres."""
    max_slope_deg: float = 45.0
    """Steepest floor."""
    cell_size: float = 0.05
    """Side of a grid column, metres."""
    cell_height: float = 0.05
    """Height of a grid level, metres."""

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            least = 0.0 if field.name in ("agent_radius", "max_climb") else 1e-3
            if not (math.isfinite(value) and value >= least):
                raise ValueError(f"{field.name} must be at least {least:g}, got {value}")
        if self.max_slope_deg >= 90.0:
            raise ValueError(f"max_slope_deg must be below 90, got {self.max_slope_deg}")
