"""Reads a motion corpus the way its recipe says: labels, performers, units and joints are data."""

from __future__ import annotations

import collections
import dataclasses
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from affectsim_data.builders.corpus_recipe import CorpusRecipe, load_recipe
from affectsim_data.motions.bvh import read_bvh
from affectsim_data.motions.looping import make_cyclic
from affectsim_data.motions.motion import Emotion, Motion
from affectsim_data.motions.retargeting import SourcePose, resample, retarget, source_pose

__all__ = ["CorpusFile", "CorpusRecipe", "CorpusScan", "load_recipe", "read_corpus", "scan_corpus"]

Progress = Callable[[str], None]
MAX_LISTED_PROBLEMS = 20
_HEAD_MIN_M = 0.5
"""Of the head above the lower foot in the median frame: also who bends or sits passes."""


@dataclasses.dataclass(frozen=True)
class CorpusFile:
    """One file a recipe takes, with its labels."""

    path: Path
    relative: str
    motion_id: str
    performer_id: str
    emotion: Emotion
    action: str


@dataclasses.dataclass(frozen=True)
class CorpusScan:
    """What a recipe finds in a folder."""

    files: tuple[CorpusFile, ...]
    """Files to read, sorted by path."""
    excluded: Mapping[str, int]
    """Files left out, by style."""

    def counts(self) -> dict[tuple[str, str], int]:
        """Files to read by action and emotion, sorted."""
        found = collections.Counter((file.action, file.emotion) for file in self.files)
        return dict(sorted(found.items()))


def scan_corpus(recipe: CorpusRecipe, source: Path | str) -> CorpusScan:
    """The files of a folder that a recipe takes, labelled by their paths; opens none of them.

    Raises:
        FileNotFoundError: No such folder, or none of its files matches the recipe's pattern.
        ValueError: Styles or actions the recipe does not know, listed together.
    """
    source = Path(source)
    if not source.is_dir():
        raise FileNotFoundError(
            f"{recipe.name}: expected a folder with the corpus at {source}, got nothing there"
        )
    paths = sorted(path for path in source.rglob("*") if path.is_file())
    matches = [(path, path.relative_to(source).as_posix()) for path in paths]
    found = [(path, rel, m) for path, rel in matches if (m := recipe.pattern.fullmatch(rel))]
    if not found:
        raise FileNotFoundError(
            f"{recipe.name}: expected files named like {recipe.pattern.pattern!r} in {source}, "
            f"got none among {len(paths)} files"
        )
    problems: dict[str, None] = {}
    excluded: collections.Counter[str] = collections.Counter()
    files: list[CorpusFile] = []
    for path, relative, match in found:
        style, action = match["style"], match["action"]
        if style in recipe.excluded:
            excluded[style] += 1
        elif style not in recipe.labels:
            problems[f"label {style!r} maps to no emotion; add it to [labels] or [excluded]"] = None
        elif action not in recipe.actions:
            problems[f"action {action!r} has no word; add it to [actions]"] = None
        else:
            files.append(_corpus_file(recipe, path, relative, match))
    _raise_problems(recipe.recipe_path, list(problems))
    return CorpusScan(tuple(files), dict(sorted(excluded.items())))


def read_corpus(
    recipe: Path | str | Mapping[str, Any] | CorpusRecipe,
    source: Path | str,
    *,
    progress: Progress | None = None,
) -> list[Motion]:
    """The motions of a corpus, retargeted, at the recipe's rate, closed into cycles.

    Args:
        recipe: A recipe, its tables, or the path of its TOML file.
        source: The folder the user downloaded.
        progress: Called with a line per hundred files, and with the counts at the end.

    Raises:
        FileNotFoundError: The folder is missing, or holds no file of this corpus.
        ValueError: The recipe does not fit, or files are damaged: all of them, up to 20 by name.
    """
    if not isinstance(recipe, CorpusRecipe):
        recipe = load_recipe(recipe)
    report = progress or (lambda _: None)
    scan = scan_corpus(recipe, source)
    motions: list[Motion] = []
    problems: list[str] = []
    for number, file in enumerate(scan.files, 1):
        try:
            motions.append(_read_motion(recipe, file))
        except ValueError as error:
            problems.append(str(error))
        if number % 100 == 0:
            report(f"{recipe.name}: {number} of {len(scan.files)} files")
    left_out = ", ".join(f"{style} {count}" for style, count in scan.excluded.items()) or "none"
    report(
        f"{recipe.name}: {len(motions)} motions read, {sum(scan.excluded.values())} files excluded "
        f"by style ({left_out}), {len(problems)} failed"
    )
    _raise_problems(recipe.name, problems)
    return motions


