"""Candidates made into trajectories in a scene, best first, and looked at as they are stored."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator

from affectsim_data.cameras import Camera
from affectsim_data.episodes import ReferenceView
from affectsim_data.observations.candidates import Candidates
from affectsim_data.observations.checking import Checks, check_knots
from affectsim_data.observations.following import follow
from affectsim_data.observations.ranking import Ranking
from affectsim_data.observations.search import ReferenceSearch
from affectsim_data.observations.steadying import SteadyPath
from affectsim_data.observations.tracks import BodyTrack
from affectsim_data.poses import FloatArray
from affectsim_data.visibility import RayCaster

__all__ = ["Attempt", "Attempts", "Way"]

_PULLED_IN_TRIED = 3
"""Candidates that are tried although others need be pulled in less."""
_TRIED = 8
"""Candidates whose trajectories are looked at."""
_VERY_NEAR_M = (1.2, 0.8, 0.4)
"""Distances for those if none of them keeps clear of everything."""


@dataclasses.dataclass(frozen=True)
class Way:
    """What cameras follow, and the candidates for following it, in the performance frame."""

    steady: SteadyPath
    candidates: Candidates


@dataclasses.dataclass(frozen=True)
class Attempt:
    """A view whose trajectory was looked at."""

    view: ReferenceView
    checks: Checks


class Attempts:
    """The views of one way in one scene."""

    def __init__(
        self,
        way: Way,
        track: BodyTrack,
        T_world_performance: FloatArray,
        *,
        camera: Camera,
        caster: RayCaster,
        search: ReferenceSearch,
    ) -> None:
        """Bounds the scores of all candidates.

        Args:
            way: In the performance frame.
            track: The target and its partner, in the world.
            T_world_performance: Where the performance is, `(4, 4)`.
            camera: Intrinsics.
            caster: Rays against the scene.
            search: Weights and limits.
        """
        self._candidates, self._track = way.candidates, track
        self._camera, self._caster, self._search = camera, caster, search
        self._steady = way.steady.placed(T_world_performance)
        self._floor_y = float(T_world_performance[1, 3])
        self._ranking = Ranking(way.candidates, track.samples, T_world_performance, caster, search)

    def best_first(self) -> Iterator[Attempt]:
        """Eight views at most, from the best score down."""
        for chosen in self._promising():
            yield self._look(chosen, float(self._candidates.distance_m[chosen]))

    def very_near(self) -> Iterator[Attempt]:
        """The same from so near that hardly anything can be in the way."""
        for chosen, distance_m in itertools.product(list(self._promising()), _VERY_NEAR_M):
            yield self._look(chosen, distance_m)

    def until_safe(self) -> Iterator[Attempt]:
        """All views there are, up to the first that keeps clear of everything."""
        for chosen in self._ranking:
            for distance_m in (float(self._candidates.distance_m[chosen]), *_VERY_NEAR_M):
                attempt = self._look(chosen, distance_m)
                yield attempt
                if attempt.checks.safe:
                    return

    def _promising(self) -> Iterator[int]:
        """Candidates best first; after a few, only those that have to be pulled in least."""
        ranked = enumerate(self._ranking)
        kept = self._ranking.kept
        promising = (one for place, one in ranked if place < _PULLED_IN_TRIED or kept[one])
        return itertools.islice(promising, _TRIED)

    def _look(self, chosen: int, distance_m: float) -> Attempt:
        azimuth = float(self._candidates.azimuth[chosen])
        height_m = float(self._candidates.height_m[chosen])
        knots = follow(
            self._steady,
            self._track.duration_s,
            azimuth=azimuth,
            distance_m=distance_m,
            eye_y=self._floor_y + height_m,
            caster=self._caster,
            search=self._search,
        )
        checks = check_knots(
            knots,
            self._track,
            self._steady,
            camera=self._camera,
            caster=self._caster,
            search=self._search,
        )
        parts = {name: float(part[chosen]) for name, part in self._ranking.parts.items()}
        score = float(self._ranking.scores[chosen])
        view = ReferenceView(azimuth, distance_m, height_m, score, parts, knots)
        return Attempt(view, checks)
