"""A small convolutional network that finds people in one RGB-D image, and which way they face."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn
from torch.nn import functional

from affectsim_data.cameras import Camera
from affectsim_data.content import content_path
from affectsim_data.weights import WeightsFile

__all__ = [
    "CELLS",
    "INPUT_SIZE",
    "WEIGHTS",
    "PersonHeat",
    "PersonNetwork",
    "find_people",
    "load_person_network",
    "network_images",
    "read_person_network",
    "save_person_network",
]

INPUT_SIZE = 112
"""Side of the square images the network works on, pixels."""
CELLS = 28
"""Cells along a side of its answers: four pixels each."""
WEIGHTS = "detector/person_network.safetensors"
"""Where the weights lie in `builders/`."""
_CHANNELS = (24, 40, 64)
_FAR_M = 20.0
"""Stands for a depth at which nothing was hit."""
_FILE = WeightsFile(
    network="PersonNetwork",
    mark="affectsim-person-network-2",
    max_bytes=4 << 20,
    making="python -m affectsim_data.simulation.policies.scan_search_follow.training makes one",
)


class PersonHeat(NamedTuple):
    """What the network says of one image."""

    share: NDArray[np.float32]
    """Part of each cell that is a person, in [0, 1], `(28, 28)`."""
    facing: NDArray[np.float32]
    """Which way a person in the cell faces: cosine and sine of the angle from the direction to the
    camera to where the body faces, counter-clockwise from above, longer the surer, `(2, 28, 28)`.
    """


class PersonNetwork(nn.Module):
    """Person share and facing per cell of 4 x 4 pixels, from colour, nearness and height.

    An encoder of stride 8 sees the shape of a body and of what is around it; its answer is brought
    back to stride 4, where a person 7 m away is still two cells wide.
    """

    def __init__(self) -> None:
        super().__init__()
        narrow, middle, wide = _CHANNELS
        self.near = nn.Sequential(
            *_convolution(5, narrow, size=5, stride=2),
            *_convolution(narrow, middle, stride=2),
            *_convolution(middle, middle),
        )
        self.around = nn.Sequential(
            *_convolution(middle, wide, stride=2),
            *_convolution(wide, wide),
            *_convolution(wide, wide, dilation=2),
        )
        self.both = nn.Sequential(*_convolution(middle + wide, middle))
        self.answer = nn.Conv2d(middle, 3, 1)

    def forward(self, images: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Logits of the share `(batch, 28, 28)`, and facing `(batch, 2, 28, 28)`.

        Args:
            images: As `network_images` makes them, `(batch, 5, 112, 112)`.
        """
        near = self.near(images)
        around = functional.interpolate(self.around(near), scale_factor=2.0, mode="nearest")
        answer = self.answer(self.both(torch.cat([near, around], dim=1)))
        return answer[:, 0], answer[:, 1:]


def network_images(
    rgb: torch.Tensor, depth: torch.Tensor, *, vfov: float, camera_height_m: float
) -> torch.Tensor:
    """Images as the network takes them: colour, nearness, height above the floor.

    Args:
        rgb: uint8 `(batch, 3, 112, 112)`.
        depth: Metres along the view axis, `(batch, 112, 112)`.
        vfov: Vertical field of view, radians.
        camera_height_m: Of the level camera above the floor.

    Returns:
        float32 `(batch, 5, 112, 112)`.
    """
    metres = depth.float().clamp(max=_FAR_M)
    rows = (torch.arange(INPUT_SIZE) + 0.5) / INPUT_SIZE - 0.5
    slope = 2.0 * float(np.tan(vfov / 2.0)) * rows[:, None]
    height = camera_height_m - slope * metres
    shape = torch.stack([1.0 / metres.clamp_min(0.4), (height - 1.0).clamp(-1.5, 1.5)], dim=1)
    return torch.cat([rgb.float() / 127.5 - 1.0, shape], dim=1)


def find_people(
    network: PersonNetwork,
    rgb: NDArray[np.uint8],
    depth: NDArray[np.float32],
    camera: Camera,
    camera_height_m: float,
) -> PersonHeat:
    """Where people are in one image.

    Args:
        network: Trained.
        rgb: `(height, width, 3)`.
        depth: Metres along the view axis, `(height, width)`.
        camera: Of both.
        camera_height_m: Above the floor.
    """
    size = (INPUT_SIZE, INPUT_SIZE)
    small = cv2.resize(rgb, size, interpolation=cv2.INTER_AREA)
    near = cv2.resize(depth, size, interpolation=cv2.INTER_NEAREST)
    # For one small image threads cost more than they give, and other processes want the cores.
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        with torch.inference_mode():
            images = network_images(
                torch.from_numpy(small).permute(2, 0, 1)[None],
                torch.from_numpy(near)[None],
                vfov=camera.vfov,
                camera_height_m=camera_height_m,
            )
            logits, facing = network(images.contiguous(memory_format=torch.channels_last))
            share = logits[0].sigmoid()
    finally:
        torch.set_num_threads(threads)
    return PersonHeat(share.numpy(), facing[0].numpy())


def save_person_network(network: PersonNetwork, path: Path, training: dict[str, object]) -> None:
    """Writes weights in half precision, and a note on how they were trained."""
    weights = {
        key: value.half() if value.is_floating_point() else value
        for key, value in network.state_dict().items()
    }
    _FILE.save(path, weights, training=training)


def read_person_network(path: Path) -> PersonNetwork:
    """Reads what `save_person_network` wrote.

    Raises:
        FileNotFoundError: No such file.
        ValueError: Not such a file.
    """
    network = PersonNetwork()
    _FILE.load(path, network)
    # With channels beside each other one small image takes less time.
    network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]  # torch's own
    return network.eval()


@functools.cache
def load_person_network() -> PersonNetwork:
    """The network the package ships, read once per process."""
    return read_person_network(content_path("builders", WEIGHTS))


def _convolution(
    inputs: int, outputs: int, *, size: int = 3, stride: int = 1, dilation: int = 1
) -> list[nn.Module]:
    padding = dilation * (size // 2)
    return [
        nn.Conv2d(inputs, outputs, size, stride, padding, dilation, bias=False),
        nn.BatchNorm2d(outputs),
        nn.ReLU(),
    ]
