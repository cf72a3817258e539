"""Recipes of motion corpora: what has to be known to read one, as a TOML file says it."""

from __future__ import annotations

import dataclasses
import re
import string
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args

from affectsim_data.builders.recipe_keys import check_keys, check_texts, typed_fields
from affectsim_data.content import content_names, content_path
from affectsim_data.motions.motion import EMOTIONS, Emotion
from affectsim_data.motions.retargeting import REQUIRED_JOINTS
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["CORPUS_TABLES", "ROLES", "CorpusFormat", "CorpusRecipe", "Role", "load_recipe"]

CorpusFormat = Literal["bvh", "smpl_npz"]
Role = Literal["target", "partner"]
"""Of two people in one recording: whose emotion is the label, and the other."""
ROLES: tuple[Role, ...] = get_args(Role)
CORPUS_TABLES = frozenset(
    {
        *("corpus", "labels", "excluded", "actions", "excluded_actions", "roles", "joints"),
        *("ignore", "files"),
    }
)
"""Tables of a TOML file that say how a corpus is read; a release recipe has others beside them."""

_Needed = TypeVar("_Needed")
_TEMPLATES = (
    *("performer", "motion_id", "style", "action", "performance", "take", "group"),
    *("pair", "role"),
)


@dataclasses.dataclass(frozen=True)
class CorpusRecipe:
    """What has to be known to read a corpus; the tables of its TOML file.

    Fields up to `unlabelled` are the keys of `[corpus]`; those without a default must be there.
    Templates are filled with the named groups of `pattern`, and with what `[files]` and `table`
    say of a file.
    """

    name: str
    """Short name; motion ids start with it."""
    licence: str
    """SPDX where there is one."""
    redistribution: bool
    """Whether a release that holds these motions may be passed on."""
    pattern: re.Pattern[str]
    """Matches the path of a file inside the corpus."""
    performer: str
    """Template of the performer id."""
    motion_id: str
    """Template of the rest of the motion id."""
    fps: float
    """Rate of the motions that come out."""
    metres_per_unit: float
    up_axis: str
    """`y` or `z`."""
    format: CorpusFormat = "bvh"
    citation: str = ""
    obtain: str = ""
    """Where the corpus comes from, and what to do with it before it is read."""
    style: str = "{style}"
    """Template of the word looked up in `[labels]` and `[excluded]`."""
    action: str = "{action}"
    """Template of the word looked up in `[actions]` and `[excluded_actions]`."""
    performance: str = ""
    """Template of what is performed, more closely than the action."""
    take: str = ""
    """Template of the number of the take; empty counts, in order of paths, from 0."""
    group: str = ""
    """Template of what splits may not share; empty: the pair, else the motion itself."""
    pair: str = ""
    """Template of what two files have in common that show two people at once, recorded together in
    one space; empty: everybody is alone."""
    role: str = ""
    """Template of the word looked up in `[roles]`; files of pairs need it."""
    table: str = ""
    """CSV or TSV file with a column `file`, in the corpus, else beside the recipe."""
    unlabelled: Literal["error", "exclude"] = "error"
    """What happens with a file nothing gives a label or an action."""
    skip_frames: int = 0
    """First frames of every file that are no performance, such as a T-pose put in front."""
    max_travel_m: float | None = None
    """Walks are cut this far from their start; None for never."""
    height_m: Sequence[float] = (1.2, 2.2)
    """Statures that pass; one outside means a wrong unit."""
    floor_m: float = 0.15
    """How far from height zero the lowest foot may be."""

    recipe_path: str = "recipe"
    """Where it was read from, for messages."""
    labels: Mapping[str, Emotion] = dataclasses.field(default_factory=dict)
    """Emotion of a style."""
    excluded: Mapping[str, str] = dataclasses.field(default_factory=dict)
    """Reason a style is left out."""
    actions: Mapping[str, str] = dataclasses.field(default_factory=dict)
    """Our word for a source's action."""
    excluded_actions: Mapping[str, str] = dataclasses.field(default_factory=dict)
    """Reason an action is left out."""
    roles: Mapping[str, Role] = dataclasses.field(
        default_factory=lambda: {role: role for role in ROLES}
    )
    """`target` or `partner` for a source's word; these two words if not given."""
    joints: Mapping[str, str | Sequence[str]] = dataclasses.field(default_factory=dict)
    """Source joint of a canonical joint, or names it may have, the first there counts."""
    ignore: Mapping[str, str] = dataclasses.field(default_factory=dict)
    """Reason why files whose path matches a pattern are no clips of their own."""
    files: Mapping[str, Mapping[str, Any]] = dataclasses.field(default_factory=dict)
    """Groups of single files, by path or name."""

    def joint_map(self, joint_names: Sequence[str]) -> dict[str, str]:
        """Source joint of each canonical joint for a file with these joints.

        Raises:
            ValueError: A joint is not in the file, or one serves two canonical joints.
        """
        there = set(joint_names)
        found: dict[str, str] = {}
        lacking = []
        for joint, names in self.joints.items():
            choices = [names] if isinstance(names, str) else list(names)
            match = next((name for name in choices if name in there), None)
            if match is not None:
                found[joint] = match
            elif joint in REQUIRED_JOINTS or isinstance(names, str):
                lacking.append(f"{joint} = {' or '.join(map(repr, choices))}")
        if lacking:
            raise ValueError(
                f"[joints] of {self.recipe_path} names joints that are not there: "
                f"{', '.join(lacking)}; the file has {', '.join(joint_names)}"
            )
        users: dict[str, list[str]] = {}
        for joint, name in found.items():
            users.setdefault(name, []).append(joint)
        twice = {name: joints for name, joints in users.items() if len(joints) > 1}
        if twice:
            raise ValueError(f"[joints] of {self.recipe_path} uses joints twice: {twice}")
        return found


