"""Summaries and plots of motions: counts, components of variance, text, pictures."""

from __future__ import annotations

import builtins
import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from PIL import Image
from small_release import small_motions, write_release

from affectsim_data import EMOTIONS, Release, open_release
from affectsim_data.inspection.motion_plots import EMOTION_COLORS, motion_plot
from affectsim_data.inspection.motion_summary import (
    GAIT_COLUMNS,
    descriptor_label,
    motion_descriptors,
    motion_summary,
    motion_summary_lines,
)
from affectsim_data.inspection.variance import variance_components
from affectsim_data.motions.descriptors import (
    MAIN_DESCRIPTORS,
    kinematic_descriptors,
    walk_kinematics,
)


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Release:
    folder = tmp_path_factory.mktemp("motions") / "small"
    write_release(folder)
    return open_release(folder)


@pytest.fixture(scope="module")
def table(small: Release) -> pa.Table:
    return motion_descriptors(small, progress=False)


def test_descriptors_of_a_release_are_those_of_its_motions(table: pa.Table) -> None:
    motions = small_motions()
    assert table.column("motion_id").to_pylist() == list(motions)
    for row in table.to_pylist():
        motion = motions[row["motion_id"]]
        for name, value in kinematic_descriptors(motion).items():
            assert row[name] == pytest.approx(value, rel=1e-6, abs=1e-9), name
        walks = motion.action == "simple_walk"
        gait = walk_kinematics(motion).speed_m_s if walks else None
        assert row["walk_speed_m_s"] == (pytest.approx(gait) if walks else None)
        assert all((row[name] is None) != walks for name in GAIT_COLUMNS)


def test_the_summary_counts_and_averages(table: pa.Table) -> None:
    summary = motion_summary(table)
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary
    assert (summary["motions"], summary["performers"]) == (7, 3)
    assert list(summary["emotions"]) == list(EMOTIONS)
    sad = summary["emotions"]["sad"]
    assert (sad["motions"], sad["performers"]) == (2, 2)
    assert sad["action"] == {"simple_walk": 1, "sway": 1}
    assert summary["emotions"]["happy"]["descriptors"]["bounce_m"]["sd"] is None
    rows = [row for row in table.to_pylist() if row["emotion"] == "sad"]
    values = [row["hands_speed_mean_m_s"] for row in rows]
    found = sad["descriptors"]["hands_speed_mean_m_s"]
    assert found["mean"] == pytest.approx(sum(values) / 2.0)
    assert found["sd"] == pytest.approx(abs(values[0] - values[1]) / np.sqrt(2.0))
    assert sad["duration_s"] == {"mean": 2.5, "sd": pytest.approx(np.sqrt(0.5))}
    assert summary["actions"]["sway"]["emotion"] == dict.fromkeys(EMOTIONS, 1)
    assert list(summary["gait"]) == ["angry", "sad"]


def test_a_release_and_its_table_have_one_summary(small: Release, table: pa.Table) -> None:
    assert motion_summary(small) == motion_summary(table)


