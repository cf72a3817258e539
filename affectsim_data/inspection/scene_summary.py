"""The scenes of a release as a table: their rooms, what is in them, and where a robot can go."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import shapely
from tqdm import tqdm

from affectsim_data.affordances import knockable_doors, reachable_seats
from affectsim_data.inspection.scene_plans import floor_areas_m2, scene_sheet
from affectsim_data.inspection.scene_recording import record_scene
from affectsim_data.navmesh import NavMesh
from affectsim_data.releases import Release
from affectsim_data.render import Renderer
from affectsim_data.scenes import Scene

__all__ = ["draw_scenes", "scene_lines", "scene_summary"]

_COLUMNS = {
    "scene_id": "scene",
    "num_rooms": "rooms",
    "floor_m2": "floor m2",
    "robot_m2": "robot m2",
    "largest_island": "one island",
    "num_islands": "islands",
    "num_objects": "things",
    "num_seats": "seats",
    "num_usable_seats": "usable",
    "num_doors": "doors",
    "num_knockable_doors": "knock at",
    "num_triangles": "triangles",
    "num_draw_calls": "draws",
}


def scene_summary(release: Release) -> list[dict[str, Any]]:
    """A row per scene of a release; every scene is read.

    Keys: `scene_id`, `purposes` of its rooms, areas in square metres (`floor_m2` of the rooms,
    `robot_m2` of it where the middle of a robot can be), `largest_island` as a share of `robot_m2`,
    and counts: a seat is usable if a sitter has room and a robot comes near.
    """
    return [_row(scene, navmesh) for scene, navmesh in _scenes(release, "scenes")]


def _scenes(release: Release, what: str) -> Iterator[tuple[Scene, NavMesh]]:
    for scene_id in tqdm(release.asset_ids("scenes"), desc=what, disable=None):
        yield release.scene(scene_id), release.navmesh(scene_id)


def _row(scene: Scene, navmesh: NavMesh) -> dict[str, Any]:
    areas = floor_areas_m2(scene, navmesh)
    return {
        "scene_id": scene.scene_id,
        "purposes": [room.purpose for room in scene.rooms],
        "num_rooms": len(scene.rooms),
        "floor_m2": sum(float(shapely.Polygon(room.polygon).area) for room in scene.rooms),
        "robot_m2": float(sum(areas)),
        "largest_island": float(areas[0] / sum(areas)),
        "num_islands": len(areas),
        "num_objects": len(scene.objects),
        "num_seats": len(scene.seats),
        "num_usable_seats": int(reachable_seats(scene, navmesh).is_usable.sum()),
        "num_doors": len(scene.doors),
        "num_knockable_doors": int(knockable_doors(scene, navmesh).is_knockable.sum()),
        "num_triangles": scene.num_triangles,
        "num_draw_calls": len(scene.surfaces),
        "source": scene.source,
        "licence": scene.licence,
    }


def scene_lines(rows: list[dict[str, Any]]) -> list[str]:
    """The rows as a table for a terminal, with totals below."""
    cells = [tuple(_COLUMNS.values())]
    cells += [tuple(_text(key, row[key]) for key in _COLUMNS) for row in rows]
    widths = [max(len(row[column]) for row in cells) for column in range(len(_COLUMNS))]
    lines = []
    for first, *others in cells:
        texts = (text.rjust(width) for text, width in zip(others, widths[1:], strict=True))
        lines.append("  ".join([first.ljust(widths[0]), *texts]))
    floor, robot = (sum(row[key] for row in rows) for key in ("floor_m2", "robot_m2"))
    triangles = sum(row["num_triangles"] for row in rows)
    lines.append(
        f"{len(rows)} scenes, {floor:.0f} m2 of floor, a robot can be on {robot:.0f} m2, "
        f"{triangles:,} triangles"
    )
    return lines


def _text(key: str, value: Any) -> str:
    if key == "largest_island":
        return f"{value:.1%}"
    if isinstance(value, float):
        return f"{value:.1f}"
    return f"{value:,}" if isinstance(value, int) else str(value)


def draw_scenes(release: Release, renderer: Renderer, folder: Path) -> list[Path]:
    """A plan `NAME.png` and a recording `NAME.rrd` per scene, in a folder that is made.

    Returns:
        What was written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for scene, navmesh in _scenes(release, "plans"):
        name = re.sub(r"[^\w.-]+", "_", scene.scene_id)
        sheet = scene_sheet(scene, navmesh, renderer)
        sheet.save(folder / f"{name}.png")
        record_scene(scene, navmesh, folder / f"{name}.rrd", plan=sheet)
        written += [folder / f"{name}.png", folder / f"{name}.rrd"]
    return written
