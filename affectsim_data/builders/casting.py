"""Who performs what: motions acted or imported, screened, and given bodies."""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from affectsim_data.avatars import Avatar
from affectsim_data.builders.corpora import (
    CorpusFile,
    CorpusRecipe,
    FailedFile,
    import_clip,
    scan_corpus,
)
from affectsim_data.builders.measuring import Performance
from affectsim_data.builders.pairing import placed_partner
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
from affectsim_data.builders.sources import SourceGiven, find_sources
from affectsim_data.motions import EMOTIONS, Emotion, Motion

__all__ = [
    "Cast",
    "CastJob",
    "CastPlan",
    "MadeMotions",
    "finish_cast",
    "make_cast",
    "make_motions",
    "plan_cast",
    "planned_performances",
]

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
    reserved: float
    seed: tuple[int, ...]


@dataclasses.dataclass(frozen=True)
class _Pair:
    """An interaction to be acted by two."""

    performer_ids: tuple[str, str]
    emotion: Emotion
    take: int
    reserved: float
    seed: tuple[int, ...]


@dataclasses.dataclass(frozen=True)
class _Clip:
    """A performance to be imported."""

    corpus: CorpusRecipe
    files: tuple[CorpusFile, ...]
    """One, or those of target and partner."""


@dataclasses.dataclass(frozen=True)
class MadeMotions:
    """Motions of one performance, target first, with what screening said of each alone."""

    motions: tuple[Motion, ...]
    findings: tuple[tuple[Finding, ...], ...]
    jerkiness: tuple[Jerkiness, ...]


CastJob = _Solo | _Pair | _Clip
"""One performance to be acted or imported."""


@dataclasses.dataclass(frozen=True)
class CastPlan:
    """Performances to be made, in the order of the release."""

    jobs: tuple[CastJob, ...]
    left_out: str = ""
    """Files of corpora that their recipes leave out, counted."""


def make_cast(
    recipe: Recipe, avatars: Sequence[Avatar], *, source: SourceGiven = None, jobs: int = 1
) -> Cast:
    """All performances of a recipe, those of its corpora and the procedural ones, screened.

    Args:
        recipe: Says what is performed.
        avatars: Bodies, taken in turn by performers.
        source: Folders of the corpora, for recipes that read some.
        jobs: Processes.

    Raises:
        FileNotFoundError: There is no such folder, or nothing of the corpus in it.
        ValueError: The recipe has a corpus and no source was given, or does not fit its files.
    """
    plan = plan_cast(recipe, source)
    thresholds = load_thresholds(recipe.document.get("screening"))
    task = functools.partial(make_motions, recipe=recipe, thresholds=thresholds)
    results = list(run_parallel(task, plan.jobs, jobs, "motions", recipe.name))
    return finish_cast(recipe, results, avatars, left_out=plan.left_out)


def plan_cast(recipe: Recipe, source: SourceGiven = None) -> CastPlan:
    """What is to be acted or imported; opens no motion file.

    Raises:
        FileNotFoundError: As `make_cast`.
        ValueError: As `make_cast`.
    """
    jobs: list[CastJob] = []
    left_out = []
    if recipe.corpora:
        folders = find_sources(recipe, source)
        for corpus in recipe.corpora:
            scan = scan_corpus(corpus, folders[corpus.name])
            left_out.append(f"{corpus.name}: {scan.summary()}")
            jobs += [_Clip(corpus, files) for files in scan.clips()]
    if "performances" in recipe.document:
        jobs += _procedural(recipe)
    return CastPlan(tuple(jobs), "; ".join(left_out))


def planned_performances(recipe: Recipe) -> list[tuple[str, str]]:
    """Action and performer, or target, of everything the recipe's `[performances]` ask for."""
    if "performances" not in recipe.document:
        return []
    return [
        (job.action, job.performer_id)
        if isinstance(job, _Solo)
        else ("interaction", job.performer_ids[0])
        for job in _procedural(recipe)
        if not isinstance(job, _Clip)
    ]


def finish_cast(
    recipe: Recipe,
    results: Sequence[MadeMotions | FailedFile],
    avatars: Sequence[Avatar],
    *,
    left_out: str = "",
) -> Cast:
    """The cast of what `make_motions` gave for every job, in order.

    Args:
        recipe: Of the release.
        results: Motions, with files that could not be read.
        avatars: Bodies, taken in turn by performers.
        left_out: Of the plan.
    """
    thresholds = load_thresholds(recipe.document.get("screening"))
    made = [result for result in results if isinstance(result, MadeMotions)]
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


