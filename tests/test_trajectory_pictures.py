"""Pictures of runs: what is read back, where it is drawn, what is seen, and why a run failed."""

from __future__ import annotations

import csv
import dataclasses
import math
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from PIL import Image
from small_release import box_room, limb_avatar, make_episode, sway_motion, world_of

from affectsim_data.cli import main
from affectsim_data.episodes import World
from affectsim_data.evaluation.tables import write_trajectories
from affectsim_data.inspection.failure_sheets import write_failures
from affectsim_data.inspection.run_streams import RunStream
from affectsim_data.inspection.scene_plans import PLAN_FINE
from affectsim_data.inspection.trajectory_failures import (
    Cause,
    Verdict,
    cause_lines,
    judge_run,
    judge_runs,
)
from affectsim_data.inspection.trajectory_frames import condition_frame, looks_at
from affectsim_data.inspection.trajectory_maps import (
    CLIPPED_COLOR,
    PHASE_COLORS,
    draw_run_map,
    map_frame,
)
from affectsim_data.inspection.trajectory_moments import chosen_moments, key_moments
from affectsim_data.inspection.trajectory_pictures import run_picture
from affectsim_data.inspection.trajectory_recording import record_run
from affectsim_data.inspection.trajectory_runs import RecordedRun, RunTable
from affectsim_data.inspection.trajectory_sights import run_sights
from affectsim_data.releases import Release
from affectsim_data.render import Renderer, open_renderer
from affectsim_data.simulation.actions import Action
from affectsim_data.simulation.running import EpisodeRun, Phase

KEYS: dict[str, Action] = {
    "w": "move_forward",
    "a": "turn_left",
    "d": "turn_right",
    "h": "hand_off",
    "q": "stop",
}
GO = "wwwadh"
"""In the small release from 2.5 m behind the target to 1.75 m, and a handoff."""


def acted(
    release: Release, keys: str, *, index: int = 0, renderer: Renderer | None = None
) -> EpisodeRun:
    """An episode of the test split in which these keys are pressed; after an h, to its end."""
    episode = release.episode("test", index)
    run = EpisodeRun(
        episode,
        release.world(episode),
        release.navmesh(episode.scene_id),
        cast(Renderer, renderer),
        policy="keys",
    )
    for key in keys:
        if run.outcome is None:
            run.act(KEYS[key], approaching=run.num_steps >= 2)
    while run.clip_start_s is not None and run.outcome is None:
        run.act("hand_off")
    return run


def table_of(path: Path, *runs: EpisodeRun) -> Path:
    """A table of runs."""
    write_trajectories([row for run in runs for row in run.rows], path)
    return path


def recorded(tmp_path: Path, run: EpisodeRun) -> RecordedRun:
    """The run, written and read."""
    return RunTable([table_of(tmp_path / "runs.parquet", run)]).run(run.episode)


def test_a_run_is_read_back_as_it_was(small: Release, tmp_path: Path) -> None:
    run = acted(small, GO)
    back = recorded(tmp_path, run)
    assert back.num_actions == run.num_steps
    assert back.times_s[-1] == run.time_s
    assert back.positions[0].tolist() == list(run.episode.start_position)
    np.testing.assert_allclose(back.positions[-1], run.state.position)
    assert back.lengths_m.sum() == pytest.approx(0.75)
    assert back.handoff == len(GO)
    assert back.clip_s is not None
    assert back.clip_s[0] == run.clip_start_s == 2.0
    assert back.clip_s[1] == run.time_s == 6.0
    assert back.times_s[back.clip_states].tolist() == np.arange(2.0, 6.01, 0.25).tolist()
    assert back.phases[:3] == ("search", "search", "approach")


@pytest.mark.parametrize(
    ("keys", "end"),
    [("aah", "collected"), ("aaq", "stopped"), ("a" * 480, "actions_exhausted")],
)
def test_the_end_is_that_of_the_run(small: Release, tmp_path: Path, keys: str, end: str) -> None:
    run = acted(small, keys)
    assert run.outcome == recorded(tmp_path, run).end == end


def test_calls_of_the_planner_run_out(small: Release, tmp_path: Path) -> None:
    run = acted(small, "w")
    run.act("turn_left", planner_calls=80)
    assert run.outcome == recorded(tmp_path, run).end == "planner_calls_exhausted"


