"""What clips look like: against geometry worked out by hand, rays, and the reference renderer."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from collections.abc import Iterator

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from render_scenes import (
    CAMERA,
    box,
    capsule_avatar,
    clip,
    furnished_room,
    merge,
    moving_camera,
    one_room,
    scene_of,
    standing_person,
    still_camera,
)
from scipy import ndimage

from affectsim_data.cameras import Camera, CameraTrajectory
from affectsim_data.poses import look_at
from affectsim_data.render import ClipSpec, PosedAvatar, RenderedClip, open_renderer
from affectsim_data.render.framing import BACKGROUND, body_corners, joint_boxes, screen_rectangles
from affectsim_data.render.rasterizer import EglRenderer
from affectsim_data.render.reference import PyrenderRenderer
from affectsim_data.scenes.solids import closed_solids

pytestmark = pytest.mark.egl

CACHE_BYTES = 2**28
AVATAR = capsule_avatar()


@pytest.fixture(scope="module")
def egl() -> Iterator[EglRenderer]:
    renderer = EglRenderer(cache_bytes=CACHE_BYTES)
    yield renderer
    renderer.close()


@pytest.fixture(scope="module")
def reference() -> Iterator[PyrenderRenderer]:
    renderer = PyrenderRenderer()
    yield renderer
    renderer.close()


def two_people(trajectory: CameraTrajectory, *, camera: Camera = CAMERA) -> ClipSpec:
    count = len(trajectory)
    first = standing_person(AVATAR, num_frames=count)
    second = standing_person(AVATAR, num_frames=count, at=(0.9, -1.0), yaw=1.0)
    return clip(one_room(), trajectory, first, second, camera=camera)


def digest(images: RenderedClip) -> str:
    return hashlib.sha256(images.rgb.tobytes() + images.depth.tobytes()).hexdigest()


def edges_of(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels within one of the border of `mask`, `(height, width)`."""
    return np.asarray(ndimage.binary_dilation(mask) & ~ndimage.binary_erosion(mask))


VIEWS = {
    "still": still_camera(num_frames=2),
    "moving": moving_camera(num_frames=3),
    "from above": still_camera(num_frames=2, eye=(3.2, 2.3, 3.2), target=(0.0, 0.6, 0.0)),
    "close": still_camera(num_frames=2, eye=(0.3, 1.4, 1.1), target=(0.0, 1.2, 0.0)),
}


@pytest.mark.parametrize("view", VIEWS)
def test_agrees_with_the_reference(
    egl: EglRenderer, reference: PyrenderRenderer, view: str
) -> None:
    spec = two_people(VIEWS[view])
    ours, theirs = (r.render(spec, instances=True) for r in (egl, reference))
    assert ours.instances is not None
    assert theirs.instances is not None
    np.testing.assert_array_equal(np.isfinite(ours.depth), np.isfinite(theirs.depth))
    # Both take depth at pixel centres from 24-bit buffers; single pixels on edges may differ.
    assert np.mean(np.abs(ours.depth - theirs.depth) < 0.005) >= 0.999
    for person in (1, 2):
        a, b = ours.instances == person, theirs.instances == person
        assert (a & b).sum() >= 0.985 * (a | b).sum()
    for a, b in zip(ours.instances > 0, theirs.instances > 0, strict=True):
        assert not ((a != b) & ~(edges_of(a) | edges_of(b))).any()
    # Antialiasing, texture filter and contact shadows are not the same; the colours are.
    difference = np.abs(ours.rgb.astype(int) - theirs.rgb.astype(int)).max(axis=-1)
    assert np.mean(difference) < 3.0
    assert np.mean(difference <= 8) > 0.94


def test_depth_of_a_facing_wall_is_its_distance_along_the_view_axis(egl: EglRenderer) -> None:
    scene = scene_of(box((0.0, 1.0, -3.5), (40.0, 40.0, 1.0), color=(90, 90, 90)))
    images = egl.render(clip(scene, still_camera(num_frames=1, eye=(0, 1, 2), target=(0, 1, 0))))
    # One step of the 24-bit depth buffer at 5 m is 0.03 mm.
    np.testing.assert_allclose(images.depth, 5.0, atol=1e-4)


