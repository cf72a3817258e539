"""A robot in an episode: where its actions take it, what it knows, and what is written down."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_release import (
    circle_motion,
    limb_avatar,
    make_episode,
    small_navmeshes,
    small_scenes,
    sway_motion,
    world_of,
)

from affectsim_data.cameras import Camera
from affectsim_data.episodes import Episode, World
from affectsim_data.poses import FloatArray
from affectsim_data.render import ClipSpec, RenderedClip, RendererName
from affectsim_data.schemas import SCHEMAS
from affectsim_data.simulation import ACTIONS, Action, Budget, EpisodeRun
from affectsim_data.simulation.moving import RobotState, after, wrapped_angle

NOBODY = np.zeros((0, 3))
WALL_M = 4.0 - 0.3
"""From the middle of the room to where the middle of the robot ends, one cell less or more."""


class Painter:
    """Stands in for a renderer: black images, and the clips it was asked for."""

    name: RendererName = "egl"

    def __init__(self) -> None:
        self.asked: list[ClipSpec] = []

    def render(self, spec: ClipSpec, *, instances: bool = False) -> RenderedClip:
        self.asked.append(spec)
        shape = (len(spec.trajectory), spec.camera.height, spec.camera.width)
        return RenderedClip(np.zeros((*shape, 3), np.uint8), np.ones(shape, np.float32), None)

    def close(self) -> None:
        pass


def moved(x: float, z: float, yaw_deg: float, action: Action, people: Any = NOBODY) -> RobotState:
    """A robot in the empty room, whose walls are 4 m from its middle, after an action."""
    state = RobotState((x, 0.0, z), math.radians(yaw_deg))
    return after(state, action, small_navmeshes()["empty_room"], np.asarray(people, np.float64))


def sway_world(anchor: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> World:
    scene = small_scenes()["empty_room"]
    return world_of(scene, [(sway_motion("sway_happy", "happy"), limb_avatar("plain"), anchor, 0)])


def begun(episode: Episode | None = None, world: World | None = None, **options: Any) -> EpisodeRun:
    """A run of the swaying episode: the robot at (0, 0, -2.5) looks along +Z, at the person."""
    return EpisodeRun(
        make_episode() if episode is None else episode,
        sway_world() if world is None else world,
        small_navmeshes()["empty_room"],
        Painter(),
        policy="test",
        **options,
    )


@pytest.mark.parametrize(
    ("yaw_deg", "x", "z"), [(0, 0, -0.25), (90, -0.25, 0), (180, 0, 0.25), (-90, 0.25, 0)]
)
def test_a_move_goes_a_quarter_of_a_metre_ahead(yaw_deg: float, x: float, z: float) -> None:
    state = moved(0.0, 0.0, yaw_deg, "move_forward")
    np.testing.assert_allclose(state.position, (x, 0.0, z), atol=1e-12)
    assert state.yaw == math.radians(yaw_deg)
    assert not state.clipped


def test_turns_are_fifteen_degrees_and_counter_clockwise_to_the_left() -> None:
    left, right = moved(1.0, 2.0, 0.0, "turn_left"), moved(1.0, 2.0, 0.0, "turn_right")
    assert math.degrees(left.yaw) == pytest.approx(15.0)
    assert math.degrees(right.yaw) == pytest.approx(-15.0)
    assert left.position == right.position == (1.0, 0.0, 2.0)
    assert math.degrees(moved(0.0, 0.0, 170.0, "turn_left").yaw) == pytest.approx(-175.0)


@pytest.mark.parametrize("action", ["hand_off", "stop"])
def test_other_actions_move_nothing(action: Action) -> None:
    assert moved(1.0, 2.0, 30.0, action) == RobotState((1.0, 0.0, 2.0), math.radians(30.0))


def test_a_move_ends_at_the_wall_and_does_not_slide_along_it() -> None:
    straight = moved(3.6, 0.0, -90.0, "move_forward")
    assert straight.clipped
    assert straight.position[0] == pytest.approx(WALL_M, abs=0.06)
    assert straight.position[2] == pytest.approx(0.0, abs=1e-9)
    askew = moved(straight.position[0], 0.0, -45.0, "move_forward")
    assert askew.clipped
    np.testing.assert_allclose(askew.position, straight.position, atol=2e-3)


def test_a_move_ends_half_a_metre_from_a_pelvis() -> None:
    # Person 0.6 m ahead: 0.1 m is left. Height does not matter.
    state = moved(0.0, 0.0, 0.0, "move_forward", [[0.0, 0.95, -0.6]])
    np.testing.assert_allclose(state.position, (0.0, 0.0, -0.1), atol=1e-9)
    assert state.clipped
    # 0.3 m to the side and 0.6 m ahead: the circle begins at 0.6 - 0.4 m.
    state = moved(0.0, 0.0, 0.0, "move_forward", [[0.3, 0.95, -0.6]])
    np.testing.assert_allclose(state.position, (0.0, 0.0, -0.2), atol=1e-9)


def test_a_move_may_pass_people_by_or_end_at_half_a_metre_unclipped() -> None:
    assert not moved(0.0, 0.0, 0.0, "move_forward", [[0.5001, 1.0, -0.125]]).clipped
    assert not moved(0.0, 0.0, 0.0, "move_forward", [[0.0, 1.0, -0.7501]]).clipped
    assert not moved(0.0, 0.0, 0.0, "move_forward", [[0.0, 1.0, 0.51]]).clipped  # behind


def test_the_nearest_of_several_people_stops_a_move() -> None:
    people = [[0.0, 1.0, -0.7], [0.0, 1.0, -0.6], [3.0, 1.0, 3.0]]
    state = moved(0.0, 0.0, 0.0, "move_forward", people)
    np.testing.assert_allclose(state.position, (0.0, 0.0, -0.1), atol=1e-9)


def test_who_is_too_near_already_may_go_away_but_not_nearer() -> None:
    person = [[0.0, 1.0, -0.3]]
    stuck = moved(0.0, 0.0, 0.0, "move_forward", person)
    assert stuck == RobotState((0.0, 0.0, 0.0), 0.0, clipped=True)
    away = moved(0.0, 0.0, 180.0, "move_forward", person)
    np.testing.assert_allclose(away.position, (0.0, 0.0, 0.25), atol=1e-12)
    assert not away.clipped
    # Across the line of sight is away, too: it ends farther off than it began.
    assert not moved(0.0, 0.0, 90.0, "move_forward", person).clipped


@given(
    yaw=st.floats(-math.pi, math.pi),
    x=st.floats(-1.5, 1.5),
    z=st.floats(-1.5, 1.5),
)
def test_no_move_ends_nearer_than_half_a_metre_unless_it_leads_away(
    yaw: float, x: float, z: float
) -> None:
    state = moved(0.0, 0.0, math.degrees(yaw), "move_forward", [[x, 1.0, z]])
    before, now = math.hypot(x, z), math.dist((x, z), state.position[::2])
    assert now >= min(before, 0.5) - 1e-9
    gone = math.hypot(*state.position[::2])
    assert gone <= 0.25 + 1e-12
    assert state.clipped == (gone**2 + 1e-5 < 0.25**2)


@given(angle=st.floats(-20.0, 20.0))
def test_wrapped_angles_are_the_same_angles_in_a_half_open_turn(angle: float) -> None:
    wrapped = wrapped_angle(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.isclose(math.cos(wrapped - angle), 1.0)
    assert wrapped_angle(-math.pi) == wrapped_angle(math.pi) == math.pi


def test_a_person_who_walks_into_the_robot_pushes_nothing_and_blocks_the_way() -> None:
    # A circle of radius 0.5 m around (0.5, 0, 0) in 3 s; the robot stands on it, opposite.
    motion = circle_motion("circle_sad", "sad")
    scene = small_scenes()["empty_room"]
    world = world_of(scene, [(motion, limb_avatar("plain"), (0.0, 0.0, 0.0), 0.0)])
    episode = make_episode(
        start_position=(1.0, 0.0, 0.0), start_yaw=math.radians(90.0), phase_s=0.0, duration_s=3.0
    )
    run = begun(episode, world)
    away = [math.dist(run.people(0.25 * step)[0, ::2], (1.0, 0.0)) for step in range(13)]
    assert min(away) < 0.1
    assert max(away) > 0.9
    for _ in range(6):
        run.act("turn_left")
        run.act("turn_right")
    assert run.state.position == (1.0, 0.0, 0.0)
    assert not any(row["clipped"] for row in run.rows)


def test_people_are_where_they_are_at_the_end_of_the_action() -> None:
    motion = circle_motion("circle_sad", "sad")
    scene = small_scenes()["empty_room"]
    world = world_of(scene, [(motion, limb_avatar("plain"), (0.0, 0.0, 0.0), 0.0)])
    # The circle from the left of the origin: (0.5 - 0.5 cos, 0.5 sin) of 120 degrees a second.
    run = begun(make_episode(phase_s=0.5, duration_s=3.0), world)
    for time_s in (0.0, 0.25, 1.0, 4.0):
        turned = math.radians(120.0 * (0.5 + time_s))
        where = (0.5 - 0.5 * math.cos(turned), 0.5 * math.sin(turned))
        np.testing.assert_allclose(run.people(time_s)[0, ::2], where, atol=0.003)


@pytest.mark.parametrize("start_yaw", [0.0, 2.0, math.pi, -1.0])
def test_the_pose_is_told_relative_to_the_start(start_yaw: float) -> None:
    run = begun(make_episode(start_position=(1.0, 0.0, -2.0), start_yaw=start_yaw))
    first = run.observe()
    assert first.position.tolist() == [0.0, 0.0, 0.0]
    assert (first.yaw, first.time_s, first.clipped, first.collecting) == (0.0, 0.0, False, False)
    # Ahead by two moves, then 90 degrees to the left and on: 0.5 m ahead, 0.25 m to the left.
    actions: tuple[Action, ...] = ("move_forward", "turn_left")
    for action in (*actions[:1] * 2, *actions[1:] * 6, *actions[:1]):
        run.act(action)
    last = run.observe()
    np.testing.assert_allclose(last.position, (-0.25, 0.0, -0.5), atol=1e-6)
    assert last.yaw == pytest.approx(math.pi / 2)
    assert last.time_s == 9 / 4
    assert last.camera_height_m == 1.2


def test_half_a_turn_is_told_as_pi() -> None:
    run = begun()
    for _ in range(12):
        run.act("turn_right")
    assert abs(run.observe().yaw) == pytest.approx(math.pi)
    assert -math.pi < run.observe().yaw <= math.pi


def test_images_are_of_the_head_camera_and_of_the_instant() -> None:
    run = begun(camera=Camera(32, 16, math.radians(60.0)))
    painter = run._renderer
    assert isinstance(painter, Painter)
    run.act("turn_left")
    seen = run.observe()
    assert seen.rgb.shape == (16, 32, 3)
    assert seen.depth.shape == (16, 32)
    pose = painter.asked[-1].trajectory.T_world_camera[0]
    np.testing.assert_allclose(pose[:3, 3], (0.0, 1.2, -2.5))
    yaw = math.pi + math.radians(15.0)
    np.testing.assert_allclose(-pose[:3, 2], (-math.sin(yaw), 0.0, -math.cos(yaw)), atol=1e-12)
    instant = np.array([run.episode.phase_s + 0.25])
    expected: FloatArray = run.world.target.joint_matrices(instant)
    np.testing.assert_array_equal(painter.asked[-1].people[0].joint_matrices, expected)


def test_rows_are_those_of_the_contract() -> None:
    run = begun()
    run.act("move_forward", planner_calls=2)
    run.act("turn_left", planner_calls=1, approaching=True)
    run.act("hand_off")
    run.act("move_forward")
    table = pa.Table.from_pylist(run.rows, schema=SCHEMAS["trajectories"])
    assert list(run.rows[0]) == SCHEMAS["trajectories"].names
    assert table.column("step").to_pylist() == [0, 1, 2, 3]
    assert table.column("time_s").to_pylist() == [0.25, 0.5, 0.75, 1.0]
    assert table.column("phase").to_pylist() == ["search", "approach", "collect", "collect"]
    assert table.column("planner_calls").to_pylist() == [2, 3, 3, 3]
    assert table.column("position_z_m").to_pylist()[:3] == pytest.approx([-2.25] * 3)
    assert table.column("yaw_deg").to_pylist()[1] == pytest.approx(-165.0)
    assert set(table.column("policy").to_pylist()) == {"test"}
    run.rows[0]["step"] = 99
    run.rows.clear()
    assert len(run.rows) == 4


@pytest.mark.parametrize(
    ("handed_off_after", "clip_start_s", "steps"),
    # Cycles of 2 s: a clip of 4 s from the first whole cycle at or after the end of the handoff.
    [(0, 2.0, 24), (6, 2.0, 24), (7, 2.0, 24), (8, 4.0, 32)],
)
def test_the_clip_begins_with_a_cycle_and_lasts_two(
    handed_off_after: int, clip_start_s: float, steps: int
) -> None:
    run = begun()
    for _ in range(handed_off_after):
        run.act("turn_left")
    starts = [run.clip_start_s]
    run.act("hand_off")
    assert [*starts, run.clip_start_s] == [None, clip_start_s]
    while run.outcome is None:
        assert run.observe().collecting
        run.act("stop" if run.num_steps % 2 else "hand_off")  # both wait
    assert run.outcome == "collected"
    assert run.num_steps == steps
    assert run.time_s == clip_start_s + 4.0
    assert {row["phase"] for row in run.rows[handed_off_after:]} == {"collect"}


def test_a_cycle_that_no_action_ends_with_is_collected_to_its_end() -> None:
    # Cycles of 1.9 s; handed off at 0.25 s, clip from 1.9 to 5.7 s, over with the action to 5.75 s.
    run = begun(make_episode(duration_s=1.9))
    while run.outcome is None:
        run.act("hand_off")
    assert run.clip_start_s == pytest.approx(1.9)
    assert run.time_s == 5.75


def test_giving_up_ends_the_episode() -> None:
    run = begun()
    run.act("stop")
    assert run.outcome == "stopped"
    with pytest.raises(ValueError, match=r"small/0: is over \(stopped\)"):
        run.act("turn_left")


def test_actions_run_out_before_the_handoff_alone() -> None:
    run = begun(budget=Budget(max_actions=3))
    for left in (2, 1, 0):
        assert run.outcome is None
        run.act("turn_left")
        assert run.observe().actions_left == left
    assert run.outcome == "actions_exhausted"
    # The last one may be the handoff; collecting is free.
    run = begun(budget=Budget(max_actions=3))
    actions: tuple[Action, ...] = ("turn_left", "turn_left", "hand_off", "turn_left")
    for action in actions:
        run.act(action)
    assert run.outcome is None
    assert run.observe().actions_left == 0


def test_planner_calls_run_out() -> None:
    run = begun(budget=Budget(max_planner_calls=3))
    run.act("turn_left", planner_calls=2)
    assert run.observe().planner_calls_left == 1
    run.act("turn_left", planner_calls=1)
    assert run.outcome == "planner_calls_exhausted"
    run = begun(budget=Budget(max_planner_calls=3))
    run.act("hand_off", planner_calls=3)
    run.act("turn_left", planner_calls=5)
    assert run.outcome is None
    assert run.observe().planner_calls_left == 0


def test_what_calls_beyond_the_budget_led_to_is_not_done() -> None:
    run = begun(budget=Budget(max_planner_calls=3))
    run.act("hand_off", planner_calls=4)
    assert run.outcome == "planner_calls_exhausted"
    assert [(row["action"], row["phase"], row["planner_calls"]) for row in run.rows] == [
        ("stop", "search", 4)
    ]


@pytest.mark.parametrize("action", ["jump", 0, None, ["stop"], np.array(["stop", "stop"])])
def test_nonsense_is_refused_and_changes_nothing(action: Any) -> None:
    run = begun()
    with pytest.raises(ValueError, match="action must be one of move_forward, turn_left"):
        run.act(action)
    for calls in (-1, 1.5, float("nan"), "3", 10**7):
        with pytest.raises(ValueError, match=r"planner_calls must be a whole number in \[0,"):
            run.act("stop", planner_calls=calls)  # type: ignore[arg-type]  # that is the test
    assert run.rows == []
    assert run.outcome is None


def test_a_start_off_the_navmesh_is_named() -> None:
    with pytest.raises(ValueError, match=r"small/0: the robot starts at .* off the navmesh of"):
        begun(make_episode(start_position=(9.0, 0.0, 0.0)))


@pytest.mark.parametrize("field", ["max_actions", "max_planner_calls"])
@pytest.mark.parametrize("value", [0, 1.5])
def test_budgets_are_whole_numbers(field: str, value: Any) -> None:
    with pytest.raises(ValueError, match=f"{field} must be a whole number from 1, got {value}"):
        Budget(**{field: value})


@given(choices=st.lists(st.sampled_from(ACTIONS[:3]), max_size=30))
def test_rows_follow_from_the_actions_one_by_one(choices: list[Action]) -> None:
    run = begun()
    for action in choices:
        run.act(action)
    state = RobotState(run.episode.start_position, run.episode.start_yaw)
    for number, (action, row) in enumerate(zip(choices, run.rows, strict=True)):
        people = run.people((number + 1) / 4)
        state = after(state, action, run.navmesh, people)
        told = (row["position_x_m"], row["position_y_m"], row["position_z_m"])
        assert (told, row["clipped"]) == (state.position, state.clipped)
        assert row["yaw_deg"] == math.degrees(state.yaw)
    assert dataclasses.astuple(run.state) == dataclasses.astuple(state)
