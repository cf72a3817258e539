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
from affectsim_data.navmesh.locating import (
    SNAP_TOLERANCE_M,
    Point,
    checked_point,
    checked_points,
    nearest_point,
    nearest_points,
    off_mesh,
    plan_region,
    random_plan_points,
    snapped_points,
)
from affectsim_data.navmesh.moves import StepResult, moved, was_clipped
from affectsim_data.navmesh.rasterize import BoolArray, IntArray
from affectsim_data.navmesh.rings import Ring, ring_distance, ring_distances
from affectsim_data.navmesh.roadmap import Roadmap
from affectsim_data.navmesh.settings import Settings
from affectsim_data.navmesh.storage import pack, unpack
from affectsim_data.navmesh.ways import pair_lengths
from affectsim_data.poses import FloatArray

__all__ = ["NavMesh", "StepResult"]


@dataclasses.dataclass(frozen=True, eq=False)
class NavMesh:
    """The floor an agent can stand on, as islands it cannot change between.

    Points are `(3,)`, Y up, metres, or `(n, 3)` where a method says so. A point may lie up to 0.1 m
    off the mesh and is then snapped; farther off is a `ValueError`. Shortest ways are exact on the
    plan; their lengths are 3-D along the floor under them, in pieces of at most 0.25 m.
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
        points = checked_points(point)
        snapped, _ = snapped_points(self.islands, points, max_offset)
        return snapped.reshape(np.shape(point))

    def island(self, point: ArrayLike) -> int:
        """Index of the island nearest to a point, `(3,)`; 0 is the largest."""
        return self._here(checked_point(point))[1]

    def island_numbers(self, points: ArrayLike) -> IntArray:
        """Index of the island nearest to each point, `(n, 3)`: `(n,)`; -1 off the mesh."""
        where = checked_points(points)
        nearest, which = nearest_points(self.islands, where)
        off = np.linalg.norm(nearest - where, axis=1) > SNAP_TOLERANCE_M
        return np.where(off, -1, which)

    def is_navigable(self, point: ArrayLike, max_offset: float = SNAP_TOLERANCE_M) -> bool:
        """Whether a point, `(3,)`, lies within `max_offset` metres of the mesh."""
        x, y, z = checked_point(point)
        (near_x, near_y, near_z), _ = nearest_point(self.islands, x, y, z)
        return math.dist((x, y, z), (near_x, near_y, near_z)) <= max_offset

    def navigable(self, points: ArrayLike, max_offset: float = SNAP_TOLERANCE_M) -> BoolArray:
        """Whether points, `(n, 3)`, lie within `max_offset` metres of the mesh, `(n,)`."""
        where = checked_points(points)
        nearest, _ = nearest_points(self.islands, where)
        near: BoolArray = np.linalg.norm(nearest - where, axis=1) <= max_offset
        return near

    def random_points(
        self,
        n: int,
        rng: np.random.Generator,
        *,
        island: int | None = None,
        within: ArrayLike | None = None,
        disc: tuple[ArrayLike, float] | None = None,
    ) -> FloatArray:
        """Points uniform over the area of the mesh, `(n, 3)`.

        Args:
            n: How many.
            rng: Draws them.
            island: Only on this one; on all of them if not given.
            within: Only in this polygon, corners `(x, z)`, `(k, 2)`, such as a room's.
            disc: Only around a point, `(3,)`, up to a distance on the plan, metres.

        Raises:
            ValueError: There is no such island, or none of it lies there.
        """
        chosen = range(len(self.islands)) if island is None else [self._number(island)]
        if within is None and disc is None:
            parts = [self.polygons[number] for number in chosen]
        else:
            region = plan_region(within, disc)
            parts = [shapely.intersection(self.polygons[number], region) for number in chosen]
        plan, which = random_plan_points(parts, n, rng, disc=disc)
        points = np.empty((n, 3))
        for place, number in enumerate(chosen):
            points[which == place] = self.islands[number].on_floor(plan[which == place])
        return points

    def distance_to_wall(self, points: ArrayLike) -> FloatArray:
        """Horizontal distance to the edge of the island, metres, `()` or `(n,)` like `points`.

        What an agent's middle may not touch: obstacles and drops are the agent's radius farther.
        """
        snapped, which = snapped_points(self.islands, checked_points(points))
        distance = np.empty(len(snapped))
        for number in np.unique(which):
            member = which == number
            distance[member] = self.islands[number].wall_distance(snapped[member][:, [0, 2]])
        return distance.reshape(np.shape(points)[:-1])

    def has_straight_way(self, starts: ArrayLike, ends: ArrayLike) -> BoolArray:
        """Whether an agent can go from starts to ends in a straight line on the plan, `(n,)`.

        Args:
            starts: `(n, 3)`, or `(3,)` for one start with many ends.
            ends: `(n, 3)`, or `(3,)`.
        """
        start, start_island = snapped_points(self.islands, checked_points(starts))
        end, end_island = snapped_points(self.islands, checked_points(ends))
        shape = np.broadcast_shapes(start.shape, end.shape)
        start, end = (
            np.broadcast_to(start, shape)[:, [0, 2]],
            np.broadcast_to(end, shape)[:, [0, 2]],
        )
        which = np.where(start_island == end_island, start_island, -1)
        straight = np.zeros(shape[0], bool)
        for number, island in enumerate(self.islands):
            pair = np.flatnonzero(np.broadcast_to(which == number, shape[:1]))
            straight[pair] = ~island.walls.blocked(start[pair], end[pair])
        return straight

    def geodesic_distance(self, start: ArrayLike, end: ArrayLike) -> float:
        """Length of the shortest way between two points, `(3,)`, metres; `inf` if there is none."""
        (x, _, z), island = self._here(checked_point(start))
        (to_x, _, to_z), other = self._here(checked_point(end))
        if island != other:
            return math.inf
        floor = self.islands[island]
        if not floor.walls.blocks(x, z, to_x, to_z):
            if floor.is_level:
                return math.hypot(to_x - x, to_z - z)
            return float(floor.floor_lengths(np.array([[x, z]]), np.array([[to_x, to_z]]))[0])
        roadmap = self._roadmap(island)
        return roadmap.through(roadmap.sight(x, z), roadmap.sight(to_x, to_z))[0]

    def geodesic_distances(self, starts: ArrayLike, ends: ArrayLike) -> FloatArray:
        """Lengths of shortest ways, metres, `(n,)`; `inf` where there is none.

        Args:
            starts: `(n, 3)`, or `(3,)` for one start with many ends.
            ends: `(n, 3)`, or `(3,)`.
        """
        start, start_island = snapped_points(self.islands, checked_points(starts))
        end, end_island = snapped_points(self.islands, checked_points(ends))
        count = np.broadcast_shapes(start.shape, end.shape)[0]
        one, two = (np.broadcast_to(np.arange(len(p)), count) for p in (start, end))
        return self._pair_lengths(start, start_island, one, end, end_island, two)

    def distance_matrix(self, starts: ArrayLike, ends: ArrayLike) -> FloatArray:
        """Lengths of shortest ways from each start `(n, 3)` to each end `(m, 3)`, `(n, m)`."""
        start, start_island = snapped_points(self.islands, checked_points(starts))
        end, end_island = snapped_points(self.islands, checked_points(ends))
        one, two = (grid.ravel() for grid in np.indices((len(start), len(end))))
        lengths = self._pair_lengths(start, start_island, one, end, end_island, two)
        return lengths.reshape(len(start), len(end))

    def shortest_path(self, start: ArrayLike, end: ArrayLike) -> FloatArray | None:
        """Points of the floor along the shortest way between two points, `(n, 3)`, metres.

        Both ends and every bend, and, where the floor between them rises, points on it at most
        0.25 m apart: the polyline is as long as `geodesic_distance` says. `None` for no way.
        """
        (x, _, z), island = self._here(checked_point(start))
        (to_x, _, to_z), other = self._here(checked_point(end))
        if island != other:
            return None
        bends = np.array([[x, z], [to_x, to_z]])
        floor = self.islands[island]
        if floor.walls.blocks(x, z, to_x, to_z):
            roadmap = self._roadmap(island)
            _, first, last = roadmap.through(roadmap.sight(x, z), roadmap.sight(to_x, to_z))
            bends = np.concatenate([bends[:1], roadmap.corner_chain(first, last), bends[1:]])
        return floor.floor_line(bends)

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
        ring = Ring.around(checked_point(anchor), distance, tolerance)
        (x, _, z), island = self._here(checked_point(start))
        if ring.meets(self.islands[island]):
            return ring_distance(self._roadmap(island), np.array([x, z]), ring)
        return math.inf if any(ring.meets(island) for island in self.islands) else math.nan

    def ring_distances(
        self, starts: ArrayLike, anchor: ArrayLike, distance: float, tolerance: float = 0.1
    ) -> FloatArray:
        """`ring_distance` of many starts, `(n, 3)`, to one anchor, metres, `(n,)`."""
        ring = Ring.around(checked_point(anchor), distance, tolerance)
        snapped, which = snapped_points(self.islands, checked_points(starts))
        met = [ring.meets(island) for island in self.islands]
        lengths = np.full(len(snapped), math.inf if any(met) else math.nan)
        for number in np.unique(which):
            if met[number]:
                member = np.flatnonzero(which == number)
                plan = snapped[member][:, [0, 2]]
                lengths[member] = ring_distances(self._roadmap(int(number)), plan, ring)
        return lengths

    def step(self, start: ArrayLike, end: ArrayLike, *, sliding: bool = False) -> StepResult:
        """Moves towards `end`, `(3,)`, whose height does not matter, and stops at walls.

        The meaning of habitat-sim's `try_step_no_sliding` and, sliding, of its `try_step`, but for
        one thing: where the end lies on or next to another island, habitat-sim does not move at
        all, and here the move ends at the wall as any other.

        Args:
            start: On the mesh, `(3,)`.
            end: Where the move would end without walls, `(3,)`.
            sliding: Move on along the wall, to the point nearest to `end` that can be reached
                within half the length of the move around its middle, as Detour does.
        """
        (x, _, z), number = self._here(checked_point(start))
        to_x, _, to_z = checked_point(end)
        island = self.islands[number]
        new_x, new_z = moved(island, x, z, to_x, to_z, sliding=sliding)
        position = np.array([new_x, island.height_here(new_x, new_z), new_z])
        return StepResult(position, was_clipped(x, z, to_x, to_z, new_x, new_z))

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

    def _number(self, island: int) -> int:
        if not 0 <= island < len(self.islands):
            raise ValueError(f"island must be 0 to {len(self.islands) - 1}, got {island}")
        return island

    def _here(self, point: Point) -> tuple[Point, int]:
        """Nearest point of the mesh and its island, for one point."""
        nearest, which = nearest_point(self.islands, *point)
        offset = math.dist(nearest, point)
        if offset > SNAP_TOLERANCE_M:
            raise off_mesh(np.array(point), offset, SNAP_TOLERANCE_M)
        return nearest, which

    def _pair_lengths(
        self,
        start: FloatArray,
        start_island: IntArray,
        one: IntArray,
        end: FloatArray,
        end_island: IntArray,
        two: IntArray,
    ) -> FloatArray:
        """Lengths of shortest ways between pairs of snapped points, by index, `(n,)`."""
        length = np.full(len(one), np.inf)
        for number in np.unique(start_island).tolist():
            pair = np.flatnonzero((start_island[one] == number) & (end_island[two] == number))
            if len(pair):
                length[pair] = pair_lengths(
                    self._roadmap(number), start[:, [0, 2]], end[:, [0, 2]], one[pair], two[pair]
                )
        return length
