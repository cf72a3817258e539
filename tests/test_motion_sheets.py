"""Sheets of motions: everybody in the picture, large, followed; one sheet per emotion."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from small_release import circle_motion, limb_avatar, small_avatars, sway_motion, write_release

from affectsim_data import EMOTIONS, open_release
from affectsim_data.episodes import Person
from affectsim_data.inspection.emotion_sheets import KEY_NAME, emotion_sheets
from affectsim_data.inspection.framing import View, needed_aspect, sheet_camera
from affectsim_data.inspection.motion_sheets import MotionRow, empty_stage, motion_sheet
from affectsim_data.motions import Motion
from affectsim_data.poses import FloatArray, compose_pose, yaw_quaternion
from affectsim_data.render import process_renderer

AVATAR = limb_avatar("plain")
STAYS = sway_motion("sway", "happy")
TRAVELS = circle_motion("circle", "sad", radius=2.0)


def person(motion: Motion, x: float = 0.0, z: float = 0.0, yaw: float = 0.0) -> Person:
    return Person(motion, AVATAR, compose_pose(yaw_quaternion(yaw), [x, 0.0, z]))


def pixels(view: View, *, aspect: float, time_s: FloatArray) -> FloatArray:
    """Joints in pixels of an image 1000 high, `(n, people * 22, 2)`."""
    camera = sheet_camera(round(1000 * aspect), 1000)
    joints = np.concatenate([one.joint_frames(time_s)[..., :3, 3] for one in view.people], axis=1)
    poses = view.trajectory(camera, time_s).T_world_camera
    seen = np.linalg.inv(poses) @ np.append(joints, np.ones((*joints.shape[:-1], 1)), -1).swapaxes(
        1, 2
    )
    return camera.project(seen[:, :3].swapaxes(1, 2))[0]


@pytest.mark.parametrize(
    "people",
    [
        (person(STAYS),),
        (person(STAYS, 3.0, -2.0, yaw=2.5),),
        (person(TRAVELS),),
        (person(STAYS), person(STAYS, z=1.2, yaw=np.pi)),
        (person(STAYS), person(STAYS, x=0.5)),
        (person(TRAVELS), person(TRAVELS, x=0.8)),
    ],
)
@pytest.mark.parametrize("azimuth_deg", [35.0, -80.0])
def test_everybody_is_in_the_picture_and_large(
    people: tuple[Person, ...], azimuth_deg: float
) -> None:
    view = View(people, azimuth_deg)
    aspect = needed_aspect([view])
    found = pixels(view, aspect=aspect, time_s=np.arange(0.0, 3.0, 1.0 / 15.0))
    u, v = found[..., 0] / aspect, found[..., 1]
    assert min(u.min(), v.min()) > 20.0
    assert max(u.max(), v.max()) < 980.0
    # Joints of a standing person span 1.5 of 1.7 m, so a tight picture is filled to 3/4 or more.
    assert max(np.ptp(u), np.ptp(v)) > 620.0


def test_who_stays_is_seen_by_a_still_camera() -> None:
    view = View((person(STAYS),), 35.0)
    poses = view.trajectory(sheet_camera(100, 200), np.arange(5) / 3.0).T_world_camera
    assert not view.follows
    np.testing.assert_array_equal(poses, np.tile(poses[:1], (5, 1, 1)))


def test_who_walks_off_is_followed_without_turning() -> None:
    walker = person(TRAVELS, 1.0, 2.0)
    view, time_s = View((walker,), 35.0), np.arange(12) / 4.0
    poses = view.trajectory(sheet_camera(100, 200), time_s).T_world_camera
    assert view.follows
    np.testing.assert_allclose(poses[:, :3, :3], np.tile(poses[:1, :3, :3], (12, 1, 1)))
    roots = walker.joint_frames(time_s)[:, 0, :3, 3]
    away = poses[:, :3, 3] - roots * [1.0, 0.0, 1.0]
    np.testing.assert_allclose(away, np.tile(away[:1], (12, 1)), atol=1e-9)


@pytest.mark.parametrize("azimuth_deg", [35.0, 120.0, -35.0])
def test_two_people_stand_side_by_side(azimuth_deg: float) -> None:
    view = View((person(STAYS), person(STAYS, z=1.2, yaw=np.pi)), azimuth_deg)
    found = pixels(view, aspect=1.0, time_s=np.zeros(1))[0]
    assert abs(found[0, 0] - found[22, 0]) > 300.0
    way = view.way / np.linalg.norm(view.way)
    asked = [np.sin(np.deg2rad(azimuth_deg)), np.cos(np.deg2rad(azimuth_deg))]
    assert way[[0, 2]] @ asked > 0.0


def test_the_stage_is_chequered() -> None:
    for half_m in (6.0, 8.0):
        (floor,) = empty_stage(half_m).surfaces
        assert np.abs(floor.positions).max() == half_m
        shades = floor.colors[::4, 0].reshape(round(4.0 * half_m), -1)
        assert (shades[1:] != shades[:-1]).all()
        assert (shades[:, 1:] != shades[:, :-1]).all()


@pytest.mark.egl
def test_a_sheet_has_a_row_per_motion_and_shows_them_move() -> None:
    rows = [MotionRow("first", (person(STAYS),)), MotionRow("second", (person(TRAVELS),))]
    renderer = process_renderer("egl")
    labelled = motion_sheet(rows, renderer, num_frames=4, size=120)
    bare = motion_sheet(rows, renderer, num_frames=4, size=120, labels=False)
    assert labelled.width == bare.width
    assert labelled.height == 2 * (120 + 22)
    assert bare.height == 2 * (120 + 3)
    cells = np.asarray(labelled)[22:142], np.asarray(bare)[3:123]
    np.testing.assert_array_equal(*cells)
    assert np.asarray(labelled)[:22].min() < 100 < np.asarray(bare)[:3].min()
    column = (bare.width + 3) // 4
    first, later = (cells[1][:, start : start + column - 3] for start in (0, column))
    # The body is the only thing that is brown: red well above blue.
    body = [(cell[..., 0].astype(int) - cell[..., 2] > 30) for cell in (first, later)]
    assert (body[0] != body[1]).any()
    tall = np.flatnonzero(body[0].any(axis=1))
    assert np.ptp(tall) > 0.75 * 120


@pytest.mark.egl
def test_every_action_and_emotion_has_a_sheet(tmp_path: Path) -> None:
    write_release(tmp_path / "release")
    release = open_release(tmp_path / "release")
    paths = emotion_sheets(release, tmp_path / "sheets", num_frames=2, progress=False)
    names = [f"sway-{emotion}" for emotion in EMOTIONS]
    assert [path.stem for path in paths] == ["simple_walk-angry", "simple_walk-sad", *names]
    assert all(Image.open(path).height == 222 for path in paths)


@pytest.mark.egl
def test_covered_labels_have_a_key(tmp_path: Path) -> None:
    motions = [sway_motion(f"m{place}", emotion) for place, emotion in enumerate(EMOTIONS)]
    paths = emotion_sheets(
        motions,
        tmp_path,
        avatars=list(small_avatars().values()),
        labels=False,
        rng=np.random.default_rng(1),
        num_frames=1,
        progress=False,
    )
    assert [path.name for path in paths] == [f"sheet-0{place}.png" for place in range(1, 6)]
    key = json.loads((tmp_path / KEY_NAME).read_text(encoding="utf-8"))
    assert list(key) == [path.stem for path in paths]
    assert sorted(key.values()) == [f"sway-{emotion}" for emotion in EMOTIONS] != [*key.values()]


def test_performers_and_performances_take_turns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    motions = [
        dataclasses.replace(sway_motion(f"{who}-{what}", "sad", performer_id=who), performance=what)
        for who in "ab"
        for what in ("mourn", "sit", "wait")
    ]
    drawn: list[MotionRow] = []

    def draw(rows: list[MotionRow], *args: object, **kwargs: object) -> Image.Image:
        drawn.extend(rows)
        return Image.new("RGB", (1, 1))

    monkeypatch.setattr("affectsim_data.inspection.emotion_sheets.motion_sheet", draw)
    emotion_sheets(motions, tmp_path, avatars=[AVATAR], max_rows=4, progress=False)
    shown = [row.people[0].motion.motion_id for row in drawn]
    assert shown == ["a-mourn", "b-sit", "a-wait", "b-mourn"]
    assert drawn[0].caption == "sad, mourn, a, 2.0 s"


def test_what_is_missing_is_said(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="motions and avatars, got 1 and 0"):
        emotion_sheets([STAYS], tmp_path)
    with pytest.raises(ValueError, match="need rng"):
        emotion_sheets([STAYS], tmp_path, avatars=[AVATAR], labels=False)
    with pytest.raises(ValueError, match="at least one row, got none"):
        motion_sheet([], process_renderer("egl"))
