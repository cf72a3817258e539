"""From the first sight of a person to the handoff: a good view is chosen, gone to, made sure of."""

from __future__ import annotations

import math

from affectsim_data.poses import FloatArray
from affectsim_data.simulation.actions import TURN, Action
from affectsim_data.simulation.policies.scan_search_follow.exploring import nearest_frontier
from affectsim_data.simulation.policies.scan_search_follow.senses import Senses
from affectsim_data.simulation.policies.scan_search_follow.tracking import WALKING_M_PER_S
from affectsim_data.simulation.policies.scan_search_follow.viewing import (
    View,
    best_view,
    rate_views,
)
from affectsim_data.simulation.policies.scan_search_follow.ways import Walk

__all__ = ["Approach", "look_at", "watch"]

_ARRIVED_M = 0.18
"""A view is reached from so near, nearer than other goals: every decimetre shows more or less of
the feet."""
_AIM = 0.2
"""Radians a handoff may look past the person: less than a turn, more than half of one."""
_WATCHED_S = 3.0
"""A person is watched this long before a handoff: most of a cycle, to know where they face."""
_CHOICES = 14
"""Views that are chosen at most."""
_GAIN, _MORE_GAIN, _WALKER_GAIN = 0.06, 0.02, 0.3
"""A view has to be worth so much more to be gone to instead, and more every time."""
_RECONSIDER_S = 2.5
_RETRIES, _MEAGRE = 1, 1.0
"""Where no view of that quality is left, what cut moves short is forgotten, so often: it closes
passages on the map that the robot may fit through after all."""
_SURVEYED_M = 3.5
_SURVEY = 3
"""Turns to either side once a person is this near: to know the floor beside them."""
_PATIENCE_S = 10.0
"""After so long at a view without seeing a person well enough for a handoff it is given up."""
_HEADINGS = round(2.0 * math.pi / TURN)
_DETOURS = 6
_LEARNED_M, _LEARNED_S = 4.5, 5.0
"""Somebody so near who walks is watched so long, most of a cycle, before a view is chosen."""
_WAITS, _WAIT_S, _PASSES_M = 10, 1.0, 2.0
"""Somebody so near who walks about is let pass, so often, so long each time."""
_GONE_S = 3.0
"""Somebody not seen for so long where they should be is not there."""


