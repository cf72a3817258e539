"""Record sets of `croissant.json`: the tables of a release, field by field, and its words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pyarrow as pa

from affectsim_data.motions import EMOTIONS
from affectsim_data.releases.manifest import Manifest
from affectsim_data.schemas import SCHEMAS, TableName

__all__ = ["emotion_records", "file_set_id", "splits_records", "table_records", "tables_of"]

_TABLES: dict[TableName, str] = {
    "episodes": "Replayable configurations: who does what, where, and where a robot starts",
    "index": "The columns of the episodes that identify them",
    "cells": "How many episodes were planned and composed",
    "motions": "Labelled performances as rotations of joints",
    "scenes": "Geometry, rooms, seats, doors and navigation meshes",
    "avatars": "Bodies that perform the motions",
    "trajectories": "Recorded runs of active-observation policies",
    "predictions": "What recognizers said",
}
_TYPES: dict[pa.DataType, str] = {
    pa.string(): "sc:Text",
    pa.binary(): "sc:Text",  # Croissant has no word for bytes; as Text they come back as they are
    pa.bool_(): "sc:Boolean",
    pa.float64(): "cr:Float64",
    pa.float32(): "cr:Float32",
    pa.int64(): "cr:Int64",
    pa.int32(): "cr:Int32",
}
_SPLIT_TYPES = {
    "train": "cr:TrainingSplit",
    "validation": "cr:ValidationSplit",
    "test": "cr:TestSplit",
}


def tables_of(manifest: Manifest) -> list[TableName]:
    """The tables that a release has files of."""
    return [table for table in _TABLES if manifest.num_rows(table)]


def file_set_id(table: TableName) -> str:
    """What the files of a table are called."""
    return f"{table}-files"


def table_records(table: TableName) -> dict[str, Any]:
    """A table, every column with its type and meaning."""
    schema = SCHEMAS[table]
    record_set: dict[str, Any] = {
        "@type": "cr:RecordSet",
        "@id": table,
        "name": table,
        "description": _TABLES[table],
        "field": [_field(table, field) for field in schema],
    }
    if schema.names[0] == f"{table.removesuffix('s')}_id":
        record_set["key"] = {"@id": f"{table}/{schema.names[0]}"}
    return record_set


def _field(table: TableName, field: pa.Field) -> dict[str, Any]:
    is_array = pa.types.is_list(field.type)
    kind = field.type.value_type if is_array else field.type
    binary = ", binary" if pa.types.is_binary(kind) else ""
    return {
        "@type": "cr:Field",
        "@id": f"{table}/{field.name}",
        "name": field.name,
        "description": field.metadata[b"description"].decode() + binary,
        "dataType": _TYPES[kind],
        **({"isArray": True, "arrayShape": "-1"} if is_array else {}),
        "source": {"fileSet": {"@id": file_set_id(table)}, "extract": {"column": field.name}},
        **({"references": {"field": {"@id": "splits/name"}}} if field.name == "split" else {}),
    }


def splits_records(splits: Sequence[str]) -> dict[str, Any]:
    """The splits, and what each is for."""
    return _words(
        "splits",
        "Splits: no two share a performer, a source performance or an interaction sequence",
        "cr:Split",
        ("url", "sc:URL", "What it is for"),
        [(name, _SPLIT_TYPES[name]) for name in splits],
    )


def emotion_records() -> dict[str, Any]:
    """The emotions, and the index that stands for each."""
    return _words(
        "emotions",
        "The words for emotions, in label order",
        "sc:Enumeration",
        ("label", "cr:Int32", "Index of the class"),
        [(name, label) for label, name in enumerate(EMOTIONS)],
    )


def _words(
    name: str,
    description: str,
    kind: str,
    second: tuple[str, str, str],
    data: Sequence[tuple[str, str | int]],
) -> dict[str, Any]:
    """A closed set of words with something said of each."""
    columns = (("name", "sc:Text", "The word"), second)
    return {
        "@type": "cr:RecordSet",
        "@id": name,
        "name": name,
        "description": description,
        "dataType": kind,
        "key": {"@id": f"{name}/name"},
        "field": [
            {
                "@type": "cr:Field",
                "@id": f"{name}/{column}",
                "name": column,
                "description": text,
                "dataType": data_type,
            }
            for column, data_type, text in columns
        ],
        "data": [{f"{name}/name": word, f"{name}/{second[0]}": said} for word, said in data],
    }
