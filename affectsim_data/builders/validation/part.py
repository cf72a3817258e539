"""Episodes of one scene with all they name, as arrays: what the geometric checks work on."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.compositions import PlacementKind
from affectsim_data.builders.recipes import Recipe, Thresholds
from affectsim_data.builders.validation.findings import Measure
from affectsim_data.builders.validation.tables import Columns
from affectsim_data.builders.validation.tracks import Bodies, Pair, Track, placed
from affectsim_data.cameras import Camera
from affectsim_data.episodes import Robot
from affectsim_data.navmesh import NavMesh
from affectsim_data.observations import head_camera_pose, monitor_pose
from affectsim_data.observations.reference import interpolate_knots
from affectsim_data.poses import FloatArray, compose_pose, invert_pose, yaw_quaternion
from affectsim_data.releases import Release
from affectsim_data.scenes import Scene
from affectsim_data.schemas import read_array
from affectsim_data.visibility import CYCLE_INSTANTS, RayCaster, scene_caster

__all__ = ["Part", "read_part"]


@dataclasses.dataclass(frozen=True, eq=False)
class Part:
    """Some episodes of one scene."""

    scene: Scene
    navmesh: NavMesh
    episodes: Columns
    """`n` rows."""
    bodies: Bodies
    camera: Camera
    robot: Robot
    recipe: Recipe | None
    sampled: frozenset[str]
    """Episodes of which d* is measured again."""

    def __len__(self) -> int:
        return len(self.episodes)

    @functools.cached_property
    def ids(self) -> NDArray[np.object_]:
        """`(n,)`."""
        return self.episodes.text("episode_id")

    @property
    def caster(self) -> RayCaster:
        """Rays against the scene."""
        return scene_caster(self.scene)

    @property
    def thresholds(self) -> Thresholds:
        """Of the recipe; those of DESIGN section 4 if there is none."""
        return Thresholds() if self.recipe is None else self.recipe.thresholds

    @functools.cached_property
    def kinds(self) -> NDArray[np.object_]:
        """Where each person was to go, `(n,)`."""
        families, actions = self.episodes.text("family"), self.episodes.text("action")
        known: Mapping[tuple[str, str], PlacementKind] = {
            (entry.family, action): entry.placement_of(action)
            for entry in (self.recipe.compositions if self.recipe else ())
            for action in entry.actions
        }
        kinds = [known.get(key, "floor") for key in zip(families, actions, strict=True)]
        return np.array(kinds, object)

    @functools.cached_property
    def has_partner(self) -> NDArray[np.bool_]:
        """Dyads, `(n,)`."""
        return np.array([one is not None for one in self.episodes.text("partner_motion_id")], bool)

    @functools.cached_property
    def anchor(self) -> FloatArray:
        """`(n, 3)`."""
        return self.episodes.point("anchor")

    @functools.cached_property
    def start(self) -> FloatArray:
        """`(n, 3)`."""
        return self.episodes.point("start")

    @functools.cached_property
    def pose(self) -> FloatArray:
        """The targets' performance frames, `(n, 4, 4)`."""
        return self._poses("")

    @functools.cached_property
    def partner_pose(self) -> FloatArray:
        """The partners', `(n, 4, 4)`; not a number where there is none."""
        return self._poses("partner_")

    def _poses(self, prefix: str) -> FloatArray:
        facing = np.radians(self.episodes.number(f"{prefix}facing_deg"))
        return compose_pose(yaw_quaternion(facing), self.episodes.point(f"{prefix}anchor"))

    @functools.cached_property
    def tracks(self) -> list[Track]:
        """The targets' bodies, `n`."""
        return self._tracks("")

    @functools.cached_property
    def partner_tracks(self) -> dict[int, Track]:
        """The partners' bodies, by place of their episode."""
        names = self.episodes.text("partner_motion_id"), self.episodes.text("partner_avatar_id")
        return {
            int(place): self.bodies.track(names[0][place], names[1][place])
            for place in np.flatnonzero(self.has_partner)
        }

    def _tracks(self, prefix: str) -> list[Track]:
        names = (
            self.episodes.text(f"{prefix}motion_id"),
            self.episodes.text(f"{prefix}avatar_id"),
        )
        return [self.bodies.track(*pair) for pair in zip(*names, strict=True)]

    @functools.cached_property
    def surface(self) -> FloatArray:
        """The targets' surface points at the cycle's instants, world, `(n, 12, k, 3)`."""
        return placed(self.pose, np.stack([track.surface for track in self.tracks]))

    def pair(self, place: int) -> Pair:
        """Names the dyad of an episode, wherever it is."""
        names = [
            self.episodes.text(f"{prefix}{name}")[place]
            for prefix in ("", "partner_")
            for name in ("motion_id", "avatar_id")
        ]
        relative = invert_pose(self.pose[place]) @ self.partner_pose[place]
        # Rounded, so that the same dyad elsewhere is the same: angles are stored to 1e-9 degrees.
        return (names[0], names[1], names[2], names[3], np.round(relative, 7).tobytes())

    @functools.cached_property
    def knots(self) -> list[FloatArray]:
        """Knots of the reference views, `(num_knots, 7)` each."""
        names = [f"reference_trajectory{end}" for end in ("", "_dtype", "_shape")]
        rows = self.episodes.table.select(names).to_pylist()
        return [
            read_array(row, "reference_trajectory", where=str(one)).astype(np.float64)
            for row, one in zip(rows, self.ids, strict=True)
        ]

    @functools.cached_property
    def views(self) -> dict[str, FloatArray]:
        """Camera poses at the cycle's instants by condition, `(n, 12, 4, 4)` each."""
        number = self.episodes.number
        init = head_camera_pose(self.start, np.radians(number("start_yaw_deg")), self.robot)
        monitor = monitor_pose(
            self.episodes.point("monitor"),
            np.radians(number("monitor_yaw_deg")),
            np.radians(number("monitor_pitch_deg")),
        )
        cycles = np.arange(CYCLE_INSTANTS) / CYCLE_INSTANTS
        shape = (len(self), CYCLE_INSTANTS, 4, 4)
        return {
            "init": np.broadcast_to(init[:, None], shape),
            "ref": np.stack([interpolate_knots(knots, cycles) for knots in self.knots]),
            "mon": np.broadcast_to(monitor[:, None], shape),
        }

    def measure(
        self,
        check: str,
        values: FloatArray,
        *,
        where: NDArray[np.bool_] | None = None,
        low: float | FloatArray = -np.inf,
        high: float | FloatArray = np.inf,
        notes: tuple[str, ...] = (),
    ) -> Measure:
        """Values `(n,)` of the episodes, or of those of which `where` `(n,)` says so."""
        chosen = np.ones(len(self), bool) if where is None else where
        low, high = (np.broadcast_to(one, (len(self),))[chosen] for one in (low, high))
        notes = tuple(np.array(notes, object)[chosen]) if notes else ()
        return Measure.of(check, self.ids[chosen], values[chosen], low=low, high=high, notes=notes)


