"""One file of a corpus as a motion: read, retargeted, checked to be a person."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from affectsim_data.builders.corpus_recipe import CorpusRecipe
from affectsim_data.builders.corpus_scan import CorpusFile
from affectsim_data.motions.bvh import read_bvh
from affectsim_data.motions.looping import make_cyclic
from affectsim_data.motions.motion import Motion
from affectsim_data.motions.retargeting import (
    SourcePose,
    resample,
    retarget_with_report,
    source_pose,
)
from affectsim_data.motions.smpl import SmplClip, read_smpl, smpl_motion, smpl_source
from affectsim_data.poses import FloatArray

__all__ = ["FailedFile", "Imported", "import_file", "import_open", "read_source", "stature_m"]

_LEAST_FRAMES = 3
_HEAD_MIN_M = 0.5
"""Of the head above the lower foot in the median frame: also who bends or sits passes."""


@dataclasses.dataclass(frozen=True)
class Imported:
    """A file of a corpus, read."""

    motion: Motion
    source: SourcePose
    """The person as recorded, before retargeting, at the rate of the file."""


@dataclasses.dataclass(frozen=True)
class FailedFile:
    """A file that could not be read."""

    path: Path
    relative: str
    """Path inside the corpus."""
    reason: str
    """Starts with the path."""


def import_file(recipe: CorpusRecipe, file: CorpusFile) -> Imported:
    """One file of a corpus as a motion closed into a cycle, with the pose it came from.

    Raises:
        ValueError: The file is damaged, or its person is no person; starts with the path.
    """
    found = import_open(recipe, file)
    try:
        motion = make_cyclic(found.motion, max_travel_m=recipe.max_travel_m)
    except ValueError as error:
        raise ValueError(f"{file.path}: {error}") from error
    return dataclasses.replace(found, motion=motion)


def import_open(recipe: CorpusRecipe, file: CorpusFile) -> Imported:
    """The same before the motion is closed into a cycle: it ends where the file does.

    Raises:
        ValueError: As `import_file`.
    """
    try:
        source, root, rotations, report = _read_pose(recipe, file.path)
        _check_person(recipe, source)
        root, rotations = resample(root, rotations, fps=source.fps, target_fps=recipe.fps)
        motion = Motion(
            motion_id=file.motion_id,
            performer_id=file.performer_id,
            group_id=file.group_id,
            emotion=file.emotion,
            action=file.action,
            performance=file.performance,
            take=file.take,
            fps=recipe.fps,
            root_translation=root,
            joint_rotations=rotations,
            source=f"{recipe.name}: {file.relative}",
            licence=recipe.licence,
            provenance={
                "corpus": recipe.name,
                "file": file.relative,
                "fps": source.fps,
                "num_frames": source.num_frames,
                **report,
            },
        )
        return Imported(motion, source)
    except (ValueError, OSError) as error:
        message = str(error)
        if not message.startswith(str(file.path)):
            message = f"{file.path}: {message}"
        raise ValueError(message) from error


def read_source(recipe: CorpusRecipe, path: Path | str) -> SourcePose:
    """The person in a file as recorded, in metres, +Y up, before retargeting; skipped frames apart.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: The file is damaged; starts with the path.
    """
    if recipe.format == "smpl_npz":
        return smpl_source(_read_smpl(recipe, path), up_axis=recipe.up_axis)
    clip, skip = read_bvh(path), recipe.skip_frames
    source = source_pose(clip, metres_per_unit=recipe.metres_per_unit, up_axis=recipe.up_axis)
    return dataclasses.replace(
        source, positions=source.positions[skip:], rotations=source.rotations[skip:]
    )


def stature_m(source: SourcePose, joints: Mapping[str, str]) -> float:
    """Height of the person standing straight, metres, from bone lengths; bending has no effect.

    Args:
        source: A person.
        joints: Source joint of a canonical joint; `CorpusRecipe.joint_map` gives it.
    """
    place = {name: source.positions[0, source.joint_names.index(j)] for name, j in joints.items()}
    place["hips"] = 0.5 * (place["left_hip"] + place["right_hip"])
    chains = (
        ("left_ankle", "left_knee", "left_hip"),
        ("hips", "pelvis", "spine1", "spine2", "spine3", "neck", "head"),
    )
    bones = 0.0
    for chain in chains:
        places = np.array([place[name] for name in chain if name in place])
        bones += float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
    # Below the ankle and above the head joint: 3.9 and about 10 percent of stature (Winter 2009).
    return bones / 0.86


def _read_pose(
    recipe: CorpusRecipe, path: Path
) -> tuple[SourcePose, FloatArray, FloatArray, dict[str, Any]]:
    """A person as recorded, root and joints of the canonical body at the rate of the file, and what
    retargeting did."""
    if recipe.format == "smpl_npz":
        clip = _read_smpl(recipe, path)
        _check_length(len(clip.translation), recipe)
        root, rotations = smpl_motion(clip, up_axis=recipe.up_axis)
        return smpl_source(clip, up_axis=recipe.up_axis), root, rotations, {}
    source = read_source(recipe, path)
    _check_length(source.num_frames, recipe)
    root, rotations, report = retarget_with_report(source, recipe.joint_map(source.joint_names))
    return source, root, rotations, dataclasses.asdict(report)


def _check_length(num_frames: int, recipe: CorpusRecipe) -> None:
    if num_frames < _LEAST_FRAMES:
        note = f" after {recipe.skip_frames} skipped" if recipe.skip_frames else ""
        raise ValueError(f"expected {_LEAST_FRAMES} frames or more{note}, got {num_frames}")


def _read_smpl(recipe: CorpusRecipe, path: Path | str) -> SmplClip:
    clip, skip = read_smpl(path), recipe.skip_frames
    translation = clip.translation[skip:] * recipe.metres_per_unit
    return dataclasses.replace(clip, translation=translation, rotations=clip.rotations[skip:])


def _check_person(recipe: CorpusRecipe, source: SourcePose) -> None:
    """Raises unless a person of human size is upright on the floor; else unit or axis is wrong."""
    joints = recipe.joint_map(source.joint_names)
    index = {name: source.joint_names.index(joint) for name, joint in joints.items()}
    low, high = recipe.height_m
    height = stature_m(source, joints)
    if not low <= height <= high:
        raise ValueError(
            f"expected a person {low} to {high} m tall, got {height:.2f} m; "
            f"check metres_per_unit in {recipe.recipe_path}"
        )
    feet = [
        index[name]
        for name in ("left_ankle", "right_ankle", "left_foot", "right_foot")
        if name in index
    ]
    lowest = source.positions[:, feet, 1].min(axis=1)
    above = float(np.median(source.positions[:, index["head"], 1] - lowest))
    if above < _HEAD_MIN_M:
        raise ValueError(
            f"expected the head {_HEAD_MIN_M} m or more above the feet, got "
            f"{above:.2f} m; check up_axis in {recipe.recipe_path}"
        )
    floor = float(np.percentile(lowest, 5.0))
    if abs(floor) > recipe.floor_m:
        raise ValueError(
            f"expected feet within {recipe.floor_m} m of the floor, got "
            f"{floor:.2f} m; check up_axis and floor_m in {recipe.recipe_path}"
        )
