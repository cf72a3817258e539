"""An episode from above: who stands where and looks which way, and where the cameras are."""

from __future__ import annotations

import math

import numpy as np
from PIL import Image, ImageDraw

from affectsim_data.episodes import Episode, Person, World
from affectsim_data.inspection.scene_plans import PLAN_FINE, PlanFrame, draw_floor
from affectsim_data.poses import FloatArray

__all__ = ["PLAN_KEY", "draw_arrow", "draw_disc", "draw_episode_plan"]

_ROBOT, _TARGET, _PARTNER = (0, 114, 178), (213, 94, 0), (204, 121, 167)
_REFERENCE, _MONITOR = (0, 140, 110), (70, 70, 76)
PLAN_KEY = (
    (_ROBOT, "robot, its view"),
    (_TARGET, "target"),
    (_PARTNER, "partner"),
    (_REFERENCE, "p_ref"),
    (_MONITOR, "p_mon"),
)
"""Colours and what they stand for; after Okabe and Ito."""
_AROUND_M, _VIEW_M, _INSTANTS = 1.0, 1.6, 24


def draw_episode_plan(episode: Episode, world: World, *, size: int) -> Image.Image:
    """The part of the scene with robot, people and cameras in it, `size` x `size` pixels.

    A person is a disc with an arrow that way it faces at its anchor, and a line where its pelvis
    goes over the cycle; the robot a triangle, with the borders of its first view.
    """
    ways = [_way(person, episode.duration_s) for person in world.people]
    knots = episode.reference.knots[:, [0, 2]]
    start, monitor = _plan(episode.start_position), _plan(episode.monitor_position)
    anchors = [_plan(one.anchor) for one in episode.participants]
    points = np.concatenate([*ways, knots, [start, monitor], anchors])
    points = np.concatenate([points - _AROUND_M, points + _AROUND_M])
    frame = PlanFrame.around(points, width=size, height=size)
    picture = draw_floor(world.scene, frame)
    draw = ImageDraw.Draw(picture)
    view = np.array([-math.sin(episode.start_yaw), -math.cos(episode.start_yaw)])
    half = world.camera.hfov / 2.0
    for angle in (-half, half):
        way = start + _VIEW_M * _turned(view, angle)
        draw.line(frame([start, way]), fill=_ROBOT, width=PLAN_FINE)
    draw.line(frame(np.append(knots, knots[:1], axis=0)), fill=_REFERENCE, width=2 * PLAN_FINE)
    draw_arrow(draw, frame, knots[0], anchors[0] - knots[0], _REFERENCE)
    draw_disc(draw, frame, monitor, _MONITOR)
    for color, way, anchor, one in zip(
        (_TARGET, _PARTNER), ways, anchors, episode.participants, strict=False
    ):
        draw.line(frame(np.append(way, way[:1], axis=0)), fill=color, width=PLAN_FINE)
        draw_disc(draw, frame, anchor, color)
        facing = np.array([math.sin(one.facing), math.cos(one.facing)])
        draw.line(frame([anchor, anchor + 0.6 * facing]), fill=color, width=2 * PLAN_FINE)
    draw_arrow(draw, frame, start, view, _ROBOT)
    return picture.resize((size, size), Image.Resampling.LANCZOS)


def _plan(point: tuple[float, float, float]) -> FloatArray:
    return np.array([point[0], point[2]])


def _way(person: Person, duration_s: float) -> FloatArray:
    """Where the pelvis goes over the cycle, `(n, 2)`."""
    instants = np.arange(_INSTANTS) * duration_s / _INSTANTS
    way: FloatArray = person.joint_frames(instants)[:, 0, [0, 2], 3]
    return way


def _turned(way: FloatArray, angle: float) -> FloatArray:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([cos * way[0] - sin * way[1], sin * way[0] + cos * way[1]])


def draw_arrow(
    draw: ImageDraw.ImageDraw,
    frame: PlanFrame,
    at: FloatArray,
    way: FloatArray,
    color: tuple[int, int, int],
) -> None:
    """A triangle at a place of the plan `(2,)` that points a way, as large whatever the scale."""
    along = way / max(float(np.linalg.norm(way)), 1e-6)
    across = np.array([along[1], -along[0]])
    middle, reach = np.array(frame(at)[0]), 7.0 * PLAN_FINE
    corners = [
        middle + reach * along,
        middle - 0.7 * reach * along + 0.7 * reach * across,
        middle - 0.7 * reach * along - 0.7 * reach * across,
    ]
    draw.polygon([(float(x), float(y)) for x, y in corners], fill=color)


def draw_disc(
    draw: ImageDraw.ImageDraw, frame: PlanFrame, at: FloatArray, color: tuple[int, int, int]
) -> None:
    """A dot at a place of the plan, `(2,)`, as large whatever the scale."""
    (x, y), reach = frame(at)[0], 4.5 * PLAN_FINE
    draw.ellipse((x - reach, y - reach, x + reach, y + reach), fill=color)
