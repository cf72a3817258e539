"""Reports as folders: whole or not at all, the same bytes, nobody's work replaced."""

from __future__ import annotations

import csv
import io
import json
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from evaluation_cases import HOSTILE_NAMES, evaluation_case
from scored_cases import scored_table

from affectsim_data.evaluation import Evaluation
from affectsim_data.evaluation.scored import OUTCOMES, ScoredTable
from affectsim_data.evaluation.tables import Places, Predictions
from affectsim_data.motions import EMOTIONS
from affectsim_data.reports import writing
from affectsim_data.reports.model_cards import read_model_cards
from affectsim_data.reports.page import Example
from affectsim_data.reports.quoting import examples_of
from affectsim_data.reports.tables import tables_of
from affectsim_data.reports.writing import write_report
from affectsim_data.schemas import SCHEMAS

SVG = (
    b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"><rect width="1" height="1"/></svg>'
)


@pytest.fixture(autouse=True)
def drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures have tests of their own; here they are stand-ins."""

    def draw_figures(evaluation: Evaluation) -> dict[str, bytes]:
        return {"models.png": b"PNG", "models.svg": SVG}

    monkeypatch.setattr(writing, "draw_figures", draw_figures)


@pytest.fixture(scope="module")
def case() -> Evaluation:
    return evaluation_case(conditions=("p_ref", "p_init"), models=("alpha",))


def contents(folder: Path) -> dict[str, bytes]:
    paths = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}


def test_a_report_holds_a_page_tables_figures_and_all_results(
    case: Evaluation, tmp_path: Path
) -> None:
    written = write_report(case, tmp_path / "new" / "report")
    assert written[0].name == "report.html"
    files = contents(tmp_path / "new" / "report")
    assert {path.relative_to(tmp_path / "new" / "report").as_posix() for path in written} == set(
        files
    )
    for table in tables_of(case):
        assert {f"tables/{table.name}.csv", f"tables/{table.name}.tex"} <= set(files)
    assert files["figures/models.png"] == b"PNG"
    assert json.loads(files["evaluation.json"]) == json.loads(json.dumps(case.to_json()))
    text = files["report.md"].decode()
    links = re.findall(r"\]\(([^)]+)\)", text)
    assert links
    assert set(links) <= set(files)


def test_long_tables_are_left_out_of_the_document(tmp_path: Path) -> None:
    case = evaluation_case(models=tuple(f"model {number}" for number in range(12)))
    write_report(case, tmp_path / "r")
    text = (tmp_path / "r" / "report.md").read_text(encoding="utf-8")
    assert "240 rows, left to the files: [CSV](tables/confusions.csv)" in text
    assert len(max(text.split("\n\n"), key=len).splitlines()) <= 203


def test_the_same_results_give_the_same_bytes(case: Evaluation, tmp_path: Path) -> None:
    write_report(case, tmp_path / "a")
    write_report(case, tmp_path / "b")
    assert contents(tmp_path / "a") == contents(tmp_path / "b")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b"]


def test_a_report_is_replaced_only_when_asked(case: Evaluation, tmp_path: Path) -> None:
    write_report(case, tmp_path / "r")
    before = contents(tmp_path / "r")
    other = evaluation_case(conditions=("p_init",), models=("beta",))
    with pytest.raises(FileExistsError, match="holds a report already; add --overwrite"):
        write_report(other, tmp_path / "r")
    assert contents(tmp_path / "r") == before
    write_report(other, tmp_path / "r", overwrite=True)
    assert "tables/tests.csv" not in contents(tmp_path / "r")
    assert b"beta" in contents(tmp_path / "r")["report.md"]


def test_what_no_report_wrote_is_never_replaced(case: Evaluation, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(FileExistsError, match="is no report; choose another --out"):
        write_report(case, tmp_path, overwrite=True)
    (tmp_path / "report.json").write_text('{"kind": "something else", "files": {}}')
    with pytest.raises(FileExistsError, match="is no report"):
        write_report(case, tmp_path, overwrite=True)
    with pytest.raises(FileExistsError, match="is no report"):
        write_report(case, tmp_path / "thesis.tex", overwrite=True)
    assert (tmp_path / "thesis.tex").read_text() == "years of work"


@pytest.mark.parametrize("change", ["edited", "added", "linked"])
def test_a_report_somebody_worked_in_is_never_replaced(
    change: str, case: Evaluation, tmp_path: Path
) -> None:
    write_report(case, tmp_path / "r")
    if change == "edited":
        name = "report.md"
        (tmp_path / "r" / name).write_text("our words")
    elif change == "added":
        name = "notes.txt"
        (tmp_path / "r" / name).write_text("our words")
    else:
        name = "tables/tests.csv"
        (tmp_path / "r" / name).rename(tmp_path / "elsewhere.csv")
        (tmp_path / "r" / name).symlink_to(tmp_path / "elsewhere.csv")
    with pytest.raises(FileExistsError, match=f"{name}: is not as a report left it"):
        write_report(case, tmp_path / "r", overwrite=True)


@pytest.mark.parametrize("fails", ["_files", "os.replace"])
def test_a_failure_leaves_what_was_there(
    fails: str, case: Evaluation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_report(case, tmp_path / "r")
    before = contents(tmp_path / "r")
    if fails == "_files":
        monkeypatch.setattr(writing, "latex_table", lambda table: 1 / 0)
    else:
        replace = os.replace

        def full(source: Path, target: Path) -> None:
            if source.name == "new":
                raise OSError("no space left")
            replace(source, target)

        monkeypatch.setattr(os, "replace", full)
    with pytest.raises((ZeroDivisionError, OSError), match=r"division|no space left"):
        write_report(case, tmp_path / "r", overwrite=True)
    assert contents(tmp_path / "r") == before
    assert [path.name for path in tmp_path.iterdir()] == ["r"]


def test_names_of_models_become_no_paths_and_no_elements(tmp_path: Path) -> None:
    case = evaluation_case(
        models=HOSTILE_NAMES, conditions=("p_ref", "p_init"), notes=HOSTILE_NAMES
    )
    said = [Example("e/1", name, name, "sad", "other", name) for name in HOSTILE_NAMES]
    write_report(case, tmp_path / "a" / "b" / "report", examples=said)
    tame = evaluation_case(models=("alpha",), conditions=("p_ref", "p_init"))
    write_report(tame, tmp_path / "tame")
    names = set(contents(tmp_path / "a" / "b" / "report"))
    assert names == set(contents(tmp_path / "tame"))
    page = (tmp_path / "a" / "b" / "report" / "report.html").read_text(encoding="utf-8")
    assert "<script" not in page
    assert "&lt;script&gt;" in page
    assert sorted(path.name for path in (tmp_path / "a" / "b").iterdir()) == ["report"]


# Sizes and groups of models


def cards_file(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "models.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_model_cards_are_read(tmp_path: Path) -> None:
    path = cards_file(tmp_path, '\ufeffmodel,group,parameters\nalpha,"Open, small",7B\nbeta,,\n')
    cards = read_model_cards(path)
    assert (cards["alpha"].group, cards["alpha"].parameters) == ("Open, small", "7B")
    assert cards["beta"].group == ""
    assert read_model_cards(cards_file(tmp_path, "model\nalpha\n"))["alpha"].parameters == ""


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name,group\nalpha,x\n", "must have the columns model, group, parameters"),
        ("", "must have the columns .* got none"),
        ("model,size\nalpha,7B\n", "got 'model', 'size'"),
        ("model,group\nalpha,x\nalpha,y\n", "line 3: model 'alpha' is there twice"),
        ("model,group\n,x\n", "line 2: names no model"),
        ("model,group\nalpha,x,y\n", "line 2: has more cells than there are columns"),
        ('model\n"alpha\n', "is no CSV in UTF-8"),
    ],
)
def test_broken_model_cards_are_named(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=message):
        read_model_cards(cards_file(tmp_path, text))


def test_model_cards_that_are_not_there(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="no such file; it should list model"):
        read_model_cards(tmp_path / "none.csv")


# Answers to quote


def predictions_of(table: ScoredTable, texts: Mapping[str, str | None]) -> Predictions:
    """Rows of the same answers, in the words of each model."""
    rows: list[dict[str, Any]] = [
        {
            "episode_id": str(episode),
            "condition": condition,
            "model": model,
            "raw_text": texts[model],
            "label": None,
        }
        for model in table.models
        for condition in table.conditions
        for episode in table.episode_ids
    ]
    columns = pa.Table.from_pylist(rows, schema=SCHEMAS["predictions"])
    places = Places(files=(), starts=np.zeros(0, int), rows=np.arange(len(rows)), find_lines=())
    return Predictions(columns, places)


def test_quoted_answers_are_the_first_of_their_kind() -> None:
    table = scored_table(models=("alpha", "mute"), num_performances=20)
    found = examples_of(predictions_of(table, {"alpha": "<b>so</b>", "mute": None}), table)
    assert {one.model for one in found} == {"alpha"}
    answers = dict(zip(table.conditions, table.answers[0], strict=True))
    mended = (answers["p_init"] != table.truth) & (answers["p_ref"] == table.truth)
    first = str(table.episode_ids[np.argmax(mended)])
    assert [(one.condition, one.episode_id) for one in found[:2]] == [
        ("p_init", first),
        ("p_ref", first),
    ]
    assert found[1].answer == found[1].truth
    assert all(one.answer in (*EMOTIONS, *OUTCOMES) for one in found)
    assert found[-1].answer in OUTCOMES
    assert found[0].raw_text == "<b>so</b>"


def test_csv_of_a_report_is_read_back_by_others(case: Evaluation, tmp_path: Path) -> None:
    write_report(case, tmp_path / "r")
    text = (tmp_path / "r" / "tables" / "tests.csv").read_text(encoding="utf-8")
    [row] = list(csv.DictReader(io.StringIO(text)))
    assert float(row["mcnemar_p"]) == case.tests[0].mcnemar_p
