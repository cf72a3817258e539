"""A scene made ready for placing, and what becomes of a slot in it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING

from affectsim_data.builders.monitors import Monitor, plan_monitor
from affectsim_data.builders.placement.floor_grid import FloorGrid
from affectsim_data.builders.recipes import Recipe
from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray
from affectsim_data.releases.rows import navmesh_sha256
from affectsim_data.scenes import Scene
from affectsim_data.visibility import RayCaster, scene_caster

if TYPE_CHECKING:
    from affectsim_data.builders.placement.pools import Pool

__all__ = ["Placement", "Stage", "Unplaced"]


@dataclasses.dataclass(frozen=True, eq=False)
class Stage:
    """A scene made ready for composing: its rays, navmesh and monitors."""

    scene: Scene
    navmesh: NavMesh
    caster: RayCaster
    monitors: dict[str, Monitor]
    """By room."""
    navmesh_sha256: str
    """Hash of the navmesh's bytes."""
    floor: FloorGrid
    """How much room there is around points of the largest island."""
    pools: dict[tuple[str, str | None], Pool] = dataclasses.field(default_factory=dict, repr=False)
    """Candidates by kind of placement and challenge, made when first asked for."""

    @classmethod
    def prepare(cls, scene: Scene, navmesh: NavMesh, recipe: Recipe) -> Stage:
        """Rays and monitors of a scene."""
        caster = scene_caster(scene)
        monitors = {room.room_id: plan_monitor(room, recipe.camera, caster) for room in scene.rooms}
        floor = FloorGrid.of_island(navmesh.islands[0])
        return cls(scene, navmesh, caster, monitors, navmesh_sha256(navmesh), floor)

    @classmethod
    def stored(cls, scene_id: str, glb: bytes, navmesh: bytes, recipe: Recipe) -> Stage:
        """The same of a scene as a release stores it."""
        scene = Scene.from_glb(glb, name=scene_id)
        return cls.prepare(scene, NavMesh.from_bytes(navmesh, name=scene_id), recipe)


@dataclasses.dataclass(frozen=True)
class Placement:
    """p_h and x0 in a scene."""

    anchor: FloatArray
    """`(3,)`, metres."""
    facing: float
    """Radians."""
    start: FloatArray
    """`(3,)`, metres."""
    start_yaw: float
    """Radians."""
    room_id: str
    """The performer's room."""
    support: str | None = None
    """Seat or door the action is aligned with, as `Episode.support`."""


@dataclasses.dataclass(frozen=True)
class Unplaced:
    """A slot without a placement in a scene."""

    key: str
    """Of the slot."""
    constraint: str
    """The constraint at which the last candidates were lost."""
    survivors: Mapping[str, int]
    """Candidates left after each constraint, in order."""
