"""The baseline's map: what depth says of a room, and ways over it."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from small_release import box_room

from affectsim_data.cameras import Camera
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Scene
from affectsim_data.simulation.policies.scan_search_follow.costing import floor_costs
from affectsim_data.simulation.policies.scan_search_follow.mapping import OccupancyMap
from affectsim_data.simulation.policies.scan_search_follow.travelling import Travel
from affectsim_data.simulation.running import Observation
from affectsim_data.visibility import scene_caster

CAMERA = Camera(width=96, height=96, hfov=math.radians(60.0))
EYE_M = 1.2
LOW_M = (EYE_M - 0.3) / (95.0 / 96.0 * math.tan(math.radians(30.0)))
"""From here on the lowest of the rows that count, at 95.5 of 96, shows things of 0.3 m."""


def look(scene: Scene, x: float, z: float, yaw: float) -> Observation:
    """What a robot that started at the origin sees of a scene, by ray casting."""
    K = CAMERA.intrinsics
    across = (np.arange(CAMERA.width) + 0.5 - K[0, 2]) / K[0, 0]
    down = (np.arange(CAMERA.height) + 0.5 - K[1, 2]) / K[1, 1]
    right = np.array([math.cos(yaw), 0.0, -math.sin(yaw)])
    ahead = np.array([-math.sin(yaw), 0.0, -math.cos(yaw)])
    rays = ahead + across[None, :, None] * right - down[:, None, None] * np.array([0.0, 1.0, 0.0])
    length = np.linalg.norm(rays, axis=-1)
    eye = np.array([x, EYE_M, z])
    reach = scene_caster(scene).distance(eye, rays / length[..., None])
    return Observation(
        rgb=np.zeros((CAMERA.height, CAMERA.width, 3), np.uint8),
        depth=(reach / length).astype(np.float32),
        position=np.array([x, 0.0, z]),
        yaw=yaw,
        camera_height_m=EYE_M,
        time_s=0.0,
        actions_left=480,
        planner_calls_left=80,
        clipped=False,
        collecting=False,
        camera=CAMERA,
    )


def whole_turn(scene: Scene, *places: tuple[float, float]) -> OccupancyMap:
    """The map after looks all round, every 15 degrees, from some places."""
    plan = OccupancyMap()
    for x, z in places:
        for turn in range(24):
            plan.add(look(scene, x, z, math.radians(15.0) * turn))
    return plan


@pytest.fixture(scope="module")
def furnished() -> Scene:
    """A room of 6 x 6 m with a column 2 m high and a table 0.7 m high, 2 m right and left."""
    boxes = [((1.8, 0.0, -0.3), (2.2, 2.0, 0.3)), ((-2.2, 0.0, -0.3), (-1.8, 0.7, 0.3))]
    return box_room("furnished", half=3.0, boxes=boxes)


@pytest.fixture(scope="module")
def plan(furnished: Scene) -> OccupancyMap:
    """Of that room, looked at from all sides."""
    return whole_turn(furnished, (0.0, 0.0), (2.4, 2.4), (2.4, -2.4), (-2.4, 2.4), (-2.4, -2.4))


def away_from_boxes(points: FloatArray) -> FloatArray:
    """Metres of points `(n, 2)` from the nearer of the furnished room's boxes."""
    off = [np.maximum(np.abs(points - (middle, 0.0)) - (0.2, 0.3), 0.0) for middle in (2.0, -2.0)]
    return np.asarray(np.minimum(*(np.hypot(*away.T) for away in off)))


def test_nothing_is_known_before_the_first_look() -> None:
    plan = OccupancyMap()
    points = np.array([[0.0, 0.0], [1.0, -3.0]])
    assert plan.unknown(points).all()
    assert np.isinf(plan.costs()).all()
    assert plan.frontiers() == []
    assert plan.path((0.0, 0.0), (1.0, 0.0)) is None


