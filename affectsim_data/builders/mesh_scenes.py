"""A whole place in one mesh file as a scene: its floor, its rooms, its things and its seats."""

from __future__ import annotations

import contextlib
import dataclasses
import fnmatch
import math
import re
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import shapely
from numpy.typing import NDArray

from affectsim_data.builders.homes.catalogue.kinds import SEATS, kinds_of
from affectsim_data.builders.homes.catalogue.surfaces_on_top import height_map, seats_on
from affectsim_data.builders.imports import ImportLog, ImportReport
from affectsim_data.builders.meshes import (
    DEFAULT_LIMITS,
    MeshAsset,
    MeshLimits,
    MeshPart,
    Notes,
    read_mesh,
)
from affectsim_data.builders.meshes.floors import Floor, find_floor
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Room, Scene, SceneObject, Seat

__all__ = ["UpAxis", "mesh_scene"]

UpAxis = Literal["auto", "y", "z"]
_CEILING_M = 2.6
"""Of a room without one."""
_FAR_M = 5.0
"""What is farther than this from the room is reported: it is hardly meant to be there."""
_LARGEST_PLACE_M = 500.0
_MUCH_LARGER = 4.0
"""A floor that is so many times as large across another axis says that the other is up."""
_STRUCTURE = re.compile(
    r"wall|floor|ground|ceiling|roof|stage|room|window|building|skirting|origin"
)
_GENERIC = re.compile(r"^(v|node|visual|mesh|cube|plane|object|geometry|part|group|material)*$")
"""Names that tell nothing, without their numbers and spaces."""
_PURPOSES = ("kitchen", "living", "dining", "bedroom", "bath", "study", "hall")


def mesh_scene(
    path: Path, *, scene_id: str, drop_nodes: tuple[str, ...] = (), up: UpAxis = "auto",
    metres_per_unit: float = 1.0, ceiling_y: float | None = None, source: str = "",
    licence: str = "", limits: MeshLimits = DEFAULT_LIMITS,
) -> tuple[Scene, ImportReport]:  # fmt: skip
    """The scene in a GLB, glTF or OBJ file, unlit, and a report of what was found and left out.

    Every connected part of the floor is a room, every node a thing, and nodes called chair, sofa,
    bench or stool have seats.

    Args:
        path: The file.
        scene_id: Of the scene.
        drop_nodes: Patterns of nodes to leave out, for example `Compass*`.
        up: The file's upward axis. glTF says `y`; `auto` takes `z` where that gives a floor
            several times as large, and notes it.
        metres_per_unit: Length of the file's unit.
        ceiling_y: Height of the ceiling, metres; found by rays if not given.
        source: Where the scene comes from; the file's name if empty.
        licence: Its licence, SPDX.
        limits: Bounds of the file.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: It is broken, over a limit, or has no floor; the message starts with `path`.
    """
    path, log = Path(path), ImportLog()
    if up not in get_args(UpAxis):
        raise ValueError(f"up must be one of {get_args(UpAxis)}, got {up!r}")
    if not (math.isfinite(metres_per_unit) and metres_per_unit > 0.0):
        raise ValueError(f"metres_per_unit must be above 0, got {metres_per_unit!r}")
    asset = read_mesh(path, limits=limits)
    parts = _kept(asset, drop_nodes, log)
    if not parts:
        raise ValueError(f"{path}: drop_nodes {list(drop_nodes)} leave nothing of it")
    try:
        parts, floor = _upright(parts, up, metres_per_unit, log)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    parts = _with_floor_up(parts, floor, log)
    rooms = _rooms(floor, path.stem, ceiling_y)
    groups = _groups(parts)
    _report_far(groups, floor, rooms, log)
    objects, seats = _things(groups, floor, rooms, log)
    scene = Scene(
        scene_id=scene_id,
        surfaces=tuple(part.to_surface(part.name) for part in parts),
        rooms=rooms,
        seats=seats,
        objects=objects,
        source=source or path.name,
        licence=licence,
    )
    for note, count in asset.notes.items():
        log.note(note, count)
    replaced = sum(count for note, count in asset.notes.items() if note.startswith("texture"))
    report = log.report(
        scene_id, source=str(path), triangles=scene.num_triangles,
        textures=len(asset.textures), textures_replaced=replaced,
    )  # fmt: skip
    return scene, report