def _procedural(recipe: Recipe) -> list[CastJob]:
    """What the recipe's `[performances]` ask for, one table or several.

    Every take has random numbers of its own: whether somebody is reserved in anger says nothing of
    the same person in fear.
    """
    work: list[CastJob] = []
    num_people = num_pairs = 0
    for table, where in _tables(recipe):
        takes = _takes(table, where)
        reserved = float(table.get("reserved_takes", 1.0))
        people = list(enumerate(table.get("performers", ()), num_people))
        pairs = list(enumerate(table.get("pairs", ()), num_pairs))
        for (number, who), (place, action) in itertools.product(
            people, enumerate(table.get("actions", ()))
        ):
            for turn in range(takes.get(action, 1)):
                count = _NUM_VARIANTS.get(action)
                take = turn if count is None else (number + turn) % count
                solo = (recipe.seed, 1, number, place, turn)
                work += [
                    _Solo(who, action, emotion, take, reserved, (*solo, label))
                    for label, emotion in enumerate(EMOTIONS)
                ]
        for number, (target, partner) in pairs:
            for turn in range(takes.get("interaction", 1)):
                take = (number + turn) % NUM_DYADS
                pair = (recipe.seed, 2, number, turn)
                work += [
                    _Pair((target, partner), emotion, take, reserved, (*pair, label))
                    for label, emotion in enumerate(EMOTIONS)
                ]
        num_people += len(people)
        num_pairs += len(pairs)
    return work


def _tables(recipe: Recipe) -> list[tuple[Mapping[str, Any], str]]:
    """The recipe's `[performances]`, one or several `[[performances]]`, and how errors call each.

    Raises:
        ValueError: A table has an unknown key.
    """
    entries = recipe.document.get("performances", ())
    if isinstance(entries, Mapping):
        tables = [(entries, f"{recipe.path}: [performances]")]
    else:
        tables = [
            (entry, f"{recipe.path}: [[performances]] {number}")
            for number, entry in enumerate(entries, 1)
        ]
    for table, where in tables:
        if unknown := sorted(set(table) - set(_PERFORMANCE_KEYS)):
            raise ValueError(
                f"{where} has unknown keys {', '.join(unknown)}; "
                f"it takes {', '.join(_PERFORMANCE_KEYS)}"
            )
    return tables


def _takes(table: Mapping[str, Any], where: str) -> dict[str, int]:
    """Takes of each action, 1 where the table says nothing.

    Raises:
        ValueError: An unknown action, or more takes than an action has variants.
    """
    takes: dict[str, int] = table.get("takes", {})
    actions = [*table.get("actions", ()), "interaction"]
    for action, count in takes.items():
        most = _NUM_VARIANTS.get(action)
        if action not in actions:
            raise ValueError(f"{where} takes has {action!r}; expected one of {', '.join(actions)}")
        if most is not None and count > most:
            raise ValueError(
                f"{where} takes of {action!r}: there are {most} different "
                f"ones, got {count}; ask for at most {most}, or name more performers"
            )
    return takes


def make_motions(
    job: CastJob, *, recipe: Recipe, thresholds: Thresholds
) -> MadeMotions | FailedFile:
    """Acts or imports one performance and screens it; the same every time.

    Args:
        job: Of `plan_cast`.
        recipe: Of the release.
        thresholds: Of the screening.
    """
    if isinstance(job, _Clip):
        return _import(job, thresholds)
    motions = tuple(motion.rounded() for motion in _act(job, recipe))
    return MadeMotions(
        motions,
        tuple(
            screen_motion(motion, source=None, joints=None, thresholds=thresholds)
            for motion in motions
        ),
        tuple(jerkiness(motion) for motion in motions),
    )


def _import(job: _Clip, thresholds: Thresholds) -> MadeMotions | FailedFile:
    try:
        imported = import_clip(job.corpus, job.files)
    except ValueError as error:
        return FailedFile(job.files[0].path, job.files[0].relative, str(error))
    motions = tuple(one.motion.rounded() for one in imported)
    findings = []
    for motion, one in zip(motions, imported, strict=True):
        joints = job.corpus.joint_map(one.source.joint_names)
        findings.append(
            screen_motion(motion, source=one.source, joints=joints, thresholds=thresholds)
        )
    return MadeMotions(motions, tuple(findings), tuple(jerkiness(motion) for motion in motions))


def _act(job: _Solo | _Pair, recipe: Recipe) -> tuple[Motion, ...]:
    rng = np.random.default_rng(job.seed)
    if isinstance(job, _Solo):
        return (
            perform(
                job.action,
                job.emotion,
                job.performer_id,
                take=job.take,
                rng=rng,
                collection=recipe.name,
                reserved_takes=job.reserved,
            ),
        )
    dyad = perform_dyad(
        job.emotion,
        job.performer_ids,
        take=job.take,
        rng=rng,
        collection=recipe.name,
        reserved_takes=job.reserved,
    )
    # Spacing belongs to what is performed: partners are placed alike in every emotion, and their
    # motion says where in front of the target they are.
    return dyad.target, placed_partner(dyad.partner, dyad.T_target_partner)


def _report(
    made: Sequence[MadeMotions], failures: Sequence[FailedFile], thresholds: Thresholds
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
    made: Sequence[MadeMotions], report: ScreenReport, avatars: Sequence[Avatar], recipe: Recipe
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
    named = list(
        dict.fromkeys(who for table, _ in _tables(recipe) for who in table.get("performers", ()))
    )
    roles = {_role(motion, recipe) for one in motions for motion in one}
    ordered = [(name, "") for name in named] + sorted(roles - {(name, "") for name in named})
    return {role: avatars[place % len(avatars)] for place, role in enumerate(ordered)}


def _role(motion: Motion, recipe: Recipe) -> tuple[str, str]:
    """Who keeps one body: a performer; in a corpus, whose actors may be unnamed, an action too."""
    return motion.performer_id, motion.action if recipe.corpora else ""
