"""Prediction tables: read strictly, joined with a release, written and read back."""

from __future__ import annotations

import csv
import json
import os
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_release import small_rows, write_release

from affectsim_data.evaluation import ScoredTable
from affectsim_data.evaluation.scored import outcome_code
from affectsim_data.evaluation.tables import (
    TableProblems,
    read_predictions,
    read_trajectories,
    score_predictions,
    write_predictions,
)
from affectsim_data.evaluation.tables.files import MAX_TEXT_BYTES
from affectsim_data.motions import EMOTIONS
from affectsim_data.releases import Release, open_release
from affectsim_data.schemas import SCHEMAS

IDS = ("small/4", "small/5")
"""Episodes of the test split: happy, and sad with a partner."""
Row = dict[str, Any]
FORMATS = ("parquet", "csv", "jsonl")


def rows_of(
    models: Sequence[str] = ("alpha", "beta"),
    conditions: Sequence[str] = ("p_ref", "p_init"),
    ids: Sequence[str] = IDS,
) -> list[Row]:
    """A prediction for everything: `happy`."""
    return [
        {"episode_id": one, "condition": condition, "model": model, "label": "happy"}
        for model in models
        for condition in conditions
        for one in ids
    ]


def put(path: Path, rows: Sequence[Mapping[str, Any]]) -> Path:
    """Writes rows as they are, right or wrong, in the format of the suffix."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    if path.suffix == ".parquet":
        columns = {name: [row.get(name) for row in rows] for name in names}
        pq.write_table(pa.table(columns), path)
    elif path.suffix == ".csv":
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(names)
            writer.writerows([row.get(name) for name in names] for row in rows)
    else:
        path.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")
    return path


def changed(number: int, **changes: Any) -> list[Row]:
    """The rows with one of them changed, counted from 1."""
    rows = rows_of()
    rows[number - 1] = {**rows[number - 1], **changes}
    return rows


def refused(*paths: Path) -> str:
    with pytest.raises(TableProblems) as caught:
        read_predictions(paths)
    return str(caught.value)


@pytest.fixture(scope="module")
def grounded(tmp_path_factory: pytest.TempPathFactory) -> Release:
    """A release with two performances of one performer, three episodes, in its test split."""
    tables = small_rows()
    template = tables["episodes"][4]
    motions = ("sway_happy", "sway_sad", "sway_happy")
    tables["episodes"] = [
        {
            **template,
            "episode_id": f"grounded/{number}",
            "family": "action_grounded",
            "challenge": None,
            "motion_id": motion_id,
            "emotion": motion_id.removeprefix("sway_"),
            "group_id": "p0",
        }
        for number, motion_id in enumerate(motions)
    ]
    for row, why in zip(tables["episodes"][1:], ("empty", "unreachable"), strict=True):
        row |= {"d_star_5m": None, "d_star_5m_null": why}
    out = tmp_path_factory.mktemp("releases") / "grounded"
    write_release(out, rows=tables, splits=("test",))
    return open_release(out)


def test_answers_stand_beside_the_truth(small: Release, tmp_path: Path) -> None:
    rows = changed(2, label="sad", latency_ms=12.5)
    table = score_predictions(
        read_predictions([put(tmp_path / "a.parquet", rows)]), small, split="test"
    )
    assert table.models == ("alpha", "beta")
    assert table.conditions == ("p_ref", "p_init")
    assert table.episode_ids.tolist() == list(IDS)
    happy, sad = EMOTIONS.index("happy"), EMOTIONS.index("sad")
    assert table.truth.tolist() == [happy, sad]
    assert table.answers.tolist() == [
        [[happy, sad], [happy, happy]],
        [[happy, happy], [happy, happy]],
    ]
    assert table.latency_ms[0, 0, 1] == 12.5
    assert np.isnan(table.latency_ms).sum() == 7
    assert table.was_run.all()
    assert table.release.startswith("small@")
    assert table.same_frames.tolist() == [[False, False], [True, True]]
    assert table.notes == ()
    assert table.factors["challenge"].tolist() == ["rear_view", ""]


def test_rings_are_those_of_the_release(grounded: Release, tmp_path: Path) -> None:
    path = put(tmp_path / "a.csv", rows_of(ids=[f"grounded/{number}" for number in range(3)]))
    table = score_predictions(read_predictions([path]), grounded, split="test")
    near, far = table.d_star_m[0], table.d_star_m[2]
    assert near.tolist() == grounded.episode_table("test").column("d_star_1m").to_pylist()
    assert np.isnan(far).tolist() == [False, True, True]
    assert table.ring_empty.tolist() == [[False] * 3, [False] * 3, [False, True, False]]


def test_performances_are_motions_of_a_performer(grounded: Release, tmp_path: Path) -> None:
    ids = [f"grounded/{number}" for number in range(3)]
    path = put(tmp_path / "a.csv", rows_of(ids=ids))
    table = score_predictions(read_predictions([path]), grounded, split="test")
    assert table.performances.tolist() == [0, 1, 0]
    assert table.performers.tolist() == [0, 0, 0]


def test_performances_are_groups_elsewhere(small: Release, tmp_path: Path) -> None:
    table = score_predictions(
        read_predictions([put(tmp_path / "a.csv", rows_of())]), small, split="test"
    )
    # Both have the group group-2, and motions of their own.
    assert table.performances.tolist() == [0, 0]


def test_text_is_parsed_and_a_label_outdoes_it(small: Release, tmp_path: Path) -> None:
    texts = ["The person looks sad.", "", "I cannot tell what people feel.", "happy"]
    rows: list[Row] = [
        {**row, "label": None, "raw_text": text}
        for row, text in zip(rows_of(models=["alpha"]), texts, strict=True)
    ]
    rows[3]["label"] = "angry"
    table = score_predictions(
        read_predictions([put(tmp_path / "a.parquet", rows)]), small, split="test"
    )
    expected = [EMOTIONS.index("sad"), outcome_code("empty"), outcome_code("refusal"), 0]
    assert table.answers.ravel().tolist() == expected
    assert any("different emotions in 1 of the 1 rows" in note for note in table.notes)


KINDS: list[tuple[Row, str]] = [
    ({"label": "Happy"}, r"label is none.*row 3.*got 'Happy'; write 'happy'"),
    ({"label": "joyful"}, r"label is none.*row 3.*got 'joyful'.*put free text into raw_text"),
    ({"label": None}, r"neither label nor raw_text.*row 3.*raw_text is the empty text"),
    ({"condition": "pinit"}, r"condition is misspelt.*row 3.*'pinit'; did you mean p_init\?"),
    ({"condition": "P-Ref"}, r"condition is misspelt.*row 3.*'P-Ref'; did you mean p_ref\?"),
    ({"condition": "p_int"}, r"condition is misspelt.*row 3.*did you mean p_init\? A condition"),
    ({"condition": " p_init"}, r"condition with white space around it.*row 3.*' p_init'"),
    ({"condition": None}, r"condition is missing.*row 3.*expected a value"),
    ({"model": None}, r"model is missing.*row 3"),
    ({"episode_id": None}, r"episode_id is missing.*row 3"),
    ({"latency_ms": -1.0}, r"latency_ms is no time.*row 3.*from 0, or nothing, got -1"),
    ({"latency_ms": "fast"}, r"latency_ms of the wrong kind.*row 3.*a number, got 'fast'"),
    ({"scores": "[1, 2, 3]"}, r"scores are not five numbers.*row 3.*got \[1.0, 2.0, 3.0\]"),
    ({"scores": "[1, 2, 3, 4, null]"}, r"scores are not five numbers.*row 3.*None\]"),
    ({"scores": "high"}, r"scores of the wrong kind.*row 3.*as JSON.*got 'high'"),
    ({"raw_text": "x" * (MAX_TEXT_BYTES + 1)}, r"raw_text is too long.*row 3.*1,000,001"),
    (
        {"condition": "p_ref", "model": "alpha"},
        r"rows there twice.*row 3.*'small/4', condition 'p_ref', model 'alpha' is already in .*"
        r"row 1",
    ),
]


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize(("changes", "message"), KINDS, ids=lambda value: str(value)[:30])
def test_a_bad_row_is_named(suffix: str, changes: Row, message: str, tmp_path: Path) -> None:
    rows = changed(3, **changes)
    text = refused(put(tmp_path / f"answers.{suffix}", rows))
    assert re.search(message, text, re.DOTALL), text
    line = " (line 4)" if suffix == "csv" else ""
    assert f"answers.{suffix}, row 3{line}: " in text
    assert text.startswith("1 problem in the predictions; nothing is scored")


def test_what_is_not_finite_is_refused(tmp_path: Path) -> None:
    rows = changed(2, latency_ms=np.nan)
    rows[4]["scores"] = [0.0, np.inf, 0.0, 0.0, 0.0]
    text = refused(put(tmp_path / "a.parquet", rows))
    assert re.search(r"latency_ms is no time: 1\n  \S+, row 2: .*got nan", text)
    assert re.search(r"scores are not five numbers: 1\n  \S+, row 5: .*got \[0.0, inf, 0.0", text)
    text = refused(put(tmp_path / "a.jsonl", rows))
    assert re.search(r"row 2: NaN is no JSON; expected a number or null", text)
    assert re.search(r"row 5: Infinity is no JSON", text)
    rows[4]["scores"] = "[0, 1e999, 0, 0, 0]"
    text = refused(put(tmp_path / "a.csv", rows))
    assert re.search(r"row 2 \(line 3\): .*got nan", text)
    assert re.search(r"row 5 \(line 6\): .*got \[0.0, inf", text)


def test_problems_of_all_files_come_at_once_and_not_without_end(tmp_path: Path) -> None:
    many = [{**row, "label": "Anger"} for row in rows_of(ids=[f"e/{n}" for n in range(10)])]
    first = put(tmp_path / "first.csv", many)
    second = put(tmp_path / "second.jsonl", [{**rows_of()[0], "model": ""}])
    third = tmp_path / "third.parquet"
    third.write_bytes(b"PAR1 but no table")
    text = refused(first, second, third, tmp_path / "fourth.csv", tmp_path / "fifth.xlsx")
    assert "label is none of the five emotions: 40\n" in text
    assert text.count("'Anger'") == 20
    assert "  ... and 20 more" in text
    assert "second.jsonl, row 1: expected a value" in text
    assert "third.parquet: cannot be read as Parquet" in text
    assert "fourth.csv: No such file" in text
    assert "fifth.xlsx: must end with .parquet, .csv or .jsonl" in text


def test_rows_that_cannot_be_read_are_named_and_the_others_keep_their_numbers(
    tmp_path: Path,
) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(
        b"\xef\xbb\xbfepisode_id,condition,model,raw_text\r\n"
        b'small/4,p_init,a,"two\r\nlines"\r\n'
        b"small/5,p_init,a\r\n"
        b"\r\n"
        b"small/4,p_ref,a,sad,sad\r\n"
        b"small/5,p_reff,a,sad"
    )
    text = refused(path)
    assert "a.csv, row 2 (line 4): expected 4 cells as in line 1, got 3" in text
    assert "a.csv, row 3 (line 6): expected 4 cells as in line 1, got 5" in text
    assert "a.csv, row 4 (line 7): got 'p_reff'" not in text  # p_ref and more: a name of one's own
    path = tmp_path / "a.jsonl"
    good = '{"episode_id": "small/4", "condition": "p_init", "model": "a", "label": "%s"}\n'
    path.write_text(
        "\n" + good % "sad" + '{"model": 1, "model": 2}\n' + "[1]\n" + "{'a': 1}\n" + "[" * 99999
    )
    text = refused(path)
    assert "a.jsonl, row 2 (line 3): keys are there twice: 'model'" in text
    assert "a.jsonl, row 3 (line 4): expected a JSON object" in text
    assert "a.jsonl, row 4 (line 5): is no JSON: Expecting property name" in text
    assert "a.jsonl, row 5 (line 6): is nested too deeply" in text


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b"episode_id,condition,label\nx,p_init,sad\n", "columns are missing: model; there are"),
        (b"episode_id,condition,model\n", "columns are missing: raw_text or label"),
        (b"episode_id;condition;model;label\n", "cells are parted by commas"),
        (b"episode,condition,model,label\n", "'episode' may be episode_id"),
        (b"episode_id,condition,model,label,label\n", "columns are there twice: label"),
        (b"episode_id,condition,model,label,frames_sha,frames_sha256\n", "twice: frames_sha256"),
        (b"episode_id,condition,model,label\n", "holds columns and no row"),
        (b'episode_id,condition,model,raw_text\na,p_init,m,"sad\nb,p_init,m,sad\n', "never closed"),
        ("episode_id,condition,model,label\n".encode("utf-16"), "is in UTF-16"),
        (
            # pyarrow passes over a row that is too short and no UTF-8 besides.
            b"episode_id,condition,model,raw_text\na,p_init,m,sad\nb,p_init,caf\xe9\n",
            "line 3 is no text in UTF-8: ... ",
        ),
        (b"episode_id,condition,model,raw_text\na,p_init,m,\xe2\x82", "line 2 is no text in UTF-8"),
    ],
)
def test_a_bad_file_is_named(content: bytes, message: str, tmp_path: Path) -> None:
    path = tmp_path / "a.CSV"
    path.write_bytes(content)
    text = refused(path)
    assert f"{path}: " in text
    assert message in text


def test_rows_of_large_files_keep_their_numbers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("affectsim_data.evaluation.tables.csv_files._MAX_ROW_BYTES", 200)
    path = put(tmp_path / "a.csv", rows_of(ids=[f"e/{number}" for number in range(100)]))
    lines = path.read_bytes().splitlines(keepends=True)
    lines[123] = b"e/0,p_init\r\n"
    lines[321] = lines[321].replace(b"happy", b"jolly")
    path.write_bytes(b"".join(lines))
    text = refused(path)
    assert "row 123 (line 124): expected 4 cells as in line 1, got 2" in text
    assert "row 321 (line 322): got 'jolly'" in text
    path.write_bytes(lines[0] + b"a" * 500 + lines[1])
    assert "cannot be read as CSV: " in refused(path)


def test_columns_of_a_wrong_kind_are_named(tmp_path: Path) -> None:
    path = put(tmp_path / "a.parquet", [{**row, "label": 3, "scores": 0.5} for row in rows_of()])
    text = refused(path)
    assert "label must be text, got int64; scores must be lists of numbers, got double" in text


def test_a_file_given_twice_is_refused(tmp_path: Path) -> None:
    path = put(tmp_path / "a.csv", rows_of())
    assert "a.csv: the same as" in refused(path, tmp_path / "." / "a.csv")
    with pytest.raises(ValueError, match="no file of predictions is given"):
        read_predictions([])


def test_a_small_file_may_not_unfold_without_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = [{**row, "raw_text": "x" * 1000} for row in rows_of(ids=[f"e/{n}" for n in range(50)])]
    path = put(tmp_path / "a.parquet", rows)
    assert path.stat().st_size < 20_000
    monkeypatch.setattr("affectsim_data.evaluation.tables.parquet_files.MAX_FILE_BYTES", 100_000)
    assert "raw_text unfolds to 200,000 bytes; at most 100,000" in refused(path)
    monkeypatch.setattr("affectsim_data.evaluation.tables.parquet_files.MAX_ROWS", 100)
    assert "a file has at most 100 rows, got 200" in refused(path)
    monkeypatch.setattr("affectsim_data.evaluation.tables.jsonl_files._MAX_LINE_BYTES", 1_000)
    objects = put(tmp_path / "a.jsonl", rows[:1])
    assert "a.jsonl, row 1: a line has at most 1,000 bytes, got 1," in refused(objects)
    monkeypatch.setattr("affectsim_data.evaluation.tables.reading.MAX_FILE_BYTES", 1_000)
    assert "a file has at most 1,000 bytes" in refused(path)


def test_kinds_of_columns_that_libraries_write_are_taken(tmp_path: Path) -> None:
    texts = [{name: row[name] for name in ("episode_id", "condition")} for row in rows_of()]
    table = pa.Table.from_pylist(texts)
    count = table.num_rows
    table = table.append_column("model", pa.array(["a"] * 4 + ["b"] * 4).dictionary_encode())
    table = table.append_column("label", pa.array(["sad"] * count, pa.large_string()))
    table = table.append_column("raw_text", pa.nulls(count))
    table = table.append_column("latency_ms", pa.array(range(count), pa.uint8()))
    scores = pa.array([[1.0, 0, 0, 0, 0]] * count, pa.list_(pa.float64(), 5))
    table = table.append_column("scores", scores)
    table = table.append_column("frames_sha", pa.array(["f0"] * count))
    table = table.append_column("prompt", pa.array(["What?"] * count))
    pq.write_table(table, tmp_path / "a.parquet")
    read = read_predictions([tmp_path / "a.parquet"])
    assert read.table.schema.equals(SCHEMAS["predictions"])
    assert read.table.column("latency_ms").to_pylist() == [float(n) for n in range(count)]
    assert read.table.column("frames_sha256").to_pylist() == ["f0"] * count
    assert read.notes == (
        "column 'prompt' of a.parquet is not of the contract and was passed over",
    )


def test_conditions_of_ones_own_come_last(small: Release, tmp_path: Path) -> None:
    conditions = ("front_2m", "a_obs", "p_ref_2m", "p_init", "p_mon")
    path = put(tmp_path / "a.jsonl", rows_of(conditions=conditions))
    table = score_predictions(read_predictions([path]), small, split="test")
    assert table.conditions == ("p_mon", "p_init", "a_obs", "front_2m", "p_ref_2m")


def test_rows_of_other_episodes_are_named(small: Release, tmp_path: Path) -> None:
    rows = changed(3, episode_id="small/77")
    rows[5]["episode_id"] = "small/1"
    predictions = read_predictions([put(tmp_path / "a.csv", rows)])
    with pytest.raises(TableProblems) as caught:
        score_predictions(predictions, small, split="test")
    text = str(caught.value)
    assert "row 3 (line 4): 'small/77' is not in small; they are called like 'small/4'" in text
    assert "row 6 (line 7): 'small/1' is of split 'train', not of split 'test'" in text
    assert "model 'alpha', condition 'p_init': 1 of 2 episodes are missing: 'small/4'" in text
    assert caught.value.counts["episode_id of another place"] == 2


def test_missing_rows_are_refused_or_count_as_wrong(small: Release, tmp_path: Path) -> None:
    predictions = read_predictions([put(tmp_path / "a.csv", rows_of()[:-1])])
    with pytest.raises(TableProblems, match=r"model 'beta', condition 'p_init': 1 of 2 episodes"):
        score_predictions(predictions, small, split="test")
    table = score_predictions(predictions, small, split="test", allow_missing=True)
    assert table.answers[1, 1, 1] == outcome_code("missing")
    assert (table.answers == outcome_code("missing")).sum() == 1
    assert table.notes == (
        "model 'beta', condition 'p_init': 1 of 2 episodes are missing and count as wrong",
    )


def test_a_condition_not_run_for_a_model_is_not_missing(small: Release, tmp_path: Path) -> None:
    rows = rows_of(models=["alpha"]) + rows_of(models=["beta"], conditions=["p_ref"])
    table = score_predictions(
        read_predictions([put(tmp_path / "a.csv", rows)]), small, split="test"
    )
    assert table.was_run.tolist() == [[True, True], [True, False]]
    assert (table.answers[1, 1] == outcome_code("missing")).all()
    assert table.notes == ()


def test_models_can_be_chosen(small: Release, tmp_path: Path) -> None:
    rows = rows_of()
    rows[1]["episode_id"] = "nowhere"  # of alpha, who is not asked for
    predictions = read_predictions([put(tmp_path / "a.csv", rows)])
    table = score_predictions(predictions, small, split="test", models=["beta"])
    assert table.models == ("beta",)
    with pytest.raises(ValueError, match="got 'gamma'; the predictions are of 'alpha', 'beta'"):
        score_predictions(predictions, small, split="test", models=["gamma"])


def test_rows_of_chosen_models_keep_their_names(small: Release, tmp_path: Path) -> None:
    rows = changed(6, episode_id="nowhere")
    paths = [put(tmp_path / "a.csv", rows[:3]), put(tmp_path / "b.csv", rows[3:])]
    with pytest.raises(TableProblems, match=r"b.csv, row 3 \(line 4\): 'nowhere' is not in small"):
        score_predictions(read_predictions(paths), small, split="test", models=["beta"])


def test_episodes_can_be_chosen(small: Release, tmp_path: Path) -> None:
    rows = [row for row in rows_of() if row["episode_id"] == "small/5" or row["model"] == "alpha"]
    predictions = read_predictions([put(tmp_path / "a.csv", rows)])
    dyads = [("family", "==", "dyadic")]
    table = score_predictions(predictions, small, split="test", filter=dyads)
    assert table.episode_ids.tolist() == ["small/5"]
    assert table.notes == ("a filter chose 1 of 2 episodes",)
    with pytest.raises(ValueError, match="matches no episode of split 'test'"):
        score_predictions(predictions, small, split="test", filter=[("family", "==", "group")])


def test_splits_may_be_by_scene(small: Release, tmp_path: Path) -> None:
    ids = [f"small/{number}" for number in range(6)]
    predictions = read_predictions([put(tmp_path / "a.csv", rows_of(ids=ids))])
    table = score_predictions(predictions, small, split="train", split_by="scene")
    assert table.episode_ids.tolist() == ids
    assert table.split == "train by scene"


def test_a_partial_copy_is_not_scored(
    small: Release, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    predictions = read_predictions([put(tmp_path / "a.csv", rows_of())])
    monkeypatch.setattr(small.stored_split("test"), "num_episodes", 9)
    with pytest.raises(ValueError, match="holds 2 of the 9 episodes of split 'test'"):
        score_predictions(predictions, small, split="test")


def hashed(rows: Sequence[Row], hashes: Mapping[tuple[str, str], str]) -> list[Row]:
    """Rows with hashes of frames, by model and condition; the episode is added to them."""
    return [
        {**row, "frames_sha": f"{told}{row['episode_id']}"}
        if (told := hashes.get((row["model"], row["condition"])))
        else row
        for row in rows
    ]


def test_equal_hashes_are_the_same_frames(small: Release, tmp_path: Path) -> None:
    rows = rows_of(conditions=["p_init", "a_obs", "p_ref"])
    rows[2]["label"] = "angry"  # alpha, a_obs, small/4
    hashes = {("alpha", "p_init"): "1", ("alpha", "a_obs"): "1", ("alpha", "p_ref"): "2"}
    path = put(tmp_path / "a.csv", hashed(rows, hashes))
    table = score_predictions(read_predictions([path]), small, split="test")
    assert table.conditions == ("p_ref", "p_init", "a_obs")
    assert table.same_frames.tolist() == [[False] * 2, [True] * 2, [True] * 2]
    assert len(table.notes) == 1
    assert "1 of 4 answers under a_obs to the very frames of p_init differ" in table.notes[0]
    hashes |= {("beta", "p_init"): "1", ("beta", "a_obs"): "3"}
    path = put(tmp_path / "b.csv", hashed(rows, hashes))
    table = score_predictions(read_predictions([path]), small, split="test")
    assert not table.same_frames[2].any()
    assert "models disagree on whether the frames of a_obs" in table.notes[0]


def aligned(table: ScoredTable) -> dict[str, Any]:
    """All of a table, models by name."""
    order = np.argsort(table.models)
    return {
        "models": sorted(table.models),
        "conditions": table.conditions,
        "answers": table.answers[order].tolist(),
        "latency_ms": table.latency_ms[order].tolist(),
        "same_frames": table.same_frames.tolist(),
        "episodes": table.episode_ids.tolist(),
        "notes": table.notes,
    }


@pytest.mark.parametrize("seed", range(3))
def test_the_order_of_rows_and_files_does_not_matter(
    small: Release, tmp_path: Path, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    rows = rows_of(models=["c", "a", "b"], conditions=["p_ref", "mine", "p_init", "a_obs"])
    for row in rows:
        row |= {"label": str(rng.choice(EMOTIONS)), "latency_ms": float(rng.random())}
        row |= {"frames_sha256": str(rng.integers(2))}
    del rows[5]

    def scored(paths: Sequence[Path]) -> ScoredTable:
        return score_predictions(read_predictions(paths), small, split="test", allow_missing=True)

    whole = scored([put(tmp_path / "whole.parquet", rows)])
    mixed = [rows[place] for place in rng.permutation(len(rows))]
    parts = [
        put(tmp_path / "1.csv", mixed[:7]),
        put(tmp_path / "2.jsonl", mixed[7:16]),
        put(tmp_path / "3.parquet", mixed[16:]),
    ]
    mine, other = aligned(whole), aligned(scored(parts))
    assert other.pop("notes") != ()
    assert mine.pop("notes") != ()
    assert repr(mine) == repr(other)


TEXTS = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
ANSWERS = st.fixed_dictionaries(
    {
        "condition": st.sampled_from(["p_init", "p_ref", "mine"]),
        "model": st.sampled_from(["alpha", '=be"ta, 7B', "gämma\n"[:-1]]),
        "raw_text": TEXTS,
        "label": st.none() | st.sampled_from(EMOTIONS),
        "scores": st.none()
        | st.lists(
            st.floats(width=32, allow_nan=False, allow_infinity=False), min_size=5, max_size=5
        ),
        "latency_ms": st.none() | st.floats(0, 1e9),
        "frames_sha256": st.none() | st.just("0f"),
    }
)


@settings(max_examples=25)
@given(st.lists(ANSWERS, min_size=1, max_size=9))
def test_every_format_reads_back_what_was_written(
    tmp_path_factory: pytest.TempPathFactory, answers: list[Row]
) -> None:
    folder = tmp_path_factory.mktemp("tables")
    rows = [{"episode_id": f"e/{number}", **row} for number, row in enumerate(answers)]
    rows.append({"episode_id": "e/null", "condition": "p_ref", "model": "a", "label": "sad"})
    expected = pa.Table.from_pylist(rows, schema=SCHEMAS["predictions"])
    for suffix in FORMATS:
        path = folder / f"a.{suffix}"
        assert write_predictions(rows, path) == len(rows)
        assert read_predictions([path]).table.equals(expected), suffix
        assert write_predictions(read_predictions([path]).table, folder / f"b.{suffix}")
        assert (folder / f"b.{suffix}").read_bytes() == path.read_bytes()


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ({"label": "sad"}, "row 1: predictions need episode_id, condition, model"),
        ({**rows_of()[0], "emotion": "sad"}, "row 1: predictions have no column emotion"),
        ({**rows_of()[0], "model": None}, "row 1: predictions need model, got"),
        ({**rows_of()[0], "latency_ms": "x"}, "not of its column's kind"),
        ({**rows_of()[0], "raw_text": "\ud800"}, "not of its column's kind"),
        ({**rows_of()[0], "latency_ms": np.nan}, "latency_ms must be finite, got nan"),
        ({**rows_of()[0], "scores": [1.0, np.inf]}, "scores must be finite, got inf"),
    ],
)
def test_what_could_not_be_read_is_not_written(row: Row, message: str, tmp_path: Path) -> None:
    path = put(tmp_path / "a.csv", rows_of())
    before = path.read_bytes()
    with pytest.raises(ValueError, match=message):
        write_predictions([row], path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["a.csv"]


def test_a_table_is_written_whole_or_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = put(tmp_path / "a.jsonl", rows_of())
    before = path.read_bytes()

    def failing(_: int) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(os, "fsync", failing)
    with pytest.raises(OSError, match="no space left"):
        write_predictions(rows_of()[:2], path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["a.jsonl"]
    with pytest.raises(ValueError, match=r"must end with .parquet, .csv or .jsonl"):
        write_predictions(rows_of(), tmp_path / "a.txt")


BYTES: list[Callable[[bytes], bytes]] = [
    lambda data: data[: len(data) // 2],
    lambda data: data.replace(b"small", b"\xff\xfe\x00\x00m"),
    lambda data: data[::-1],
]


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("spoil", BYTES, ids=["half", "bytes", "reversed"])
def test_a_spoilt_file_is_refused_not_crashed_on(
    suffix: str, spoil: Callable[[bytes], bytes], tmp_path: Path
) -> None:
    path = put(tmp_path / f"a.{suffix}", rows_of())
    path.write_bytes(spoil(path.read_bytes()))
    assert f"a.{suffix}" in refused(path)


def test_the_tables_in_the_docs_are_read(tmp_path: Path) -> None:
    page = (Path(__file__).parents[1] / "docs" / "prediction_tables.md").read_text()
    blocks = re.findall(r"(?<=\n\n)(?:    .*\n)+", page)
    plain = [re.sub(r"^    ", "", block, flags=re.M) for block in blocks]
    predictions, walks = (block for block in plain if block.startswith("episode_id,"))
    (objects,) = (block for block in plain if block.startswith("{"))
    for name, text in (("a.csv", predictions), ("a.jsonl", objects), ("walks.csv", walks)):
        (tmp_path / name).write_text(text)
    as_csv = read_predictions([tmp_path / "a.csv"]).table
    assert as_csv.equals(read_predictions([tmp_path / "a.jsonl"]).table)
    assert as_csv.num_rows == 2
    assert read_trajectories([tmp_path / "walks.csv"]).table.num_rows == 3
