"""Which files of a folder a corpus recipe takes, with what labels, and why it leaves out others."""

from __future__ import annotations

import collections
import dataclasses
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Literal

from affectsim_data.builders.corpus_recipe import ROLES, CorpusRecipe, Role
from affectsim_data.builders.corpus_table import FileTable, read_file_table
from affectsim_data.motions.motion import Emotion

__all__ = ["CorpusFile", "CorpusScan", "LeftOut", "raise_problems", "scan_corpus"]

MAX_LISTED_PROBLEMS = 20
SUFFIXES = {"bvh": ".bvh", "smpl_npz": ".npz"}
_Cause = Literal["style", "action", "ignored", "unlabelled", "unmatched", "unpaired"]


@dataclasses.dataclass(frozen=True)
class CorpusFile:
    """One file a recipe takes, with its labels."""

    path: Path
    relative: str
    """Path inside the corpus, with slashes."""
    motion_id: str
    performer_id: str
    group_id: str
    """What splits may not share."""
    emotion: Emotion
    action: str
    performance: str
    take: int
    pair: str = ""
    """What it has in common with the file of the other person; empty for somebody alone."""
    role: Role = "target"


@dataclasses.dataclass(frozen=True)
class LeftOut:
    """Files that are no clips of the corpus, or that nobody wants, for one reason."""

    cause: _Cause
    """The recipe leaves out the style or the action; ignores the file; nothing labels it; its path
    does not match the pattern; the other person's file is not there."""
    word: str
    """The style, the action, or the pattern."""
    reason: str
    count: int
    example: str
    """Path inside the corpus of the first."""


@dataclasses.dataclass(frozen=True)
class CorpusScan:
    """What a recipe finds in a folder."""

    files: tuple[CorpusFile, ...]
    """Files to read, sorted by path."""
    left_out: tuple[LeftOut, ...]
    """Other files with the suffix of the format: every one is counted."""
    rows_without_file: tuple[str, ...] = ()
    """Files a table names that are not there, or that are left out."""

    def clips(self) -> list[tuple[CorpusFile, ...]]:
        """The files by what they show: one, or target and partner; in the order of paths."""
        pairs: dict[str, list[CorpusFile]] = {}
        for file in self.files:
            pairs.setdefault(file.pair or file.motion_id, []).append(file)
        return [
            tuple(sorted(files, key=lambda one: ROLES.index(one.role))) for files in pairs.values()
        ]

    def counts(self) -> dict[tuple[str, str], int]:
        """Files to read by action and emotion, sorted."""
        found = collections.Counter((file.action, file.emotion) for file in self.files)
        return dict(sorted(found.items()))

    def excluded(self, *causes: _Cause) -> dict[str, int]:
        """Files left out for these causes, or any, by word."""
        found: collections.Counter[str] = collections.Counter()
        for one in self.left_out:
            if not causes or one.cause in causes:
                found[one.word] += one.count
        return dict(sorted(found.items()))

    def summary(self) -> str:
        """What is taken and what is not, in a line."""
        by_cause: dict[str, list[str]] = {}
        for one in self.left_out:
            by_cause.setdefault(one.cause, []).append(f"{one.word} {one.count}")
        parts = [f"{cause}: {', '.join(words)}" for cause, words in sorted(by_cause.items())]
        count = sum(one.count for one in self.left_out)
        line = f"{len(self.files)} files taken, {count} left out ({'; '.join(parts) or 'none'})"
        if self.rows_without_file:
            line += f"; rows without a file: {len(self.rows_without_file)}"
        return line


def scan_corpus(recipe: CorpusRecipe, source: Path | str) -> CorpusScan:
    """The files of a folder that a recipe takes, labelled by path and table; opens none of them.

    Raises:
        FileNotFoundError: No such folder, or none of its files matches the recipe's pattern.
        ValueError: Labels, actions or takes the recipe does not know, identifiers that repeat:
            listed together, each with the way out.
    """
    source = Path(source)
    if not source.is_dir():
        raise FileNotFoundError(
            f"{recipe.name}: expected a folder with the corpus at {source}, got nothing there"
        )
    paths = [path for path in source.rglob("*") if path.is_file()]
    suffix = SUFFIXES[recipe.format]
    clips = sorted(
        (path.relative_to(source).as_posix(), path)
        for path in paths
        if path.suffix.lower() == suffix
    )
    sorting = _Sorting(recipe, read_file_table(recipe, source))
    for relative, path in clips:
        sorting.add(relative, path)
    if not sorting.matched:
        raise FileNotFoundError(
            f"{recipe.name}: expected files named like {recipe.pattern.pattern!r} in {source}, "
            f"got none among {len(paths)} files, {len(clips)} of them {suffix}"
        )
    files = sorting.finished()
    raise_problems(recipe.recipe_path, list(sorting.problems))
    left_out = tuple(
        LeftOut(cause, word, reason, len(found), found[0])
        for (cause, word, reason), found in sorted(sorting.left_out.items())
    )
    return CorpusScan(files, left_out, sorting.table.unused)