@pytest.mark.parametrize(
    ("yaw_deg", "way"),
    [(0, (0, -1)), (90, (-1, 0)), (180, (0, 1)), (-90, (1, 0)), (45, (-0.7071, -0.7071))],
)
def test_a_look_marks_the_floor_and_the_wall_it_is_turned_to(
    yaw_deg: float, way: tuple[float, float]
) -> None:
    plan, ahead = OccupancyMap(), np.array(way)
    plan.add(look(box_room("room", half=3.0), 0.0, 0.0, math.radians(yaw_deg)))
    wall = 3.0 if 0.0 in way else 3.0 * math.sqrt(2.0)
    assert plan.free(np.array([1.7, 2.2, wall - 0.3])[:, None] * ahead).all()
    # Nearer, something low could stand below the image; nothing tall does.
    assert plan.unknown(np.array([0.5, 1.4])[:, None] * ahead).all()
    assert not plan.unseen(np.array([0.5, 1.4])[:, None] * ahead).any()
    beside = np.array([-ahead[1], ahead[0]])
    off, along = np.meshgrid([-0.05, 0.0, 0.05], [-0.1, -0.05, 0.0, 0.05, 0.1])
    near_wall = wall * ahead + off.reshape(-1, 1) * ahead + along.reshape(-1, 1) * beside
    assert plan.occupied(near_wall).any()
    assert plan.unknown((wall + 0.3) * ahead)
    assert plan.unknown(-0.5 * ahead)
    assert plan.unknown(2.0 * beside)


def evidence_of(one: Observation) -> dict[tuple[int, int], int]:
    """What one look says of cells of 5 cm, pixel by pixel and step by step along every ray."""
    K, turn = CAMERA.intrinsics, one.yaw
    ahead = np.array([-math.sin(turn), -math.cos(turn)])
    right = np.array([math.cos(turn), -math.sin(turn)])
    occupied, seen, passed = set(), set(), set()
    for u in range(1, CAMERA.width, 2):
        across = float(np.float32((u + 0.5 - K[0, 2]) / K[0, 0]))
        ray = ahead + across * right

        def cell(depth: float, ray: FloatArray = ray) -> tuple[int, int]:
            x, z = (int((value + 20.0) * 20.0) for value in one.position[[0, 2]] + depth * ray)
            return min(max(z, 0), 799), min(max(x, 0), 799)

        nearest, farthest = np.float32(np.inf), np.float32(0.0)
        for v in range(1, CAMERA.height, 2):
            depth = one.depth[v, u]
            height = np.float32(EYE_M) - np.float32((v + 0.5 - K[1, 2]) / K[1, 1]) * depth
            if depth < 9.0 and abs(height) < 0.15:
                seen.add(cell(depth))
                farthest = max(farthest, depth)
            elif depth < 9.0 and 0.15 <= height < 1.5:
                occupied.add(cell(depth))
                nearest = min(nearest, depth)
        reach = min(nearest - np.float32(0.05), farthest)
        steps = np.arange(0.0, max(float(reach), 0.0), 0.04)
        passed |= {cell(depth) for depth in steps[steps >= LOW_M]}
    evidence = {one: -((one in seen - occupied) + (one in passed)) for one in seen | passed}
    return evidence | {one: evidence.get(one, 0) + 2 for one in occupied}


@pytest.mark.parametrize(
    ("half", "x", "z", "yaw_deg"),
    [
        (3.0, 0.0, 0.0, 0.0),
        (3.0, 1.0, -2.3, 100.0),
        (1.2, 0.4, 0.3, -45.0),
        (1.2, 0.0, -0.9, 0.0),
        (40.0, 19.0, 19.5, 7.0),
    ],
)
def test_evidence_is_that_of_every_pixel_and_ray(
    half: float, x: float, z: float, yaw_deg: float
) -> None:
    """Also right before a wall, where every pixel is of it, and beyond the edge of the map."""
    plan = OccupancyMap()
    one = look(box_room("room", half=half), x, z, math.radians(yaw_deg))
    plan.add(one)
    expected = evidence_of(one)
    cells = np.array(list(expected))
    points = (cells[:, ::-1] + 0.5) * 0.05 - 20.0
    signs = np.sign(list(expected.values()))
    assert np.count_nonzero(signs) > 3
    found = plan.occupied(points).astype(int) - plan.free(points).astype(int)
    np.testing.assert_array_equal(found, signs)
    grid = (np.argwhere(np.ones((800, 800)))[:, ::-1] + 0.5) * 0.05 - 20.0
    assert (~plan.unknown(grid)).sum() == np.count_nonzero(signs)


def test_points_and_cells_are_each_others_inverse() -> None:
    plan = OccupancyMap()
    assert plan.shape == (400, 400)
    assert plan.cells((0.03, 0.17)).tolist() == [201, 200]  # row along z, column along x
    assert plan.points((201, 200)) == pytest.approx([0.05, 0.15])
    cells = np.argwhere(np.ones((7, 5))) + 100
    assert np.array_equal(plan.cells(plan.points(cells)), cells)
    assert plan.cells((1e3, -1e3)).tolist() == [0, 399]


