"""Trajectory tables: read strictly, and what they say of a_obs beside the predictions."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from affectsim_data.evaluation import ScoredTable
from affectsim_data.evaluation.tables import (
    Predictions,
    TableProblems,
    read_predictions,
    read_trajectories,
    score_predictions,
    write_predictions,
    write_trajectories,
)
from affectsim_data.motions import EMOTIONS
from affectsim_data.releases import Release
from affectsim_data.schemas import SCHEMAS

FOUND, LOST = "small/4", "small/5"
"""The test split: in the first episode the policy finds the person, in the second it does not."""
START = (0.0, 0.0, -2.5)
Row = dict[str, Any]


def steps_of(episode_id: str, actions: Sequence[str], *, policy: str = "walker") -> list[Row]:
    """Rows of an episode: a step along +Z is 0.25 m, what follows the handoff is phase collect."""
    rows: list[Row] = []
    x, y, z = START
    for step, action in enumerate(actions):
        z += 0.25 * (action == "move_forward")
        handed_off = any(row["action"] == "hand_off" for row in rows)
        rows.append(
            {
                "episode_id": episode_id,
                "policy": policy,
                "step": step,
                "time_s": 0.25 * (step + 1),
                "action": action,
                "position_x_m": x,
                "position_y_m": y,
                "position_z_m": z,
                "yaw_deg": 180.0,
                "clipped": False,
                "phase": "collect" if handed_off else "search",
                "planner_calls": 1 + step // 2,
            }
        )
    return rows


def walks() -> list[Row]:
    found = ["move_forward", "turn_left", "move_forward", "hand_off", "move_forward"]
    return steps_of(FOUND, found) + steps_of(LOST, ["turn_left", "move_forward"])


def put(path: Path, rows: Sequence[Mapping[str, Any]]) -> Path:
    """Writes rows as they are, right or wrong, in the format of the suffix."""
    names = SCHEMAS["trajectories"].names
    if path.suffix == ".parquet":
        pq.write_table(pa.table({name: [row.get(name) for row in rows] for name in names}), path)
    elif path.suffix == ".csv":
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(names)
            writer.writerows([row.get(name) for name in names] for row in rows)
    else:
        path.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")
    return path


def refused(path: Path) -> str:
    with pytest.raises(TableProblems) as caught:
        read_trajectories([path])
    return str(caught.value)


KINDS: list[tuple[Row, str]] = [
    ({"action": "jump"}, r"action is unknown.*row 3.*move_forward, turn_left.*got 'jump'"),
    ({"phase": "rest"}, r"phase is unknown.*row 3.*search, approach, collect, got 'rest'"),
    ({"step": 1}, r"steps there twice.*row 3.*'small/4'.*next step after step 1, got step 1"),
    ({"step": 9}, r"steps with a gap.*row 3.*'small/4'.*after step 4, got step 9"),
    ({"step": -1}, r"step is out of range.*row 3.*finite number from 0, got -1"),
    ({"step": 1.5}, r"step of the wrong kind.*row 3.*whole number of 32 bits, got"),
    ({"time_s": 0.5}, r"time_s does not grow.*row 3.*a later time after step 1, got 0.5 after 0.5"),
    ({"planner_calls": 0}, r"planner_calls becomes fewer.*row 3.*after step 1, got 0 after 1"),
    ({"clipped": "perhaps"}, r"clipped of the wrong kind.*row 3.*true or false, got 'perhaps'"),
    ({"position_z_m": None}, r"position_z_m is missing.*row 3"),
    ({"policy": ""}, r"policy is missing.*row 3"),
]


@pytest.mark.parametrize("suffix", ["csv", "jsonl"])
@pytest.mark.parametrize(("changes", "message"), KINDS, ids=lambda value: str(value)[:30])
def test_a_bad_row_is_named(suffix: str, changes: Row, message: str, tmp_path: Path) -> None:
    rows = walks()
    rows[2] |= changes
    text = refused(put(tmp_path / f"walks.{suffix}", rows))
    assert re.search(message, text, re.DOTALL), text
    line = " (line 4)" if suffix == "csv" else ""
    assert f"walks.{suffix}, row 3{line}: " in text


def test_what_is_not_finite_is_refused(tmp_path: Path) -> None:
    rows = walks()
    rows[2]["yaw_deg"] = np.inf
    rows[3]["time_s"] = np.nan
    text = refused(put(tmp_path / "a.parquet", rows))
    assert re.search(r"yaw_deg is out of range: 1\n  \S+, row 3: .*finite number, got inf", text)
    assert re.search(r"time_s is out of range: 1\n  \S+, row 4: .*got nan", text)


def test_an_episode_begins_with_step_0(tmp_path: Path) -> None:
    text = refused(put(tmp_path / "a.csv", walks()[1:]))
    assert "episode 'small/4': expected the next step after the start, got step 1" in text


def test_columns_that_are_missing_are_named(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    path.write_text(json.dumps({"episode_id": "x", "policy": "y", "position": [1, 2, 3]}))
    assert "columns are missing: step, time_s, action, position_x_m, position_y_m" in refused(path)


@pytest.mark.parametrize("suffix", ["parquet", "csv", "jsonl"])
def test_every_format_reads_back_what_was_written(suffix: str, tmp_path: Path) -> None:
    expected = pa.Table.from_pylist(walks(), schema=SCHEMAS["trajectories"])
    path = tmp_path / f"a.{suffix}"
    assert write_trajectories(walks(), path) == 7
    assert read_trajectories([path]).table.equals(expected)


def predicted(tmp_path: Path, labels: Mapping[tuple[str, str], str], **more: str) -> Predictions:
    """Predictions of one model, by condition and episode; `more` are hashes by condition."""
    rows = [
        {
            "episode_id": one,
            "condition": condition,
            "model": "alpha",
            "label": label,
            "frames_sha256": more.get(condition),
        }
        for (condition, one), label in labels.items()
    ]
    write_predictions(rows, tmp_path / "predictions.csv")
    return read_predictions([tmp_path / "predictions.csv"])


def scored(
    tmp_path: Path,
    small: Release,
    labels: Mapping[tuple[str, str], str],
    rows: Sequence[Row],
    *,
    policy: str | None = None,
    allow_missing: bool = False,
    **hashes: str,
) -> ScoredTable:
    return score_predictions(
        predicted(tmp_path, labels, **hashes),
        small,
        split="test",
        trajectories=read_trajectories([put(tmp_path / "walks.parquet", rows)]),
        policy=policy,
        allow_missing=allow_missing,
    )


ALL = {
    ("p_init", FOUND): "sad",
    ("p_init", LOST): "sad",
    ("a_obs", FOUND): "happy",
    ("a_obs", LOST): "sad",
}


def test_acquisitions_stand_beside_the_answers(small: Release, tmp_path: Path) -> None:
    table = scored(tmp_path, small, ALL, walks())
    acquired = table.acquisitions
    assert acquired is not None
    assert acquired.policy == "walker"
    assert acquired.path_length_m.tolist() == [0.75, 0.25]
    assert acquired.path_before_handoff_m.tolist() == [0.5, 0.25]
    assert acquired.acquired.tolist() == [True, False]
    assert acquired.num_steps.tolist() == [5, 2]
    assert table.same_frames.tolist() == [[True, True], [False, True]]
    assert table.notes == ()


def test_rows_may_come_in_any_order(small: Release, tmp_path: Path) -> None:
    straight = scored(tmp_path, small, ALL, walks()).acquisitions
    rows = walks()
    mixed = [rows[place] for place in np.random.default_rng(5).permutation(len(rows))]
    shuffled = scored(tmp_path, small, ALL, mixed).acquisitions
    assert repr(straight) == repr(shuffled)


def test_without_an_observation_a_obs_falls_back_to_p_init(small: Release, tmp_path: Path) -> None:
    labels = {key: label for key, label in ALL.items() if key != ("a_obs", LOST)}
    table = scored(tmp_path, small, labels, walks())
    assert table.answers[0].tolist() == [[4, 4], [2, 4]]
    assert EMOTIONS[4] == "sad"
    assert len(table.notes) == 1
    assert table.notes[0].startswith("1 of 2 answers under a_obs are those under p_init")
    labels = {key: label for key, label in ALL.items() if key != ("a_obs", FOUND)}
    with pytest.raises(TableProblems, match=r"condition 'a_obs': 1 of 2 episodes .*'small/4'"):
        scored(tmp_path, small, labels, walks())


def test_an_answer_that_changes_for_equal_frames_is_noted(small: Release, tmp_path: Path) -> None:
    table = scored(tmp_path, small, {**ALL, ("a_obs", LOST): "angry"}, walks())
    assert "1 of 1 answers under a_obs to the very frames of p_init differ" in table.notes[0]
    assert "'alpha' 1" in table.notes[0]


def test_other_frames_without_an_observation_are_a_contradiction(
    small: Release, tmp_path: Path
) -> None:
    with pytest.raises(TableProblems, match=r"row 4 \(line 5\): 'walker' acquired nothing"):
        scored(tmp_path, small, ALL, walks(), p_init="1", a_obs="2")
    table = scored(tmp_path, small, ALL, walks(), p_init="1", a_obs="1")
    assert table.same_frames.all()
    assert "1 of 1 clips collected after a handoff show the very frames" in table.notes[1]


def test_missing_trajectories_are_refused_or_count_as_standing_still(
    small: Release, tmp_path: Path
) -> None:
    rows = steps_of(LOST, ["move_forward"])
    with pytest.raises(TableProblems, match="1 of 2 episodes have no trajectory: 'small/4'"):
        scored(tmp_path, small, ALL, rows)
    table = scored(tmp_path, small, ALL, rows, allow_missing=True)
    assert table.acquisitions is not None
    assert table.acquisitions.path_length_m.tolist() == [0.0, 0.25]
    assert "they count as no handoff and no way" in table.notes[0]


def test_trajectories_of_other_episodes_are_named_once_each(small: Release, tmp_path: Path) -> None:
    rows = [*walks(), *steps_of("small/0", ["stop"] * 3), *steps_of("nowhere", ["stop"] * 2)]
    with pytest.raises(TableProblems) as caught:
        scored(tmp_path, small, ALL, rows)
    text = str(caught.value)
    assert "trajectories of another place: 2\n" in text
    assert "walks.parquet, row 8: 'small/0' is of split 'train', not of split 'test'" in text
    assert "walks.parquet, row 11: 'nowhere' is not in small" in text


def test_one_policy_is_evaluated_at_a_time(small: Release, tmp_path: Path) -> None:
    rows = (
        walks() + steps_of(FOUND, ["stop"], policy="idle") + steps_of(LOST, ["stop"], policy="idle")
    )
    with pytest.raises(ValueError, match="of several policies: 'walker', 'idle'; name one"):
        scored(tmp_path, small, ALL, rows)
    with pytest.raises(ValueError, match="policy: got 'runner'; the trajectories are of 'walker'"):
        scored(tmp_path, small, ALL, rows, policy="runner")
    idle = scored(tmp_path, small, ALL, rows, policy="idle").acquisitions
    assert idle is not None
    assert idle.num_steps.tolist() == [1, 1]
    assert not idle.acquired.any()
    with pytest.raises(ValueError, match="policy 'idle' is named, but no trajectories"):
        score_predictions(predicted(tmp_path, ALL), small, split="test", policy="idle")