class Approach:
    """Goes to the best view of the person in sight."""

    def __init__(self, senses: Senses, walk: Walk) -> None:
        self._senses, self._walk = senses, walk
        self._view: View | None = None
        self._chosen_s = -1e9
        self._avoid: list[FloatArray] = []
        self._choices = 0
        turns: tuple[Action, Action] = ("turn_left", "turn_right")
        self._survey = [turns[0]] * _SURVEY + [turns[1]] * 2 * _SURVEY
        self._settled_s: float | None = None
        self._moved_before = 0
        self._detours = 0
        self._learn_until_s: float | None = None
        self._waits, self._wait_until_s = _WAITS, -1.0
        self._lost_way = False
        self._retries = _RETRIES
        self.planner_calls = 0
        """Views chosen so far."""

    def action(self) -> Action | None:
        """The next action: `hand_off` when the view is good, `None` when nobody is there."""
        senses = self._senses
        place = senses.track.place_xz
        if place is None:
            return None
        if self._learns():
            return watch(senses, place)
        if self._survey and (self._lost_way or math.dist(place, senses.here) < _SURVEYED_M):
            return self._survey.pop(0)
        if senses.time_s < self._wait_until_s:
            return watch(senses, place)
        walked = self._walked(place)
        if walked is not None:
            self._settled_s = None
            return walked
        if self._settled_s is None:
            self._settled_s, self._moved_before = senses.time_s, senses.num_moved
        turn = look_at(senses, place)
        if turn is not None:
            return turn
        settled_s = senses.time_s - self._settled_s
        if min(senses.unseen_s, settled_s) > _GONE_S or settled_s > _PATIENCE_S:
            return None
        if self._is_sure():
            return self._last_thought(place) or "hand_off"
        return watch(senses, place)

    def _is_sure(self) -> bool:
        """Whether there is somebody, by three of the last four looks, who lives and was watched."""
        senses = self._senses
        stable = senses.track.is_stable and senses.is_seen
        watched = self._settled_s is not None and senses.time_s - self._settled_s >= _WATCHED_S
        # Not only once, elsewhere: the looks of somebody may have gone over to a thing.
        lives = senses.is_alive and senses.num_moved > self._moved_before
        return stable and watched and lives

    def _last_thought(self, place: FloatArray) -> Action | None:
        """The first step to another view, if there is one better by far; else `None`."""
        before = self._view
        self._choose()
        if self._survey:
            return self._survey.pop(0)
        return None if self._view is before else self._walked(place)

    def _walked(self, place: FloatArray) -> Action | None:
        """The next action towards the view of a place, `None` if it is reached or there is none
        better."""
        senses = self._senses
        for _ in range(3):
            if self._view is None or senses.time_s - self._chosen_s >= _RECONSIDER_S:
                self._choose()
                if self._survey:
                    return self._survey.pop(0)
            assert self._view is not None
            action = self._walk.action(
                senses.here, senses.yaw, self._view.place_xz, within_m=_ARRIVED_M
            )
            if action is not None:
                return action
            arrived = math.dist(senses.here, self._view.place_xz) <= _ARRIVED_M
            if arrived and math.isfinite(self._view.quality):
                return None
            if self._waits > 0 and self._is_in_the_way():
                self._waits -= 1
                self._wait_until_s = senses.time_s + _WAIT_S
                return watch(senses, place)
            self._avoid.append(self._view.place_xz)
            self._view = None
        return None

    def _learns(self) -> bool:
        """Whether somebody who walks about is watched first, to know where they go."""
        senses, place = self._senses, self._senses.track.place_xz
        if self._learn_until_s is None:
            near = place is not None and math.dist(place, senses.here) < _LEARNED_M
            if not near or not (senses.course.walks or senses.track.speed > WALKING_M_PER_S):
                return False
            self._learn_until_s = senses.time_s + _LEARNED_S
        return senses.time_s < self._learn_until_s and senses.unseen_s < _GONE_S

    def _is_in_the_way(self) -> bool:
        """Whether somebody who walks about is near, to be let pass."""
        senses = self._senses
        place = senses.track.place_xz
        if place is None or not senses.course.walks:
            return False
        return math.dist(place, senses.here) < _PASSES_M

    def _least_gain(self) -> float:
        """What another view has to be worth more: who walks about is seen from all sides anyway."""
        reach_m = min(self._senses.course.reach_m, 1.0)
        return _GAIN + _MORE_GAIN * self._choices + _WALKER_GAIN * reach_m

    def _choose(self) -> None:
        """Chooses the view anew, unless that has been done often enough."""
        senses = self._senses
        self._chosen_s = senses.time_s
        if self._choices >= _CHOICES and self._view is not None:
            return
        self._choices += 1
        self.planner_calls += 1
        found = best_view(senses.plan, senses.here, senses.course, self._avoid, senses.partner_xz)
        if found.quality < _MEAGRE and self._retries > 0 and self._walk.forget_bumps():
            self._retries -= 1
            self._avoid.clear()
            found = best_view(
                senses.plan, senses.here, senses.course, self._avoid, senses.partner_xz
            )
        if found.is_poor and self._detours < _DETOURS:
            if not self._lost_way:
                # Too little is known of the floor to say: look all around, once.
                self._lost_way, self._survey = True, ["turn_left"] * _HEADINGS
                self._view = None
                return
            # No good view is known yet; there may be one where the map ends near the person.
            goal = nearest_frontier(senses.plan, senses.here, senses.course.center_xz, self._avoid)
            if goal is not None:
                self._detours += 1
                self._view = View(goal, -math.inf, -math.inf)
                return
        if self._choices > _CHOICES:
            found = View(senses.here, 0.0, 0.0)
        # Who has arrived compares with where they stand, not with where they meant to.
        goes = self._view is not None and self._settled_s is None
        kept = self._view.place_xz if self._view is not None and goes else senses.here
        quality = float(rate_views(senses.plan, kept[None], senses.course, senses.partner_xz)[0])
        if self._view is None or found.worth > quality + self._least_gain():
            self._view = found


def look_at(senses: Senses, place_xz: FloatArray) -> Action | None:
    """The turn that brings a place into the middle of the image, `None` if it is there."""
    off = senses.bearing_to(place_xz)
    if abs(off) <= _AIM:
        return None
    return "turn_left" if off > 0.0 else "turn_right"


def watch(senses: Senses, place_xz: FloatArray) -> Action:
    """A turn that keeps a place in sight, to and fro: there is no waiting before a handoff."""
    sway: Action = "turn_left" if senses.bearing_to(place_xz) > 0.0 else "turn_right"
    return look_at(senses, place_xz) or sway
