"""Where a robot can go in a scene: distances, shortest ways and moves on its floor."""

from __future__ import annotations

import dataclasses
import functools
import math
import re
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import ArrayLike

from affectsim_data.navmesh.build import build_islands
from affectsim_data.navmesh.islands import Island
from affectsim_data.navmesh.rasterize import BoolArray, IntArray
from affectsim_data.navmesh.rings import Ring, ring_distance
from affectsim_data.navmesh.roadmap import Roadmap, Sight
from affectsim_data.navmesh.settings import Settings
from affectsim_data.navmesh.storage import pack, unpack
from affectsim_data.poses import FloatArray

__all__ = ["NavMesh", "StepResult"]

# Largest distance of a start or goal to the navmesh, metres.
SNAP_TOLERANCE_M = 0.1
# habitat-sim's rule for a collision; square metres.
CLIP_SLACK_M2 = 1e-5


@dataclasses.dataclass(frozen=True)
class StepResult:
    """Where a move ended."""

    position: FloatArray
    """On the floor, metres, `(3,)`."""
    clipped: bool
    """Whether it ended early: `|moved|^2 + 1e-5 < |asked|^2`, on the plan."""


@dataclasses.dataclass(frozen=True, eq=False)
class NavMesh:
    """The floor an agent can stand on, as islands it cannot change between.

    Points are `(3,)`, Y up, metres, or `(n, 3)` where a method says so. A point may lie up to 0.1 m
    off the mesh and is then snapped; farther off is a `ValueError`. Shortest ways are exact on the
    polygons; lengths are 3-D along the floor at the bends, which on a level floor is horizontal.
    """

    settings: Settings
    """What it was built for."""
    islands: tuple[Island, ...]
    """Connected parts, largest first."""
    mesh_sha256: str = ""
    """Hash of the mesh it was built from, hexadecimal; empty if unknown."""

    def __post_init__(self) -> None:
        if not self.islands:
            raise ValueError("a navmesh needs at least one island")
        if not re.fullmatch(r"([0-9a-f]{64})?", self.mesh_sha256):
            raise ValueError(f"mesh_sha256 must be 64 hex digits, got {self.mesh_sha256!r}")

    @classmethod
    def from_mesh(
        cls,
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        agent_radius: float = 0.3,
        agent_height: float = 1.5,
        max_climb: float = 0.2,
        max_slope_deg: float = 45.0,
        cell_size: float = 0.05,
        cell_height: float = 0.05,
        mesh_sha256: str = "",
    ) -> NavMesh:
        """Builds the navmesh of a scene as Recast does: voxels, filters, erosion, outlines.

        Args:
            vertices: Metres, Y up, `(n, 3)`.
            faces: Triangles, counter-clockwise from outside, `(m, 3)`.
            agent_radius: Distance kept from walls, metres, rounded up to cells.
            agent_height: Free height an agent needs, metres.
            max_climb: Highest step, metres, rounded down to levels.
            max_slope_deg: Steepest floor.
            cell_size: Side of a grid column, metres.
            cell_height: Height of a grid level, metres.
            mesh_sha256: Hash of the mesh, kept with the result.

        Raises:
            ValueError: A malformed mesh or setting, no walkable surface, or storeys that overlap
                and are joined by a walkable way.
        """
        settings = Settings(
            agent_radius, agent_height, max_climb, max_slope_deg, cell_size, cell_height
        )
        return cls(settings, build_islands(vertices, faces, settings), mesh_sha256)

    @functools.cached_property
    def area_m2(self) -> float:
        """Area of all islands on the plan, square metres."""
        return float(sum(self.island_areas_m2))

    @property
    def island_areas_m2(self) -> tuple[float, ...]:
        """Area of each island on the plan, square metres."""
        return tuple(float(island.polygon.area) for island in self.islands)

    @property
    def polygons(self) -> tuple[shapely.Polygon, ...]:
        """Each island seen from above, `(x, z)`, metres, with holes."""
        return tuple(island.polygon for island in self.islands)

    def snap(self, point: ArrayLike, *, max_offset: float = SNAP_TOLERANCE_M) -> FloatArray:
        """The nearest points of the mesh, `(3,)` or `(n, 3)` like `point`.

        Raises:
            ValueError: A point is farther off the mesh than `max_offset`, metres.
        """
        points = _points(point)
        snapped, _ = self._snapped(points, max_offset)
        return snapped.reshape(np.shape(point))

    def island(self, point: ArrayLike) -> int:
        """Index of the island nearest to a point, `(3,)`; 0 is the largest."""
        return int(self._snapped(_point(point))[1][0])

    def is_navigable(self, point: ArrayLike, max_offset: float = SNAP_TOLERANCE_M) -> bool:
        """Whether a point, `(3,)`, lies within `max_offset` metres of the mesh."""
        return bool(self.navigable(_point(point), max_offset)[0])

    def navigable(self, points: ArrayLike, max_offset: float = SNAP_TOLERANCE_M) -> BoolArray:
        """Whether points, `(n, 3)`, lie within `max_offset` metres of the mesh, `(n,)`."""
        nearest, _ = self._nearest(_points(points))
        near: BoolArray = np.linalg.norm(nearest - _points(points), axis=1) <= max_offset
        return near

    def random_points(self, n: int, rng: np.random.Generator) -> FloatArray:
        """Points uniform over the area of all islands, `(n, 3)`."""
        share = np.array(self.island_areas_m2) / self.area_m2
        which = rng.choice(len(self.islands), size=n, p=share)
        points = np.empty((n, 3))
        for number, island in enumerate(self.islands):
            member = which == number
            plan = island.random_plan_points(int(member.sum()), rng)
            points[member] = island.on_floor(plan)
        return points

    def distance_to_wall(self, points: ArrayLike) -> FloatArray:
        """Horizontal distance to the edge of the island, metres, `()` or `(n,)` like `points`."""
        snapped, which = self._snapped(_points(points))
        distance = np.empty(len(snapped))
        for number in np.unique(which):
            member = which == number
            distance[member] = self.islands[number].wall_distance(snapped[member][:, [0, 2]])
        return distance.reshape(np.shape(points)[:-1])

    def geodesic_distance(self, start: ArrayLike, end: ArrayLike) -> float:
        """Length of the shortest way between two points, `(3,)`, metres; `inf` if there is none."""
        return float(self.geodesic_distances(_point(start), _point(end))[0])

    def geodesic_distances(self, starts: ArrayLike, ends: ArrayLike) -> FloatArray:
        """Lengths of shortest ways, metres, `(n,)`; `inf` where there is none.

        Args:
            starts: `(n, 3)`, or `(3,)` for one start with many ends.
            ends: `(n, 3)`, or `(3,)`.
        """
        start, start_island = self._snapped(_points(starts))
        end, end_island = self._snapped(_points(ends))
        shape = np.broadcast_shapes(start.shape, end.shape)
        distance = np.full(shape[0], np.inf)
        from_, to = (np.broadcast_to(np.arange(len(p)), shape[0]) for p in (start, end))
        for number in np.unique(start_island):
            pair = (start_island[from_] == number) & (end_island[to] == number)
            distance[pair] = self._island_distances(number, start, from_[pair], end, to[pair])
        return distance

    def shortest_path(self, start: ArrayLike, end: ArrayLike) -> FloatArray | None:
        """Corners of the shortest way between two points, both included, `(n, 3)`, metres.

        `None` if there is no way.
        """
        (a, b), (island_a, island_b) = self._snapped(np.concatenate([_point(start), _point(end)]))
        if island_a != island_b:
            return None
        if not self.islands[island_a].walls.blocked(a[None, [0, 2]], b[None, [0, 2]])[0]:
            return np.stack([a, b])
        roadmap = self._roadmap(int(island_a))
        _, first, last = roadmap.through(*roadmap.sights(np.stack([a, b])))
        return np.concatenate([a[None], roadmap.corner_chain(first, last), b[None]])

    def ring_distance(
        self, start: ArrayLike, anchor: ArrayLike, distance: float, tolerance: float = 0.1
    ) -> float:
        """Length of the shortest way to a point p with `| |p - anchor| - distance | <= tolerance`.

        Args:
            start: On the mesh, `(3,)`.
            anchor: Anywhere, usually on the floor, `(3,)`.
            distance: Radius of the ring in 3-D, metres.
            tolerance: Half its width, metres.

        Returns:
            Metres; 0 if `start` is on the ring, `inf` if the ring is on other islands only, and
            `nan` if it is nowhere on the mesh.

        Raises:
            ValueError: `start` is off the mesh, or a number is not finite or negative.
        """
        for name, value in (("distance", distance), ("tolerance", tolerance)):
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"{name} must be at least 0 m, got {value}")
        ring = Ring(_point(anchor)[0], distance - tolerance, distance + tolerance)
        snapped, which = self._snapped(_point(start))
        if ring.meets(self.islands[which[0]]):
            return ring_distance(self._roadmap(int(which[0])), snapped[0], ring)
        return math.inf if any(ring.meets(island) for island in self.islands) else math.nan

    def step(self, start: ArrayLike, end: ArrayLike, *, sliding: bool = False) -> StepResult:
        """Moves towards `end`, `(3,)`, whose height does not matter, and stops at walls.

        Args:
            start: On the mesh, `(3,)`.
            end: Where the move would end without walls, `(3,)`.
            sliding: Move on along the wall, to the point nearest to `end` that can be reached
                within half the length of the move around its middle, as Detour does.
        """
        snapped, which = self._snapped(_point(start))
        island = self.islands[which[0]]
        source, target = snapped[0, [0, 2]], _point(end)[0, [0, 2]]
        share = island.walls.first_hit(source, target)
        reached = source + share * (target - source)
        if share < 1.0 and sliding:
            reached = _slide(island, source, target)
        reached = island.nearest(reached[None])
        moved2 = float(np.sum((reached[0] - source) ** 2))
        clipped = moved2 + CLIP_SLACK_M2 < float(np.sum((target - source) ** 2))
        return StepResult(island.on_floor(reached)[0], clipped)

    def to_bytes(self) -> bytes:
        """A compact form without pickle; equal meshes give equal bytes."""
        return pack(self.settings, self.mesh_sha256, self.islands)

    @classmethod
    def from_bytes(cls, payload: bytes, *, name: str) -> NavMesh:
        """Reads what `to_bytes` wrote; the copy answers exactly alike.

        Raises:
            ValueError: Not a navmesh; the message starts with `name`.
        """
        settings, mesh_sha256, islands = unpack(payload, name=name)
        try:
            return cls(settings, islands, mesh_sha256)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from error

    def save(self, path: str | Path) -> None:
        """Writes `to_bytes` to a file."""
        Path(path).write_bytes(self.to_bytes())

    @classmethod
    def load(cls, path: str | Path) -> NavMesh:
        """Reads a file written by `save`."""
        return cls.from_bytes(Path(path).read_bytes(), name=str(path))

    @functools.cached_property
    def _roadmaps(self) -> dict[int, Roadmap]:
        return {}

    def _roadmap(self, number: int) -> Roadmap:
        if number not in self._roadmaps:
            self._roadmaps[number] = Roadmap.on(self.islands[number])
        return self._roadmaps[number]

    def _nearest(self, points: FloatArray) -> tuple[FloatArray, IntArray]:
        """Nearest point of the mesh and its island, for points `(n, 3)`."""
        best = np.full(len(points), np.inf)
        nearest, which = np.empty_like(points), np.zeros(len(points), np.int64)
        for number, island in enumerate(self.islands):
            found = island.on_floor(island.nearest(points[:, [0, 2]]))
            offset = np.linalg.norm(found - points, axis=1)
            closer = offset < best
            best = np.where(closer, offset, best)
            nearest[closer], which[closer] = found[closer], number
        return nearest, which

    def _snapped(
        self, points: FloatArray, max_offset: float = SNAP_TOLERANCE_M
    ) -> tuple[FloatArray, IntArray]:
        nearest, which = self._nearest(points)
        offset = np.linalg.norm(nearest - points, axis=1)
        far = np.flatnonzero(offset > max_offset)
        if len(far):
            point = ", ".join(f"{value:.3f}" for value in points[far[0]])
            raise ValueError(
                f"point ({point}) is {offset[far[0]]:.3f} m off the navmesh, "
                f"more than {max_offset:g} m"
            )
        return nearest, which

    def _island_distances(
        self, number: int, start: FloatArray, from_: IntArray, end: FloatArray, to: IntArray
    ) -> FloatArray:
        """Lengths of shortest ways on one island between pairs of indices, `(n,)`."""
        blocked = self.islands[number].walls.blocked(start[from_][:, [0, 2]], end[to][:, [0, 2]])
        distance: FloatArray = np.linalg.norm(start[from_] - end[to], axis=1)
        hidden = np.flatnonzero(blocked)
        if len(hidden):
            roadmap = self._roadmap(number)
            near = _sights(roadmap, start, from_[hidden])
            far = _sights(roadmap, end, to[hidden])
            distance[hidden] = [
                roadmap.through(near[i], far[j])[0]
                for i, j in zip(from_[hidden].tolist(), to[hidden].tolist(), strict=True)
            ]
        return distance


