"""Recipes: what a release is made of, as a TOML file."""

from __future__ import annotations

import dataclasses
import tomllib
from pathlib import Path
from typing import Any

from affectsim_data.builders.compositions import Composition, read_compositions, read_split_rule
from affectsim_data.builders.corpus_recipe import CORPUS_TABLES, load_recipe
from affectsim_data.builders.scene_recipe import SceneRecipe, read_scene_recipe
from affectsim_data.cameras import Camera
from affectsim_data.content import content_names, content_path
from affectsim_data.episodes import Robot
from affectsim_data.releases.manifest import Source

__all__ = ["Recipe", "Thresholds", "read_recipe"]

_KNOWN = {
    *("name", "seed", "camera", "robot", "scenes", "avatars", "performances", "screening"),
    *("splits", "thresholds", "compose"),
    *CORPUS_TABLES,
}


@dataclasses.dataclass(frozen=True)
class Thresholds:
    """When a challenge holds, measured at x0 over the motion cycle; DESIGN section 4."""

    far_distance_m: float = 5.0
    near_m: float = 1.5
    """Nearest start of rear_view and partial_occlusion."""
    far_m: float = 5.0
    """Farthest start of rear_view and partial_occlusion."""
    rear_bearing_deg: float = 135.0
    visible: float = 0.5
    """Least visible share of far_visible and rear_view."""
    occluded_low: float = 0.15
    occluded_high: float = 0.6
    in_image: float = 0.9
    """Least share of a partly hidden body inside the image: the scene hides it, not the border."""
    detour_ratio: float = 1.4
    """Least geodesic over straight way to the 1 m ring."""
    grounded_visible: float = 0.3
    """Least visible share of action-grounded and dyadic starts."""


@dataclasses.dataclass(frozen=True)
class Recipe:
    """A release to be built."""

    name: str
    seed: int
    camera: Camera
    robot: Robot
    scenes: SceneRecipe
    """Where its scenes come from."""
    avatar_ids: tuple[str, ...]
    """Baked bodies; performers take them in turn."""
    thresholds: Thresholds
    compositions: tuple[Composition, ...]
    """None: a release of scenes alone."""
    document: dict[str, Any]
    """The whole file: motions have tables of their own."""
    path: Path
    """Where it was read."""

    @property
    def redistribution(self) -> bool:
        """Whether the release may be passed on; the corpus and scenes it reads, if any, say so.

        Raises:
            ValueError: The corpus tables do not say what they must.
        """
        corpus = "corpus" not in self.document or load_recipe(self.path).redistribution
        return corpus and self.scenes.redistribution

    @property
    def sources(self) -> tuple[Source, ...]:
        """Where its motions and scenes come from, and on what terms.

        Raises:
            ValueError: The corpus tables do not say what they must.
        """
        found = []
        if "corpus" in self.document:
            corpus = load_recipe(self.path)
            found.append(
                Source(
                    corpus.name,
                    "motions",
                    corpus.licence,
                    corpus.redistribution,
                    corpus.citation,
                    corpus.obtain,
                )
            )
        if self.scenes.needs_source:
            one = self.scenes
            found.append(
                Source(
                    self.name,
                    "scenes",
                    one.licence,
                    one.redistribution,
                    one.citation,
                    one.obtain,
                )
            )
        return tuple(found)

    def with_shell(self) -> Recipe:
        """The recipe with a floor and walls built around scenes that lack their stage.

        Raises:
            ValueError: Its scenes are not of a Habitat dataset.
        """
        if self.scenes.kind != "habitat":
            raise ValueError(
                f"{self.path}: --shell is for scenes of Habitat datasets, "
                f"those of this recipe are {self.scenes.kind}"
            )
        return dataclasses.replace(self, scenes=dataclasses.replace(self.scenes, shell=True))


def read_recipe(recipe: str | Path) -> Recipe:
    """A recipe by the name of a file in `builders/`, or by path.

    Raises:
        FileNotFoundError: There is no such file; the recipes there are are listed.
        ValueError: The file does not say what it must.
    """
    path = _find(recipe)
    with path.open("rb") as stream:
        try:
            document = tomllib.load(stream)
        except tomllib.TOMLDecodeError as error:
            raise ValueError(f"{path}: not TOML: {error}") from error
    if unknown := sorted(set(document) - _KNOWN):
        raise ValueError(f"{path}: unknown entries: {', '.join(unknown)}")
    try:
        return _from_document(document, path)
    except (KeyError, TypeError) as error:
        raise ValueError(f"{path}: {error} is missing or malformed") from error


def _find(recipe: str | Path) -> Path:
    path = Path(recipe)
    if path.suffix == ".toml":
        if not path.is_file():
            raise FileNotFoundError(f"{path}: no such recipe")
        return path
    names = [name for name in content_names("builders", ".toml") if _is_release(name)]
    if str(recipe) not in names:
        raise FileNotFoundError(
            f"no recipe {str(recipe)!r}: expected a path ending in .toml or one of "
            f"{', '.join(names)}"
        )
    return content_path("builders", f"{recipe}.toml")


def _is_release(name: str) -> bool:
    return "\n[scenes]\n" in content_path("builders", f"{name}.toml").read_text(encoding="utf-8")


def _from_document(document: dict[str, Any], path: Path) -> Recipe:
    compose = document.get("compose", ())
    splits = document.get("splits")
    default = None if splits is None else read_split_rule(splits, where=f"{path}: [splits]")
    compositions = read_compositions(compose, default, where=str(path))
    return Recipe(
        name=document["name"],
        seed=int(document["seed"]),
        camera=Camera.from_json(document["camera"]),
        robot=Robot(**document.get("robot", {})),
        scenes=read_scene_recipe(document["scenes"], where=f"{path}: [scenes]"),
        avatar_ids=tuple(document["avatars"]["ids"]) if compose else (),
        thresholds=Thresholds(**document.get("thresholds", {})),
        compositions=compositions,
        document=document,
        path=path,
    )
