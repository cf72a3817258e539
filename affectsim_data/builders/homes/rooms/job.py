"""One room to furnish, and what every kind of room gets: curtains, pictures, plants, rugs."""

from __future__ import annotations

import dataclasses
from functools import partial

import numpy as np

from affectsim_data.builders.homes import chairs, decor, lamps, plants, storage, textiles
from affectsim_data.builders.homes.pieces import Design, Furniture, Workshop
from affectsim_data.builders.homes.placed import Placed
from affectsim_data.builders.homes.placing import RoomFloor
from affectsim_data.builders.homes.plans import RoomPlan, Wall

__all__ = ["CHAIRS", "FLOOR_LAMPS", "SHELVES", "TABLE_LAMPS", "Job"]

CHAIRS: tuple[Design, ...] = (
    chairs.chair_slatted, chairs.chair_shell, chairs.chair_spindle, chairs.chair_padded,
    chairs.chair_steel,
)  # fmt: skip
FLOOR_LAMPS: tuple[Design, ...] = (
    lamps.floor_lamp, lamps.floor_lamp_tripod, lamps.floor_lamp_arc,
)  # fmt: skip
TABLE_LAMPS: tuple[Design, ...] = (lamps.table_lamp, lamps.table_lamp_ball)
SHELVES: tuple[Design, ...] = (
    storage.bookshelf, storage.ladder_shelf, storage.cube_shelf, storage.glass_cabinet,
)  # fmt: skip
_PLANTS: tuple[Design, ...] = (
    plants.plant_bladed, plants.plant_sword, plants.plant_fig, plants.plant_palm,
)  # fmt: skip
_PICTURE_MIDDLE_Y = 1.6


