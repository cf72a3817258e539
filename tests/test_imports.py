"""Reports of imports count the same in text and in rows."""

from __future__ import annotations

import json

from affectsim_data.builders.imports import ImportLog


def log() -> ImportLog:
    """One of everything."""
    log = ImportLog()
    for name in ("b", "a", "a"):
        log.add("found", "object", name)
    log.add("missing", "mesh", "c.glb", reason="no such file", asked_by="c.json")
    log.add("missing", "mesh", "d.glb", reason="no such file", asked_by="d.json", count=3)
    log.note("textures not decoded", 2)
    log.note("textures not decoded")
    return log


def test_equal_things_are_counted_and_sorted() -> None:
    report = log().report("home", source="home.json", triangles=12)
    assert [(e.name, e.count) for e in report.entries] == [
        ("a", 2), ("b", 1), ("c.glb", 1), ("d.glb", 3),
    ]  # fmt: skip
    assert report.total("found") == 3
    assert report.total("missing", "mesh") == 4
    assert report.total("missing", "object") == 0
    assert report.names("found", "object") == ("a", "b")
    assert report.notes == {"textures not decoded": 3}


def test_lines_group_by_kind_and_reason_and_shorten_lists() -> None:
    report = log().report("home", source="home.json", triangles=12, textures=3, textures_replaced=1)
    assert report.lines() == [
        "home: 12 triangles, 3 textures (1 replaced by a colour), from home.json",
        "  found    object: 3: a x2, b",
        "  missing  mesh: 4 (no such file): c.glb, d.glb x3; asked for by c.json and 1 more files",
        "  note     textures not decoded: 3",
    ]
    assert report.lines(max_names=1)[1] == "  found    object: 3: a x2 and 1 more names"


def test_rows_are_json_with_the_same_keys() -> None:
    rows = log().report("home", source="home.json", triangles=12).to_rows()
    assert json.loads(json.dumps(rows)) == rows
    assert {tuple(row) for row in rows} == {
        ("scene_id", "source", "status", "kind", "name", "count", "reason", "asked_by")
    }
    assert sum(row["count"] for row in rows if row["status"] == "missing") == 4
    note = next(row for row in rows if row["status"] == "note")
    assert (note["name"], note["count"]) == ("textures not decoded", 3)
    total = next(row for row in rows if row["name"] == "triangles")
    assert (total["kind"], total["count"]) == ("total", 12)