def load_recipe(recipe: Path | str | Mapping[str, Any], *, where: str = "recipe") -> CorpusRecipe:
    """The corpus recipe of a name in `builders/`, in a TOML file, or in tables already read.

    Args:
        recipe: Name, path ending in .toml, or tables.
        where: What messages call tables already read: their file.

    Raises:
        FileNotFoundError: There is no such file; the recipes there are are listed.
        ValueError: A table or key is missing or unknown, or a value does not fit; names file and
            key, and suggests the key that may be meant.
    """
    if isinstance(recipe, Mapping):
        return _from_tables(recipe, where)
    path = _find(recipe)
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{path}: not TOML: {error}") from error
    return _from_tables(tables, str(path))


def _find(recipe: Path | str) -> Path:
    path = Path(recipe)
    if path.suffix == ".toml":
        if not path.is_file():
            raise FileNotFoundError(f"{path}: no such recipe")
        return path
    names = []
    for name in content_names("builders", ".toml"):
        text = content_path("builders", f"{name}.toml").read_text(encoding="utf-8")
        names += [name] if "\n[corpus]" in f"\n{text}" else []
    if str(recipe) not in names:
        raise FileNotFoundError(
            f"no corpus recipe {str(recipe)!r}: expected a path ending in .toml or one of "
            f"{', '.join(names)}"
        )
    return content_path("builders", f"{recipe}.toml")


def _from_tables(tables: Mapping[str, Any], name: str) -> CorpusRecipe:
    needed = {"corpus", "labels", "actions"}
    if isinstance(tables.get("corpus"), Mapping) and tables["corpus"].get("format") != "smpl_npz":
        needed.add("joints")
    if lacking := sorted(needed - set(tables)):
        raise ValueError(f"{name}: expected the tables {sorted(needed)}, got none of {lacking}")
    if "compose" not in tables:  # a release recipe has tables of its own, checked where it is read
        check_keys(tables, CORPUS_TABLES, where=name)
    texts = {key: tables.get(key, {}) for key in CORPUS_TABLES - {"corpus", "joints", "files"}}
    texts["roles"] = tables.get("roles", {role: role for role in ROLES})
    for key, table in texts.items():
        check_texts(table, where=f"{name}: [{key}]")
    same = {joint: joint for joint in JOINT_NAMES}
    try:
        recipe = CorpusRecipe(
            **typed_fields(CorpusRecipe, tables["corpus"], before="recipe_path"),
            recipe_path=name,
            joints=tables.get("joints", same),
            files=tables.get("files", {}),
            **texts,
        )
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: [corpus] {error}") from error
    _check_values(recipe)
    _check_words(recipe)
    _check_templates(recipe)
    _check_joints(recipe)
    return recipe


