"""The rooms of an imported scene: regions its dataset names, else the outline of its floor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from affectsim_data.builders.habitat.dataset import Dataset
from affectsim_data.builders.habitat.fields import Table
from affectsim_data.builders.habitat.files import read_json
from affectsim_data.builders.habitat.instances import SceneInstance
from affectsim_data.builders.habitat.things import Thing
from affectsim_data.builders.imports import ImportLog
from affectsim_data.builders.meshes.floors import find_floor
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Room

__all__ = ["floor_rooms", "region_rooms", "room_of"]

_PURPOSES = {
    "bathroom": "bath",
    "living_room": "living",
    "dining_room": "dining",
    "hallway": "hall",
    "corridor": "hall",
    "entryway": "hall",
    "office": "study",
}
REGIONS = ".semantic_config.json"
_HEIGHT_M = 2.6
"""Of a room that says nothing else and has no ceiling."""


def region_rooms(dataset: Dataset, scene: SceneInstance, log: ImportLog) -> list[Room]:
    """Rooms from the regions of the scene's semantic descriptor; empty if it has none."""
    wanted = scene.semantics.lower()
    for handle, path in sorted(dataset.descriptors.items()):
        named = bool(wanted) and (handle == scene.semantics or wanted in handle.lower())
        if not path.name.endswith(REGIONS) or not (named or path.name == scene.handle + REGIONS):
            continue
        where = dataset.folder.relative(path)
        if not path.is_file():
            reason = f"no file {where}"
            log.add("missing", "semantic descriptor", handle, reason=reason, asked_by=scene.where)
            continue
        try:
            rows = read_json(path, where=where).rows("region_annotations")
        except ValueError as error:
            log.add("skipped", "semantic descriptor", handle, reason=str(error))
            continue
        rooms = _regions(rows, where, log)
        if rooms:
            log.add("found", "regions", where, count=len(rooms))
            return rooms
    return []


def _regions(rows: list[object], where: str, log: ImportLog) -> list[Room]:
    rooms: dict[str, Room] = {}
    for index, row in enumerate(rows):
        place = f"{where}: region_annotations[{index}]"
        try:
            room = _region(Table.of(row, where=place), f"region-{index}")
        except ValueError as error:
            log.add("skipped", "region", place, reason=str(error))
            continue
        if room.room_id in rooms:
            log.add("skipped", "region", place, reason=f"a second {room.room_id!r}")
        else:
            rooms[room.room_id] = room
    return list(rooms.values())


def _region(table: Table, default_id: str) -> Room:
    corners = [
        Table({"corner": corner}, f"{table.where}: poly_loop").vector("corner", (0.0, 0.0, 0.0))
        for corner in table.rows("poly_loop")
    ]
    if len(corners) < 3:
        raise table.wrong("poly_loop", "three or more points")
    floor_y = table.number("floor_height", float(min(corner[1] for corner in corners)))
    height = table.number("extrusion_height", _HEIGHT_M)
    label = table.text("label").lower().replace(" ", "_").split("/")[0]
    return Room(
        room_id=table.text("name") or default_id,
        purpose=_PURPOSES.get(label, label) or "room",
        polygon=tuple((float(corner[0]), float(corner[2])) for corner in corners),
        floor_y=floor_y,
        ceiling_y=floor_y + height,
    )


def floor_rooms(stage: Thing, log: ImportLog) -> list[Room]:
    """A room per connected floor of a stage, the largest first; empty if there is no floor."""
    starts = np.cumsum([0, *(len(one.positions) for one in stage.surfaces[:-1])])
    faces = [
        one.faces.astype(np.int64) + start
        for one, start in zip(stage.surfaces, starts, strict=True)
    ]
    try:
        floor = find_floor(stage.points, np.concatenate(faces))
    except ValueError as error:
        log.note(f"stage {stage.name!r}: {error}")
        return []
    ceiling_y = floor.y + _HEIGHT_M if floor.ceiling_y is None else floor.ceiling_y
    return [
        Room(
            room_id=f"room-{index}",
            purpose="living" if index == 0 else "room",
            polygon=tuple((float(x), float(z)) for x, z in outline.exterior.coords[:-1]),
            floor_y=floor.y,
            ceiling_y=ceiling_y,
        )
        for index, outline in enumerate(floor.outlines)
    ]


def room_of(rooms: Sequence[Room], points: FloatArray) -> NDArray[np.int64]:
    """Index of the room that each point `(n, 3)` is in, -1 for none, `(n,)`."""
    found = np.full(len(points), -1)
    for index, room in reversed(list(enumerate(rooms))):
        inside = shapely.contains_xy(shapely.Polygon(room.polygon), points[:, 0], points[:, 2])
        inside &= (points[:, 1] > room.floor_y - 0.3) & (points[:, 1] < room.ceiling_y + 0.3)
        found[inside] = index
    return found
