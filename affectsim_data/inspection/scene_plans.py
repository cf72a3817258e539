"""A scene from above: its plan with rooms, furniture and where a robot can go, and how it looks."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable

import numpy as np
import shapely
from numpy.typing import ArrayLike
from PIL import Image, ImageDraw, ImageFont

from affectsim_data.inspection.scene_views import view_from_above
from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray
from affectsim_data.render import Renderer
from affectsim_data.scenes import Door, Scene, SceneObject, Seat

__all__ = [
    "PLAN_FINE",
    "PlanFrame",
    "draw_floor",
    "draw_plan",
    "draw_scale",
    "floor_areas_m2",
    "scene_sheet",
]

PLAN_FINE = 3
"""Lines are drawn this much larger and scaled down."""
_MARGIN_M, _WALL_M = 0.35, 0.14
_HIGH_M = 1.9
"""What hangs higher is left out of the plan."""
_HEADER, _FOOTER = 34, 46

_INK, _PAPER, _QUIET, _WALL = (30, 30, 34), (250, 250, 248), (110, 110, 118), (58, 58, 64)
_ROOM_COLORS = {
    "living": (245, 232, 208),
    "kitchen": (222, 234, 222),
    "dining": (240, 222, 210),
    "bedroom": (220, 226, 240),
    "bath": (210, 234, 238),
    "study": (232, 224, 240),
    "hall": (236, 236, 230),
}
_OTHER_ROOM = (238, 238, 232)
_FURNITURE, _FURNITURE_EDGE, _RUG = (214, 206, 196), (120, 110, 100), (232, 224, 214)
_MAIN_ISLAND = (0, 140, 130)
_OTHER_ISLANDS = ((213, 94, 0), (204, 121, 167), (0, 114, 178), (230, 159, 0), (86, 180, 233))
_SEAT, _DOOR = (160, 60, 40), (150, 96, 40)
_LEGEND = (
    (_MAIN_ISLAND, "robot's middle: largest island"),
    (_OTHER_ISLANDS[0], "other islands"),
    (_FURNITURE, "furniture"),
    (_SEAT, "seat, and where it looks"),
    (_DOOR, "door, and where to knock"),
)


@dataclasses.dataclass(frozen=True)
class PlanFrame:
    """How the plan `(x, z)`, metres, comes onto the picture: +x to the right, +z down.

    The picture is drawn in fine pixels, `PLAN_FINE` to one of the result.
    """

    low: FloatArray
    scale: float
    """Fine pixels to a metre."""
    size: tuple[int, int]
    """Fine pixels."""

    @classmethod
    def around(cls, points: FloatArray, *, width: int, height: int) -> PlanFrame:
        """The frame that shows points `(n, 2)`, metres, as large as fits `height` x `width`."""
        low, high = points.min(axis=0) - _MARGIN_M, points.max(axis=0) + _MARGIN_M
        box = np.array([width, height]) * PLAN_FINE
        scale = float(np.min(box / np.maximum(high - low, 1e-3)))
        middle = (low + high) / 2.0
        return cls(middle - box / scale / 2.0, scale, (int(box[0]), int(box[1])))

    def __call__(self, plan: ArrayLike) -> list[tuple[float, float]]:
        """Points of the plan, `(n, 2)` or one, in fine pixels."""
        points = (np.asarray(plan, np.float64).reshape(-1, 2) - self.low) * self.scale
        return [(float(x), float(y)) for x, y in points]


def scene_sheet(
    scene: Scene, navmesh: NavMesh, renderer: Renderer | None = None, *, size: int = 720
) -> Image.Image:
    """The plan of a scene and, with a renderer, beside it the scene without its ceiling.

    Args:
        scene: What to draw.
        navmesh: Where a robot can go in it.
        renderer: Draws the view from above; the plan alone without one.
        size: Of each picture, pixels.
    """
    pictures = [draw_plan(scene, navmesh, width=size, height=size)]
    if renderer is not None:
        view = view_from_above(scene, renderer, width=size, height=size)
        pictures.append(Image.fromarray(view))
    sheet = Image.new("RGB", (size * len(pictures), _HEADER + size + _FOOTER), _PAPER)
    for place, picture in enumerate(pictures):
        sheet.paste(picture, (place * size, _HEADER))
    draw = ImageDraw.Draw(sheet)
    draw.text((10, 8), _title(scene, navmesh), fill=_INK, font=ImageFont.load_default(size=16))
    _draw_legend(draw, sheet.width, sheet.height - _FOOTER + 8)
    return sheet


def draw_plan(scene: Scene, navmesh: NavMesh, *, width: int, height: int) -> Image.Image:
    """Rooms, furniture, doors, seats and the islands of the navmesh, `height` x `width` pixels."""
    frame = PlanFrame.around(_extent(scene, navmesh), width=width, height=height)
    picture = Image.new("RGB", frame.size, _PAPER)
    rooms = _draw_rooms(ImageDraw.Draw(picture), frame, scene)
    picture = _with_islands(picture, frame, navmesh)
    draw = ImageDraw.Draw(picture)
    _draw_contents(draw, frame, scene)
    _label_rooms(draw, frame, scene, rooms)
    draw_scale(draw, frame)
    return picture.resize((width, height), Image.Resampling.LANCZOS)


def draw_floor(scene: Scene, frame: PlanFrame) -> Image.Image:
    """Rooms, furniture, doors and seats, in fine pixels, to draw more on top."""
    picture = Image.new("RGB", frame.size, _PAPER)
    draw = ImageDraw.Draw(picture)
    _draw_rooms(draw, frame, scene)
    _draw_contents(draw, frame, scene)
    return picture


def _draw_rooms(draw: ImageDraw.ImageDraw, frame: PlanFrame, scene: Scene) -> list[shapely.Polygon]:
    """Draws walls and floors, and returns the floors."""
    rooms = [shapely.Polygon(room.polygon) for room in scene.rooms]
    _draw_walls(draw, frame, scene, rooms)
    for room, polygon in zip(scene.rooms, rooms, strict=True):
        _fill(draw, frame, polygon, _ROOM_COLORS.get(room.purpose, _OTHER_ROOM))
    return rooms


def _draw_contents(draw: ImageDraw.ImageDraw, frame: PlanFrame, scene: Scene) -> None:
    for thing in sorted(scene.objects, key=lambda one: one.position[1] + one.size[1]):
        _draw_object(draw, frame, thing)
    for door in scene.doors:
        _draw_door(draw, frame, door)
    for seat in scene.seats:
        _draw_seat(draw, frame, seat)


def floor_areas_m2(scene: Scene, navmesh: NavMesh) -> list[float]:
    """Areas of islands on the floor, largest first: a robot may fit on a bed, but not get there.

    Of a scene whose islands all lie higher, all count.
    """
    top = max(room.floor_y for room in scene.rooms) + navmesh.settings.max_climb
    islands = zip(navmesh.islands, navmesh.island_areas_m2, strict=True)
    low = [area for island, area in islands if island.median_y <= top]
    return low or list(navmesh.island_areas_m2)


def _title(scene: Scene, navmesh: NavMesh) -> str:
    areas = floor_areas_m2(scene, navmesh)
    floor = sum(shapely.Polygon(room.polygon).area for room in scene.rooms)
    rooms = f"{len(scene.rooms)} room{'s' * (len(scene.rooms) != 1)}"
    return (
        f"{scene.scene_id}   {rooms}, {floor:.0f} m2   {scene.num_triangles:,} triangles   "
        f"robot: {sum(areas):.1f} m2, {areas[0] / sum(areas):.1%} of it one island"
    )


def _extent(scene: Scene, navmesh: NavMesh) -> FloatArray:
    """Points `(n, 2)` of the plan that have to be in the picture."""
    corners = [np.array(room.polygon) for room in scene.rooms]
    bounds = [np.array(polygon.bounds).reshape(2, 2) for polygon in navmesh.polygons]
    return np.concatenate([*corners, *bounds])


def _draw_walls(
    draw: ImageDraw.ImageDraw, frame: PlanFrame, scene: Scene, rooms: list[shapely.Polygon]
) -> None:
    whole = shapely.union_all([room.buffer(_WALL_M, join_style="mitre") for room in rooms])
    _fill(draw, frame, whole, _WALL)
    for doorway in scene.doorways:
        yaw = math.radians(doorway.yaw_deg)
        way = np.array([math.sin(yaw), math.cos(yaw)])
        across = np.array([way[1], -way[0]])
        middle = np.array([doorway.position[0], doorway.position[2]])
        half = doorway.depth / 2.0 + 0.02
        corners = [
            middle + sign * doorway.width / 2.0 * across + side * half * way
            for sign, side in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        draw.polygon(frame(corners), fill=_OTHER_ROOM)


def _fill(
    draw: ImageDraw.ImageDraw,
    frame: PlanFrame,
    shape: shapely.Geometry,
    color: tuple[int, ...],
) -> None:
    """Fills polygons without their holes; what is in the holes is drawn before or after."""
    for polygon in shapely.get_parts(shape):
        if polygon.area > 0.0:
            draw.polygon(frame(polygon.exterior.coords), fill=color)


def _with_islands(picture: Image.Image, frame: PlanFrame, navmesh: NavMesh) -> Image.Image:
    colors = [_MAIN_ISLAND, *_cycled(_OTHER_ISLANDS, len(navmesh.islands) - 1)]
    for polygon, color in zip(navmesh.polygons, colors, strict=True):
        mask = Image.new("L", frame.size, 0)
        cut = ImageDraw.Draw(mask)
        cut.polygon(frame(polygon.exterior.coords), fill=70)
        for hole in polygon.interiors:
            cut.polygon(frame(hole.coords), fill=0)
        picture = Image.composite(Image.new("RGB", frame.size, color), picture, mask)
        draw = ImageDraw.Draw(picture)
        for ring in (polygon.exterior, *polygon.interiors):
            draw.line(frame(ring.coords), fill=color, width=PLAN_FINE)
    return picture


def _cycled(colors: Iterable[tuple[int, ...]], count: int) -> list[tuple[int, ...]]:
    listed = list(colors)
    return [listed[place % len(listed)] for place in range(max(count, 0))]


def _draw_object(draw: ImageDraw.ImageDraw, frame: PlanFrame, thing: SceneObject) -> None:
    if thing.position[1] > _HIGH_M:
        return
    corners = frame(thing.footprint)
    flat = thing.size[1] < 0.05
    draw.polygon(corners, fill=_RUG if flat else _FURNITURE)
    draw.line([*corners, corners[0]], fill=_FURNITURE_EDGE, width=PLAN_FINE)
    label = thing.category.replace("_", " ")
    font = ImageFont.load_default(size=9 * PLAN_FINE)
    box = draw.textbbox((0, 0), label, font=font)
    spans = np.ptp(np.array(corners), axis=0)
    if label and box[2] - box[0] < spans[0] and box[3] - box[1] < spans[1] and not flat:
        middle = np.mean(np.array(corners), axis=0)
        draw.text((middle[0], middle[1]), label, fill=_QUIET, font=font, anchor="mm")


def _draw_door(draw: ImageDraw.ImageDraw, frame: PlanFrame, door: Door) -> None:
    """The leaf from its hinge; a closed one with a dot where one knocks."""
    hinge = np.array([door.hinge[0], door.hinge[2]])
    knock = np.array([door.knock_point[0], door.knock_point[2]])
    yaw = math.radians(door.yaw_deg)
    along = np.array([math.cos(yaw), -math.sin(yaw)])
    side = 1.0 if float((knock - hinge) @ along) >= 0.0 else -1.0
    draw.line(frame([hinge, hinge + side * door.width * along]), fill=_DOOR, width=3 * PLAN_FINE)
    if door.is_closed:
        way = np.array([math.sin(yaw), math.cos(yaw)])
        (x, y), reach = frame(knock + 0.25 * way)[0], 4 * PLAN_FINE
        draw.ellipse((x - reach, y - reach, x + reach, y + reach), fill=_DOOR)


def _draw_seat(draw: ImageDraw.ImageDraw, frame: PlanFrame, seat: Seat) -> None:
    """A triangle that points where a sitter looks."""
    yaw = math.radians(seat.yaw_deg)
    way = np.array([math.sin(yaw), math.cos(yaw)])
    across = np.array([way[1], -way[0]])
    at = np.array([seat.position[0], seat.position[2]])
    corners = [at + 0.16 * way, at - 0.08 * way + 0.1 * across, at - 0.08 * way - 0.1 * across]
    draw.polygon(frame(corners), fill=_SEAT)


def _label_rooms(
    draw: ImageDraw.ImageDraw, frame: PlanFrame, scene: Scene, rooms: list[shapely.Polygon]
) -> None:
    font = ImageFont.load_default(size=12 * PLAN_FINE)
    for room, polygon in zip(scene.rooms, rooms, strict=True):
        x0, z0, _, _ = polygon.bounds
        (x, y), text = frame([x0, z0])[0], f"{room.purpose or room.room_id} {polygon.area:.0f} m2"
        box = draw.textbbox((x + 6 * PLAN_FINE, y + 4 * PLAN_FINE), text, font=font)
        draw.rectangle([box[0] - 6, box[1] - 3, box[2] + 6, box[3] + 3], fill=_PAPER)
        draw.text((x + 6 * PLAN_FINE, y + 4 * PLAN_FINE), text, fill=_INK, font=font)


def draw_scale(draw: ImageDraw.ImageDraw, frame: PlanFrame) -> None:
    """A bar of one metre in the lower left corner."""
    x, y = 14 * PLAN_FINE, frame.size[1] - 14 * PLAN_FINE
    draw.line([(x, y), (x + frame.scale, y)], fill=_INK, width=2 * PLAN_FINE)
    font = ImageFont.load_default(size=11 * PLAN_FINE)
    at = (x + frame.scale + 5 * PLAN_FINE, y)
    draw.text(at, "1 m", _INK, font, "lm", stroke_width=2 * PLAN_FINE, stroke_fill=_PAPER)


def _draw_legend(draw: ImageDraw.ImageDraw, width: int, y: int) -> None:
    font = ImageFont.load_default(size=12)
    x, line = 12.0, float(y)
    for color, text in _LEGEND:
        length = draw.textlength(text, font=font) + 34
        if x + length > width:
            x, line = 12.0, line + 18
        draw.rectangle([x, line + 2, x + 12, line + 12], fill=color)
        draw.text((x + 18, line), text, fill=_QUIET, font=font)
        x += length