def _kept(asset: MeshAsset, drop_nodes: tuple[str, ...], log: ImportLog) -> list[MeshPart]:
    """The parts no pattern names; patterns that name none are noted."""
    dropped: dict[str, set[str]] = {pattern: set() for pattern in drop_nodes}
    for part in asset.parts:
        # Some viewers call the parts of a node NODE_MATERIAL.
        names = (part.node, part.name, f"{part.node}_{part.material}")
        for pattern, found in dropped.items():
            if any(fnmatch.fnmatchcase(name, pattern) for name in names):
                found.add(part.name)
    gone = set().union(*dropped.values()) if dropped else set()
    for part in asset.parts:
        if part.name in gone:
            log.add("skipped", "node", part.node or part.name, reason="drop_nodes")
    for pattern, found in dropped.items():
        if not found:
            log.note(f"drop_nodes pattern {pattern!r} matches no node")
    return [part for part in asset.parts if part.name not in gone]


def _in_metres(part: MeshPart, up: UpAxis, metres_per_unit: float) -> MeshPart:
    if up == "y" and metres_per_unit == 1.0:
        return part
    turn = np.eye(3) if up == "y" else np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
    positions = part.positions.astype(np.float64) @ turn.T * metres_per_unit
    normals = part.normals @ turn.T
    return dataclasses.replace(
        part, positions=positions.astype(np.float32), normals=normals.astype(np.float32)
    )


def _upright(
    parts: list[MeshPart], up: UpAxis, metres_per_unit: float, log: ImportLog
) -> tuple[list[MeshPart], Floor]:
    """The parts in metres with Y up, and their floor."""
    first: Literal["y", "z"] = "y" if up == "auto" else up
    upright = [_in_metres(part, first, metres_per_unit) for part in parts]
    problem: ValueError | None = None
    floor: Floor | None = None
    try:
        floor = _floor_of(upright)
    except ValueError as error:
        problem = error
    if up == "auto":
        other = [_in_metres(part, "z", metres_per_unit) for part in parts]
        with contextlib.suppress(ValueError):
            on_side = _floor_of(other)
            if floor is None or on_side.area_m2 > _MUCH_LARGER * floor.area_m2:
                log.note(f"taken as z up: its floor has {on_side.area_m2:.0f} m2 then")
                return other, on_side
    if floor is None:
        assert problem is not None
        raise problem
    return upright, floor


def _floor_of(parts: list[MeshPart]) -> Floor:
    positions, faces = MeshAsset("", tuple(parts), Notes()).mesh()
    extent = float(np.ptp(positions, axis=0)[[0, 2]].max())
    if extent > _LARGEST_PLACE_M:
        raise ValueError(
            f"{extent:.0f} m across, more than the {_LARGEST_PLACE_M:.0f} m of any place; drop far "
            "nodes (drop_nodes) or say what unit is meant (metres_per_unit)"
        )
    return find_floor(positions, faces)


def _with_floor_up(parts: list[MeshPart], floor: Floor, log: ImportLog) -> list[MeshPart]:
    """Floors that face down turned round: a robot stands on what faces up."""
    if not floor.upside_down.any():
        return parts
    log.note("floor triangles that faced down turned round", int(floor.upside_down.sum()))
    turned, start = [], 0
    for part in parts:
        down = floor.upside_down[start : start + len(part.faces)]
        start += len(part.faces)
        faces = np.where(down[:, None], part.faces[:, ::-1], part.faces)
        turned.append(dataclasses.replace(part, faces=faces))
    return turned


def _rooms(floor: Floor, name: str, ceiling_y: float | None) -> tuple[Room, ...]:
    purpose = next((one for one in _PURPOSES if one in name.lower()), "living")
    top = ceiling_y if ceiling_y is not None else floor.ceiling_y
    return tuple(
        Room(
            room_id=f"{purpose}_{number}",
            purpose=purpose,
            polygon=tuple((float(x), float(z)) for x, z in outline.exterior.coords[:-1]),
            floor_y=floor.y,
            ceiling_y=top if top is not None else floor.y + _CEILING_M,
        )
        for number, outline in enumerate(floor.outlines, start=1)
    )


@dataclasses.dataclass(frozen=True)
class _Group:
    """All parts of one node."""

    name: str
    words: str
    """What it is called: its own name, or its materials' where that says nothing."""
    positions: FloatArray
    faces: NDArray[np.int64]

    @property
    def low(self) -> FloatArray:
        low: FloatArray = self.positions.min(axis=0)
        return low

    @property
    def high(self) -> FloatArray:
        high: FloatArray = self.positions.max(axis=0)
        return high


