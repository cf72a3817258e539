"""Pictures of rejected motions: one each, with the failing joint ringed and the reason above."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from affectsim_data.avatars import Avatar
from affectsim_data.builders.performances import perform
from affectsim_data.builders.screening import Finding, load_thresholds, screen_motion
from affectsim_data.content import content_path
from affectsim_data.inspection.screening_pictures import rejected_pictures
from affectsim_data.motions import Motion
from affectsim_data.render import open_renderer
from affectsim_data.skeletons import JOINT_NAMES

RING = (214, 40, 40)


def screened(motion: Motion) -> tuple[Motion, tuple[Finding, ...]]:
    limits = load_thresholds()
    return motion, screen_motion(motion, source=None, joints=None, thresholds=limits)


@pytest.mark.egl
def test_only_rejected_motions_get_a_picture_and_the_joint_is_ringed(tmp_path: Path) -> None:
    clean = perform("knock_door", "neutral", "p1", rng=np.random.default_rng(3))
    local = clean.joint_rotations.copy()
    half = np.deg2rad(-40.0) / 2.0
    local[30:60, JOINT_NAMES.index("left_knee")] = [np.cos(half), np.sin(half), 0.0, 0.0]
    bent = dataclasses.replace(clean, motion_id="mini/bent", joint_rotations=local)
    path = content_path("builders", "avatars/ben.glb")
    avatar = Avatar.from_glb(path.read_bytes(), name="ben")
    motions = [screened(clean), screened(bent)]
    failed = [finding for finding in motions[1][1] if not finding.passed]
    assert "joint_limits" in [finding.check for finding in failed]
    paths = rejected_pictures(motions, avatar, open_renderer(), tmp_path / "rejected")
    assert paths == [tmp_path / "rejected" / "mini__bent.png"]
    picture = np.asarray(Image.open(paths[0]))
    assert picture.shape[1] > 7 * 200
    # Red on the person, whose clothes are not: the rings.
    ringed = (picture == RING).all(axis=-1)
    assert 100 < ringed.sum() < 0.02 * ringed.size
    # The caption takes the rows above the first strip and is not empty.
    assert picture[:18].min() < 120
