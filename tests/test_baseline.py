"""The baseline's decisions: where to look for a person, and where to look at them from."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_release import box_room
from test_baseline_mapping import look, whole_turn

from affectsim_data.observations.still import head_camera_pose
from affectsim_data.poses import FloatArray
from affectsim_data.releases import Release, open_release
from affectsim_data.render import process_renderer
from affectsim_data.simulation import EpisodeRun
from affectsim_data.simulation.actions import STEP_M, TURN, Action, Budget
from affectsim_data.simulation.conformance import PolicyConformance
from affectsim_data.simulation.episodes import run_episode
from affectsim_data.simulation.policies import Policy
from affectsim_data.simulation.policies.scan_search_follow.approaching import Approach
from affectsim_data.simulation.policies.scan_search_follow.courses import PersonCourse
from affectsim_data.simulation.policies.scan_search_follow.exploring import (
    best_frontier,
    nearest_frontier,
)
from affectsim_data.simulation.policies.scan_search_follow.following import follow
from affectsim_data.simulation.policies.scan_search_follow.living import LifeSigns
from affectsim_data.simulation.policies.scan_search_follow.mapping import OccupancyMap
from affectsim_data.simulation.policies.scan_search_follow.policy import ScanSearchFollow
from affectsim_data.simulation.policies.scan_search_follow.senses import Senses
from affectsim_data.simulation.policies.scan_search_follow.viewing import best_view, rate_views
from affectsim_data.simulation.policies.scan_search_follow.ways import Walk
from affectsim_data.visibility import body_samples, scene_caster, visible_share


@pytest.fixture(scope="module")
def hall() -> OccupancyMap:
    """The map of an empty room of 8 x 8 m."""
    return whole_turn(box_room("hall", half=4.0), (0.0, 0.0), (3.0, 3.0), (-3.0, -3.0))


@pytest.fixture(scope="module")
def doorway() -> OccupancyMap:
    """The map of 8 x 8 m that a wall with a doorway 1 m wide parts, seen from one side."""
    walls = [((-4.0, 0.0, -1.1), (0.5, 2.4, -0.9)), ((1.5, 0.0, -1.1), (4.0, 2.4, -0.9))]
    return whole_turn(box_room("doorway", half=4.0, boxes=walls), (0.0, 2.5), (-2.5, 2.5))


def watched(
    place: tuple[float, float],
    facing_yaw: float | None,
    *,
    distance_m: float = 2.0,
    looks: int = 20,
    height_m: float | None = None,
) -> PersonCourse:
    """A person who stays where they are, seen four times a second."""
    course = PersonCourse()
    for number in range(looks):
        course.add(0.25 * number, np.array(place), facing_yaw, distance_m, height_m)
    return course


def circling(
    middle: tuple[float, float], radius_m: float, *, round_s: float = 6.0, looks: int = 32
) -> PersonCourse:
    """A person who walks in circles and faces where they go, seen four times a second."""
    course = PersonCourse()
    for number in range(looks):
        angle = 2.0 * math.pi * 0.25 * number / round_s
        place = np.array(middle) + radius_m * np.array([math.sin(angle), math.cos(angle)])
        course.add(0.25 * number, place, angle - math.pi / 2.0, 2.0)
    return course


class TestCourses:
    def test_facing_grows_surer_with_looks(self) -> None:
        short, long = (watched((0.0, 0.0), 0.5, looks=count).facing for count in (1, 20))
        assert abs(short) == pytest.approx(1 / 4)
        assert abs(long) == pytest.approx(20 / 23)
        assert np.angle(long) == pytest.approx(0.5)

    def test_who_turns_round_faces_nowhere(self) -> None:
        course = PersonCourse()
        for number in range(24):
            course.add(0.25 * number, np.zeros(2), TURN * number, 2.0)
        assert abs(course.facing) < 1e-9

    def test_near_looks_outweigh_far_ones(self) -> None:
        course = watched((0.0, 0.0), math.pi / 2, distance_m=5.0)
        for number in range(20, 24):
            course.add(0.25 * number, np.zeros(2), 0.0, 2.0)
        assert abs(np.angle(course.facing)) < math.radians(20.0)

    def test_unknown_facings_say_nothing(self) -> None:
        assert watched((1.0, 2.0), None).facing == 0.0

    def test_middle_and_reach_are_of_the_bounds(self) -> None:
        course = PersonCourse()
        for number, x in enumerate((0.0, 0.0, 0.0, 0.0, 2.0)):
            course.add(float(number), np.array([x, 0.0]), None, 2.0)
        assert course.center_xz.tolist() == [1.0, 0.0]
        assert course.reach_m == 1.0

    def test_old_looks_are_forgotten(self) -> None:
        course = watched((0.0, 0.0), 0.0)
        course.add(60.0, np.array([3.0, 0.0]), None, 2.0)
        assert len(course) == 1
        assert course.center_xz.tolist() == [3.0, 0.0]

    def test_who_stays_about_treads_no_way(self) -> None:
        course = watched((1.0, 2.0), 0.0)
        course.add(6.0, np.array([1.3, 2.0]), 0.0, 2.0)
        assert not course.walks
        assert course.trodden_xz.shape == (0, 2)

    def test_the_way_of_a_walker_is_near_to_where_they_were_seen(self) -> None:
        course = circling((1.0, -2.0), 1.2)
        assert course.walks
        trodden = course.trodden_xz
        assert np.abs(np.hypot(*(trodden - [1.0, -2.0]).T) - 1.2).max() < 0.2
        angles = np.sort(np.arctan2(*(trodden - [1.0, -2.0]).T))
        assert np.diff(angles, append=angles[0] + 2.0 * math.pi).max() < math.radians(35.0)

    def test_the_way_of_a_walker_is_remembered_while_they_are_not_looked_at(self) -> None:
        course = circling((0.0, 0.0), 1.2)
        course.add(15.0, np.array([0.0, 1.2]), None, 2.0)
        assert course.reach_m == pytest.approx(1.2, abs=0.1)
        course.add(60.0, np.array([0.0, 1.2]), None, 2.0)
        assert len(course) == 1


class TestViews:
    @settings(max_examples=12)
    @given(yaw=st.floats(-math.pi, math.pi))
    def test_the_best_view_is_in_front(self, hall: OccupancyMap, yaw: float) -> None:
        course = watched((0.0, 0.0), yaw)
        view = best_view(hall, np.array([0.5, 2.5]), course, [])
        front = -np.array([math.sin(yaw), math.cos(yaw)])
        away = view.place_xz / np.hypot(*view.place_xz)
        assert front @ away > math.cos(math.radians(25.0))
        assert 1.7 < np.hypot(*view.place_xz) < 2.6
        assert not view.is_poor

    def test_of_a_person_who_faces_nowhere_a_near_side_is_best(self, hall: OccupancyMap) -> None:
        here = np.array([0.0, 3.0])
        view = best_view(hall, here, watched((0.0, 0.0), None), [])
        assert math.dist(view.place_xz, here) < 1.2

    def test_places_to_avoid_are_avoided(self, hall: OccupancyMap) -> None:
        course, here = watched((0.0, 0.0), 0.0), np.array([0.0, 2.5])
        first = best_view(hall, here, course, [])
        second = best_view(hall, here, course, [first.place_xz])
        assert math.dist(first.place_xz, second.place_xz) > 0.4

    def test_of_a_walker_the_side_does_not_matter_but_their_way_does(
        self, hall: OccupancyMap
    ) -> None:
        course = circling((0.0, 0.0), 1.2)
        around = 2.8 * np.array([[0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [-1.0, 0.0]])
        assert np.ptp(rate_views(hall, around, course)) < 0.05
        beside, off = rate_views(hall, np.array([[0.0, 1.5], [0.0, 2.3]]), course)
        assert off > beside + 0.3
        view = best_view(hall, np.array([0.3, 2.2]), course, [])
        assert 2.0 < np.hypot(*view.place_xz) < 3.1

    @pytest.mark.parametrize(
        ("height_m", "nearest_m", "farthest_m"), [(1.2, 2.35, 2.6), (1.7, 2.05, 2.3)]
    )
    def test_who_sits_is_seen_from_farther_off(
        self, hall: OccupancyMap, height_m: float, nearest_m: float, farthest_m: float
    ) -> None:
        course = watched((0.0, 0.0), 0.0, height_m=height_m)
        assert course.height_m == pytest.approx(height_m)
        view = best_view(hall, np.array([0.0, -2.9]), course, [])
        assert nearest_m < np.hypot(*view.place_xz) < farthest_m

    def test_a_wall_between_is_worse_than_a_back(self, doorway: OccupancyMap) -> None:
        course = watched((-2.0, 0.5), 0.0)  # faces the wall, 1.5 m away
        behind_wall, behind = rate_views(doorway, np.array([[-2.0, -1.5], [-2.0, 2.5]]), course)
        assert behind > behind_wall

    def test_who_is_behind_the_wall_is_seen_poorly(self, doorway: OccupancyMap) -> None:
        assert best_view(doorway, np.array([0.0, 2.5]), watched((-2.5, -3.5), None), []).is_poor


class TestWays:
    def test_a_way_leads_through_the_doorway(self, doorway: OccupancyMap) -> None:
        path = doorway.path(np.array([0.0, 2.5]), np.array([1.0, -1.6]))
        assert path is not None
        assert doorway.room(path[1:-1]).min(initial=1.0) >= 0.25
        crossing = path[np.abs(path[:, 1] + 1.0) < 0.8]
        assert len(crossing)
        assert (np.abs(crossing[:, 0] - 1.0) < 0.35).all()

    def test_there_is_no_way_into_a_wall(self, hall: OccupancyMap) -> None:
        assert hall.path(np.zeros(2), np.array([9.0, 0.0])) is None
        row, column = hall.cells((9.0, 0.0))
        assert hall.distances_from(np.zeros(2))[row, column] == np.inf

    def test_a_walk_arrives(self, doorway: OccupancyMap) -> None:
        here, goal = np.array([-2.5, 2.5]), np.array([1.0, -1.6])
        walk, yaw, moves = Walk(doorway), 0.0, 0
        for _ in range(120):
            action = walk.action(here, yaw, goal)
            if action is None:
                break
            if action == "move_forward":
                here = here - STEP_M * np.array([math.sin(yaw), math.cos(yaw)])
                moves += 1
            else:
                yaw += TURN if action == "turn_left" else -TURN
        assert math.dist(here, goal) <= 0.25
        assert moves * STEP_M < 1.2 * (math.hypot(3.5, 3.2) + 1.0)
        assert walk.planner_calls <= 2

    def test_a_bump_is_gone_round(self) -> None:
        plan = whole_turn(box_room("hall", half=4.0), (0.0, 0.0))
        here, goal = np.zeros(2), np.array([0.0, -2.0])
        walk = Walk(plan)
        assert walk.action(here, 0.0, goal) == "move_forward"
        walk.note(here, 0.0, clipped=True)
        assert walk.action(here, 0.0, goal) in ("turn_left", "turn_right")

    def test_a_walk_lets_who_walks_pass(self) -> None:
        plan = whole_turn(box_room("hall", half=4.0), (0.0, 0.0))
        here, goal, walker = np.zeros(2), np.array([0.0, -2.5]), np.array([0.0, -0.85])
        walk = Walk(plan)
        plan.keep_from([walker], [walker])
        assert walk.action(here, 0.0, goal) != "move_forward"
        plan.keep_from([np.array([1.5, -0.85])], [walker])
        assert walk.action(here, 0.0, goal) in ("move_forward", "turn_left", "turn_right")
        assert walk.planner_calls <= 3

    def test_a_goal_out_of_reach_is_given_up(self, hall: OccupancyMap) -> None:
        walk = Walk(hall)
        assert walk.action(np.zeros(2), 0.0, np.array([9.0, 9.0])) is None


class TestExploring:
    def test_a_room_known_whole_has_no_border(self, hall: OccupancyMap) -> None:
        assert best_frontier(hall, np.zeros(2), 0.0, []) is None

    def test_the_border_is_at_the_doorway(self, doorway: OccupancyMap) -> None:
        goal = best_frontier(doorway, np.array([0.0, 2.5]), 0.0, [])
        assert goal is not None
        assert goal[1] < 0.0

    def test_a_border_to_no_avail_is_not_gone_to_again(self, doorway: OccupancyMap) -> None:
        here, avoid = np.array([0.0, 2.5]), list[FloatArray]()
        for _ in range(60):
            goal = best_frontier(doorway, here, 0.0, avoid)
            if goal is None:
                return
            assert all(math.dist(goal, one) >= 0.5 for one in avoid)
            avoid.append(goal)
        pytest.fail("borders must come to an end")

    def test_the_nearest_to_somebody_is_towards_them(self, doorway: OccupancyMap) -> None:
        goal = nearest_frontier(doorway, np.array([0.0, 2.5]), np.array([2.5, -3.0]), [])
        assert goal is not None
        assert goal[0] > 0.0


class TestLife:
    def test_a_change_at_the_same_pose_is_life(self) -> None:
        still = look(box_room("hall", half=4.0), 0.0, 0.0, 0.0)
        hand = still.rgb.copy()
        hand[40:50, 44:54] = 200
        body = np.zeros(hand.shape[:2], bool)
        body[20:80, 36:60] = True
        life = LifeSigns()
        life.take_in(still)
        assert not life.seen_in(body, 0.0, still)
        life.take_in(still)
        assert not life.seen_in(body, 0.0, still)
        life.take_in(dataclasses.replace(still, rgb=hand))
        assert life.seen_in(body, 0.0, still)
        assert not life.seen_in(body, math.radians(25.0), still)
        assert not life.seen_in(None, 0.0, still)

    def test_views_from_elsewhere_are_not_compared(self) -> None:
        still = look(box_room("hall", half=4.0), 0.0, 0.0, 0.0)
        other = np.full_like(still.rgb, 255)
        body = np.ones(other.shape[:2], bool)
        for moved in (
            dataclasses.replace(still, rgb=other, position=np.array([0.3, 0.0, 0.0])),
            dataclasses.replace(still, rgb=other, yaw=TURN),
        ):
            life = LifeSigns()
            life.take_in(still)
            life.take_in(moved)
            assert not life.seen_in(body, 0.0, moved)


@dataclasses.dataclass
class SeenTrack:
    """A track that says what a test wants."""

    place_xz: FloatArray | None
    last_seen_s: float | None = 0.0
    is_stable: bool = True
    confidence: float = 0.9
    speed: float = 0.0


def sensing(place: tuple[float, float] | None, *, unseen_s: float = 0.0) -> Senses:
    """What a robot at the origin that looks along -Z knows of a person at a place."""
    senses = Senses()
    senses.here, senses.yaw, senses.time_s = np.zeros(2), 0.0, 10.0
    where = None if place is None else np.array(place)
    senses.track = SeenTrack(where, 10.0 - unseen_s)  # type: ignore[assignment]  # all that is read
    return senses


class TestFollowing:
    @pytest.mark.parametrize(
        ("place", "action"),
        [
            ((0.0, -2.0), "stop"),
            ((0.2, -2.0), "stop"),
            ((1.0, -2.0), "turn_right"),
            ((-1.0, -2.0), "turn_left"),
            ((0.1, 2.0), "turn_right"),
        ],
    )
    def test_the_person_is_kept_in_the_middle(
        self, place: tuple[float, float], action: str
    ) -> None:
        assert follow(sensing(place)) == action

    def test_who_left_the_middle_unseen_is_looked_for(self) -> None:
        assert follow(sensing((0.0, -2.0), unseen_s=1.0)) == "stop"
        assert follow(sensing((0.0, -2.0), unseen_s=3.0)) == "turn_left"
        assert follow(sensing(None)) == "turn_left"


class TestWalkers:
    """Who walks about is watched before a view is chosen, and let pass."""

    def approaching(self, plan: OccupancyMap) -> Approach:
        senses = sensing((0.0, -2.0))
        senses.track.speed = 1.0  # type: ignore[misc]  # of a stand-in
        senses.course = circling((0.0, -3.0), 1.0)
        senses.plan = plan
        senses.num_moved = 9
        self.senses = senses
        return Approach(senses, Walk(plan))

    def test_they_are_watched_first(self, hall: OccupancyMap) -> None:
        approach = self.approaching(hall)
        actions: list[Action | None] = []
        while approach.planner_calls == 0 and len(actions) < 100:
            actions.append(approach.action())
            self.senses.time_s += 0.25
            self.senses.track.last_seen_s = self.senses.time_s  # type: ignore[misc]  # of a stand-in
        assert 4.0 < 0.25 * len(actions) < 10.0
        assert set(actions[:16]) <= {"turn_left", "turn_right"}

    def test_no_view_is_given_up_because_they_are_in_the_way(self) -> None:
        plan = whole_turn(box_room("corridor", half=4.0), (0.0, 0.0))
        approach = self.approaching(plan)
        # They walk round the robot, which knows the floor all around.
        self.senses.course = circling((0.0, 0.0), 0.5)
        self.senses.track.place_xz = np.array([0.0, -0.5])  # type: ignore[misc]  # of a stand-in
        approach._survey, approach._learn_until_s, approach._lost_way = [], 0.0, True
        for _ in range(16):
            # Wherever it would go they are.
            plan.keep_from(
                [
                    0.5 * np.array([math.sin(one), math.cos(one)])
                    for one in np.arange(0.0, 6.3, 0.4)
                ],
                self.senses.course.trodden_xz,
            )
            assert approach.action() in ("turn_left", "turn_right")
            self.senses.time_s += 0.25
            self.senses.track.last_seen_s = self.senses.time_s  # type: ignore[misc]  # of a stand-in
        assert approach._avoid == []
        assert 1 <= approach.planner_calls <= 6


def test_bumps_are_forgotten_once_where_they_leave_but_a_back_to_see() -> None:
    plan = whole_turn(box_room("hall", half=4.0), (0.0, 0.0), (3.0, -3.5), (-3.0, -3.5))
    senses, walk = sensing((0.0, -1.5)), Walk(plan)
    senses.plan, senses.course = plan, watched((0.0, -1.5), 0.0)
    for yaw in np.arange(24) * TURN:
        walk.note(senses.here, yaw, clipped=True)
    shut_in = best_view(plan, senses.here, senses.course, [])
    assert np.array_equal(shut_in.place_xz, senses.here)
    approach = Approach(senses, walk)
    approach._survey, approach._lost_way = [], True
    approach.action()
    assert approach._view is not None
    assert approach._view.place_xz[1] < -2.5
    assert not walk.forget_bumps()


def test_who_is_gone_is_searched_for_again(hall: OccupancyMap) -> None:
    senses = sensing(None)
    assert Approach(senses, Walk(hall)).action() is None


@pytest.mark.egl
class TestConformance(PolicyConformance):
    def make_policy(self) -> Policy:
        return ScanSearchFollow()

    @pytest.fixture(autouse=True)
    def _release(self, small: Release) -> None:
        self._small = small

    def make_runs(self, policy: Policy) -> list[EpisodeRun]:
        episode = self._small.episode("test", 0)
        world, navmesh = self._small.world(episode), self._small.navmesh(episode.scene_id)
        return [
            EpisodeRun(
                episode,
                world,
                navmesh,
                process_renderer(),
                policy=policy.name,
                camera=world.camera.resized(width=112, height=112),
                budget=Budget(max_actions=24),
            )
        ]


@pytest.mark.egl
def test_its_clip_shows_the_person() -> None:
    release = open_release("mini")
    episode = release.episode("test", 0)
    world = release.world(episode)
    navmesh = release.navmesh(episode.scene_id)
    policy = ScanSearchFollow()
    # The network sees no more than this of an image.
    camera = world.camera.resized(width=112, height=112)
    run = EpisodeRun(episode, world, navmesh, process_renderer(), policy=policy.name, camera=camera)
    result = run_episode(run, policy, seed=0)
    assert result.outcome == "collected"
    phases = [row["phase"] for row in result.rows]
    assert phases == sorted(phases, key=("search", "approach", "collect").index)
    # It starts 8 m off, out of sight: that takes more than a look around, and then a way.
    assert phases.count("search") > 24
    assert phases.count("approach") > 12
    last = result.rows[-1]
    position = np.array([last[f"position_{axis}_m"] for axis in "xyz"])
    pose = head_camera_pose(position, np.radians(last["yaw_deg"]), world.robot)
    samples = body_samples(world, [episode.phase_s + last["time_s"]])
    seen = visible_share(samples, pose[None, None], world.camera, scene_caster(world.scene))
    assert seen.visible[0, 0] > 0.6
