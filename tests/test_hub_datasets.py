"""Datasets of a release on the Hub: the same episodes as from a folder, and no file too many."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest
from hub_client import ADDRESS, cache_fixture, hub_fixture, opened
from hub_server import COMMIT, Hub
from torch.utils.data import DataLoader

from affectsim_data import AffectSimDataset, Release, data_loader
from affectsim_data.loaders import EpisodeStream

__all__ = ["cache_fixture", "hub_fixture"]

pytestmark = pytest.mark.usefixtures("cache")

SELECTIONS: tuple[dict[str, Any], ...] = (
    {},
    {"filter": [("emotion", "=", "sad")]},
    {"filter": [("reference_distance_m", "<", 5.0)]},
    {"episodes": ["small/5", "small/4"]},
    {"exclude": ["small/4"]},
)


@pytest.mark.parametrize("selection", SELECTIONS, ids=str)
def test_a_selection_is_the_same_from_the_hub_and_from_a_folder(
    selection: dict[str, Any], hub: Hub, small_release_path: Path
) -> None:
    far = AffectSimDataset(ADDRESS, split="test", images=False, **selection)
    near = AffectSimDataset(small_release_path, split="test", images=False, **selection)
    expected = [near.episode(row).episode_id for row in range(len(near))]
    assert [far.episode(row).episode_id for row in range(len(far))] == expected
    assert far.fingerprint == near.fingerprint
    loader = data_loader(far, batch_size=1, shuffle="scenes", seed=2)
    assert [b["episode_id"][0] for b in loader] == [
        b["episode_id"][0] for b in data_loader(near, batch_size=1, shuffle="scenes", seed=2)
    ]
    stream = EpisodeStream(far, batch_size=1)
    streamed = [batch["episode_id"][0] for batch in DataLoader(stream, batch_size=None)]
    assert streamed == expected


def test_what_a_filter_leaves_out_is_not_fetched(hub: Hub) -> None:
    # A release of its own: an open one remembers what it has read.
    release, kind = Release(opened()), ("family", "!=", "dyadic")
    dataset = AffectSimDataset(release, split="test", images=False, filter=[kind])
    assert len(dataset) == 1
    list(data_loader(dataset))
    files = dataset.release.manifest.files
    keys = {key for name in hub.fetched() if name in files for key in files[name].keys}
    assert keys == {"empty_room", "sway_happy", "plain"}


def test_samples_and_tokens_carry_the_commit(hub: Hub) -> None:
    dataset = AffectSimDataset(f"{ADDRESS}@main", split="test", images=False)
    pinned = f"{ADDRESS}@{COMMIT}"
    assert dataset[0]["release"] == pinned
    assert data_loader(dataset).state_dict()["release"] == pinned


def test_files_are_fetched_before_their_samples_are_asked_for(hub: Hub) -> None:
    dataset = AffectSimDataset(Release(opened()), split="train", images=False)
    ahead = set(dataset.release.episode_files("train", [1]))
    hub.requests.clear()
    batches = iter(data_loader(dataset, batch_size=1, look_ahead=1))
    next(batches)
    deadline = time.monotonic() + 20.0
    while not ahead <= set(hub.fetched()) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert ahead <= set(hub.fetched()), "the second sample has not been asked for"
