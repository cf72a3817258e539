"""The baseline's map: what depth says of a room, and ways over it."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_release import box_room

from affectsim_data.cameras import Camera
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Scene
from affectsim_data.simulation.policies.scan_search_follow.mapping import OccupancyMap
from affectsim_data.simulation.policies.scan_search_follow.travelling import Travel
from affectsim_data.simulation.running import Observation
from affectsim_data.visibility import scene_caster

CAMERA = Camera(width=96, height=96, hfov=math.radians(60.0))
EYE_M = 1.2


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
    assert not plan.travelable().any()
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
    assert plan.free(np.array([0.5, 1.5, wall - 0.3])[:, None] * ahead).all()
    beside = np.array([-ahead[1], ahead[0]])
    off, along = np.meshgrid([-0.05, 0.0, 0.05], [-0.1, -0.05, 0.0, 0.05, 0.1])
    near_wall = wall * ahead + off.reshape(-1, 1) * ahead + along.reshape(-1, 1) * beside
    assert plan.occupied(near_wall).any()
    assert plan.unknown((wall + 0.3) * ahead)
    assert plan.unknown(-0.5 * ahead)
    assert plan.unknown(2.0 * beside)


def test_points_and_cells_are_each_others_inverse() -> None:
    plan = OccupancyMap()
    assert plan.shape == (400, 400)
    assert plan.cells((0.03, 0.17)).tolist() == [201, 200]  # row along z, column along x
    assert plan.points((201, 200)) == pytest.approx([0.05, 0.15])
    cells = np.argwhere(np.ones((7, 5))) + 100
    assert np.array_equal(plan.cells(plan.points(cells)), cells)
    assert plan.cells((1e3, -1e3)).tolist() == [0, 399]


def test_the_robot_keeps_its_radius_from_walls(plan: OccupancyMap) -> None:
    points = plan.points(np.argwhere(plan.travelable(0.3)))
    assert np.abs(points).max() < 2.76  # the wall is at 3 m; cells are 0.1 m wide
    assert np.abs(points).max() > 2.5
    assert away_from_boxes(points).min() > 0.2
    assert len(points) > len(np.argwhere(plan.travelable(0.5))) > 0


def test_where_the_robot_stands_it_can_stand() -> None:
    # 0.2 m from the wall behind it, which it does not see.
    plan = OccupancyMap()
    plan.add(look(box_room("room", half=3.0), 0.0, 2.8, 0.0))
    row, column = plan.cells((0.0, 2.8))
    assert plan.travelable(0.4)[row, column]


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
    round_it = plan.path(start, goal, 0.25)
    assert round_it is not None
    length = float(np.hypot(*np.diff(round_it, axis=0).T).sum())
    # By hand: round the corner (1.8, 0.3) at 0.25 m and to the nearest place to stand behind it.
    assert 1.7 < length < 2.6
    for one, two in itertools.pairwise(round_it):
        line = one + np.linspace(0.0, 1.0, 40)[:, None] * (two - one)
        assert away_from_boxes(line).min() > 0.15
    row, column = plan.cells(round_it[-1])
    measured = plan.distances_from(start, 0.25)[row, column]
    assert length <= measured + 0.15  # a string pulled tight is no longer than the chain of cells


def test_there_is_no_way_to_what_is_not_known(plan: OccupancyMap) -> None:
    assert plan.path((0.0, 0.0), (8.0, 8.0)) is None
    row, column = plan.cells((8.0, 8.0))
    assert np.isinf(plan.distances_from((0.0, 0.0))[row, column])


def test_travel_by_hand() -> None:
    grid = np.ones((3, 5), bool)
    grid[0:2, 2] = False
    travel = Travel(grid, (0, 0), 0.5)
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
    travel = Travel(grid, (1, 1), 0.1)
    assert np.isinf(travel.distances[:, 5:]).all()
    # Half a metre off is near enough: the nearest cell that can be reached takes its place.
    bends = travel.path((1, 7))
    assert bends is not None
    assert bends[-1].tolist() == [1, 3]
    assert Travel(grid, (1, 1), 1.0).path((1, 7)) is None
    assert Travel(np.zeros((3, 3), bool), (1, 1), 0.1).path((0, 0)) is None


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
    there, back = Travel(grid, one, 0.1), Travel(grid, two, 0.1)
    assert there.distances[two] == pytest.approx(back.distances[one])
    assert there.distances[one] == 0.0
    reached: FloatArray = there.distances[np.isfinite(there.distances)]
    assert (reached <= 0.1 * math.sqrt(2.0) * grid.sum()).all()
    if np.isfinite(there.distances[two]):
        bends = there.path(two)
        assert bends is not None
        pulled = 0.1 * np.hypot(*np.diff(bends, axis=0).T).sum()
        assert math.dist(one, two) * 0.1 - 1e-9 <= pulled <= there.distances[two] + 1e-9
