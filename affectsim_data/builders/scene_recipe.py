"""`[scenes]` of a recipe: homes of our own, the scenes of a Habitat dataset, or mesh files."""

from __future__ import annotations

import dataclasses
import fnmatch
import zlib
from collections.abc import Mapping, Sequence
from typing import Literal, get_args

from affectsim_data.builders.recipe_keys import check_keys, typed_fields

__all__ = ["SceneRecipe", "read_scene_recipe"]

SceneKind = Literal["homes", "habitat", "meshes"]


@dataclasses.dataclass(frozen=True)
class SceneRecipe:
    """Where the scenes of a release come from, and what is done to them; keys of `[scenes]`."""

    name: str = ""
    """What `--source` calls them and their ids start with; the recipe's name if empty."""
    catalogue: bool = False
    """Whether homes take furniture from a catalogue in the user's own folder."""
    include: tuple[str, ...] = ("*",)
    """Patterns of scene names, of which one must match."""
    exclude: tuple[str, ...] = ()
    """Patterns of scene names, of which none may match."""
    count: int | None = None
    """How many of these, always the same ones for a seed; all if not given."""
    shell: bool = False
    """Whether scenes without a stage get a floor and walls around their objects."""
    drop_nodes: tuple[str, ...] = ()
    """Patterns of nodes of mesh files to leave out."""
    max_triangles: int | None = None
    """Scenes with more are simplified."""
    licence: str = ""
    """Of the scenes, SPDX where there is one; empty takes what the files say."""
    redistribution: bool = True
    """Whether a release that holds these scenes may be passed on."""
    citation: str = ""
    obtain: str = ""
    """Where the files come from."""

    kind: SceneKind = "homes"
    """`homes` are generated; `habitat` and `meshes` are read from the user's own copy."""
    files: str = ""
    """Name of the homes file; pattern of the dataset's config; pattern of the mesh files."""

    @property
    def needs_source(self) -> bool:
        """Whether there is something of the user's own to read."""
        return self.kind != "homes" or self.catalogue

    def wants(self, name: str) -> bool:
        """Whether a scene of that name is to be imported."""
        return _matches(name, self.include) and not _matches(name, self.exclude)

    def chosen(self, scene_ids: Sequence[str], seed: int) -> list[str]:
        """Which of the scenes that are wanted are imported, in the order given.

        With `count`, those with the lowest hashes: who has more scenes, or lacks one, gets the
        same others.

        Args:
            scene_ids: Of the scenes there are and that `wants` lets pass.
            seed: Of the recipe.

        Raises:
            ValueError: There are fewer than `count`.
        """
        if self.count is None:
            return list(scene_ids)
        if len(scene_ids) < self.count:
            raise ValueError(
                f"{self.name}: {len(scene_ids)} of {self.count} scenes are there; complete your "
                "copy, or set another count in [scenes]"
            )
        ranked = sorted(scene_ids, key=lambda one: (zlib.crc32(f"{seed}/{one}".encode()), one))
        kept = set(ranked[: self.count])
        return [one for one in scene_ids if one in kept]


def _matches(name: str, patterns: tuple[str, ...]) -> bool:
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)


def read_scene_recipe(table: object, *, where: str) -> SceneRecipe:
    """The table of a recipe.

    Raises:
        ValueError: It does not say what it must; the message starts with `where`.
    """
    kinds = get_args(SceneKind)
    keys = {field.name for field in dataclasses.fields(SceneRecipe)} - {"kind", "files"}
    check_keys(table, {*kinds, *keys}, where=where)
    assert isinstance(table, Mapping)
    named = [kind for kind in kinds if kind in table]
    if len(named) != 1:
        listed = ", ".join(named) or "none"
        raise ValueError(f"{where} must have exactly one of {', '.join(kinds)}, got {listed}")
    files = table[named[0]]
    if not isinstance(files, str) or not files:
        raise ValueError(f"{where} {named[0]} must be a text, got {files!r}")
    rest = {key: value for key, value in table.items() if key != named[0]}
    try:
        fields = typed_fields(SceneRecipe, rest, before="kind")
    except ValueError as error:
        raise ValueError(f"{where} {error}") from error
    return SceneRecipe(**fields, kind=named[0], files=files)