@pytest.mark.parametrize("eye", [(0.0, 1.2, 3.4), (2.5, 0.5, 3.0), (-3.0, 2.2, -3.0)])
def test_depth_is_that_of_a_ray_through_the_pixel_centre(
    egl: EglRenderer, eye: tuple[float, float, float]
) -> None:
    scene = one_room()
    T_world_camera = look_at(eye, (0.2, 0.7, 0.1))
    images = egl.render(clip(scene, CameraTrajectory.still(T_world_camera, num_frames=1)))
    rows, columns = np.mgrid[4 : CAMERA.height : 9, 4 : CAMERA.width : 9]
    pixels = np.stack([columns.ravel(), rows.ravel()], axis=1) + 0.5
    K = CAMERA.intrinsics
    rays = np.stack(
        [
            (pixels[:, 0] - K[0, 2]) / K[0, 0],
            -(pixels[:, 1] - K[1, 2]) / K[1, 1],
            -np.ones(len(pixels)),
        ],
        axis=1,
    )
    vertices, faces = scene.mesh()
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    # A ray whose length is the depth is one at depth 1: hits are that many rays away.
    origins = np.tile(T_world_camera[:3, 3], (len(rays), 1))
    directions = rays @ T_world_camera[:3, :3].T
    places, which, _ = mesh.ray.intersects_location(origins, directions, multiple_hits=False)
    expected = np.full(len(rays), np.inf)
    expected[which] = -((places - T_world_camera[:3, 3]) @ T_world_camera[:3, :3])[:, 2]
    drawn = images.depth[0, rows.ravel(), columns.ravel()]
    # Rays through the very edge of a box may fall to either side.
    assert np.mean(np.abs(drawn - expected) < 1e-3) >= 0.998


def test_left_is_left_up_is_up_and_rows_run_down(egl: EglRenderer) -> None:
    scene = scene_of(
        box((-1.0, 1.0, -3.0), (0.5, 0.5, 0.5), color=(220, 0, 0), name="left"),
        box((1.0, 1.0, -3.0), (0.5, 0.5, 0.5), color=(0, 0, 220), name="right"),
        box((0.0, 2.0, -3.0), (0.5, 0.5, 0.5), color=(0, 220, 0), name="up"),
    )
    camera = still_camera(num_frames=1, eye=(0, 1, 0), target=(0, 1, -1))
    image = egl.render(clip(scene, camera)).rgb[0].astype(int)
    centre = {}
    for name, channel in (("left", 0), ("up", 1), ("right", 2)):
        others = [c for c in range(3) if c != channel]
        found = np.argwhere((image[..., channel] > 100) & (image[..., others] < 40).all(axis=-1))
        centre[name] = found.mean(axis=0)
    assert centre["left"][1] < 112 < centre["right"][1]
    assert centre["up"][0] < centre["left"][0] == pytest.approx(centre["right"][0], abs=0.5)
    focal = CAMERA.intrinsics[0, 0]
    # The outer edge of the right box's near face, 1.25 m right of the axis at 2.75 m.
    blue = np.argwhere((image[..., 2] > 100) & (image[..., 0] < 40))
    assert blue[:, 1].max() + 1 - 112 == pytest.approx(focal * 1.25 / 2.75, abs=1.0)


