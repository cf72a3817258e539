"""Recipes of motion corpora: what has to be known to read one, as a TOML file says it."""

from __future__ import annotations

import dataclasses
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from affectsim_data.motions.motion import EMOTIONS, Emotion

__all__ = ["CorpusRecipe", "load_recipe"]

_TABLES = {"corpus", "labels", "excluded", "actions", "joints"}


@dataclasses.dataclass(frozen=True)
class CorpusRecipe:
    """What has to be known to read a corpus; the tables of its TOML file."""

    recipe_path: str
    """Where it was read from, for messages."""
    name: str
    """Short name; motion ids start with it."""
    licence: str
    """SPDX where there is one."""
    redistribution: bool
    """Whether a release that holds these motions may be passed on."""
    pattern: re.Pattern[str]
    """Matches the path of a file inside the corpus; groups `action`, `style`, and what `performer`
    and `motion_id` name."""
    performer: str
    """Template of the performer id, filled with the groups of `pattern`."""
    motion_id: str
    """Template of the rest of the motion id."""
    fps: float
    """Rate of the motions that come out."""
    metres_per_unit: float
    up_axis: str
    max_travel_m: float | None
    """Walks are cut this far from their start; None for never."""
    height_m: tuple[float, float]
    """Statures that pass; one outside means a wrong unit."""
    floor_m: float
    """How far from height zero the lowest foot may be."""
    labels: Mapping[str, Emotion]
    """Emotion of a style."""
    excluded: Mapping[str, str]
    """Reason a style is left out."""
    actions: Mapping[str, str]
    """Our word for a source's action."""
    joints: Mapping[str, str]
    """Source joint of a canonical joint."""


def load_recipe(recipe: Path | str | Mapping[str, Any]) -> CorpusRecipe:
    """The recipe in a TOML file, or in tables already read.

    Raises:
        ValueError: A table or key is missing, or a value does not fit; names file and key.
    """
    name = "recipe"
    if not isinstance(recipe, Mapping):
        name = str(recipe)
        recipe = tomllib.loads(Path(recipe).read_text(encoding="utf-8"))
    lacking = sorted(_TABLES - set(recipe))
    if lacking:
        raise ValueError(f"{name}: expected the tables {sorted(_TABLES)}, got none of {lacking}")
    corpus = recipe["corpus"]
    try:
        low, high = corpus.get("height_m", (1.2, 2.2))
        loaded = CorpusRecipe(
            recipe_path=name,
            name=corpus["name"],
            licence=corpus["licence"],
            redistribution=_boolean(corpus["redistribution"]),
            pattern=re.compile(corpus["pattern"]),
            performer=corpus["performer"],
            motion_id=corpus["motion_id"],
            fps=float(corpus["fps"]),
            metres_per_unit=float(corpus["metres_per_unit"]),
            up_axis=corpus["up_axis"],
            max_travel_m=corpus.get("max_travel_m"),
            height_m=(float(low), float(high)),
            floor_m=float(corpus.get("floor_m", 0.15)),
            labels=recipe["labels"],
            excluded=recipe["excluded"],
            actions=recipe["actions"],
            joints=recipe["joints"],
        )
    except KeyError as error:
        raise ValueError(f"{name}: [corpus] needs the key {error.args[0]!r}") from error
    except TypeError as error:
        raise ValueError(f"{name}: [corpus] {error}") from error
    except re.error as error:
        raise ValueError(f"{name}: [corpus] pattern is no regular expression: {error}") from error
    _check_labels(loaded)
    return loaded


def _boolean(value: object) -> bool:
    # A text such as "false" would count as true, and the motions would be passed on.
    if not isinstance(value, bool):
        raise TypeError(f"redistribution must be true or false, got {value!r}")
    return value


def _check_labels(recipe: CorpusRecipe) -> None:
    """Raises unless every label is an emotion and no style is both taken and left out."""
    for style, emotion in recipe.labels.items():
        if emotion not in EMOTIONS:
            raise ValueError(
                f"{recipe.recipe_path}: label {style!r} maps to {emotion!r}; expected one of "
                f"{', '.join(EMOTIONS)}"
            )
    both = sorted(set(recipe.labels) & set(recipe.excluded))
    if both:
        raise ValueError(f"{recipe.recipe_path}: {both} stand in both [labels] and [excluded]")
    lacking = {"action", "style"} - set(recipe.pattern.groupindex)
    if lacking:
        raise ValueError(f"{recipe.recipe_path}: pattern needs the named groups {sorted(lacking)}")
