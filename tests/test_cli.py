"""The `affectsim` command: exit statuses, one-line errors, and the demo as a user runs it."""

from __future__ import annotations

import json
import re
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
