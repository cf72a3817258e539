"""Sheets, recordings, summaries and the doctor: what a user looks at."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_release import box_room

from affectsim_data import AffectSimDataset, Clip, Orbit, Release, open_release
from affectsim_data.cards import dataset_card
from affectsim_data.inspection.contact_sheet import contact_sheet, representative_episodes
from affectsim_data.inspection.doctor import examine
from affectsim_data.inspection.recording import record_episode
from affectsim_data.inspection.scene_recording import _simplified
from affectsim_data.inspection.summary import release_summary, summary_lines
from affectsim_data.inspection.views import draw_views
from affectsim_data.render import process_renderer
from affectsim_data.schemas import SPLITS


@pytest.fixture(scope="module")
def mini() -> Release:
    return open_release("mini")


def test_representatives_cover_families_and_challenges(mini: Release) -> None:
    chosen = representative_episodes(mini)
    assert {episode.family for episode in chosen} == {
        "action_grounded",
        "observation_controlled",
        "dyadic",
    }
    assert len({episode.challenge for episode in chosen}) == 5
    assert len({episode.emotion for episode in chosen}) >= 4
    assert len({episode.episode_id for episode in chosen}) == len(chosen)


@pytest.mark.egl
def test_sheet_shows_what_the_dataset_yields(mini: Release) -> None:
    episode = representative_episodes(mini)[0]
    orbit = Orbit(distance_m=2.0, azimuth_deg=45.0)
    sheet = np.asarray(
        contact_sheet(mini, [episode], process_renderer("egl"), conditions=["p_ref", orbit])
    )
    clip = Clip(num_frames=5, width=224, height=224)
    dataset = AffectSimDataset(mini, split=episode.split, condition=orbit, clip=clip)
    ids = [dataset.episode(i).episode_id for i in range(len(dataset))]
    place = ids.index(episode.episode_id)
    frame = dataset[place]["video"][1].permute(1, 2, 0).numpy()
    rows, columns = sheet.shape[0] - 224, sheet.shape[1] - 224
    found = any(
        np.array_equal(sheet[y : y + 224, x : x + 224], frame)
        for y in range(40, rows + 1)
        for x in range(columns // 2, columns + 1)
        if np.array_equal(sheet[y, x : x + 224], frame[0])
    )
    assert found


@pytest.mark.egl
def test_reference_shows_the_person_larger_than_the_monitor(mini: Release) -> None:
    sizes = {}
    for condition in ("p_ref", "p_mon"):
        dataset = AffectSimDataset(mini, split="test", condition=condition, instances=True)
        shares = [(dataset[i]["instances"] == 1).float().mean() for i in range(0, 30, 3)]
        sizes[condition] = float(np.mean(shares))
    assert sizes["p_ref"] > 2.0 * sizes["p_mon"] > 0.0


@pytest.mark.egl
def test_recordings_are_small_and_complete(mini: Release, tmp_path: Path) -> None:
    for episode in representative_episodes(mini):
        path = tmp_path / "episode.rrd"
        record_episode(episode, mini.world(episode), process_renderer("egl"), path)
        payload = path.read_bytes()
        assert payload[:3] == b"RRF"
        assert len(payload) <= 3_000_000, f"{episode.episode_id}: {len(payload)} bytes"
        for entity in ("world/people/target/body", "world/cameras/p_ref", "world/cameras/p_init"):
            assert entity.encode() in payload


def test_simplified_surfaces_keep_their_extent() -> None:
    for surface in box_room("r").surfaces:
        positions, colors, faces = _simplified(surface)
        assert len(positions) == len(colors)
        assert len(faces)
        assert faces.max() < len(positions)
        np.testing.assert_allclose(positions.min(0), surface.positions.min(0), atol=0.06)
        np.testing.assert_allclose(positions.max(0), surface.positions.max(0), atol=0.06)


@pytest.mark.egl
def test_views_are_drawn_for_every_condition(small: Release) -> None:
    episode = small.episode("test", 0)
    clip = Clip(num_frames=2, width=32, height=24)
    views = draw_views(episode, small.world(episode), process_renderer("egl"), clip=clip)
    assert list(views)[:3] == ["p_init", "p_ref", "p_mon"]
    assert all(frames.shape == (2, 24, 32, 3) for frames in views.values())


@pytest.mark.egl
def test_doctor_draws_and_names_the_device() -> None:
    lines, works = examine()
    text = "\n".join(lines)
    assert works
    assert "test triangle    drawn" in text
    assert "OpenGL" in text


def test_doctor_says_how_to_mend_a_missing_driver(monkeypatch: pytest.MonkeyPatch) -> None:
    from affectsim_data.errors import RendererUnavailableError
    from affectsim_data.render import device

    def broken(_: int | None = None) -> None:
        raise RendererUnavailableError("no EGL: apt-get install -y libegl1")

    monkeypatch.setattr(device, "describe_device", broken)
    lines, works = examine()
    assert not works
    assert any("NOT WORKING" in line for line in lines)
    assert any("apt-get install -y libegl1" in line for line in lines)


def test_summary_counts_agree_with_the_manifest(small: Release) -> None:
    summary = release_summary(small)
    counts = summary["episodes"]
    total = small.manifest.num_rows("episodes")
    assert all(sum(counts[column].values()) == total for column in counts)
    assert summary["assets"]["scenes"] == len(small.asset_ids("scenes"))
    assert summary["measured"]["initial_distance_m"]["n"] == total
    assert any("split" in line for line in summary_lines(summary))


def test_summary_of_a_selection_counts_it_and_names_it(small: Release) -> None:
    filter: list[tuple[str, str, Any]] = [("emotion", "in", ["sad", "angry"])]
    summary = release_summary(small, filter=filter)
    assert summary["episodes"]["emotion"] == {"angry": 1, "sad": 2}
    assert summary["episodes"]["split"] == {"train": 2, "test": 1}
    assert summary["measured"]["initial_distance_m"]["n"] == 3
    for split, count in (("train", 2), ("test", 1)):
        dataset = AffectSimDataset(small, split=split, filter=filter)
        entry = {"selected": count, "of": 2, "fingerprint": dataset.fingerprint}
        assert summary["selection"][split] == entry
        line = f"{split:12} {count} of 2 episodes, fingerprint {dataset.fingerprint[:16]}"
        assert f"  {line}" in summary_lines(summary)
        of_dataset = release_summary(dataset)
        assert of_dataset == release_summary(small, split=split, filter=filter)
        assert of_dataset["episodes"]["split"] == {split: count}


def test_summary_of_the_whole_names_every_split(small: Release) -> None:
    entries = release_summary(small)["selection"]
    assert {split: entry["fingerprint"] for split, entry in entries.items()} == {
        split: AffectSimDataset(small, split=split).fingerprint for split in SPLITS
    }


def test_summary_of_nothing_is_refused(small: Release) -> None:
    with pytest.raises(ValueError, match=r"no episode of train, validation, test matches .*angry"):
        release_summary(small, filter=[("emotion", "==", "bored")])
    with pytest.raises(ValueError, match="split must be one of"):
        release_summary(small, split="dev")
    dataset = AffectSimDataset(small, split="test")
    with pytest.raises(ValueError, match="a dataset has its split and filter"):
        release_summary(dataset, split="test")


def test_card_names_every_split_file_pattern_and_licence(small: Release) -> None:
    card = dataset_card(small, place="hf://datasets/org/name@main")
    for split in ("train", "validation", "test"):
        assert f"path: episodes/{split}-*.parquet" in card
    assert 'AffectSimDataset("hf://datasets/org/name@main"' in card
    assert all(licence in card for licence in small.manifest.licences)
    assert "$" not in card.replace("$$", "")
