"""A run from above: the home, who performs where, the way the robot went, and where it looked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
import shapely
from PIL import Image, ImageDraw, ImageFont

from affectsim_data.episodes import RING_DISTANCES_M, Episode, Person, World
from affectsim_data.inspection.episode_plans import PLAN_KEY, draw_arrow, draw_disc
from affectsim_data.inspection.scene_plans import PLAN_FINE, PlanFrame, draw_floor, draw_scale
from affectsim_data.inspection.trajectory_moments import Moment
from affectsim_data.inspection.trajectory_runs import RecordedRun
from affectsim_data.navmesh import NavMesh
from affectsim_data.observations.bodies import BodyPath, body_path
from affectsim_data.poses import FloatArray
from affectsim_data.simulation.running import Phase

__all__ = ["CLIPPED_COLOR", "MAP_KEY", "PHASE_COLORS", "draw_run_map", "draw_surroundings"]
__all__ += ["map_frame"]

_KEY = {name: color for color, name in PLAN_KEY}
_PEOPLE = (_KEY["target"], _KEY["partner"])
_REFERENCE = _KEY["p_ref"]
PHASE_COLORS: Final[dict[Phase, tuple[int, int, int]]] = {
    "search": (0, 114, 178),
    "approach": (225, 150, 0),
    "collect": (106, 61, 154),
}
"""Of the way; after Okabe and Ito, but for the last."""
CLIPPED_COLOR = (214, 40, 40)
_INK, _PAPER, _QUIET, _WALKABLE = (30, 30, 34), (255, 255, 255), (110, 110, 118), (0, 140, 130)
MAP_KEY = (
    *((color, name) for name, color in PHASE_COLORS.items()),
    (CLIPPED_COLOR, "move cut short"),
    (_INK, "handoff"),
    (_PEOPLE[0], "target, its way and facing"),
    (_PEOPLE[1], "partner"),
    (_REFERENCE, "p_ref"),
)
"""Colours of a map and what they stand for."""
_AROUND_M, _LEAST_M = 0.8, 5.0
_CONE_M = 0.9
_CHEVRON_M = 0.8
"""A mark of the direction every so far."""


def map_frame(run: RecordedRun, world: World, *, width: int, height: int) -> PlanFrame:
    """The part of the plan with the run, the people and the reference view in it."""
    return _frame(run.episode, world, run.positions[:, [0, 2]], width=width, height=height)


def draw_run_map(
    run: RecordedRun,
    world: World,
    *,
    navmesh: NavMesh | None = None,
    moments: Sequence[Moment] = (),
    width: int,
    height: int,
) -> Image.Image:
    """The run on the plan of its home, `height` x `width` pixels.

    The way is coloured by phase, an arrow head every 0.8 m; a red cross is a move cut short, a
    black diamond the handoff. Grey circles are 1, 3 and 5 m around the target's anchor.

    Args:
        run: What the robot did.
        world: Where.
        navmesh: Its outline is drawn if given: where the robot's middle can be.
        moments: Viewpoints to number, with the borders of their view.
        width: Pixels.
        height: Pixels.
    """
    frame = map_frame(run, world, width=width, height=height)
    picture = draw_surroundings(run.episode, world, frame, navmesh=navmesh)
    draw = ImageDraw.Draw(picture, "RGBA")
    views = {(*run.positions[one.state], run.yaws[one.state]): one.state for one in moments}
    for state in views.values():
        _draw_cone(draw, frame, run, state, world.camera.hfov)
    _draw_way(draw, frame, run)
    _draw_numbers(draw, frame, run, moments)
    draw_scale(draw, frame)
    return picture.resize((width, height), Image.Resampling.LANCZOS)


def draw_surroundings(
    episode: Episode, world: World, frame: PlanFrame, *, navmesh: NavMesh | None = None
) -> Image.Image:
    """What there is without a run, in fine pixels: home, rings, people, reference view."""
    picture = draw_floor(world.scene, frame)
    draw = ImageDraw.Draw(picture, "RGBA")
    if navmesh is not None:
        _draw_outline(draw, frame, navmesh)
    _label_rooms(draw, frame, world)
    _draw_rings(draw, frame, episode)
    _draw_reference(draw, frame, episode)
    for person, color in zip(world.people, _PEOPLE, strict=False):
        _draw_person(draw, frame, person, episode, color)
    return picture


def _frame(
    episode: Episode, world: World, places: FloatArray, *, width: int, height: int
) -> PlanFrame:
    people = [body_path(person).center[:, [0, 2]] for person in world.people]
    knots = episode.reference.knots[:, [0, 2]]
    points = np.concatenate([places, *people, knots])
    low, high = points.min(axis=0) - _AROUND_M, points.max(axis=0) + _AROUND_M
    lacking = np.maximum(_LEAST_M - (high - low), 0.0) / 2.0
    corners: FloatArray = np.stack([low - lacking, high + lacking])
    return PlanFrame.around(corners, width=width, height=height)


def _draw_outline(draw: ImageDraw.ImageDraw, frame: PlanFrame, navmesh: NavMesh) -> None:
    for polygon in navmesh.polygons:
        for ring in (polygon.exterior, *polygon.interiors):
            draw.line(frame(ring.coords), fill=(*_WALKABLE, 110), width=PLAN_FINE)


def _label_rooms(draw: ImageDraw.ImageDraw, frame: PlanFrame, world: World) -> None:
    """Names each room in the corner of what is shown of it."""
    reach = np.array(frame.size) / frame.scale
    shown = shapely.box(*frame.low, *(frame.low + reach))
    font = ImageFont.load_default(size=12 * PLAN_FINE)
    for room in world.scene.rooms:
        part = shapely.Polygon(room.polygon).intersection(shown)
        if part.area < 1.0:
            continue
        x, y = frame([part.bounds[0], part.bounds[1]])[0]
        x, y = x + 5 * PLAN_FINE, y + 4 * PLAN_FINE
        draw.text((x, y), room.purpose or room.room_id, fill=_QUIET, font=font)


def _draw_rings(draw: ImageDraw.ImageDraw, frame: PlanFrame, episode: Episode) -> None:
    anchor = np.array([episode.target.anchor[0], episode.target.anchor[2]])
    font = ImageFont.load_default(size=10 * PLAN_FINE)
    angles = np.linspace(0.0, 2.0 * math.pi, 145)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    size = np.array(frame.size)
    for radius in RING_DISTANCES_M:
        points = frame(anchor + radius * circle)
        for start in range(0, len(points) - 1, 2):  # dashes
            draw.line(points[start : start + 2], fill=(*_QUIET, 200), width=PLAN_FINE)
        inside = np.all((np.array(points) > 30) & (np.array(points) < size - 60), axis=1)
        if inside.any():
            # At the lower right if that is in the picture, else at the first dash that is.
            place = 18 if inside[18] else int(np.flatnonzero(inside)[0])
            label = f"{radius} m"
            draw.text(
                *(points[place], label, _QUIET, font, "mm"), stroke_width=6, stroke_fill=_PAPER
            )


def _draw_reference(draw: ImageDraw.ImageDraw, frame: PlanFrame, episode: Episode) -> None:
    knots = episode.reference.knots[:, [0, 2]]
    draw.line(frame(np.append(knots, knots[:1], axis=0)), fill=_REFERENCE, width=2 * PLAN_FINE)
    anchor = np.array([episode.target.anchor[0], episode.target.anchor[2]])
    draw_arrow(draw, frame, knots[0], anchor - knots[0], _REFERENCE)


def _draw_person(
    draw: ImageDraw.ImageDraw,
    frame: PlanFrame,
    person: Person,
    episode: Episode,
    color: tuple[int, int, int],
) -> None:
    """The way over the cycle, and at the first instant of clips a disc that faces somewhere."""
    path = body_path(person)
    way = path.center[:, [0, 2]]
    draw.line(frame(np.append(way, way[:1], axis=0)), fill=color, width=2 * PLAN_FINE)
    at, facing = _place(path, episode.phase_s)
    draw_disc(draw, frame, at, color)
    tip = at + 0.5 * facing
    draw.line(frame([at, tip]), fill=color, width=3 * PLAN_FINE)
    draw_arrow(draw, frame, tip, facing, color)


def _place(path: BodyPath, instant_s: float) -> tuple[FloatArray, FloatArray]:
    """Where a body is on the plan and which way it faces, `(2,)` each."""
    center, heading = path.at(np.array([instant_s]))
    return center[0, [0, 2]], np.array([math.sin(heading[0]), math.cos(heading[0])])


def _draw_way(draw: ImageDraw.ImageDraw, frame: PlanFrame, run: RecordedRun) -> None:
    way = run.positions[:, [0, 2]]
    gone, since = np.cumsum(run.lengths_m), 0.0
    for action, phase in enumerate(run.phases):
        step = way[action : action + 2]
        if run.lengths_m[action] > 0.0:
            draw.line(frame(step), fill=PHASE_COLORS[phase], width=3 * PLAN_FINE)
        if gone[action] - since >= _CHEVRON_M:
            since = float(gone[action])
            draw_arrow(draw, frame, way[action + 1], step[1] - step[0], PHASE_COLORS[phase])
    for state in np.flatnonzero(run.clipped) + 1:
        _draw_cross(draw, frame(way[state])[0])
    if run.handoff is not None:
        x, y = frame(way[run.handoff])[0]
        reach = 8 * PLAN_FINE
        corners = [(x, y - reach), (x + reach, y), (x, y + reach), (x - reach, y)]
        draw.polygon(corners, fill=_INK, outline=_PAPER, width=PLAN_FINE)


def _draw_cross(draw: ImageDraw.ImageDraw, at: tuple[float, float]) -> None:
    reach = 4 * PLAN_FINE
    for sign in (-1, 1):
        ends = [(at[0] - reach, at[1] - sign * reach), (at[0] + reach, at[1] + sign * reach)]
        draw.line(ends, fill=CLIPPED_COLOR, width=2 * PLAN_FINE)


def _ahead(run: RecordedRun, state: int, turn: float = 0.0) -> FloatArray:
    """Where the robot looks in a state, turned to the left, on the plan, `(2,)`."""
    yaw = run.yaws[state] + turn
    return np.array([-math.sin(yaw), -math.cos(yaw)])


def _draw_cone(
    draw: ImageDraw.ImageDraw, frame: PlanFrame, run: RecordedRun, state: int, hfov: float
) -> None:
    at = run.positions[state, [0, 2]]
    turns = np.linspace(-hfov / 2.0, hfov / 2.0, 9)
    corners = frame([at, *(at + _CONE_M * _ahead(run, state, turn) for turn in turns)])
    color = _color(run, state)
    draw.polygon(corners, fill=(*color, 50))
    draw.line([*corners, corners[0]], fill=(*color, 170), width=PLAN_FINE)


def _color(run: RecordedRun, state: int) -> tuple[int, int, int]:
    return PHASE_COLORS[run.phases[max(state - 1, 0)]]


def _draw_numbers(
    draw: ImageDraw.ImageDraw, frame: PlanFrame, run: RecordedRun, moments: Sequence[Moment]
) -> None:
    """A numbered disc behind each viewpoint, or beside it where another one is already."""
    font = ImageFont.load_default(size=11 * PLAN_FINE)
    reach, taken = 8.0 * PLAN_FINE, list[FloatArray]()
    for moment in moments:
        at = np.array(frame(run.positions[moment.state, [0, 2]])[0])
        place = at
        for attempt in range(36):
            # All around at one distance, then at a larger one.
            turn = math.pi + (-1) ** attempt * math.radians(30.0) * ((attempt % 12 + 1) // 2)
            away = (20.0 + 18.0 * (attempt // 12)) * PLAN_FINE
            place = at + away * _ahead(run, moment.state, turn)
            if all(np.hypot(*(place - other)) > 2.1 * reach for other in taken):
                break
        taken.append(place)
        (x, y), color = place, _color(run, moment.state)
        draw.line([(at[0], at[1]), (x, y)], fill=color, width=PLAN_FINE)
        box = (x - reach, y - reach, x + reach, y + reach)
        draw.ellipse(box, fill=_PAPER, outline=color, width=2 * PLAN_FINE)
        draw.text((x, y), str(moment.number), fill=_INK, font=font, anchor="mm")
