"""Driving by hand: turns, moves, ways along walls, and nothing that swings to and fro."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from affectsim_data.poses import FloatArray
from affectsim_data.simulation.actions import STEP_M, TURN, Action
from affectsim_data.simulation.policies.driving import bearing, drive_along, turn_towards


def moved(place: FloatArray, yaw: float, action: Action) -> tuple[FloatArray, float]:
    """The robot after a move nothing cuts short."""
    if action == "move_forward":
        return place - STEP_M * np.array([math.sin(yaw), math.cos(yaw)]), yaw
    return place, yaw + (TURN if action == "turn_left" else -TURN)


def driven(place: Any, yaw: float, polyline: Any, **kwargs: Any) -> list[FloatArray]:
    """Where the robot gets to, action by action, until it is there."""
    here: FloatArray = np.array(place, float)
    places: list[FloatArray] = []
    for _ in range(400):
        action = drive_along(here, yaw, polyline, **kwargs)
        if action is None:
            return places
        here, yaw = moved(here, yaw, action)
        places.append(here)
    raise AssertionError("it never arrives")


def test_bearings_count_from_ahead_to_the_left() -> None:
    for goal, degrees in (((0, -2), 0), ((-2, 0), 90), ((2, 0), -90), ((-1, -1), 45)):
        assert math.degrees(bearing((0.0, 0.0), goal)) == pytest.approx(degrees)


def test_turns_go_the_short_way_and_end_within_the_tolerance() -> None:
    assert turn_towards(0.0, math.radians(11.0)) == "turn_left"
    assert turn_towards(0.0, math.radians(-11.0)) == "turn_right"
    assert turn_towards(0.0, math.radians(10.0)) is None
    assert turn_towards(math.radians(-175.0), math.radians(170.0)) == "turn_right"
    with pytest.raises(ValueError, match=r"tolerance must be at least 0\.131, got 0\.1"):
        turn_towards(0.0, 1.0, tolerance=0.1)


@given(
    st.floats(-4.0, 4.0),
    st.floats(-4.0, 4.0),
    st.lists(st.floats(-math.radians(2.4), math.radians(2.4)), min_size=20, max_size=20),
)
def test_turning_never_swings_although_the_bearing_does(
    yaw: float, wanted: float, noise: list[float]
) -> None:
    turns = []
    for sway in noise:
        turn = turn_towards(yaw, wanted + sway)
        if turn is not None:
            turns.append(turn)
            _, yaw = moved(np.zeros(2), yaw, turn)
    off = abs(math.remainder(wanted - yaw, 2.0 * math.pi))
    assert off <= math.radians(12.5)
    if turns:
        # At the far side of the circle the first turn may go either way; after it, none go back.
        assert len(set(turns[1:])) <= 1


def test_a_straight_way_is_driven_straight() -> None:
    places = driven((0.0, 0.0), 0.0, [(0.0, -2.0)])
    assert len(places) == 8
    np.testing.assert_allclose(places[-1], (0.0, -2.0), atol=1e-9)


def test_a_goal_to_the_left_is_turned_to_first() -> None:
    assert drive_along((0, 0), 0.0, [(-2, 0)]) == "turn_left"
    assert drive_along((0, 0), math.radians(90.0), [(-2, 0)]) == "move_forward"
    assert drive_along((0, 0), math.radians(9.0), [(0, -2)]) == "move_forward"
    assert drive_along((0, 0), math.radians(10.0), [(0, -2)]) == "turn_right"


def test_there_is_nothing_to_drive_at_the_end() -> None:
    assert drive_along((0.1, 0.0), 0.0, [(0.0, 0.0)]) is None


@given(
    st.floats(-math.pi, math.pi),
    st.floats(-math.pi, math.pi),
    st.lists(
        st.tuples(st.floats(-math.radians(80.0), math.radians(80.0)), st.floats(0.05, 2.0)),
        min_size=1,
        max_size=5,
    ),
)
def test_a_way_that_leads_on_is_driven_to_its_end(
    yaw: float, direction: float, pieces: list[tuple[float, float]]
) -> None:
    ahead = [
        (length * math.sin(direction + bend), length * math.cos(direction + bend))
        for bend, length in pieces
    ]
    corners = np.concatenate([[[0.0, 0.0]], np.cumsum(ahead, axis=0)])
    places = driven((0.0, 0.0), yaw, corners)
    end = places[-1] if places else corners[0]
    assert math.dist(end, corners[-1]) <= 0.3


def test_corners_that_were_passed_are_not_gone_back_to() -> None:
    polyline = [(0.0, 0.0), (0.0, -2.0), (2.0, -2.0)]
    places = driven((0.0, 0.0), 0.0, polyline)
    # 4 m of way are 16 moves; one more for the corner that is cut or overshot.
    moves = [b for a, b in itertools.pairwise(places) if math.dist(a, b) > 0.1]
    assert len(moves) <= 17
    assert math.dist(places[-1], polyline[-1]) <= 0.3
    assert drive_along((1.0, -2.1), math.radians(-90.0), polyline) == "move_forward"


def test_a_wall_is_gone_along_and_round() -> None:
    def is_free(start: FloatArray, end: FloatArray) -> bool:
        # A wall at x = 0 from z = -2 to the back; its corner is where the way bends.
        if (start[0] < 0.0) == (end[0] < 0.0):
            return True
        share = start[0] / (start[0] - end[0])
        return bool(start[1] + share * (end[1] - start[1]) < -2.0)

    places = driven((0.05, 0.0), math.pi, [(0.0, -2.0), (-1.0, -2.05)], is_free=is_free)
    assert math.dist(places[-1], (-1.0, -2.05)) <= 0.2
    crossings = [b for a, b in itertools.pairwise(places) if (a[0] < 0) != (b[0] < 0)]
    assert len(crossings) == 1


def test_where_nothing_is_free_there_is_no_action() -> None:
    assert drive_along((0, 0), 0.0, [(0, -2)], is_free=lambda start, end: False) is None