@pytest.mark.parametrize("keys", ["aa", GO])
def test_a_run_that_breaks_off_is_cut_short(small: Release, tmp_path: Path, keys: str) -> None:
    run = acted(small, keys)
    write_trajectories(run.rows[: len(keys) + 1], tmp_path / "runs.csv")
    assert RunTable([tmp_path / "runs.csv"]).run(run.episode).end == "cut_short"


def test_what_is_not_in_a_table_is_named(small: Release, tmp_path: Path) -> None:
    run = acted(small, "q")
    rows = [{**row, "policy": name} for name in ("one", "two") for row in run.rows]
    write_trajectories(rows, tmp_path / "two.parquet")
    with pytest.raises(ValueError, match="holds runs of 'one', 'two'; say whose with --policy"):
        RunTable([tmp_path / "two.parquet"])
    with pytest.raises(ValueError, match="none of 'three'"):
        RunTable([tmp_path / "two.parquet"], policy="three")
    table = RunTable([tmp_path / "two.parquet"], policy="two")
    with pytest.raises(KeyError, match="has no run of episode 'small/5'"):
        table.run(small.episode("test", 1))
    elsewhere = dataclasses.replace(run.episode, start_position=(1.0, 0.0, -2.5))
    with pytest.raises(ValueError, match=r"begins 1\.00 m from where the robot starts"):
        table.run(elsewhere)
    write_trajectories([], tmp_path / "none.parquet")
    with pytest.raises(ValueError, match="holds columns and no row"):
        RunTable([tmp_path / "none.parquet"])


def still_run(place: tuple[float, float], yaw_deg: float, *, then_deg: float = 0.0) -> RecordedRun:
    """A run that hands off at once at a place on the plan; in the clip it turns by `then_deg`.

    The target sways at the origin and looks along +Z; a cycle takes two seconds.
    """
    position = (place[0], 0.0, place[1])
    episode = make_episode(start_position=position, start_yaw=math.radians(yaw_deg), phase_s=0.0)
    times_s = np.arange(0.0, 6.01, 0.25)
    yaws = np.where(times_s > 3.0, yaw_deg + then_deg, yaw_deg)
    count = len(times_s) - 1
    action: Action = "hand_off"
    phase: Phase = "collect"
    return RecordedRun(
        episode=episode,
        policy="still",
        times_s=times_s,
        positions=np.tile(position, (count + 1, 1)),
        yaws=np.radians(yaws),
        actions=(action,) * count,
        phases=(phase,) * count,
        clipped=np.zeros(count, bool),
        planner_calls=np.zeros(count, np.int64),
    )


def world(*boxes: Any) -> World:
    """A room of 12 m with the target in the middle, and boxes."""
    room = box_room("hall", half=6.0, boxes=boxes)
    return world_of(room, [(sway_motion("sway", "happy"), limb_avatar("plain"), (0, 0, 0), 0.0)])


def test_sights_by_hand() -> None:
    sights = run_sights(still_run((1.5, 2.0), math.degrees(math.atan2(1.5, 2.0))), world())
    np.testing.assert_allclose(sights.distance_m, 2.5, atol=0.05)
    np.testing.assert_allclose(sights.azimuth, math.atan2(1.5, 2.0), atol=0.05)
    assert sights.visible.min() == 1.0
    away = run_sights(still_run((1.5, 2.0), 180.0), world())
    assert away.visible.max() == away.in_image.max() == 0.0


WALL = ((-1.0, 0.0, 0.9), (1.0, 2.0, 1.1))
"""Between the target and whoever stands in front of it."""


@pytest.mark.parametrize(
    ("run", "boxes", "cause"),
    [
        (still_run((0.0, 2.0), 0.0), (), None),
        (still_run((0.0, 2.0), 180.0), (), "out_of_view"),
        (still_run((0.0, 2.0), 0.0), (WALL,), "hidden"),
        (still_run((0.0, 2.0), 0.0, then_deg=120.0), (), "lost"),
        (still_run((0.0, 5.0), 0.0), (), "too_far"),
        (still_run((0.0, -2.0), 180.0), (), "from_behind"),
    ],
)
def test_causes_by_hand(run: RecordedRun, boxes: Sequence[Any], cause: Cause | None) -> None:
    verdict = judge_run(run, world(*boxes))
    assert verdict.cause == cause
    assert verdict.path_length_m == 0.0
    seen_first = cause not in ("out_of_view", "hidden")
    assert verdict.first_seen_s == 0.0 if seen_first else math.isnan(verdict.first_seen_s)


