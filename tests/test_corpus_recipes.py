"""The recipes that ship: made-up trees of exact layout, and the real files there are."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from corpus_files import (
    BEND_DEG,
    bend_share,
    body_rig,
    elbow_bends_deg,
    emilya_rig,
    kdae_rig,
    rig_bvh,
    smpl_arrays,
    write_emilya,
    write_kdae,
    write_smpl,
    write_tree,
)
from paper_sources import write_dyads

from affectsim_data.builders.corpora import (
    import_file,
    load_recipe,
    read_corpus,
    read_source,
    scan_corpus,
    stature_m,
)
from affectsim_data.builders.measuring import partner_place
from affectsim_data.builders.performances import perform_dyad
from affectsim_data.motions import EMOTIONS, Motion
from affectsim_data.motions.bvh import read_bvh
from affectsim_data.motions.looping import seam_step
from affectsim_data.poses import transform_points
from affectsim_data.skeletons import JOINT_NAMES

RECIPES = ("amass", "bandai_namco", "bvh", "cmu", "dyads", "emilya", "kdae", "xia")


def check_bend(motion: Motion) -> None:
    """The left elbow bends forward, to 40 degrees after a second of two; nothing else moves."""
    assert motion.fps == 30.0
    expected = BEND_DEG * bend_share(60)[:31]
    np.testing.assert_allclose(elbow_bends_deg(motion)[:31], expected, atol=0.5)
    np.testing.assert_allclose(elbow_bends_deg(motion, "right")[:31], 0.0, atol=0.5)
    places = motion.joint_positions()[30]
    elbow, wrist = (places[JOINT_NAMES.index(f"left_{part}")] for part in ("elbow", "wrist"))
    assert wrist[2] - elbow[2] > 0.1, "it bends towards the front"
    assert places[JOINT_NAMES.index("head"), 1] > 1.3
    assert abs(places[JOINT_NAMES.index("left_ankle"), 1] - 0.065) < 0.03


@pytest.mark.parametrize("name", RECIPES)
def test_every_recipe_says_whose_it_is(name: str) -> None:
    recipe = load_recipe(name)
    assert recipe.name == name
    assert recipe.licence
    assert recipe.obtain
    assert recipe.citation or name in ("bvh", "dyads")
    assert recipe.redistribution == (name == "cmu")
    assert set(recipe.labels.values()) <= set(EMOTIONS)
    assert all(len(reason) > 2 for reason in (*recipe.excluded.values(), *recipe.ignore.values()))


def test_the_made_up_skeletons_are_those_of_the_corpora(tmp_path: Path) -> None:
    for rig, joints, ends in ((kdae_rig(), 59, 13), (emilya_rig(), 23, 5)):
        path = tmp_path / "clip.bvh"
        path.write_text(rig_bvh(rig, 3, 125.0), encoding="utf-8")
        clip = read_bvh(path)
        assert (len(clip.joint_names), len(clip.end_sites)) == (joints, ends)
    path.write_text(rig_bvh(kdae_rig(), 3, 125.0), encoding="utf-8")
    clip = read_bvh(path)
    order = "Xposition Yposition Zposition Zrotation Xrotation Yrotation"
    assert {" ".join(names) for names in clip.channels} == {order}
    np.testing.assert_allclose(clip.offsets[0], [0.0, 93.0, 0.0])


def test_kdae(tmp_path: Path) -> None:
    names = ["F01A0V1", "F01SA2V1", "F01SA2V2", "M02SU1V1", "M02D3V1", "M02N5V2", "F11F1V1"]
    write_kdae(tmp_path, [*names, "M02H4V1"])
    reading = read_corpus("kdae", tmp_path)
    found = {
        m.motion_id: (m.performer_id, m.emotion, m.performance, m.take, m.group_id)
        for m in reading.complete()
    }
    assert found == {
        "kdae/F01A0V1": ("kdae_F01", "angry", "scenario_0", 1, "kdae/F01A0"),
        "kdae/F01SA2V1": ("kdae_F01", "sad", "scenario_2", 1, "kdae/F01SA2"),
        "kdae/F01SA2V2": ("kdae_F01", "sad", "scenario_2", 2, "kdae/F01SA2"),
        "kdae/F11F1V1": ("kdae_F11", "fearful", "scenario_1", 1, "kdae/F11F1"),
        "kdae/M02H4V1": ("kdae_M02", "happy", "scenario_4", 1, "kdae/M02H4"),
        "kdae/M02N5V2": ("kdae_M02", "neutral", "scenario_5", 2, "kdae/M02N5"),
    }
    assert {m.action for m in reading.motions} == {"scenario"}
    assert reading.scan.excluded() == {"D": 1, "SU": 1}
    check_bend(reading.motions[0])
    recipe = load_recipe("kdae")
    file = scan_corpus(recipe, tmp_path).files[0]
    source = import_file(recipe, file).source
    assert source.fps == pytest.approx(125.0)
    assert 1.2 < stature_m(source, recipe.joint_map(source.joint_names)) < 2.2
    write_kdae(tmp_path, ["F01X0V1"])
    with pytest.raises(ValueError, match=r"kdae.toml: label 'X' maps to no emotion; add it to"):
        read_corpus("kdae", tmp_path)


def test_emilya(tmp_path: Path) -> None:
    places = [
        ("Simple Walk", "Panic Fear", "Brian"),
        ("Being Seated", "Joy", "Elie"),
        ("Sitting Down", "Sadness", "Hu"),
        ("Knocking on the Door", "Anger", "Sally"),
        ("Simple Walk", "Neutral", "Sally"),
        ("Simple Walk", "Shame", "Sally"),
        ("Lift", "Anger", "Sally"),
    ]
    write_emilya(tmp_path, places)
    reading = read_corpus("emilya", tmp_path)
    found = {(m.performer_id, m.action, m.emotion, m.take) for m in reading.complete()}
    assert found == {
        (f"emilya_{actor}", action, emotion, take)
        for actor, action, emotion in (
            ("Brian", "simple_walk", "fearful"),
            ("Elie", "being_seated", "happy"),
            ("Hu", "sit_down", "sad"),
            ("Sally", "knock_door", "angry"),
            ("Sally", "simple_walk", "neutral"),
        )
        for take in (0, 1)
    }
    assert reading.scan.excluded("style", "action") == {"Shame": 2, "Lift": 2}
    ignored = [one for one in reading.scan.left_out if one.cause == "ignored"]
    assert [one.count for one in ignored] == [len(places)]
    check_bend(reading.motions[0])
    assert len(scan_corpus(load_recipe("emilya"), tmp_path / "Emilya" / "PerAction").files) == 10
    write_emilya(tmp_path, [("Sneaking", "Anger", "Hu")])
    with pytest.raises(ValueError, match=r"emilya.toml: action 'Sneaking' has no word; add it to"):
        read_corpus("emilya", tmp_path)


def test_amass_is_read_where_a_table_labels_it(tmp_path: Path) -> None:
    for number, arrays in enumerate((smpl_arrays(), smpl_arrays(width=165), smpl_arrays())):
        arrays["mocap_frame_rate"] = arrays.pop("mocap_framerate")
        write_smpl(tmp_path / "BMLmovi" / "Subject_1" / f"act_{number}_poses.npz", arrays)
    write_smpl(tmp_path / "BMLmovi" / "Subject_1" / "shape.npz")
    scan = scan_corpus(load_recipe("amass"), tmp_path)
    assert not scan.files
    assert scan.excluded("unlabelled") == {"no label": 3}
    (tmp_path / "labels.csv").write_text(
        "file,style,action\nact_0_poses,sad,scenario\nact_1_poses.npz,happy,scenario\n"
    )
    reading = read_corpus("amass", tmp_path)
    motions = reading.complete()
    assert [m.emotion for m in motions] == ["sad", "happy"]
    assert {m.performer_id for m in motions} == {"amass_BMLmovi_Subject_1"}
    assert {one.cause: one.count for one in reading.scan.left_out} == {
        "ignored": 1,
        "unlabelled": 1,
    }
    check_bend(motions[0])


def test_the_recipe_to_copy_reads_common_exporters(tmp_path: Path) -> None:
    text = rig_bvh(kdae_rig(), 250, 125.0)
    mixamo = text.replace("ROOT ", "ROOT mixamorig:").replace("JOINT ", "JOINT mixamorig:")
    own = rig_bvh(body_rig(), 60, 30.0)
    xsens = rig_bvh(emilya_rig(), 60, 30.0)
    for name, content in (("noitom", text), ("mixamo", mixamo), ("own", own), ("xsens", xsens)):
        write_tree(tmp_path, [f"{name}/happy/being_seated_3.bvh"], content)
    motions = read_corpus("bvh", tmp_path).complete()
    assert [m.performer_id for m in motions] == ["mixamo", "noitom", "own", "xsens"]
    assert {(m.action, m.emotion, m.take) for m in motions} == {("being_seated", "happy", 3)}
    for motion in motions:
        check_bend(motion)


def test_dyads_stand_as_they_were_recorded(tmp_path: Path) -> None:
    write_dyads(tmp_path, 2)
    reading = read_corpus("dyads", tmp_path)
    motions = reading.complete()
    assert [m.motion_id.rsplit("/", 1)[-1] for m in motions] == ["target", "partner"] * 2
    for number, (target, partner) in enumerate(zip(motions[::2], motions[1::2], strict=True)):
        emotion = EMOTIONS[number]
        dyad = perform_dyad(emotion, ("p1", "p2"), rng=np.random.default_rng([9, number]))
        assert (target.emotion, target.action) == (emotion, "interaction")
        assert target.group_id == partner.group_id != motions[2 - 2 * number].group_id
        assert target.performer_id != partner.performer_id
        assert target.num_frames == partner.num_frames == dyad.target.num_frames
        body = slice(0, target.num_frames - 20)  # the rest is the seam
        found, wanted = (
            np.linalg.norm(
                one.joint_positions()[body, :, None]
                - transform_points(pose, other.joint_positions()[body])[:, None],
                axis=-1,
            )
            for one, pose, other in (
                (target, partner_place(), partner),
                (dyad.target, dyad.T_target_partner, dyad.partner),
            )
        )
        # Every distance from a joint of the one to a joint of the other.
        np.testing.assert_allclose(found, wanted, atol=0.012)


def centred(path: Path) -> Path:
    """Moves a BVH file's person to the origin, as some exporters do."""
    shift_root(path, -first_root(path))
    return path


