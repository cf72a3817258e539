"""The episode: its row and back without loss, and what is refused."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_release import (
    box_room,
    front_view,
    limb_avatar,
    make_episode,
    small_episodes,
    sway_motion,
    world_of,
)

from affectsim_data.episodes import Episode, Participant, clip_time_s
from affectsim_data.poses import matrix_quaternion
from affectsim_data.schemas import SCHEMAS, array_columns

PARTNER = Participant("circle_angry", "p2", "plain", (1.0, 0.0, 2.0), -3.0)
angles = st.floats(-math.pi, math.pi)
lengths = st.floats(-50.0, 50.0)
points = st.tuples(lengths, lengths, lengths)
stars = st.one_of(st.floats(0.0, 99.0), st.sampled_from(["empty", "unreachable"]))


def episodes() -> st.SearchStrategy[Episode]:
    """Episodes with and without a partner, everywhere and every way round."""
    people = st.builds(
        Participant, st.just("m"), st.just("p"), st.just("a"), anchor=points, facing=angles
    )
    knots = Episode.from_row(make_episode().to_row()).reference.knots
    views = st.builds(lambda azimuth: dataclasses.replace(front_view(), azimuth=azimuth), angles)
    assert len(knots) == 10
    return st.builds(
        make_episode,
        target=people,
        partner=st.none() | people,
        start_position=points,
        start_yaw=angles,
        monitor_yaw=angles,
        monitor_pitch=angles,
        initial_bearing=angles,
        phase_s=st.floats(0.0, 1.999),
        d_star=st.fixed_dictionaries({1: stars, 3: stars, 5: stars}),
        reference=views,
    )


def test_a_row_has_exactly_the_columns_of_the_contract() -> None:
    assert sorted(make_episode().to_row()) == sorted(SCHEMAS["episodes"].names)
    assert sorted(make_episode(partner=PARTNER).to_row()) == sorted(SCHEMAS["episodes"].names)


@given(episodes())
def test_a_row_read_and_written_again_is_the_same_row(episode: Episode) -> None:
    row = episode.to_row()
    assert Episode.from_row(row).to_row() == row


@given(st.integers(0, 1000))
def test_reference_knots_survive_to_the_last_bit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    knots = rng.normal(size=(8, 7))
    knots[:, 3:] /= np.linalg.norm(knots[:, 3:], axis=1, keepdims=True)
    reference = dataclasses.replace(front_view(), knots=knots)
    row = make_episode(reference=reference).to_row()
    assert Episode.from_row(row).to_row()["reference_trajectory"] == row["reference_trajectory"]


def test_fields_survive_their_row() -> None:
    before = make_episode(partner=PARTNER, family="dyadic", challenge=None, target_index=1)
    after = Episode.from_row(before.to_row())
    for field in dataclasses.fields(Episode):
        a, b = getattr(after, field.name), getattr(before, field.name)
        if isinstance(b, float):
            assert a == pytest.approx(b, abs=1e-10), field.name
        elif field.name not in ("reference", "target", "partner"):
            assert a == b, field.name
    assert after.partner is not None
    assert after.partner.facing == pytest.approx(-3.0)
    assert dataclasses.replace(after.partner, facing=-3.0) == PARTNER
    np.testing.assert_array_equal(after.reference.knots, before.reference.knots)
    assert after.reference.parts == before.reference.parts


def test_rows_survive_parquet(tmp_path: Path) -> None:
    rows = [episode.to_row() for episode in small_episodes()]
    table = pa.Table.from_pylist(rows, schema=SCHEMAS["episodes"])
    pq.write_table(table, tmp_path / "e.parquet")
    assert pq.read_table(tmp_path / "e.parquet").to_pylist() == rows
    assert pq.read_schema(tmp_path / "e.parquet").field("phase_s").metadata[b"description"]


def test_derived_values_by_hand() -> None:
    episode = make_episode(start_position=(3.0, 0.0, 4.0))
    assert episode.initial_distance_m == 5.0
    assert episode.label == 2
    assert [person.motion_id for person in episode.participants] == ["sway_happy"]
    dyad = make_episode(partner=PARTNER)
    assert [p.motion_id for p in dyad.participants] == ["sway_happy", "circle_angry"]


def test_the_performance_frame_stands_at_the_anchor_and_looks_along_its_facing() -> None:
    person = Participant("m", "p", "a", (1.0, 0.5, 2.0), math.pi / 2.0)
    T = person.T_world_performance
    np.testing.assert_allclose(T @ [0.0, 0.0, 1.0, 1.0], [2.0, 0.5, 2.0, 1.0], atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"split": "dev"}, r"split must be one of \('train', 'validation', 'test'\), got 'dev'"),
        ({"family": "solo"}, "family must be one of .*'dyadic'.* got 'solo'"),
        ({"challenge": "dark"}, "challenge must be one of .*'rear_view'.* got 'dark'"),
        ({"emotion": "joy"}, "emotion must be one of .*'happy'.* got 'joy'"),
        ({"phase_s": 2.0}, r"phase_s must be in \[0, 2\), got 2"),
        ({"phase_s": -0.1}, r"phase_s must be in \[0, 2\), got -0\.1"),
        ({"phase_s": math.nan}, r"phase_s must be in \[0, 2\), got nan"),
        ({"duration_s": 0.0}, r"phase_s must be in \[0, 0\), got 0\.5"),
        ({"d_star": {1: 1.0, 3: 1.0}}, "d_star at 5 m must be a length or one of .* got None"),
        ({"d_star": {1: "far", 3: 1.0, 5: 1.0}}, "d_star at 1 m must be .*'empty'.* got 'far'"),
        ({"d_star": {1: -1.0, 3: 1.0, 5: 1.0}}, "d_star at 1 m must be a length .* got -1.0"),
    ],
)
def test_bad_episodes_are_refused_by_name(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=f"episode 'small/0': {message}"):
        make_episode(**changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"phase_s": 7.0}, r"phase_s must be in \[0, 2\), got 7"),
        ({"phase_s": None}, "columns may not be missing or null: phase_s"),
        ({"anchor_y_m": math.nan}, "columns must be finite: anchor_y_m"),
        ({"partner_avatar_id": "plain"}, "of a partner's columns these are null: .*motion_id"),
        ({"d_star_3m": None}, "d_star at 3 m must be a length or one of"),
        (
            array_columns("reference_trajectory", np.zeros((3, 6), np.float32)),
            r"reference_trajectory must be \(n, 7\), got \(3, 6\)",
        ),
        (
            array_columns("reference_trajectory", np.zeros((0, 7), np.float32)),
            r"reference_trajectory must be \(n, 7\), got \(0, 7\)",
        ),
        (
            array_columns("reference_trajectory", np.zeros((3, 7), np.float32)),
            "reference_trajectory must hold finite unit quaternions",
        ),
        (
            array_columns("reference_trajectory", np.full((3, 7), np.nan, np.float32)),
            "reference_trajectory must hold finite unit quaternions",
        ),
        ({"reference_trajectory": b"1234"}, "reference_trajectory with shape .* got 4"),
    ],
)
def test_bad_rows_are_refused_by_name(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=f"episode 'small/0': {message}"):
        Episode.from_row({**make_episode().to_row(), **changes})


def test_a_row_without_a_column_is_refused() -> None:
    row = make_episode().to_row()
    del row["start_x_m"]
    with pytest.raises(ValueError, match="columns may not be missing or null: start_x_m"):
        Episode.from_row(row)


def test_clips_cover_two_cycles_from_the_phase() -> None:
    time_s = clip_time_s(make_episode(phase_s=0.5, duration_s=2.0))
    assert len(time_s) == 120
    assert time_s[0] == 0.5
    np.testing.assert_allclose(np.diff(time_s), 1.0 / 30.0)
    np.testing.assert_allclose(time_s[-1], 4.5 - 1.0 / 30.0)


def test_clips_of_the_shortest_cycle_have_a_frame() -> None:
    assert len(clip_time_s(make_episode(phase_s=0.0, duration_s=0.002))) == 1


def test_people_are_placed_by_their_participant() -> None:
    motion, avatar = sway_motion("s", "sad"), limb_avatar("tall", scale=1.1)
    world = world_of(box_room("r"), [(motion, avatar, (1.0, 0.0, 2.0), math.pi / 2.0)])
    frames = world.target.joint_frames([0.0])[0]
    # Stored translations are multiples of 2^-16 m.
    np.testing.assert_allclose(frames[0, :3, 3], [1.0, 0.95 * 1.1, 2.0], atol=1e-5)
    np.testing.assert_allclose(frames[0, :3, 2], [1.0, 0.0, 0.0], atol=1e-6)
    assert matrix_quaternion(frames[0, :3, :3]) == pytest.approx(
        [math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0], abs=1e-6
    )


def test_joint_matrices_carry_the_rest_pose_onto_the_joints() -> None:
    motion, avatar = sway_motion("s", "sad"), limb_avatar("plain")
    world = world_of(box_room("r"), [(motion, avatar, (1.0, 0.0, 2.0), 0.7)])
    time_s = [0.0, 0.4]
    rest = np.c_[avatar.skeleton.rest_positions, np.ones(22)]
    carried = np.einsum("njab,jb->nja", world.target.joint_matrices(time_s), rest)
    expected = world.target.joint_frames(time_s)[..., 3]
    np.testing.assert_allclose(carried, expected, atol=1e-9)
