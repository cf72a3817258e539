"""Doors: linings of doorways, leaves that stand open, and closed doors in their recess."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Literal

import numpy as np

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box, lathe, sheet
from affectsim_data.builders.homes.plans import WALL_THICKNESS, HomePlan, Opening, RoomPlan, Wall
from affectsim_data.builders.homes.plans.doorways import LEAF_OUT_M, LEAF_THICKNESS_M, leaf_width
from affectsim_data.builders.homes.trim import Finish, casing, graded, span_u
from affectsim_data.builders.homes.windows import facing, recess
from affectsim_data.poses import FloatArray

__all__ = ["DoorStyle", "LeafPose", "closed_door", "doorway_lining", "leaves_of", "open_leaf"]

DoorStyle = Literal["four_panels", "two_panels", "planks", "plain"]
"""How leaves look."""
_METAL = np.array([0.62, 0.61, 0.59])
_DARK = np.array([0.16, 0.15, 0.14])
_SILL = np.array([0.45, 0.36, 0.28])
_RECESS_M = 0.06
"""From the face of a wall to what lies behind a closed leaf."""
_SHUT_OUT_M = 0.014
"""From the face of a wall to the panels of a closed leaf."""
_GAP_M = 0.003
_UNDER_M = 0.006
"""Below a leaf."""
_PANEL_M = 0.008
"""By which panels stand out from a leaf."""
_HANDLE_Y = 1.05


@dataclasses.dataclass(frozen=True)
class LeafPose:
    """Where a leaf is: closed in its recess, or open into the room."""

    opening: Opening
    hinge: FloatArray
    """Foot of its axis, `(3,)`, metres."""
    along: FloatArray
    """Unit, from the hinge to the free end, `(3,)`."""
    face: FloatArray
    """Unit, out of the face that people see from the doorway or, if closed, the room, `(3,)`."""
    width: float
    height: float

    @property
    def yaw(self) -> float:
        """Of its face, radians."""
        return float(np.arctan2(self.face[0], self.face[2]))

    def point(self, share: float, y: float) -> FloatArray:
        """On its face, a share of the width from the hinge, at height `y`, `(3,)`."""
        on_face = self.hinge + share * self.width * self.along
        return np.asarray(on_face + np.array([0.0, y, 0.0]))


def leaves_of(plan: HomePlan) -> Iterator[tuple[RoomPlan, Wall, LeafPose]]:
    """Every leaf with the room it turns into or, if closed, is seen from."""
    for room in plan.rooms:
        for wall in room.walls():
            for opening in room.openings_in(wall.side):
                if opening.leaf is not None:
                    yield room, wall, _pose(wall, opening)


def _pose(wall: Wall, opening: Opening) -> LeafPose:
    assert opening.leaf is not None
    start, end = span_u(wall, opening)
    hinge_place = opening.span[0] if opening.leaf.hinge == "low" else opening.span[1]
    at_start = abs(wall.u_of(hinge_place) - start) < 1e-9
    shut = wall.along if at_start else -wall.along
    hinge_u = start if at_start else end
    if opening.kind == "door":
        width, height = opening.width - 2.0 * _GAP_M, opening.top - _UNDER_M - _GAP_M
        hinge = wall.point(hinge_u + (_GAP_M if at_start else -_GAP_M), 0.0, -_SHUT_OUT_M)
        return LeafPose(opening, hinge, shut, wall.normal, width, height)
    angle = math.radians(opening.leaf.angle_deg)
    along = math.cos(angle) * shut + math.sin(angle) * wall.normal
    face = math.sin(angle) * shut - math.cos(angle) * wall.normal
    height = opening.top - _UNDER_M - 0.01
    hinge = wall.point(hinge_u, 0.0, LEAF_OUT_M)
    return LeafPose(opening, hinge, along, face, leaf_width(opening), height)


def open_leaf(pose: LeafPose, style: DoorStyle, finish: Finish) -> list[Part]:
    """A leaf with panels and handles on both faces."""
    parts = _leaf(pose, style, finish, thickness=LEAF_THICKNESS_M, both=True)
    for y in (0.25, pose.height / 2.0, pose.height - 0.25):
        x, _, z = pose.hinge
        parts.append(
            lathe([(0.0, 0.0), (0.008, 0.0), (0.008, 0.09), (0.0, 0.09)], color=_METAL,
                  center=(float(x), y, float(z)), segments=8)
        )  # fmt: skip
    return parts


def closed_door(
    wall: Wall, pose: LeafPose, style: DoorStyle, finish: Finish, trim: Finish
) -> list[Part]:
    """A leaf with panels and a handle, slightly recessed in its casing."""
    opening = pose.opening
    start, end = span_u(wall, opening)
    behind = sheet(
        wall.point(start, 0.0, -_RECESS_M), wall.along, np.array([0.0, 1.0, 0.0]),
        np.array([0.0, end - start]), np.array([0.0, opening.top]), color=_DARK, material="plain",
    )  # fmt: skip
    sill = sheet(
        wall.point(start), wall.along, -wall.normal,
        graded(0.0, end - start), np.array([0.0, _RECESS_M]),
        color=_SILL, material="wood",
    )  # fmt: skip
    return [
        behind,
        facing(sill, wall.point(start, 1.0)),
        *casing(wall, opening, trim),
        *recess(wall, opening, _RECESS_M, finish=trim, bottom=False),
        *_leaf(pose, style, finish, thickness=0.034, both=False),
    ]


def _leaf(
    pose: LeafPose, style: DoorStyle, finish: Finish, *, thickness: float, both: bool
) -> list[Part]:
    """The parts of a leaf in the world; its face, panels apart, is `_PANEL_M` behind the hinge."""
    right = np.array([pose.face[2], 0.0, -pose.face[0]])
    sign = 1.0 if float(right @ pose.along) > 0.0 else -1.0
    slab = thickness - (2.0 if both else 1.0) * _PANEL_M
    depth = -_PANEL_M - slab / 2.0
    parts = [
        box((pose.width, pose.height, slab), (0.0, pose.height / 2.0, depth),
            color=finish.color, material=finish.material, step=0.4)
    ]  # fmt: skip
    faces = ((0.0, 1.0), (-thickness, -1.0)) if both else ((0.0, 1.0),)
    for front, out in faces:
        for x, y, width, height in _panels(pose.width, pose.height, style):
            parts.append(
                box((width, height, _PANEL_M), (x, y, front - out * _PANEL_M / 2.0),
                    color=finish.color, material=finish.material, step=0.5)
            )  # fmt: skip
        parts += _handle(sign * (pose.width / 2.0 - 0.07), front, out, sign)
    middle = pose.point(0.5, _UNDER_M)
    x, y, z = (float(value) for value in middle)
    return [part.moved(x, y, z, yaw=pose.yaw) for part in parts]


def _panels(
    width: float, height: float, style: DoorStyle
) -> list[tuple[float, float, float, float]]:
    """Middle x and y, width and height of the raised panels of a leaf."""
    if style == "plain":
        return [(0.0, height / 2.0, width - 0.002, height - 0.002)]
    if style == "planks":
        count = 6
        step = (width - 0.01) / count
        return [
            (-width / 2.0 + 0.005 + (k + 0.5) * step, height / 2.0, step - 0.008, height - 0.02)
            for k in range(count)
        ]
    # Between the rails: at the foot, below the lock and under the top.
    rows = ((0.24, 0.9), (1.14, height - 0.13))
    columns = 2 if style == "four_panels" else 1
    free = width - 0.11 * (columns + 1)
    return [
        (
            -width / 2.0 + 0.11 * (k + 1) + free / columns * (k + 0.5),
            (low + high) / 2.0, free / columns, high - low,
        )
        for low, high in rows
        for k in range(columns)
    ]  # fmt: skip


def _handle(x: float, front: float, out: float, sign: float) -> list[Part]:
    """A plate and a lever that points to the hinge."""
    y = _HANDLE_Y
    base = front - out * (_PANEL_M - 0.001)
    return [
        box((0.04, 0.21, 0.014), (x, y - 0.05, base + out * 0.007), color=_METAL),
        box((0.02, 0.02, 0.04), (x, y, base + out * 0.03), color=_METAL),
        box((0.13, 0.02, 0.02), (x - sign * 0.045, y, base + out * 0.055), color=_METAL,
            radius=0.009),
    ]  # fmt: skip


def doorway_lining(
    wall: Wall, opening: Opening, palette: Palette, trim: Finish, *, planks: bool
) -> list[Part]:
    """Jambs, head and threshold of a doorway, through all of the wall.

    Args:
        wall: One of the two faces of the wall.
        opening: Its opening.
        palette: Colours.
        trim: Of jambs and head.
        planks: Whether floorboards run on through it.
    """
    start, end = span_u(wall, opening)
    color = palette.floor if planks else palette.dark_wood
    strip = sheet(
        wall.point(start), wall.along, -wall.normal,
        graded(0.0, end - start, fine=0.2), np.array([0.0, WALL_THICKNESS]),
        color=color, material="planks" if planks else "wood",
    )  # fmt: skip
    strip = facing(strip, wall.point(start, 1.0))
    if planks:
        strip = dataclasses.replace(strip, uvs=strip.positions[:, [0, 2]])
    return [strip, *recess(wall, opening, WALL_THICKNESS, finish=trim, bottom=False)]
