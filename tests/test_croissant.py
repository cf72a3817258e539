"""`croissant.json`: valid for MLCommons' own reader, which finds the rows of the release."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import shutil
from pathlib import Path
from typing import Any

import mlcroissant as mlc
import numpy as np
import pytest
from small_release import small_rows, write_release

from affectsim_data import Release, open_release
from affectsim_data.cards.croissant import croissant_text
from affectsim_data.cards.facts import read_facts
from affectsim_data.cards.statements import Statements
from affectsim_data.releases.stores import open_store
from affectsim_data.releases.tables import read_table
from affectsim_data.schemas import SCHEMAS, SPLITS, TableName

DAY = "2026-11-21"


@pytest.fixture(scope="module")
def document(small: Release) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(croissant_text(read_facts(small), published=DAY))
    return found


@pytest.fixture(scope="module")
def dataset(small: Release, tmp_path_factory: pytest.TempPathFactory) -> mlc.Dataset:
    """The release as the reader opens it: its files are found beside croissant.json."""
    folder = tmp_path_factory.mktemp("croissant") / "small"
    path = Path(shutil.copytree(small.uri, folder)) / "croissant.json"
    path.write_text(croissant_text(read_facts(small), published=DAY))
    return mlc.Dataset(jsonld=path)


def expected(value: Any) -> Any:
    """A value of a row as the reader gives it: text is bytes."""
    if isinstance(value, str):
        return value.encode()
    return [expected(one) for one in value] if isinstance(value, list) else value


def same(found: Any, value: Any) -> bool:
    """Whether the reader's value is that of the row."""
    if isinstance(value, float) and math.isnan(value):
        return found is None
    return bool(np.all(found == value)) if isinstance(value, list) else bool(found == value)


# What the reader says


def test_it_is_valid_without_a_warning(dataset: mlc.Dataset) -> None:
    issues = dataset.metadata.ctx.issues
    assert (list(issues.errors), list(issues.warnings)) == ([], [])
    assert dataset.metadata.ctx.is_v1_1()
    assert dataset.metadata.conforms_to == [
        "http://mlcommons.org/croissant/1.1",
        "http://mlcommons.org/croissant/RAI/1.0",
    ]


def test_on_the_hub_files_are_those_of_its_repository(small: Release) -> None:
    text = croissant_text(read_facts(small), place="hf://datasets/org/name@v1")
    dataset = mlc.Dataset(jsonld=json.loads(text), mapping={"repository": small.uri})
    issues = dataset.metadata.ctx.issues
    assert not issues.errors
    (warning,) = issues.warnings
    assert "datePublished" in warning, "nobody said when"
    assert dataset.metadata.url == "https://huggingface.co/datasets/org/name"
    found = {record["index/episode_id"].decode() for record in dataset.records("index")}
    assert found == {row["episode_id"] for row in small_rows()["episodes"]}


@pytest.mark.parametrize("table", ["episodes", "index", "motions", "scenes", "avatars"])
def test_records_are_the_rows(small: Release, dataset: mlc.Dataset, table: TableName) -> None:
    records = list(dataset.records(table))
    store = open_store(small.uri)
    rows = [
        row
        for name in sorted(small.manifest.table_files(table))
        for row in read_table(store, table, name).to_pylist()
    ]
    assert len(records) == len(rows) > 0
    key = SCHEMAS[table].names[0]
    by_key = {record[f"{table}/{key}"]: record for record in records}
    for row in rows:
        record = by_key[row[key].encode()]
        assert record.keys() == {f"{table}/{name}" for name in row}
        wrong = [
            name
            for name, value in row.items()
            if not same(record[f"{table}/{name}"], expected(value))
        ]
        assert not wrong


def test_words_are_records(dataset: mlc.Dataset) -> None:
    splits = [record["splits/name"] for record in dataset.records("splits")]
    assert splits == list(SPLITS)
    labels = {one["emotions/name"]: one["emotions/label"] for one in dataset.records("emotions")}
    assert labels == {"angry": 0, "fearful": 1, "happy": 2, "neutral": 3, "sad": 4}


# What the file says


def test_every_column_is_a_field_with_its_meaning(document: dict[str, Any]) -> None:
    sets = {one["@id"]: one for one in document["recordSet"]}
    assert list(sets) == ["splits", "emotions", "episodes", "index", "motions", "scenes", "avatars"]
    tables: tuple[TableName, ...] = ("episodes", "motions", "scenes", "avatars")
    for table in tables:
        schema = SCHEMAS[table]
        fields = {field["name"]: field for field in sets[table]["field"]}
        assert list(fields) == schema.names
        for field in schema:
            meaning = field.metadata[b"description"].decode()
            assert fields[field.name]["description"].startswith(meaning)


def test_every_file_comes_with_its_hash(document: dict[str, Any], small: Release) -> None:
    found = {one["@id"]: one for one in document["distribution"] if "sha256" in one}
    assert found.keys() == {"MANIFEST.json", *small.manifest.files}
    for name, one in found.items():
        payload = (Path(small.uri) / name).read_bytes()
        assert one["sha256"] == hashlib.sha256(payload).hexdigest()
        assert name == "MANIFEST.json" or one["contentSize"] == f"{len(payload)} B"


def test_patterns_find_every_file_once(document: dict[str, Any], small: Release) -> None:
    patterns = [one["includes"] for one in document["distribution"] if "includes" in one]
    found = [path for pattern in patterns for path in Path(small.uri).glob(pattern)]
    assert sorted(found) == sorted(Path(small.uri) / name for name in small.manifest.files)


def test_responsible_use_is_told_as_in_the_card(document: dict[str, Any], small: Release) -> None:
    said = {name: value for name, value in document.items() if name.startswith("rai:")}
    assert said.pop("rai:hasSyntheticData") is True
    assert len(said) == 10
    assert all(said.values())
    says = Statements(read_facts(small))
    assert f"Not for: {says.items('misuses')[0]}" in said["rai:dataUseCases"]
    assert said["rai:dataBiases"] == says.items("biases")
    assert not [text for text in says.items("biases") if "$" in text or "*" in text]


@pytest.mark.parametrize(
    ("licence", "page"),
    [
        ("CC-BY-4.0", "https://spdx.org/licenses/CC-BY-4.0.html"),
        ("LicenseRef-AMASS", "LicenseRef-AMASS"),
        ("CC0-1.0 AND CC-BY-4.0", "CC0-1.0 AND CC-BY-4.0"),
    ],
)
def test_licences_are_named_by_their_page(small: Release, licence: str, page: str) -> None:
    facts = read_facts(small)
    manifest = dataclasses.replace(facts.manifest, licences=(licence,))
    text = croissant_text(dataclasses.replace(facts, manifest=manifest))
    assert json.loads(text)["license"] == [page]


def test_scenes_alone_are_described(tmp_path: Path) -> None:
    rows = {**small_rows(), "episodes": [], "motions": [], "avatars": []}
    write_release(tmp_path, rows=rows, overwrite=True)
    text = croissant_text(read_facts(open_release(tmp_path)), published=DAY)
    (tmp_path / "croissant.json").write_text(text)
    dataset = mlc.Dataset(jsonld=tmp_path / "croissant.json")
    assert not [*dataset.metadata.ctx.issues.errors, *dataset.metadata.ctx.issues.warnings]
    assert [one.id for one in dataset.metadata.record_sets] == ["scenes"]
    names = {record["scenes/scene_id"] for record in dataset.records("scenes")}
    assert names == {b"empty_room", b"crate_room"}
