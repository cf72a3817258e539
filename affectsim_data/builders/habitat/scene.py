"""`import_scene`: a scene of a Habitat dataset as a scene of ours, and what became of its parts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from affectsim_data.builders.habitat.assets import MeshReader
from affectsim_data.builders.habitat.categories import read_categories
from affectsim_data.builders.habitat.dataset import Dataset
from affectsim_data.builders.habitat.doors import doors_on
from affectsim_data.builders.habitat.instances import Instance, SceneInstance, read_scene_instance
from affectsim_data.builders.habitat.rooms import floor_rooms, region_rooms, room_of
from affectsim_data.builders.habitat.seats import seats_on
from affectsim_data.builders.habitat.shell import build_shell
from affectsim_data.builders.habitat.things import Thing, Things
from affectsim_data.builders.imports import ImportLog, ImportReport
from affectsim_data.scenes import Door, Room, Scene, SceneObject, Seat, Surface

__all__ = ["import_scene"]

_ROOM_HEIGHT_M = 2.6


def import_scene(
    dataset: Dataset,
    handle: str,
    *,
    shell: bool = False,
    licence: str = "",
    lexicon: Path | None = None,
    read_mesh: MeshReader | None = None,
) -> tuple[Scene, ImportReport]:
    """Imports a scene: its stage and objects in their places, unlit, one surface per mesh part.

    Args:
        dataset: From `read_dataset`.
        handle: Of a scene instance, or of a stage to import alone.
        shell: Builds floor, walls and ceiling where the stage is missing. Objects whose mesh is
            missing are then stood for by their collision mesh, or by a plain box where the size of
            their category is known.
        licence: SPDX id of the scene; that of the dataset's licence file if empty.
        lexicon: A semantic lexicon to use instead of the dataset's own.
        read_mesh: Reads a mesh file; `affectsim_data.builders.meshes.read_mesh` if `None`.

    Returns:
        The scene, and a report of everything found, missing, skipped and ignored.

    Raises:
        KeyError: The dataset has no such scene.
        ValueError: The scene's file is broken, or nothing of the scene can be drawn.
    """
    log = ImportLog()
    name = dataset.find_scene(handle)
    if name:
        path = dataset.scenes[name]
        where = dataset.folder.relative(path)
        instance = read_scene_instance(
            path, handle=name, where=where, defaults=dataset.scene_defaults, log=log
        )
    else:
        instance = _stage_alone(handle)
    categories = read_categories(dataset, named=instance.semantics, lexicon=lexicon, log=log)
    things = Things(dataset, instance, categories, log=log, read_mesh=read_mesh, stand_ins=shell)
    stage, objects = things.stage(), things.objects()
    _ignored(instance, log)
    surfaces, rooms = _room_and_walls(dataset, instance, things, stage, objects, shell, log)
    surfaces += [surface for thing in objects for surface in thing.surfaces]
    described, seats, doors = _described(objects, rooms)
    scene = Scene(
        scene_id=instance.handle,
        surfaces=tuple(surfaces),
        rooms=tuple(rooms),
        seats=seats,
        doors=doors,
        objects=described,
        source=f"{dataset.name}: {instance.where}",
        licence=licence or dataset.licence,
    )
    if not scene.licence:
        log.note("no licence file in the dataset's folder, and none was given")
    report = log.report(
        scene.scene_id,
        source=scene.source,
        triangles=scene.num_triangles,
        textures=things.assets.textures,
        textures_replaced=things.assets.replaced,
    )
    return scene, report


def _stage_alone(handle: str) -> SceneInstance:
    """The scene that Habitat makes of a stage without a scene instance."""
    still = Instance(handle, np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), np.ones(3), False)
    short = handle.rsplit("/", 1)[-1].split(".", 1)[0]
    return SceneInstance(short, "no scene instance", still, (), ())


def _ignored(instance: SceneInstance, log: ImportLog) -> None:
    if instance.lighting and instance.lighting != "no_lights":
        reason = "light is baked by the builder"
        log.add("ignored", "light setup", instance.lighting, reason=reason)
    if instance.navmesh:
        reason = "navmeshes are built from the scene"
        log.add("ignored", "navmesh", instance.navmesh, reason=reason)


def _room_and_walls(
    dataset: Dataset,
    instance: SceneInstance,
    things: Things,
    stage: Thing | None,
    objects: list[Thing],
    shell: bool,
    log: ImportLog,
) -> tuple[list[Surface], list[Room]]:
    """What encloses the scene, and its rooms: at least one."""
    rooms = region_rooms(dataset, instance, log)
    if stage is not None:
        if shell:
            log.note("no shell built: the stage is there")
        return list(stage.surfaces), rooms or floor_rooms(stage, log) or [_bounds_room([stage])]
    if shell and (objects or things.anchors):
        built = build_shell(objects, things.anchors)
        log.note("shell: floor, walls and ceiling built around the objects")
        if built.left_out:
            log.note(
                "objects far above or below the floor: the shell is not for them", built.left_out
            )
        return list(built.surfaces), rooms or [built.room]
    if not objects:
        raise ValueError(_nothing(instance, things, shell))
    log.note("no floor: the stage is missing, and no shell was asked for (--shell)")
    return [], rooms or [_bounds_room(objects)]


def _nothing(instance: SceneInstance, things: Things, shell: bool) -> str:
    """The message for a scene of which nothing can be drawn."""
    text = f"scene {instance.handle!r}: nothing to draw: "
    count = len(instance.objects) + len(instance.articulated)
    if instance.stage is not None:
        text += f"stage {instance.stage.template_name!r} cannot be had, "
    text += f"nor can any of its {count} objects" if count else "it has no objects"
    if things.anchors and not shell:
        text += "; put the dataset's meshes in place, or build walls around the objects: --shell"
    return text + f" ({instance.where})"


def _bounds_room(things: Sequence[Thing]) -> Room:
    """The plan of a box around things."""
    points = np.concatenate([thing.points for thing in things])
    low, high = points.min(axis=0), points.max(axis=0)
    # A flat thing must still have an inside.
    high = np.maximum(high, low + 0.1)
    corners = ((low[0], low[2]), (high[0], low[2]), (high[0], high[2]), (low[0], high[2]))
    polygon = tuple((float(x), float(z)) for x, z in corners)
    ceiling_y = float(max(high[1], low[1] + _ROOM_HEIGHT_M))
    return Room("room-0", "living", polygon, float(low[1]), ceiling_y)


def _described(
    objects: Sequence[Thing], rooms: Sequence[Room]
) -> tuple[tuple[SceneObject, ...], tuple[Seat, ...], tuple[Door, ...]]:
    """Every thing as a box about its vertical axis, the seats of those to sit on, and doors."""
    if not objects:
        return (), (), ()
    boxes = [_upright_box(thing) for thing in objects]
    middles = np.array([[x, y + size[1] / 2.0, z] for (x, y, z), size in boxes])
    found, seats, doors = [], [], []
    for thing, (position, size), index in zip(objects, boxes, room_of(rooms, middles), strict=True):
        room_id = rooms[index].room_id if index >= 0 else ""
        found.append(
            SceneObject(thing.name, thing.category, position, size, thing.yaw_deg, room_id)
        )
        floor_y = rooms[max(int(index), 0)].floor_y
        seats += seats_on(thing, floor_y=floor_y)
        doors += doors_on(thing, floor_y=floor_y)
    return tuple(found), tuple(seats), tuple(doors)


def _upright_box(thing: Thing) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Middle of the bottom, and width, height and depth, of the box that looks the thing's way."""
    yaw = np.radians(thing.yaw_deg)
    axes = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    points = thing.points
    plan = points[:, [0, 2]] @ axes
    low, high = plan.min(axis=0), plan.max(axis=0)
    x, z = axes @ ((low + high) / 2.0)
    bottom, top = float(points[:, 1].min()), float(points[:, 1].max())
    width, depth = high - low
    return (float(x), bottom, float(z)), (float(width), top - bottom, float(depth))
