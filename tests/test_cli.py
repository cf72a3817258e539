"""The `affectsim` command: exit statuses, one-line errors, and the demo as a user runs it."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from PIL import Image

from affectsim_data.cli import main


def test_errors_are_one_line_with_the_way_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["info", str(tmp_path / "nothing")]) == 1
    error = capsys.readouterr().err
    assert error.startswith("affectsim: no release")
    assert "Traceback" not in error
    assert main(["build", "maxi", "--out", str(tmp_path / "x")]) == 1
    assert "bandai_namco, full, habitat" in capsys.readouterr().err


def test_unknown_episode_is_named(
    small_release_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["inspect", str(small_release_path), "mini/none"]) == 1
    assert "no episode 'mini/none'" in capsys.readouterr().err


def test_info_prints_json(small_release_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(small_release_path), "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert sum(summary["episodes"]["split"].values()) == 6


def test_build_refuses_a_folder_that_is_no_release(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    assert main(["build", "mini", "--out", str(tmp_path)]) == 1
    assert "is no release" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_what_the_system_refuses_is_one_line_too(
    small_release_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["download", str(small_release_path), "--out", str(tmp_path / ("x" * 300))]) == 1
    error = capsys.readouterr().err
    assert re.fullmatch(r"affectsim: \[Errno \d+\] File name too long: '.*'\n", error)


def test_help_lists_the_commands(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["--help"])
    text = capsys.readouterr().out
    for command in ("doctor", "demo", "build", "info", "plan", "download", "upload", "inspect"):
        assert f" {command} " in text


@pytest.mark.slow
def test_killed_build_can_be_run_again(tmp_path: Path) -> None:
    out = tmp_path / "mini"
    command = [sys.executable, "-m", "affectsim_data", "build", "mini", "--out", str(out)]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL, start_new_session=True)
    deadline = time.monotonic() + 100.0
    while not (tmp_path / ".mini.partial").is_dir():
        assert time.monotonic() < deadline, "the build did not begin"
        time.sleep(0.05)
    time.sleep(1.0)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert not out.exists()
    subprocess.run(command, check=True, capture_output=True, timeout=200)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mini"]
    assert main(["info", str(out)]) == 0


@pytest.mark.egl
@pytest.mark.slow
def test_demo_writes_sheet_recording_and_numbers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["demo", "--out", str(tmp_path / "demo")]) == 0
    text = capsys.readouterr().out
    assert "samples/s" in text
    with Image.open(tmp_path / "demo" / "contact_sheet.png") as sheet:
        assert sheet.width > 1500
        assert sheet.height > 1500
    assert 100_000 < (tmp_path / "demo" / "episode.rrd").stat().st_size <= 3_000_000
