"""Whether robots start where they can go, away from everybody's way, and d* is what it must be."""

from __future__ import annotations

import math

import numpy as np

from affectsim_data.affordances import clearance
from affectsim_data.builders.validation.findings import Measure
from affectsim_data.builders.validation.part import Part
from affectsim_data.episodes import RING_DISTANCES_M
from affectsim_data.poses import FloatArray, transform_points

__all__ = ["check_navigation", "off_island"]

OFF_MESH_M = 0.01
"""A start may be off the navmesh by: rounding, no more."""
APART_M = 0.45
"""Between the start and anybody's pelvis in every frame: the robot's radius and half a body."""
D_STAR_M = 1e-6


def check_navigation(part: Part) -> list[Measure]:
    """Starts, ways of people, and d* of the sampled episodes."""
    offset = np.array([off_island(part, point) for point in part.start])
    return [
        part.measure("start_navigable", offset, high=OFF_MESH_M),
        part.measure("start_clear", _start_gaps(part), low=APART_M),
        _ways(part),
        _d_star(part),
    ]


def off_island(part: Part, point: FloatArray) -> float:
    """Distance to the largest island, metres."""
    island = part.navmesh.islands[0]
    on_floor = island.on_floor(island.nearest(point[None, [0, 2]]))[0]
    return float(math.dist(on_floor, point))


def _people_ways(part: Part, place: int) -> list[FloatArray]:
    """Floor under the pelvises of everybody in an episode, world, `(num_frames, 3)` each."""
    people = [(part.tracks[place], part.pose[place])]
    if place in part.partner_tracks:
        people.append((part.partner_tracks[place], part.partner_pose[place]))
    ways = [transform_points(pose, track.pelvis) for track, pose in people]
    for way, (_, pose) in zip(ways, people, strict=True):
        way[:, 1] = pose[1, 3]
    return ways


def _start_gaps(part: Part) -> FloatArray:
    """On the plan, between the start and the nearest place of a pelvis, metres, `(n,)`."""
    gaps = np.empty(len(part))
    for place in range(len(part)):
        ways = np.concatenate(_people_ways(part, place))
        gaps[place] = np.hypot(*(ways - part.start[place])[:, [0, 2]].T).min()
    return gaps


def _ways(part: Part) -> Measure:
    """Free disc around the pelvis of whoever stands or walks on the floor, in every frame."""
    on_floor = ~np.isin(part.kinds.astype(str), ["seat", "before_seat"])
    ways, owner = [], []
    for place in map(int, np.flatnonzero(on_floor)):
        for way in _people_ways(part, place):
            ways.append(way)
            owner.append(np.full(len(way), place))
    free = np.full(len(part), np.inf)
    if ways:
        np.minimum.at(free, np.concatenate(owner), clearance(part.navmesh, np.concatenate(ways)))
    least = part.navmesh.settings.agent_radius
    return part.measure("way_clear", free, where=on_floor, low=least)


def _d_star(part: Part) -> Measure:
    """The largest difference over the rings; infinite where one is null and the other not."""
    sampled = np.array([one in part.sampled for one in part.ids], bool)
    differences, notes = np.zeros(len(part)), [""] * len(part)
    known: dict[bytes, list[float | str]] = {}
    for place in np.flatnonzero(sampled):
        ends = np.concatenate([part.start[place], part.anchor[place]])
        found = known.setdefault(ends.tobytes(), [])
        if not found:
            found += [_ring(part, int(place), ring) for ring in RING_DISTANCES_M]
        stored = [_stored(part, int(place), ring) for ring in RING_DISTANCES_M]
        gaps = [_difference(one, two) for one, two in zip(stored, found, strict=True)]
        worst = int(np.argmax(gaps))
        differences[place] = gaps[worst]
        if gaps[worst] > D_STAR_M:
            ring = RING_DISTANCES_M[worst]
            notes[place] = f"d*({ring} m) is {stored[worst]}, on the navmesh {found[worst]}"
    return part.measure("d_star", differences, where=sampled, high=D_STAR_M, notes=tuple(notes))


def _ring(part: Part, place: int, ring: int) -> float | str:
    try:
        length = part.navmesh.ring_distance(part.start[place], part.anchor[place], float(ring))
    except ValueError:
        return "off the navmesh"
    if math.isnan(length):
        return "empty"
    return "unreachable" if math.isinf(length) else length


def _stored(part: Part, place: int, ring: int) -> float | str:
    length = float(part.episodes.number(f"d_star_{ring}m")[place])
    return str(part.episodes.text(f"d_star_{ring}m_null")[place]) if math.isnan(length) else length


def _difference(one: float | str, two: float | str) -> float:
    if isinstance(one, str) or isinstance(two, str):
        return 0.0 if one == two else math.inf
    return abs(one - two)
