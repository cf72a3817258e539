"""Corpora by recipe: labels from paths, what is left out and why, damage listed at once."""

from __future__ import annotations

import copy
import pickle
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from corpus_files import BEND_DEG, bend_share, body_rig, rig_bvh

from affectsim_data.builders.corpora import (
    LeftOut,
    import_file,
    load_recipe,
    read_corpus,
    read_source,
    scan_corpus,
    stature_m,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES

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


def body_bvh(num_frames: int = 24) -> str:
    """The canonical body as BVH at 60 fps, in centimetres, the left elbow bending."""
    return rig_bvh(body_rig(), num_frames, 60.0)


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
    reading = read_corpus(RECIPE, corpus, progress=told.append)
    motions = reading.complete()
    assert [m.motion_id for m in motions] == ["tiny/ann_wave_mad", "tiny/bob_wave_glad"]
    assert [m.performer_id for m in motions] == ["tiny_ann", "tiny_bob"]
    assert [m.emotion for m in motions] == ["angry", "happy"]
    assert {m.group_id for m in motions} == {m.motion_id for m in motions}
    assert [(m.performance, m.take) for m in motions] == [("", 0), ("", 0)]
    assert motions[0].source.startswith("tiny: ann/wave_mad.bvh; ")
    assert told == [
        "tiny: 2 motions read, 0 failed; 2 files taken, 1 left out (style: bored 1)",
    ]
    assert reading.scan.left_out == (
        LeftOut("style", "bored", "none of the five emotions", 1, "ann/wave_bored.bvh"),
    )
    assert reading.scan.excluded() == {"bored": 1}


def test_the_body_comes_back_from_its_own_file(corpus: Path) -> None:
    recipe = load_recipe(RECIPE)
    imported = import_file(recipe, scan_corpus(recipe, corpus).files[0])
    motion = imported.motion
    assert 6 <= motion.num_frames <= 12, "at 30 fps, perhaps ended earlier"
    np.testing.assert_allclose(motion.root_translation[0], [0.0, BODY.hip_height, 0.0], atol=1e-3)
    elbow = motion.joint_rotations[5, JOINT_NAMES.index("left_elbow")]
    # Frame 5 at 30 fps is frame 10 of the file: a turn about Y.
    bend = np.rad2deg(2.0 * np.arcsin(elbow[1:]))
    np.testing.assert_allclose(bend, [0.0, -BEND_DEG * bend_share(24)[10], 0.0], atol=0.1)
    assert imported.source.num_frames == 24
    assert imported.source.fps == pytest.approx(60.0, abs=1e-3)
    head = imported.source.positions[:, imported.source.joint_names.index("head"), 1]
    np.testing.assert_allclose(head, BODY.rest_positions[JOINT_NAMES.index("head"), 1], atol=1e-6)
    assert stature_m(imported.source, recipe.joint_map(JOINT_NAMES)) == pytest.approx(1.7, abs=0.03)


def test_what_is_read_pickles_and_processes_change_nothing(corpus: Path) -> None:
    recipe = load_recipe(RECIPE)
    file = scan_corpus(recipe, corpus).files[0]
    again_recipe, again_file = pickle.loads(pickle.dumps((recipe, file)))
    assert again_file == file
    imported = pickle.loads(pickle.dumps(import_file(again_recipe, again_file)))
    np.testing.assert_array_equal(
        imported.motion.joint_rotations, import_file(recipe, file).motion.joint_rotations
    )
    (corpus / "bob" / "wave_mad.bvh").write_text("junk", encoding="utf-8")
    one, two = read_corpus(RECIPE, corpus), read_corpus(RECIPE, corpus, jobs=2)
    assert [m.motion_id for m in one.motions] == [m.motion_id for m in two.motions]
    assert one.failures == two.failures
    assert len(two.failures) == 1


def test_an_unknown_style_is_named_with_the_way_out(corpus: Path) -> None:
    (corpus / "ann" / "wave_disgust.bvh").write_text(body_bvh(), encoding="utf-8")
    message = "recipe: label 'disgust' maps to no emotion; add it to .labels. or .excluded."
    with pytest.raises(ValueError, match=message):
        read_corpus(RECIPE, corpus)
    (corpus / "ann" / "jump_mad.bvh").write_text(body_bvh(), encoding="utf-8")
    message = r"2 problems:\n  action 'jump' has no word; add it to \[actions\] or \[excluded_a"
    with pytest.raises(ValueError, match=message):
        read_corpus(RECIPE, corpus)


def test_damaged_files_are_collected_and_the_rest_is_read(corpus: Path) -> None:
    path = corpus / "ann" / "wave_mad.bvh"
    path.write_text(path.read_text(encoding="utf-8")[:-2000], encoding="utf-8")
    (corpus / "bob" / "wave_mad.bvh").write_text("junk", encoding="utf-8")
    reading = read_corpus(RECIPE, corpus)
    assert [m.motion_id for m in reading.motions] == ["tiny/bob_wave_glad"]
    assert [failure.relative for failure in reading.failures] == [
        "ann/wave_mad.bvh",
        "bob/wave_mad.bvh",
    ]
    assert all(failure.reason.startswith(str(failure.path)) for failure in reading.failures)
    assert "1 motions read, 2 failed" in reading.summary()
    with pytest.raises(ValueError, match=r"tiny: 2 problems:\n.*wave_mad\.bvh: expected 24 frames"):
        reading.complete()


def test_at_most_twenty_problems_are_listed(corpus: Path) -> None:
    for number in range(25):
        (corpus / f"a{number}").mkdir()
        (corpus / f"a{number}" / "wave_mad.bvh").write_text("junk", encoding="utf-8")
    reading = read_corpus(RECIPE, corpus)
    with pytest.raises(ValueError, match=r"25 problems:(\n  .*){20}\n  and 5 more$"):
        reading.complete()


def failure(tables: dict[str, Any], corpus: Path) -> str:
    """Why the first file fails."""
    return read_corpus(tables, corpus).failures[0].reason


def test_wrong_units_and_axes_are_seen(corpus: Path) -> None:
    reason = failure(recipe(corpus={"metres_per_unit": 0.001}), corpus)
    assert "expected a person 1.2 to 2.2 m tall, got 0.17 m; check metres_per_unit" in reason
    reason = failure(recipe(corpus={"up_axis": "z"}), corpus)
    assert re.search(r"head 0.5 m or more above .* got .* check up_axis", reason)


def test_a_floating_person_is_seen(corpus: Path) -> None:
    path = corpus / "ann" / "wave_mad.bvh"
    raised = path.read_text(encoding="utf-8").replace("\n0.0000 95.0000", "\n0.0000 195.0000")
    path.write_text(raised, encoding="utf-8")
    reason = failure(RECIPE, corpus)
    assert "within 0.15 m of the floor, got 1.02 m" in reason


def test_numbers_that_are_none_and_joints_that_lack_are_seen(corpus: Path) -> None:
    path = corpus / "ann" / "wave_mad.bvh"
    path.write_text(path.read_text(encoding="utf-8").replace("95.0000", "nan", 1), "utf-8")
    assert "expected a number after OFFSET that is finite, got 'nan'" in failure(RECIPE, corpus)
    path.write_text(body_bvh().replace("left_knee", "LeftKnee"), encoding="utf-8")
    reason = failure(RECIPE, corpus)
    assert "names joints that are not there: left_knee = 'left_knee'; the file has" in reason
    path.write_text(rig_bvh(body_rig(), 1, 60.0), encoding="utf-8")
    assert "expected 3 frames or more, got 1" in failure(RECIPE, corpus)


def test_first_frames_are_skipped_where_the_recipe_says_so(corpus: Path) -> None:
    skipping = load_recipe(recipe(corpus={"skip_frames": 10}))
    file = scan_corpus(skipping, corpus).files[0]
    whole = read_source(load_recipe(RECIPE), file.path)
    rest = import_file(skipping, file).source
    np.testing.assert_array_equal(rest.positions, whole.positions[10:])
    np.testing.assert_array_equal(rest.rotations, whole.rotations[10:])
    reason = failure(recipe(corpus={"skip_frames": 30}), corpus)
    assert "expected 3 frames or more after 30 skipped, got 0" in reason


def test_a_missing_or_empty_folder_says_what_was_looked_for(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="tiny: expected a folder with the corpus at"):
        read_corpus(RECIPE, tmp_path / "none")
    (tmp_path / "a.txt").write_text("")
    (tmp_path / "b.bvh").write_text("")
    with pytest.raises(
        FileNotFoundError, match=r"expected files named like .* none among 2 files, 1 of them .bvh"
    ):
        read_corpus(RECIPE, tmp_path)


def test_files_beside_the_pattern_are_counted_and_ignored_ones_say_why(corpus: Path) -> None:
    (corpus / "stray.bvh").write_text("")
    (corpus / "ann" / "wave_mad_copy.bvh").write_text("")
    tables = recipe() | {"ignore": {r".*_copy\.bvh": "a copy"}}
    scan = scan_corpus(load_recipe(tables), corpus)
    assert [(one.cause, one.reason, one.count, one.example) for one in scan.left_out] == [
        ("ignored", "a copy", 1, "ann/wave_mad_copy.bvh"),
        ("style", "none of the five emotions", 1, "ann/wave_bored.bvh"),
        ("unmatched", "its path does not match [corpus] pattern", 1, "stray.bvh"),
    ]
    assert scan.excluded("style") == {"bored": 1}


def test_takes_are_read_or_counted_and_groups_follow_their_template(corpus: Path) -> None:
    text = body_bvh()
    for name in ("ann/wave_mad2", "bob/wave_mad2", "bob/wave_mad7"):
        (corpus / f"{name}.bvh").write_text(text, encoding="utf-8")
    pattern = r"(?P<actor>\w+)/(?P<action>[a-z]+)_(?P<style>[a-z]+)(?P<take>\d*)\.bvh"
    changes = {
        "pattern": pattern,
        "motion_id": "{actor}_{style}{take}",
        "performance": "{style} wave",
        "group": "{actor} {style}",
    }
    scan = scan_corpus(load_recipe(recipe(corpus=changes)), corpus)
    found = {file.motion_id: (file.take, file.performance, file.group_id) for file in scan.files}
    assert found == {
        "tiny/ann_mad": (0, "mad wave", "tiny/ann mad"),
        "tiny/ann_mad2": (1, "mad wave", "tiny/ann mad"),
        "tiny/bob_glad": (0, "glad wave", "tiny/bob glad"),
        "tiny/bob_mad2": (0, "mad wave", "tiny/bob mad"),
        "tiny/bob_mad7": (1, "mad wave", "tiny/bob mad"),
    }
    changes["take"] = "{take}"
    takes = scan_corpus(load_recipe(recipe(corpus=changes)), corpus).files
    assert [file.take for file in takes] == [0, 2, 0, 2, 7]
    changes["take"] = "no {take}"
    with pytest.raises(ValueError, match=r"ann/wave_mad.bvh: take must be a whole number, got 'no"):
        scan_corpus(load_recipe(recipe(corpus=changes)), corpus)


def test_motion_ids_that_repeat_are_an_error(corpus: Path) -> None:
    with pytest.raises(ValueError, match=r"wave_glad.bvh and ann/wave_mad.bvh give the same motio"):
        scan_corpus(load_recipe(recipe(corpus={"motion_id": "{action}"})), corpus)


FILES: dict[str, Any] = {
    "pattern": r"(?P<actor>\w+)/(?P<name>\w+)\.bvh",
    "motion_id": "{actor}_{name}",
    "table": "labels.csv",
}


def test_labels_come_from_a_table_where_names_carry_none(corpus: Path) -> None:
    tables = recipe(corpus=FILES)
    with pytest.raises(FileNotFoundError, match=r"expected the table 'labels.csv' in .* nothing"):
        scan_corpus(load_recipe(tables), corpus)
    (corpus / "labels.csv").write_text(
        "\ufefffile,style,action\nann/wave_mad.bvh,glad,wave\nwave_glad,mad,wave\nnone.bvh,mad,\n"
    )
    tables["files"] = {"wave_bored.bvh": {"style": "mad", "action": "wave"}}
    scan = scan_corpus(load_recipe(tables), corpus)
    assert {f.relative: f.emotion for f in scan.files} == {
        "ann/wave_bored.bvh": "angry",
        "ann/wave_mad.bvh": "happy",
        "bob/wave_glad.bvh": "angry",
    }
    assert scan.rows_without_file == ("none.bvh",)


def test_files_nothing_labels_are_an_error_or_counted(corpus: Path) -> None:
    (corpus / "labels.csv").write_text("file,style\nwave_mad,mad\nwave_glad,\n")
    message = r"3 problems:\n  ann/wave_bored.bvh: no label; .*\n  ann/wave_mad.bvh: no action; "
    with pytest.raises(ValueError, match=message):
        scan_corpus(load_recipe(recipe(corpus=FILES)), corpus)
    scan = scan_corpus(load_recipe(recipe(corpus={**FILES, "unlabelled": "exclude"})), corpus)
    assert not scan.files
    assert scan.excluded("unlabelled") == {"no action": 1, "no label": 2}
    (corpus / "labels.csv").unlink()
    scan = scan_corpus(load_recipe(recipe(corpus={**FILES, "unlabelled": "exclude"})), corpus)
    assert "there is no labels.csv in" in scan.left_out[0].reason


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name,style\na,mad\n", r"columns that differ, one of them 'file', got \['name', 'style'"),
        ("", "one of them 'file', got"),
        ("file,style\na,mad,b\n", "row 2: expected 2 cells, got 3"),
        ("file,style\na,mad\n,mad\n", "row 3: expected a file of its own, got no file"),
        ("file,style\na,mad\na,glad\n", "row 3: expected a file of its own, got 'a' twice"),
        (b"file,style\n\xff,mad\n", "expected UTF-8 text, got byte 11"),
    ],
)
def test_a_wrong_table_says_which_row(corpus: Path, text: str | bytes, message: str) -> None:
    path = corpus / "labels.csv"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    with pytest.raises(ValueError, match=message) as caught:
        scan_corpus(load_recipe(recipe(corpus=FILES)), corpus)
    assert str(caught.value).startswith(str(path))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"labels": {"mad": "furious"}}, "label 'mad' maps to 'furious'; expected one of angry"),
        ({"labels": {"mad": 1}}, r"\[labels\] 'mad' must be a text, got 1"),
        ({"excluded": {"mad": "why"}}, r"\['mad'\] stand in both \[labels\] and \[excluded\]"),
        ({"excluded": {"sly": ""}}, r"\[excluded\] 'sly' must be a text, got ''"),
        ({"corpus": {"pattern": "("}}, "pattern is no regular expression"),
        ({"corpus": {"pattern": "(?P<style>.*)"}}, r"pattern needs the named groups \['actor'\]"),
        ({"corpus": {"group": "{take}"}}, r"groups \['take'\], which group = '{take}' uses"),
        ({"corpus": {"group": "{take"}}, "group is no template"),
        (
            {"corpus": {"licnce": "x"}},
            r"\[corpus\] knows no 'licnce'; is it 'licence'\? Known: act",
        ),
        ({"corpus": {"fps": "30"}}, r"\[corpus\] fps must be a number, got '30'"),
        ({"corpus": {"fps": 0}}, r"\[corpus\] fps must be positive, got 0"),
        ({"corpus": {"skip_frames": -1}}, "skip_frames must be a whole number from 0, got -1"),
        ({"corpus": {"name": 3}}, r"\[corpus\] name must be a text, got 3"),
        ({"corpus": {"up_axis": "x"}}, "up_axis must be one of y, z, got 'x'"),
        ({"corpus": {"format": "fbx"}}, "format must be one of bvh, smpl_npz, got 'fbx'"),
        ({"corpus": {"height_m": [2.2, 1.2]}}, "height_m must be a low and a high number"),
        ({"corpus": {"height_m": 2}}, "height_m must be a list of numbers, got 2"),
        ({"corpus": {"redistribution": "no"}}, "redistribution must be true or false, got 'no'"),
        (
            {"joints": {"left_toe": "x"}},
            r"\[joints\] knows no 'left_toe'; is it 'left_knee'\?",
        ),
        ({"joints": {"head": 3}}, r"\[joints\] head must be a name or a list of names, got 3"),
    ],
)
def test_a_wrong_recipe_is_named(changes: dict[str, dict[str, Any]], message: str) -> None:
    with pytest.raises(ValueError, match=message) as caught:
        load_recipe(recipe(**changes))
    assert str(caught.value).startswith("recipe: ")


