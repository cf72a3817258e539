"""What a renderer is: a clip specification in, RGB, depth and instance ids out."""

from __future__ import annotations

import dataclasses
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from affectsim_data.avatars import Avatar
from affectsim_data.cameras import Camera, CameraTrajectory
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Scene
from affectsim_data.skeletons import NUM_JOINTS

__all__ = ["ClipSpec", "PosedAvatar", "RenderedClip", "Renderer", "RendererName"]

RendererName = Literal["egl", "pyrender"]


@dataclasses.dataclass(frozen=True)
class PosedAvatar:
    """A body and its pose at every frame of a clip."""

    avatar: Avatar
    """Whose body."""
    joint_matrices: FloatArray
    """Rest vertices to world, `(num_frames, 22, 4, 4)`."""

    def __post_init__(self) -> None:
        shape = self.joint_matrices.shape
        if len(shape) != 4 or shape[1:] != (NUM_JOINTS, 4, 4):
            raise ValueError(
                f"avatar {self.avatar.avatar_id!r}: joint_matrices must be "
                f"(n, {NUM_JOINTS}, 4, 4), got {shape}"
            )


@dataclasses.dataclass(frozen=True)
class ClipSpec:
    """Everything the pixels of a clip depend on: the same spec gives the same pixels."""

    scene: Scene
    """Static world; renderers cache it by object identity and id."""
    people: tuple[PosedAvatar, ...]
    """Participants; instance ids are their places here, counted from 1."""
    camera: Camera
    """Intrinsics, one for all frames."""
    trajectory: CameraTrajectory
    """Camera poses, `num_frames` of them."""

    def __post_init__(self) -> None:
        for person in self.people:
            if len(person.joint_matrices) != len(self.trajectory):
                raise ValueError(
                    f"avatar {person.avatar.avatar_id!r} has {len(person.joint_matrices)} poses "
                    f"for {len(self.trajectory)} camera frames"
                )


@dataclasses.dataclass(frozen=True)
class RenderedClip:
    """The images of a clip, top row first."""

    rgb: NDArray[np.uint8]
    """sRGB, `(num_frames, height, width, 3)`."""
    depth: NDArray[np.float32]
    """Metres along the view axis, `inf` where nothing was hit, `(num_frames, height, width)`."""
    instances: NDArray[np.uint8] | None
    """0 for the scene and for nothing, k for the k-th person, `(num_frames, height, width)`;
    `None` unless asked for."""


class Renderer(Protocol):
    """Draws clips. One per process and device; never shared between processes or threads."""

    name: RendererName

    def render(self, spec: ClipSpec, *, instances: bool = False) -> RenderedClip:
        """The images of `spec`."""
        ...

    def close(self) -> None:
        """Frees the device; the renderer cannot be used again."""
        ...