def _corpus_file(
    recipe: CorpusRecipe, path: Path, relative: str, match: re.Match[str]
) -> CorpusFile:
    groups = {key: value or "" for key, value in match.groupdict().items()}
    return CorpusFile(
        path=path,
        relative=relative,
        motion_id=f"{recipe.name}/{recipe.motion_id.format(**groups)}",
        performer_id=recipe.performer.format(**groups),
        emotion=recipe.labels[groups["style"]],
        action=recipe.actions[groups["action"]],
    )


def _read_motion(recipe: CorpusRecipe, file: CorpusFile) -> Motion:
    """One file as a motion.

    Raises:
        ValueError: The file is damaged, or its person is no person; starts with the path.
    """
    clip = read_bvh(file.path)
    source = source_pose(clip, metres_per_unit=recipe.metres_per_unit, up_axis=recipe.up_axis)
    try:
        root, rotations = retarget(source, recipe.joints)
    except ValueError as error:
        raise ValueError(f"{file.path}: {error}") from error
    _check_person(recipe, file, source)
    root, rotations = resample(root, rotations, fps=source.fps, target_fps=recipe.fps)
    motion = Motion(
        motion_id=file.motion_id,
        performer_id=file.performer_id,
        group_id=file.motion_id,
        emotion=file.emotion,
        action=file.action,
        fps=recipe.fps,
        root_translation=root,
        joint_rotations=rotations,
        source=f"{recipe.name}: {file.relative}",
        licence=recipe.licence,
    )
    return make_cyclic(motion, max_travel_m=recipe.max_travel_m)


def _check_person(recipe: CorpusRecipe, file: CorpusFile, source: SourcePose) -> None:
    """Raises unless a person of human size is upright on the floor; else unit or axis is wrong."""
    index = {name: source.joint_names.index(joint) for name, joint in recipe.joints.items()}
    low, high = recipe.height_m
    height = _stature(source, index)
    if not low <= height <= high:
        raise ValueError(
            f"{file.path}: expected a person {low} to {high} m tall, got {height:.2f} m; "
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
            f"{file.path}: expected the head {_HEAD_MIN_M} m or more above the feet, got "
            f"{above:.2f} m; check up_axis in {recipe.recipe_path}"
        )
    floor = float(np.percentile(lowest, 5.0))
    if abs(floor) > recipe.floor_m:
        raise ValueError(
            f"{file.path}: expected feet within {recipe.floor_m} m of the floor, got "
            f"{floor:.2f} m; check up_axis and floor_m in {recipe.recipe_path}"
        )


def _stature(source: SourcePose, index: Mapping[str, int]) -> float:
    """Height of the person standing straight, metres, from bone lengths; bending has no effect."""
    chains = (
        ("left_ankle", "left_knee", "left_hip"),
        ("pelvis", "spine1", "spine2", "spine3", "neck", "head"),
    )
    bones = 0.0
    for chain in chains:
        joints = source.positions[0, [index[name] for name in chain if name in index]]
        bones += float(np.linalg.norm(np.diff(joints, axis=0), axis=1).sum())
    # Below the ankle and above the head joint: 3.9 and about 10 percent of stature (Winter 2009).
    return bones / 0.86


def _raise_problems(name: str, problems: list[str]) -> None:
    if not problems:
        return
    if len(problems) == 1:
        raise ValueError(problems[0] if name in problems[0] else f"{name}: {problems[0]}")
    listed = "".join(f"\n  {problem}" for problem in problems[:MAX_LISTED_PROBLEMS])
    more = len(problems) - MAX_LISTED_PROBLEMS
    tail = f"\n  and {more} more" if more > 0 else ""
    raise ValueError(f"{name}: {len(problems)} problems:{listed}{tail}")
