"""Rooms furnished by their purpose."""

from __future__ import annotations

from collections.abc import Callable

from affectsim_data.builders.homes.rooms.bath import furnish_bath
from affectsim_data.builders.homes.rooms.bedroom import furnish_bedroom
from affectsim_data.builders.homes.rooms.dining import furnish_dining
from affectsim_data.builders.homes.rooms.hall import furnish_hall
from affectsim_data.builders.homes.rooms.job import Job
from affectsim_data.builders.homes.rooms.kitchen import furnish_kitchen
from affectsim_data.builders.homes.rooms.living import furnish_living
from affectsim_data.builders.homes.rooms.study import furnish_study

__all__ = ["ESSENTIALS", "FURNISHERS", "Job"]

FURNISHERS: dict[str, Callable[[Job], None]] = {
    "living": furnish_living,
    "kitchen": furnish_kitchen,
    "dining": furnish_dining,
    "bedroom": furnish_bedroom,
    "bath": furnish_bath,
    "study": furnish_study,
    "hall": furnish_hall,
}
"""What furnishes a room of a purpose."""
ESSENTIALS: dict[str, tuple[str, ...]] = {
    "living": ("sofa", "table"),
    "kitchen": ("counter", "fridge"),
    "dining": ("table", "chair"),
    "bedroom": ("bed", "wardrobe"),
    "bath": ("toilet", "washbasin"),
    "study": ("desk", "chair"),
}
"""Categories that a room of a purpose should not be without."""
