"""`AffectSimDataset`: the sample contract, the same pixels everywhere, and clear refusals."""

from __future__ import annotations

import hashlib
import multiprocessing
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from small_release import write_release
from torch.utils.data import DataLoader

from affectsim_data import AffectSimDataset, Clip, Orbit, Sample, data_loader
from affectsim_data.loaders import condition_names, resolve_clip, resolve_condition
from affectsim_data.observations import PRef

CLIP = Clip(num_frames=3, width=48, height=48)


def pixels(sample: Sample) -> str:
    """Hash of everything drawn in a sample, video and depth."""
    payload = sample["video"].numpy().tobytes() + sample["depth"].numpy().tobytes()
    return hashlib.sha256(payload).hexdigest()


def hashes(loader: DataLoader[Any]) -> dict[str, str]:
    return {sample["episode_id"]: pixels(sample) for sample in loader}


def identity(samples: list[Sample]) -> Sample:
    return samples[0]


@pytest.mark.egl
def test_sample_has_the_shapes_units_and_provenance_it_promises(small_release_path: Path) -> None:
    dataset = AffectSimDataset(small_release_path, split="test", condition="p_ref", instances=True)
    sample: Sample = dataset[0]
    episode = dataset.episode(0)
    assert sample["video"].shape == (8, 3, 224, 224)
    assert sample["video"].dtype == torch.uint8
    assert sample["depth"].shape == (8, 1, 224, 224)
    assert sample["depth"].dtype == torch.float32
    assert sample["instances"].shape == (8, 1, 224, 224)
    assert set(np.unique(sample["instances"].numpy()).tolist()) <= {0, 1, 2}
    assert sample["T_world_camera"].shape == (8, 4, 4)
    assert sample["T_world_camera"].dtype == torch.float64
    assert sample["intrinsics"].shape == (3, 3)
    assert sample["label"] == episode.label
    assert sample["motion_id"] == episode.target.motion_id
    assert sample["release"] == str(small_release_path)
    last = round(2 * episode.duration_s * 30) - 1
    expected = np.round(np.linspace(0, last, 8)).astype(int)
    assert sample["frame_indices"].tolist() == expected.tolist()
    np.testing.assert_allclose(sample["time_s"].numpy(), expected / 30.0, atol=1e-12)
    near = sample["depth"][sample["instances"] == 1]
    assert abs(float(sample["distance_m"].mean()) - float(near.mean())) < 0.5
    finite = sample["depth"][torch.isfinite(sample["depth"])]
    assert 0.05 < finite.min() < finite.max() < 30.0


@pytest.mark.egl
def test_conditions_differ_only_in_the_camera(small_release_path: Path) -> None:
    conditions = ("p_init", "p_ref", "p_mon", Orbit(distance_m=1.5, azimuth_deg=90.0))
    samples = [
        AffectSimDataset(small_release_path, split="test", condition=c, clip=CLIP)[0]
        for c in conditions
    ]
    for sample in samples[1:]:
        for name in ("frame_indices", "time_s", "intrinsics"):
            assert torch.equal(sample[name], samples[0][name])
        for name in ("label", "motion_id", "scene_id", "episode_id"):
            assert sample[name] == samples[0][name]
        assert not torch.equal(sample["T_world_camera"], samples[0]["T_world_camera"])
        assert pixels(sample) != pixels(samples[0])


@pytest.mark.egl
def test_stock_loader_collates_samples(small_release_path: Path) -> None:
    dataset = AffectSimDataset(small_release_path, split="train", condition="p_init", clip=CLIP)
    batch = next(iter(DataLoader(dataset, batch_size=2)))
    assert batch["video"].shape == (2, 3, 3, 48, 48)
    assert batch["label"].tolist() == [dataset.episode(0).label, dataset.episode(1).label]
    assert batch["episode_id"] == [dataset.episode(i).episode_id for i in range(2)]
    assert all(isinstance(one, str) for one in batch["challenge"])


@pytest.mark.egl
def test_transform_sees_the_sample_and_its_result_is_yielded(small_release_path: Path) -> None:
    def label_and_mean(sample: Sample) -> tuple[int, float]:
        return sample["label"], float(sample["video"].float().mean())

    dataset = AffectSimDataset(
        small_release_path, split="test", condition="p_init", clip=CLIP, transform=label_and_mean
    )
    label, mean = dataset[0]
    assert label == dataset.episode(0).label
    assert 1.0 < mean < 254.0