@dataclasses.dataclass
class Job:
    """A room, the workshop that makes its pieces, and what the home has."""

    floor: RoomFloor
    shop: Workshop
    purposes: tuple[str, ...]
    """Of all rooms of the home."""
    lamp_places: tuple[tuple[float, float], ...]
    """Where ceiling lamps hang already, `(x, z)` metres."""
    compact: bool = False
    """Whether a first attempt left out what the room is for: smaller things are tried first."""

    @property
    def rng(self) -> np.random.Generator:
        """What draws everything."""
        return self.floor.rng

    @property
    def room(self) -> RoomPlan:
        """The empty room."""
        return self.floor.room

    @property
    def size(self) -> tuple[float, float]:
        """Shorter and longer side, metres."""
        sides = sorted((self.room.x1 - self.room.x0, self.room.z1 - self.room.z0))
        return (sides[0], sides[1])

    @property
    def area(self) -> float:
        """Square metres."""
        return self.size[0] * self.size[1]

    def chance(self, share: float) -> bool:
        """Whether something of that chance happens."""
        return bool(self.rng.random() < share)

    def make(self, *designs: Design, style: str | None = None) -> Furniture:
        """A piece of one of the designs."""
        return self.shop.make(*designs, style=style)

    def curtains(self) -> None:
        """Curtains at the windows that have them; before anything else."""
        for opening in self.room.openings:
            if opening.kind == "window" and opening.curtains:
                self.floor.drape(opening, self._curtain, self._rod)

    def _curtain(self, height: float) -> Furniture:
        return self.make(partial(textiles.curtain, height=height))

    def _rod(self, width: float) -> Furniture:
        return self.make(partial(textiles.curtain_rod, width=width))

    def walls_by_length(self) -> list[Wall]:
        """Longest first."""
        return sorted(self.room.walls(), key=lambda wall: -wall.length)

    def plants(self, most: int) -> None:
        """Up to so many plants in corners and before windows."""
        for _ in range(most):
            self.floor.at_wall(self.make(*_PLANTS), prefer="corner", windows=True)

    def floor_lamp(self, near: tuple[float, float] | None = None) -> None:
        """A standing lamp at a wall."""
        self.floor.at_wall(self.make(*FLOOR_LAMPS), prefer="corner", near=near, windows=True)

    def lamp_on(self, base: Placed) -> None:
        """A small lamp on a piece that has room for it."""
        self.floor.on_top(base, self.make(*TABLE_LAMPS, style="table lamp"))

    def shelf(self, *, widths: tuple[float, ...] = (0.9, 0.6), front: float = 0.5) -> bool:
        """A shelf at a wall, a narrower one where there is less room."""
        columns = {True: 2, False: 1}
        for width in widths:
            wide = width >= 0.8
            designs = (
                partial(storage.bookshelf, width=width),
                partial(storage.ladder_shelf, width=width),
                partial(
                    storage.cube_shelf, columns=columns[wide], rows=int(self.rng.integers(3, 6))
                ),
                partial(storage.glass_cabinet, width=max(width, 0.7)),
            )
            if self.floor.at_wall(self.make(*designs), prefer="corner", front=front) is not None:
                return True
        return False

    def rug_under(
        self, x: float, z: float, width: float, depth: float, *, yaw: float = 0.0
    ) -> bool:
        """The largest rug about a point that nothing stands half on."""
        for share in (1.0, 0.9, 0.8, 0.7, 0.6):
            if min(width, depth) * share < 0.55:
                break
            rug = self.make(partial(textiles.rug, width=width * share, depth=depth * share))
            if self.floor.lay(rug, x, z, yaw):
                return True
        return False

    def pictures(self, share: float = 0.8, *, most: int = 4) -> None:
        """Pictures, mirrors, clocks and boards on free stretches of wall."""
        hung = 0
        for wall in self.room.walls():
            for place in self.rng.permutation(np.linspace(0.15, 0.85, 6)):
                if hung >= most or not self.chance(share):
                    continue
                if self._hang_one(wall, float(place) * wall.length):
                    hung += 1

    def _hang_one(self, wall: Wall, u: float) -> bool:
        draw = float(self.rng.random())
        sizes = ((0.5, 0.7), (0.62, 0.82), (0.95, 0.68), (0.4, 0.4), (1.2, 0.8))
        width, height = sizes[int(self.rng.integers(len(sizes)))]
        design: Design = partial(decor.picture, width=width, height=height)
        depth, y, gap = 0.03, _PICTURE_MIDDLE_Y - height / 2.0, 0.35
        if draw < 0.12:
            width, height, depth, y, gap, design = 0.3, 0.3, 0.04, 1.75, 0.5, decor.clock
        elif draw < 0.27:
            depth, height, y, gap = 0.25, 0.42, 1.56, 0.4
            design = partial(decor.wall_board, width=width)
        if not self.floor.can_hang(wall, (width, depth, height), u, y, gap=gap):
            return False
        return self.floor.hang(wall, self.make(design), u, y, gap=gap)

    def spare_seat(self) -> None:
        """One more chair at a wall, beside the rugs; a stool where there is no room for it."""
        rugs = [p.rect() for p in self.floor.placed if p.piece.category == "rug"]
        self.floor.keep_free(*rugs)
        for designs in (CHAIRS, (chairs.stool,)):
            if self.floor.at_wall(self.make(*designs), windows=True) is not None:
                return

    def wall_behind(self, placed: Placed) -> Wall:
        """The wall that a piece turns its back to."""
        return min(self.room.walls(), key=lambda w: abs(np.sin((w.yaw - placed.yaw) / 2.0)))

    def along_wall(self, placed: Placed) -> float:
        """Where along that wall its middle is, metres."""
        wall = self.wall_behind(placed)
        return float((np.array([placed.x, 0.0, placed.z]) - wall.origin) @ wall.along)

    def picture_over(self, placed: Placed) -> bool:
        """A picture on the wall behind a piece, over its middle."""
        wall, u = self.wall_behind(placed), self.along_wall(placed)
        wide = placed.piece.width > 1.2
        width, height = (0.95, 0.68) if wide else (0.5, 0.6)
        piece = self.make(partial(decor.picture, width=width, height=height))
        low = max(placed.top_y + 0.12, _PICTURE_MIDDLE_Y - height / 2.0)
        return self.floor.hang(wall, piece, u, low)

    def bare_of_lamps(self, x: float, z: float, gap: float = 0.55) -> bool:
        """Whether no ceiling lamp is near a point."""
        return all(np.hypot(x - a, z - b) > gap for a, b in self.lamp_places)