def test_a_clip_that_is_not_whole_is_not_judged_by_what_it_shows() -> None:
    run = still_run((0.0, 2.0), 0.0)
    short = dataclasses.replace(
        run, times_s=run.times_s[:-2], actions=run.actions[:-2], phases=run.phases[:-2]
    )
    verdict = judge_run(short, world())
    assert verdict.cause == "cut_short"
    assert math.isnan(verdict.visible)


def test_causes_are_counted_by_kind() -> None:
    one = judge_run(still_run((0.0, 2.0), 180.0), world())
    verdicts = [one, dataclasses.replace(one, kind="dyadic", cause=None), one]
    lines = cause_lines(verdicts)
    assert [line.split() for line in lines[1:]] == [
        ["out", "of", "view", "2", "0", "2"],
        ["the", "clip", "shows", "the", "target", "0", "1", "1"],
        ["runs", "2", "1", "3"],
    ]
    assert lines[0].index("rear view") < lines[0].index("dyadic")
    assert len({len(line) for line in lines}) == 1


def test_moments_are_in_order_and_hold_what_matters(small: Release, tmp_path: Path) -> None:
    run = recorded(tmp_path, acted(small, "aaaaaaaaaaaa" + GO))
    sights = run_sights(run, small.world(run.episode))
    for count in range(2, 9):
        moments = key_moments(run, sights, count=count)
        states = [one.state for one in moments]
        assert [one.number for one in moments] == list(range(1, count + 1))
        assert states == sorted(set(states))
        assert (states[0], states[-1]) == (0, run.num_actions)
    titles = {one.title: one.state for one in key_moments(run, sights, count=6)}
    assert titles["handoff"] == 12 + len(GO)
    assert run.times_s[titles["clip begins"]] == 6.0
    assert "clip ends" in titles
    assert len(key_moments(run, sights, count=10**3)) == run.num_actions + 1
    with pytest.raises(ValueError, match="count=1"):
        key_moments(run, sights, count=1)
    with pytest.raises(ValueError, match=f"steps must be 0 to {run.num_actions}, got 999"):
        chosen_moments(run, [0, 999])


def test_the_map_shows_the_way_where_it_was(small: Release, tmp_path: Path) -> None:
    # To the left, and straight on into the wall: the last moves are cut short.
    run = recorded(tmp_path, acted(small, "aaaaaa" + "w" * 17 + "q"))
    assert run.clipped.sum() >= 1
    place = small.world(run.episode)
    picture = np.asarray(draw_run_map(run, place, width=400, height=400)).astype(int)
    frame = map_frame(run, place, width=400, height=400)

    def nearest(state: int, color: tuple[int, int, int]) -> float:
        x, y = (int(one / PLAN_FINE) for one in frame(run.positions[state, [0, 2]])[0])
        around = picture[y - 3 : y + 4, x - 3 : x + 4].reshape(-1, 3)
        return float(np.abs(around - color).max(axis=1).min())

    assert nearest(12, PHASE_COLORS["approach"]) < 40
    assert nearest(run.num_actions, CLIPPED_COLOR) < 40
    assert nearest(12, CLIPPED_COLOR) > 60
    assert not (np.abs(picture - PHASE_COLORS["collect"]).max(axis=-1) < 20).any()


class FakeStream:
    """Keeps which poses are shown."""

    def __init__(self) -> None:
        self.scales: dict[str, float] = {}
        self.entities: Counter[str] = Counter()

    def log(self, entity: str, what: Any, *, static: bool = False) -> None:
        self.entities[entity] += 1
        if type(what).__name__ == "Transform3D" and "pose_" in entity:
            self.scales[entity] = what.scale.as_arrow_array().to_pylist()[0][0]

    def set_time(self, timeline: str, *, duration: float) -> None:
        assert timeline == "run"