def _sights(roadmap: Roadmap, points: FloatArray, index: IntArray) -> dict[int, Sight]:
    used = np.unique(index)
    return dict(zip(used.tolist(), roadmap.sights(points[used]), strict=True))


def _slide(island: Island, source: FloatArray, target: FloatArray) -> FloatArray:
    """The point nearest to `target` that a move can reach, `(2,)`."""
    middle, half = (source + target) / 2.0, float(np.linalg.norm(target - source)) / 2.0
    disc = shapely.Point(*middle).buffer(half, quad_segs=32)
    parts = shapely.get_parts(shapely.intersection(island.polygon, disc))
    parts = [part for part in parts if part.area > 0.0]
    if not parts:
        return source
    here = min(parts, key=lambda part: float(part.distance(shapely.Point(*source))))
    line = shapely.shortest_line(here, shapely.Point(*target))
    reached: FloatArray = shapely.get_coordinates(line)[0]
    return reached


def _point(point: ArrayLike) -> FloatArray:
    array = np.asarray(point, np.float64)
    if array.shape not in ((3,), (1, 3)):
        raise ValueError(f"a point must be (3,), got {array.shape}")
    return _points(array)


def _points(points: ArrayLike) -> FloatArray:
    array = np.asarray(points, np.float64)
    if array.ndim not in (1, 2) or array.shape[-1] != 3:
        raise ValueError(f"points must be (3,) or (n, 3), got {array.shape}")
    if not np.all(np.isfinite(array)):
        raise ValueError(f"points must be finite, got {array}")
    return array.reshape(-1, 3)
