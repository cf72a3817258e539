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
from varied_release import RemoteStore, varied_rows, write_varied_release

from affectsim_data import AffectSimDataset, Clip, Orbit, Sample, data_loader
from affectsim_data.loaders import condition_names, resolve_clip, resolve_condition
from affectsim_data.loaders.places import Place
from affectsim_data.observations import PRef
from affectsim_data.releases import Release
from affectsim_data.releases.splits import SplitTable

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


# Without images: what a sample says is the same, and no device is needed.


@pytest.mark.egl
def test_samples_without_images_say_the_same(small_release_path: Path) -> None:
    for condition in ("p_init", Orbit(distance_m=1.5)):
        drawn, told = (
            AffectSimDataset(
                small_release_path, split="test", condition=condition, clip=CLIP, images=images
            )[1]
            for images in (True, False)
        )
        assert drawn.keys() - told.keys() == {"video", "depth"}
        for name, value in told.items():
            equal = torch.equal if isinstance(value, torch.Tensor) else lambda a, b: bool(a == b)
            assert equal(value, drawn[name]), name


def test_joint_positions_are_where_the_targets_joints_are(small_release_path: Path) -> None:
    dataset = AffectSimDataset(small_release_path, split="test", images=False)
    sample: Sample = dataset[1]
    assert sample["joint_positions"].dtype == torch.float32
    instants = dataset.episode(1).phase_s + sample["time_s"].numpy()
    frames = dataset.world(1).target.joint_frames(instants)
    found = sample["joint_positions"].numpy()
    np.testing.assert_allclose(found, frames[..., :3, 3], atol=1e-6)
    eye = sample["T_world_camera"][:, :3, 3].numpy()
    distance = np.linalg.norm(eye - frames[:, 0, :3, 3], axis=1)
    np.testing.assert_allclose(sample["distance_m"].numpy(), distance, atol=1e-12)


def test_instances_without_images_are_refused(small_release_path: Path) -> None:
    with pytest.raises(ValueError, match="instances=True needs images=True"):
        AffectSimDataset(small_release_path, images=False, instances=True)


_NO_GL = """
import sys
from affectsim_data import AffectSimDataset
sample = AffectSimDataset(sys.argv[1], split="test", images=False)[0]
assert not {"moderngl", "pyrender", "OpenGL"} & set(sys.modules)
print(sample["episode_id"])
"""


def test_samples_without_images_load_no_gl(small_release_path: Path) -> None:
    command = [sys.executable, "-c", _NO_GL, str(small_release_path)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=120)
    assert done.stdout == "small/4\n"


# Asked for by a place in an order.


@pytest.fixture(scope="module")
def varied_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("varied") / "release"
    write_varied_release(out)
    return out


def told(source: Path | Release, **options: Any) -> AffectSimDataset:
    return AffectSimDataset(source, split="train", images=False, clip=CLIP, **options)


def test_a_place_is_written_into_the_sample(varied_path: Path) -> None:
    dataset = told(varied_path)
    asked = dataset[Place(3, 2, 77, padding=True)]
    assert (asked["epoch"], asked["position"], asked["padding"]) == (2, 77, True)
    for index, row in ((3, 3), (np.int64(3), 3), (-1, 299)):
        plain = dataset[index]
        assert (plain["epoch"], plain["position"], plain["padding"]) == (0, row, False)
        assert plain["episode_id"] == varied_rows("train")[row]["episode_id"]
    assert asked["episode_id"] == dataset[3]["episode_id"]


def test_several_at_once_are_those_one_by_one_in_order(varied_path: Path) -> None:
    dataset = told(varied_path).subset(range(299, 0, -2))
    rows = [7, 0, 7, -1]
    several = dataset.__getitems__([Place(7, 1, 9), *rows[1:]])
    assert [one["episode_id"] for one in several] == [dataset[row]["episode_id"] for row in rows]
    assert [one["position"] for one in several] == [9, 0, 7, len(dataset) - 1]