def first_root(path: Path) -> np.ndarray:
    lines = path.read_text(encoding="utf-8").splitlines()
    first = next(n for n, line in enumerate(lines) if line.startswith("Frame Time")) + 1
    return np.array([float(number) for number in lines[first].split()[:3]]) * [1.0, 0.0, 1.0]


def shift_root(path: Path, by_cm: np.ndarray, *, growing: bool = False) -> None:
    """Moves the person of a BVH file, at once or more and more to the end."""
    lines = path.read_text(encoding="utf-8").splitlines()
    start = next(n for n, line in enumerate(lines) if line.startswith("Frame Time")) + 1
    for number in range(start, len(lines)):
        share = (number - start) / (len(lines) - start) if growing else 1.0
        x, y, z, rest = lines[number].split(maxsplit=3)
        place = np.array([float(x), float(y), float(z)]) + share * by_cm
        lines[number] = " ".join(f"{value:.4f}" for value in place) + f" {rest}"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def shortened(path: Path) -> None:
    """Leaves out the last second and a half of a BVH file."""
    lines = path.read_text(encoding="utf-8").splitlines()[:-45]
    place = next(n for n, line in enumerate(lines) if line.startswith("Frames:"))
    lines[place] = f"Frames: {len(lines) - place - 2}"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda target, partner: [centred(path) for path in (target, partner)],
         r"two people 0\.2 to 4\.0 m apart at the start, got 0\.\d\d m; both files must be in"),
        (lambda target, partner: shortened(partner),
         r"two files of one recording, equally long, got \d\.\d\d s and \d\.\d\d s"),
        (lambda target, partner: shift_root(partner, np.array([90.0, 0, 0]), growing=True),
         r"expected the partner to end within 0\.5 m of where it began, got \d\.\d\d m"),
    ],
    ids=["centred", "unequal", "walks off"],
)  # fmt: skip
def test_two_files_that_show_no_interaction_are_told(
    tmp_path: Path, damage: Callable[[Path, Path], object], message: str
) -> None:
    write_dyads(tmp_path, 1)
    damage(*sorted(tmp_path.rglob("*.bvh"), reverse=True))
    reading = read_corpus("dyads", tmp_path)
    assert len(reading.failures) == 1
    with pytest.raises(ValueError, match=rf"pair angry/\S+ and angry/\S+: .*{message}"):
        reading.complete()


