"""The data contract: the published JSON is the Arrow schema, arrays survive their columns."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from affectsim_data.content import content_names, content_path
from affectsim_data.schemas import (
    SCHEMA_VERSION,
    SCHEMAS,
    TableName,
    array_columns,
    check_table,
    read_array,
    schema_to_json,
    write_json_twins,
)


@pytest.mark.parametrize("table", SCHEMAS)
def test_the_published_json_is_the_schema_in_code(table: TableName) -> None:
    text = content_path("schemas", f"{table}.json").read_text(encoding="utf-8")
    assert json.loads(text) == schema_to_json(table)


def test_every_table_is_published_and_nothing_else() -> None:
    assert content_names("schemas", ".json") == sorted(SCHEMAS)


def test_the_files_are_what_the_module_writes(tmp_path: Any) -> None:
    write_json_twins(tmp_path)
    for path in tmp_path.iterdir():
        assert path.read_bytes() == content_path("schemas", path.name).read_bytes()


def test_json_says_what_a_reader_needs() -> None:
    document = schema_to_json("motions")
    assert document["schema_version"] == SCHEMA_VERSION
    columns = {column["name"]: column for column in document["columns"]}
    assert columns["joint_rotations"]["type"] == "binary"
    assert columns["joint_rotations_shape"]["type"] == "list<int32>"
    assert not columns["emotion"]["nullable"]
    assert all(column["description"] for column in document["columns"])


def test_only_documented_columns_are_nullable() -> None:
    nullable = {field.name for field in SCHEMAS["episodes"] if field.nullable}
    assert {"challenge", "partner_motion_id", "d_star_1m", "d_star_1m_null"} <= nullable
    assert not nullable & {"emotion", "start_x_m", "phase_s", "reference_trajectory"}


@given(
    hnp.arrays(
        st.sampled_from([np.dtype(x) for x in ("<f4", "<f8", "<i4", "<i8", "u1")]),
        hnp.array_shapes(min_dims=1, max_dims=4, min_side=0, max_side=4),
    )
)
def test_arrays_survive_their_columns(array: np.ndarray) -> None:
    back = read_array(array_columns("a", array), "a", where="row")
    assert back.dtype == array.dtype
    np.testing.assert_array_equal(back, array)


def test_arrays_are_stored_little_endian_and_row_major() -> None:
    columns = array_columns("a", np.array([[1, 2], [3, 4]], ">i4").T)
    assert columns["a"] == bytes([1, 0, 0, 0, 3, 0, 0, 0, 2, 0, 0, 0, 4, 0, 0, 0])
    assert columns["a_dtype"] == "<i4"
    assert columns["a_shape"] == [2, 2]


def test_arrays_no_reader_would_take_are_not_written() -> None:
    with pytest.raises(ValueError, match=r"a: dtype must be one of .* got float16"):
        array_columns("a", np.zeros(3, np.float16))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"a_dtype": "O"}, r"row 3: a_dtype must be one of .*'<f4'.* got 'O'"),
        ({"a_dtype": "<f8"}, r"row 3: a with shape \(2, 3\) of <f8 needs 48 bytes, got 24"),
        ({"a_shape": [2, 4]}, r"row 3: a with shape \(2, 4\) of <f4 needs 32 bytes, got 24"),
        ({"a_shape": [-2, -3]}, r"row 3: a with shape \(-2, -3\)"),
        ({"a": b""}, r"needs 24 bytes, got 0"),
        # 2**64 elements, which is none in 64-bit arithmetic.
        ({"a": b"", "a_shape": [1 << 16] * 4}, r"row 3: a with shape \(65536, .* got 0"),
    ],
)
def test_arrays_that_lie_are_refused_by_row(changes: dict[str, Any], message: str) -> None:
    row = {**array_columns("a", np.zeros((2, 3), np.float32)), **changes}
    with pytest.raises(ValueError, match=message):
        read_array(row, "a", where="row 3")


def test_check_table_takes_the_contract_and_extra_columns() -> None:
    schema = SCHEMAS["avatars"].append(pa.field("note", pa.string()))
    check_table(schema, "avatars", file="x.parquet")


def test_check_table_names_what_is_missing() -> None:
    schema = SCHEMAS["avatars"].remove(0).remove(1)
    with pytest.raises(
        ValueError, match=r"^x\.parquet: avatars columns are missing: avatar_id, height_m$"
    ):
        check_table(schema, "avatars", file="x.parquet")


def test_check_table_names_what_has_the_wrong_type() -> None:
    schema = SCHEMAS["avatars"].set(2, pa.field("height_m", pa.string()))
    with pytest.raises(
        ValueError, match=r"^x\.parquet: .* wrong type: height_m must be double, got string$"
    ):
        check_table(schema, "avatars", file="x.parquet")
