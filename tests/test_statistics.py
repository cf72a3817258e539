"""Statistics of episodes against plain Python, their tables and figure, and sheets by eye."""

from __future__ import annotations

import csv
import dataclasses
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from PIL import Image
from small_release import small_rows
from varied_release import RemoteStore, varied_rows, write_varied_release

from affectsim_data.cli import main
from affectsim_data.inspection.contact_sheet import contact_sheet
from affectsim_data.inspection.episode_plans import draw_episode_plan
from affectsim_data.inspection.episode_sheets import sampled_episodes, write_episode_sheets
from affectsim_data.inspection.statistics import (
    KINDS,
    MEASURES,
    chosen_episodes,
    episode_kinds,
    measured_values,
)
from affectsim_data.inspection.statistics_figure import statistics_figure
from affectsim_data.inspection.statistics_lines import statistics_lines
from affectsim_data.inspection.summary import chosen_rows, release_summary, summary_lines
from affectsim_data.motions import EMOTIONS
from affectsim_data.releases import Release, ReleaseWriter, open_release
from affectsim_data.render import process_renderer
from affectsim_data.schemas import SPLITS

ROWS = [row for split in SPLITS for row in varied_rows(split)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("statistics") / "release"
    write_varied_release(out)
    return out


@pytest.fixture(scope="module")
def varied(folder: Path) -> Release:
    return open_release(folder)


@pytest.fixture(scope="module")
def summary(varied: Release) -> dict[str, Any]:
    return release_summary(varied)


def kind_of(row: dict[str, Any]) -> str:
    return str(row["challenge"] or row["family"])


def members(grouped_by: str, group: str) -> list[dict[str, Any]]:
    pick = {"all": lambda _: "all", "split": lambda row: row["split"], "kind": kind_of}[grouped_by]
    return [row for row in ROWS if pick(row) == group]


def test_distributions_agree_with_plain_python(summary: dict[str, Any]) -> None:
    columns = [name for name in MEASURES if name in ROWS[0]]
    assert len(columns) == len(MEASURES) - 2
    for grouped_by, groups in summary["statistics"]["distributions"].items():
        for group, spreads in groups.items():
            rows = members(grouped_by, group)
            assert rows
            for name in columns:
                values = [row[name] for row in rows if row[name] is not None]
                found = spreads[name]
                assert (found["n"], found["missing"]) == (len(values), len(rows) - len(values))
                quartiles = [found[key] for key in ("min", "q25", "median", "q75", "max")]
                np.testing.assert_allclose(
                    quartiles, np.quantile(values, [0.0, 0.25, 0.5, 0.75, 1.0])
                )
                assert found["mean"] == pytest.approx(np.mean(values))


def test_scale_and_balance_agree_with_plain_python(summary: dict[str, Any]) -> None:
    statistics = summary["statistics"]
    for entry in statistics["scale"]:
        rows = [
            row
            for row in ROWS
            if row["family"] == entry["family"] and entry["split"] in (row["split"], "total")
        ]
        assert entry["episodes"] == len(rows)
        assert entry["motions"] == len({row["motion_id"] for row in rows})
        assert entry["scenes"] == len({row["scene_id"] for row in rows})
        assert entry["groups"] == len({row["group_id"] for row in rows})
    for kind, counts in statistics["balance"]["kind"].items():
        found = [row["emotion"] for row in members("kind", kind)]
        assert counts == {emotion: found.count(emotion) for emotion in EMOTIONS}
    nulls = [row["d_star_3m_null"] for row in ROWS if row["d_star_3m_null"]]
    assert statistics["d_star_null"]["d_star_3m"] == {"empty": len(nulls)}
    assert statistics["scenes"]["n"] == len({row["scene_id"] for row in ROWS})
    assert statistics["durations_s"]["max"] == max(row["duration_s"] for row in ROWS)


def test_partners_count_as_performers_and_their_motions(small: Release) -> None:
    (dyad,) = [
        row
        for row in release_summary(small, split="test")["statistics"]["scale"]
        if row["family"] == "dyadic" and row["split"] == "total"
    ]
    assert (dyad["episodes"], dyad["performers"], dyad["motions"]) == (1, 2, 2)


def one_episode(release: Release, **changes: Any) -> dict[str, float]:
    table = chosen_episodes(release, {"test": np.array([0])})
    for name, value in changes.items():
        place = table.column_names.index(name)
        field = table.schema.field(name)
        table = table.set_column(place, field, pa.array([value], field.type))
    return {name: float(values[0]) for name, values in measured_values(table).items()}


def test_bearings_are_folded_and_detours_are_measured_to_the_ring(varied: Release) -> None:
    for bearing, folded in ((170.0, 170.0), (-170.0, 170.0), (190.0, 170.0), (-350.0, 10.0)):
        found = one_episode(varied, initial_bearing_deg=bearing)
        assert found["initial_bearing_abs_deg"] == pytest.approx(folded)
    straight = one_episode(varied, initial_distance_m=4.1, d_star_1m=3.0)
    assert straight["detour_ratio"] == pytest.approx(1.0)
    around = one_episode(varied, initial_distance_m=4.1, d_star_1m=4.5)
    assert around["detour_ratio"] == pytest.approx(1.5)
    at_the_ring = one_episode(varied, initial_distance_m=1.2, d_star_1m=0.1)
    assert np.isnan(at_the_ring["detour_ratio"])
    nowhere = one_episode(varied, d_star_1m=None)
    assert np.isnan(nowhere["d_star_1m"])
    assert np.isnan(nowhere["detour_ratio"])


def test_kinds_are_challenges_or_else_families(varied: Release) -> None:
    table = chosen_episodes(varied, chosen_rows(varied))
    assert episode_kinds(table).tolist() == [kind_of(row) for row in ROWS]


def test_lines_name_what_is_short_and_why(
    summary: dict[str, Any], tmp_path: Path, small: Release
) -> None:
    lines = summary_lines(summary)
    assert max(map(len, lines[3:])) <= 120
    text = "\n".join(lines)
    assert "d*(3), m is null for" in text
    cell = {"split": "test", "family": "dyadic", "challenge": None, "action": "interaction"}
    cells = [
        {**cell, "emotion": emotion, "planned": 5, "composed": count, "binding_constraint": why}
        for emotion, count, why in (("sad", 3, "no room for two"), ("angry", 5, None))
    ]
    manifest = small.manifest
    with ReleaseWriter(tmp_path / "short") as writer:
        rows = [row for row in small_rows()["episodes"] if row["split"] == "test"]
        writer.add_table("episodes", rows, stem="test")
        writer.add_table("cells", cells, stem="test")
        for table in ("motions", "scenes", "avatars"):
            writer.add_table(table, small_rows()[table])
        writer.finish(
            name="short",
            recipe="short",
            seed=1,
            code_version="0.0.0",
            camera=manifest.camera,
            robot=manifest.robot,
            licences=["CC0-1.0"],
        )
    short = release_summary(open_release(tmp_path / "short"))
    assert short["cells"] == {"planned": 10, "composed": 8, "short": cells[:1]}
    told = statistics_lines(short["statistics"], short["cells"])
    assert told[-2:] == [
        "the recipe asks for 10 episodes, there are 8",
        "  test, dyadic, interaction, sad: 3 of 5 (no room for two)",
    ]
    sad = release_summary(open_release(tmp_path / "short"), filter=[("emotion", "==", "sad")])
    assert sad["cells"] is None


def test_tables_and_figure_are_written(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("matplotlib")
    out = tmp_path / "made" / "here"
    assert main(["info", str(folder), "--json", "--out", str(out)]) == 0
    printed = json.loads(capsys.readouterr().out)
    with (out / "emotions.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    in_file = {(row["grouped_by"], row["group"], row["emotion"]): row["episodes"] for row in rows}
    balance = printed["statistics"]["balance"]
    assert in_file["kind", "rear_view", "sad"] == str(balance["kind"]["rear_view"]["sad"])
    with (out / "distributions.csv").open() as stream:
        (row,) = [
            row
            for row in csv.DictReader(stream)
            if (row["group"], row["measure"]) == ("validation", "initial_distance_m")
        ]
    spread = printed["statistics"]["distributions"]["split"]["validation"]["initial_distance_m"]
    assert float(row["median"]) == spread["median"]
    assert {path.name for path in out.iterdir()} == {
        *("statistics.png", "scale.csv", "emotions.csv", "distributions.csv", "scenes.csv")
    }
    with Image.open(out / "statistics.png") as picture:
        assert picture.width > 1.3 * picture.height > 1000
        colors = picture.convert("RGB").getcolors(1 << 20)
    assert colors is not None
    drawn = {color for count, color in colors if count > 500}
    assert {(0, 114, 178), (213, 94, 0), (230, 159, 0), (127, 127, 127)} <= drawn


def test_figures_of_few_episodes_can_be_drawn(small: Release, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    table = chosen_episodes(small, {"test": np.array([1])})
    statistics_figure(table, tmp_path / "one.svg")
    assert b"<svg" in (tmp_path / "one.svg").read_bytes()[:500]


def test_without_matplotlib_the_figure_names_the_extra(
    small: Release, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(ModuleNotFoundError, match=r'pip install "affectsim-data\[plots\]"'):
        statistics_figure(chosen_episodes(small, {"test": np.array([0])}), tmp_path / "x.png")


def test_motions_and_scenes_take_no_selection(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["info", str(folder), "--scenes", "--split-by", "scene"]) == 1
    assert "leave out --split, --split-by and --where" in capsys.readouterr().err


# Sheets.


def test_samples_are_even_over_kinds_and_the_same_every_time(varied: Release) -> None:
    chosen = sampled_episodes(varied, 40, rng=np.random.default_rng(1))
    sizes = [len(episodes) for episodes in chosen.values()]
    assert sum(sizes) == 40
    assert max(sizes) - min(sizes) <= 1
    assert list(chosen) == [kind for kind in KINDS if kind in chosen]
    for kind, episodes in chosen.items():
        assert {episode.challenge or episode.family for episode in episodes} == {kind}
        assert len({episode.episode_id for episode in episodes}) == len(episodes)
    again = sampled_episodes(varied, 40, rng=np.random.default_rng(1))
    assert again == chosen
    assert sampled_episodes(varied, 40, rng=np.random.default_rng(2)) != chosen


def test_samples_take_what_there_is_of_a_selection(varied: Release) -> None:
    sad: list[tuple[str, str, Any]] = [("emotion", "==", "sad")]
    chosen = sampled_episodes(varied, 1000, rng=np.random.default_rng(0), split="train", filter=sad)
    expected = {row["episode_id"] for row in varied_rows("train") if row["emotion"] == "sad"}
    assert {one.episode_id for episodes in chosen.values() for one in episodes} == expected
    with pytest.raises(ValueError, match="at least one episode, got 0"):
        sampled_episodes(varied, 0, rng=np.random.default_rng(0))


def test_only_the_episodes_drawn_are_read(folder: Path) -> None:
    store = RemoteStore(folder)
    sampled_episodes(Release(store), 3, rng=np.random.default_rng(0))
    assert not [name for name in store.read_names if name.startswith(("motions", "scenes"))]


def test_plans_show_the_robot_where_it_starts(small: Release) -> None:
    episode = small.episode("test", 0)
    world = small.world(episode)
    picture = np.asarray(draw_episode_plan(episode, world, size=200), np.int64)

    def middle(color: tuple[int, int, int]) -> np.ndarray:
        found: np.ndarray = np.argwhere(np.abs(picture - color).sum(axis=2) < 60).mean(axis=0)
        return found

    robot, person = middle((0, 114, 178)), middle((213, 94, 0))
    start, anchor = np.array(episode.start_position), np.array(episode.target.anchor)
    way = (start - anchor)[[2, 0]]
    seen = robot - person
    cosine = float(seen @ way / np.linalg.norm(seen) / np.linalg.norm(way))
    assert cosine > 0.95
    turned = dataclasses.replace(episode, start_position=(2.5, 0.0, 0.0))
    other = np.asarray(draw_episode_plan(turned, world, size=200), np.int64)
    found = np.argwhere(np.abs(other - (0, 114, 178)).sum(axis=2) < 60).mean(axis=0)
    assert found[1] > 100.0  # +x is to the right


@pytest.mark.egl
def test_sheets_have_a_page_per_kind_of_ten_rows_at_most(small: Release, tmp_path: Path) -> None:
    renderer = process_renderer("egl")
    one = small.episode("test", 0)
    pages = write_episode_sheets(
        small, {"rear_view": [one] * 11, "dyadic": [one]}, renderer, tmp_path / "sheets"
    )
    assert [path.name for path in pages] == ["rear_view-1.png", "rear_view-2.png", "dyadic.png"]
    heights = []
    for path in pages:
        with Image.open(path) as page:
            heights.append(page.height)
    assert heights[1] == heights[2]
    assert heights[0] > 8 * heights[1]
    bare = contact_sheet(small, [one], renderer, conditions=["p_init"])
    planned = contact_sheet(small, [one], renderer, conditions=["p_init"], plans=True)
    assert planned.width - bare.width == 230


@pytest.mark.egl
def test_inspect_draws_sheets(
    small_release_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["inspect", str(small_release_path), "--sheet", "2", "--split", "test"]
    assert main([*command, "--out", str(tmp_path / "sheets")]) == 0
    printed = capsys.readouterr().out.split()
    assert [Path(name).name for name in printed] == ["rear_view.png", "dyadic.png"]
    assert all(Path(name).is_file() for name in printed)


def test_inspect_takes_an_episode_or_sheets(
    small_release_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["inspect", str(small_release_path)]) == 1
    assert "takes an episode_id, or --sheet N" in capsys.readouterr().err
    assert main(["inspect", str(small_release_path), "small/0", "--sheet", "3"]) == 1
    assert "takes an episode_id, or --sheet N" in capsys.readouterr().err
    assert main(["inspect", str(small_release_path), "small/0", "--split", "test"]) == 1
    assert "go with --sheet" in capsys.readouterr().err
