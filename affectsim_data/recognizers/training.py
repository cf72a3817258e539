"""Training of the small video network on clips of a release."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator

import torch
from torch import nn
from torch.nn import functional
from torch.utils.data import DataLoader
from tqdm import tqdm

from affectsim_data.loaders import AffectSimDataset, Sample
from affectsim_data.recognizers.network import INPUT_SIZE, ClipNetwork, Looks, network_input
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["TrainingClips", "load_clips", "train_network"]

_BATCH_SIZE = 32
_JOINT_RATE, _EMOTION_RATE = 3e-3, 1e-3
"""Peaks of the learning rates."""
_WEIGHT_DECAY = 0.05
_CHANGES = 2
"""How often every clip is looked at, changed anew."""
_PLACE_NOISE = 0.005
"""Added to where joints are, parts of the image."""
_SMOOTHING = 0.1
_ZOOM = (0.45, 1.25)
"""Range of sizes a clip is trained at: other views show people smaller than the reference."""
_SHIFT = 0.12
"""Largest shift, in parts of the image."""
_MIRRORED = [
    JOINT_NAMES.index(name.replace("left", "?").replace("right", "left").replace("?", "right"))
    for name in JOINT_NAMES
]


@dataclasses.dataclass(frozen=True)
class TrainingClips:
    """Clips in memory, as small as the network takes them."""

    video: torch.Tensor
    """uint8 `(num_clips, num_frames, 3, 112, 112)`."""
    joints: torch.Tensor
    """x y in parts of the image, NaN behind the camera; float32 `(clips, frames, 22, 2)`."""
    labels: torch.Tensor
    """int64 `(num_clips,)`."""

    def __len__(self) -> int:
        return len(self.labels)


def load_clips(
    dataset: AffectSimDataset, *, num_workers: int = 0, progress: bool = True
) -> TrainingClips:
    """Draws every clip of a dataset once and keeps it, some 0.3 MB each."""
    loader = DataLoader(
        dataset,
        batch_size=16,
        num_workers=num_workers,
        collate_fn=_collate,
        multiprocessing_context="spawn" if num_workers else None,
    )
    parts = list(tqdm(loader, desc="drawing clips", unit="batch", disable=not progress))
    video, joints, labels = (torch.cat(one) for one in zip(*parts, strict=True))
    return TrainingClips(video, joints, labels)


def _collate(samples: list[Sample]) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    return (
        torch.stack([network_input(sample["video"]) for sample in samples]),
        torch.stack([_image_joints(sample) for sample in samples]),
        torch.tensor([sample["label"] for sample in samples]),
    )


def _image_joints(sample: Sample) -> torch.Tensor:
    """Joints in the image, x y in parts of it, `(num_frames, 22, 2)`; NaN behind the camera."""
    T_camera_world = torch.linalg.inv(sample["T_world_camera"])
    points = sample["joint_positions"].double() @ T_camera_world[:, :3, :3].transpose(1, 2)
    points = points + T_camera_world[:, None, :3, 3]
    depth = -points[..., 2]
    pixels = (points * points.new_tensor([1.0, -1.0, -1.0])) @ sample["intrinsics"].T
    height, width = sample["video"].shape[-2:]
    places = pixels[..., :2] / depth[..., None] / depth.new_tensor([width, height])
    places[depth < 0.05] = math.nan
    joints: torch.Tensor = places.float()
    return joints


def train_network(
    clips: TrainingClips,
    *,
    joint_epochs: int = 3,
    emotion_epochs: int = 40,
    seed: int,
    progress: bool = True,
) -> ClipNetwork:
    """A network trained from nothing; the same clips, seed and number of threads, the same weights.

    First it learns in which cell of a frame each joint lies, from clips mirrored, shifted, resized
    and lit otherwise. Then what it sees is written down twice for every clip, changed anew, and the
    emotion is learned from that alone: many epochs at next to no cost.

    Args:
        clips: Of the train split.
        joint_epochs: Passes over all clips to find the joints.
        emotion_epochs: Passes over what was seen of them.
        seed: Of weights, order and changes to clips.
        progress: Whether to show bars.
    """
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        generator = torch.Generator().manual_seed(seed)
        network = ClipNetwork()
        network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]  # torch's own
        _find_joints(network, clips, joint_epochs, generator, progress=progress)
        network.eval()
        looks, labels = _looks(network, clips, generator, progress=progress)
        _read_emotions(network, looks, labels, emotion_epochs, generator, progress=progress)
    network.eval()
    return network


def _find_joints(
    network: ClipNetwork,
    clips: TrainingClips,
    num_epochs: int,
    generator: torch.Generator,
    *,
    progress: bool,
) -> None:
    network.train()
    steps = num_epochs * _num_batches(len(clips))
    descent = _Descent([network.encoder, network.heat], rate=_JOINT_RATE, steps=steps)
    with tqdm(total=steps, desc="finding joints", unit="step", disable=not progress) as bar:
        for _ in range(num_epochs):
            for rows in _batches(len(clips), generator):
                video, joints = _changed(clips.video[rows], clips.joints[rows], generator)
                loss = descent.step(_joint_loss(network.look_at(video)[1], joints))
                bar.set_postfix(loss=f"{loss:.2f}", refresh=False)
                bar.update()


def _looks(
    network: ClipNetwork, clips: TrainingClips, generator: torch.Generator, *, progress: bool
) -> tuple[Looks, torch.Tensor]:
    """What the network sees of every clip, changed anew each time, and the labels."""
    seen, labels = [], []
    count = _CHANGES * _num_batches(len(clips))
    with (
        torch.inference_mode(),
        tqdm(total=count, desc="looking", unit="step", disable=not progress) as bar,
    ):
        for _ in range(_CHANGES):
            for rows in _batches(len(clips), generator):
                video, _ = _changed(clips.video[rows], clips.joints[rows], generator)
                looks = network.look_at(video)[0]
                seen.append(Looks(looks.places, looks.features.half()))
                labels.append(clips.labels[rows])
                bar.update()
    places, features = (torch.cat(one) for one in zip(*seen, strict=True))
    return Looks(places, features), torch.cat(labels)


def _read_emotions(
    network: ClipNetwork,
    looks: Looks,
    labels: torch.Tensor,
    num_epochs: int,
    generator: torch.Generator,
    *,
    progress: bool,
) -> None:
    parts = (network.look, network.frame, network.course, network.answer)
    for part in parts:
        part.train()
    steps = num_epochs * _num_batches(len(labels))
    descent = _Descent(parts, rate=_EMOTION_RATE, steps=steps)
    with tqdm(total=steps, desc="reading emotions", unit="step", disable=not progress) as bar:
        for _ in range(num_epochs):
            for rows in _batches(len(labels), generator):
                places = looks.places[rows]
                noise = torch.randn(places.shape, generator=generator)
                near = Looks(places + _PLACE_NOISE * noise, looks.features[rows].float())
                loss = descent.step(
                    functional.cross_entropy(
                        network.read(near), labels[rows], label_smoothing=_SMOOTHING
                    )
                )
                bar.set_postfix(loss=f"{loss:.2f}", refresh=False)
                bar.update()


class _Descent:
    """Gradient descent with one cycle of the rate."""

    def __init__(self, parts: Iterable[nn.Module], *, rate: float, steps: int) -> None:
        weights = [weight for part in parts for weight in part.parameters()]
        self._weights = weights
        self._optimizer = torch.optim.AdamW(weights, lr=rate, weight_decay=_WEIGHT_DECAY)
        self._schedule = torch.optim.lr_scheduler.OneCycleLR(
            self._optimizer, rate, total_steps=max(steps, 1)
        )

    def step(self, loss: torch.Tensor) -> float:
        """Goes down a loss, which comes back as a number."""
        self._optimizer.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]  # torch's own
        nn.utils.clip_grad_norm_(self._weights, 2.0)
        self._optimizer.step()
        self._schedule.step()
        return loss.item()


def _num_batches(count: int) -> int:
    return math.ceil(count / _BATCH_SIZE)


def _batches(count: int, generator: torch.Generator) -> Iterator[torch.Tensor]:
    yield from torch.split(torch.randperm(count, generator=generator), _BATCH_SIZE)


def _changed(
    video: torch.Tensor, joints: torch.Tensor, generator: torch.Generator
) -> tuple[torch.Tensor, torch.Tensor]:
    """Clips mirrored, shifted, scaled and lit otherwise, and where their joints then are."""
    count, frames = video.shape[:2]
    low, high = _ZOOM

    def uniform(least: float, most: float, *shape: int) -> torch.Tensor:
        return least + (most - least) * torch.rand(count, *shape, generator=generator)

    zoom = torch.exp(uniform(math.log(low), math.log(high)))
    shift = uniform(-_SHIFT, _SHIFT, 2)
    mirrored = torch.rand(count, generator=generator) < 0.5
    sign = torch.where(mirrored, -1.0, 1.0)
    theta = torch.zeros(
        count, 2, 3
    )  # from places in the new image to places in the old, in [-1, 1]
    theta[:, 0, 0], theta[:, 1, 1] = sign / zoom, 1.0 / zoom
    theta[:, 0, 2], theta[:, 1, 2] = -2 * sign * shift[:, 0] / zoom, -2 * shift[:, 1] / zoom
    grid = functional.affine_grid(
        theta, [count, 3 * frames, INPUT_SIZE, INPUT_SIZE], align_corners=False
    )
    images = functional.grid_sample(
        video.flatten(1, 2).float(), grid, padding_mode="border", align_corners=False
    ).view(count, frames, 3, INPUT_SIZE, INPUT_SIZE)
    gain, offset = uniform(0.8, 1.25, 1, 3, 1, 1), uniform(-20.0, 20.0, 1, 1, 1, 1)
    images = (images * gain + offset).clamp(0.0, 255.0)

    placed = joints.clone()
    placed[mirrored] = placed[mirrored][:, :, _MIRRORED]
    placed = (placed - 0.5) * zoom[:, None, None, None]
    placed[..., 0] *= sign[:, None, None]
    return images, placed + 0.5 + shift[:, None, None]


def _joint_loss(log_heat: torch.Tensor, joints: torch.Tensor) -> torch.Tensor:
    """Mean cross-entropy of the cells the joints lie in, of those inside the image."""
    size = log_heat.shape[-1]
    inside = ((joints >= 0) & (joints < 1)).all(dim=-1)
    cells = (torch.nan_to_num(joints) * size).long().clamp(0, size - 1)
    index = cells[..., 1] * size + cells[..., 0]
    chosen = log_heat.flatten(-2).gather(-1, index[..., None])[..., 0]
    return -(chosen * inside).sum() / inside.sum().clamp_min(1)
