"""Validation of the trajectories a release carries: runs of the simulation pass, all else fails."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from acting_runs import make_run
from broken_releases import Row, failed
from small_release import write_release

from affectsim_data.builders.validation import Measure
from affectsim_data.builders.validation.catalogue import CHECKS
from affectsim_data.builders.validation.findings import gather
from affectsim_data.builders.validation.tables import Tables, read_tables
from affectsim_data.builders.validation.trajectories import check_trajectories
from affectsim_data.builders.validation.validating import recipe_inside
from affectsim_data.cli import main
from affectsim_data.releases import Release, open_release
from affectsim_data.releases.manifest import FileEntry, sha256_of
from affectsim_data.releases.recorded import add_trajectories
from affectsim_data.releases.stores import open_store
from affectsim_data.schemas import SCHEMAS
from affectsim_data.simulation import Action

NAME = "trajectories/walker-test.parquet"
Change = Callable[[list[Row]], object]


@pytest.fixture(scope="module")
def rows(small: Release) -> list[Row]:
    """What a robot did in the two episodes of the test split: it collected a clip, it gave up."""
    found: list[Row] = []
    into_a_wall: list[Action] = ["move_forward"] * 24
    ways: tuple[list[Action], ...] = (
        ["turn_left", "move_forward", "move_forward", "turn_right", "hand_off"],
        [*into_a_wall, "turn_left", "stop"],
    )
    for index, way in enumerate(ways):
        run = make_run(small, "walker", index=index)
        for action in way:
            run.act(action, planner_calls=1)
        while run.outcome is None:
            run.act("turn_left")
        found += run.rows
    assert any(row["clipped"] for row in found)
    return found


@pytest.fixture
def folder(tmp_path: Path, rows: list[Row]) -> Path:
    """A release that carries them."""
    write_release(tmp_path / "small")
    put(tmp_path / "walks.parquet", rows)
    assert add_trajectories(tmp_path / "small", tmp_path / "walks.parquet") == [NAME]
    return tmp_path / "small"


def put(path: Path, rows: list[Row]) -> None:
    """Writes a table, whatever is null in it."""
    schema = pa.schema([field.with_nullable(True) for field in SCHEMAS["trajectories"]])
    pq.write_table(pa.Table.from_pylist(rows, schema=schema), path)


def replace(folder: Path, rows: list[Row], name: str = NAME) -> None:
    """Puts other rows into the release, whatever they say, with the entry that goes with them."""
    put(folder / name, rows)
    path = folder / "MANIFEST.json"
    document = json.loads(path.read_text(encoding="utf-8"))
    entry = FileEntry((folder / name).stat().st_size, sha256_of(folder / name), len(rows))
    document["files"][name] = entry.to_json()
    path.write_text(json.dumps(document), encoding="utf-8")


def measures(folder: Path) -> list[Measure]:
    release = open_release(folder)
    tables: Tables = read_tables(release, open_store(folder), *recipe_inside(release))
    return check_trajectories(release, tables)


def messages(found: list[Measure]) -> str:
    """All failures, a line each."""
    return "\n".join(
        f"{check} {failure.item}: {failure.message}"
        for check in dict.fromkeys(measure.check for measure in found)
        for failure in gather(CHECKS[check], [one for one in found if one.check == check]).failures
    )


def test_what_the_simulation_writes_passes(folder: Path) -> None:
    found = measures(folder)
    assert failed(found) == set()
    made = {one.check: len(one.items) for one in found}
    assert made.pop("trajectory_files") == made.pop("trajectory_clip") == 1
    assert set(made.values()) == {2}
    assert set(made) == {name for name in CHECKS if name.startswith("trajectory_")} - {
        "trajectory_files",
        "trajectory_clip",
    }


def test_a_release_without_trajectories_has_none_to_check(tmp_path: Path) -> None:
    write_release(tmp_path / "small")
    assert sum(len(one.items) for one in measures(tmp_path / "small")) == 0


def at(place: int, **values: Any) -> Change:
    """Changes a row."""
    return lambda rows: rows[place].update(values)


def later(rows: list[Row]) -> None:
    for row in rows:
        row["time_s"] += 0.25


def without_the_end(rows: list[Row]) -> None:
    last = max(place for place, row in enumerate(rows) if row["phase"] == "collect")
    del rows[last - 4 : last + 1]


def without_handoff(rows: list[Row]) -> None:
    rows[4].update(action="stop")


def aside(rows: list[Row]) -> None:
    for row in rows:
        row["position_x_m"] += 0.5


def turned(rows: list[Row]) -> None:
    for row in rows:
        row["yaw_deg"] += 30.0


def under_the_floor(rows: list[Row]) -> None:
    for row in rows:
        row["position_y_m"] -= 0.1


def after_the_stop(rows: list[Row]) -> None:
    rows.append({**rows[-1], "step": rows[-1]["step"] + 1, "time_s": rows[-1]["time_s"] + 0.25})


BROKEN: tuple[tuple[Change, set[str], str], ...] = (
    (lambda rows: None, set(), ""),
    (at(1, action="jump"), {"values"}, "small/4: .*'walker', step 1: action is 'jump'"),
    (at(2, phase="dance"), {"values"}, "small/4: .*step 2: phase is 'dance'"),
    (at(3, yaw_deg=math.nan), {"values"}, "small/4: .*step 3: yaw_deg is nan"),
    (at(3, planner_calls=0), {"values"}, "step 3: planner_calls becomes fewer: 0"),
    (at(2, step=7), {"steps", "values"}, "small/4: .*rows, got 2 .*step 3: expected step 2"),
    (lambda rows: rows.pop(2), {"steps"}, r"step 3: expected step 2"),
    (later, {"times"}, r"small/4: .*step 0: time_s is 0\.5, the action ends at 0\.25 s"),
    (at(2, phase="collect"), {"phases"}, "step 2: phase is collect before the handoff"),
    (at(6, phase="approach"), {"phases"}, "step 6: phase is approach after the handoff"),
    (without_handoff, {"phases"}, "step 4: phase is collect before the handoff"),
    (after_the_stop, {"phases"}, "small/5: .*step 26: the robot had stopped"),
    (without_the_end, {"clip"}, r"small/4: .*1\.25 \(.*the last one ends at .*, the clip at"),
    (aside, {"start"}, r"got 0\.5 .*step 0: .*the episode starts 0\.50 m away"),
    (turned, {"turns"}, "small/4: .*step 0: turn_left to .*30 deg off the start"),
    (at(3, yaw_deg=0.0), {"turns"}, "step 3: turn_right to 0 deg"),
    (at(0, clipped=True), {"clipped"}, "step 0: turn_left by 0 m is said to be cut short"),
    (at(1, clipped=True), {"clipped"}, r"step 1: move_forward by 0\.25 m is said to be"),
    (under_the_floor, {"floor"}, r"step 0: .* is 0\.10 m off"),
    (at(0, episode_id="small/9"), {"episodes", "steps"}, "small/9: .*in no row of split 'test'"),
    (at(0, episode_id="small/1"), {"episodes", "steps"}, "small/1: .*in no row of split 'test'"),
    (at(0, policy="dancer"), {"files"}, "holds trajectories of 'dancer'"),
    (at(1, time_s=None), {"files"}, "time_s is null in row 2"),
)


@pytest.mark.parametrize(("change", "expected", "message"), BROKEN)
def test_a_wrong_row_fails_its_check(
    folder: Path, rows: list[Row], change: Change, expected: set[str], message: str
) -> None:
    changed = [dict(row) for row in rows]
    change(changed)
    replace(folder, changed)
    found = measures(folder)
    assert failed(found) == {f"trajectory_{name}" for name in expected}
    assert re.search(message, messages(found))


def test_a_move_leads_no_further_than_it_can(folder: Path, rows: list[Row]) -> None:
    changed = [dict(row) for row in rows]
    for row in changed[2:5]:
        row["position_z_m"] += 0.1
    replace(folder, changed)
    found = measures(folder)
    assert "trajectory_moves" in failed(found)
    assert re.search(r"step 2: move_forward leads 0\.3\d* m on, at most 0\.25", messages(found))


def test_files_of_another_name_are_no_trajectories(folder: Path, rows: list[Row]) -> None:
    replace(folder, rows, "trajectories/walker.parquet")
    found = measures(folder)
    assert failed(found) == {"trajectory_files"}
    assert "its name is not trajectories/POLICY-SPLIT.parquet" in messages(found)


def test_the_command_tells_of_them(folder: Path, rows: list[Row], capsys: Any) -> None:
    changed = [dict(row) for row in rows]
    later(changed)
    replace(folder, changed)
    assert main(["validate", str(folder), "--sample", "0", "--jobs", "1"]) == 1
    told = capsys.readouterr().out
    assert "trajectory_times: 2 of 2" in told
    assert "record it again with `affectsim acquire --into-release`" in told


def test_of_a_partial_copy_only_what_is_there_is_looked_at(
    folder: Path, rows: list[Row], tmp_path: Path
) -> None:
    part = tmp_path / "part"
    words = ["--split", "test", "--scenes", "crate_room", "--condition", "a_obs"]
    assert main(["download", str(folder), *words, "--out", str(part)]) == 0
    replace(part, [*rows, {**rows[0], "episode_id": "small/9"}])
    found = measures(part)
    assert failed(found) == set()
    assert {item for one in found for item in one.items} == {NAME, "small/4", "small/5"}