def test_the_robot_keeps_its_radius_from_walls(plan: OccupancyMap) -> None:
    costs = plan.costs()
    points = plan.points(np.argwhere(np.isfinite(costs)))
    assert np.abs(points).max() < 2.81  # the wall is at 3 m; cells are 0.1 m wide
    assert np.abs(points).max() > 2.5
    assert away_from_boxes(points).min() > 0.15
    row, column = plan.cells((0.0, 2.0))
    assert costs[row, column] == 1.0
    row, column = plan.cells((0.0, 2.65))
    assert 1.5 < costs[row, column] < 10.0


def test_where_the_robot_stands_it_can_stand() -> None:
    # 0.2 m from the wall behind it, which it does not see.
    plan = OccupancyMap()
    plan.add(look(box_room("room", half=3.0), 0.0, 2.8, 0.0))
    row, column = plan.cells((0.0, 2.8))
    assert np.isfinite(plan.costs()[row, column])


def test_room_is_the_way_to_the_nearest_thing(plan: OccupancyMap) -> None:
    points = np.array([[0.0, 0.0], [0.0, 2.0], [-1.4, 0.0], [1.82, 0.0]])
    assert plan.room(points) == pytest.approx([1.8, 1.0, 0.4, 0.0], abs=0.11)


def test_ways_keep_from_people_for_as_long_as_they_are_there(plan: OccupancyMap) -> None:
    start, goal, person = (0.0, 2.0), (0.0, -2.0), np.array([0.0, 0.5])
    before = plan.path(start, goal)
    assert before is not None
    assert len(before) == 2
    plan.keep_from([person])
    round_them = plan.path(start, goal)
    assert round_them is not None
    for one, two in itertools.pairwise(round_them):
        line = one + np.linspace(0.0, 1.0, 40)[:, None] * (two - one)
        assert np.hypot(*(line - person).T).min() > 0.55
    plan.keep_from([])
    after = plan.path(start, goal)
    assert after is not None
    assert after == pytest.approx(before)


def test_ways_go_round_where_somebody_walks_and_not_where_they_are_just_now(
    plan: OccupancyMap,
) -> None:
    start, goal = (0.0, 2.0), (0.0, -2.0)
    trodden = [np.array([x, 0.5]) for x in np.arange(-0.25, 1.3, 0.25)]
    plan.keep_from([np.array([0.25, 0.5])], trodden)
    row, column = plan.cells((0.25, 0.5))
    assert np.isfinite(plan.costs()[row, column])
    round_it = plan.path(start, goal)
    assert round_it is not None
    assert round_it[:, 0].min() < -0.5
    plan.keep_from([np.array([-1.5, 0.5])], trodden)
    row, column = plan.cells((-1.5, 0.5))
    assert np.isinf(plan.costs()[row, column])
    plan.keep_from([])


def test_where_a_move_was_cut_short_no_way_leads_until_that_is_forgotten() -> None:
    plan = whole_turn(box_room("hall", half=3.0), (0.0, 0.0))
    row, column = plan.cells((0.0, -1.8))
    before = plan.costs()[row, column]
    plan.block([[0.0, -1.8], [0.1, -1.8]])
    assert np.isinf(plan.costs()[row, column])
    plan.forget_blocks()
    assert plan.costs()[row, column] == before


def test_sight_passes_above_tables_and_not_through_columns(plan: OccupancyMap) -> None:
    seen = plan.line_of_sight([[0.0, 0.0], [0.0, 2.0]], [[2.8, 0.0], [-2.8, 0.0], [0.0, -2.5]])
    assert seen.tolist() == [[False, True, True], [True, True, True]]
    at_column = plan.line_of_sight([[0.0, 0.0]], [[1.9, 0.0]], end_gap_m=0.0)
    assert not at_column.any()
    assert plan.line_of_sight([[0.0, 0.0]], [[1.9, 0.0]], end_gap_m=0.35).all()


def test_people_are_no_furniture(furnished: Scene) -> None:
    observation = look(furnished, 0.0, 0.0, -math.pi / 2)
    assert observation.depth[:, 44:52].min() < 2.0  # the column
    people = np.zeros(observation.depth.shape, bool)
    people[:, 30:66] = True
    plan = OccupancyMap()
    plan.add(observation, people)
    assert not plan.occupied((1.82, 0.0))
    plan.add(observation)
    assert plan.occupied((1.82, 0.0))


def test_who_went_away_is_forgotten() -> None:
    empty = box_room("room", half=3.0)
    with_somebody = box_room("room", half=3.0, boxes=[((-0.2, 0.0, -2.4), (0.2, 1.7, -2.1))])
    plan = OccupancyMap()
    for _ in range(9):
        plan.add(look(with_somebody, 0.0, 0.0, 0.0))
    assert plan.occupied((0.0, -2.12))
    for _ in range(8):
        plan.add(look(empty, 0.0, 0.0, 0.0))
    assert plan.free((0.0, -2.12))
    assert plan.line_of_sight([[0.0, 0.0]], [[0.0, -2.8]], end_gap_m=0.0).all()


