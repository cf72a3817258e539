"""A performance made ready to be placed anywhere: its body over one cycle, computed once."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence

from affectsim_data.episodes import Person
from affectsim_data.observations.bodies import BodyPath, path_instants, path_of_frames
from affectsim_data.poses import FloatArray, transform_points
from affectsim_data.visibility import BodySamples, cycle_instants, people_samples

__all__ = ["BodyTrack", "body_track"]


@dataclasses.dataclass(frozen=True, eq=False)
class BodyTrack:
    """The target of a performance over one motion cycle, and the partner that may hide it."""

    samples: BodySamples
    """Its surface at the instants of `cycle_instants`."""
    path: BodyPath
    """Its smoothed way."""
    joints: FloatArray
    """Of the target, at the samples of the path, `(num_samples, 22, 3)`."""
    partner_joints: FloatArray | None = None
    """Of the other participant, at the samples of the path, `(num_samples, 22, 3)`."""

    @property
    def duration_s(self) -> float:
        """Of the cycle."""
        return self.path.duration_s

    @functools.cached_property
    def mean_heading(self) -> float:
        """Yaw the body faces over the cycle, radians in (-pi, pi]."""
        return self.path.mean_heading

    def placed(self, T_world_performance: FloatArray) -> BodyTrack:
        """The same track elsewhere, `(4, 4)`: nothing is posed or meshed again."""
        pose, partner = T_world_performance, self.partner_joints
        return BodyTrack(
            samples=self.samples.placed(pose),
            path=self.path.placed(pose),
            joints=transform_points(pose, self.joints),
            partner_joints=None if partner is None else transform_points(pose, partner),
        )

    def at_instants(self, values: FloatArray) -> FloatArray:
        """Of values at the samples of the path, `(num_samples, ...)`, those at the instants of
        `samples`, `(12, ...)`."""
        return values[:: len(values) // len(self.samples.points)]


def body_track(people: Sequence[Person], samples: BodySamples | None = None) -> BodyTrack:
    """The track of a target, which comes first, and its partner if there is one.

    Args:
        people: Where they stand; for a track to be placed, in the performance frame: the
            target's `T_world_performance` is the identity.
        samples: Theirs at the cycle instants, if they are known already.
    """
    duration_s = people[0].motion.duration_s
    instants = path_instants(duration_s)
    frames = [person.joint_frames(instants) for person in people]
    joints = [one[..., :3, 3] for one in frames]
    return BodyTrack(
        samples=samples or people_samples(people, cycle_instants(duration_s)),
        path=path_of_frames(frames[0], duration_s),
        joints=joints[0].copy(),
        partner_joints=joints[1].copy() if len(people) > 1 else None,
    )
