"""Doors among imported things: closed leaves can be knocked on from both sides, others cannot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from habitat_files import Box, DatasetFiles

from affectsim_data.affordances import knockable_doors
from affectsim_data.builders.scene_sources import scene_navmesh
from affectsim_data.episodes import Robot
from affectsim_data.scenes import Scene

FLOOR: Box = ((-3.0, -0.1, -2.0), (3.0, 0.0, 2.0))
LEAF: Box = ((-0.4, 0.0, -0.02), (0.4, 2.05, 0.02))
FRAME: tuple[Box, ...] = (
    ((-0.48, 0.0, -0.1), (-0.4, 2.1, 0.1)),
    ((0.4, 0.0, -0.1), (0.48, 2.1, 0.1)),
    ((-0.4, 2.05, -0.1), (0.4, 2.1, 0.1)),
)
HALF = float(np.sqrt(0.5))
TURNED = [HALF, 0.0, HALF, 0.0]
"""A quarter turn about Y, wxyz: +Z goes to +X."""


def scene_with(folder: Path, *boxes: Box, name: str = "door", **instance: object) -> Scene:
    """A thing at x = 1 in a room of floor alone."""
    files = DatasetFiles(folder)
    files.stage("floor", FLOOR)
    files.add_object(name, *boxes)
    place = {"translation": [1.0, 0.0, 0.0], "translation_origin": "asset_local"}
    files.scene({"template_name": name, **place, **instance})
    return files.imported()[0]


def test_a_closed_door_has_a_leaf_with_two_sides(tmp_path: Path) -> None:
    back, front = scene_with(tmp_path, LEAF, *FRAME).doors
    np.testing.assert_allclose(front.knock_point, (1.0, 1.4, 0.02), atol=1e-6)
    np.testing.assert_allclose(back.knock_point, (1.0, 1.4, -0.02), atol=1e-6)
    assert abs(front.yaw_deg) < 1e-6
    assert abs(abs(back.yaw_deg) - 180.0) < 1e-6
    assert (front.width, front.height) == pytest.approx((0.96, 2.1))
    # Feet of both axes are under the frame, each to the right of who stands before the door.
    assert front.hinge == pytest.approx((0.52, 0.0, 0.02), abs=1e-6)
    assert back.hinge == pytest.approx((1.48, 0.0, -0.02), abs=1e-6)
    assert front.is_closed


def test_doors_turn_with_their_things_and_either_axis_may_be_thin(tmp_path: Path) -> None:
    turned = scene_with(tmp_path / "turned", LEAF, rotation=TURNED).doors
    assert sorted(round(door.yaw_deg) for door in turned) == [-90, 90]
    along: Box = ((-0.02, 0.0, -0.4), (0.02, 2.05, 0.4))
    assert sorted(
        round(door.yaw_deg) for door in scene_with(tmp_path / "along", along).doors
    ) == [-90, 90]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "boxes"),
    [
        ("wardrobe", (LEAF,)),
        ("door", FRAME),
        ("door", (((-0.4, 0.0, -0.02), (0.4, 1.2, 0.02)),)),
        ("door", (((-1.4, 0.0, -0.02), (1.4, 2.05, 0.02)),)),
        ("door", (((-0.4, 0.0, -0.4), (0.4, 2.05, 0.4)),)),
        ("door", (((-0.4, 0.5, -0.02), (0.4, 2.55, 0.02)),)),
    ],
    ids=["no door", "frame alone", "too low", "too wide", "too deep", "above the floor"],
)
def test_what_is_no_closed_door_is_left_out(
    tmp_path: Path, name: str, boxes: tuple[Box, ...]
) -> None:
    assert scene_with(tmp_path, *boxes, name=name).doors == ()


def test_imported_doors_can_be_knocked_on(tmp_path: Path) -> None:
    scene = scene_with(tmp_path, LEAF, *FRAME)
    access = knockable_doors(scene, scene_navmesh(scene, Robot()))
    assert np.isfinite(access.stand).all()
    np.testing.assert_allclose(access.stand[:, 0], 1.0, atol=1e-6)
    assert (np.sign(access.stand[:, 2]) == [-1.0, 1.0]).all()
