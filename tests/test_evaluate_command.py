"""`affectsim evaluate` and `report` as a user runs them, on a tiny release."""

from __future__ import annotations

import json
import re
import time
from pathlib import Path

import pytest

from affectsim_data import cli
from affectsim_data.cli import evaluating
from affectsim_data.evaluation.tables import write_predictions

IDS = ("small/4", "small/5")
"""Episodes of the test split: happy and sad."""


@pytest.fixture(autouse=True)
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")


@pytest.fixture
def predictions(tmp_path: Path) -> Path:
    """All right under p_ref; under p_init one right, one in words that must stay text."""
    said = {"p_ref": ("happy", "It is sad."), "p_init": ("happy", "<script>\x1b[31mnothing")}
    rows = [
        {"episode_id": one, "condition": condition, "model": "alpha", "raw_text": text}
        for condition, texts in said.items()
        for one, text in zip(IDS, texts, strict=True)
    ]
    write_predictions(rows, tmp_path / "p.parquet")
    return tmp_path / "p.parquet"


def run(command: str, *arguments: object) -> int:
    return cli.main([command, *map(str, arguments), "--resamples", "100"])


def test_evaluate_prints_scores_gap_and_chance(
    predictions: Path, small_release_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("evaluate", predictions, "--release", small_release_path) == 0
    text = capsys.readouterr().out
    assert "2 episodes, 1 model, 2 conditions" in text
    assert re.search(r"alpha +40\.0† +20\.0†", text)
    assert "Chance (uniform)" in text
    assert "Tests against P-Init" in text
    assert "\x1b" not in text
    assert run("evaluate", predictions, "--release", small_release_path, "--brief") == 0
    assert "Tests against P-Init" not in capsys.readouterr().out


def test_a_selection_is_scored_alone(
    predictions: Path, small_release_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ("evaluate", predictions, "--release", small_release_path, "--brief", "--where")
    assert run(*options, "emotion=happy") == 0
    assert "1 episodes, 1 model" in capsys.readouterr().out
    assert run(*options, "initial_distance_m<0") == 1
    assert "no episode" in capsys.readouterr().err


def test_evaluate_prints_json(
    predictions: Path, small_release_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("evaluate", predictions, "--release", small_release_path, "--json") == 0
    found = json.loads(capsys.readouterr().out)
    scores = {one["condition"]: one["macro_f1"]["value"] for one in found["scores"]}
    assert scores == {"p_ref": pytest.approx(0.4), "p_init": pytest.approx(0.2)}
    assert found["settings"]["num_resamples"] == 100


def test_groups_and_sizes_come_from_a_file(
    predictions: Path,
    small_release_path: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    cards = tmp_path / "models.csv"
    cards.write_text("model,group,parameters\nalpha,Open-source,7B\n")
    options = ("--release", small_release_path, "--models-file", cards, "--brief")
    assert run("evaluate", predictions, *options) == 0
    text = capsys.readouterr().out
    assert "Open-source" in text
    assert "7B" in text


def test_broken_tables_are_listed_and_nothing_is_scored(
    small_release_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "p.csv"
    path.write_text("episode_id,condition,model,label\nsmall/9,p_ref,alpha,happy\n")
    assert run("evaluate", path, "--release", small_release_path) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("affectsim: ")
    assert "small/9" in captured.err
    assert str(path) in captured.err
    assert "Traceback" not in captured.err
    assert run("evaluate", tmp_path / "none.csv", "--release", small_release_path) == 1
    assert "none.csv" in capsys.readouterr().err


def test_report_writes_a_folder_and_keeps_one_that_is_there(
    predictions: Path,
    small_release_path: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    pytest.importorskip("matplotlib")
    out = tmp_path / "report"
    options = ("--release", small_release_path, "--out", out)
    assert run("report", predictions, *options) == 0
    captured = capsys.readouterr()
    assert "Macro-F1 (%) with intervals" in captured.out
    assert f"{out}/report.html and" in captured.err
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "&lt;script&gt;[U+001B][31mnothing" in page
    assert "<script" not in page
    assert (out / "figures" / "models.png").stat().st_size > 1000
    start = time.perf_counter()
    assert run("report", predictions, *options) == 1
    assert time.perf_counter() - start < 1.0, "is refused before the work is done"
    assert "holds a report already; add --overwrite" in capsys.readouterr().err


def test_patience_is_told_on_stderr(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(evaluating, "_PATIENCE_S", 0.05)
    with evaluating._telling("counting"):
        time.sleep(0.3)
    with evaluating._telling("nothing"):
        pass
    time.sleep(0.1)
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", "counting ...\n")


def test_help_says_what_is_read(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        cli.main(["report", "--help"])
    text = capsys.readouterr().out
    for option in ("--out", "--trajectories", "--models-file", "--allow-missing", "--cluster"):
        assert option in text
