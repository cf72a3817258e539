"""A small video network: it finds the joints of a body and reads the emotion from their course."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import torch
from torch import nn
from torch.nn import functional

from affectsim_data.loaders import Sample
from affectsim_data.motions import EMOTIONS
from affectsim_data.recognizers.protocol import Reply
from affectsim_data.skeletons import JOINT_NAMES
from affectsim_data.weights import WeightsFile

__all__ = ["INPUT_SIZE", "ClipNetwork", "Looks", "NetworkRecognizer", "network_input"]

INPUT_SIZE = 112
"""Side of the square images the network works on, pixels; clips of other sizes are resized."""
_CHANNELS = (16, 32, 64)
_JOINT_FEATURES = 8
_HIDDEN = 128
_FILE = WeightsFile(
    network="ClipNetwork",
    mark="affectsim-clip-network-1",
    max_bytes=64 << 20,
    making="examples/12_train_recognizer.py makes one",
)


def network_input(video: torch.Tensor) -> torch.Tensor:
    """Clips as the network takes them: resized by area, uint8 `(..., 3, 112, 112)`.

    Args:
        video: uint8 `(..., 3, height, width)`.
    """
    shape = video.shape
    if shape[-2:] == (INPUT_SIZE, INPUT_SIZE):
        return video
    frames = video.reshape(-1, *shape[-3:]).float()
    small = functional.interpolate(frames, size=(INPUT_SIZE, INPUT_SIZE), mode="area")
    return small.round().to(torch.uint8).reshape(*shape[:-2], INPUT_SIZE, INPUT_SIZE)


class Looks(NamedTuple):
    """What is seen of the joints in the frames of clips."""

    places: torch.Tensor
    """Where they are, x y in parts of the image, `(batch, num_frames, 22, 2)`."""
    features: torch.Tensor
    """What it looks like there, `(batch, num_frames, 22, 64)`."""


class ClipNetwork(nn.Module):
    """Emotions of clips, by way of heat maps of the 22 joints in every frame.

    Each frame passes a small convolutional network of stride 8. Its heat maps say where the joints
    are; what is seen there, and where they lie around the pelvis, describes the frame. Two
    convolutions over time and a mean and a maximum over it describe the clip.
    """

    def __init__(self) -> None:
        super().__init__()
        narrow, middle, wide = _CHANNELS
        joints = len(JOINT_NAMES)
        self.encoder = nn.Sequential(
            *_convolution(4, narrow, size=5, stride=2),
            *_convolution(narrow, middle, stride=2),
            _Residual(middle),
            *_convolution(middle, wide, stride=2),
            _Residual(wide),
            _Residual(wide, dilation=2),
        )
        self.heat = nn.Conv2d(wide, joints, 1)
        self.look = nn.Linear(wide, _JOINT_FEATURES)
        self.frame = nn.Sequential(
            nn.Linear(joints * (2 + _JOINT_FEATURES), _HIDDEN), nn.LayerNorm(_HIDDEN), nn.ReLU()
        )
        self.course = nn.Sequential(
            nn.Conv1d(2 * _HIDDEN, _HIDDEN, 3, padding=1),
            nn.ReLU(),
            nn.Conv1d(_HIDDEN, _HIDDEN, 3, padding=1),
            nn.ReLU(),
        )
        self.answer = nn.Sequential(nn.Dropout(0.4), nn.Linear(2 * _HIDDEN, len(EMOTIONS)))

    def forward(self, video: torch.Tensor) -> torch.Tensor:
        """Logits of the emotions, `(batch, 5)`.

        Args:
            video: uint8 or float in [0, 255], `(batch, num_frames, 3, 112, 112)`.
        """
        logits: torch.Tensor = self.read(self.look_at(video)[0])
        return logits

    def look_at(self, video: torch.Tensor) -> tuple[Looks, torch.Tensor]:
        """What is seen of the joints, and log probabilities of the cells they may lie in.

        Args:
            video: uint8 or float in [0, 255], `(batch, num_frames, 3, 112, 112)`.

        Returns:
            The looks, and heat maps `(batch, num_frames, 22, 14, 14)`.
        """
        batch, frames = video.shape[:2]
        images = video.float() / 127.5 - 1.0
        # What differs from the clip's mean frame: where something moved.
        moved = (images - images.mean(dim=1, keepdim=True)).abs().mean(dim=2, keepdim=True)
        seen = torch.cat([images, 2.0 * moved], dim=2).flatten(0, 1)
        features = self.encoder(seen.contiguous(memory_format=torch.channels_last))
        size = features.shape[-1]
        log_heat = self.heat(features).flatten(2).log_softmax(dim=-1)
        heat = log_heat.exp()
        looks = Looks(
            places=(heat @ _cell_centres(size).to(heat)).unflatten(0, (batch, frames)),
            features=(heat @ features.flatten(2).transpose(1, 2)).unflatten(0, (batch, frames)),
        )
        return looks, log_heat.reshape(batch, frames, -1, size, size)

    def read(self, looks: Looks) -> torch.Tensor:
        """Logits of the emotions, `(batch, 5)`, from what was seen of the joints."""
        around = looks.places - looks.places[:, :, :1]
        height = around.abs().amax(dim=(1, 2, 3), keepdim=True).clamp_min(0.02)
        described = torch.cat([around / height, self.look(looks.features)], dim=-1)
        per_frame = self.frame(described.flatten(2)).transpose(1, 2)
        change = functional.pad(per_frame.diff(dim=-1), (1, 0))
        course = self.course(torch.cat([per_frame, change], dim=1))
        logits: torch.Tensor = self.answer(
            torch.cat([course.mean(dim=-1), course.amax(dim=-1)], dim=1)
        )
        return logits


def _convolution(inputs: int, outputs: int, *, size: int = 3, stride: int = 1) -> list[nn.Module]:
    return [
        nn.Conv2d(inputs, outputs, size, stride=stride, padding=size // 2, bias=False),
        nn.BatchNorm2d(outputs),
        nn.ReLU(),
    ]


class _Residual(nn.Module):
    def __init__(self, channels: int, dilation: int = 1) -> None:
        super().__init__()
        self.body = nn.Sequential(
            nn.Conv2d(channels, channels, 3, padding=dilation, dilation=dilation, bias=False),
            nn.BatchNorm2d(channels),
        )

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        return functional.relu(features + self.body(features))


def _cell_centres(size: int) -> torch.Tensor:
    """Centres of the cells of a square map in parts of the image, x y, `(size * size, 2)`."""
    along = (torch.arange(size) + 0.5) / size
    down, right = torch.meshgrid(along, along, indexing="ij")
    return torch.stack([right, down], dim=-1).reshape(-1, 2)


class NetworkRecognizer:
    """A trained `ClipNetwork` as a recognizer."""

    batch_size = 16

    def __init__(self, network: ClipNetwork, *, name: str, device: str = "cpu") -> None:
        self.name = name
        self._device = torch.device(device)
        self._network = network.to(self._device).eval()

    @classmethod
    def from_file(cls, path: Path, *, device: str = "cpu") -> NetworkRecognizer:
        """Reads what `save` wrote.

        Raises:
            FileNotFoundError: No such file.
            ValueError: Not such a file.
        """
        path, network = Path(path), ClipNetwork()
        metadata = _FILE.load(path, network)
        return cls(network, name=metadata.get("name", path.stem), device=device)

    def save(self, path: Path, *, training: dict[str, object] | None = None) -> None:
        """Writes weights, name and a note on how they were trained."""
        weights = self._network.state_dict()
        _FILE.save(Path(path), weights, training=training or {}, name=self.name)

    def recognize(self, samples: Sequence[Sample]) -> list[Reply]:
        """Labels and softmax scores of clips; batches of one length share a pass."""
        start = time.perf_counter()
        scores: list[tuple[float, ...]] = [()] * len(samples)
        by_length: dict[int, list[int]] = {}
        for place, sample in enumerate(samples):
            by_length.setdefault(len(sample["video"]), []).append(place)
        for places in by_length.values():
            video = torch.stack([network_input(samples[place]["video"]) for place in places])
            with torch.inference_mode():
                logits = self._network(video.to(self._device))
            for place, row in zip(places, logits.softmax(dim=1).cpu().tolist(), strict=True):
                scores[place] = tuple(row)
        took_ms = 1000 * (time.perf_counter() - start) / max(len(samples), 1)
        return [
            Reply(
                label=EMOTIONS[max(range(5), key=row.__getitem__)], scores=row, latency_ms=took_ms
            )
            for row in scores
        ]
