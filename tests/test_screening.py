"""Screening: broken motions are caught, clean ones pass, and the report says why."""

from __future__ import annotations

import collections
import dataclasses
import pickle
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from defects import DEFECTS, NotPossibleError, Take, take_of, take_of_motion

from affectsim_data.builders.corpora import load_recipe
from affectsim_data.builders.performances import perform
from affectsim_data.builders.screening import (
    REPORT_SCHEMA,
    Finding,
    Jerkiness,
    ScreenReport,
    jerkiness,
    load_thresholds,
    screen_motion,
    screen_outliers,
)
from affectsim_data.builders.screening.joint_checks import joint_angles
from affectsim_data.content import content_path
from affectsim_data.motions import EMOTIONS, Motion
from affectsim_data.motions.bvh import read_bvh
from affectsim_data.motions.joint_frames import SourcePose
from affectsim_data.motions.looping import make_cyclic
from affectsim_data.motions.retargeting import resample, retarget, source_pose
from affectsim_data.poses import quaternion_multiply, quaternion_rotate, yaw_quaternion
from affectsim_data.skeletons import JOINT_NAMES

LIMITS = load_thresholds()
CHECKS = tuple(check for check in LIMITS.checks if check != "jerk")
IDENTITY = {name: name for name in JOINT_NAMES}
_SIDES = {"left": "right", "right": "left"}
_MIRRORED = [
    JOINT_NAMES.index("_".join([_SIDES.get(part, part) for part in name.split("_")]))
    for name in JOINT_NAMES
]
"""Place of each joint's twin on the other side."""


def knock(emotion: str = "neutral", who: str = "p1") -> Motion:
    return perform("knock_door", emotion, who, rng=np.random.default_rng(3))  # type: ignore[arg-type]


def screened(motion: Motion, source: SourcePose | None = None) -> dict[str, Finding]:
    joints = {name: name for name in source.joint_names} if source else None
    found = screen_motion(motion, source=source, joints=joints, thresholds=LIMITS)
    return {finding.check: finding for finding in found}


def rejecting(findings: dict[str, Finding]) -> set[str]:
    return {check for check, finding in findings.items() if not finding.passed}


def _failures(findings: dict[str, Finding]) -> set[tuple[str, str]]:
    """Checks that reject, and the joint they name."""
    return {(check, findings[check].joint) for check in rejecting(findings)}


def recorded(take: Take, motion: Motion) -> tuple[Motion, SourcePose]:
    """A take of the canonical body as a motion and its recording."""
    broken = dataclasses.replace(
        motion,
        root_translation=take.local_positions[:, 0],
        joint_rotations=take.local_rotations,
    )
    return broken, take.source()


def test_injected_defects_are_caught() -> None:
    caught: collections.Counter[str] = collections.Counter()
    made: collections.Counter[str] = collections.Counter()
    for number, emotion in enumerate(EMOTIONS):
        action = ("knock_door", "sit_down")[number % 2]
        motion = perform(action, emotion, "p1", rng=np.random.default_rng(number))  # type: ignore[arg-type]
        take = take_of_motion(motion)
        before = _failures(screened(*recorded(take, motion)))
        for kind, inject in DEFECTS.items():
            broken = take.copy()
            try:
                inject(broken, np.random.default_rng([number, len(made)]))
            except NotPossibleError:
                continue
            made[kind] += 1
            caught[kind] += bool(_failures(screened(*recorded(broken, motion))) - before)
    assert set(made) == set(DEFECTS)
    assert sum(caught.values()) >= 0.95 * sum(made.values()), (caught, made)
    assert all(caught[kind] >= 0.6 * made[kind] for kind in DEFECTS), (caught, made)


@pytest.mark.parametrize("emotion", EMOTIONS)
def test_a_clean_motion_passes_every_check(emotion: str) -> None:
    found = screened(knock(emotion))
    assert tuple(found) == CHECKS
    assert rejecting(found) == set()
    assert found["bone_drift"].reason == "not checked: the motion has no source skeleton"
    assert np.isnan(found["bone_drift"].value)


