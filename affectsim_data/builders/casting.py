"""Who performs what: motions acted or imported, screened, and given bodies."""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from affectsim_data.avatars import Avatar
from affectsim_data.builders.corpora import (
    CorpusFile,
    CorpusRecipe,
    FailedFile,
    import_file,
    load_recipe,
    scan_corpus,
)
from affectsim_data.builders.measuring import Performance, partner_place
from affectsim_data.builders.performances import PerformanceAction, perform, perform_dyad
from affectsim_data.builders.performances.dyads import NUM_DYADS
from affectsim_data.builders.performances.scenarios import NUM_SCENARIOS
from affectsim_data.builders.processes import run_parallel
from affectsim_data.builders.recipes import Recipe
from affectsim_data.builders.screening import (
    Finding,
    Jerkiness,
    ScreenReport,
    Thresholds,
    jerkiness,
    load_thresholds,
    screen_motion,
    screen_outliers,
)
from affectsim_data.motions import EMOTIONS, Emotion, Motion
from affectsim_data.poses import (
    FloatArray,
    invert_pose,
    matrix_quaternion,
    quaternion_multiply,
    transform_points,
)

__all__ = ["Cast", "make_cast"]

_NUM_VARIANTS = {"scenario": NUM_SCENARIOS, "interaction": NUM_DYADS}
"""Actions of which every take is a different performance; performers begin with different ones."""
_PERFORMANCE_KEYS = ("performers", "actions", "takes", "pairs", "reserved_takes")


@dataclasses.dataclass(frozen=True)
class Cast:
    """The performances of a release, and what screening said of them."""

    performances: tuple[Performance, ...]
    """Those that passed."""
    screening: ScreenReport
    """Every motion and check, and every file that could not be read."""
    rejected: tuple[Motion, ...]
    """Motions that failed a check; their performances are left out."""
    failures: tuple[FailedFile, ...]
    """Files of the corpus that could not be read."""
    left_out: str = ""
    """Files of the corpus that its recipe leaves out, counted."""


@dataclasses.dataclass(frozen=True)
class _Solo:
    """A performance to be acted by one person."""

    performer_id: str
    action: PerformanceAction
    emotion: Emotion
    take: int
    seed: tuple[int, ...]


@dataclasses.dataclass(frozen=True)
class _Pair:
    """An interaction to be acted by two."""

    performer_ids: tuple[str, str]
    emotion: Emotion
    take: int
    seed: tuple[int, ...]


@dataclasses.dataclass(frozen=True)
class _Made:
    """Motions of one performance, target first, with what screening said of each alone."""

    motions: tuple[Motion, ...]
    findings: tuple[tuple[Finding, ...], ...]
    jerkiness: tuple[Jerkiness, ...]


_Job = _Solo | _Pair | CorpusFile


def make_cast(
    recipe: Recipe, avatars: Sequence[Avatar], *, source: Path | None = None, jobs: int = 1
) -> Cast:
    """All performances of a recipe, those of its corpus and the procedural ones, screened.

    Args:
        recipe: Says what is performed.
        avatars: Bodies, taken in turn by performers.
        source: Folder of the corpus, for recipes that read one.
        jobs: Processes.

    Raises:
        FileNotFoundError: There is no such folder, or nothing of the corpus in it.
        ValueError: The recipe has a corpus and no source was given, or does not fit its files.
    """
    corpus: CorpusRecipe | None = None
    work: list[_Job] = []
    left_out = ""
    if "corpus" in recipe.document:
        if source is None:
            raise ValueError(
                f"recipe {recipe.name!r} reads a corpus: add --source FOLDER, where your copy of "
                f"{recipe.document['corpus']['name']!r} is"
            )
        corpus = load_recipe(recipe.path)
        scan = scan_corpus(corpus, source)
        left_out = scan.summary()
        work += scan.files
    if "performances" in recipe.document:
        work += _procedural(recipe)
    thresholds = load_thresholds(recipe.document.get("screening"))
    task = functools.partial(_make, recipe=recipe, corpus=corpus, thresholds=thresholds)
    results = list(run_parallel(task, work, jobs, "motions", recipe.name))
    made = [result for result in results if isinstance(result, _Made)]
    failures = tuple(result for result in results if isinstance(result, FailedFile))
    report = _report(made, failures, thresholds)
    motions = [motion for one in made for motion in one.motions]
    return Cast(
        performances=_embodied(made, report, avatars, recipe),
        screening=report,
        rejected=tuple(motion for motion in motions if motion.motion_id in report.rejected),
        failures=failures,
        left_out=left_out,
    )


def _procedural(recipe: Recipe) -> list[_Job]:
    """What the recipe's `[performances]` ask for.

    Every take has random numbers of its own: whether somebody is reserved in anger says nothing of
    the same person in fear.
    """
    table = recipe.document["performances"]
    takes = _takes(recipe)
    work: list[_Job] = []
    for (number, who), (place, action) in itertools.product(
        enumerate(table["performers"]), enumerate(table["actions"])
    ):
        for turn in range(takes.get(action, 1)):
            count = _NUM_VARIANTS.get(action)
            take = turn if count is None else (number + turn) % count
            seed = (recipe.seed, 1, number, place, turn)
            work += [
                _Solo(who, action, emotion, take, (*seed, label))
                for label, emotion in enumerate(EMOTIONS)
            ]
    for number, (target, partner) in enumerate(table.get("pairs", ())):
        for turn in range(takes.get("interaction", 1)):
            take = (number + turn) % NUM_DYADS
            work += [
                _Pair((target, partner), emotion, take, (recipe.seed, 2, number, turn, label))
                for label, emotion in enumerate(EMOTIONS)
            ]
    return work