def read_part(
    release: Release,
    bodies: Bodies,
    episodes: Columns,
    recipe: Recipe | None,
    sampled: frozenset[str],
) -> tuple[Part | None, list[Measure]]:
    """Some episodes of one scene, and which of the assets they name can be read.

    Episodes whose motions or bodies cannot be read are left out; nothing comes back if the scene
    cannot, or nothing is left.
    """
    keep, problems = _readable_people(bodies, episodes)
    scene_id = str(episodes.text("scene_id")[0])
    try:
        scene, navmesh = release.scene(scene_id), release.navmesh(scene_id)
        problems[scene_id] = ""
    except (KeyError, ValueError, OSError) as error:
        problems[scene_id] = _text(error)
        keep[:] = False
    measures = [_readable(problems)]
    if not keep.any():
        return None, measures
    manifest = release.manifest
    left = episodes if keep.all() else episodes.where(keep)
    part = Part(scene, navmesh, left, bodies, manifest.camera, manifest.robot, recipe, sampled)
    return part, measures


def _readable_people(bodies: Bodies, episodes: Columns) -> tuple[NDArray[np.bool_], dict[str, str]]:
    """Episodes whose motions and bodies can be read, and by pair of them what is wrong."""
    problems: dict[str, str] = {}
    keep = np.ones(len(episodes), bool)
    for prefix in ("", "partner_"):
        motions, avatars = (episodes.text(f"{prefix}{one}_id") for one in ("motion", "avatar"))
        for place, pair in enumerate(zip(motions, avatars, strict=True)):
            if None in pair:
                keep[place] &= bool(prefix)
                continue
            name = " on ".join(pair)
            if name not in problems:
                problems[name] = ""
                try:
                    bodies.track(*pair)
                except (KeyError, ValueError, OSError) as error:
                    problems[name] = _text(error)
            keep[place] &= not problems[name]
    return keep, problems


def _readable(problems: Mapping[str, str]) -> Measure:
    values = [float(bool(problem)) for problem in problems.values()]
    notes = tuple(problems.values())
    return Measure.of("assets_readable", problems, values, high=0, notes=notes)


def _text(error: Exception) -> str:
    return str(error.args[0] if isinstance(error, KeyError) and error.args else error)