def test_a_teleport_is_found_where_it_is() -> None:
    motion = knock()
    root = motion.root_translation.copy()
    root[40:, 0] += 0.5
    finding = screened(dataclasses.replace(motion, root_translation=root))["root_jump"]
    assert not finding.passed
    assert finding.value == pytest.approx(0.5, abs=0.02)
    assert (finding.frame, finding.joint, finding.unit) == (40, "pelvis", "m")
    assert finding.time_s == pytest.approx(40 / 30.0)
    assert finding.reason.endswith("at most 0.08 m passes")


def test_lost_and_repeated_frames_are_told_apart() -> None:
    motion = knock("angry")
    frames = np.arange(motion.num_frames)
    held = np.where((frames >= 20) & (frames < 30), 20, frames)
    positions = motion.root_translation
    found = screened(
        dataclasses.replace(
            motion,
            root_translation=positions[held],
            joint_rotations=motion.joint_rotations[held],
        )
    )
    assert found["repeated_frames"].value == pytest.approx(0.3)
    assert found["repeated_frames"].frame == 20
    assert not found["repeated_frames"].passed


def test_a_knee_that_bends_backwards_has_negative_flexion() -> None:
    rotations = np.zeros((2, 22, 4))
    rotations[..., 0] = 1.0
    for side in ("left", "right"):
        half = np.deg2rad(np.array([40.0, -40.0])) / 2.0
        knee = JOINT_NAMES.index(f"{side}_knee")
        rotations[:, knee] = np.stack([np.cos(half), np.sin(half), 0 * half, 0 * half], axis=1)
        np.testing.assert_allclose(joint_angles(rotations)[f"{side}_knee_flexion"], [40.0, -40.0])


def test_a_bone_is_measured_against_itself_and_its_twin() -> None:
    motion = knock()
    for_good = take_of_motion(motion)
    for_good.local_positions[:, for_good.index("left_elbow")] *= 1.2
    found = screened(*recorded(for_good, motion))
    assert found["bone_drift"].passed
    assert found["bone_asymmetry"].value == pytest.approx(0.2)
    assert found["bone_asymmetry"].joint == "left_elbow"
    for_a_while = take_of_motion(motion)
    for_a_while.local_positions[30:50, for_a_while.index("neck")] *= 1.3
    drift = screened(*recorded(for_a_while, motion))["bone_drift"]
    assert drift.value == pytest.approx(0.3)
    assert (drift.frame, drift.joint, drift.passed) == (30, "neck", False)


def test_a_map_that_skips_a_joint_makes_no_bone_drift() -> None:
    motion = knock()
    bend = motion.joint_rotations.copy()
    half = 0.3 * np.sin(np.arange(motion.num_frames) / 10.0)
    zero = np.zeros_like(half)
    for name in ("spine3", "neck"):
        joint = JOINT_NAMES.index(name)
        bend[:, joint] = np.stack([np.cos(half), np.sin(half), zero, zero], axis=1)
    source = take_of_motion(dataclasses.replace(motion, joint_rotations=bend)).source()
    joints = {name: name for name in JOINT_NAMES if name != "neck"}
    found = screen_motion(motion, source=source, joints=joints, thresholds=LIMITS)
    assert next(f.value for f in found if f.check == "bone_drift") == 0.0


@pytest.mark.parametrize("kind", ["clean", "swapped_limb", "slid_foot", "flipped_knee"])
def test_where_the_person_stands_and_faces_makes_no_difference(kind: str) -> None:
    take = take_of_motion(knock())
    if kind != "clean":
        DEFECTS[kind](take, np.random.default_rng(5))
    motion, _ = recorded(take, knock())
    turn = yaw_quaternion(0.7)
    local = motion.joint_rotations.copy()
    local[:, 0] = quaternion_multiply(turn, local[:, 0])
    root = quaternion_rotate(turn, motion.root_translation) + np.array([3.0, 0.0, -2.0])
    moved = dataclasses.replace(motion, root_translation=root, joint_rotations=local)
    _same(screened(motion), screened(moved))