def _takes(recipe: Recipe) -> dict[str, int]:
    """Takes of each action, 1 where the recipe says nothing.

    Raises:
        ValueError: An unknown key or action, or more takes than an action has variants.
    """
    table = recipe.document["performances"]
    if unknown := sorted(set(table) - set(_PERFORMANCE_KEYS)):
        raise ValueError(
            f"{recipe.path}: [performances] has unknown keys {', '.join(unknown)}; "
            f"it takes {', '.join(_PERFORMANCE_KEYS)}"
        )
    takes: dict[str, int] = table.get("takes", {})
    actions = [*table["actions"], "interaction"]
    for action, count in takes.items():
        most = _NUM_VARIANTS.get(action)
        if action not in actions:
            raise ValueError(
                f"{recipe.path}: [performances] takes has {action!r}; expected one of "
                f"{', '.join(actions)}"
            )
        if most is not None and count > most:
            raise ValueError(
                f"{recipe.path}: [performances] takes of {action!r}: there are {most} different "
                f"ones, got {count}; ask for at most {most}, or name more performers"
            )
    return takes


def _make(
    job: _Job, *, recipe: Recipe, corpus: CorpusRecipe | None, thresholds: Thresholds
) -> _Made | FailedFile:
    """Acts or imports one performance and screens it."""
    if isinstance(job, CorpusFile):
        assert corpus is not None
        try:
            imported = import_file(corpus, job)
        except ValueError as error:
            return FailedFile(job.path, job.relative, str(error))
        motion, pose = imported.motion.rounded(), imported.source
        joints = corpus.joint_map(pose.joint_names)
        findings = screen_motion(motion, source=pose, joints=joints, thresholds=thresholds)
        return _Made((motion,), (findings,), (jerkiness(motion),))
    motions = tuple(motion.rounded() for motion in _act(job, recipe))
    return _Made(
        motions,
        tuple(
            screen_motion(motion, source=None, joints=None, thresholds=thresholds)
            for motion in motions
        ),
        tuple(jerkiness(motion) for motion in motions),
    )


def _act(job: _Solo | _Pair, recipe: Recipe) -> tuple[Motion, ...]:
    rng = np.random.default_rng(job.seed)
    reserved = float(recipe.document["performances"].get("reserved_takes", 1.0))
    if isinstance(job, _Solo):
        return (
            perform(
                job.action,
                job.emotion,
                job.performer_id,
                take=job.take,
                rng=rng,
                collection=recipe.name,
                reserved_takes=reserved,
            ),
        )
    dyad = perform_dyad(
        job.emotion,
        job.performer_ids,
        take=job.take,
        rng=rng,
        collection=recipe.name,
        reserved_takes=reserved,
    )
    # Spacing belongs to what is performed: partners are placed alike in every emotion, and their
    # motion says where in front of the target they are.
    offset = invert_pose(partner_place()) @ dyad.T_target_partner
    return dyad.target, _moved(dyad.partner, offset)


def _moved(motion: Motion, pose: FloatArray) -> Motion:
    """The motion in another frame, of which its own is at `pose` `(4, 4)`."""
    rotations = motion.joint_rotations.copy()
    rotations[:, 0] = quaternion_multiply(matrix_quaternion(pose[:3, :3]), rotations[:, 0])
    root = transform_points(pose, motion.root_translation)
    return dataclasses.replace(motion, root_translation=root, joint_rotations=rotations)


def _report(
    made: Sequence[_Made], failures: Sequence[FailedFile], thresholds: Thresholds
) -> ScreenReport:
    report = ScreenReport()
    for one in made:
        for motion, findings in zip(one.motions, one.findings, strict=True):
            report.add(motion, findings)
    everybody = [measure for one in made for measure in one.jerkiness]
    report.add_outliers(screen_outliers(everybody, thresholds))
    for failure in failures:
        report.add_failure(failure.relative, failure.reason)
    return report


def _embodied(
    made: Sequence[_Made], report: ScreenReport, avatars: Sequence[Avatar], recipe: Recipe
) -> tuple[Performance, ...]:
    """Performances that passed, in the bodies of their performers; never chosen by emotion."""
    bodies = _bodies([one.motions for one in made], avatars, recipe)
    performances = []
    for one in made:
        if any(motion.motion_id in report.rejected for motion in one.motions):
            continue
        target, *others = ((motion, bodies[_role(motion, recipe)]) for motion in one.motions)
        performances.append(Performance(*target, others[0] if others else None))
    return tuple(performances)


def _bodies(
    motions: Sequence[tuple[Motion, ...]], avatars: Sequence[Avatar], recipe: Recipe
) -> dict[Any, Avatar]:
    named = recipe.document.get("performances", {}).get("performers", ())
    roles = {_role(motion, recipe) for one in motions for motion in one}
    ordered = [(name, "") for name in named] + sorted(roles - {(name, "") for name in named})
    return {role: avatars[place % len(avatars)] for place, role in enumerate(ordered)}


def _role(motion: Motion, recipe: Recipe) -> tuple[str, str]:
    """Who keeps one body: a performer; in a corpus, whose actors may be unnamed, an action too."""
    return motion.performer_id, motion.action if "corpus" in recipe.document else ""
