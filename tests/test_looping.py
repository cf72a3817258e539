"""Cycles: seams closed, feet in steps instead of slides, turns on foot, and everything undone."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from real_clips import real_clips
from walkers import swayer, walker

from affectsim_data.motions import Motion
from affectsim_data.motions.looping import close_loop, make_cyclic, out_and_back, seam_step
from affectsim_data.motions.planting import ANKLES, TOES, find_stances, stance_slides
from affectsim_data.motions.retargeting import resample, retarget
from affectsim_data.poses import FloatArray, quaternion_rotate, yaw_quaternion
from affectsim_data.skeletons import BODY, JOINT_NAMES

KNEES = [JOINT_NAMES.index(f"{side}_knee") for side in ("left", "right")]


def cut(motion: Motion, count: int) -> Motion:
    return dataclasses.replace(
        motion,
        root_translation=motion.root_translation[:count],
        joint_rotations=motion.joint_rotations[:count],
    )


def ring(motion: Motion) -> FloatArray:
    """Joint positions over a cycle and half of the next."""
    positions = motion.joint_positions()
    return np.concatenate([positions, positions[: len(positions) // 2]])


def assert_no_slides(motion: Motion, most_m: float) -> None:
    toes = ring(motion)[:, TOES]
    stances = find_stances(toes, motion.fps)
    assert stances
    assert stance_slides(toes, stances).max() < most_m


def assert_same(found: Motion, expected: Motion) -> None:
    for field in dataclasses.fields(Motion):
        a, b = (getattr(motion, field.name) for motion in (found, expected))
        if isinstance(b, np.ndarray):
            np.testing.assert_array_equal(a, b, err_msg=field.name)
        else:
            assert a == b, field.name


def test_a_loop_closes_and_says_so() -> None:
    part = dataclasses.replace(swayer(), provenance={"file": "a.bvh"})
    closed = close_loop(part)
    excess_m, excess_rad = seam_step(closed)
    assert excess_m < 0.005
    assert excess_rad < np.deg2rad(1.0)
    loop = closed.provenance["loop"]
    first = loop["frames"][0]
    np.testing.assert_array_equal(closed.joint_rotations[:first], part.joint_rotations[:first])
    assert closed.source == f"made; {loop['note']}"
    assert loop["note"].endswith("seam of 0.4 s blended")
    assert closed.provenance["file"] == "a.bvh"
    assert_no_slides(closed, 1e-3)


def test_the_end_is_given_up_where_that_brings_it_nearer_to_the_beginning() -> None:
    motion = swayer(seconds=4.0)
    root = motion.root_translation.copy()
    root[-15:, 0] += np.linspace(0.0, 0.05, 15)  # leans away at last
    leaning = dataclasses.replace(motion, root_translation=root)
    closed = close_loop(leaning)
    assert 0.8 * motion.num_frames <= closed.num_frames <= motion.num_frames - 10
    assert closed.source.startswith(f"made; first {closed.num_frames} of {motion.num_frames} frame")
    assert_same(closed.original(), leaning)


def test_a_foot_that_stands_elsewhere_at_the_end_steps_back() -> None:
    motion = swayer(drift_m=0.12)
    closed = close_loop(motion)
    assert_no_slides(closed, 0.005)
    assert max(seam_step(closed)) < 0.01
    left = ring(closed)[:, TOES[0]]
    first, last = closed.provenance["loop"]["frames"]
    assert left[first:last, 1].max() > 0.045  # it is lifted for that
    assert np.ptp(ring(closed)[first:last, TOES[1]], axis=0).max() < 1e-3  # and the other stays
    assert_same(closed.original(), motion)


def test_who_walks_off_walks_back_and_ends_where_they_began() -> None:
    motion = walker(seconds=2.7)
    cycle = make_cyclic(motion)
    turn = cycle.provenance["loop"]["turn_frames"]
    assert 1.2 <= turn / motion.fps <= 2.1
    used = cycle.provenance["loop"]["used_frames"]
    assert 0.8 * motion.num_frames <= used <= motion.num_frames
    assert cycle.num_frames == 2 * (used + turn)
    half = cycle.num_frames // 2
    back = yaw_quaternion(np.pi)
    positions = cycle.joint_positions()
    # The second half is the first, turned by half a circle: what follows it is the beginning.
    origin = positions[half] - quaternion_rotate(back, positions[0])
    np.testing.assert_allclose(
        positions[half:], quaternion_rotate(back, positions[:half]) + origin[0], atol=1e-6
    )
    heading = quaternion_rotate(cycle.joint_rotations[:, 0], [0.0, 0.0, 1.0])
    np.testing.assert_allclose(heading[half], heading[0] * [-1.0, 1.0, -1.0], atol=1e-9)
    assert cycle.source.endswith(f"out and back, turns of {turn / 30.0:.1f} s")
    assert_same(cycle.original(), motion)


@pytest.mark.parametrize("seconds", [1.7, 2.0, 2.3, 2.5, 2.9])
def test_turns_are_walked(seconds: float) -> None:
    """Whatever foot is in the air: no slide, jerk, crossed legs or backward knee."""
    motion = walker(seconds=seconds)
    cycle = out_and_back(motion)
    assert_no_slides(cycle, 0.01)
    excess_m, excess_rad = seam_step(cycle)
    assert excess_m < 0.02
    assert excess_rad < np.deg2rad(5.0)
    positions = ring(cycle)
    speeds = np.linalg.norm(np.diff(positions, axis=0), axis=-1) * cycle.fps
    own = np.linalg.norm(np.diff(motion.joint_positions(), axis=0), axis=-1) * motion.fps
    assert speeds.max() < 1.2 * own.max()
    jumps = np.linalg.norm(np.diff(positions, 2, axis=0), axis=-1) * cycle.fps**2
    assert jumps.max() < 75.0  # of the walk itself: 57
    assert positions[:, TOES, 1].min() > 0.0
    first, turn = (cycle.provenance["loop"][key] for key in ("used_frames", "turn_frames"))
    lifted = positions[first : first + turn, TOES, 1] > 0.035
    steps = np.abs(np.diff(lifted.astype(int), axis=0)).sum() / 2
    assert steps >= 3
    feet = positions[first : first + turn][:, [*TOES, *(t - 3 for t in TOES)]]
    apart = np.linalg.norm(feet[:, [0, 2], None] - feet[:, None, [1, 3]], axis=-1)
    assert apart.min() > 0.06


@pytest.mark.parametrize("first", range(0, 30, 3))
def test_a_turn_leads_into_any_moment_of_a_step(first: int) -> None:
    """Also into one in which a foot has just left the floor, or is about to land."""
    walk = walker(seconds=3.6)
    cycle = out_and_back(
        dataclasses.replace(
            walk,
            root_translation=walk.root_translation[first:],
            joint_rotations=walk.joint_rotations[first:],
        )
    )
    excess_m, excess_rad = seam_step(cycle)
    assert excess_m < 0.02
    assert excess_rad < np.deg2rad(5.0)
    assert_no_slides(cycle, 0.01)
    positions = ring(cycle)
    assert positions[:, TOES, 1].min() > 0.0
    speeds = np.linalg.norm(np.diff(positions, axis=0), axis=-1) * cycle.fps
    own = np.linalg.norm(np.diff(walk.joint_positions(), axis=0), axis=-1) * walk.fps
    assert speeds.max() < 1.2 * own.max()
    bend = quaternion_rotate(cycle.joint_rotations[:, KNEES], [0.0, -1.0, 0.0])
    assert np.rad2deg(np.arcsin(np.abs(bend[..., 0]))).max() < 12.0
    foot = quaternion_rotate(cycle.joint_rotations[:, ANKLES], [0.0, 0.0, 1.0])
    assert np.rad2deg(np.arccos(foot[..., 2])).max() < 70.0


def test_a_cut_walk_gives_the_whole_one_back() -> None:
    motion = walker(seconds=4.0, speed=1.2)
    cycle = make_cyclic(motion, max_travel_m=2.0)
    used = cycle.provenance["loop"]["used_frames"]
    assert 1.4 <= used * 1.2 / 30.0 <= 2.05
    assert f"first {used} of 120 frames, out and back" in cycle.source
    # The turn overshoots, and the way back is beside the way out, by less than half a metre each.
    assert np.ptp(cycle.root_translation[:, [0, 2]], axis=0).max() < 2.5
    assert_same(cycle.original(), motion)


def test_who_ends_near_the_beginning_but_in_mid_walk_walks_home() -> None:
    """A blended seam would drag a swinging foot along."""
    motion = walker(seconds=5.0)
    turn = np.linspace(0.0, 1.9 * np.pi, motion.num_frames)
    circle = np.stack([1.0 - np.cos(turn), np.ones_like(turn), np.sin(turn)], axis=1)
    local = motion.joint_rotations.copy()
    local[:, 0] = yaw_quaternion(turn)
    root = 0.8 * circle * [1.0, 0.0, 1.0] + motion.root_translation * [0.0, 1.0, 0.0]
    cycle = make_cyclic(dataclasses.replace(motion, root_translation=root, joint_rotations=local))
    assert cycle.provenance["loop"]["kind"] == "walked_home"
    assert "walked home in" in cycle.source
    assert seam_step(cycle)[0] < 0.02


def test_closing_twice_is_undone_by_one_step_back_each() -> None:
    motion = swayer()
    assert motion.original() is motion
    once = close_loop(motion)
    assert_same(once.original().original(), motion)


def test_what_shards_hold_is_undone_to_what_shards_would_hold() -> None:
    motion = walker(seconds=2.0)
    assert_same(make_cyclic(motion).rounded().original(), motion.rounded())


def test_a_motion_too_short_to_close_is_named() -> None:
    short = cut(swayer(), 2)
    with pytest.raises(ValueError, match=r"motion 'swayer': a cycle needs 3 frames or more, got 2"):
        close_loop(short)
    with pytest.raises(ValueError, match=r"motion 'walker': a cycle needs 3 frames or more, got 2"):
        out_and_back(cut(walker(), 2))


def test_the_very_shortest_motions_close() -> None:
    for count in (3, 4, 7):
        assert close_loop(cut(swayer(), count)).num_frames <= count
        assert np.isfinite(out_and_back(cut(walker(), count)).root_translation).all()


@pytest.mark.realdata
def test_real_cycles_close_within_limits_and_open_again(realdata: Path) -> None:
    for name, source, joints in real_clips(realdata):
        root, rotations = retarget(source, joints)
        root, rotations = resample(root, rotations, fps=source.fps, target_fps=30.0)
        motion = Motion(name, "p", name, "neutral", "real", 30.0, root, rotations)
        cycle = make_cyclic(motion, max_travel_m=3.0)
        excess_m, excess_rad = seam_step(cycle)
        assert excess_m < 0.02, name
        assert excess_rad < np.deg2rad(5.0), name
        assert_same(cycle.original(), motion)
        positions = cycle.joint_positions()
        assert (
            np.abs(
                BODY.forward_kinematics(
                    cycle.rounded().root_translation, cycle.rounded().joint_rotations
                )[0]
                - positions
            ).max()
            < 3e-4
        ), name
