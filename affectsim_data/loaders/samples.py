"""What a dataset yields: one clip with its label and its provenance, and how it is drawn."""

from __future__ import annotations

from typing import NotRequired, TypedDict

import numpy as np
import torch

from affectsim_data.episodes import Episode, World, clip_time_s
from affectsim_data.loaders.places import Place
from affectsim_data.loaders.presets import Clip
from affectsim_data.observations import AObs, Condition
from affectsim_data.poses import FloatArray
from affectsim_data.render import ClipSpec, PosedAvatar, Renderer

__all__ = ["Sample", "clip_spec", "draw_sample"]


class Sample(TypedDict):
    """One episode under one condition; every value can be collated by the stock DataLoader."""

    video: NotRequired[torch.Tensor]
    """uint8 `(num_frames, 3, height, width)`, sRGB; absent from a dataset with `images=False`."""
    depth: NotRequired[torch.Tensor]
    """float32 `(num_frames, 1, height, width)`, metres along the view axis, `inf` for no hit;
    absent where `video` is."""
    instances: NotRequired[torch.Tensor]
    """uint8 `(num_frames, 1, height, width)`: 0 scene, 1 target, 2 partner; on request."""
    label: int
    """Index of the emotion: angry 0, fearful 1, happy 2, neutral 3, sad 4."""
    emotion: str
    """The same in words."""
    T_world_camera: torch.Tensor
    """float64 `(num_frames, 4, 4)`; the camera looks along -Z, +Y up."""
    intrinsics: torch.Tensor
    """float64 `(3, 3)`, pixels."""
    joint_positions: torch.Tensor
    """float32 `(num_frames, 22, 3)`, the target's joints in the world, metres."""
    distance_m: torch.Tensor
    """float64 `(num_frames,)`, camera to the target's pelvis: what was, where walls allow less
    than a condition asks for."""
    time_s: torch.Tensor
    """float64 `(num_frames,)`, since the start of the clip."""
    frame_indices: torch.Tensor
    """int64 `(num_frames,)`, on the clip's 30 fps grid."""
    condition: str
    """Name of the condition."""
    fallback: bool
    """Whether a_obs acquired nothing here, so that the clip is that of p_init; else `False`."""
    episode_id: str
    motion_id: str
    performer_id: str
    scene_id: str
    avatar_id: str
    split: str
    """The split by group, whatever split the dataset is of."""
    family: str
    challenge: str
    """Empty outside the observation-controlled family."""
    action: str
    release: str
    """Where the episode comes from; on the Hub, with the commit."""
    epoch: int
    """Epoch the sample was asked for in; 0 where a plain index was asked for."""
    position: int
    """Place in the global order of that epoch, over all ranks; else the index."""
    padding: bool
    """Whether it repeats an episode only to give every rank as many samples."""


def clip_spec(
    episode: Episode, world: World, condition: Condition, clip: Clip
) -> tuple[ClipSpec, np.ndarray]:
    """What to draw for an episode under a condition, and the frames of the grid it covers.

    Returns:
        The specification, and frame indices `(num_frames,)`.
    """
    grid_time_s = clip_time_s(episode)
    indices = clip.frame_indices(len(grid_time_s))
    time_s = grid_time_s[indices]
    people = tuple(
        PosedAvatar(person.avatar, person.joint_matrices(time_s)) for person in world.people
    )
    camera = world.camera.resized(width=clip.width, height=clip.height)
    trajectory = condition.trajectory(episode, world, time_s)
    return ClipSpec(world.scene, people, camera, trajectory), indices


def draw_sample(
    episode: Episode,
    world: World,
    condition: Condition,
    clip: Clip,
    renderer: Renderer | None,
    *,
    release: str,
    instances: bool = False,
    place: Place | None = None,
) -> Sample:
    """An episode under a condition: rendered, or with no renderer only described.

    Args:
        episode: Which one.
        world: What its identifiers stand for.
        condition: How it is seen.
        clip: Frames and size.
        renderer: Draws `video` and `depth`; `None` leaves them out.
        release: Where the episode comes from.
        instances: Whether to draw instance ids too.
        place: What the sample was asked for as; the first of an order if not said.
    """
    spec, indices = clip_spec(episode, world, condition, clip)
    joints = _joint_positions(spec)
    asked = Place(0, 0, 0) if place is None else place
    sample = Sample(
        label=episode.label,
        emotion=episode.emotion,
        T_world_camera=torch.from_numpy(spec.trajectory.T_world_camera),
        intrinsics=torch.from_numpy(spec.camera.intrinsics),
        joint_positions=torch.from_numpy(joints.astype(np.float32)),
        distance_m=torch.from_numpy(
            np.linalg.norm(spec.trajectory.T_world_camera[:, :3, 3] - joints[:, 0], axis=1)
        ),
        time_s=torch.from_numpy(clip_time_s(episode)[indices] - episode.phase_s),
        frame_indices=torch.from_numpy(indices),
        condition=condition.name,
        fallback=isinstance(condition, AObs) and condition.falls_back(episode),
        episode_id=episode.episode_id,
        motion_id=episode.target.motion_id,
        performer_id=episode.target.performer_id,
        scene_id=episode.scene_id,
        avatar_id=episode.target.avatar_id,
        split=episode.split,
        family=episode.family,
        challenge=episode.challenge or "",
        action=episode.action,
        release=release,
        epoch=asked.epoch,
        position=asked.position,
        padding=asked.padding,
    )
    if renderer is not None:
        images = renderer.render(spec, instances=instances)
        sample["video"] = torch.from_numpy(np.ascontiguousarray(images.rgb.transpose(0, 3, 1, 2)))
        sample["depth"] = torch.from_numpy(images.depth[:, None])
        if images.instances is not None:
            sample["instances"] = torch.from_numpy(images.instances[:, None])
    return sample


def _joint_positions(spec: ClipSpec) -> FloatArray:
    """The target's joints in the world, metres, `(num_frames, 22, 3)`."""
    target = spec.people[0]
    rest = target.avatar.skeleton.rest_positions
    turned = target.joint_matrices[..., :3, :3] @ rest[:, :, None]
    positions: FloatArray = turned[..., 0] + target.joint_matrices[..., :3, 3]
    return positions
