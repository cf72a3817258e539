"""Runs of a policy over a split: the same bytes however they are made; nothing is lost or mixed."""

from __future__ import annotations

import json
import multiprocessing
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from small_release import small_rows, write_release

from affectsim_data.cli import main
from affectsim_data.loaders import AffectSimDataset
from affectsim_data.releases import Release, open_release
from affectsim_data.releases.journals import journal_path, open_journal_file
from affectsim_data.schemas import SCHEMAS
from affectsim_data.simulation.acquiring import acquire
from affectsim_data.simulation.acting import Job
from affectsim_data.simulation.intake import work_units
from affectsim_data.simulation.journal import RunHeader, RunJournal, open_run_journal
from affectsim_data.simulation.recording import EpisodeRecord, failures_path

POLICY = "random:6"
HEADER = RunHeader("walker", "here", "ab12", "split 'test'", 0, 60.0, "ef")
KILLED = """
import os, sys
from affectsim_data.releases import open_release
from affectsim_data.releases.journals import JournalFile
from affectsim_data.simulation.acquiring import acquire

append = JournalFile.append
left = 3

def append_and_die(self, document):
    global left
    append(self, document)
    left -= 1
    if not left:
        os.kill(os.getpid(), 9)

JournalFile.append = append_and_die
acquire(open_release(sys.argv[1]), sys.argv[3], sys.argv[2], jobs=1, progress=False)
"""


@pytest.fixture(scope="module")
def six(tmp_path_factory: pytest.TempPathFactory) -> Release:
    """The small release with all six episodes in the test split."""
    rows = small_rows()
    episodes = [{**row, "split": "test"} for row in rows["episodes"]]
    out = tmp_path_factory.mktemp("releases") / "six"
    write_release(out, rows={**rows, "episodes": episodes}, splits=("test",))
    return open_release(out)