@pytest.mark.parametrize("kind", ["clean", "swapped_limb", "slid_foot", "flipped_knee"])
def test_a_mirrored_person_is_judged_alike(kind: str) -> None:
    take = take_of_motion(knock())
    if kind != "clean":
        DEFECTS[kind](take, np.random.default_rng(5))
    motion, _ = recorded(take, knock())
    mirrored = dataclasses.replace(
        motion,
        root_translation=motion.root_translation * [-1.0, 1.0, 1.0],
        joint_rotations=motion.joint_rotations[:, _MIRRORED] * [1.0, 1.0, -1.0, -1.0],
    )
    _same(screened(motion), screened(mirrored))


def test_bones_do_not_depend_on_the_unit_or_the_place() -> None:
    take = take_of_motion(knock())
    DEFECTS["scaled_bone"](take, np.random.default_rng(1))
    motion, source = recorded(take, knock())
    other = dataclasses.replace(
        source, positions=1.7 * quaternion_rotate(yaw_quaternion(1.0), source.positions) + 4.0
    )
    one, two = screened(motion, source), screened(motion, other)
    for check in ("bone_drift", "bone_asymmetry", "repeated_frames"):
        assert one[check].value == pytest.approx(two[check].value)
        assert one[check].joint == two[check].joint


def _same(one: dict[str, Finding], two: dict[str, Finding]) -> None:
    for check in one:
        assert one[check].value == pytest.approx(two[check].value, abs=1e-6, nan_ok=True), check
        assert one[check].passed == two[check].passed


def test_findings_travel_between_processes() -> None:
    found = screen_motion(knock(), source=None, joints=None, thresholds=LIMITS)
    again = pickle.loads(pickle.dumps((LIMITS, found)))  # our own bytes
    assert again[0] == LIMITS
    assert [f.check for f in again[1]] == list(CHECKS)


def test_a_source_needs_its_joint_map() -> None:
    source = take_of_motion(knock()).source()
    with pytest.raises(ValueError, match="source needs joints, the joint map, too"):
        screen_motion(knock(), source=source, joints=None, thresholds=LIMITS)


def _class(count: int, jerk: float, action: str = "bow") -> list[Jerkiness]:
    spread = np.exp(np.linspace(-0.3, 0.3, count))
    return [
        Jerkiness(f"{action}/{i}", action, "happy", jerk * x, 8.0 * jerk * x, 5)
        for i, x in enumerate(spread.tolist())
    ]


def test_jerk_is_compared_within_the_class_where_it_is_large_enough() -> None:
    calm = _class(20, 10.0)
    # Usual for a run, but not among bows.
    odd = Jerkiness("bow/odd", "bow", "happy", 300.0, 2400.0, 7)
    found = screen_outliers([*calm, odd, *_class(20, 300.0, "run")], LIMITS)
    rejected = [motion_id for motion_id, (jerk,) in found.items() if not jerk.passed]
    assert rejected == ["bow/odd"]
    (jerk,) = found["bow/odd"]
    assert (jerk.check, jerk.unit, jerk.frame) == ("jerk", "sigma", 7)
    assert "jerk is 300 m/s^3" in jerk.reason or "jerk is 2400 m/s^3" in jerk.reason
    assert all(jerk.passed for (jerk,) in screen_outliers([*calm[:3], odd], LIMITS).values())


def test_the_report_has_a_row_per_motion_and_check(tmp_path: Path) -> None:
    report = ScreenReport()
    motions = [knock("happy"), knock("sad")]
    for motion in motions:
        report.add(motion, screen_motion(motion, source=None, joints=None, thresholds=LIMITS))
    report.add_outliers(screen_outliers([jerkiness(m) for m in motions], LIMITS))
    root = motions[0].root_translation + np.array([0.0, -0.1, 0.0])
    sunk = dataclasses.replace(motions[0], motion_id="x/sunk", root_translation=root)
    report.add(sunk, screen_motion(sunk, source=None, joints=None, thresholds=LIMITS))
    report.add_failure("a/b.bvh", "a/b.bvh: expected 3 frames, got 2")
    assert report.rejected == {"x/sunk"}
    assert [finding.check for finding in report.failed("x/sunk")] == ["ground_penetration"]
    path = tmp_path / "new" / "report.parquet"
    report.write_report(path)
    table = pq.read_table(path)
    assert table.schema.equals(REPORT_SCHEMA, check_metadata=True)
    assert [entry.name for entry in path.parent.iterdir()] == ["report.parquet"]
    rows = table.to_pylist()
    assert len(rows) == 2 * len(LIMITS.checks) + len(CHECKS) + 1
    pairs = [(row["motion_id"], row["check"]) for row in rows]
    assert len(set(pairs)) == len(pairs)
    assert rows[-1]["check"] == "read"
    assert rows[-1]["reason"] == "a/b.bvh: expected 3 frames, got 2"
    assert not rows[-1]["passed"]
    lines = report.summary_lines()
    assert lines[1].split() == ["read", "1", "4", "25.0", "%"]
    assert next(x for x in lines if x.startswith("any")).split() == ["any", "1", "3", "33.3", "%"]
    assert lines[-1] == "unreadable: a/b.bvh: a/b.bvh: expected 3 frames, got 2"
    with pytest.raises(ValueError, match="'x/sunk' is in the screening report already"):
        report.add(sunk, ())