class _Sorting:
    """Files sorted into those to read and those to leave out, and what is wrong."""

    def __init__(self, recipe: CorpusRecipe, table: FileTable) -> None:
        self.recipe = recipe
        self.table = table
        self.matched = 0
        self.files: list[CorpusFile] = []
        self.left_out: dict[tuple[_Cause, str, str], list[str]] = {}
        self.problems: dict[str, None] = {}

    def add(self, relative: str, path: Path) -> None:
        recipe = self.recipe
        for pattern, reason in recipe.ignore.items():
            if re.fullmatch(pattern, relative):
                self._leave("ignored", pattern, reason, relative)
                return
        match = recipe.pattern.fullmatch(relative)
        if match is None:
            reason = "its path does not match [corpus] pattern"
            self._leave("unmatched", recipe.pattern.pattern, reason, relative)
            return
        self.matched += 1
        named = {key: value for key, value in match.groupdict(default="").items() if value}
        groups = {**dict.fromkeys(match.groupdict(), ""), **named, **self.table.groups(relative)}
        try:
            self._sort(relative, path, groups)
        except (KeyError, IndexError, AttributeError, ValueError) as error:
            self._problem(f"{relative}: a template does not fit {groups}: {error!r}")

    def _sort(self, relative: str, path: Path, groups: Mapping[str, str]) -> None:
        recipe = self.recipe
        style, action = (_word(one, groups) for one in (recipe.style, recipe.action))
        if style in recipe.excluded:
            self._leave("style", style, recipe.excluded[style], relative)
        elif action in recipe.excluded_actions:
            self._leave("action", action, recipe.excluded_actions[action], relative)
        elif not style or not action:
            self._unlabelled("no label" if not style else "no action", relative)
        elif style not in recipe.labels:
            self._problem(f"label {style!r} maps to no emotion; add it to [labels] or [excluded]")
        elif action not in recipe.actions:
            self._problem(
                f"action {action!r} has no word; add it to [actions] or [excluded_actions]"
            )
        else:
            self._take(relative, path, groups, style, action)

    def _take(
        self, relative: str, path: Path, groups: Mapping[str, str], style: str, action: str
    ) -> None:
        recipe = self.recipe
        take = recipe.take.format_map(groups)
        if take and not (take.isascii() and take.isdigit()):
            self._problem(f"{relative}: take must be a whole number, got {take!r}")
            return
        role = recipe.role.format_map(groups)
        if role and role not in recipe.roles:
            self._problem(f"role {role!r} is neither target nor partner; add it to [roles]")
            return
        motion_id = f"{recipe.name}/{recipe.motion_id.format_map(groups)}"
        pair = recipe.pair.format_map(groups)
        group = recipe.group.format_map(groups) or pair
        self.files.append(
            CorpusFile(
                path=path,
                relative=relative,
                motion_id=motion_id,
                performer_id=recipe.performer.format_map(groups),
                group_id=f"{recipe.name}/{group}" if group else motion_id,
                emotion=recipe.labels[style],
                action=recipe.actions[action],
                performance=recipe.performance.format_map(groups),
                take=int(take) if take else -1,
                pair=f"{recipe.name}/{pair}" if pair else "",
                role=recipe.roles[role] if role else "target",
            )
        )

    def finished(self) -> tuple[CorpusFile, ...]:
        """The files to read, takes counted where the recipe does not number them."""
        first: dict[str, str] = {}
        takes: collections.Counter[tuple[str, ...]] = collections.Counter()
        files = []
        for file in self._paired():
            if file.motion_id in first:
                self._problem(
                    f"{file.relative} and {first[file.motion_id]} give the same motion id "
                    f"{file.motion_id!r}; put what tells them apart into motion_id"
                )
            first.setdefault(file.motion_id, file.relative)
            role = (file.performer_id, file.action, file.performance, file.emotion)
            files.append(dataclasses.replace(file, take=takes[role]) if file.take < 0 else file)
            takes[role] += 1
        return tuple(files)

    def _paired(self) -> list[CorpusFile]:
        """The files without those whose other person is not there."""
        pairs: dict[str, list[CorpusFile]] = {}
        for file in self.files:
            if file.pair:
                pairs.setdefault(file.pair, []).append(file)
        for pair, files in pairs.items():
            roles = [file.role for file in files]
            listed = ", ".join(file.relative for file in files)
            if len(set(roles)) < len(roles):
                self._problem(f"pair {pair!r} must have one target and one partner, got {listed}")
            elif lacking := [role for role in ROLES if role not in roles]:
                reason = f"pair without a {lacking[0]}"
                self._leave("unpaired", pair, reason, files[0].relative)
        alone = {pair for pair, files in pairs.items() if len(files) == 1}
        return [file for file in self.files if file.pair not in alone]

    def _unlabelled(self, what: str, relative: str) -> None:
        if self.recipe.unlabelled == "exclude":
            note = f"; {self.table.note}" if self.table.note else ""
            reason = f"neither name, [files] nor table labels it{note}"
            self._leave("unlabelled", what, reason, relative)
        else:
            self._problem(
                f"{relative}: {what}; name the file in [files] or a table, or set "
                'unlabelled = "exclude"'
            )

    def _leave(self, cause: _Cause, word: str, reason: str, relative: str) -> None:
        self.left_out.setdefault((cause, word, reason), []).append(relative)

    def _problem(self, message: str) -> None:
        self.problems[message] = None


def _word(template: str, groups: Mapping[str, str]) -> str:
    """A template filled; empty where nothing gives a group of it."""
    try:
        return template.format_map(groups)
    except KeyError:
        return ""


def raise_problems(name: str, problems: Iterable[str], *, hint: str = "") -> None:
    """Raises one ValueError that lists problems, up to 20, and the way out; none raise nothing."""
    problems = list(problems)
    if not problems:
        return
    if len(problems) == 1:
        problem = problems[0] if name in problems[0] else f"{name}: {problems[0]}"
        raise ValueError(f"{problem}; {hint}" if hint else problem)
    listed = "".join(f"\n  {problem}" for problem in problems[:MAX_LISTED_PROBLEMS])
    more = len(problems) - MAX_LISTED_PROBLEMS
    tail = f"\n  and {more} more" if more > 0 else ""
    tail += f"\n{hint}" if hint else ""
    raise ValueError(f"{name}: {len(problems)} problems:{listed}{tail}")
