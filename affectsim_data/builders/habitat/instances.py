"""Scene instances: which templates stand where, as `*.scene_instance.json` says."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from affectsim_data.builders.habitat.fields import Table
from affectsim_data.builders.habitat.files import read_json
from affectsim_data.builders.imports import ImportLog
from affectsim_data.poses import FloatArray

__all__ = ["MAX_INSTANCES", "Instance", "SceneInstance", "read_scene_instance"]

MAX_INSTANCES = 20_000
_OWN_NAME = "%%CONFIG_NAME_AS_ASSET_FILENAME%%"
MAX_SCALE = 1e4
MAX_DISTANCE_M = 1e5
_UNIT_TOLERANCE = 1e-3
"""Rotations further from unit length than this are normalised with a note."""


@dataclasses.dataclass(frozen=True)
class Instance:
    """A stage or an object, placed."""

    template_name: str
    translation: FloatArray
    """Metres, `(3,)`."""
    rotation: FloatArray
    """Unit quaternion `wxyz`."""
    scale: FloatArray
    """Uniform times non-uniform scale, `(3,)`."""
    com_origin: bool
    """Whether the translation is that of the centre of mass, not of the asset's own origin."""
    visible: bool = True
    joints: Mapping[str, float] | tuple[float, ...] = ()
    """Joint positions by name, or of the movable joints in order; empty is all zero."""


@dataclasses.dataclass(frozen=True)
class SceneInstance:
    """A scene as its file describes it."""

    handle: str
    """Its short name."""
    where: str
    """Its file, relative to the dataset."""
    stage: Instance | None
    objects: tuple[Instance, ...]
    articulated: tuple[Instance, ...]
    semantics: str = ""
    """Handle of its semantic descriptor."""
    lighting: str = ""
    navmesh: str = ""


def read_scene_instance(
    path: Path, *, handle: str, where: str, defaults: Mapping[str, object], log: ImportLog
) -> SceneInstance:
    """Reads a scene instance. Instances with wrong values are skipped and named in the log.

    Args:
        path: The `*.scene_instance.json`.
        handle: Short name of the scene.
        where: What messages call the file.
        defaults: Default attributes of the dataset.
        log: Gets what is skipped or mended.

    Raises:
        ValueError: The file is broken, or names more than 20,000 instances.
    """
    table = read_json(path, where=where)
    table = Table({**defaults, **table.values}, where)
    com_origin = _com_origin(table, default=True)
    objects, articulated = (
        table.rows("object_instances"),
        table.rows("articulated_object_instances"),
    )
    count = len(objects) + len(articulated)
    if count > MAX_INSTANCES:
        raise ValueError(f"{where}: has {count} instances, more than the {MAX_INSTANCES} allowed")
    stage = None
    if "stage_instance" in table:
        found = _instances([table.values["stage_instance"]], "stage", "stage_instance", table, log)
        stage = found[0] if found else None
    semantics = table.text("semantic_scene_instance").replace(_OWN_NAME, handle)
    return SceneInstance(
        handle=handle,
        where=where,
        stage=stage,
        objects=_instances(objects, "object", "object_instances", table, log, com_origin),
        articulated=_instances(
            articulated, "articulated object", "articulated_object_instances", table, log
        ),
        semantics=semantics,
        lighting=table.text("default_lighting"),
        navmesh=table.text("navmesh_instance"),
    )


def _instances(
    rows: list[object], kind: str, key: str, scene: Table, log: ImportLog, com_origin: bool = True
) -> tuple[Instance, ...]:
    """The instances of a list; broken ones are logged by what is wrong with them."""
    instances = []
    for index, row in enumerate(rows):
        place = f"{scene.where}: {key}[{index}]" if kind != "stage" else f"{scene.where}: {key}"
        try:
            instance = _instance(Table.of(row, where=place), com_origin=com_origin, log=log)
            # Stages and articulated objects are placed by their own origin, whatever they say.
            own = instance.com_origin and kind == "object"
            instances.append(dataclasses.replace(instance, com_origin=own))
        except ValueError as error:
            name = str(row.get("template_name", key)) if isinstance(row, Mapping) else key
            log.add("skipped", kind, name, reason=str(error), asked_by=scene.where)
    return tuple(instances)


def _instance(table: Table, *, com_origin: bool, log: ImportLog) -> Instance:
    name = table.text("template_name")
    if not name:
        raise ValueError(f"{table.where}: needs a template_name")
    scale = table.vector("non_uniform_scale", (1.0, 1.0, 1.0)) * table.number("uniform_scale", 1.0)
    if not scale.all() or np.abs(scale).max() > MAX_SCALE:
        raise ValueError(
            f"{table.where}: scale must not be zero nor above {MAX_SCALE:g}, got {scale.tolist()}"
        )
    translation = table.vector("translation", (0.0, 0.0, 0.0))
    if np.abs(translation).max() > MAX_DISTANCE_M:
        raise table.wrong("translation", f"within {MAX_DISTANCE_M:g} m of the origin")
    if (scale < 0.0).any():
        log.note("instances mirrored by a negative scale")
    return Instance(
        template_name=name,
        translation=translation,
        rotation=_rotation(table, log),
        scale=scale,
        com_origin=_com_origin(table, default=com_origin),
        visible=table.flag("is_instance_visible", default=True),
        joints=_joints(table),
    )


def _rotation(table: Table, log: ImportLog) -> FloatArray:
    """The rotation, normalised.

    Raises:
        ValueError: It has no direction.
    """
    rotation = table.vector("rotation", (1.0, 0.0, 0.0, 0.0))
    length = float(np.linalg.norm(rotation))
    if length < _UNIT_TOLERANCE:
        raise table.wrong("rotation", "a quaternion wxyz of length 1")
    if abs(length - 1.0) > _UNIT_TOLERANCE:
        log.note("rotations that were not of length 1, normalised")
    return rotation / length


def _com_origin(table: Table, *, default: bool) -> bool:
    """Whether translations are of the centre of mass; texts that mean neither are the default."""
    origin = table.text("translation_origin").lower()
    return {"com": True, "asset_local": False}.get(origin, default)


def _joints(table: Table) -> Mapping[str, float] | tuple[float, ...]:
    given = table.values.get("initial_joint_pose", ())
    if isinstance(given, Mapping):
        joints = Table(given, f"{table.where}: initial_joint_pose")
        return {name: joints.number(name, 0.0) for name in given}
    if not isinstance(given, list | tuple):
        raise table.wrong("initial_joint_pose", "a list or a table of numbers")
    return tuple(float(x) for x in table.vector("initial_joint_pose", (0.0,) * len(given)))
