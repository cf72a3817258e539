"""A catalogue of furniture models that stand in for the parametric pieces of a home."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from affectsim_data.builders.homes.catalogue.entries import CatalogueEntry, library_entries
from affectsim_data.builders.homes.catalogue.kinds import SEATS, TABLES, WALL_HUNG
from affectsim_data.builders.homes.catalogue.models import (
    fitted,
    lightened,
    to_parts,
    triangle_budget,
)
from affectsim_data.builders.homes.catalogue.surfaces_on_top import height_map, seats_on, top_of
from affectsim_data.builders.homes.parts import merged
from affectsim_data.builders.homes.pieces import Furniture, piece
from affectsim_data.builders.meshes import MeshLimits, read_mesh_from

__all__ = ["Catalogue", "read_catalogue"]

Size = tuple[float, float, float]
_LIMITS = MeshLimits(
    max_file_bytes=64 * 2**20,
    max_json_bytes=2**22,
    max_nodes=5_000,
    max_triangles=400_000,
    max_vertices=1_200_000,
    texture_side=512,
    max_texture_bytes=2**27,
)
"""A model beyond these is left out."""
_LAMP_SHARE = 0.85
"""A lamp shines from this share of its height unless the catalogue says where."""


@dataclasses.dataclass(eq=False)
class Catalogue:
    """Furniture models with their real sizes; models are read when they are first asked for."""

    name: str
    """What messages call it: its path."""
    entries: tuple[CatalogueEntry, ...]
    """Models of categories this knows, in the order of their libraries."""
    left_out: dict[str, str]
    """Models that cannot be used, with the reason; grows as models are read."""
    _made: dict[tuple[str, str], Furniture | None] = dataclasses.field(default_factory=dict)

    def __getstate__(self) -> dict[str, Any]:
        """What was made stays behind: elsewhere the same is made again."""
        return {**self.__dict__, "_made": {}}

    @property
    def licences(self) -> Mapping[str, str]:
        """Licence of every model by its id, as the library states it."""
        return {entry.entry_id: entry.licence for entry in self.entries}

    @property
    def categories(self) -> tuple[str, ...]:
        """What there is at least one model of, in alphabetical order."""
        return tuple(sorted({kind for entry in self.entries for kind in entry.kinds}))

    def piece(
        self, category: str, *, rng: np.random.Generator, max_size: Size, least_share: float = 0.55
    ) -> Furniture | None:
        """A model of that category, its front towards +Z, or none that fits.

        Args:
            category: `chair`, `sofa`, `table`, ...
            rng: Chooses among those that fit; drawn from once, whatever comes of it.
            max_size: Largest width, depth and height, metres.
            least_share: No extent may be smaller than this share of the largest.

        Raises:
            MissingExtraError: A model has too many triangles and the extra `build` is missing.
        """
        low = tuple(least_share * extent for extent in max_size)
        fits = [
            entry
            for entry in self.entries
            if category in entry.kinds
            and entry.size is not None
            and all(a <= x <= b for a, x, b in zip(low, _reach(entry), max_size, strict=True))
        ]
        for index in rng.permutation(len(fits)):
            made = self.furniture(fits[int(index)], category)
            if made is not None:
                return made
        return None

    def furniture(self, entry: CatalogueEntry, category: str) -> Furniture | None:
        """One model as a piece of that category; none if it turns out unusable."""
        key = (entry.entry_id, category)
        if key not in self._made:
            try:
                self._made[key] = _furniture(entry, category)
            except (ValueError, FileNotFoundError) as error:
                self.left_out[entry.entry_id] = str(error)
                self._made[key] = None
        return self._made[key]


def _reach(entry: CatalogueEntry) -> Size:
    """Width, depth, and height above the floor."""
    assert entry.size is not None
    return entry.size[0], entry.size[1], entry.size[2] + entry.elevation_m


def _furniture(entry: CatalogueEntry, category: str) -> Furniture:
    asset = read_mesh_from(entry.files, entry.model, label=entry.entry_id, limits=_LIMITS)
    shapes, size = fitted(asset, entry)
    if entry.elevation_m > 0.05 and not set(entry.kinds) & WALL_HUNG:
        raise ValueError(f"hangs {entry.elevation_m:g} m above the floor")
    parts = to_parts(lightened(shapes, triangle_budget(size)))
    whole = merged(parts)
    reach = (size[0], size[1], size[2] + entry.elevation_m)
    seats, tops = [], []
    if {category, *entry.kinds} & (SEATS | TABLES):
        view = height_map(whole.positions, whole.faces, size)
        if category in SEATS:
            seats = list(seats_on(view, places=category in ("sofa", "bench")))
            if not seats and category != "stool":
                raise ValueError(f"a {category} without a seat 0.33 to 0.56 m high")
        elif category in TABLES:
            tops = [top for top in [top_of(view, height=entry.top_m)] if top is not None]
    lamp_y = (entry.light_y or _LAMP_SHARE * size[2]) if category == "lamp" else None
    made = piece(category, parts, reach, seats=seats, tops=tops, lamp_y=lamp_y)
    credit = f"{entry.name} by {entry.creator}" if entry.creator else entry.name
    return dataclasses.replace(made, licence=entry.licence or "unknown", credit=credit)


def read_catalogue(path: Path) -> Catalogue:
    """The furniture of a Sweet Home 3D library, of a folder of such, or of a folder of models.

    Args:
        path: An `.sh3f` file, a folder of them, an unpacked one, or a folder of OBJ and GLB models
            with `catalogue.toml`, `catalogue.csv` or sizes in their names (`chair_45x50x90cm.obj`:
            width, depth, height).

    Raises:
        FileNotFoundError: There is no such file or folder.
        ValueError: There is no furniture in it; the message starts with `path`.
    """
    path = Path(path).expanduser()
    if not path.exists():
        raise FileNotFoundError(f"{path}: no such furniture library or folder")
    libraries = sorted(path.glob("*.sh3f")) if path.is_dir() else []
    left_out: dict[str, str] = {}
    entries: list[CatalogueEntry] = []
    for library in libraries or [path]:
        entries += library_entries(library, left_out=left_out)
    if not entries:
        reasons = "; ".join(f"{name}: {why}" for name, why in list(left_out.items())[:3])
        raise ValueError(
            f"{path}: no furniture that can be used" + (f" ({reasons})" if reasons else "")
        )
    unique: dict[str, CatalogueEntry] = {}
    for entry in entries:
        if unique.setdefault(entry.entry_id, entry) is not entry:
            left_out[f"{entry.entry_id}, again"] = "its id is there twice"
    return Catalogue(str(path), tuple(unique.values()), left_out)
