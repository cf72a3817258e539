"""Whether folders hold what a recipe asks for: all that lacks, counted, before hours of work.

Only names of files are looked at, and the stages of Habitat scenes. What lacks later, because a
file cannot be read or a motion fails its screening, is told when that is known.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from affectsim_data.builders.casting import planned_performances
from affectsim_data.builders.compositions import Composition
from affectsim_data.builders.corpora import CorpusFile, CorpusRecipe, scan_corpus
from affectsim_data.builders.corpus_scan import CorpusScan, raise_problems
from affectsim_data.builders.habitat.stages import missing_stage
from affectsim_data.builders.recipes import Recipe
from affectsim_data.builders.scene_sources import HabitatScene, found_scenes, read_habitat
from affectsim_data.builders.sources import SourceGiven, find_sources

__all__ = ["check_inventory"]

_LISTED = 8
"""Names in a line."""


@dataclasses.dataclass(frozen=True)
class _Shelf:
    """A corpus and what was found of it."""

    corpus: CorpusRecipe
    scan: CorpusScan

    def targets(self, composition: Composition) -> list[CorpusFile]:
        """Motions of some actions and emotions, partners apart."""
        return [
            one
            for one in self.scan.files
            if one.role == "target"
            and one.action in composition.actions
            and one.emotion in composition.emotions
        ]

    def words(self, table: Mapping[str, str], word: str) -> str:
        """The corpus' own words for one of ours."""
        return " or ".join(repr(own) for own, ours in table.items() if ours == word)


def check_inventory(
    recipe: Recipe, source: SourceGiven, *, skip_broken: bool = False
) -> tuple[Recipe, tuple[str, ...]]:
    """The recipe, if all that it counts on is there.

    Args:
        recipe: Of the release.
        source: The user's own copies.
        skip_broken: Whether to go on with what there is.

    Returns:
        The recipe, with as many scenes as there are, and a line for everything that lacks.

    Raises:
        FileNotFoundError: A folder is not there, or holds nothing of the source.
        ValueError: Something lacks: all of it, up to 20 lines.
    """
    folders = find_sources(recipe, source)
    shelves, lacking = _shelves(recipe, folders)
    acted = _acted(recipe)
    for composition in recipe.compositions:
        lacking += _motion_gaps(composition, shelves, acted)
    scenes, gaps = _scene_gaps(recipe, folders)
    lacking += gaps
    if lacking and not skip_broken:
        hint = (
            "complete the folders, change the counts in a copy of the recipe, or add "
            "--skip-broken to build what there is"
        )
        if recipe.scenes.kind == "habitat" and not recipe.scenes.shell:
            hint += "; --shell builds floor and walls where a stage is missing"
        raise_problems(f"recipe {recipe.name!r}", lacking, hint=hint)
    return scenes, tuple(lacking)


def _shelves(recipe: Recipe, folders: Mapping[str, Path]) -> tuple[list[_Shelf], list[str]]:
    """What is found of every corpus, and what makes one unusable.

    Raises:
        FileNotFoundError: Nothing of a corpus is in its folder, for any of the corpora.
    """
    shelves, absent, lacking = [], [], []
    for corpus in recipe.corpora:
        try:
            shelves.append(_Shelf(corpus, scan_corpus(corpus, folders[corpus.name])))
        except FileNotFoundError as error:
            absent.append(str(error))
        except ValueError as error:
            lacking.append(str(error))
    if absent:
        raise FileNotFoundError("\n".join([*absent, *lacking]))
    return shelves, lacking


def _motion_gaps(
    composition: Composition, shelves: Sequence[_Shelf], acted: Mapping[str, Counter[str]]
) -> list[str]:
    """What lacks for the counts of one `[[compose]]`."""
    serving = [
        one for one in shelves if set(composition.actions) & set(one.corpus.actions.values())
    ]
    if not serving:
        return []
    called = "/".join(one.corpus.name for one in serving)
    found = [(shelf, file) for shelf in serving for file in shelf.targets(composition)]
    lacking = [
        f"{called}: no motion of {action!r}{_said(serving, 'actions', action)}"
        for action in composition.actions
        if action not in acted and all(file.action != action for _, file in found)
    ]
    performers = {file.performer_id for _, file in found}
    for action in composition.actions:
        performers |= set(acted.get(action, ()))
    if composition.split_rule.by == "performer":
        lacking += _performer_gaps(composition, performers, called)
        if composition.episodes is not None:
            lacking += [line for shelf in serving for line in _emotion_gaps(composition, shelf)]
    if composition.motions is not None:
        wanted = sum(composition.motions.values())
        total = len(found) + sum(acted[a].total() for a in composition.actions if a in acted)
        if total < wanted:
            pairs = any(shelf.corpus.pair for shelf in serving)
            what = "sequences" if pairs else f"motions of {', '.join(composition.actions)}"
            lacking.append(f"{called}: {total} of {wanted} {what}{_unpaired(serving)}")
    return lacking


