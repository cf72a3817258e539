"""What places let people and robots do: stand, see, sit, knock, walk; for many places at once."""

from affectsim_data.affordances.doors import DoorAccess, knockable_doors
from affectsim_data.affordances.rooms import line_of_sight, rooms_of, same_room
from affectsim_data.affordances.runs import Runs, curved_runs, straight_runs
from affectsim_data.affordances.seats import SeatAccess, reachable_seats
from affectsim_data.affordances.standing import clearance, fits, footprint_fits

__all__ = [
    "DoorAccess",
    "Runs",
    "SeatAccess",
    "clearance",
    "curved_runs",
    "fits",
    "footprint_fits",
    "knockable_doors",
    "line_of_sight",
    "reachable_seats",
    "rooms_of",
    "same_room",
    "straight_runs",
]
