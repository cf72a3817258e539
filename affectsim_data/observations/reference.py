"""P-Ref: the reference view, from privileged geometry and never from labels or predictions."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator

import numpy as np

from affectsim_data.cameras import Camera, CameraTrajectory
from affectsim_data.episodes import Episode, ReferenceView, World
from affectsim_data.observations.attempts import Attempt, Attempts, Way
from affectsim_data.observations.candidates import make_candidates
from affectsim_data.observations.knots import interpolate_knots
from affectsim_data.observations.search import ReferenceSearch
from affectsim_data.observations.steadying import SteadyPath, steady_path
from affectsim_data.observations.tracks import BodyTrack, body_track
from affectsim_data.poses import FloatArray
from affectsim_data.visibility import RayCaster

__all__ = [
    "PRef",
    "ReferencePlanner",
    "ReferenceSearch",
    "interpolate_knots",
    "plan_reference",
    "reference_planner",
]

_TURNS_RAD = np.radians(60.0)
"""Who turns no more than this is seen alike by cameras that turn with it and that do not."""


@dataclasses.dataclass(frozen=True)
class PRef:
    """P-Ref: the trajectory stored with the episode, by `plan_reference`."""

    name: str = "p_ref"

    def trajectory(self, episode: Episode, world: World, time_s: FloatArray) -> CameraTrajectory:
        """Poses between the stored knots, cyclic."""
        knots = episode.reference.knots
        return CameraTrajectory(interpolate_knots(knots, time_s / episode.duration_s))


class ReferencePlanner:
    """Plans reference views of one performance wherever it is placed."""

    def __init__(self, track: BodyTrack, camera: Camera, search: ReferenceSearch) -> None:
        """Prepares all that no scene can change.

        Args:
            track: The performance in its own frame.
            camera: Intrinsics.
            search: Candidates, weights and limits.
        """
        self._track, self._camera, self._search = track, camera, search
        self.going_round = self._way(steady_path(track.path))
        """Cameras that turn with the performer."""

    @functools.cached_property
    def _keeping_side(self) -> Way | None:
        """Cameras that do not turn with the performer; none for one who hardly turns."""
        steady = self.going_round.steady
        if np.ptp(steady.heading) < _TURNS_RAD:
            return None
        still = np.full(len(steady.heading), steady.heading[0])
        return self._way(dataclasses.replace(steady, heading=still))

    def _way(self, steady: SteadyPath) -> Way:
        return Way(steady, make_candidates(self._track, steady, self._camera, self._search))

    def plan(
        self, T_world_performance: FloatArray, caster: RayCaster
    ) -> tuple[ReferenceView, float]:
        """The best view whose trajectory holds, and its mean visible share.

        Candidates are taken from the best score down; the first whose trajectory, as it would be
        stored, keeps every limit of the search is the view. If none of eight does and the
        performer turns, the camera may keep its side in the room instead of going round; azimuths
        then count from the facing at instant 0. If that does not help, the view is the one that
        comes nearest to the limits; safety comes first.

        Args:
            T_world_performance: Where the performance is: upright, `(4, 4)`.
            caster: Rays against the scene.
        """
        track = self._track.placed(T_world_performance)
        tried: list[Attempts] = []
        found: list[Attempt] = []
        for way in self._ways():
            attempts = Attempts(
                way,
                track,
                T_world_performance,
                camera=self._camera,
                caster=caster,
                search=self._search,
            )
            tried.append(attempts)
            for attempt in attempts.best_first():
                found.append(attempt)
                if attempt.checks.hold(self._search):
                    return attempt.view, attempt.checks.visible
        if not any(attempt.checks.safe for attempt in found):
            found += [attempt for attempts in tried for attempt in attempts.very_near()]
        if not any(attempt.checks.safe for attempt in found):
            found += [attempt for attempts in tried for attempt in attempts.until_safe()]
        best = max(found, key=lambda attempt: attempt.checks.quality(self._search))
        return best.view, best.checks.visible

    def _ways(self) -> Iterator[Way]:
        yield self.going_round
        if self._keeping_side is not None:
            yield self._keeping_side


@functools.lru_cache(maxsize=2048)
def reference_planner(
    track: BodyTrack, camera: Camera, search: ReferenceSearch | None = None
) -> ReferencePlanner:
    """The planner of a track; those of the last tracks are kept, some 100 kB each."""
    return ReferencePlanner(track, camera, search or ReferenceSearch())


def plan_reference(
    world: World, caster: RayCaster, *, search: ReferenceSearch | None = None
) -> tuple[ReferenceView, float]:
    """The best relative view of a world's target, kept as it moves, and its visible share.

    Every candidate of azimuth, distance and height is scored at instants spread over the cycle: a
    weighted sum of visible body share, alignment with the facing, distance, framing and clearance.
    A build that places a performance often keeps a `ReferencePlanner` for it.
    """
    pose = world.target.T_world_performance
    back = np.linalg.inv(pose)
    people = tuple(
        dataclasses.replace(one, T_world_performance=back @ one.T_world_performance)
        for one in world.people
    )
    planner = ReferencePlanner(body_track(people), world.camera, search or ReferenceSearch())
    return planner.plan(pose, caster)