def _performer_gaps(composition: Composition, there: set[str], called: str) -> list[str]:
    members = composition.split_rule.members.values()
    wanted = sum(value for value in members if isinstance(value, int))
    named = {name for value in members if not isinstance(value, int) for name in value}
    lacking = []
    if len(there - named) < wanted:
        lacking.append(f"{called}: {len(there)} of {wanted} performers: {_listed(sorted(there))}")
    if named - there:
        lacking.append(f"{called}: no motion of {_listed(sorted(named - there))}")
    return lacking


def _emotion_gaps(composition: Composition, shelf: _Shelf) -> list[str]:
    """Actions that a performer of a corpus does not show in every emotion the corpus has."""
    corpus = shelf.corpus
    there = {(one.performer_id, one.action, one.emotion) for one in shelf.targets(composition)}
    emotions = [one for one in composition.emotions if one in corpus.labels.values()]
    lacking = []
    for action in composition.actions:
        if action not in corpus.actions.values():
            continue
        for who in sorted({performer for performer, _, _ in there}):
            gone = [emotion for emotion in emotions if (who, action, emotion) not in there]
            if gone:
                words = ", ".join(shelf.words(corpus.labels, emotion) for emotion in gone)
                own = shelf.words(corpus.actions, action)
                lacking.append(f"{corpus.name}: {action}: no file under {own} for {who} in {words}")
    return lacking


def _said(serving: Sequence[_Shelf], table: str, word: str) -> str:
    """How the corpora call something, in brackets."""
    words = [shelf.words(getattr(shelf.corpus, table), word) for shelf in serving]
    listed = " or ".join(filter(None, words))
    return f" (expected files of {listed})" if listed else ""


def _unpaired(serving: Sequence[_Shelf]) -> str:
    """Sequences left out because one of their files lacks."""
    alone = [one for shelf in serving for one in shelf.scan.left_out if one.cause == "unpaired"]
    if not alone:
        return ""
    return f"; {len(alone)} lack a file: {_listed([f'{one.word} ({one.reason})' for one in alone])}"


def _acted(recipe: Recipe) -> dict[str, Counter[str]]:
    """Motions of the recipe's own performances, by action and performer."""
    counts: dict[str, Counter[str]] = {}
    for action, performer in planned_performances(recipe):
        counts.setdefault(action, Counter())[performer] += 1
    return counts


def _scene_gaps(recipe: Recipe, folders: Mapping[str, Path]) -> tuple[Recipe, list[str]]:
    """The recipe with as many scenes as there are, and what lacks."""
    scenes = recipe.scenes
    if scenes.kind == "homes":
        return recipe, []
    folder = folders[scenes.name]
    found = {one.scene_id: one for one in found_scenes(recipe, folder)}
    lacking = []
    if scenes.count is not None and len(found) < scenes.count:
        lacking.append(f"{scenes.name}: {len(found)} of {scenes.count} scenes")
        scenes = dataclasses.replace(scenes, count=len(found))
    if not scenes.shell:
        chosen = [found[one] for one in scenes.chosen(list(found), recipe.seed)]
        lacking += _stage_gaps(scenes.name, chosen)
    return dataclasses.replace(recipe, scenes=scenes), lacking


def _stage_gaps(called: str, chosen: Sequence[HabitatScene | object]) -> list[str]:
    gone, broken = [], []
    for one in chosen:
        if isinstance(one, HabitatScene):
            try:
                lacks = missing_stage(read_habitat(one.dataset), one.handle)
            except ValueError as error:
                broken.append(f"{called}: {error}")
                continue
            gone += [f"{one.name} ({lacks})"] if lacks else []
    if gone:
        broken.insert(
            0, f"{called}: stage missing for {len(gone)} of {len(chosen)} scenes: {_listed(gone)}"
        )
    return broken


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return (", ".join(names[:_LISTED]) or "none") + more
