"""The clips of a run: which there are, and drawing the ones that are still to be answered."""

from __future__ import annotations

import dataclasses
import multiprocessing
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeAlias, cast

import numpy as np
import torch
from torch.utils.data import DataLoader

import affectsim_data
from affectsim_data.loaders import AffectSimDataset, ConcatenatedDataset, Sample, concatenate
from affectsim_data.loaders.places import Place
from affectsim_data.loaders.workers import WorkerStart
from affectsim_data.observations import AObs
from affectsim_data.recognizers.frames import SEEN, blinded, frames_sha256
from affectsim_data.recognizers.journal import Key, RunHeader
from affectsim_data.releases.joined_splits import split_title

__all__ = ["ClipBatch", "Clips", "clip_batches", "clip_keys", "run_header"]

Clips: TypeAlias = AffectSimDataset | ConcatenatedDataset
"""Episodes under one condition, or such datasets of one release added up, one per condition."""


@dataclasses.dataclass(frozen=True)
class ClipBatch:
    """Clips that are recognized together."""

    keys: tuple[Key, ...]
    """Episode and condition of each."""
    samples: tuple[Sample, ...]
    """What a recognizer is given of each."""
    frames_sha256: tuple[str, ...]
    """Hash of the frames of each."""


def run_header(model: str, dataset: Clips) -> RunHeader:
    """What a run of a recognizer over these clips is.

    Args:
        model: Name of the recognizer.
        dataset: The clips.

    Raises:
        ValueError: The dataset has parts that belong in tables of their own.
    """
    parts = concatenate([dataset]).parts
    conditions = [part.condition for part in parts]
    recorded = {one.trajectories.sha256 for one in conditions if isinstance(one, AObs)}
    headers = [
        RunHeader(
            model=model,
            release=part.source,
            release_sha256=part.release.content_sha256,
            split=split_title(part.split, part.split_by),
            clip=f"{part.clip.num_frames}x{part.clip.width}x{part.clip.height}",
            trajectories=" ".join(sorted(recorded)),
            code_version=affectsim_data.__version__,
        )
        for part in parts
    ]
    # Copies of a release are one release.
    if len({dataclasses.replace(header, release="") for header in headers}) > 1:
        told = dict.fromkeys(f"{one.release}, {one.split}, clip {one.clip}" for one in headers)
        raise ValueError(
            f"a prediction table is of one release, split and clip, got {'; '.join(told)}; run "
            "predict for each, with its own table"
        )
    return headers[0]


def clip_keys(dataset: Clips) -> list[Key]:
    """Episode and condition of every clip, in order.

    Raises:
        ValueError: A clip is there twice.
    """
    keys: list[Key] = []
    for part in concatenate([dataset]).parts:
        ids = part.release.split_table(part.split, part.split_by).index.column("episode_id")
        name = part.condition.name
        keys += [(episode_id, name) for episode_id in ids.take(part.rows).to_pylist()]
    key, count = Counter(keys).most_common(1)[0]
    if count > 1:
        raise ValueError(f"the dataset holds episode {key[0]!r} under {key[1]} twice")
    return keys


def clip_batches(
    dataset: Clips, rows: Sequence[int], *, batch_size: int, num_workers: int = 0
) -> Iterator[ClipBatch]:
    """Draws clips, scene by scene: each scene is read once for all its episodes and conditions.

    Args:
        dataset: The clips.
        rows: Places of those to draw.
        batch_size: Clips of a batch.
        num_workers: Processes that draw; 0 for this one.
    """
    places = np.asarray(rows, np.int64)
    places = places[np.argsort(dataset.scene_codes[places], kind="stable")]
    batches = [places[at : at + batch_size].tolist() for at in range(0, len(places), batch_size)]
    requests = [
        [Place(row, 0, row, ahead=tuple(ahead) if not at else ()) for at, row in enumerate(batch)]
        for batch, ahead in zip(batches, [*batches[1:], []], strict=True)
    ]
    options: dict[str, Any] = {}
    if num_workers:
        # Clean processes: an OpenGL context would not survive a fork.
        options = {
            "multiprocessing_context": multiprocessing.get_context("forkserver"),
            "worker_init_fn": WorkerStart(),
        }
    loader: DataLoader[Any] = DataLoader(
        dataset,
        batch_sampler=requests,
        collate_fn=_packed,
        num_workers=num_workers,
        **options,
    )
    for keys, columns, hashes in loader:
        samples = tuple(_sample(columns, number) for number in range(len(keys)))
        yield ClipBatch(keys, samples, hashes)


def _packed(
    samples: Sequence[Sample],
) -> tuple[tuple[Key, ...], dict[str, Any], tuple[str, ...]]:
    """A batch on its way between processes: few tensors, as each takes a file descriptor."""
    seen = [blinded(sample) for sample in samples]
    columns: dict[str, Any] = {}
    for name in SEEN:
        values: list[torch.Tensor] = [sample[name] for sample in seen]  # type: ignore[literal-required]  # of SEEN
        alike = len({value.shape for value in values}) == 1
        columns[name] = torch.stack(values) if alike else values
    keys = tuple((sample["episode_id"], sample["condition"]) for sample in samples)
    return keys, columns, tuple(frames_sha256(sample["video"]) for sample in seen)


def _sample(columns: Mapping[str, Any], number: int) -> Sample:
    return blinded(cast(Sample, {name: values[number] for name, values in columns.items()}))
