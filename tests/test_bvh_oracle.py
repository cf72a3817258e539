"""Joint positions of real BVH files agree with bvhio, an independent reader, to a millimetre.

bvhio (https://pypi.org/project/bvhio) takes 2 ms a frame, so 8 frames of every file are compared,
evenly spread, the first and the last among them; it calculates in float32.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from corpus_files import emilya_rig, kdae_rig, rig_bvh

from affectsim_data.motions.bvh import read_bvh
from affectsim_data.poses import FloatArray

UNITS = {
    "bandai_namco": 0.01,
    "cmu": 0.05644,
    "xia_styles": 0.05644,
    "pymo_affect_walk": 0.0254,
}
"""Metres per unit of the files of a folder."""
NUM_FRAMES = 8


def frames_of(num_frames: int) -> list[int]:
    spread = np.linspace(0, num_frames - 1, min(NUM_FRAMES, num_frames))
    return [int(frame) for frame in spread.round()]


def shortened(path: Path, out: Path) -> Path:
    """The file with the lines of `frames_of` alone, cut as text."""
    lines = path.read_text(encoding="utf-8-sig").splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("Frame Time")) + 1
    head, rows = lines[:start], [line for line in lines[start:] if line.strip()]
    kept = [rows[frame] for frame in frames_of(len(rows))]
    head[-2] = f"Frames: {len(kept)}"
    out.write_text("\n".join([*head, *kept]) + "\n", encoding="utf-8")
    return out


def oracle_positions(bvhio: Any, path: Path) -> dict[str, FloatArray]:
    """World positions of the joints of a file, `(num_frames, 3)` by name."""
    root = bvhio.readAsHierarchy(str(path))
    joints = [joint for joint, _, _ in root.layout()]
    places: dict[str, list[Any]] = {joint.Name: [] for joint in joints}
    for frame in range(len(root.Keyframes)):
        root.loadPose(frame, recursive=True)
        for joint in joints:
            places[joint.Name].append(tuple(joint.PositionWorld))
    return {name: np.array(found, np.float64) for name, found in places.items()}


def worst_difference(bvhio: Any, path: Path, tmp_path: Path) -> float:
    """Greatest distance of a joint between the two readers, file units."""
    clip = read_bvh(path)
    positions = clip.world()[0][frames_of(clip.num_frames)]
    expected = oracle_positions(bvhio, shortened(path, tmp_path / "short.bvh"))
    assert set(clip.joint_names) == set(expected)
    stacked = np.stack([expected[name] for name in clip.joint_names], axis=1)
    return float(np.linalg.norm(positions - stacked, axis=-1).max())


def test_made_up_skeletons_agree(tmp_path: Path) -> None:
    bvhio = pytest.importorskip("bvhio")
    for rig in (kdae_rig(), emilya_rig()):
        path = tmp_path / "clip.bvh"
        path.write_text(rig_bvh(rig, 20, 125.0), encoding="utf-8")
        assert worst_difference(bvhio, path, tmp_path) < 0.01


@pytest.mark.realdata
@pytest.mark.parametrize("folder", sorted(UNITS))
def test_real_files_agree(realdata: Path, tmp_path: Path, folder: str) -> None:
    import bvhio  # in the extra `dev`; where the corpora are, so must it be

    paths = sorted((realdata / folder).rglob("*.bvh"))
    assert paths
    for path in paths:
        assert worst_difference(bvhio, path, tmp_path) * UNITS[folder] < 0.001, path.name


@pytest.mark.realdata
def test_no_real_file_is_left_out(realdata: Path) -> None:
    found = {path.relative_to(realdata).parts[0] for path in realdata.rglob("*.bvh")}
    assert found == set(UNITS)