@pytest.mark.egl
@pytest.mark.parametrize("method", ["fork", "forkserver", "spawn"])
def test_workers_of_every_kind_draw_the_same_pixels(small_release_path: Path, method: str) -> None:
    dataset = AffectSimDataset(small_release_path, split="train", condition="p_ref", clip=CLIP)
    expected = hashes(DataLoader(dataset, batch_size=1, collate_fn=identity))
    for num_workers in (1, 2):
        loader = DataLoader(
            dataset,
            batch_size=1,
            shuffle=True,
            collate_fn=identity,
            num_workers=num_workers,
            multiprocessing_context=multiprocessing.get_context(method),
            timeout=120,
        )
        assert hashes(loader) == expected


@pytest.mark.egl
def test_data_loader_helper_draws_the_same_pixels(small_release_path: Path) -> None:
    dataset = AffectSimDataset(small_release_path, split="train", condition="p_init", clip=CLIP)
    expected = hashes(DataLoader(dataset, batch_size=1, collate_fn=identity))
    loader = data_loader(dataset, num_workers=2, batch_size=1, collate_fn=identity, timeout=120)
    assert loader.multiprocessing_context.get_start_method() == "forkserver"
    assert hashes(loader) == expected


_FRESH = """
import sys
from affectsim_data import AffectSimDataset, Clip
from test_dataset import pixels
dataset = AffectSimDataset(sys.argv[1], split="train", condition="p_mon", clip=Clip(3, 48, 48))
order = range(len(dataset)) if sys.argv[2] == "up" else reversed(range(len(dataset)))
found = {i: pixels(dataset[i]) for i in order}
print(" ".join(found[i] for i in sorted(found)))
"""


@pytest.mark.egl
def test_pixels_do_not_depend_on_process_or_order(small_release_path: Path) -> None:
    runs = [
        subprocess.run(
            [sys.executable, "-c", _FRESH, str(small_release_path), order],
            check=True,
            capture_output=True,
            text=True,
            timeout=120,
        ).stdout
        for order in ("up", "down")
    ]
    assert runs[0] == runs[1]
    assert len(runs[0].split()) >= 2


@pytest.mark.egl
def test_reference_renderer_draws_the_same_scene(small_release_path: Path) -> None:
    # Large enough that pixels on edges, where one sample of four decides, are few.
    clip = Clip(num_frames=2, width=224, height=224)
    samples = [
        AffectSimDataset(
            small_release_path, split="test", condition="p_ref", clip=clip, renderer=name
        )[0]
        for name in ("egl", "pyrender")
    ]
    fast, slow = (sample["depth"].numpy() for sample in samples)
    both = np.isfinite(fast) & np.isfinite(slow)
    assert both.mean() > 0.9
    assert np.mean(np.abs(fast - slow)[both] < 0.005) >= 0.98


def test_length_and_bounds(small_release_path: Path) -> None:
    dataset = AffectSimDataset(small_release_path, split="test", condition="p_init")
    assert len(dataset) == dataset.release.manifest.num_rows("episodes", "test")
    with pytest.raises(IndexError, match=rf"has {len(dataset)} episodes, got index {len(dataset)}"):
        dataset.episode(len(dataset))
    assert dataset.episode(-1).episode_id == dataset.episode(len(dataset) - 1).episode_id


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"condition": "p_best"}, r"condition must be one of .*p_init.*got 'p_best'"),
        ({"split": "dev"}, r"split must be one of train, validation, test, got 'dev'"),
        ({"clip": "9x9"}, r"clip must be a Clip or one of .*8x224.*got '9x9'"),
        ({"condition": 3}, r"a condition has a name and a trajectory method, got 3"),
    ],
)
def test_unknown_words_are_refused(
    small_release_path: Path, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        AffectSimDataset(small_release_path, **options)


def test_empty_split_is_refused(tmp_path: Path) -> None:
    write_release(tmp_path / "half", splits=("train",))
    with pytest.raises(ValueError, match=r"split 'test' is empty"):
        AffectSimDataset(tmp_path / "half", split="test")


def test_unknown_release_says_what_was_expected(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"expected a folder with a MANIFEST\.json, hf://"):
        AffectSimDataset(tmp_path / "nothing")


def test_presets_resolve_by_name() -> None:
    assert {"p_init", "p_ref", "p_mon"} <= set(condition_names())
    assert isinstance(resolve_condition("p_ref"), PRef)
    assert resolve_clip("16x224").num_frames == 16
    assert len(resolve_clip("full").frame_indices(77)) == 77


@pytest.mark.parametrize(
    "make",
    [
        lambda: Clip(num_frames=0, width=8, height=8),
        lambda: Clip(num_frames=10**9, width=8, height=8),
    ],
)
def test_impossible_clips_are_refused(make: Callable[[], Clip]) -> None:
    with pytest.raises(ValueError, match="num_frames must be 1 to"):
        make()