def test_a_recipe_that_lacks_or_misspells_something_is_named(tmp_path: Path) -> None:
    lacking = recipe()
    del lacking["joints"]
    with pytest.raises(ValueError, match=r"got none of \['joints'\]"):
        load_recipe(lacking)
    with pytest.raises(ValueError, match=r"recipe knows no 'exclude'; is it 'excluded'\?"):
        load_recipe(recipe() | {"exclude": {}})
    with pytest.raises(ValueError, match=r"recipe: \[ignore\] '\(' is no regular expression"):
        load_recipe(recipe() | {"ignore": {"(": "why"}})
    lacking = recipe()
    del lacking["corpus"]["fps"]
    with pytest.raises(ValueError, match=r"\[corpus\] needs the key 'fps'"):
        load_recipe(lacking)
    lacking = recipe()
    del lacking["joints"]["head"]
    with pytest.raises(ValueError, match=r"\[joints\] expected a source joint for \['head'\]"):
        load_recipe(lacking)
    path = tmp_path / "broken.toml"
    path.write_text("[corpus\n")
    with pytest.raises(ValueError, match=r"broken.toml: not TOML"):
        load_recipe(path)
    with pytest.raises(FileNotFoundError, match=r"no corpus recipe 'kdea': .* amass, .* kdae, xia"):
        load_recipe("kdea")
    with pytest.raises(FileNotFoundError, match=r"none.toml: no such recipe"):
        load_recipe(tmp_path / "none.toml")


def test_joints_go_by_the_first_name_a_file_has() -> None:
    tables = recipe(joints={"left_shoulder": ["LeftArm", "LeftShoulder"], "spine2": ["a", "b"]})
    tables["joints"]["left_collar"] = ["LeftCollar", "LeftShoulder"]
    loaded = load_recipe(tables)
    others = [n for n in JOINT_NAMES if n not in ("left_shoulder", "left_collar", "spine2")]
    found = loaded.joint_map([*others, "LeftArm", "LeftShoulder"])
    assert (found["left_collar"], found["left_shoulder"]) == ("LeftShoulder", "LeftArm")
    assert "spine2" not in found
    found = loaded.joint_map([*others, "LeftCollar", "LeftShoulder"])
    assert (found["left_collar"], found["left_shoulder"]) == ("LeftCollar", "LeftShoulder")
    with pytest.raises(ValueError, match=r"uses joints twice: {'LeftShoulder': .*'left_collar'"):
        loaded.joint_map([*others, "LeftShoulder"])
    with pytest.raises(ValueError, match=r"not there: left_shoulder = 'LeftArm' or 'LeftShoulder'"):
        loaded.joint_map(others)