def test_a_still_camera_gives_the_same_pixels_with_and_without_its_background(
    egl: EglRenderer,
) -> None:
    redraw = EglRenderer(cache_bytes=CACHE_BYTES, reuse_background=False)
    scene = furnished_room(num_triangles=9_000, rng=np.random.default_rng(1))
    views = [VIEWS["still"], VIEWS["from above"], VIEWS["close"]]
    # The last one has the person across the near plane and behind the camera.
    views.append(still_camera(num_frames=2, eye=(0.05, 1.2, 0.1), target=(2.0, 1.0, 0.4)))
    for trajectory in views:
        person = standing_person(AVATAR, num_frames=len(trajectory))
        spec = clip(scene, trajectory, person, camera=Camera(200, 150, 1.0))
        ours, expected = (r.render(spec, instances=True) for r in (egl, redraw))
        np.testing.assert_array_equal(ours.rgb, expected.rgb)
        np.testing.assert_array_equal(ours.depth, expected.depth)
        assert ours.instances is not None
        assert expected.instances is not None
        np.testing.assert_array_equal(ours.instances, expected.instances)
    redraw.close()


@pytest.mark.parametrize("eye", [(0.0, 1.2, 3.4), (3.0, 1.9, 3.0), (-1.5, 0.4, -0.45)])
def test_leaving_out_the_backs_of_solids_changes_outlines_at_most(
    egl: EglRenderer, eye: tuple[float, float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = furnished_room(num_triangles=9_000, rng=np.random.default_rng(2))
    inside = box((-1.5, 0.4, -1.0), (0.8, 0.8, 0.8), color=(200, 40, 30), name="red")
    scene = scene_of(*scene.surfaces, inside)
    spec = clip(scene, still_camera(num_frames=1, eye=eye, target=(0.2, 0.6, 0.0)))
    ours = egl.render(spec)
    monkeypatch.setattr("affectsim_data.render.buffers.SOLID_MARGIN_M", np.inf)
    whole = egl.render(spec)
    # On an outline front and back meet at one depth, and either may have drawn a sample.
    difference = np.abs(ours.rgb.astype(int) - whole.rgb.astype(int)).max(axis=-1)
    assert np.mean(difference > 0) < 1e-3
    assert difference.max() < 64
    assert np.mean(np.abs(ours.depth - whole.depth) > 1e-3) < 1e-4


def test_closed_solids_are_told_from_sheets_and_rooms() -> None:
    solid = box((0, 1, 0), (1, 2, 1), color=(9, 9, 9), steps=3)
    far = box((5, 1, 0), (1, 2, 1), color=(9, 9, 9), steps=2)
    both = merge([solid, far], name="both")
    closed, boxes = closed_solids(both.positions.astype(float), both.faces.astype(int))
    assert closed.all()
    np.testing.assert_allclose(boxes[0], [(-0.5, 0, -0.5), (0.5, 2, 0.5)])
    np.testing.assert_allclose(boxes[-1], [(4.5, 0, -0.5), (5.5, 2, 0.5)])
    holed, _ = closed_solids(both.positions.astype(float), both.faces[1:].astype(int))
    assert holed.sum() == len(far.faces)
    inwards, _ = closed_solids(solid.positions.astype(float), solid.faces[:, ::-1].astype(int))
    assert not inwards.any()


def test_instance_ids_are_places_in_the_clip(egl: EglRenderer) -> None:
    spec = two_people(VIEWS["still"])
    swapped = ClipSpec(spec.scene, spec.people[::-1], spec.camera, spec.trajectory)
    ids, other = (egl.render(s, instances=True).instances for s in (spec, swapped))
    assert ids is not None
    assert other is not None
    assert set(np.unique(ids)) == {0, 1, 2}
    np.testing.assert_array_equal(ids, np.array([0, 2, 1], np.uint8)[other])
    assert egl.render(spec).instances is None


def test_contact_shadows_darken_the_floor_and_leave_depth_alone(egl: EglRenderer) -> None:
    trajectory = VIEWS["still"]
    empty = egl.render(clip(one_room(), trajectory))
    images = egl.render(
        clip(one_room(), trajectory, standing_person(AVATAR, num_frames=2)), instances=True
    )
    assert images.instances is not None
    scene = images.instances == 0
    np.testing.assert_array_equal(images.depth[scene], empty.depth[scene])
    away = np.stack([~ndimage.binary_dilation(~s, iterations=2) for s in scene])
    darker = images.rgb.astype(int).sum(axis=-1) < empty.rgb.astype(int).sum(axis=-1) - 20
    assert (darker & away).any(axis=(1, 2)).all()
    assert not (images.rgb.astype(int) > empty.rgb.astype(int))[away].any()


def test_nothing_in_view_is_background_at_infinity(egl: EglRenderer) -> None:
    scene = scene_of(box((0.0, 0.5, 0.0), (1.0, 1.0, 1.0), color=(200, 200, 200)))
    away = still_camera(num_frames=2, eye=(0, 1, 3), target=(0, 1, 6))
    images = egl.render(clip(scene, away, standing_person(AVATAR, num_frames=2)), instances=True)
    assert np.isposinf(images.depth).all()
    assert (images.rgb == BACKGROUND).all()
    assert images.instances is not None
    assert not images.instances.any()


def test_shapes_and_types(egl: EglRenderer) -> None:
    spec = two_people(VIEWS["moving"], camera=Camera(97, 61, 1.2))
    images = egl.render(spec, instances=True)
    assert images.rgb.shape == (3, 61, 97, 3)
    assert images.rgb.dtype == np.uint8
    assert images.depth.shape == (3, 61, 97)
    assert images.depth.dtype == np.float32
    assert images.instances is not None
    assert images.instances.shape == (3, 61, 97)
    assert images.instances.dtype == np.uint8


def test_long_clips_are_drawn_in_several_strips(
    egl: EglRenderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    specs = [two_people(VIEWS["moving"]), two_people(VIEWS["still"])]
    whole = [digest(egl.render(spec)) for spec in specs]
    monkeypatch.setattr("affectsim_data.render.targets.MAX_STRIP_BYTES", 1)
    assert [digest(egl.render(spec)) for spec in specs] == whole


def test_the_same_clip_gives_the_same_pixels_in_any_order_and_process(egl: EglRenderer) -> None:
    specs = [two_people(VIEWS[view]) for view in ("still", "moving", "close")]
    first = [digest(egl.render(spec)) for spec in specs]
    other = EglRenderer(cache_bytes=CACHE_BYTES)
    assert [digest(other.render(spec)) for spec in specs[::-1]] == first[::-1]
    other.close()
    program = (
        "from test_render import *\n"
        "renderer = EglRenderer(cache_bytes=CACHE_BYTES)\n"
        "for view in ('close', 'moving', 'still'):\n"
        "    print(digest(renderer.render(two_people(VIEWS[view]))))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.stdout.split() == first[::-1], done.stderr


def test_the_person_stays_inside_the_rectangle_that_is_redrawn() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        person = standing_person(AVATAR, num_frames=4, at=(0.3, 0.2), yaw=rng.uniform(0, 6))
        trajectory = still_camera(num_frames=4, eye=(*rng.uniform(0.6, 2.5, 2), 3.0))
        mesh = AVATAR.meshes[0]
        corners = body_corners(joint_boxes(mesh), person.joint_matrices)
        bounds = screen_rectangles(corners, CAMERA, trajectory.T_world_camera)
        points = mesh.skin(person.joint_matrices)
        tight = screen_rectangles(points, CAMERA, trajectory.T_world_camera)
        assert (bounds[:, :2] <= tight[:, :2]).all()
        assert (bounds[:, 2:] >= tight[:, 2:]).all()


def test_poses_and_frames_must_be_as_many() -> None:
    person = standing_person(AVATAR, num_frames=3)
    with pytest.raises(ValueError, match="'capsules' has 3 poses for 2 camera frames"):
        clip(one_room(), VIEWS["still"], person)


def test_joint_matrices_must_be_those_of_the_body() -> None:
    with pytest.raises(ValueError, match=r"'capsules': joint_matrices must be \(n, 22, 4, 4\)"):
        PosedAvatar(AVATAR, np.zeros((2, 21, 4, 4)))


def test_an_unknown_renderer_is_named() -> None:
    with pytest.raises(ValueError, match="'egl' or 'pyrender', got 'vulkan'"):
        open_renderer("vulkan")  # type: ignore[arg-type]
