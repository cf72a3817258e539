"""Two people in one interaction: recorded together, retargeted apart, and brought together again.

A partner's motion is told in a frame that stands at `partner_place` before the target, the same in
every interaction; how near the partner comes, and from which side, is in the motion.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from affectsim_data.builders.corpus_import import Imported, import_file, import_open
from affectsim_data.builders.corpus_recipe import CorpusRecipe
from affectsim_data.builders.corpus_scan import CorpusFile
from affectsim_data.builders.measuring import partner_place
from affectsim_data.motions.looping import close_loop, common_end
from affectsim_data.motions.motion import Motion
from affectsim_data.poses import (
    FloatArray,
    compose_pose,
    invert_pose,
    matrix_quaternion,
    quaternion_multiply,
    quaternion_rotate,
    transform_points,
    yaw_quaternion,
)
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["import_clip", "placed_partner"]

_FLOOR = np.array([1.0, 0.0, 1.0])
_HIPS = tuple(JOINT_NAMES.index(f"{side}_hip") for side in ("left", "right"))
_APART_M = (0.2, 4.0)
"""Hips of two people at the start of an interaction, in the size of the canonical body."""
_MOST_UNLIKE_S = 0.2
"""How much longer one file of a pair may be."""
_MOST_TRAVEL_M = 0.5
"""From the first to the last frame: what a seam can close with a step or two."""


def placed_partner(partner: Motion, T_target_partner: FloatArray) -> Motion:
    """A partner's motion in the frame at `partner_place`.

    Args:
        partner: In its own performance frame, not yet closed into a cycle or made as one.
        T_target_partner: That frame in the target's, `(4, 4)`.
    """
    pose = invert_pose(partner_place()) @ T_target_partner
    rotations = partner.joint_rotations.copy()
    rotations[:, 0] = quaternion_multiply(matrix_quaternion(pose[:3, :3]), rotations[:, 0])
    root = transform_points(pose, partner.root_translation)
    return dataclasses.replace(partner, root_translation=root, joint_rotations=rotations)


def import_clip(recipe: CorpusRecipe, files: Sequence[CorpusFile]) -> tuple[Imported, ...]:
    """What one clip of a corpus shows: somebody alone, or target and partner, closed into cycles.

    Args:
        recipe: Of the corpus.
        files: One file, or those of target and partner.

    Raises:
        ValueError: A file is damaged, or two do not show one interaction; starts with the path.
    """
    if len(files) == 1:
        return (import_file(recipe, files[0]),)
    found = [import_open(recipe, file) for file in files]
    try:
        target, partner = _together(recipe, found)
        motions = _cycles(target, partner)
    except ValueError as error:
        names = " and ".join(file.relative for file in files)
        raise ValueError(f"{files[0].path}: pair {names}: {error}") from error
    return tuple(
        dataclasses.replace(one, motion=motion) for one, motion in zip(found, motions, strict=True)
    )


def _together(recipe: CorpusRecipe, found: Sequence[Imported]) -> tuple[Motion, Motion]:
    """Target and partner of equal length, the partner where the recording has it."""
    target, partner = (one.motion for one in found)
    apart_s = abs(target.duration_s - partner.duration_s)
    if apart_s > _MOST_UNLIKE_S:
        raise ValueError(
            f"expected two files of one recording, equally long, got {target.duration_s:.2f} s "
            f"and {partner.duration_s:.2f} s"
        )
    count = min(target.num_frames, partner.num_frames)
    scale = float(np.mean([one.motion.provenance.get("leg_scale", 1.0) for one in found]))
    T_space_target, T_space_partner = (_place_in_space(recipe, one, scale) for one in found)
    T_target_partner = invert_pose(T_space_target) @ T_space_partner
    distance = float(np.linalg.norm(T_target_partner[:3, 3]))
    low, high = _APART_M
    if not low <= distance <= high:
        raise ValueError(
            f"expected two people {low} to {high} m apart at the start, got {distance:.2f} m; "
            "both files must be in the one space they were recorded in, not centred each"
        )
    return _first(target, count), _first(placed_partner(partner, T_target_partner), count)


def _place_in_space(recipe: CorpusRecipe, one: Imported, scale: float) -> FloatArray:
    """The performance frame of a motion in the space it was recorded in, scaled, `(4, 4)`.

    The heading is the one that best turns the joints of the motion, seen from the hips, onto those
    of the recording, over all frames.
    """
    source, motion = one.source, one.motion
    joints = recipe.joint_map(source.joint_names)
    instants = np.arange(motion.num_frames) / motion.fps
    frames = np.minimum(np.rint(instants * source.fps).astype(np.intp), source.num_frames - 1)
    columns = [source.joint_names.index(name) for name in joints.values()]
    recorded = source.positions[frames]
    recorded_hips = recorded[:, [source.joint_names.index(joints[JOINT_NAMES[h]]) for h in _HIPS]]
    ours = motion.joint_positions()
    hips = ours[:, list(_HIPS)].mean(axis=1)
    ours_about = ours[:, [JOINT_NAMES.index(name) for name in joints]] - hips[:, None]
    about = recorded[:, columns] - recorded_hips.mean(axis=1)[:, None]
    sine = (about[..., 0] * ours_about[..., 2] - about[..., 2] * ours_about[..., 0]).sum()
    cosine = (about[..., 0] * ours_about[..., 0] + about[..., 2] * ours_about[..., 2]).sum()
    heading = yaw_quaternion(np.arctan2(sine, cosine))
    origin = scale * recorded_hips[0].mean(axis=0) - quaternion_rotate(heading, hips[0])
    return compose_pose(heading, origin * _FLOOR)


def _first(motion: Motion, count: int) -> Motion:
    return dataclasses.replace(
        motion,
        root_translation=motion.root_translation[:count],
        joint_rotations=motion.joint_rotations[:count],
    )


def _cycles(target: Motion, partner: Motion) -> tuple[Motion, Motion]:
    """Both as cycles of one length: ended together where both are most like their beginning."""
    count = common_end([target, partner])
    for motion, role in ((target, "target"), (partner, "partner")):
        way = (motion.root_translation[count - 1] - motion.root_translation[0]) * _FLOOR
        travel = float(np.linalg.norm(way))
        if travel > _MOST_TRAVEL_M:
            raise ValueError(
                f"expected the {role} to end within {_MOST_TRAVEL_M} m of where it began, "
                f"got {travel:.2f} m; interactions are played as cycles: cut both files where "
                "both people stand nearly as at the start"
            )
    return close_loop(target, num_frames=count), close_loop(partner, num_frames=count)
