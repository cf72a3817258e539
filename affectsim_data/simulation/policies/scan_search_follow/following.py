"""After the handoff: the person is kept in the middle of the image, in as few turns as may be."""

from __future__ import annotations

import math

from affectsim_data.simulation.actions import Action
from affectsim_data.simulation.policies.scan_search_follow.senses import Senses

__all__ = ["follow"]

_AIM = math.radians(11.0)
"""A still camera is good to recognize from: a person may be that far beside the middle."""
_LOST_S = 2.0


def follow(senses: Senses) -> Action:
    """The next action while the clip is collected; `stop` then waits."""
    place = senses.track.place_xz
    if place is None:
        return "turn_left"
    off = senses.bearing_to(place)
    if senses.unseen_s > _LOST_S and abs(off) <= 2.0 * _AIM:
        # Gone from where they were: they left the image on one side or the other, so look round.
        return "turn_left"
    if abs(off) <= _AIM:
        return "stop"
    return "turn_left" if off > 0.0 else "turn_right"