def _check_values(recipe: CorpusRecipe) -> None:
    """Raises unless numbers and choices are of the kinds there are."""
    for key, choices in (
        ("up_axis", ("y", "z")),
        ("format", get_args(CorpusFormat)),
        ("unlabelled", ("error", "exclude")),
    ):
        if getattr(recipe, key) not in choices:
            raise ValueError(
                f"{recipe.recipe_path}: [corpus] {key} must be one of {', '.join(choices)}, "
                f"got {getattr(recipe, key)!r}"
            )
    for key in ("fps", "metres_per_unit", "floor_m", "max_travel_m"):
        value = getattr(recipe, key)
        if value is not None and not 0.0 < value < 1e6:
            raise ValueError(f"{recipe.recipe_path}: [corpus] {key} must be positive, got {value}")
    if len(recipe.height_m) != 2 or not 0.0 < recipe.height_m[0] < recipe.height_m[1]:
        raise ValueError(
            f"{recipe.recipe_path}: [corpus] height_m must be a low and a high number of metres, "
            f"got {recipe.height_m}"
        )


def _check_words(recipe: CorpusRecipe) -> None:
    """Raises unless labels are emotions, roles are roles and no word is both taken and left out."""
    for style, emotion in recipe.labels.items():
        if emotion not in EMOTIONS:
            raise ValueError(
                f"{recipe.recipe_path}: label {style!r} maps to {emotion!r}; expected one of "
                f"{', '.join(EMOTIONS)}; to leave it out, add it to [excluded] with a reason"
            )
    for taken, left in (("labels", "excluded"), ("actions", "excluded_actions")):
        both = sorted(set(getattr(recipe, taken)) & set(getattr(recipe, left)))
        if both:
            raise ValueError(f"{recipe.recipe_path}: {both} stand in both [{taken}] and [{left}]")
    for word, role in recipe.roles.items():
        if role not in ROLES:
            raise ValueError(
                f"{recipe.recipe_path}: role {word!r} must be one of {', '.join(ROLES)}, "
                f"got {role!r}"
            )
    if bool(recipe.pair) != bool(recipe.role):
        raise ValueError(
            f"{recipe.recipe_path}: [corpus] pair and role go together, got pair = "
            f"{recipe.pair!r} and role = {recipe.role!r}"
        )
    for pattern in recipe.ignore:
        try:
            re.compile(pattern)
        except re.error as error:
            raise ValueError(
                f"{recipe.recipe_path}: [ignore] {pattern!r} is no regular expression: {error}"
            ) from error


def _check_templates(recipe: CorpusRecipe) -> None:
    """Raises unless the pattern has the groups templates name; a table may add others."""
    for key in _TEMPLATES:
        template = getattr(recipe, key)
        try:
            fields = {field for _, field, _, _ in string.Formatter().parse(template) if field}
        except ValueError as error:
            raise ValueError(
                f"{recipe.recipe_path}: [corpus] {key} is no template: {error}, got {template!r}"
            ) from error
        lacking = sorted(fields - set(recipe.pattern.groupindex))
        if lacking and not recipe.files and not recipe.table:
            raise ValueError(
                f"{recipe.recipe_path}: pattern needs the named groups {lacking}, which {key} "
                f"= {template!r} uses; or [files] or a table must give them"
            )


def _check_joints(recipe: CorpusRecipe) -> None:
    """Raises unless `[joints]` maps body joints, and all that retargeting needs."""
    where = f"{recipe.recipe_path}: [joints]"
    check_keys(recipe.joints, JOINT_NAMES, where=where)
    for joint, names in recipe.joints.items():
        listed = [names] if isinstance(names, str) else names
        if not isinstance(listed, Sequence) or not all(isinstance(n, str) and n for n in listed):
            raise ValueError(f"{where} {joint} must be a name or a list of names, got {names!r}")
    if lacking := sorted(REQUIRED_JOINTS - set(recipe.joints)):
        raise ValueError(f"{where} expected a source joint for {lacking}")
