"""The command `affectsim validate`, and the pictures it draws."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from small_release import write_release

from affectsim_data.builders.validation import Failure, ValidationReport
from affectsim_data.cli import main
from affectsim_data.inspection.validation_pictures import failure_pictures
from affectsim_data.releases import open_release


def test_the_status_is_0_only_if_every_check_holds(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "small"
    write_release(folder)
    path = tmp_path / "report.parquet"
    arguments = ["validate", str(folder), "--jobs", "1", "--sample", "all"]
    assert main([*arguments, "--json", "--report", str(path)]) == 1
    printed = capsys.readouterr()
    document = json.loads(printed.out)
    assert document["holds"] is False
    assert "the manifest holds no recipe" in str(document["failures"])
    assert path.is_file()
    assert f"{path}: " in printed.err

    def passing(release: str, *, sample: int | None, jobs: int | None) -> ValidationReport:
        assert (release, sample, jobs) == (str(folder), None, 1)
        return ValidationReport(release, 6, ())

    monkeypatch.setattr("affectsim_data.builders.validation.validate_release", passing)
    assert main(arguments) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "valid: all 0 checks hold"


def test_a_place_without_a_release_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["validate", str(tmp_path)]) == 1
    assert "MANIFEST.json" in capsys.readouterr().err


@pytest.mark.egl
def test_failed_episodes_are_drawn_check_by_check(tmp_path: Path) -> None:
    from affectsim_data.render import open_renderer

    write_release(tmp_path / "small")
    release = open_release(tmp_path / "small")
    one = Failure("phase", "episode", "small/0", 2.0, 0.0, 1.0, "Phase: expected 0 to 1, got 2")
    failures = [
        one,
        dataclasses.replace(one, item="small/1"),
        dataclasses.replace(one, item="small/1", check="d_star"),
        dataclasses.replace(one, item="small/2", check="d_star"),
        dataclasses.replace(one, item="train", level="release"),
        dataclasses.replace(one, item="small/99"),
    ]
    paths = failure_pictures(release, failures, open_renderer(), tmp_path / "images", most=3)
    # Checks take turns, so that the second one is shown before the first is through.
    assert [path.name for path in paths] == [
        *("phase__small__0.png", "d_star__small__2.png", "phase__small__1.png"),
    ]
    with Image.open(paths[0]) as picture:
        pixels = np.asarray(picture.convert("RGB"))
    assert pixels.shape[0] > 600
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 500
