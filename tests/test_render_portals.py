"""Leaving out rooms that cannot be seen through doorways: the same pixels, fewer triangles."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from render_scenes import (
    CEILING_M,
    DOORWAY_M,
    ROOM_M,
    WALL_M,
    capsule_avatar,
    clip,
    flat_of_rooms,
    one_room,
    standing_person,
)

from affectsim_data.cameras import Camera, CameraTrajectory
from affectsim_data.poses import FloatArray, invert_pose, look_at
from affectsim_data.render import RenderedClip
from affectsim_data.render.framing import FAR_M, NEAR_M, visible_boxes
from affectsim_data.render.portals import WINDOW_MARGIN, Portals
from affectsim_data.render.rasterizer import EglRenderer
from affectsim_data.scenes import Room, Scene

FLAT = flat_of_rooms(rng=np.random.default_rng(4))
WIDE = Camera(width=96, height=72, hfov=np.deg2rad(100.0))
EYE_Y = 1.2
STEP_M = ROOM_M + WALL_M
R0 = (-STEP_M / 2, EYE_Y, -STEP_M / 2)
"""The middle of room `r0`."""
Point = tuple[float, float, float]


@pytest.fixture(scope="module")
def egl() -> Iterator[EglRenderer]:
    renderer = EglRenderer(cache_bytes=2**28)
    yield renderer
    renderer.close()


def windows(scene: Scene, eye: Point, target: Point, camera: Camera = WIDE) -> FloatArray | None:
    """What `Portals` says of one camera."""
    pose = look_at(eye, target)
    clip_from_view = camera.projection_matrix(near=NEAR_M, far=FAR_M)
    matrices = (clip_from_view @ invert_pose(pose))[None]
    return Portals(scene).windows(matrices, np.array([eye], np.float64))[0]


def seen(scene: Scene, eye: Point, target: Point, camera: Camera = WIDE) -> set[str]:
    """Rooms that can be seen."""
    found = windows(scene, eye, target, camera)
    assert found is not None
    return {room.room_id for room, w in zip(scene.rooms, found, strict=False) if w[0] < w[2]}


def both_ways(
    egl: EglRenderer, trajectory: CameraTrajectory, camera: Camera = WIDE
) -> tuple[RenderedClip, RenderedClip]:
    """With rooms left out, and with everything in the frustum drawn."""
    person = standing_person(BODY, num_frames=len(trajectory), at=(2.2, 2.0))
    spec = clip(FLAT, trajectory, person, camera=camera)
    ours = egl.render(spec)
    with patch.object(Portals, "windows", lambda _, matrices, eyes: [None] * len(eyes)):
        return ours, egl.render(spec)


BODY = capsule_avatar(rings=3, sides=6)
REACH_M = ROOM_M + WALL_M + 0.4
places = st.tuples(
    st.floats(-REACH_M, REACH_M), st.floats(0.05, CEILING_M + 0.2), st.floats(-REACH_M, REACH_M)
)
"""In rooms, walls, doorways and furniture, above the ceiling and outside."""


@pytest.mark.egl
@settings(max_examples=40)
@given(
    eyes=st.lists(places, min_size=4, max_size=4),
    yaw=st.floats(-np.pi, np.pi),
    rise=st.floats(-0.6, 0.6),
    hfov_deg=st.floats(40.0, 120.0),
)
def test_pixels_are_those_of_everything_drawn(
    egl: EglRenderer, eyes: list[Point], yaw: float, rise: float, hfov_deg: float
) -> None:
    angles = yaw + np.arange(len(eyes)) * np.pi / 2
    away = np.stack([np.sin(angles), np.full(len(eyes), rise), np.cos(angles)], axis=1)
    path = CameraTrajectory(look_at(np.array(eyes), np.array(eyes) + away))
    ours, whole = both_ways(egl, path, Camera(96, 72, float(np.deg2rad(hfov_deg))))
    np.testing.assert_array_equal(ours.rgb, whole.rgb)
    np.testing.assert_array_equal(ours.depth, whole.depth)


@pytest.mark.egl
def test_pixels_are_those_of_everything_drawn_on_a_walk_through_all_doorways(
    egl: EglRenderer,
) -> None:
    half = STEP_M / 2
    corners = np.array(
        [(-half, -1.1 - half), (half, -1.1 - half), (half - 0.4, half + 0.7),
         (1.2 - half, half + 0.7), (1.2 - half, -half)]
    )  # fmt: skip
    steps = np.linspace(0.0, len(corners) - 1.0, 60)
    at = np.stack([np.interp(steps, np.arange(len(corners)), corners[:, k]) for k in (0, 1)])
    eye = np.stack([at[0], np.full(len(steps), EYE_Y), at[1]], axis=1)
    ahead = np.roll(eye, -3, axis=0) + np.array([0.0, -0.1, 0.02])
    ours, whole = both_ways(egl, CameraTrajectory(look_at(eye, ahead)))
    np.testing.assert_array_equal(ours.rgb, whole.rgb)
    np.testing.assert_array_equal(ours.depth, whole.depth)


def test_rooms_out_of_sight_are_left_out() -> None:
    # Towards the outer wall: nothing else. Towards the doorway to r1: r1, but not what is beyond.
    assert seen(FLAT, R0, (-9.0, EYE_Y, R0[2])) == {"r0"}
    through = (0.0, EYE_Y, R0[2] - 1.1)
    assert seen(FLAT, (-3.0, EYE_Y, R0[2] - 1.1), through, Camera(90, 90, 0.6)) == {"r0", "r1"}
    chunks = FLAT.chunks
    assert chunks is not None
    assert set(chunks.room.tolist()) == {-1, 0, 1, 2, 3}
    eye, target = R0, (-9.0, EYE_Y, R0[2] + 9.0)
    matrix = WIDE.projection_matrix(near=NEAR_M, far=FAR_M) @ invert_pose(look_at(eye, target))
    found = windows(FLAT, eye, target)
    assert found is not None
    place = np.array(eye)
    drawn = visible_boxes(chunks.low, chunks.high, matrix, place, found[chunks.room])
    everything = visible_boxes(chunks.low, chunks.high, matrix, place)
    assert set(drawn) < set(everything)
    assert set(chunks.room[drawn]) == {-1, 0}


def test_a_room_is_seen_where_its_doorway_is() -> None:
    camera = Camera(100, 100, float(np.pi / 2))
    eye = (-3.1, 1.0, R0[2] - 1.1)
    found = windows(FLAT, eye, (0.0, 1.0, eye[2]), camera)
    assert found is not None
    np.testing.assert_array_equal(found[0], (-1.0, -1.0, 1.0, 1.0))
    np.testing.assert_array_equal(found[-1], found[0])
    # The far end of the hole is 3.2 m away, and at 90 degrees a metre there is 1 / 3.2 wide.
    width, height = DOORWAY_M
    margin = 0.06
    half, top = width / 2 + margin, height - 1.0 + margin
    low, high = (np.array([-half, -1.0 - margin]), np.array([half, top]))
    expected = np.concatenate([low / 3.2 - WINDOW_MARGIN, high / 3.2 + WINDOW_MARGIN])
    np.testing.assert_allclose(found[1], expected, atol=1e-9)


@pytest.mark.parametrize(
    ("eye", "where"),
    [
        ((0.0, EYE_Y, R0[2] - 1.1), "in a doorway"),
        ((0.0, EYE_Y, 1.0), "in a wall"),
        ((-0.13, EYE_Y, 1.0), "so near to a wall that the near plane cuts into it"),
        ((9.0, EYE_Y, 0.0), "outside"),
        ((1.0, CEILING_M + 0.1, 1.0), "above the ceiling"),
    ],
)
def test_a_camera_that_is_in_no_room_has_everything_drawn(eye: Point, where: str) -> None:
    assert windows(FLAT, eye, (eye[0] + 1.0, eye[1], eye[2])) is None, where


def test_a_doorway_to_no_room_leads_outside_from_where_all_can_be_seen() -> None:
    front, *others = FLAT.doorways
    outwards = dataclasses.replace(front, room_ids=("r0", "street"))
    scene = dataclasses.replace(FLAT, doorways=(outwards, *others))
    towards = (0.0, EYE_Y, R0[2] - 1.1)
    assert windows(scene, R0, towards) is None
    assert seen(scene, R0, (-9.0, EYE_Y, R0[2])) == {"r0"}


def test_without_doorways_everything_is_drawn() -> None:
    assert windows(dataclasses.replace(FLAT, doorways=()), R0, (0.0, EYE_Y, 0.0)) is None
    assert windows(one_room(), (0.0, EYE_Y, 3.0), (0.0, EYE_Y, 0.0)) is None


def test_too_many_ways_through_doorways_end_in_drawing_everything() -> None:
    # The same hole twenty times over: more ways than could ever be followed.
    scene = dataclasses.replace(FLAT, doorways=FLAT.doorways[:1] * 20)
    assert windows(scene, R0, (0.0, EYE_Y, R0[2] - 1.1)) is None


def test_rooms_that_overlap_are_all_seen_from_where_they_do() -> None:
    corners = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))
    centred = tuple((x + R0[0], z + R0[2]) for x, z in corners)
    nook = Room("nook", "dining", centred, ceiling_y=CEILING_M)
    scene = dataclasses.replace(FLAT, rooms=(*FLAT.rooms, nook))
    assert seen(scene, R0, (-9.0, EYE_Y, R0[2])) == {"r0", "nook"}
    assert seen(scene, (-3.8, EYE_Y, R0[2]), (-9.0, EYE_Y, R0[2])) == {"r0"}
