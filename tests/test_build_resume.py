"""Builds that are killed, broken off or started twice: nothing is lost, nothing is mixed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from small_release import box_room, small_motions
from tiny_build import tree, write_tiny

from affectsim_data.builders.building import build_release
from affectsim_data.builders.checkpoints import (
    Checkpoints,
    result_type,
    staging_folder,
    unit_key,
)
from affectsim_data.builders.fingerprints import build_fingerprint
from affectsim_data.builders.recipes import read_recipe
from affectsim_data.builders.scene_sources import FailedScene, build_scene
from affectsim_data.builders.units import pack_unit, unpack_unit
from affectsim_data.cli import main


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Recipe and source of the tiny release."""
    return write_tiny(tmp_path_factory.mktemp("files"))


def command(files: tuple[Path, Path], out: Path) -> list[str]:
    recipe, source = map(str, files)
    reports = [str(out.with_name(f"{name}.parquet")) for name in ("screen", "scene")]
    return [
        *("build", recipe, "--source", source, "--out", str(out)),
        *("--screen-report", reports[0], "--scene-report", reports[1]),
    ]


def children(process: int) -> list[int]:
    """Processes below one, its children's children too."""
    parents: dict[int, list[int]] = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
        except OSError:
            continue
        parents.setdefault(parent, []).append(int(entry.name))
    found, waiting = [], [process]
    while waiting:
        waiting += (below := parents.get(waiting.pop(), []))
        found += below
    return found


