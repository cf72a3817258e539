"""Says how well a person network sees, in views of a split it was not trained on.

    python -m affectsim_data.simulation.policies.scan_search_follow.grading FULL

prints a table by how large people are in the image; 2,000 views take a minute.
"""

from __future__ import annotations

import dataclasses
import itertools
from pathlib import Path
from typing import Literal

import numpy as np
import torch
import tyro
from numpy.typing import NDArray

from affectsim_data.releases import open_release
from affectsim_data.simulation.policies.scan_search_follow.bodies import HOT
from affectsim_data.simulation.policies.scan_search_follow.person_network import (
    PersonNetwork,
    load_person_network,
    network_images,
    read_person_network,
)
from affectsim_data.simulation.policies.scan_search_follow.person_views import (
    PersonViews,
    draw_views,
)

__all__ = ["Grade", "grade_network"]

_SIZES = (2.0, 8.0, 25.0, 80.0, 784.0)
"""Cells that people fill; an adult who stands 6 m away fills some 8, at 3.5 m 25, at 2 m 80."""
_BODY = 0.5
"""Share of a cell from which it is body, not border."""
_FOUND = 0.4
"""Of the cells of a body so many have to be hot for it to be found."""
_SURELY = 0.5
"""Evidence of a cell from which an image of nobody is said to hold somebody."""
_WRONG_DEG = 60.0
_ALIKE = 0.99
"""Length of the mean facing of the cells of one person; two who face apart have less."""
_BATCH = 100


@dataclasses.dataclass(frozen=True)
class Grade:
    """How people of some size in the image are seen."""

    least_cells: float
    most_cells: float
    num_people: int
    found: float
    """Share of them, `nan` for none; the following are of those."""
    facing_off_deg: float
    """Median of how far off their facing is, degrees."""
    facing_wrong: float
    """Share whose facing is off by more than 60 degrees."""


def grade_network(network: PersonNetwork, views: PersonViews) -> tuple[list[Grade], float]:
    """How well a network sees, by the size of people in the image.

    Args:
        network: Trained.
        views: Not those it was trained on.

    Returns:
        A grade for each size, and the share of images of nobody in which it sees somebody.
    """
    share = views.share.astype(np.float32)
    body = share > _BODY
    direction = np.exp(1j * np.nan_to_num(views.facing.astype(np.float32)))
    size = np.maximum(body.sum(axis=(1, 2)), 1)
    truth = np.where(body, direction, 0.0).sum(axis=(1, 2)) / size
    seen, facing = _answers(network, views)
    hot = seen > HOT
    found = (hot & body).sum(axis=(1, 2)) > _FOUND * size
    weight = seen * (hot & body)
    told = np.asarray((facing * weight).sum(axis=(1, 2)))
    off = np.degrees(np.abs(np.angle(told * np.conj(truth))))
    area = share.sum(axis=(1, 2))
    one = body.any(axis=(1, 2)) & (np.abs(truth) > _ALIKE)
    grades = []
    for least, most in itertools.pairwise(_SIZES):
        sized = one & (area >= least) & (area < most)
        known = off[sized & found]
        grades.append(
            Grade(
                least,
                most,
                num_people=int(sized.sum()),
                found=float(found[sized].mean()) if sized.any() else np.nan,
                facing_off_deg=float(np.median(known)) if len(known) else np.nan,
                facing_wrong=float((known > _WRONG_DEG).mean()) if len(known) else np.nan,
            )
        )
    nobody = share.max(axis=(1, 2)) == 0.0
    false = seen[nobody].max(axis=(1, 2)) > _SURELY
    return grades, float(false.mean()) if nobody.any() else np.nan


def _answers(
    network: PersonNetwork, views: PersonViews
) -> tuple[NDArray[np.float32], NDArray[np.complex64]]:
    """Evidence of a person, and facing as complex numbers, both `(n, 28, 28)`."""
    seen, facing = [], []
    with torch.inference_mode():
        for start in range(0, len(views), _BATCH):
            part = slice(start, start + _BATCH)
            images = network_images(
                torch.from_numpy(views.rgb[part]).permute(0, 3, 1, 2),
                torch.from_numpy(views.depth[part]),
                vfov=views.camera.vfov,
                camera_height_m=views.camera_height_m,
            )
            logits, turned = network(images)
            seen.append(logits.sigmoid().numpy())
            facing.append(turned[:, 0].numpy() + 1j * turned[:, 1].numpy())
    return np.concatenate(seen), np.concatenate(facing)


@dataclasses.dataclass(frozen=True)
class _Arguments:
    release: tyro.conf.Positional[str]
    """Release with views that the network has not seen."""
    split: Literal["train", "validation", "test"] = "validation"
    """Of performers and of homes."""
    views: int = 2_000
    """How many images."""
    seed: int = 3
    """Of which views."""
    weights: Path | None = None
    """Of the network; those the package ships if not given."""


def _main(arguments: _Arguments) -> None:
    weights = arguments.weights
    network = load_person_network() if weights is None else read_person_network(weights)
    views = draw_views(
        open_release(arguments.release),
        arguments.split,
        num_views=arguments.views,
        views_per_episode=4,
        rng=np.random.default_rng(arguments.seed),
        progress=True,
    )
    grades, false = grade_network(network, views)
    print("| cells | people | found | facing off, median | by more than 60 degrees |")
    print("|---|---|---|---|---|")
    for one in grades:
        print(
            f"| {one.least_cells:.0f} to {one.most_cells:.0f} | {one.num_people} "
            f"| {100.0 * one.found:.1f} % | {one.facing_off_deg:.0f} deg "
            f"| {100.0 * one.facing_wrong:.1f} % |"
        )
    print(f"{100.0 * false:.1f} % of images of nobody are said to hold somebody")


if __name__ == "__main__":
    _main(tyro.cli(_Arguments, description=__doc__))
