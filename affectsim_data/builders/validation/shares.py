"""Visible shares measured again: every camera, every instant, all episodes of a scene at once."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.validation.part import Part
from affectsim_data.poses import FloatArray, invert_pose, transform_points

__all__ = ["Seen", "initial_shares", "seen"]


@dataclasses.dataclass(frozen=True, eq=False)
class Seen:
    """What one condition sees of the targets at the cycle's instants."""

    inside: NDArray[np.bool_]
    """Points in the image, `(n, 12, k)`."""
    visible: NDArray[np.bool_]
    """Those of them that nothing hides, `(n, 12, k)`."""

    @property
    def share(self) -> FloatArray:
        """Mean visible share, `(n,)`."""
        share: FloatArray = self.visible.mean(axis=(1, 2))
        return share


@functools.lru_cache(maxsize=3)
def seen(part: Part, view: str) -> Seen:
    """What `init`, `ref` or `mon` sees, by rays against the scene and the partner."""
    poses = part.views[view]
    eyes = poses[..., :3, 3]
    inside = np.asarray(part.camera.sees(part.surface, poses), bool)
    hidden = part.caster.hidden(eyes[:, :, None], part.surface)
    for place in np.flatnonzero(part.has_partner):
        local = transform_points(invert_pose(part.pose[place]), eyes[place])
        hidden[place] |= part.bodies.pair(part.pair(int(place))).hidden_by_partner(local[:, None])[
            :, 0
        ]
    return Seen(inside, inside & ~hidden)


def initial_shares(part: Part) -> tuple[FloatArray, FloatArray]:
    """Mean visible share at the start, and share inside the image, hidden or not, `(n,)` each."""
    initial = seen(part, "init")
    return initial.share, initial.inside.mean(axis=(1, 2))