def test_frontiers_lie_where_a_door_leads_on() -> None:
    # A wall at z = -1 with a doorway between x = -0.5 and 0.5; looked at askew from the right.
    boxes = [((-3.0, 0.0, -1.1), (-0.5, 2.6, -1.0)), ((0.5, 0.0, -1.1), (3.0, 2.6, -1.0))]
    plan = whole_turn(box_room("two rooms", half=3.0, boxes=boxes), (0.0, 1.5))
    frontiers = plan.frontiers()
    assert frontiers
    sizes = [frontier.size for frontier in frontiers]
    assert sizes == sorted(sizes, reverse=True)
    assert frontiers[0].size > 1.0
    for frontier in frontiers[:2]:  # the two sides of the fan that is seen through the door
        assert -3.1 < frontier.centre_xz[1] < -0.9
        assert plan.free(plan.points(frontier.cells)).mean() > 0.5
        assert any(np.array_equal(plan.cells(frontier.centre_xz), cell) for cell in frontier.cells)


def test_a_room_seen_whole_has_no_long_frontier() -> None:
    assert all(
        one.size < 0.7 for one in whole_turn(box_room("room", half=2.0), (0.0, 0.0)).frontiers()
    )


def test_ways_go_round_things(plan: OccupancyMap) -> None:
    start, goal = np.array([1.0, 0.0]), np.array([2.6, 0.0])
    straight = plan.path(start, (1.0, 2.0))
    assert straight is not None
    assert straight[0] == pytest.approx(start)
    assert np.abs(straight[-1] - (1.0, 2.0)).max() <= 0.051
    round_it = plan.path(start, goal)
    assert round_it is not None
    length = float(np.hypot(*np.diff(round_it, axis=0).T).sum())
    # By hand: round the corner (1.8, 0.3) at 0.25 m and to the nearest place to stand behind it.
    assert 1.7 < length < 2.9
    for one, two in itertools.pairwise(round_it):
        line = one + np.linspace(0.0, 1.0, 40)[:, None] * (two - one)
        assert away_from_boxes(line).min() > 0.15
    row, column = plan.cells(round_it[-1])
    measured = plan.distances_from(start)[row, column]
    assert length <= measured + 0.15  # a metre costs at least 1


def test_there_is_no_way_to_what_is_not_known(plan: OccupancyMap) -> None:
    assert plan.path((0.0, 0.0), (8.0, 8.0)) is None
    row, column = plan.cells((8.0, 8.0))
    assert np.isinf(plan.distances_from((0.0, 0.0))[row, column])


def costs_of(grid: NDArray[np.bool_]) -> FloatArray:
    """1 where one can go."""
    return np.where(grid, 1.0, np.inf)


def test_travel_by_hand() -> None:
    grid = np.ones((3, 5), bool)
    grid[0:2, 2] = False
    travel = Travel(costs_of(grid), (0, 0), 0.5)
    assert travel.distances[0, 1] == pytest.approx(0.5)
    assert travel.distances[1, 1] == pytest.approx(0.5 * math.sqrt(2.0))
    # Down two, right two without cutting the corner, and up again.
    assert travel.distances[2, 2] == pytest.approx(0.5 * (math.sqrt(2.0) + 2.0))
    assert np.isinf(travel.distances[0, 2])
    bends = travel.path((0, 4))
    assert bends is not None
    assert bends[0].tolist() == [0, 0]
    assert bends[-1].tolist() == [0, 4]
    assert 2 in bends[:, 0]


def test_a_wall_without_a_gap_parts_the_grid() -> None:
    grid = np.ones((4, 9), bool)
    grid[:, 4] = False
    travel = Travel(costs_of(grid), (1, 1), 0.1)
    assert np.isinf(travel.distances[:, 5:]).all()
    # Half a metre off is near enough: the nearest cell that can be reached takes its place.
    bends = travel.path((1, 7))
    assert bends is not None
    assert bends[-1].tolist() == [1, 3]
    assert Travel(costs_of(grid), (1, 1), 1.0).path((1, 7)) is None
    assert Travel(np.full((3, 3), np.inf), (1, 1), 0.1).path((0, 0)) is None


