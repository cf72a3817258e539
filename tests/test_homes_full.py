"""Every third of the 57 homes of the full release: a robot gets everywhere.

With AFFECTSIM_EVERY_HOME=1 all of them, some minutes. Run as a script, it measures some of them and
prints the findings as JSON:

    python tests/test_homes_full.py FIRST STEP
"""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys

import numpy as np
import pytest
import shapely
from furniture_laws import crossing_meshes, overlapping_boxes

from affectsim_data.builders.homes import HomeRecipe, build_home, design_home, home_recipes
from affectsim_data.content import content_path
from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Scene
from affectsim_data.visibility import RayCaster

RECIPES = home_recipes(content_path("builders", "homes-full.toml"))
FLOOR_M = 0.1
"""Islands below are floor; others are the tops of tables."""


@dataclasses.dataclass(frozen=True)
class Finding:
    """What is measured of one home."""

    scene_id: str
    num_rooms: int
    area_m2: float
    num_triangles: int
    num_seats: int
    main_share: float
    """Of the floor that a robot fits on, in its largest island."""
    rooms_missed: tuple[str, ...]
    """Rooms of which the largest island has less than a robot needs to turn."""
    doorways_blocked: tuple[tuple[str, str], ...]
    doors_blocked: tuple[str, ...]
    """Rooms of closed doors that one cannot stand before."""
    rays_escaped: int
    overlaps: tuple[tuple[str, str], ...]
    """Pieces of furniture whose boxes overlap by more than 1 cm."""
    crossings: tuple[tuple[str, str], ...]
    """Pieces of furniture that go through each other."""


def measure(recipe: HomeRecipe) -> Finding:
    """Builds a home without light and drives through it."""
    scene = build_home(recipe, rng=np.random.default_rng(recipe.seed), lit=False)
    placed = design_home(recipe, rng=np.random.default_rng(recipe.seed)).furnishing.placed
    vertices, faces = scene.mesh()
    navmesh = NavMesh.from_mesh(vertices, faces, agent_radius=0.3, agent_height=1.5, cell_size=0.05)
    floor = [
        polygon
        for island, polygon in zip(navmesh.islands, navmesh.polygons, strict=True)
        if island.median_y < FLOOR_M
    ]
    rooms = {room.room_id: shapely.Polygon(room.polygon) for room in scene.rooms}
    return Finding(
        scene_id=scene.scene_id,
        num_rooms=len(scene.rooms),
        area_m2=sum(polygon.area for polygon in rooms.values()),
        num_triangles=scene.num_triangles,
        num_seats=len(scene.seats),
        main_share=floor[0].area / sum(polygon.area for polygon in floor),
        rooms_missed=tuple(
            name for name, room in rooms.items() if floor[0].intersection(room).area < 0.1
        ),
        doorways_blocked=_doorways_blocked(scene, navmesh),
        doors_blocked=tuple(
            door.room_id
            for door in scene.doors
            if door.is_closed
            and not floor[0].contains(
                shapely.Point(_before(door.knock_point, door.yaw_deg, 0.6)[[0, 2]])
            )
        ),
        rays_escaped=_rays_escaped(scene, RayCaster(vertices, faces)),
        overlaps=tuple(overlapping_boxes(placed)),
        crossings=tuple(crossing_meshes(placed)),
    )


def _before(point: tuple[float, float, float], yaw_deg: float, distance: float) -> FloatArray:
    """The floor some way before a point, `(3,)`."""
    yaw = np.radians(yaw_deg)
    way = np.array([np.sin(yaw), 0.0, np.cos(yaw)])
    return np.asarray(np.array([point[0], 0.0, point[2]]) + distance * way)


def _doorways_blocked(scene: Scene, navmesh: NavMesh) -> tuple[tuple[str, str], ...]:
    """Doorways through which a robot does not drive straight."""
    blocked = []
    for doorway in scene.doorways:
        ends = [_before(doorway.position, doorway.yaw_deg, way) for way in (-0.4, 0.0, 0.4)]
        free = all(navmesh.is_navigable(end) for end in ends)
        if not free or navmesh.geodesic_distance(ends[0], ends[2]) > 0.9:
            blocked.append(doorway.room_ids)
    return tuple(blocked)


def _rays_escaped(scene: Scene, caster: RayCaster) -> int:
    rng, count = np.random.default_rng(3), 4000
    escaped = 0
    for room in scene.rooms:
        low, high = np.min(room.polygon, axis=0), np.max(room.polygon, axis=0)
        plan = rng.uniform(low + 0.02, high - 0.02, (count, 2))
        heights = rng.uniform(0.05, room.ceiling_y - 0.05, count)
        directions = rng.normal(size=(count, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        starts = np.stack([plan[:, 0], heights, plan[:, 1]], axis=1)
        escaped += int((caster.distance(starts, directions) > 40.0).sum())
    return escaped


def check(findings: list[Finding]) -> None:
    """Every promise of every home, told together."""
    wrong = [
        f"{one.scene_id}: {what}"
        for one in findings
        for what, holds in {
            f"{one.num_rooms} rooms": 2 <= one.num_rooms <= 7,
            f"{one.area_m2:.1f} m2": 40.0 <= one.area_m2 <= 180.0,
            f"{one.num_triangles} triangles": 60_000 <= one.num_triangles <= 250_000,
            f"{one.num_seats} seats": one.num_seats >= 3,
            f"largest island has {one.main_share:.3f}": one.main_share >= 0.95,
            f"rooms not reached: {one.rooms_missed}": not one.rooms_missed,
            f"doorways blocked: {one.doorways_blocked}": not one.doorways_blocked,
            f"doors blocked: {one.doors_blocked}": not one.doors_blocked,
            f"{one.rays_escaped} rays escaped": not one.rays_escaped,
            f"furniture overlaps: {one.overlaps}": not one.overlaps,
            f"furniture crosses: {one.crossings}": not one.crossings,
        }.items()
        if not holds
    ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.slow
def test_a_robot_gets_everywhere() -> None:
    step = 1 if os.environ.get("AFFECTSIM_EVERY_HOME") == "1" else 3
    processes = [
        subprocess.Popen(
            [sys.executable, __file__, str(first), str(2 * step)], stdout=subprocess.PIPE
        )
        for first in (0, step)
    ]
    printed = [process.communicate()[0] for process in processes]
    assert [process.returncode for process in processes] == [0, 0]
    findings = [Finding(**one) for text in printed for one in json.loads(text)]
    assert len(findings) == len(RECIPES[::step])
    check(findings)


def main(first: int, step: int) -> None:
    """Prints the findings of every `step`-th home."""
    print(json.dumps([dataclasses.asdict(measure(recipe)) for recipe in RECIPES[first::step]]))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
