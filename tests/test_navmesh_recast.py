"""Against Recast and Detour: reachability and path lengths on random flats of boxes."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import numpy as np

from affectsim_data.navmesh import NavMesh

GOLDENS = Path(__file__).parent / "goldens" / "navmesh"


def test_distances_agree_with_recast() -> None:
    spec = importlib.util.spec_from_file_location("make_recast", GOLDENS / "make_recast.py")
    assert spec is not None
    assert spec.loader is not None
    make_recast = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(make_recast)
    ours, theirs = [], []
    for flat in json.loads((GOLDENS / "recast.json").read_text(encoding="utf-8")):
        navmesh = NavMesh.from_mesh(*make_recast.flat_mesh(flat["boxes"]))
        pairs = np.array(flat["pairs"])
        ours.append(navmesh.geodesic_distances(pairs[:, :3], pairs[:, 3:]))
        theirs.append([np.inf if v is None else v for v in flat["lengths_m"]])
    our, their = np.concatenate(ours), np.concatenate(theirs)
    assert len(our) >= 200
    np.testing.assert_array_equal(np.isinf(our), np.isinf(their))
    both = np.isfinite(our) & (their > 0.5)
    error = np.abs(our[both] / their[both] - 1.0)
    # Detour's corridor of polygons need not hold the shortest way, so it is sometimes longer.
    assert np.mean(error) <= 0.006
    assert np.quantile(error, 0.95) <= 0.02