def test_files_of_pairs_are_paired_by_name(tmp_path: Path) -> None:
    names = ["sad/a/target_ann.bvh", "sad/a/partner_bob.bvh", "sad/b/target_ann.bvh"]
    write_tree(tmp_path, names, "")
    scan = scan_corpus(load_recipe("dyads"), tmp_path)
    assert [[file.role for file in clip] for clip in scan.clips()] == [["target", "partner"]]
    assert scan.excluded("unpaired") == {"dyads/sad/b": 1}
    write_tree(tmp_path, ["sad/a/target_cai.bvh"], "")
    with pytest.raises(ValueError, match=r"'dyads/sad/a' must have one target and one partner"):
        scan_corpus(load_recipe("dyads"), tmp_path)
    (tmp_path / "sad/a/target_cai.bvh").rename(tmp_path / "sad/a/observer_cai.bvh")
    with pytest.raises(ValueError, match=r"role 'observer' is neither target nor partner; add it"):
        scan_corpus(load_recipe("dyads"), tmp_path)


@pytest.mark.realdata
def test_the_bandai_namco_corpus(realdata: Path) -> None:
    reading = read_corpus("bandai_namco", realdata / "bandai_namco")
    motions = reading.complete()
    assert not reading.recipe.redistribution
    assert reading.scan.counts()["walk", "angry"] == 1
    assert reading.scan.excluded("style")["proud"] == 6
    assert len(motions) == len(reading.scan.files) == 30
    assert {m.emotion for m in motions} == {"angry", "happy", "neutral", "sad"}
    assert {m.performer_id for m in motions} == {"bandai_namco_set1", "bandai_namco_set2"}
    assert all(m.licence == "CC-BY-NC-4.0" for m in motions)
    for motion in motions:
        excess_m, excess_rad = seam_step(motion)
        assert excess_m < 0.02, motion.motion_id
        assert excess_rad < np.deg2rad(5.0), motion.motion_id
        assert np.ptp(motion.root_translation[:, [0, 2]], axis=0).max() < 5.5