def test_one_pose_of_a_person_is_shown_at_a_time() -> None:
    run, place = still_run((0.0, 2.0), 0.0), world()
    fake, frame = FakeStream(), map_frame(run, place, width=64, height=64)
    shown = RunStream(fake, run.episode, place, Image.new("RGB", (64, 64)), frame)
    poses = []
    for time_s in (0.0, 0.5, 1.0, 2.0):
        shown.at(time_s)
        poses.append([name for name, scale in fake.scales.items() if scale == 1.0])
    assert [len(one) for one in poses] == [1, 1, 1, 1]
    assert poses[0] == poses[3] != poses[1] != poses[2]
    assert len(fake.scales) == 12  # six poses a second of a cycle of two


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--failures"], "--trajectories names their table"),
        (["--trajectories", "t.parquet"], "takes an episode_id, or --failures"),
        (["small/4", "--trajectories", "t.parquet", "--failures"], "takes an episode_id, or"),
        (["small/4", "--trajectories", "t.parquet", "--split", "test"], "do not go with runs"),
        (["small/4", "--trajectories", "t.parquet", "--out", "a.mp4"], "must end with .png or"),
    ],
)
def test_arguments_that_do_not_go_together(
    small_release_path: Path,
    arguments: list[str],
    message: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["inspect", str(small_release_path), *arguments]) == 1
    assert message in capsys.readouterr().err


@pytest.mark.egl
def test_frames_are_those_the_robot_saw(small: Release, tmp_path: Path) -> None:
    run = acted(small, "wwa", renderer=open_renderer())
    back = recorded(tmp_path, run)
    place, renderer = small.world(run.episode), open_renderer()
    again = looks_at(back, place, renderer, [0, 3], camera=place.camera)
    seen = run.observe()
    np.testing.assert_allclose(again.rgb[1].astype(int), seen.rgb, atol=1)
    np.testing.assert_allclose(again.depth[1], seen.depth, rtol=1e-4)
    first = condition_frame(back, place, renderer, "p_init", 0, size=place.camera.width)
    np.testing.assert_allclose(first.astype(int), again.rgb[0], atol=1)


@pytest.mark.egl
def test_a_run_as_picture_and_recording(
    small: Release, small_release_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = table_of(tmp_path / "runs.parquet", acted(small, GO, index=1))
    out = tmp_path / "shown"
    arguments = ["inspect", str(small_release_path), "small/5", "--trajectories", str(table)]
    assert main([*arguments, "--out", str(out)]) == 0
    assert sorted(path.name for path in out.iterdir()) == ["small_5.png", "small_5.rrd"]
    assert Image.open(out / "small_5.png").width == 1600
    assert 10_000 < (out / "small_5.rrd").stat().st_size < 4_000_000
    assert "open it with: rerun" in capsys.readouterr().out


@pytest.mark.egl
def test_pages_of_failures(small: Release, tmp_path: Path) -> None:
    runs = RunTable([table_of(tmp_path / "t.csv", acted(small, "aaq"), acted(small, GO, index=1))])
    verdicts = judge_runs(small, runs)
    assert [one.episode_id for one in verdicts] == ["small/4", "small/5"]
    assert verdicts[0].cause == "stopped"
    paths = write_failures(small, runs, verdicts, open_renderer(), tmp_path / "failures")
    causes = {one.cause for one in verdicts if one.cause}
    assert {path.stem for path in paths} == {"runs", *causes}
    with paths[0].open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == [field.name for field in dataclasses.fields(Verdict)]
    assert (rows[0]["cause"], rows[0]["visible"], rows[0]["num_actions"]) == ("stopped", "", "3")
    with pytest.raises(ValueError, match="most=0"):
        write_failures(small, runs, verdicts, open_renderer(), tmp_path, most=0)


@pytest.mark.egl
def test_a_page_has_room_for_six_steps(small: Release, tmp_path: Path) -> None:
    run = recorded(tmp_path, acted(small, "aaq"))
    place, renderer = small.world(run.episode), open_renderer()
    with pytest.raises(ValueError, match="room for 6 steps, got 7"):
        run_picture(run, place, renderer, steps=range(7))
    picture = run_picture(run, place, renderer, steps=[0, 3])
    assert picture.width == 1600
    record_run(run, place, renderer, tmp_path / "run.rrd")
    assert (tmp_path / "run.rrd").stat().st_size > 10_000