@pytest.mark.parametrize(
    ("index", "kind", "message"),
    [
        (300, IndexError, "split 'train' has 300 episodes, got index 300"),
        (-301, IndexError, "split 'train' has 300 episodes, got index -301"),
        (Place(300, 0, 0), IndexError, "split 'train' has 300 episodes, got index 300"),
        (1.0, TypeError, r"an int or a Place, got 1\.0; dataset\.subset"),
        (slice(3), TypeError, r"an int or a Place, got slice\(None, 3, None\)"),
    ],
)
def test_requests_outside_a_dataset_are_refused(
    varied_path: Path, index: Any, kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind, match=message):
        told(varied_path)[index]
    with pytest.raises(kind, match=message):
        told(varied_path).__getitems__([0, index])


def test_what_samples_need_is_prefetched_in_order_of_use(varied_path: Path) -> None:
    store = RemoteStore(varied_path)
    dataset = told(Release(store)).subset(range(280, -1, -20))
    rows = dataset.rows
    dataset.__getitems__([Place(0, 0, 0, ahead=(3, 4)), Place(1, 0, 1, ahead=(4, 2)), 5])
    expected = dataset.release.episode_files("train", rows[[0, 1, 5, 3, 4, 2]])
    assert store.prefetched == [expected]
    first = dataset.release.episode_files("train", rows[:1])
    assert expected[: len(first)] == first
    assert set(expected) <= set(store.manifest.files)

    dataset[Place(6, 0, 2, ahead=(7,))]
    assert store.prefetched[1:] == [dataset.release.episode_files("train", rows[[6, 7]])]
    dataset[6]
    assert len(store.prefetched) == 2, "one plain index has nothing ahead"


def test_rows_ahead_are_not_read(varied_path: Path) -> None:
    store = RemoteStore(varied_path)
    told(Release(store))[Place(0, 0, 0, ahead=tuple(range(1, 300)))]
    shards = [name for name in store.read_names if name.startswith("episodes/")]
    assert shards == store.manifest.table_files("episodes", "train")[:1]


def test_folders_are_not_asked_for_files_ahead(
    varied_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dataset = told(Release(RemoteStore(varied_path)))
    near = told(varied_path)
    monkeypatch.setattr(SplitTable, "files", lambda *_: 1 / 0)
    assert near.__getitems__([Place(0, 0, 0, ahead=(1, 2))])[0]["position"] == 0
    with pytest.raises(ZeroDivisionError):
        dataset.__getitems__([0])


# Parts.


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        ([5, -1, 0], [5, 299, 0]),
        (np.array([2, 2]), [2, 2]),
        (range(10, 13), [10, 11, 12]),
        (slice(None, None, -150), [299, 149]),
        (np.arange(300) % 100 == 1, [1, 101, 201]),
        (torch.tensor([4, 3]), [4, 3]),
    ],
)
def test_subsets_by_places_slices_and_masks(
    varied_path: Path, rows: Any, expected: list[int]
) -> None:
    dataset = told(varied_path)
    part = dataset.subset(rows)
    assert part.rows.tolist() == expected
    assert part.release is dataset.release
    assert [part[i]["episode_id"] for i in range(len(part))] == [
        dataset[i]["episode_id"] for i in expected
    ]
    assert part.scene_codes.tolist() == dataset.scene_codes[expected].tolist()
    assert len(dataset) == 300


@pytest.mark.parametrize(
    ("rows", "kind", "message"),
    [
        ([300], IndexError, "subset: the dataset has 300 episodes, got index 300"),
        ([], ValueError, "no episode of 300 is chosen"),
        (np.zeros(300, bool), ValueError, "no episode of 300 is chosen"),
        (np.ones(3, bool), ValueError, r"the mask must be \(300,\), got \(3,\)"),
        ([0.5], ValueError, r"takes places, a slice or a mask, got float64 of shape \(1,\)"),
        (3, ValueError, r"takes places, a slice or a mask, got int64 of shape \(\)"),
    ],
)
def test_impossible_subsets_are_refused(
    varied_path: Path, rows: Any, kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind, match=message):
        told(varied_path).subset(rows)


def test_scene_codes_are_places_in_the_scenes_of_the_release(varied_path: Path) -> None:
    dataset = told(varied_path)
    assert dataset.scene_codes.dtype == np.int64
    assert [dataset.scene_ids[code] for code in dataset.scene_codes] == [
        row["scene_id"] for row in varied_rows("train")
    ]


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
