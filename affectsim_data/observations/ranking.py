"""Candidate reference views in a scene, best first, casting no more rays than that takes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from affectsim_data.observations.candidates import Candidates
from affectsim_data.observations.orbit import MARGIN_M
from affectsim_data.observations.search import ReferenceSearch
from affectsim_data.poses import FloatArray, transform_points
from affectsim_data.visibility import BodySamples, RayCaster

__all__ = ["Ranking"]

_BATCH = 8
"""Candidates whose rays are cast together."""
_DIGITS = 9
"""Scores that differ by less are equal: the earlier candidate wins."""
_DIRECTIONS = np.array(
    [d for d in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(d)], np.float64
)
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)


class Ranking:
    """Scores of candidates in a scene, measured as far as the order asked for needs them."""

    def __init__(
        self,
        candidates: Candidates,
        samples: BodySamples,
        T_world_performance: FloatArray,
        caster: RayCaster,
        search: ReferenceSearch,
    ) -> None:
        """Bounds of all scores.

        Args:
            candidates: About the performance in its own frame.
            samples: Its body, in the world.
            T_world_performance: Where it is, `(4, 4)`.
            caster: Rays against the scene.
            search: Weights.
        """
        self._candidates, self._samples = candidates, samples
        self._caster, self._search = caster, search
        self._eyes = transform_points(T_world_performance, candidates.eyes)
        center = transform_points(T_world_performance, candidates.center)
        self._reach = candidates.beside_partner & self._reachable(center)
        reach = self._reach.mean(axis=0)
        self.kept = reach >= reach.max()
        """Candidates to be pulled in least: at none of the cycle instants if possible, `(k,)`."""
        count = len(candidates.azimuth)
        self.parts = {name: np.zeros(count) for name in search.weights} | candidates.parts
        """By name, in [0, 1], `(k,)` each; those of a scene are bounds until measured."""
        self.parts["visibility"] = (candidates.in_image * self._reach).mean(axis=0)
        self.parts["framing"] = (candidates.framing * self._reach).mean(axis=0)
        self.parts["clearance"] = self._reach.mean(axis=0)
        self.measured = np.zeros(count, bool)
        """Which candidates' parts are no bounds any more, `(k,)`."""
        self.scores = self._score()
        """Weighted sums of the parts, `(k,)`."""

    def __iter__(self) -> Iterator[int]:
        """Candidates from the best score to the least; of equal ones the earlier first.

        A candidate comes once its measured score is above the bounds of all that are not measured.
        """
        waiting = np.lexsort((np.arange(len(self.scores)), -self.scores))
        done = 0
        given = np.zeros(len(self.scores), bool)
        while not given.all():
            ready = np.flatnonzero(self.measured & ~given)
            bound = self.scores[waiting[done]] if done < len(waiting) else -np.inf
            ready = ready[self.scores[ready] > bound]
            if len(ready):
                best = int(ready[np.argmax(self.scores[ready])])
                given[best] = True
                yield best
            else:
                self._measure(waiting[done : done + _BATCH])
                done += _BATCH

    def measure_all(self) -> None:
        """Casts the rays of all candidates: what an exhaustive search does."""
        self._measure(np.flatnonzero(~self.measured))

    def _score(self, chosen: NDArray[np.intp] | slice = slice(None)) -> FloatArray:
        weights = self._search.weights
        total = sum(weights[name] * part[chosen] for name, part in self.parts.items())
        score: FloatArray = np.round(total, _DIGITS)
        return score

    def _reachable(self, center: FloatArray) -> NDArray[np.bool_]:
        """Whether nothing is between the body's axis and a camera or close behind it, `(t, k)`.

        Candidates on one side and of one height share a ray.
        """
        search = self._search
        shape = tuple(len(x) for x in (search.azimuths_deg, search.distances_m, search.heights_m))
        eyes = self._eyes.reshape(len(center), *shape, 3)[:, :, 0]
        axis = np.broadcast_to(center[:, None, None], eyes.shape).copy()
        axis[..., 1] = eyes[..., 1]
        way = eyes - axis
        way /= np.linalg.norm(way, axis=-1, keepdims=True)
        distance_m = np.array(search.distances_m) + MARGIN_M
        free = self._caster.distance(axis, way, limit=float(distance_m.max()) + MARGIN_M)
        reachable: NDArray[np.bool_] = free[:, :, None] > distance_m[:, None]
        return reachable.reshape(len(center), -1)

    def _measure(self, chosen: NDArray[np.intp]) -> None:
        """Casts the rays of some candidates and puts what they say in place of the bounds."""
        eyes, reach = self._eyes[:, chosen], self._reach[:, chosen]
        points = self._samples.points
        seen = self._candidates.inside(chosen, points.shape[1])
        seen &= ~self._caster.hidden(eyes[:, :, None], points[:, None])
        if self._samples.partner is not None:
            seen &= ~self._samples.hidden_by_partner(eyes)
        limit = self._search.clearance_m
        free = self._caster.distance(eyes[..., None, :], _DIRECTIONS, limit=limit).min(axis=-1)
        self.parts["visibility"][chosen] = (seen.mean(axis=-1) * reach).mean(axis=0)
        self.parts["clearance"][chosen] = (np.minimum(free / limit, 1.0) * reach).mean(axis=0)
        self.measured[chosen] = True
        self.scores[chosen] = self._score(chosen)