def until(condition: object, limit_s: float = 60.0) -> None:
    assert callable(condition)
    deadline = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def run_and_kill(arguments: list[str], out: Path, units: int, jobs: int) -> None:
    """Starts a build, kills it with -9 when it has that many units, and sees its workers die."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    process = subprocess.Popen(
        [sys.executable, "-m", "affectsim_data", *arguments, "--jobs", str(jobs)],
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    folder = staging_folder(out)

    def is_far_enough() -> bool:
        assert process.poll() is None, "the build was over before it could be killed"
        return sum(1 for _ in folder.glob("*/*-*-*.parquet")) >= units

    until(is_far_enough)
    workers = children(process.pid)
    assert bool(workers) == (jobs > 1)
    process.send_signal(signal.SIGKILL)
    process.wait()
    until(lambda: not any(Path(f"/proc/{worker}/cmdline").is_file() for worker in workers))


def test_killed_builds_go_on_and_end_with_the_same_bytes(
    tmp_path: Path, files: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    whole, broken = tmp_path / "whole" / "out", tmp_path / "broken" / "out"
    assert main([*command(files, whole), "--jobs", "1"]) == 0
    # Anywhere: amid motions (5), scenes (2) and episodes (2).
    stops = sorted(np.random.default_rng(os.getpid()).choice(np.arange(1, 9), 3, replace=False))
    for units, jobs in zip(stops, (2, 1, 1), strict=True):
        run_and_kill(command(files, broken), broken, int(units), jobs)
        assert not broken.exists()
    capsys.readouterr()
    assert main([*command(files, broken), "--jobs", "1"]) == 0
    told = capsys.readouterr()
    assert "going on; " in told.err
    assert f"{'motions':10}" in told.out
    first, second = tree(whole.parent), tree(broken.parent)
    assert first.keys() == second.keys()
    assert [name for name in first if first[name] != second[name]] == []


def test_what_is_stored_is_read_back_exactly() -> None:
    for motion in (one.rounded() for one in small_motions().values()):
        again = unpack_unit(pack_unit(motion), type(motion))
        assert np.array_equal(again.joint_rotations, motion.joint_rotations)
        assert np.array_equal(again.root_translation, motion.root_translation)
        assert (again.motion_id, again.provenance) == (motion.motion_id, motion.provenance)
    failed = FailedScene("a", "no floor")
    assert unpack_unit(pack_unit(failed), result_type(build_scene)) == failed


def store_and_stop(checkpoints: Checkpoints, error: BaseException) -> None:
    """A build that ends with an error when one unit is stored."""
    with checkpoints:
        (unit,) = checkpoints.units("scenes", [unit_key("a")], FailedScene)
        assert not unit.is_done
        unit.write(FailedScene("a", "no floor"))
        raise error


def stored(folder: Path) -> Checkpoints:
    """Checkpoints of a build that was broken off."""
    checkpoints = Checkpoints(folder / "out", "same")
    with pytest.raises(KeyboardInterrupt):
        store_and_stop(checkpoints, KeyboardInterrupt())
    return checkpoints


def is_done(folder: Path, fingerprint: str = "same", key: str = "a") -> tuple[bool, list[str]]:
    """Whether a later build finds the unit, and what it says."""
    said: list[str] = []
    with Checkpoints(folder / "out", fingerprint, say=said.append) as checkpoints:
        (unit,) = checkpoints.units("scenes", [unit_key(key)], FailedScene)
        return unit.is_done, said


def test_units_are_found_again_by_the_same_build_alone(tmp_path: Path) -> None:
    stored(tmp_path)
    done, (line,) = is_done(tmp_path)
    assert done
    assert "going on; done before: 1 scenes" in line
    assert list(tmp_path.iterdir()) == []
    stored(tmp_path)
    assert not is_done(tmp_path, key="b")[0]
    stored(tmp_path)
    done, (line,) = is_done(tmp_path, "another recipe")
    assert not done
    assert "left by a build of another recipe, source or version; starting anew" in line


@pytest.mark.parametrize("keep", [0.0, 0.5, 0.999])
def test_torn_units_are_made_again(tmp_path: Path, keep: float) -> None:
    folder = stored(tmp_path).folder
    (path,) = folder.glob("scenes/*.parquet")
    payload = path.read_bytes()
    path.write_bytes(payload[: int(keep * len(payload))])
    (folder / "scenes" / f"{path.name}.tmp").write_bytes(b"half")
    assert not is_done(tmp_path)[0]


def test_errors_leave_units_only_where_they_can_be_used(tmp_path: Path) -> None:
    for keep in (False, True):
        checkpoints = Checkpoints(tmp_path / "out", "same")
        checkpoints.keep = keep
        with pytest.raises(ValueError, match="wrong"):
            store_and_stop(checkpoints, ValueError("wrong"))
        assert checkpoints.folder.exists() == keep
    assert is_done(tmp_path)[0]
    with pytest.raises(OSError, match="disk"), Checkpoints(tmp_path / "out", "same"):
        raise OSError("disk")
    assert list(tmp_path.iterdir()) == []


def test_two_builds_into_one_folder_are_refused(tmp_path: Path) -> None:
    with Checkpoints(tmp_path / "out", "one") as first:
        first.units("scenes", [unit_key("a")], FailedScene)[0].write(FailedScene("a", ""))
        with (
            pytest.raises(BlockingIOError, match=r"out: another build writes there now"),
            Checkpoints(tmp_path / "out", "other"),
        ):
            pass
        assert first.done() == "1 scenes"
    with Checkpoints(tmp_path / "out", "other"):
        pass
    assert list(tmp_path.iterdir()) == []


def test_everything_a_build_depends_on_is_in_its_fingerprint(tmp_path: Path) -> None:
    recipe, source = write_tiny(tmp_path)
    prints = {build_fingerprint(read_recipe(recipe), source)}
    (source / "third.glb").write_bytes(box_room("third").to_glb())
    prints.add(build_fingerprint(read_recipe(recipe), source))
    os.utime(source / "third.glb", ns=(1, 1))
    prints.add(build_fingerprint(read_recipe(recipe), source))
    (source / "third.glb").rename(source / "fourth.glb")
    prints.add(build_fingerprint(read_recipe(recipe), source))
    source.rename(tmp_path / "moved")
    prints.add(build_fingerprint(read_recipe(recipe), tmp_path / "moved"))
    recipe.write_text(recipe.read_text(encoding="utf-8") + "\n# more\n", encoding="utf-8")
    prints.add(build_fingerprint(read_recipe(recipe), tmp_path / "moved"))
    assert len(prints) == 6
    again = build_fingerprint(read_recipe(recipe), tmp_path / "moved")
    assert again in prints
    shell = read_recipe("habitat")
    assert build_fingerprint(shell, None) != build_fingerprint(shell.with_shell(), None)


def test_files_a_recipe_names_are_in_its_fingerprint(tmp_path: Path) -> None:
    recipe, source = write_tiny(tmp_path)
    named = tmp_path / "corpora" / "own.toml"
    named.parent.mkdir()
    named.write_text('table = "labels.csv"\n', encoding="utf-8")
    plan = read_recipe(recipe)
    plan.document["corpora"] = ["corpora/own.toml"]
    prints = {build_fingerprint(plan, source)}
    (named.parent / "labels.csv").write_text("file,style\n", encoding="utf-8")
    prints.add(build_fingerprint(plan, source))
    named.write_text('table = "labels.csv"\nfps = 30\n', encoding="utf-8")
    prints.add(build_fingerprint(plan, source))
    assert len(prints) == 3


def test_a_broken_scene_can_be_skipped_without_reading_the_others_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recipe, source = write_tiny(tmp_path)
    (source / "broken.glb").write_bytes(b"glTF")
    out = tmp_path / "out"
    with pytest.raises(ValueError, match=r"tiny/broken: .*add --skip-broken"):
        build_release(recipe, out, source=source, jobs=1)
    assert "5 motions, 3 scenes are done; the same command" in capsys.readouterr().err
    report = build_release(recipe, out, source=source, jobs=1, skip_broken=True)
    assert [one.scene_id for one in report.failed_scenes] == ["tiny/broken"]
    kept = {cost.name: (cost.units, cost.resumed) for cost in report.costs}
    assert kept["motions"] == (0, 5)
    assert kept["scenes"] == (0, 3)
    assert kept["episodes"] == (10, 0)
    assert not staging_folder(out).exists()
    assert pq.read_table(out / "episodes").num_rows == 10
    assert "going on; done before: 5 motions, 3 scenes" in capsys.readouterr().err


def test_ctrl_c_says_how_far_it_is(
    tmp_path: Path,
    files: tuple[Path, Path],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("affectsim_data.builders.building.make_scenes", interrupted)
    out = tmp_path / "out"
    assert main([*command(files, out), "--jobs", "1"]) == 130
    error = capsys.readouterr().err
    assert "out: 5 motions are done; the same command goes on from there" in error
    assert error.endswith("affectsim: interrupted\n")
    assert not out.exists()
