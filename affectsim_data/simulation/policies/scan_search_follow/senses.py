"""What the robot knows in an episode: where it is, its map, and the person it has seen."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from affectsim_data.poses import FloatArray
from affectsim_data.simulation.policies.driving import bearing
from affectsim_data.simulation.policies.scan_search_follow.courses import PersonCourse
from affectsim_data.simulation.policies.scan_search_follow.living import LifeSigns
from affectsim_data.simulation.policies.scan_search_follow.mapping import OccupancyMap
from affectsim_data.simulation.policies.scan_search_follow.seeing import PersonFinder, Sighting
from affectsim_data.simulation.policies.scan_search_follow.tracking import (
    PersonTrack,
    turned_from,
)
from affectsim_data.simulation.running import Observation

__all__ = ["Senses"]

_STRAY_M, _STRAY_M_PER_S, _FARTHEST_M = 0.9, 0.3, 2.0
"""A person who is believed stays about where they were seen: this far from it, this much farther
for every second they were not seen, and never farther. What is seen beyond is another thing."""
_DEAD_M = 0.5
"""So near to a thing that never moved nobody is seen, unless they move."""
_NEARER = 0.7
_PERSON_STAYS_S = 4.0
"""Ways keep so long from where a person was seen last."""
_OTHER_M, _OTHERS_STAY_S = 0.6, 15.0
_PARTNER_M, _PARTNER_LOOKS, _SURELY = 1.8, 3, 0.85
"""Somebody seen that often that near to the person, so surely, belongs to them."""
_CLEARLY = math.radians(3.0)
"""Of two people the one nearer by so much to where the robot was turned at first is meant."""
_CENTRAL = math.radians(20.0)
_LIKELY, _NEAR_M = 0.75, 0.5
"""Confidence of a look from which it may be of the person who is believed, unless it is this near
to where they were seen before."""
_SURE, _SURE_ALIVE, _ALIVE_LOOKS = 0.75, 0.55, 2
"""Mean confidence of the last looks from which a person is believed."""


@dataclasses.dataclass(frozen=True, eq=False)
class _Thing:
    """Something that looked like a person and never moved."""

    place_xz: FloatArray
    distance_m: float
    """From where it was watched: from much nearer it may be seen to live after all."""

    def hides(self, sighting: Sighting) -> bool:
        """Whether a sighting is of this thing."""
        near = math.dist(sighting.place_xz, self.place_xz) <= _DEAD_M
        return near and sighting.distance_m > _NEARER * self.distance_m


class Senses:
    """Everything learned from the observations of one episode, and nothing else."""

    def __init__(self) -> None:
        self.plan = OccupancyMap()
        self.track = PersonTrack()
        self.course = PersonCourse()
        self._finder = PersonFinder()
        self._life = LifeSigns()
        self.here: FloatArray = np.zeros(2)
        self.yaw = 0.0
        self.time_s = 0.0
        self.num_moved = 0
        """Looks in which the person moved, while the robot watched."""
        self._believed: PersonCourse | None = None
        self._dead: list[_Thing] = []
        self._others: list[tuple[float, FloatArray]] = []

    def take_in(self, observation: Observation) -> None:
        """One look; those of the collection only tell where the person is."""
        searching = not observation.collecting
        self.here, self.yaw = observation.position[[0, 2]], observation.yaw
        self.time_s = observation.time_s
        around = tuple(
            one
            for one in self._finder.update(observation, compared=searching)
            if one.moved or not any(dead.hides(one) for dead in self._dead)
        )
        partner = self.partner_xz
        other = None if partner is None else self._other_meant(around, partner)
        if other is None:
            sightings = self._theirs(around, partner)
        else:
            self._turn_to_other()
            sightings = (other,)
        before = self.track.place_xz
        self.track.update(sightings, observation)
        place = self.track.place_xz
        self._note_others([one.place_xz for one in around if one.confidence >= _SURELY])
        if searching:
            self._life.take_in(observation)
            self.plan.add(observation, self._finder.person_pixels)
            recent = [] if place is None or self.unseen_s > _PERSON_STAYS_S else [place]
            people = [one.place_xz for one in around if one.confidence >= _SURE_ALIVE]
            self.plan.keep_from(people + recent, self.course.trodden_xz)
        if place is None or not self.is_seen:
            return
        if self._believed is None and before is not None and math.dist(place, before) > _STRAY_M:
            self.course = PersonCourse()
            self.num_moved = 0
        look = min(sightings, key=lambda one: math.dist(one.place_xz, place))
        pixels = self._finder.person_pixels
        if searching:
            self.num_moved += self._life.seen_in(pixels, look.bearing, observation)
        # Of a body that the border of the image cuts, the facing is a guess.
        is_whole = not look.cut and abs(look.bearing) < _CENTRAL
        facing = look.facing_yaw if is_whole else None
        height = None if look.cut else look.height_m
        self.course.add(self.time_s, place, facing, look.distance_m, height)
        sure = _SURE_ALIVE if self.is_alive else _SURE
        if self.track.is_stable and self.track.confidence >= sure:
            self._believed = self.course

    def _theirs(
        self, sightings: tuple[Sighting, ...], partner: FloatArray | None
    ) -> tuple[Sighting, ...]:
        """Those that may be of the person who is believed, and not of a partner at `(2,)`."""
        place = self.track.place_xz
        if place is not None and partner is not None:
            sightings = tuple(
                one
                for one in sightings
                if math.dist(one.place_xz, place) < math.dist(one.place_xz, partner)
            )
        if self._believed is None:
            return sightings
        center, reach = self._believed.center_xz, self._believed.reach_m
        gate = min(_STRAY_M + reach + _STRAY_M_PER_S * self.unseen_s, _FARTHEST_M)
        away = [(one, math.dist(one.place_xz, center)) for one in sightings]
        return tuple(
            one
            for one, away_m in away
            if away_m <= gate and (one.confidence >= _LIKELY or away_m <= reach + _NEAR_M)
        )

    def _other_meant(self, sightings: tuple[Sighting, ...], partner: FloatArray) -> Sighting | None:
        """The look at a partner at `(2,)`, if they are meant and not the one who is tracked.

        An episode begins turned to whom it is about; who of two matters cannot be seen.
        """
        place = self.track.place_xz
        if place is None or turned_from(partner) + _CLEARLY > turned_from(place):
            return None
        near = [
            one
            for one in sightings
            if one.confidence >= _SURELY and math.dist(one.place_xz, partner) < _NEAR_M
        ]
        return min(near, key=lambda one: math.dist(one.place_xz, partner), default=None)

    def _turn_to_other(self) -> None:
        """Tracks somebody else from now on, believed as much as who was tracked before."""
        self.num_moved = 0
        self.track, self.course = PersonTrack(), PersonCourse()
        self._others.clear()
        if self._believed is not None:
            self._believed = self.course

    def _note_others(self, people: list[FloatArray]) -> None:
        """Remembers where people are who are not the one that is tracked."""
        tracked = self.track.place_xz
        if tracked is not None:
            for place in people:
                if math.dist(place, tracked) > _OTHER_M:
                    self._others.append((self.time_s, place))
        self._others = [one for one in self._others if one[0] > self.time_s - _OTHERS_STAY_S]

    @property
    def partner_xz(self) -> FloatArray | None:
        """Where somebody else near to the person was in the last seconds, `(2,)`."""
        if not len(self.course):
            return None
        center = self.course.center_xz
        near = [place for _, place in self._others if math.dist(place, center) < _PARTNER_M]
        return np.median(near, axis=0) if len(near) >= _PARTNER_LOOKS else None

    @property
    def is_seen(self) -> bool:
        """Whether the person is in the last look."""
        return self.track.last_seen_s == self.time_s

    @property
    def unseen_s(self) -> float:
        """Since the person was seen last; `inf` if never."""
        last = self.track.last_seen_s
        return math.inf if last is None else self.time_s - last

    @property
    def is_found(self) -> bool:
        """Whether there is a person beyond doubt, who looked like one in stable looks."""
        return self._believed is not None

    def bearing_to(self, place_xz: FloatArray) -> float:
        """How far to turn left to look at a place, radians in [-pi, pi]."""
        return math.remainder(bearing(self.here, place_xz) - self.yaw, 2.0 * math.pi)

    @property
    def is_alive(self) -> bool:
        """Whether the person moved while the robot watched: nobody stands still for long."""
        return self.num_moved >= _ALIVE_LOOKS

    def forget_person(self) -> None:
        """Nobody is there; a thing that never moved is ignored from now on, until it does."""
        place = self.track.place_xz
        if not self.is_alive and place is not None:
            self._dead.append(_Thing(place, math.dist(place, self.here)))
        self.num_moved = 0
        self.track, self.course = PersonTrack(), PersonCourse()
        self._believed = None
