"""Corpora by recipe: labels from paths, what is left out and why, damage listed at once."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from affectsim_data.builders.corpora import load_recipe, read_corpus, scan_corpus
from affectsim_data.content import content_path
from affectsim_data.motions.looping import seam_step
from affectsim_data.skeletons import BODY, JOINT_NAMES, JOINT_PARENTS

RECIPE: dict[str, Any] = {
    "corpus": {
        "name": "tiny",
        "licence": "CC0-1.0",
        "redistribution": True,
        "pattern": r"(?P<actor>\w+)/(?P<action>\w+)_(?P<style>\w+)\.bvh",
        "performer": "tiny_{actor}",
        "motion_id": "{actor}_{action}_{style}",
        "fps": 30,
        "metres_per_unit": 0.01,
        "up_axis": "y",
    },
    "labels": {"mad": "angry", "glad": "happy"},
    "excluded": {"bored": "none of the five emotions"},
    "actions": {"wave": "wave"},
    "joints": {name: name for name in JOINT_NAMES},
}


def recipe(**changes: dict[str, Any]) -> dict[str, Any]:
    """The recipe with some keys of its tables changed."""
    changed = copy.deepcopy(RECIPE)
    for table, keys in changes.items():
        changed[table] |= keys
    return changed


def body_bvh(num_frames: int = 12, *, scale: float = 100.0) -> str:
    """The canonical body as BVH at 60 fps, in centimetres, the left elbow bending."""
    lines = ["HIERARCHY"]

    def joint(index: int) -> None:
        offset = " ".join(f"{x * scale:.4f}" for x in BODY.joint_offsets[index])
        position = "" if index else "Xposition Yposition Zposition "
        count = 3 if index else 6
        lines.extend([f"{'JOINT' if index else 'ROOT'} {JOINT_NAMES[index]}", "{"])
        lines.extend(
            [f"OFFSET {offset}", f"CHANNELS {count} {position}Zrotation Xrotation Yrotation"]
        )
        children = [child for child, parent in enumerate(JOINT_PARENTS) if parent == index]
        for child in children:
            joint(child)
        if not children:
            lines.extend(["End Site", "{", "OFFSET 0 0 0", "}"])
        lines.append("}")

    joint(0)
    order = [line.split()[1] for line in lines if line.startswith(("ROOT", "JOINT"))]
    lines.extend(["MOTION", f"Frames: {num_frames}", "Frame Time: 0.0166667"])
    for frame in range(num_frames):
        numbers = [0.0, BODY.hip_height * scale, 0.0]
        for name in order:
            bend = -40.0 * np.sin(np.pi * frame / num_frames) if name == "left_elbow" else 0.0
            numbers += [0.0, 0.0, float(bend)]
        lines.append(" ".join(f"{number:.4f}" for number in numbers))
    return "\n".join(lines) + "\n"


@pytest.fixture
def corpus(tmp_path: Path) -> Path:
    """Two performers; one clip of each of three styles, and a file that is none."""
    for name in ("ann/wave_mad", "ann/wave_bored", "bob/wave_glad"):
        path = tmp_path / f"{name}.bvh"
        path.parent.mkdir(exist_ok=True)
        path.write_text(body_bvh(), encoding="utf-8")
    (tmp_path / "README.txt").write_text("hello", encoding="utf-8")
    return tmp_path


def test_labels_come_from_paths_and_counts_are_told(corpus: Path) -> None:
    told: list[str] = []
    motions = read_corpus(RECIPE, corpus, progress=told.append)
    assert [m.motion_id for m in motions] == ["tiny/ann_wave_mad", "tiny/bob_wave_glad"]
    assert [m.performer_id for m in motions] == ["tiny_ann", "tiny_bob"]
    assert [m.emotion for m in motions] == ["angry", "happy"]
    assert {m.group_id for m in motions} == {m.motion_id for m in motions}
    assert motions[0].source == "tiny: ann/wave_mad.bvh; seam of 0.1 s blended"
    assert told == ["tiny: 2 motions read, 1 files excluded by style (bored 1), 0 failed"]


def test_the_body_comes_back_from_its_own_file(corpus: Path) -> None:
    motion = read_corpus(RECIPE, corpus)[0]
    assert motion.num_frames == 6
    np.testing.assert_allclose(motion.root_translation[0], [0.0, BODY.hip_height, 0.0], atol=1e-3)
    elbow = motion.joint_rotations[2, JOINT_NAMES.index("left_elbow")]
    # Frame 2 at 30 fps is frame 4 of the file: a turn about Y.
    bend = np.rad2deg(2.0 * np.arcsin(elbow[1:]))
    np.testing.assert_allclose(bend, [0.0, -40.0 * np.sin(np.pi * 4 / 12), 0.0], atol=0.1)


def test_an_unknown_style_is_named_with_the_way_out(corpus: Path) -> None:
    (corpus / "ann" / "wave_disgust.bvh").write_text(body_bvh(), encoding="utf-8")
    message = "recipe: label 'disgust' maps to no emotion; add it to .labels. or .excluded."
    with pytest.raises(ValueError, match=message):
        read_corpus(RECIPE, corpus)
    (corpus / "ann" / "jump_mad.bvh").write_text(body_bvh(), encoding="utf-8")
    with pytest.raises(ValueError, match=r"2 problems:\n  action 'jump' has no word"):
        read_corpus(RECIPE, corpus)


def test_damaged_files_are_listed_together(corpus: Path) -> None:
    for name in ("ann/wave_mad", "bob/wave_glad"):
        path = corpus / f"{name}.bvh"
        path.write_text(path.read_text(encoding="utf-8")[:-200], encoding="utf-8")
    with pytest.raises(ValueError, match=r"tiny: 2 problems:") as caught:
        read_corpus(RECIPE, corpus)
    assert "wave_mad.bvh: " in str(caught.value)
    assert "wave_glad.bvh: " in str(caught.value)


def test_at_most_twenty_problems_are_listed(corpus: Path) -> None:
    for number in range(25):
        (corpus / f"a{number}").mkdir()
        (corpus / f"a{number}" / "wave_mad.bvh").write_text("junk", encoding="utf-8")
    with pytest.raises(ValueError, match=r"25 problems:(\n  .*){20}\n  and 5 more$"):
        read_corpus(RECIPE, corpus)


def test_wrong_units_and_axes_are_seen(corpus: Path) -> None:
    with pytest.raises(ValueError, match=r"person 1.2 to 2.2 m tall, got 0.17 m; check metres_per"):
        read_corpus(recipe(corpus={"metres_per_unit": 0.001}), corpus)
    with pytest.raises(ValueError, match=r"head 0.5 m or more above .* got .* check up_axis"):
        read_corpus(recipe(corpus={"up_axis": "z"}), corpus)


def test_a_floating_person_is_seen(corpus: Path) -> None:
    path = corpus / "ann" / "wave_mad.bvh"
    raised = path.read_text(encoding="utf-8").replace("\n0.0000 95.0000", "\n0.0000 195.0000")
    path.write_text(raised, encoding="utf-8")
    with pytest.raises(ValueError, match=r"within 0.15 m of the floor, got 1.02 m"):
        read_corpus(RECIPE, corpus)


def test_a_missing_or_empty_folder_says_what_was_looked_for(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="tiny: expected a folder with the corpus at"):
        read_corpus(RECIPE, tmp_path / "none")
    with pytest.raises(
        FileNotFoundError, match=r"tiny: expected files named like .* among 0 files"
    ):
        read_corpus(RECIPE, tmp_path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"labels": {"mad": "furious"}}, "label 'mad' maps to 'furious'; expected one of angry"),
        ({"excluded": {"mad": "why"}}, r"\['mad'\] stand in both \[labels\] and \[excluded\]"),
        ({"corpus": {"pattern": "("}}, "pattern is no regular expression"),
        ({"corpus": {"pattern": "(?P<style>.*)"}}, r"pattern needs the named groups \['action'\]"),
    ],
)
def test_a_wrong_recipe_is_named(changes: dict[str, dict[str, Any]], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        load_recipe(recipe(**changes))


def test_a_recipe_that_lacks_something_is_named() -> None:
    lacking = recipe()
    del lacking["joints"]
    with pytest.raises(ValueError, match=r"got none of \['joints'\]"):
        load_recipe(lacking)
    lacking = recipe()
    del lacking["corpus"]["fps"]
    with pytest.raises(ValueError, match=r"\[corpus\] needs the key 'fps'"):
        load_recipe(lacking)


@pytest.mark.realdata
def test_the_bandai_namco_corpus(realdata: Path) -> None:
    loaded = load_recipe(content_path("builders", "bandai_namco.toml"))
    assert not loaded.redistribution
    scan = scan_corpus(loaded, realdata / "bandai_namco")
    assert scan.counts()["walk", "angry"] == 1
    assert scan.excluded["proud"] == 6
    motions = read_corpus(loaded, realdata / "bandai_namco")
    assert len(motions) == len(scan.files) == 30
    assert {m.emotion for m in motions} == {"angry", "happy", "neutral", "sad"}
    assert {m.performer_id for m in motions} == {"bandai_namco_set1", "bandai_namco_set2"}
    assert all(m.licence == "CC-BY-NC-4.0" for m in motions)
    for motion in motions:
        excess_m, excess_rad = seam_step(motion)
        assert excess_m < 0.02, motion.motion_id
        assert excess_rad < np.deg2rad(5.0), motion.motion_id
        assert np.ptp(motion.root_translation[:, [0, 2]], axis=0).max() < 5.5
