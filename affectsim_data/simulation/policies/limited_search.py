"""`limited_search`: exploring by a fixed rule, without a scan or a map; what search is compared to.

It stands for what the paper's baseline searches with, a frozen navigation policy that follows one
instruction, whoever is where, and proposes places to stop at: here "go ahead as far as you can, or
3 m; stop; then turn left". Only at these stops does it look for a person, without turning round,
and where it sees one it hands off as it stands. It sees people as `scan_search_follow` does, so
that the two differ in how they search and where they stand, not in what they would notice.
"""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from affectsim_data.cameras import Camera
from affectsim_data.simulation.actions import Action
from affectsim_data.simulation.policies.driving import bearing, turn_towards
from affectsim_data.simulation.policies.protocol import Decision
from affectsim_data.simulation.policies.scan_search_follow.seeing import PersonFinder
from affectsim_data.simulation.policies.scan_search_follow.tracking import PersonTrack
from affectsim_data.simulation.running import Observation

__all__ = ["LimitedSearch", "free_ahead"]

_Course = Generator[Decision, Observation, Observation]
"""Decisions out, what is seen after each in, and at the end what was seen last."""
_HALF_WIDTH_M = 0.35
"""Of what the robot fills as it goes ahead: its radius and a little."""
_FLOOR_M, _TOP_M = 0.15, 1.5
"""Heights between which things are in its way."""
_BLOCKED_M = 0.9
"""Nearer things are turned away from; with less, low furniture has left the image before."""
_LEG = 12
"""Moves after which it stops although it could go on: 3 m."""
_LOOKS: tuple[Action, ...] = ("turn_left", "turn_right", "turn_left")
"""Between four looks; the robot cannot wait, so it looks again from beside."""
_TURNS = 6
"""With the last look 105 degrees, which does not divide a whole turn: its ways differ."""
_MORE_TURNS = 17
"""As long as it is blocked; then it has turned once round and goes on, whatever is there."""


class LimitedSearch:
    """Goes ahead, stops, looks, hands off where it sees a person, and turns left where not."""

    name = "limited_search"

    def reset(self, camera: Camera, *, seed: int) -> None:
        """Forgets whom it saw and where it was going."""
        self._track = PersonTrack()
        self._course = self._search()
        next(self._course)

    def act(self, observation: Observation) -> Decision:
        """The next step of the search, or what keeps the person in view after it."""
        return self._course.send(observation)

    def _search(self) -> _Course:
        """The whole episode: decisions out, what is seen after each in."""
        seen = yield Decision("stop")  # before the first observation; given to nobody
        while True:
            seen = yield from _go_ahead(seen)
            found, seen = yield from self._look(seen)
            if found:
                break
            seen = yield from _turn_away(seen)
        seen = yield Decision("hand_off")
        while True:
            self._notice(seen)
            place = self._track.place_xz
            here = seen.position[[0, 2]]
            turn = None if place is None else turn_towards(seen.yaw, bearing(here, place))
            seen = yield Decision(turn or "stop")

    def _look(
        self, seen: Observation
    ) -> Generator[Decision, Observation, tuple[bool, Observation]]:
        """Four looks from one spot, and whether they show a person; a call of the planner."""
        self._finder, self._track = PersonFinder(), PersonTrack()
        self._notice(seen)
        for number, turn in enumerate(_LOOKS):
            seen = yield Decision(turn, planner_calls=int(number == 0))
            self._notice(seen)
        return self._track.is_stable, seen

    def _notice(self, seen: Observation) -> None:
        self._track.update(self._finder.update(seen), seen)


def _go_ahead(seen: Observation) -> _Course:
    """A leg: ahead until something is in the way, or for 3 m."""
    for _ in range(_LEG):
        if _is_blocked(seen):
            break
        seen = yield Decision("move_forward")
    return seen


def _turn_away(seen: Observation) -> _Course:
    """To the left, and farther as long as something is in the way."""
    for number in range(_TURNS + _MORE_TURNS):
        if number >= _TURNS and not _is_blocked(seen):
            return seen
        seen = yield Decision("turn_left")
    return (yield Decision("move_forward"))


def _is_blocked(seen: Observation) -> bool:
    return seen.clipped or free_ahead(seen) <= _BLOCKED_M


def free_ahead(observation: Observation) -> float:
    """Way ahead to the first thing the robot would hit, as far as the image shows it, metres.

    From the camera; `inf` if nothing is in the way. What is lower than the image reaches is missed.
    """
    camera, depth = observation.camera, observation.depth
    rows, columns = (np.arange(count) + 0.5 for count in depth.shape)
    focal = camera.intrinsics[0, 0]
    with np.errstate(invalid="ignore"):  # the middle of an odd image, where nothing was hit
        across = (columns - camera.width / 2.0) / focal * depth
        down = ((rows - camera.height / 2.0) / focal)[:, None] * depth
    height = observation.camera_height_m - down
    in_way = (np.abs(across) <= _HALF_WIDTH_M) & (height >= _FLOOR_M) & (height <= _TOP_M)
    return float(depth[in_way].min(initial=np.inf))
