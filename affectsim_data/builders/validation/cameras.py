"""Whether cameras stand in free space, and what is stored of their views is right."""

from __future__ import annotations

import functools

import numpy as np
import shapely

from affectsim_data.affordances import rooms_of
from affectsim_data.builders.validation.challenges import signed_bearings_deg
from affectsim_data.builders.validation.findings import Measure
from affectsim_data.builders.validation.part import Part
from affectsim_data.builders.validation.shares import seen
from affectsim_data.builders.validation.surfaces import scene_surface
from affectsim_data.builders.validation.tracks import placed
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Doorway, Scene

__all__ = ["check_cameras"]

CLEARANCE_M = 0.05
"""Least distance of a camera to any surface: nothing of a scene is drawn nearer."""
_ASKED_M = 0.1
PEOPLE_M = 0.15
"""Least distance of a camera to anybody's skin: the robot's head, and thrice the near plane."""
SHARE, DISTANCE_M, BEARING_DEG = 0.01, 1e-6, 0.01
"""How far stored shares, distances and bearings may be off."""
CLOSING_M = 0.1
"""How much longer than all others the step from the last knot to the first may be."""
VIEWS = ("init", "ref", "mon")


def check_cameras(part: Part) -> list[Measure]:
    """Clearance, rooms and views of p_init, p_ref and p_mon."""
    distance = np.linalg.norm(part.start - part.anchor, axis=1)
    bearing = signed_bearings_deg(part) - part.episodes.number("initial_bearing_deg")
    distance_off = np.abs(distance - part.episodes.number("initial_distance_m"))
    bearing_off = np.abs((bearing + 180.0) % 360.0 - 180.0)
    measures = [
        part.measure("initial_distance", distance_off, high=DISTANCE_M),
        part.measure("initial_bearing", bearing_off, high=BEARING_DEG),
    ]
    for view in VIEWS:
        stored = part.episodes.number(f"visible_share_{view}")
        off = np.abs(seen(part, view).share - stored)
        measures.append(part.measure(f"share_{view}", off, high=SHARE))
    return [*measures, *_positions(part), _people(part), _monitor_room(part), _closes(part)]


def _positions(part: Part) -> list[Measure]:
    """Every place of every camera: distance to surfaces, rooms, solids."""
    points = {
        "init": part.views["init"][:, 0, :3, 3],
        "ref": np.concatenate([_along(knots) for knots in part.knots]),
        "mon": part.views["mon"][:, 0, :3, 3],
    }
    owner = {
        "ref": np.repeat(np.arange(len(part)), [2 * len(knots) for knots in part.knots]),
    }
    surface = scene_surface(part.scene)
    measures, outside, inside = [], np.zeros(len(part)), np.zeros(len(part))
    for view in VIEWS:
        places = owner.get(view, np.arange(len(part)))
        unique, index = np.unique(points[view], axis=0, return_inverse=True)
        index = index.reshape(-1)
        gaps = np.full(len(part), _ASKED_M)
        np.minimum.at(gaps, places, surface.distance(unique, limit=_ASKED_M)[index])
        measures.append(part.measure(f"clear_{view}", gaps, low=CLEARANCE_M))
        np.add.at(outside, places, ~_in_rooms(part.scene, unique)[index])
        np.add.at(inside, places, surface.inside(unique)[index])
    return [
        *measures,
        part.measure("cameras_in_rooms", outside, high=0),
        part.measure("cameras_not_inside", inside, high=0),
    ]


def _along(knots: FloatArray) -> FloatArray:
    """Knots of a closed trajectory and the middles between them, `(2 n, 3)`."""
    places = knots[:, :3]
    return np.concatenate([places, (places + np.roll(places, -1, axis=0)) / 2.0])


def _in_rooms(scene: Scene, points: FloatArray) -> np.ndarray:
    """Whether points `(n, 3)` are in a room or the hole between two, `(n,)`."""
    low, high = min(r.floor_y for r in scene.rooms), max(r.ceiling_y for r in scene.rooms)
    inside = shapely.contains_xy(_floor(scene), points[:, 0], points[:, 2])
    return np.asarray(inside & (points[:, 1] >= low) & (points[:, 1] <= high))


@functools.lru_cache(maxsize=2)
def _floor(scene: Scene) -> shapely.Geometry:
    rooms = [shapely.Polygon(room.polygon) for room in scene.rooms]
    floor = shapely.union_all([*rooms, *map(_threshold, scene.doorways)])
    shapely.prepare(floor)
    return floor


def _threshold(doorway: Doorway) -> shapely.Polygon:
    """A doorway on the plan, a little deeper than the wall, so that rooms join."""
    half = np.array([doorway.width, doorway.depth + 0.02]) / 2.0
    corners = half * [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
    yaw = np.radians(doorway.yaw_deg)
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    middle = np.array([doorway.position[0], doorway.position[2]])
    return shapely.Polygon(middle + corners @ turn)


def _people(part: Part) -> Measure:
    """Nearest point of anybody's skin to a camera, metres."""
    nearest = np.full(len(part), np.inf)
    rows = np.array(list(part.partner_tracks), np.intp)
    bodies = [(np.arange(len(part)), part.surface)]
    if len(rows):
        skins = np.stack([track.surface for track in part.partner_tracks.values()])
        bodies.append((rows, placed(part.partner_pose[rows], skins)))
    for view in VIEWS:
        eyes = part.views[view][..., :3, 3]
        for which, skin in bodies:
            gaps = np.linalg.norm(skin - eyes[which][:, :, None], axis=-1).min(axis=(1, 2))
            nearest[which] = np.minimum(nearest[which], gaps)
    return part.measure("clear_people", nearest, low=PEOPLE_M)


def _monitor_room(part: Part) -> Measure:
    rooms = rooms_of(part.scene, part.anchor)
    monitors = rooms_of(part.scene, part.episodes.point("monitor"))
    other = (rooms != monitors) | (rooms < 0)
    return part.measure("monitor_room", other.astype(np.float64), high=0)


def _closes(part: Part) -> Measure:
    """How much longer the step from the last knot to the first is than all others, metres."""
    beyond = np.zeros(len(part))
    for place, knots in enumerate(part.knots):
        steps = np.linalg.norm(np.roll(knots[:, :3], -1, axis=0) - knots[:, :3], axis=1)
        beyond[place] = max(0.0, steps[-1] - steps[:-1].max(initial=0.0))
    return part.measure("reference_closes", beyond, high=CLOSING_M)