def _groups(parts: list[MeshPart]) -> list[_Group]:
    members: dict[str, list[MeshPart]] = {}
    for part in parts:
        members.setdefault(part.node or part.name, []).append(part)
    groups = []
    for name, group in members.items():
        positions, faces = MeshAsset("", tuple(group), Notes()).mesh()
        largest = max(group, key=lambda part: len(part.faces))
        words = _words(name)
        if _GENERIC.match(words.replace(" ", "")):
            words = _words(largest.material) or words
        groups.append(_Group(name, words, positions, faces))
    return groups


def _words(name: str) -> str:
    """`Cabinet_Door.R.001` as `cabinet door r`."""
    spaced = re.sub(r"([a-z])([A-Z])", r"\1 \2", name)
    return " ".join(re.findall(r"[a-z]+", spaced.lower()))


def _report_far(
    groups: list[_Group], floor: Floor, rooms: tuple[Room, ...], log: ImportLog
) -> None:
    """Notes the nodes that float or lie far from the rooms."""
    whole = shapely.union_all(list(floor.outlines))
    for group in groups:
        box = shapely.box(group.low[0], group.low[2], group.high[0], group.high[2])
        aside = float(box.distance(whole))
        above = float(group.low[1] - rooms[0].ceiling_y)
        below = float(floor.y - group.high[1])
        away = max(aside, above, below)
        if away > _FAR_M:
            log.note(
                f"node {group.name!r} is {away:.1f} m away from the rooms; drop_nodes leaves it out"
            )


def _things(
    groups: list[_Group], floor: Floor, rooms: tuple[Room, ...], log: ImportLog
) -> tuple[tuple[SceneObject, ...], tuple[Seat, ...]]:
    objects: list[SceneObject] = []
    seats: list[Seat] = []
    numbers: dict[str, int] = {}
    area = floor.area_m2
    for group in groups:
        extent = group.high - group.low
        if _STRUCTURE.search(group.words) or extent[0] * extent[2] > 0.5 * area:
            log.add("found", "structure", group.name)
            continue
        kinds = kinds_of(group.words)
        category = kinds[0] if kinds else (group.words or "object")
        numbers[category] = numbers.get(category, 0) + 1
        yaw = 0.0
        if category in SEATS:
            found, yaw = _seats(group, category, floor.y)
            seats += found
            if not found:
                log.note(f"no seat found on node {group.name!r}")
        objects.append(_object(group, category, numbers[category], yaw, floor, rooms))
        log.add("found", "object", group.name)
    return tuple(objects), tuple(seats)


def _object(
    group: _Group, category: str, number: int, yaw: float, floor: Floor, rooms: tuple[Room, ...]
) -> SceneObject:
    extent, middle = group.high - group.low, (group.low + group.high) / 2.0
    sideways = round(yaw / 90.0) % 2 == 1
    size = (extent[2], extent[1], extent[0]) if sideways else tuple(extent)
    room = next(
        (
            room.room_id
            for room, outline in zip(rooms, floor.outlines, strict=True)
            if outline.covers(shapely.Point(middle[0], middle[2]))
        ),
        "",
    )
    return SceneObject(
        object_id=f"{category.replace(' ', '_')}_{number:02d}",
        category=category,
        position=(float(middle[0]), float(group.low[1]), float(middle[2])),
        size=(float(size[0]), float(size[1]), float(size[2])),
        yaw_deg=yaw,
        room_id=room,
    )


def _seats(group: _Group, category: str, floor_y: float) -> tuple[list[Seat], float]:
    """Seats of a thing, looking away from its back, and that direction in degrees."""
    middle = (group.low + group.high) / 2.0
    middle[1] = floor_y
    best: tuple[float, list[Seat], float] = (-math.inf, [], 0.0)
    for yaw_deg in (0.0, 90.0, 180.0, -90.0):
        yaw = math.radians(yaw_deg)
        c, s = math.cos(yaw), math.sin(yaw)
        T_world_local = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
        local = (group.positions - middle) @ T_world_local
        extent = np.ptp(local, axis=0)
        view = height_map(local, group.faces, (float(extent[0]), float(extent[2]), 0.0))
        found = seats_on(view, places=category in ("sofa", "bench"))
        if not found:
            continue
        rows = len(view.zs) // 4 + 1
        solid = np.where(np.isfinite(view.heights), view.heights, 0.0)
        back = float(np.percentile(solid[:rows], 70) - np.percentile(solid[-rows:], 70))
        if back > best[0] + 1e-6:
            placed = [
                Seat(
                    position=_point(T_world_local @ np.array(one.position) + middle),
                    yaw_deg=yaw_deg, depth=one.depth, height=one.position[1],
                )
                for one in found
            ]  # fmt: skip
            best = (back, placed, yaw_deg)
    return best[1], best[2]


def _point(values: FloatArray) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])