@pytest.fixture(scope="module")
def whole(six: Release, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The table of a run over it, in one process."""
    out = tmp_path_factory.mktemp("runs") / "whole.parquet"
    run = acquire(six, POLICY, out, jobs=1, progress=False)
    assert run.endings == {"collected": 6}
    assert (run.num_episodes, run.num_new) == (6, 6)
    return out


def fallbacks(dataset: AffectSimDataset) -> list[bool]:
    """What every sample says of itself."""
    return [dataset[place]["fallback"] for place in range(len(dataset))]


@pytest.mark.egl
def test_two_processes_give_the_bytes_of_one(
    six: Release, whole: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "two.parquet"
    assert main(["acquire", six.uri, "--policy", POLICY, "--out", str(out), "--jobs", "2"]) == 0
    assert "6 episodes in" in capsys.readouterr().out
    assert out.read_bytes() == whole.read_bytes()
    assert multiprocessing.active_children() == []
    assert [path.name for path in tmp_path.iterdir()] == ["two.parquet"]


@pytest.mark.egl
def test_a_run_that_is_done_has_nothing_to_do(
    six: Release, whole: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    written = whole.read_bytes()
    assert main(["acquire", six.uri, "--policy", POLICY, "--out", str(whole)]) == 0
    assert capsys.readouterr().out.splitlines() == [
        f"{whole}: all 6 episodes were done before; nothing to do",
        "        6 collected",
    ]
    others: dict[str, dict[str, Any]] = {
        "is of another run: seed 0, here 1; go on with what it was": {"seed": 1},
        "is of another run: policy 'random:6', here 'stay'": {"policy": "stay"},
        "is of another run: max_policy_time_s 60.0, here 5": {"max_policy_time_s": 5.0},
        r"of other episodes: 4 more are, such as 'small/2'; .*--out.*--overwrite": {"limit": 2},
    }
    for message, options in others.items():
        with pytest.raises(ValueError, match=message):
            acquire(six, options.pop("policy", POLICY), whole, progress=False, **options)
    assert whole.read_bytes() == written
    assert [path.name for path in whole.parent.iterdir()] == [whole.name]


@pytest.mark.egl
def test_a_run_into_its_release_is_done_too(tmp_path: Path, capsys: Any) -> None:
    release, out = tmp_path / "release", tmp_path / "runs.parquet"
    write_release(release)
    words = ["acquire", str(release), "--policy", "stay", "--out", str(out), "--jobs", "1"]
    assert main([*words, "--limit", "1", "--into-release"]) == 0
    carried = (release / "trajectories/stay-test.parquet").read_bytes()
    assert b"affectsim_trajectories" in out.read_bytes()
    assert b"affectsim_trajectories" not in carried
    capsys.readouterr()
    assert main([*words, "--limit", "1", "--into-release"]) == 0
    assert "all 1 episodes were done before; nothing to do" in capsys.readouterr().out
    assert (release / "trajectories/stay-test.parquet").read_bytes() == carried


@pytest.mark.egl
def test_tables_hold_the_episodes_in_order_and_are_what_a_obs_shows(
    six: Release, whole: Path
) -> None:
    table = pq.read_table(whole)
    assert table.schema.equals(SCHEMAS["trajectories"])
    ids = table.column("episode_id").to_pylist()
    assert list(dict.fromkeys(ids)) == [f"small/{number}" for number in range(6)]
    # Each has random numbers of its own.
    actions = table.column("action").to_pylist()
    assert len({tuple(actions[ids.index(one) :][:6]) for one in set(ids)}) > 1
    dataset = AffectSimDataset(six, condition="a_obs", trajectories=whole, images=False)
    assert fallbacks(dataset) == [False] * 6


@pytest.mark.egl
def test_a_killed_run_goes_on_and_ends_with_the_same_bytes(
    six: Release, whole: Path, tmp_path: Path
) -> None:
    out = tmp_path / "killed.parquet"
    command = [sys.executable, "-c", KILLED, six.uri, str(out), POLICY]
    assert subprocess.run(command, check=False, timeout=120).returncode == -9
    assert not out.exists()
    with pytest.raises(ValueError, match=r"is of another run: seed 0, here 1; go on with what it"):
        acquire(six, POLICY, out, seed=1, jobs=1, progress=False)
    with journal_path(out).open("ab") as journal:
        journal.write(b'{"episode_id":"small/4","rows":{"st')  # torn
    run = acquire(six, POLICY, out, jobs=1, progress=False)
    assert (run.num_episodes, run.num_new) == (6, 4)
    assert out.read_bytes() == whole.read_bytes()
    assert not journal_path(out).exists()


@pytest.mark.egl
def test_a_policy_that_fails_costs_its_own_episode_only(
    six: Release, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "troubled.parquet"
    words = ["--policy", "module:troubled_policies:Troubled", "--policy-time", "1", "--jobs", "1"]
    assert main(["acquire", six.uri, *words, "--out", str(out)]) == 0
    reasons = [json.loads(line) for line in failures_path(out).read_text().splitlines()]
    assert [(one["episode_id"], one["step"], one["reason"]) for one in reasons] == [
        ("small/0", 3, "LookupError: lost them while following"),
        ("small/1", 2, "TypeError: act must return a Decision, got a str"),
        ("small/2", 2, "took more than 1 s to decide"),
        ("small/3", 2, "took more than 1 s to decide; was ended"),
        ("small/4", 0, "its process died twice in this episode: status 7"),
    ]
    told = capsys.readouterr()
    assert "5 failed" in told.out
    assert "failed: small/0, step 3: LookupError" in told.err
    assert main(["acquire", six.uri, *words, "--out", str(out)]) == 0
    again = capsys.readouterr()
    assert again.err == "".join(line for line in told.err.splitlines(True) if "failed:" in line)
    assert again.out.splitlines()[1:] == told.out.splitlines()[1:]
    table = pq.read_table(out)
    rows = {
        f"small/{number}": table.filter(pa.compute.equal(table["episode_id"], f"small/{number}"))
        for number in range(6)
    }
    # What was done before the handoff stays, the robot stops, and nothing is acquired.
    turned = ["turn_left", "turn_left", "stop"]
    actions = {name: part.column("action").to_pylist() for name, part in rows.items()}
    assert [actions[f"small/{number}"] for number in range(5)] == [*[turned] * 4, ["stop"]]
    assert actions["small/5"][:3] == ["turn_left", "turn_left", "hand_off"]
    assert rows["small/0"].column("step").to_pylist() == [0, 1, 2]
    np.testing.assert_allclose(rows["small/0"].column("yaw_deg"), [-165.0, -150.0, -150.0])
    dataset = AffectSimDataset(six, condition="a_obs", trajectories=out, images=False)
    assert fallbacks(dataset) == [True] * 5 + [False]


def test_seeds_are_of_the_run_and_the_episode(small: Release) -> None:
    def seed(run: int, episode_id: str) -> int:
        return Job(small, "test", "group", "stay", "stay", run, 1.0).episode_seed(episode_id)

    found = {seed(run, episode_id) for run in (0, 1) for episode_id in ("a", "b", "1", "01")}
    assert len(found) == 8
    assert all(0 <= one < 2**63 for one in found)
    assert seed(0, "a") == 476750478927199554


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"policy": "fly"}, "policy must be one of stay, random"),
        ({"out": "runs.csv"}, r"runs\.csv: must end with \.parquet"),
        ({"limit": 0}, "limit must be from 1 up, got 0"),
        ({"seed": -1}, "seed must be from 0 up, got -1"),
        ({"jobs": 0}, "jobs must be at least 1, got 0"),
        ({"max_policy_time_s": 0.0}, "max_policy_time_s must be more than 0 s, got 0"),
        ({"engine": "mars"}, "engine must be one of local, ray, got 'mars'"),
        ({"split": "dev"}, "split"),
    ],
)
def test_arguments_are_checked_before_anything_is_done(
    small: Release, tmp_path: Path, options: dict[str, Any], message: str
) -> None:
    given = {"policy": "stay", "out": "runs.parquet", "progress": False, **options}
    policy, out = given.pop("policy"), tmp_path / given.pop("out")
    with pytest.raises(ValueError, match=message):
        acquire(small, policy, out, **given)
    assert list(tmp_path.iterdir()) == []


def test_a_table_that_is_there_is_not_replaced_unasked(small: Release, tmp_path: Path) -> None:
    out = tmp_path / "runs.parquet"
    out.write_bytes(b"mine")
    with pytest.raises(FileExistsError, match=r"does not say what run it is of; --overwrite"):
        acquire(small, "stay", out, progress=False)
    with (
        open_journal_file(journal_path(out), kind="runs", busy="somebody works there"),
        pytest.raises(BlockingIOError, match="another process acquires into it now"),
    ):
        acquire(small, "stay", out, progress=False)
    assert out.read_bytes() == b"mine"


def record(number: int) -> EpisodeRecord:
    rng = np.random.default_rng(number)
    rows = [
        {
            "episode_id": f"small/{number}",
            "policy": "walker",
            "step": step,
            "time_s": 0.25 * (step + 1),
            "action": "turn_left",
            "position_x_m": rng.normal(),
            "position_y_m": 0.1 + 0.2,
            "position_z_m": 1e-300,
            "yaw_deg": rng.uniform(-180.0, 180.0),
            "clipped": bool(step % 2),
            "phase": "search",
            "planner_calls": step,
        }
        for step in range(3)
    ]
    table = pa.Table.from_pylist(rows, schema=SCHEMAS["trajectories"])
    return EpisodeRecord(f"small/{number}", "walker", "stopped", table)


def test_records_come_back_from_a_journal_to_the_last_bit(tmp_path: Path) -> None:
    out = tmp_path / "runs.parquet"
    with open_run_journal(out, HEADER, anew=False) as journal:
        for number in range(3):
            journal.add(record(number))
    with open_run_journal(out, HEADER, anew=False) as journal:
        assert list(journal.records) == ["small/0", "small/1", "small/2"]
        for number in range(3):
            assert journal.records[f"small/{number}"].rows.equals(record(number).rows)


@pytest.mark.parametrize("tail", [b"", b"\0" * 9, b"\0" * 9 + b"\n"])
def test_a_journal_torn_anywhere_loses_the_last_record_alone(tmp_path: Path, tail: bytes) -> None:
    out = tmp_path / "runs.parquet"
    with open_run_journal(out, HEADER, anew=False) as journal:
        journal.add(record(0))
        whole = journal.path.read_bytes()
        journal.add(record(1))
    content = journal_path(out).read_bytes()
    for cut in (len(whole), len(whole) + 1, (len(whole) + len(content)) // 2, len(content) - 1):
        journal_path(out).write_bytes(content[:cut] + tail)
        with open_run_journal(out, HEADER, anew=False) as journal:
            assert list(journal.records) == ["small/0"]
            journal.add(record(1))
        assert journal_path(out).read_bytes() == content


def opened(out: Path) -> RunJournal:
    with open_run_journal(out, HEADER, anew=False) as journal:
        return journal


def test_files_that_are_no_journals_are_refused_and_kept(tmp_path: Path) -> None:
    out = tmp_path / "runs.parquet"
    path = journal_path(out)
    path.write_text('{"affectsim_predictions": 1}\n')
    with pytest.raises(ValueError, match="not a journal of trajectories"):
        opened(out)
    path.write_text(json.dumps(HEADER.to_json()) + '\n{"episode_id": "a"}\n')
    with pytest.raises(ValueError, match=r"line 2: not a journal.*: not the record of an episode"):
        opened(out)
    path.write_text(json.dumps(HEADER.to_json()) + "\nhello\n{}\n")
    with pytest.raises(ValueError, match=r"partial\.jsonl, line 2: not a journal.*: not JSON"):
        opened(out)
    assert path.exists()
    with open_run_journal(out, HEADER, anew=True) as journal:
        assert journal.records == {}
    assert not path.exists()  # nothing in it


class TestWorkUnits:
    rows = np.arange(100, 120)
    scenes = np.array([1, 0] * 10)
    placements = np.array([5, 2, 3, 4, 5, 4, 3, 2, 5, 4] * 2)

    def units(self, jobs: int = 1) -> list[tuple[int, ...]]:
        return work_units(self.rows, self.scenes, self.placements, jobs=jobs)

    def test_every_episode_is_in_one_unit(self) -> None:
        assert sorted(row for unit in self.units() for row in unit) == self.rows.tolist()

    def test_scenes_and_within_them_places_follow_each_other(self) -> None:
        order = np.array([row for unit in self.units() for row in unit]) - 100
        kinds = [(self.scenes[at], self.placements[at]) for at in order]
        assert kinds == sorted(kinds)
        assert (np.diff(order[10:14]) > 0).all()  # of the same place in the order of the split

    def test_every_process_gets_some_of_a_few(self) -> None:
        few = work_units(self.rows[:5], self.scenes[:5], self.placements[:5], jobs=2)
        assert len(few) >= 2
        assert max(map(len, self.units(jobs=1))) == 4
        assert work_units(self.rows[:0], self.scenes[:0], self.placements[:0], jobs=2) == []
