"""Of two people the baseline tracks the one whom the episode began turned to."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from small_release import box_room
from test_baseline import watched
from test_baseline_mapping import whole_turn
from test_baseline_seeing import observation, sighting

from affectsim_data.simulation.policies.scan_search_follow.mapping import OccupancyMap
from affectsim_data.simulation.policies.scan_search_follow.seeing import Sighting
from affectsim_data.simulation.policies.scan_search_follow.senses import Senses
from affectsim_data.simulation.policies.scan_search_follow.viewing import best_view

TARGET, PARTNER = (0.1, -3.0), (1.0, -2.2)
"""The first is 2 degrees beside where the robot is turned at first, the other 24, and nearer."""


class SeenPeople:
    """A finder that finds what a test wants."""

    person_pixels = None
    sightings: tuple[Sighting, ...] = ()

    def update(self, *_: object, **__: object) -> tuple[Sighting, ...]:
        return self.sightings


def seeing(*looks: tuple[tuple[float, float], ...]) -> Senses:
    """What is known after looks, four a second, each at people at places `(x, z)`."""
    senses, finder = Senses(), SeenPeople()
    senses._finder = finder  # type: ignore[assignment]  # all that is called
    for number, people in enumerate(looks):
        finder.sightings = tuple(sighting(*place) for place in people)
        look = dataclasses.replace(observation(time_s=number / 4.0), collecting=True)
        senses.take_in(look)
    return senses


@pytest.fixture(scope="module")
def hall() -> OccupancyMap:
    return whole_turn(box_room("hall", half=4.0), (0.0, 0.0))


class TestWho:
    def test_of_two_in_sight_the_one_the_start_is_turned_to(self) -> None:
        for people in ((TARGET, PARTNER), (PARTNER, TARGET)):
            assert seeing(people).track.place_xz == pytest.approx(TARGET)

    def test_the_other_is_left_as_soon_as_the_one_meant_is_seen(self) -> None:
        alone = ((PARTNER,),) * 8
        assert seeing(*alone).track.place_xz == pytest.approx(PARTNER)
        senses = seeing(*alone, *((PARTNER, TARGET),) * 6)
        assert senses.track.place_xz == pytest.approx(TARGET)
        assert senses.is_found
        assert senses.partner_xz == pytest.approx(PARTNER)
        assert senses.course.center_xz == pytest.approx(TARGET)

    def test_who_is_hidden_for_a_moment_does_not_become_the_other(self) -> None:
        both, hidden = (TARGET, PARTNER), (PARTNER,)
        senses = seeing(*(both,) * 8, *(hidden,) * 8, *(both,) * 2)
        assert senses.track.place_xz == pytest.approx(TARGET)
        assert senses.course.reach_m < 0.1

    @pytest.mark.parametrize(
        "other",
        [
            (3.0, -3.0),  # too far off
            (0.4, -3.0),  # the very same person
        ],
    )
    def test_who_is_no_partner_does_not_count(self, other: tuple[float, float]) -> None:
        assert seeing(*((TARGET, other),) * 8).partner_xz is None

    def test_a_partner_is_seen_more_than_once(self) -> None:
        assert seeing(*((TARGET,),) * 8, *((TARGET, PARTNER),) * 2).partner_xz is None


class TestViewsOfTwo:
    def test_nobody_hides_the_one_who_matters(self, hall: OccupancyMap) -> None:
        one, other = np.array([-0.6, 0.0]), np.array([0.6, 0.0])
        course = watched((-0.6, 0.0), -math.pi / 2.0)  # turned to the other
        assert best_view(hall, np.array([2.5, 0.0]), course, []).place_xz[0] > 1.0
        both = best_view(hall, np.array([2.5, 0.0]), course, [], other)
        away, across = both.place_xz - one, (other - one) / math.dist(one, other)
        assert abs(away[0] * across[1] - away[1] * across[0]) > 0.5
        assert away @ across > 0.0

    def test_they_face_each_other_where_nothing_else_is_known(self, hall: OccupancyMap) -> None:
        one, other = np.array([0.0, 0.0]), np.array([0.0, -1.2])
        view = best_view(hall, np.array([0.5, 2.5]), watched((0.0, 0.0), None), [], other)
        assert (view.place_xz - one) @ (other - one) > 0.0
