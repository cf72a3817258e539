"""Floor plans: rectangular rooms with a purpose, the openings in their walls, the ways between."""

from affectsim_data.builders.homes.plans.model import (
    CEILING_Y,
    WALL_THICKNESS,
    HomePlan,
    Leaf,
    Opening,
    Rect,
    RoomPlan,
    Side,
    Wall,
    overlaps,
)
from affectsim_data.builders.homes.plans.planning import plan_home

__all__ = [
    "CEILING_Y", "WALL_THICKNESS", "HomePlan", "Leaf", "Opening", "Rect",
    "RoomPlan", "Side", "Wall", "overlaps", "plan_home",
]  # fmt: skip
