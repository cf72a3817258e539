"""Against others: Recast and Detour on floors laid out like homes, an exact solver on homes."""

from __future__ import annotations

import dataclasses
import functools
import importlib.util
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from affectsim_data.navmesh import NavMesh, Settings
from affectsim_data.navmesh.islands import Island
from affectsim_data.poses import FloatArray

GOLDENS = Path(__file__).parent / "goldens" / "navmesh"


def golden(name: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads((GOLDENS / name).read_text(encoding="utf-8"))
    return found


@dataclasses.dataclass
class Answers:
    """Ours and theirs over all floors."""

    our_lengths: FloatArray
    their_lengths: FloatArray
    move_offsets: FloatArray


@functools.cache
def answers() -> Answers:
    spec = importlib.util.spec_from_file_location("make_recast", GOLDENS / "make_recast.py")
    assert spec is not None
    assert spec.loader is not None
    make_recast = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(make_recast)
    ours, theirs, offsets = [], [], []
    for floor in golden("recast.json"):
        mesh = make_recast.floor_mesh(floor["width"], floor["depth"], floor["parts"])
        navmesh = NavMesh.from_mesh(*mesh)
        pairs, moves = np.array(floor["pairs"]), np.array(floor["moves"])
        ours.append(navmesh.geodesic_distances(pairs[:, :3], pairs[:, 3:]))
        theirs.append([np.inf if v is None else v for v in floor["lengths_m"]])
        ends = [navmesh.step(move[:3], move[3:], sliding=True).position for move in moves]
        offsets.append(np.hypot(*(np.array(ends) - floor["ends"])[:, [0, 2]].T))
    return Answers(np.concatenate(ours), np.concatenate(theirs), np.concatenate(offsets))


def test_what_can_be_reached_agrees_with_recast() -> None:
    found = answers()
    agrees = np.isinf(found.our_lengths) == np.isinf(found.their_lengths)
    assert len(agrees) >= 1000
    assert 0.2 < np.mean(np.isinf(found.their_lengths)) < 0.8
    assert np.mean(agrees) >= 0.995


def test_lengths_agree_with_recast() -> None:
    found = answers()
    both = np.isfinite(found.our_lengths) & np.isfinite(found.their_lengths)
    both &= found.their_lengths > 0.5
    error = np.abs(found.our_lengths[both] / found.their_lengths[both] - 1.0)
    # Detour's corridor of polygons need not hold the shortest way, so it is sometimes longer.
    assert np.median(error) < 0.003
    assert np.quantile(error, 0.95) < 0.025


def test_moves_agree_with_detour() -> None:
    """On other polygons, whose walls lie up to 1.3 cells apart; most moves meet none."""
    offset = answers().move_offsets
    assert np.median(offset) < 1e-3
    assert np.quantile(offset, 0.95) < 0.02
    assert offset.max() < 0.25


@pytest.mark.parametrize("home", range(4))
def test_lengths_equal_an_exact_solver(home: int) -> None:
    known = golden("exact.json")[home]
    rings = tuple(np.array(ring, np.float32) for ring in known["rings"])
    island = Island(rings, np.zeros((1, 1), np.int16), (0.0, 0.0), 0.0, 0.05)
    navmesh = NavMesh(Settings(), (island,))
    plan = np.array(known["pairs"]).reshape(-1, 2)
    points = island.on_floor(plan)
    found = navmesh.geodesic_distances(points[::2], points[1::2])
    np.testing.assert_allclose(found, known["lengths_m"], atol=1e-3, rtol=0.0)
    assert np.sum(found > 1.01 * np.linalg.norm(points[::2] - points[1::2], axis=1)) > 5
