"""Ways, handoffs, budgets and clipped moves from trajectories, by hand and by a plain loop."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

from affectsim_data.evaluation.acquisition import MAX_ACTIONS, MAX_PLANNER_CALLS, acquisitions
from affectsim_data.evaluation.scored import Acquisitions
from affectsim_data.schemas import SCHEMAS

IDS = np.array(["one", "two", "three"])
STARTS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 3.0], [5.0, 0.0, -2.0]])


def step(
    episode: str,
    number: int,
    action: str,
    position: tuple[float, float, float],
    *,
    phase: str = "search",
    clipped: bool = False,
    planner_calls: int = 0,
) -> dict[str, Any]:
    """A row of the table."""
    return {
        "episode_id": episode,
        "policy": "walker",
        "step": number,
        "time_s": number / 4,
        "action": action,
        "position_x_m": position[0],
        "position_y_m": position[1],
        "position_z_m": position[2],
        "yaw_deg": 0.0,
        "clipped": clipped,
        "phase": phase,
        "planner_calls": planner_calls,
    }


def table_of(rows: list[dict[str, Any]]) -> pa.Table:
    return pa.Table.from_pylist(rows, schema=SCHEMAS["trajectories"])


def measured(rows: list[dict[str, Any]]) -> Acquisitions:
    return acquisitions(table_of(rows), IDS, STARTS, policy="walker")


def test_an_episode_by_hand() -> None:
    found = measured(
        [
            step("two", 0, "move_forward", (1.0, 0.0, 0.0), planner_calls=1),
            step("two", 1, "turn_left", (1.0, 0.0, 0.0), planner_calls=1),
            step("two", 2, "move_forward", (4.0, 2.0, 4.0), clipped=True, planner_calls=3),
            step("two", 3, "hand_off", (4.0, 2.0, 4.0), phase="approach", planner_calls=3),
            step("two", 4, "move_forward", (4.0, 2.0, 6.0), phase="collect", planner_calls=3),
        ]
    )
    # From (1, 3) to (1, 0), to (4, 4) over the floor, and 2 m more after the handoff.
    assert found.path_length_m.tolist() == [0, 3 + 5 + 2, 0]
    assert found.path_before_handoff_m.tolist() == [0, 8, 0]
    assert found.num_steps.tolist() == [0, 5, 0]
    assert found.planner_calls.tolist() == [0, 3, 0]
    assert found.num_translations.tolist() == [0, 3, 0]
    assert found.num_clipped.tolist() == [0, 1, 0]
    assert found.handed_off.tolist() == [False, True, False]
    assert found.acquired.tolist() == [False, True, False]
    assert found.budget_exhausted.tolist() == [False, False, False]


def test_without_a_handoff_all_of_the_way_is_before_it() -> None:
    found = measured(
        [step("one", 0, "move_forward", (0, 0, -3)), step("one", 1, "stop", (0, 0, -3))]
    )
    assert found.path_length_m[0] == found.path_before_handoff_m[0] == 3
    assert not found.handed_off.any()


def test_a_handoff_without_collecting_acquires_nothing() -> None:
    rows = [step("one", 0, "hand_off", (0, 0, 0)), step("one", 1, "stop", (0, 0, 0))]
    found = measured(rows)
    assert found.handed_off[0]
    assert not found.acquired[0]


def test_collecting_before_the_handoff_acquires_nothing() -> None:
    rows = [
        step("one", 0, "move_forward", (0, 0, -1), phase="collect"),
        step("one", 1, "hand_off", (0, 0, -1), phase="collect"),
    ]
    assert not measured(rows).acquired[0]


def test_the_first_handoff_counts() -> None:
    rows = [
        step("one", 0, "move_forward", (0, 0, -1)),
        step("one", 1, "hand_off", (0, 0, -1)),
        step("one", 2, "move_forward", (0, 0, -2)),
        step("one", 3, "hand_off", (0, 0, -2)),
    ]
    found = measured(rows)
    assert (found.path_length_m[0], found.path_before_handoff_m[0]) == (2, 1)


@pytest.mark.parametrize(("actions", "calls", "exhausted"), [
    (MAX_ACTIONS, 0, True),
    (MAX_ACTIONS - 1, 0, False),
    (5, MAX_PLANNER_CALLS, True),
    (5, MAX_PLANNER_CALLS - 1, False),
])  # fmt: skip
def test_the_budget_is_480_actions_or_80_planner_calls(
    actions: int, calls: int, exhausted: bool
) -> None:
    rows = [
        step("one", number, "turn_left", (0, 0, 0), planner_calls=calls)
        for number in range(actions)
    ]
    assert measured(rows).budget_exhausted.tolist() == [exhausted, False, False]
    rows[-1]["action"] = "hand_off"
    assert not measured(rows).budget_exhausted.any()


def random_rows(rng: np.random.Generator) -> list[dict[str, Any]]:
    actions = ("move_forward", "turn_left", "turn_right", "hand_off", "stop")
    return [
        step(
            str(episode),
            number,
            str(rng.choice(actions, p=[0.5, 0.2, 0.2, 0.02, 0.08])),
            tuple(rng.normal(size=3)),
            phase=str(rng.choice(["search", "collect"])),
            clipped=bool(rng.random() < 0.3),
            planner_calls=number // 3,
        )
        for episode in IDS
        for number in range(rng.integers(1, 40))
    ]


@pytest.mark.parametrize("seed", range(5))
def test_a_plain_loop_finds_the_same_in_any_order_of_rows(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows = random_rows(rng)
    shuffled = measured([rows[place] for place in rng.permutation(len(rows))])
    for index, episode in enumerate(IDS):
        mine = [row for row in rows if row["episode_id"] == episode]
        x, z = STARTS[index, 0], STARTS[index, 2]
        total = before = 0.0
        handed = acquired = False
        for row in mine:
            total += math.hypot(row["position_x_m"] - x, row["position_z_m"] - z)
            x, z = row["position_x_m"], row["position_z_m"]
            acquired |= handed and row["phase"] == "collect"
            if not handed:
                before, handed = total, row["action"] == "hand_off"
        moves = [row["clipped"] for row in mine if row["action"] == "move_forward"]
        assert shuffled.path_length_m[index] == pytest.approx(total)
        assert shuffled.path_before_handoff_m[index] == pytest.approx(before)
        assert (shuffled.num_translations[index], shuffled.num_clipped[index]) == (
            len(moves),
            sum(moves),
        )
        assert (shuffled.handed_off[index], shuffled.acquired[index]) == (handed, acquired)


def test_strange_rows_are_refused() -> None:
    rows = [step("four", 0, "stop", (0, 0, 0))]
    with pytest.raises(ValueError, match="episode 'four' is not among those evaluated"):
        measured(rows)
    with pytest.raises(ValueError, match="must be of policy 'other' alone, got 'walker'"):
        acquisitions(table_of(rows), IDS, STARTS, policy="other")


def test_no_rows_at_all() -> None:
    assert measured([]).path_length_m.tolist() == [0, 0, 0]