def grid(
    rng: np.random.Generator, *, emotion_sd: float, performer_sd: float, noise_sd: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Two actions with shifted means, 5 emotions, 40 performers, 3 takes each."""
    emotion = np.array([-1.5, -0.5, 0.0, 0.5, 1.5])
    emotion *= emotion_sd / emotion.std(ddof=1)
    performer = rng.normal(0.0, 1.0, 40)
    performer *= performer_sd / performer.std(ddof=1)
    act, emo, who, _ = (axis.ravel() for axis in np.indices((2, 5, 40, 3)))
    values = 10.0 * act + emotion[emo] + performer[who] + rng.normal(0.0, noise_sd, len(act))
    return values[:, None], np.array(EMOTIONS)[emo], who.astype(str), act.astype(str)


def test_components_of_variance_are_found_again() -> None:
    rng = np.random.default_rng(5)
    found = variance_components(*grid(rng, emotion_sd=2.0, performer_sd=0.8, noise_sd=0.5))
    assert found["emotion_sd"][0] == pytest.approx(2.0, rel=0.05)
    assert found["performer_sd"][0] == pytest.approx(0.8, rel=0.1)
    assert found["residual_sd"][0] == pytest.approx(0.5, rel=0.1)
    assert found["performer_to_emotion"][0] == pytest.approx(0.4, rel=0.1)


def test_noise_is_not_taken_for_performers() -> None:
    rng = np.random.default_rng(6)
    found = variance_components(*grid(rng, emotion_sd=1.0, performer_sd=0.0, noise_sd=1.0))
    assert found["performer_sd"][0] < 0.12  # without the correction: about 0.26
    assert found["emotion_sd"][0] == pytest.approx(1.0, rel=0.1)


def test_components_need_more_motions_than_effects() -> None:
    labels = np.array(["happy", "sad"]), np.array(["p0", "p1"]), np.array(["walk", "walk"])
    found = variance_components(np.ones((2, 3)), *labels)
    assert all(np.isnan(column).all() and column.shape == (3,) for column in found.values())


def test_unbalanced_performers_do_not_pass_for_emotions() -> None:
    """One performer moves twice as much, and does mostly anger."""
    rows = [("angry", "a")] * 6 + [("angry", "b")] + [("sad", "a")] + [("sad", "b")] * 6
    emotions, performers = (np.array(column) for column in zip(*rows, strict=True))
    values = np.where(performers == "a", 2.0, 1.0)[:, None]
    found = variance_components(values, emotions, performers, np.full(len(rows), "walk"))
    assert found["emotion_sd"][0] == pytest.approx(0.0, abs=1e-7)
    assert found["performer_sd"][0] == pytest.approx(np.sqrt(0.5))


def test_lines_are_aligned_and_say_units(table: pa.Table) -> None:
    lines = motion_summary_lines(motion_summary(table))
    assert max(map(len, lines)) <= 120
    header = next(line for line in lines if "angry" in line)
    assert header.split() == [*EMOTIONS, "perf./emotion"]
    jerk = next(line for line in lines if line.startswith("hands jerk, m/s3"))
    ends = [header.index(emotion) + len(emotion) for emotion in EMOTIONS]
    assert all(jerk[end - 1] != " " and jerk[end : end + 1] in (" ", "") for end in ends)
    assert sum(line.startswith("cadence, /min") for line in lines) == 1
    assert any(line.split() == ["sway", *"11111"] for line in lines)


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("body_speed_mean_m_s", "body speed, m/s"),
        ("trunk_pitch_mean_deg", "trunk pitch, deg"),
        ("hand_span_mean", "hand span, share"),
        ("bounce_m", "bounce, m"),
        ("cadence_steps_min", "cadence, /min"),
    ],
)
def test_labels_have_units(name: str, label: str) -> None:
    assert descriptor_label(name) == label


def test_plots_show_every_emotion(table: pa.Table, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="the extra `plots`")
    path = tmp_path / "motions.png"
    motion_plot(table, path)
    image = np.asarray(Image.open(path).convert("RGB")).astype(int)
    assert image.shape[1] > 1500
    for color in EMOTION_COLORS.values():
        rgb = [int(color[place : place + 2], 16) for place in (1, 3, 5)]
        assert (np.abs(image - rgb).max(axis=-1) < 6).sum() > 20, color
    motion_plot(table, tmp_path / "one.svg", descriptors=MAIN_DESCRIPTORS[:1])
    assert (tmp_path / "one.svg").read_text(encoding="utf-8").startswith("<?xml")
    with pytest.raises(KeyError, match=r"no descriptors \['speed'\]"):
        motion_plot(table, path, descriptors=["speed"])


def test_plots_say_what_to_install(
    table: pa.Table, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = builtins.__import__

    def without(name: str, *args: Any, **kwargs: Any) -> Any:
        if name.startswith("matplotlib"):
            raise ModuleNotFoundError(f"No module named {name!r}")
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(ModuleNotFoundError, match=r'pip install "affectsim-data\[plots\]"'):
        motion_plot(table, tmp_path / "motions.png")
