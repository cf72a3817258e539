"""The baseline's eyes: change, the person network, sightings and the track through them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from affectsim_data.cameras import Camera
from affectsim_data.content import content_path
from affectsim_data.poses import FloatArray
from affectsim_data.releases import Release, open_release
from affectsim_data.simulation.policies.scan_search_follow.bodies import median, span
from affectsim_data.simulation.policies.scan_search_follow.changing import ChangeMemory
from affectsim_data.simulation.policies.scan_search_follow.grading import grade_network
from affectsim_data.simulation.policies.scan_search_follow.person_network import (
    CELLS,
    INPUT_SIZE,
    WEIGHTS,
    PersonNetwork,
    find_people,
    load_person_network,
    network_images,
    read_person_network,
    save_person_network,
)
from affectsim_data.simulation.policies.scan_search_follow.person_views import (
    PersonViews,
    body_facing,
    draw_views,
)
from affectsim_data.simulation.policies.scan_search_follow.seeing import (
    PersonFinder,
    Sighting,
)
from affectsim_data.simulation.policies.scan_search_follow.tracking import PersonTrack
from affectsim_data.simulation.policies.scan_search_follow.training import train_person_network
from affectsim_data.simulation.running import EpisodeRun, Observation
from affectsim_data.skeletons import JOINT_NAMES

CAMERA = Camera(width=112, height=112, hfov=math.radians(60.0))
FOCAL = 56.0 / math.tan(math.radians(30.0))
EYE_M = 1.2


def observation(
    *boards: tuple[float, float, float, float],
    yaw: float = 0.0,
    x: float = 0.0,
    z: float = 0.0,
    time_s: float = 0.0,
) -> Observation:
    """An empty world with boards in it that face the camera.

    Args:
        boards: Left edge and right edge to the right of the camera, depth and top, metres each.
        yaw: Of the robot.
        x: Of the robot.
        z: Of the robot.
        time_s: Of the look.
    """
    along = (np.arange(112) + 0.5 - 56.0) / FOCAL
    depth = np.full((112, 112), 8.0, np.float32)
    floor = np.where(along > 0, EYE_M / np.maximum(along, 1e-9), np.inf)[:, None]
    depth = np.minimum(depth, floor).astype(np.float32)
    rgb = np.full((112, 112, 3), 180, np.uint8)
    for left, right, away, top in boards:
        height = EYE_M - along[:, None] * away
        inside = (height >= 0.0) & (height <= top)
        inside = inside & (along * away >= left) & (along * away <= right) & (away < depth)
        depth[inside] = away
        rgb[inside] = (120, 40, 40)
    return Observation(
        rgb=rgb,
        depth=depth,
        position=np.array([x, 0.0, z]),
        yaw=yaw,
        camera_height_m=EYE_M,
        time_s=time_s,
        actions_left=480,
        planner_calls_left=80,
        clipped=False,
        collecting=False,
        camera=CAMERA,
    )


class RedNetwork(PersonNetwork):
    """Takes everything red for a person whose body faces so far from the camera."""

    def __init__(self, angle: float = 0.0) -> None:
        super().__init__()
        self._angle = angle

    def forward(self, images: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        red = (images[:, 0] - images[:, 1] > 0.3).float()
        cells = torch.nn.functional.avg_pool2d(red, INPUT_SIZE // CELLS)
        turned = torch.tensor([math.cos(self._angle), math.sin(self._angle)])
        return 12.0 * cells - 6.0, turned[:, None, None].expand(len(cells), 2, CELLS, CELLS)


def sighting(x: float, z: float, confidence: float = 0.9, facing: float | None = None) -> Sighting:
    return Sighting(
        place_xz=np.array([x, z]),
        height_m=1.7,
        width_m=0.5,
        distance_m=math.hypot(x, z),
        bearing=0.0,
        confidence=confidence,
        moved=False,
        facing_yaw=facing,
        cut=False,
    )


def looks(track: PersonTrack, *each: list[Sighting], start_s: float = 0.0) -> None:
    """A look every quarter of a second."""
    for step, sightings in enumerate(each):
        track.update(sightings, observation(time_s=start_s + step / 4.0))


def place(track: PersonTrack) -> FloatArray | None:
    return track.place_xz


def stable(track: PersonTrack) -> bool:
    return track.is_stable


@pytest.mark.parametrize("decimals", [1, 7])
def test_medians_and_spans_are_those_of_numpy_to_the_last_bit(decimals: int) -> None:
    rng = np.random.default_rng(0)
    for count in [1, 2, 3, *rng.integers(12, 2000, 200).tolist()]:
        values = rng.normal(1.0, 1.0, count).round(decimals).astype(np.float32)
        assert median(values) == float(np.median(values))
        assert span(values) == tuple(np.percentile(values, [3, 97]))
    assert math.isnan(median(np.zeros(0, np.float32)))


def test_the_first_look_has_nothing_to_compare() -> None:
    memory = ChangeMemory()
    assert memory.changed(observation()) is None
    assert memory.changed(observation()) is not None
    assert memory.changed(observation(x=0.25)) is None  # somewhere else


def test_what_came_has_changed_and_what_left_has_not() -> None:
    memory, somebody = ChangeMemory(), (-0.25, 0.25, 3.0, 1.7)
    memory.changed(observation())
    came = memory.changed(observation(somebody))
    assert came is not None
    on_board = observation(somebody).depth == 3.0
    assert came[on_board].mean() > 0.9
    assert not came[~on_board].any()
    memory = ChangeMemory()
    memory.changed(observation(somebody))
    left = memory.changed(observation())
    assert left is not None
    # But for where the feet were: there the floor that came into sight is as far away as they.
    above_floor = left[: round(56.0 + FOCAL * (EYE_M - 0.15) / 3.0)]
    assert not above_floor.any()
    assert left.mean() < 0.01


@pytest.mark.parametrize("turn_deg", [15, -15, 30])
def test_turning_is_no_change(turn_deg: int) -> None:
    """A cylinder of wall round the robot, striped by direction, seen from two yaws."""

    def inside(yaw: float) -> Observation:
        across = (np.arange(112) + 0.5 - 56.0) / FOCAL
        depth = np.broadcast_to(3.0 / np.sqrt(1.0 + across**2), (112, 112)).astype(np.float32)
        direction = yaw - np.arctan(across)
        stripes = (100 + 60 * np.sin(6.0 * direction)).astype(np.uint8)
        rgb = np.repeat(np.broadcast_to(stripes, (112, 112))[..., None], 3, axis=2)
        empty = observation(yaw=yaw)
        return Observation(**{**vars(empty), "rgb": rgb, "depth": depth})

    memory = ChangeMemory()
    memory.changed(inside(0.0))
    changed = memory.changed(inside(math.radians(turn_deg)))
    assert changed is not None
    assert changed.mean() < 0.001
    unturned = ChangeMemory()
    unturned.changed(inside(0.0))
    # The control: the same stripes shifted without the turn that explains it are a change.
    shifted = Observation(**{**vars(inside(math.radians(turn_deg))), "yaw": 0.0})
    wrong = unturned.changed(shifted)
    assert wrong is not None
    assert wrong.mean() > 0.2


def test_a_person_is_measured() -> None:
    finder = PersonFinder(RedNetwork())
    (found,) = finder.update(observation((0.75, 1.25, 3.0, 1.7)))
    assert found.place_xz == pytest.approx([1.0, -3.0], abs=0.2)  # and half a body behind it
    assert found.place_xz[1] < -3.05
    assert found.height_m == pytest.approx(1.7, abs=0.06)
    assert found.width_m == pytest.approx(0.5, abs=0.08)
    assert found.bearing == pytest.approx(-math.atan2(1.0, 3.0), abs=0.02)
    assert found.confidence > 0.9
    assert not found.cut
    pixels = finder.person_pixels
    assert pixels is not None
    board = observation((0.75, 1.25, 3.0, 1.7)).depth == 3.0
    assert pixels[board].mean() > 0.85


def test_places_are_in_the_starting_frame() -> None:
    board = (-0.25, 0.25, 3.0, 1.7)
    turned = observation(board, yaw=math.pi / 2, x=2.0, z=-1.0)
    (found,) = PersonFinder(RedNetwork()).update(turned)
    assert found.place_xz == pytest.approx([2.0 - 3.12, -1.0], abs=0.06)


@pytest.mark.parametrize(
    ("angle", "yaw", "facing"),
    [(0.0, 0.0, math.pi), (math.pi / 2, 0.0, -math.pi / 2), (0.0, math.pi / 2, -math.pi / 2)],
)
def test_facing_is_told_from_the_camera_on(angle: float, yaw: float, facing: float) -> None:
    finder = PersonFinder(RedNetwork(angle))
    (found,) = finder.update(observation((-0.25, 0.25, 3.0, 1.7), yaw=yaw))
    assert found.facing_yaw is not None
    assert abs(math.remainder(found.facing_yaw - facing, 2 * math.pi)) < 0.05


def test_two_people_are_two() -> None:
    finder = PersonFinder(RedNetwork())
    apart = finder.update(observation((-0.9, -0.4, 3.0, 1.7), (0.4, 0.9, 3.0, 1.6)))
    assert sorted(round(float(one.place_xz[0]), 1) for one in apart) == [-0.7, 0.7]
    behind = finder.update(observation((-0.3, 0.1, 2.5, 1.6), (0.1, 0.6, 4.0, 1.7)))
    assert sorted(round(float(-one.place_xz[1])) for one in behind) == [3, 4]


@pytest.mark.parametrize(
    "board", [(-1.6, 1.6, 3.5, 1.7), (-0.25, 0.25, 3.0, 0.3), (-0.03, 0.03, 2.0, 1.7)]
)
def test_what_is_no_persons_size_is_nobody(board: tuple[float, float, float, float]) -> None:
    assert PersonFinder(RedNetwork()).update(observation(board)) == ()


def test_change_makes_a_sighting_surer() -> None:
    class Unsure(RedNetwork):
        def forward(self, images: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
            logits, facing = super().forward(images)
            return logits.clamp(max=0.0), facing

    finder, somebody = PersonFinder(Unsure()), (-0.25, 0.25, 3.0, 1.7)
    finder.update(observation())
    (moved,) = finder.update(observation(somebody))
    (still,) = PersonFinder(Unsure()).update(observation(somebody))
    assert moved.moved
    assert not still.moved
    assert moved.confidence > still.confidence + 0.1


def test_bodies_face_across_their_hips_and_shoulders() -> None:
    joints = np.zeros((2, len(JOINT_NAMES), 3))
    for part in ("hip", "shoulder"):
        joints[0, JOINT_NAMES.index(f"left_{part}")] = (-0.2, 1.0, 0.0)  # looks along -Z
        joints[1, JOINT_NAMES.index(f"left_{part}")] = (0.0, 1.0, 0.2)  # looks along -X
    assert body_facing(joints) == pytest.approx([0.0, math.pi / 2])


def test_the_network_is_shown_heights_and_nearness() -> None:
    depth = torch.full((1, INPUT_SIZE, INPUT_SIZE), 2.0)
    depth[0, :, 0] = torch.inf
    rgb = torch.zeros(1, 3, INPUT_SIZE, INPUT_SIZE, dtype=torch.uint8)
    images = network_images(rgb, depth, vfov=math.radians(60.0), camera_height_m=1.2)
    assert images.shape == (1, 5, INPUT_SIZE, INPUT_SIZE)
    assert images.isfinite().all()
    assert images[0, 3, 50, 50] == pytest.approx(0.5)
    # The horizon is at the camera's height, the image's border one half of 2.31 m lower at 2 m.
    assert images[0, 4, 55:57, 50].mean() == pytest.approx(0.2, abs=1e-4)
    assert images[0, 4, -1, 50] == pytest.approx(0.2 - 1.1547 * 111 / 112, abs=1e-3)


def test_a_track_is_stable_after_three_of_four_looks() -> None:
    track = PersonTrack()
    assert place(track) is None
    assert track.confidence == 0.0
    looks(track, [sighting(0.0, -3.0)], [], [sighting(0.1, -3.0)])
    assert not stable(track)
    looks(track, [sighting(0.2, -3.0)], start_s=0.75)
    assert stable(track)
    assert track.last_seen_s == 0.75
    assert place(track) == pytest.approx([0.2, -3.0])
    looks(track, [], [], start_s=1.0)
    assert not stable(track)
    assert track.last_seen_s == 0.75


def test_sightings_far_from_each_other_are_not_stable() -> None:
    track = PersonTrack()
    looks(track, *[[sighting(0.7 * step, -3.0)] for step in range(4)])
    assert track.last_seen_s == 0.75
    assert not stable(track)


def test_a_track_keeps_to_its_person() -> None:
    track = PersonTrack()
    looks(track, *[[sighting(0.0, -3.0, 0.8)]] * 4)
    both = [sighting(1.5, -2.0, 0.99), sighting(0.1, -3.0, 0.6)]
    looks(track, both, [sighting(1.5, -2.0, 0.99)], start_s=1.0)
    assert place(track) == pytest.approx([0.1, -3.0])


def test_a_doubtful_track_gives_way_to_a_surer_one() -> None:
    track = PersonTrack()
    looks(track, [sighting(0.0, -3.0, 0.55)], [sighting(2.0, -2.0, 0.95)])
    assert place(track) == pytest.approx([2.0, -2.0])


def test_who_went_over_to_a_thing_comes_back_to_somebody_surer() -> None:
    track = PersonTrack()
    looks(track, *[[sighting(0.0, -3.0, 0.97)]] * 4)
    thing = (1.2, -2.5)
    looks(track, [sighting(*thing, 0.8)], *[[sighting(*thing, 0.55)]] * 3, start_s=4.0)
    assert place(track) == pytest.approx(thing)
    looks(track, [sighting(0.0, -3.0, 0.99), sighting(*thing, 0.6)], start_s=5.0)
    assert place(track) == pytest.approx([0.0, -3.0])


def test_weak_sightings_begin_no_track_but_go_on_with_one() -> None:
    track = PersonTrack()
    looks(track, [sighting(0.0, -3.0, 0.45)])
    assert place(track) is None
    looks(track, [sighting(0.0, -3.0, 0.7)], [sighting(0.2, -3.0, 0.45)])
    assert place(track) == pytest.approx([0.2, -3.0])


def test_who_is_not_where_they_should_be_seen_was_nobody() -> None:
    track = PersonTrack()
    looks(track, [sighting(0.0, -3.0, 0.6)], [], [])
    assert place(track) is not None
    looks(track, [], start_s=0.75)
    assert place(track) is None
    behind = PersonTrack()  # out of view, so that it says nothing not to see them
    looks(behind, [sighting(0.0, 3.0, 0.6)], *[[]] * 6)
    assert place(behind) is not None


def test_who_walks_faces_where_they_go() -> None:
    track = PersonTrack()
    looks(track, *[[sighting(0.2 * step, -3.0)] for step in range(5)])
    assert track.speed == pytest.approx(0.8)
    assert track.facing_yaw == pytest.approx(-math.pi / 2)  # along +X
    looks(track, [sighting(1.0, -3.0, facing=0.3)], start_s=1.25)
    assert track.facing_yaw == pytest.approx(0.3)  # what is seen of the body counts more


def test_shipped_weights_are_small_and_whole() -> None:
    path = content_path("builders", WEIGHTS)
    assert path.stat().st_size < 400_000
    network = load_person_network()
    assert not network.training
    assert all(value.isfinite().all() for value in network.state_dict().values())


def test_weights_come_back_as_they_were_written(tmp_path: Path) -> None:
    torch.manual_seed(1)
    network = PersonNetwork().eval()
    save_person_network(network, tmp_path / "new" / "w.safetensors", {"views": 1})
    again = read_person_network(tmp_path / "new" / "w.safetensors")
    for key, value in network.state_dict().items():
        assert torch.allclose(again.state_dict()[key].float(), value.float(), atol=1e-3), key


def test_bad_weights_are_named(tmp_path: Path) -> None:
    from safetensors.torch import save_file

    with pytest.raises(
        FileNotFoundError, match=r"no\.safetensors: no such file of weights; python"
    ):
        read_person_network(tmp_path / "no.safetensors")
    (tmp_path / "text").write_text("hello")
    with pytest.raises(ValueError, match="text: must be a file in safetensors"):
        read_person_network(tmp_path / "text")
    save_file({"a": torch.zeros(1)}, str(tmp_path / "other"))
    with pytest.raises(ValueError, match=r"must be weights of a PersonNetwork .* got format None"):
        read_person_network(tmp_path / "other")
    save_file(
        {"a": torch.zeros(1)},
        str(tmp_path / "odd"),
        metadata={"format": "affectsim-person-network-2"},
    )
    with pytest.raises(ValueError, match="odd: weights do not fit the network"):
        read_person_network(tmp_path / "odd")


def test_the_answer_does_not_depend_on_the_number_of_threads() -> None:
    rng = np.random.default_rng(0)
    rgb: NDArray[np.uint8] = rng.integers(0, 256, (224, 224, 3), np.uint8)
    depth = rng.uniform(1.0, 6.0, (224, 224)).astype(np.float32)
    before, answers = torch.get_num_threads(), []
    try:
        for threads in (1, 2):
            torch.set_num_threads(threads)
            answers.append(find_people(load_person_network(), rgb, depth, CAMERA, EYE_M))
            assert torch.get_num_threads() == threads
    finally:
        torch.set_num_threads(before)
    assert np.array_equal(answers[0].share, answers[1].share)


@pytest.mark.egl
def test_the_shipped_network_finds_people_it_was_not_trained_on(small: Release) -> None:
    from affectsim_data.render import process_renderer

    for split in ("train", "test"):
        episode = small.episode(split, 0)
        navmesh = small.navmesh(episode.scene_id)
        run = EpisodeRun(episode, small.world(episode), navmesh, process_renderer(), policy="look")
        pelvis = run.people(0.0)[0] - np.array(episode.start_position)
        truth = _in_starting_frame(pelvis, episode.start_yaw)
        found = PersonFinder().update(run.observe())
        assert found, split
        assert found[0].place_xz == pytest.approx(truth, abs=0.4), split


@pytest.mark.egl
def test_views_carry_their_truth_and_can_be_learned_from(small_release_path: Path) -> None:
    release = open_release(small_release_path)
    views = draw_views(
        release, "train", num_views=6, views_per_episode=6, rng=np.random.default_rng(0)
    )
    assert len(views) == 6
    assert views.rgb.shape == (6, INPUT_SIZE, INPUT_SIZE, 3)
    share = views.share.astype(np.float32)
    assert 0.0 <= share.min() <= share.max() <= 1.0
    assert (share.max(axis=(1, 2)) > 0.5).sum() >= 3  # most are turned to somebody
    assert np.array_equal(np.isnan(views.facing), share == 0.0)
    again = draw_views(
        release, "train", num_views=6, views_per_episode=6, rng=np.random.default_rng(0)
    )
    assert np.array_equal(views.rgb, again.rgb)
    first, second = (train_person_network(views, epochs=1, seed=3) for _ in range(2))
    for key, value in first.state_dict().items():
        assert torch.equal(value, second.state_dict()[key]), key


class KnowingNetwork(PersonNetwork):
    """Answers what it is told to."""

    def __init__(self, share: NDArray[np.float32], facing: NDArray[np.float32]) -> None:
        super().__init__()
        self.told = torch.logit(torch.from_numpy(share), eps=1e-4)
        self.turned = torch.from_numpy(np.stack([np.cos(facing), np.sin(facing)], axis=1))

    def forward(self, images: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        assert len(images) == len(self.told)
        return self.told, self.turned


def test_grades_by_hand() -> None:
    share = np.zeros((5, CELLS, CELLS), np.float32)
    facing = np.full((5, CELLS, CELLS), np.nan, np.float32)
    for view, (rows, yaw) in enumerate([(2, 0.5), (2, -3.0), (5, 3.1), (5, 1.0)]):
        share[view, :rows, :2] = 1.0
        facing[view, :rows, :2] = yaw
    views = PersonViews(
        np.zeros((5, INPUT_SIZE, INPUT_SIZE, 3), np.uint8),
        np.ones((5, INPUT_SIZE, INPUT_SIZE), np.float16),
        share.astype(np.float16),
        facing.astype(np.float16),
        CAMERA,
        EYE_M,
    )
    truth = np.where(np.isnan(facing), np.float32(0.0), facing)
    grades, false = grade_network(KnowingNetwork(share, truth), views)
    assert [one.num_people for one in grades] == [2, 2, 0, 0]
    assert [one.found for one in grades[:2]] == [1.0, 1.0]
    assert [one.facing_off_deg for one in grades[:2]] == pytest.approx([0.0, 0.0], abs=0.1)
    assert np.isnan(grades[2].found)
    assert false == 0.0
    # One is missed, one is turned to the other side, and a person is seen where nobody is.
    seen, turned = share.copy(), truth.copy()
    seen[0], seen[4, 3, 3] = 0.0, 0.9
    turned[2] += np.float32(math.pi / 2.0)
    grades, false = grade_network(KnowingNetwork(seen, turned), views)
    assert [one.found for one in grades[:2]] == [0.5, 1.0]
    assert [one.facing_wrong for one in grades[:2]] == [0.0, 0.5]
    assert grades[1].facing_off_deg == pytest.approx(45.0, abs=0.1)  # median of 0 and 90
    assert false == 1.0


def _in_starting_frame(away: FloatArray, start_yaw: float) -> FloatArray:
    cosine, sine = math.cos(start_yaw), math.sin(start_yaw)
    return np.array([cosine * away[0] - sine * away[2], sine * away[0] + cosine * away[2]])
