"""What privileged policies are told: where everything is, and where one would stand."""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np

from affectsim_data.episodes import Episode, World
from affectsim_data.navmesh import NavMesh
from affectsim_data.observations.knots import interpolate_knots
from affectsim_data.poses import FloatArray
from affectsim_data.simulation.actions import PERSON_CLEARANCE_M
from affectsim_data.simulation.running import Observation
from affectsim_data.visibility import scene_caster

__all__ = ["Truth", "nearest_view", "reference_view"]

_RANGES_M = (1.75, 2.0, 1.5, 2.25, 2.5, 3.0)
"""Distances to the target to stand at, the best first."""
_NUM_BEARINGS = 24
_CLEARANCES_M = (1.5, 0.9)
"""Of where anybody comes over the cycle: where the image holds most of them, or else where they do
not walk into the robot."""
_SPREAD_M = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5)
"""How far from below a camera to look for floor to stand on."""
_INSTANTS = 12


@dataclasses.dataclass(frozen=True)
class Truth:
    """An episode with nothing hidden, in the frame of the world."""

    episode: Episode
    world: World
    navmesh: NavMesh

    def place(self, observation: Observation) -> tuple[FloatArray, float]:
        """Where the robot is, metres, `(3,)`, and its yaw."""
        turn = self.episode.start_yaw
        right, up, back = observation.position
        away = [
            math.cos(turn) * right + math.sin(turn) * back,
            up,
            -math.sin(turn) * right + math.cos(turn) * back,
        ]
        return np.array(self.episode.start_position) + away, observation.yaw + turn

    def people(self, time_s: float) -> FloatArray:
        """Pelvis of each participant, the target first, `(n, 3)`, so long after the start."""
        return self._pelvis([self.episode.phase_s + time_s])[:, 0]

    @functools.cached_property
    def whereabouts(self) -> FloatArray:
        """Pelvis of each participant over a cycle of the target's motion, `(n, 12, 3)`."""
        return self._pelvis(np.arange(_INSTANTS) / _INSTANTS * self.episode.duration_s)

    def _pelvis(self, instants: FloatArray | list[float]) -> FloatArray:
        people = self.world.people
        return np.stack([one.joint_frames(np.array(instants))[:, 0, :3, 3] for one in people])

    def is_free(self, start: FloatArray, end: FloatArray, *, time_s: float) -> bool:
        """Whether the robot can go straight from one place, `(2,)`, to another and meets nobody."""
        near = np.hypot(*(self.people(time_s)[:, [0, 2]] - end).T)
        if near.min() < PERSON_CLEARANCE_M + 0.1:
            return False
        level = self.episode.start_position[1]
        moved = self.navmesh.step([start[0], level, start[1]], [end[0], level, end[1]])
        return not moved.clipped

    def best_of(self, places: FloatArray, *, clearance_m: float) -> FloatArray | None:
        """The nearest of places `(n, 3)` to stand at, by the way there; `None` if none is fit.

        Fit is navigable floor that can be reached, as clear as that of where people come, and from
        where the pelvis of the target is seen past the furniture at most instants of the cycle.
        """
        places = places[self.navmesh.navigable(places)]
        people = self.whereabouts.reshape(-1, 3)
        apart = np.hypot(*np.moveaxis(places[:, None] - people, -1, 0)[[0, 2]])
        places = places[(apart >= clearance_m).all(axis=1)]
        eyes = places + np.array([0.0, self.world.robot.camera_height_m, 0.0])
        hidden = scene_caster(self.world.scene).hidden(eyes[:, None], self.whereabouts[None, 0])
        places = places[hidden.mean(axis=1) < 0.5]
        if not len(places):
            return None
        lengths = self.navmesh.geodesic_distances(self.episode.start_position, places)
        nearest = int(np.argmin(lengths))
        return places[nearest] if math.isfinite(lengths[nearest]) else None


def nearest_view(truth: Truth, instant_s: float) -> FloatArray | None:
    """The nearest place, `(3,)`, 1.75 m from the target's middle or as near that as can be."""
    middle = truth.whereabouts[0].mean(axis=0)
    return _first_fit(truth, middle, _RANGES_M)


def reference_view(truth: Truth, instant_s: float) -> FloatArray | None:
    """Floor below the P-Ref camera at an instant of the motion, or as near that as can be."""
    cycles = np.array([instant_s / truth.episode.duration_s])
    camera = interpolate_knots(truth.episode.reference.knots, cycles)[0, :3, 3]
    return _first_fit(truth, camera, _SPREAD_M)


def _first_fit(truth: Truth, middle: FloatArray, radii_m: tuple[float, ...]) -> FloatArray | None:
    """A place on the first circle around a middle that has one, with the best clearance."""
    for clearance_m in _CLEARANCES_M:
        for radius in radii_m:
            found = truth.best_of(_circle(truth, middle, radius), clearance_m=clearance_m)
            if found is not None:
                return found
    return None


def _circle(truth: Truth, middle: FloatArray, distance: float) -> FloatArray:
    """Places around a middle, `(24, 3)`, at the height of the start."""
    angles = np.arange(_NUM_BEARINGS) * 2.0 * np.pi / _NUM_BEARINGS
    around = np.stack([np.sin(angles), np.zeros(_NUM_BEARINGS), np.cos(angles)], axis=1)
    level = np.array([middle[0], truth.episode.start_position[1], middle[2]])
    return level + distance * around