def test_columns_of_the_report_are_described() -> None:
    for field in REPORT_SCHEMA:
        assert field.metadata[b"description"], field.name


def test_a_recipe_changes_limits_and_switches_checks_off() -> None:
    changed = load_thresholds(
        {
            "foot_slide": {"limit": 0.2},
            "joint_limits": {"ranges_deg": {"hip_flexion": [-45, 150]}},
            "off": {"floating": "they fly"},
        }
    )
    assert changed.foot_slide.limit == 0.2
    assert changed.foot_slide.height_m == LIMITS.foot_slide.height_m
    assert changed.joint_limits.ranges_deg["hip_flexion"] == (-45.0, 150.0)
    assert changed.joint_limits.ranges_deg["knee_flexion"] == (-8.0, 165.0)
    root = knock().root_translation + np.array([0.0, 0.5, 0.0])
    flying = dataclasses.replace(knock(), root_translation=root)
    assert not screened(flying)["floating"].passed
    found = {
        f.check: f for f in screen_motion(flying, source=None, joints=None, thresholds=changed)
    }
    assert found["floating"].passed
    assert found["floating"].reason == "switched off: they fly"


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ({"foot_glide": {"limit": 1}}, r"\[screening\]: expected tables named .*'foot_glide'"),
        ({"foot_slide": {"limt": 1}}, r"foot_slide: expected one of .*'limit'.*, got 'limt'"),
        ({"foot_slide": 0.2}, "foot_slide must be a table, got 0.2"),
        ({"foot_slide": {"limit": "wide"}}, "foot_slide limit: expected a number, got 'wide'"),
        ({"foot_slide": {"limit": -1}}, "foot_slide limit: expected a number of 0 or more, got -1"),
        ({"foot_slide": {"limit": True}}, "foot_slide limit: expected a number, got True"),
        (
            {"joint_limits": {"ranges_deg": {"hip_bend": [0, 1]}}},
            r"joint_limits ranges_deg: expected a range for each of .*'hip_bend'",
        ),
        (
            {"joint_limits": {"ranges_deg": {"hip_flexion": [9, 1]}}},
            r"hip_flexion: expected \[lowest, highest\] in degrees, got \[9, 1\]",
        ),
        ({"off": {"foot_glide": "x"}}, r"expected checks of .*, got 'foot_glide'"),
        ({"off": {"foot_slide": ""}}, "foot_slide: expected a reason, got ''"),
    ],
)
def test_bad_thresholds_are_named(overrides: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        load_thresholds(overrides)


def test_a_file_of_thresholds_must_be_complete(tmp_path: Path) -> None:
    text = content_path("builders", "screening.toml").read_text(encoding="utf-8")
    path = tmp_path / "mine.toml"
    path.write_text(text.replace("height_m = 0.02\n", ""), encoding="utf-8")
    with pytest.raises(ValueError, match=r"mine\.toml: foot_slide: expected the keys .*'height_m'"):
        load_thresholds(path=path)
    path.write_text("[jerk]\nlimit = 1.0\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"mine\.toml: expected a table for each check, got none"):
        load_thresholds(path=path)


def _real_clips(folder: Path) -> list[tuple[str, SourcePose, dict[str, str]]]:
    """Every BVH recording of the four corpora, in metres, with its joint map."""
    recipes = {name: load_recipe(name) for name in ("bandai_namco", "cmu", "xia")}
    lower = {
        "pelvis": "Hips",
        "spine1": "Spine",
        "head": "Head",
        **{
            f"{side}_{ours}": f"{side.title()}{theirs}"
            for side in ("left", "right")
            for ours, theirs in {
                "collar": "Shoulder",
                "shoulder": "Arm",
                "elbow": "ForeArm",
                "wrist": "Hand",
                "hip": "UpLeg",
                "knee": "Leg",
                "ankle": "Foot",
                "foot": "ToeBase",
            }.items()
        },
    }
    clips = []
    for path in sorted(folder.rglob("*.bvh")):
        corpus = path.relative_to(folder).parts[0]
        name = {"xia_styles": "xia", "pymo_affect_walk": "pymo"}.get(corpus, corpus)
        if name not in {*recipes, "pymo"}:
            continue
        clip = read_bvh(path)
        unit = 0.0254 if name == "pymo" else recipes[name].metres_per_unit
        source = source_pose(clip, metres_per_unit=unit)
        joints = lower if name == "pymo" else dict(recipes[name].joint_map(source.joint_names))
        if path.stem in ("01_01", "12_01_walk"):
            # These open with a T-pose for calibration, which screening rightly finds.
            source = dataclasses.replace(
                source, positions=source.positions[1:], rotations=source.rotations[1:]
            )
        clips.append((path.stem, source, joints))
    return clips


def _imported(
    name: str, source: SourcePose, joints: dict[str, str], *, closed: bool = True
) -> dict[str, Finding]:
    """What screening says of a recording, retargeted and, if `closed`, made a cycle.

    Without a cycle there is no seam to be checked.
    """
    root, rotations = retarget(source, joints)
    root, rotations = resample(root, rotations, fps=source.fps, target_fps=30.0)
    motion = Motion(name, "p", name, "neutral", "any", 30.0, root, rotations)
    motion = make_cyclic(motion) if closed else motion
    found = screen_motion(motion, source=source, joints=joints, thresholds=LIMITS)
    return {f.check: f for f in found if closed or not f.check.startswith("seam")}


@pytest.mark.realdata
@pytest.mark.slow
@pytest.mark.parametrize("closed", [False, True])
def test_clean_recordings_pass(realdata: Path, *, closed: bool) -> None:
    clips = _real_clips(realdata)
    assert len(clips) >= 90
    found = {
        name: rejecting(_imported(name, source, joints, closed=closed))
        for name, source, joints in clips
    }
    rejected = {name: checks for name, checks in found.items() if checks}
    assert len(rejected) <= 0.05 * len(clips), rejected


@pytest.mark.realdata
@pytest.mark.slow
def test_broken_recordings_are_caught(realdata: Path) -> None:
    caught: collections.Counter[str] = collections.Counter()
    made: collections.Counter[str] = collections.Counter()
    for number, (name, source, joints) in enumerate(_real_clips(realdata)):
        take = take_of(source, joints)
        names = {joint: joint for joint in take.names}
        before = rejecting(_imported(name, take.source(), names))
        for turn in range(2):
            kind = list(DEFECTS)[(2 * number + turn) % len(DEFECTS)]
            broken = take.copy()
            try:
                DEFECTS[kind](broken, np.random.default_rng([11, number, turn]))
            except NotPossibleError:
                continue
            made[kind] += 1
            caught[kind] += bool(rejecting(_imported(name, broken.source(), names)) - before)
    assert sum(caught.values()) >= 0.95 * sum(made.values()), (caught, made)
    assert all(caught[kind] >= 0.8 * made[kind] for kind in DEFECTS), (caught, made)


@pytest.mark.realdata
def test_a_calibration_pose_before_the_clip_is_found(realdata: Path) -> None:
    clip = read_bvh(realdata / "cmu" / "12_01_walk.bvh")
    recipe = load_recipe("cmu")
    source = source_pose(clip, metres_per_unit=recipe.metres_per_unit)
    jump = _imported("walk", source, dict(recipe.joint_map(source.joint_names)))["dropped_frames"]
    assert not jump.passed
    assert jump.frame <= 3
