"""Trains the person network the baseline ships, from simulator masks of the train split.

    python -m affectsim_data.simulation.policies.scan_search_follow.training FULL

writes `builders/detector/person_network.safetensors`; two cores need some thirty minutes.
"""

from __future__ import annotations

import dataclasses
import math
import time
from pathlib import Path

import numpy as np
import torch
import tyro
from torch.nn import functional

from affectsim_data.content import content_path
from affectsim_data.releases import open_release
from affectsim_data.simulation.policies.scan_search_follow.person_network import (
    WEIGHTS,
    PersonNetwork,
    network_images,
    save_person_network,
)
from affectsim_data.simulation.policies.scan_search_follow.person_views import (
    PersonViews,
    draw_views,
)

__all__ = ["train_person_network"]

_BATCH = 64
_PEAK_RATE = 4e-3
_FACING_WEIGHT = 0.4
_LIGHT = 0.25
"""Images are made up to this much brighter or darker, and each colour by half as much."""
_VIEWS_PER_EPISODE = 4


def train_person_network(
    views: PersonViews, *, epochs: int = 12, seed: int = 0, progress: bool = False
) -> PersonNetwork:
    """A network that knows what is true of these views.

    Args:
        views: Drawn of a train split.
        epochs: Passes over them.
        seed: Of the first weights, the order and the changes of light.
        progress: Print the loss of each epoch.
    """
    torch.manual_seed(seed)
    network = PersonNetwork()
    optimizer = torch.optim.AdamW(network.parameters(), lr=_PEAK_RATE, weight_decay=1e-3)
    batches = math.ceil(len(views) / _BATCH)
    schedule = torch.optim.lr_scheduler.OneCycleLR(
        optimizer, _PEAK_RATE, total_steps=epochs * batches, pct_start=0.2
    )
    draw = torch.Generator().manual_seed(seed)
    for epoch in range(epochs):
        started, losses = time.perf_counter(), []
        for rows in torch.split(torch.randperm(len(views), generator=draw), _BATCH):
            loss = _loss(network, views, rows, draw)
            optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]  # so it is in torch
            optimizer.step()
            schedule.step()
            losses.append(loss.item())
        if progress:
            took = time.perf_counter() - started
            mean = float(np.mean(losses))
            print(f"epoch {epoch + 1} of {epochs}: loss {mean:.4f}, {took:.0f} s", flush=True)
    network.eval()
    return network


def _loss(
    network: PersonNetwork, views: PersonViews, rows: torch.Tensor, draw: torch.Generator
) -> torch.Tensor:
    """Cross entropy of the share in each cell, and how far off the facing is where people are."""
    index = rows.numpy()
    rgb = torch.from_numpy(views.rgb[index]).permute(0, 3, 1, 2).float()
    gain = 1.0 + _LIGHT * (2.0 * torch.rand(len(rows), 1, 1, 1, generator=draw) - 1.0)
    tint = 1.0 + _LIGHT * (torch.rand(len(rows), 3, 1, 1, generator=draw) - 0.5)
    images = network_images(
        (rgb * gain * tint).clamp(0.0, 255.0),
        torch.from_numpy(views.depth[index]),
        vfov=views.camera.vfov,
        camera_height_m=views.camera_height_m,
    )
    share = torch.from_numpy(views.share[index]).float()
    facing = torch.from_numpy(views.facing[index]).float()
    if torch.rand((), generator=draw) < 0.5:  # a mirrored world
        images, share, facing = images.flip(-1), share.flip(-1), -facing.flip(-1)
    logits, turned = network(images.contiguous(memory_format=torch.channels_last))
    found = functional.binary_cross_entropy_with_logits(logits, share)
    truth = torch.stack([facing.cos(), facing.sin()], dim=1).nan_to_num()
    off = (turned - truth).square().sum(dim=1)
    wrong = (off * share).sum() / share.sum().clamp_min(1.0)
    return torch.add(found, wrong, alpha=_FACING_WEIGHT)


@dataclasses.dataclass(frozen=True)
class _Arguments:
    release: tyro.conf.Positional[str]
    """Release whose train split is learned from."""
    views: int = 40_000
    """How many images."""
    epochs: int = 12
    """Passes over them."""
    views_seed: int = 7
    """Of which views."""
    seed: int = 0
    """Of the first weights, the order and the changes of light."""
    out: Path | None = None
    """Where the weights go; the place the package ships them in if not given."""


def _main(arguments: _Arguments) -> None:
    release = open_release(arguments.release)
    views = draw_views(
        release,
        "train",
        num_views=arguments.views,
        views_per_episode=_VIEWS_PER_EPISODE,
        rng=np.random.default_rng(arguments.views_seed),
        progress=True,
    )
    network = train_person_network(
        views, epochs=arguments.epochs, seed=arguments.seed, progress=True
    )
    out = arguments.out or content_path("builders") / WEIGHTS
    training = {
        "release": release.content_sha256,
        "split": "train",
        "views": len(views),
        "views_seed": arguments.views_seed,
        "epochs": arguments.epochs,
        "seed": arguments.seed,
    }
    save_person_network(network, out, training)
    print(f"{out}: {out.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    _main(tyro.cli(_Arguments, description=__doc__))