@pytest.mark.realdata
def test_the_xia_and_cmu_files(realdata: Path, tmp_path: Path) -> None:
    xia = read_corpus("xia", realdata / "xia_styles")
    found = {(m.emotion, m.action, m.take) for m in xia.complete()}
    assert found == {("angry", "run", 0), ("neutral", "walk", 0), ("neutral", "jump", 0)}
    assert xia.scan.excluded() == {"depressed": 2, "old": 1, "sexy": 2, "strutting": 1}
    recipe = load_recipe("cmu")
    scan = scan_corpus(recipe, realdata / "cmu")
    assert scan.excluded("unlabelled") == {"no label": 5}
    text = Path(recipe.recipe_path).read_text(encoding="utf-8")
    labelled = tmp_path / "labelled.toml"
    labelled.write_text(f'{text}\n[files]\n12_01_walk = {{ style = "neutral", action = "walk" }}\n')
    (motion,) = read_corpus(labelled, realdata / "cmu").complete()
    assert (motion.motion_id, motion.performer_id) == ("cmu/12_01", "cmu_12")
    assert (motion.action, motion.emotion) == ("simple_walk", "neutral")


@pytest.mark.realdata
@pytest.mark.parametrize(
    ("name", "folder", "metres_per_unit"),
    [
        ("bandai_namco", "bandai_namco", 0.0),
        ("cmu", "cmu", 0.0),
        ("xia", "xia_styles", 0.0),
        ("bvh", "pymo_affect_walk", 0.0254),
    ],
)
def test_people_of_real_files_are_of_human_size(
    realdata: Path, name: str, folder: str, metres_per_unit: float
) -> None:
    recipe = load_recipe(name)
    if metres_per_unit:
        recipe = dataclasses.replace(recipe, metres_per_unit=metres_per_unit)
    paths = sorted((realdata / folder).rglob("*.bvh"))
    assert paths
    for path in paths:
        source = read_source(recipe, path)
        assert 1.2 < stature_m(source, recipe.joint_map(source.joint_names)) < 2.2, path.name
