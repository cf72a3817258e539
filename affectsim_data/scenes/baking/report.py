"""What baking did to a scene, in numbers."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from affectsim_data.scenes.surfaces import Surface

__all__ = ["BakeCounts", "BakeLoss", "BakeReport"]


@dataclasses.dataclass(frozen=True)
class BakeCounts:
    """The size of a scene."""

    triangles: int
    vertices: int
    surfaces: int
    """What is drawn in one call each, culling aside."""
    textures: int
    """Different ones."""
    texels: int
    """Of all different textures."""
    num_bytes: int
    """Of its arrays and textures in memory."""

    @classmethod
    def of(cls, surfaces: Sequence[Surface]) -> BakeCounts:
        """The size of some surfaces; a texture that several share counts once."""
        textures = {id(one.texture): one.texture for one in surfaces if one.texture is not None}
        arrays = [
            array
            for one in surfaces
            for array in (one.positions, one.normals, one.colors, one.faces, one.uvs)
            if array is not None
        ]
        return cls(
            triangles=sum(len(one.faces) for one in surfaces),
            vertices=sum(len(one.positions) for one in surfaces),
            surfaces=len(surfaces),
            textures=len(textures),
            texels=sum(one.shape[0] * one.shape[1] for one in textures.values()),
            num_bytes=sum(one.nbytes for one in (*arrays, *textures.values())),
        )


@dataclasses.dataclass(frozen=True)
class BakeLoss:
    """How far a decimated scene is from what it was, over points drawn on both by area."""

    mean_mm: float
    """Mean distance to the other mesh."""
    max_mm: float
    """Largest distance to the other mesh."""
    mean_levels: float
    """Mean difference of the vertex colours there, of 255."""
    points: int
    """How many were drawn."""


@dataclasses.dataclass(frozen=True)
class BakeReport:
    """What baking did to a scene."""

    scene_id: str
    before: BakeCounts
    after: BakeCounts
    loss: BakeLoss | None = None
    """`None` if no triangle was decimated."""
    notes: tuple[str, ...] = ()
    """What was dropped, replaced or made smaller, with counts."""

    def lines(self) -> list[str]:
        """For a terminal: counts before and after, the loss, the notes."""
        found = [f"{self.scene_id}: baked"]
        for field in dataclasses.fields(BakeCounts):
            old, new = getattr(self.before, field.name), getattr(self.after, field.name)
            found.append(f"  {field.name.removeprefix('num_'):<10} {old:>13,} -> {new:>13,}")
        if self.loss is not None:
            found.append(
                f"  decimation moved the surface by {self.loss.mean_mm:.2f} mm on average, "
                f"{self.loss.max_mm:.1f} mm at most, colours by {self.loss.mean_levels:.1f} of 255 "
                f"({self.loss.points:,} points)"
            )
        return found + [f"  {note}" for note in self.notes]

    def to_json(self) -> dict[str, Any]:
        """Plain dictionaries, lists and numbers."""
        return {**dataclasses.asdict(self), "notes": list(self.notes)}