@given(
    st.lists(st.booleans(), min_size=48, max_size=48),
    st.tuples(st.integers(0, 5), st.integers(0, 7)),
    st.tuples(st.integers(0, 5), st.integers(0, 7)),
)
def test_ways_are_as_long_there_as_back(
    cells: list[bool], one: tuple[int, int], two: tuple[int, int]
) -> None:
    grid = np.array(cells).reshape(6, 8)
    grid[one] = grid[two] = True
    there, back = (Travel(costs_of(grid), at, 0.1) for at in (one, two))
    assert there.distances[two] == pytest.approx(back.distances[one])
    assert there.distances[one] == 0.0
    reached: FloatArray = there.distances[np.isfinite(there.distances)]
    assert (reached <= 0.1 * math.sqrt(2.0) * grid.sum()).all()
    if np.isfinite(there.distances[two]):
        bends = there.path(two)
        assert bends is not None
        pulled = 0.1 * np.hypot(*np.diff(bends, axis=0).T).sum()
        assert math.dist(one, two) * 0.1 - 1e-9 <= pulled <= there.distances[two] + 1e-9


def test_a_dear_cell_is_gone_round_where_that_is_cheaper() -> None:
    costs = np.ones((7, 7))
    costs[1:6, 3] = 3.0
    # Straight on: half of two steps costs 3 a metre, so 6 + 2. Round the end: 2 + 4 diagonals.
    travel = Travel(costs, (3, 0), 1.0)
    assert travel.distances[3, 6] == pytest.approx(6.0 + 2.0)
    costs[1:6, 3] = 9.0
    travel = Travel(costs, (3, 0), 1.0)
    assert travel.distances[3, 6] == pytest.approx(6.0 * math.sqrt(2.0))
    bends = travel.path((3, 6))
    assert bends is not None
    assert (costs[bends[:, 0], bends[:, 1]] == 1.0).all()
    assert bends[:, 0].min() == 0 or bends[:, 0].max() == 6


@given(st.lists(st.sampled_from([1.0, 2.0, 5.0, np.inf]), min_size=70, max_size=70))
def test_a_string_pulled_tight_costs_hardly_more(values: list[float]) -> None:
    costs = np.array(values).reshape(7, 10)
    costs[0, 0] = costs[6, 9] = 1.0
    travel = Travel(costs, (0, 0), 0.1)
    bends = travel.path((6, 9))
    if not np.isfinite(travel.distances[6, 9]):
        return
    assert bends is not None
    spent = 0.0
    for one, two in itertools.pairwise(bends):
        line = one + np.linspace(0.0, 1.0, 2 * int(np.abs(two - one).max()) + 1)[:, None] * (
            two - one
        )
        cells = np.rint(line).astype(int)
        assert np.isfinite(costs[cells[:, 0], cells[:, 1]]).all()
        spent += 0.1 * math.dist(one, two) * float(costs[cells[:, 0], cells[:, 1]].mean())
    assert spent <= 1.25 * travel.distances[6, 9] + 1e-9


class TestCosts:
    def floor(self, evidence: int, room_m: float, **near: bool) -> float:
        """Cost of one cell."""
        cell = np.full((1, 2, 1, 2), evidence, np.int8)
        flags = {name: np.array([[near.get(name, False)]]) for name in ("beside", "wary")}
        return float(floor_costs(cell, cell == 0, np.array([[room_m]]), **flags)[0, 0])

    def test_less_room_costs_more_and_too_little_is_no_way(self) -> None:
        for evidence in (-2, 0):
            costs = [self.floor(evidence, room_m) for room_m in (1.0, 0.5, 0.4, 0.33, 0.28, 0.25)]
            assert costs == sorted(costs)
            assert np.isinf(self.floor(evidence, 0.24))
        assert self.floor(-1, 1.0) == 1.0

    def test_floor_not_seen_costs_more_and_most_where_something_was_in_the_way(self) -> None:
        assert self.floor(-1, 0.5) < self.floor(0, 0.5) < self.floor(0, 0.5, wary=True)
        assert self.floor(-1, 0.5) == self.floor(-1, 0.5, wary=True)

    def test_the_robot_squeezes_only_where_it_was(self) -> None:
        assert np.isinf(self.floor(-1, 0.22))
        assert np.isfinite(self.floor(-1, 0.22, beside=True))
        assert np.isinf(self.floor(-1, 0.19, beside=True))

    def test_nobody_stands_on_things_or_on_what_is_not_known(self) -> None:
        assert np.isinf(self.floor(1, 1.0))
        unknown = np.zeros((1, 2, 1, 2), np.int8)
        nowhere = np.zeros((1, 1), bool)
        costs = floor_costs(unknown, unknown > 0, np.ones((1, 1)), beside=nowhere, wary=nowhere)
        assert np.isinf(costs[0, 0])
