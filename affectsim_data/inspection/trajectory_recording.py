"""A recorded run for the Rerun viewer, and the same view of a run that is being made."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from affectsim_data.episodes import RING_DISTANCES_M, Episode, World
from affectsim_data.inspection.run_streams import TIMELINE, RunStream
from affectsim_data.inspection.scene_plans import PLAN_FINE, PlanFrame
from affectsim_data.inspection.trajectory_frames import looks_at
from affectsim_data.inspection.trajectory_maps import (
    CLIPPED_COLOR,
    PHASE_COLORS,
    draw_run_map,
    draw_surroundings,
    map_frame,
)
from affectsim_data.inspection.trajectory_moments import key_moments
from affectsim_data.inspection.trajectory_pictures import run_caption
from affectsim_data.inspection.trajectory_runs import RecordedRun
from affectsim_data.inspection.trajectory_sights import SEEN_SHARE, Sights, run_sights
from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import UP
from affectsim_data.render import Renderer

__all__ = ["live_stream", "record_run"]

_MAP, _BATCH = 760, 32
_MAX_IMAGES = 200
"""Longer runs show every second or third look."""
_PEOPLE_FPS = 6.0
_LIFT_M = 0.03


def record_run(
    run: RecordedRun,
    world: World,
    renderer: Renderer,
    path: Path,
    *,
    navmesh: NavMesh | None = None,
) -> None:
    """Writes an `.rrd` that `rerun FILE` opens: a few megabytes, time in seconds.

    Args:
        run: What the robot did.
        world: Where.
        renderer: Draws what it saw; of long runs every second or third look.
        path: The file; its folder is there.
        navmesh: Outlined on the map if given.
    """
    import rerun as rr

    sights = run_sights(run, world)
    frame = map_frame(run, world, width=_MAP, height=_MAP)
    moments = key_moments(run, sights, count=6)
    plan = draw_run_map(run, world, navmesh=navmesh, moments=moments, width=_MAP, height=_MAP)
    stream = rr.RecordingStream("affectsim", recording_id=f"{run.policy} {run.episode.episode_id}")
    stream.save(path, default_blueprint=_blueprint(run.episode, with_sights=True))
    about = _about(run.episode, run_caption(run, sights))
    stream.log("about", rr.TextDocument(about, media_type="text/markdown"), static=True)
    shown = RunStream(stream, run.episode, world, plan, frame)
    _log_way(stream, run)
    _log_events(stream, run, {one.state: one.title for one in moments})
    _log_sights(stream, run, sights)
    _log_people(shown, run)
    _log_looks(shown, run, world, renderer)
    stream.disconnect()


def live_stream(
    stream: Any, episode: Episode, world: World, *, navmesh: NavMesh | None = None
) -> RunStream:
    """A stream to show a run in as it is made: `at`, `place` and `see` after every action.

    Args:
        stream: A `rerun.RecordingStream`, connected to a viewer or saving to a file.
        episode: Which one.
        world: What its identifiers stand for.
        navmesh: Outlined on the map if given.
    """
    corners = np.concatenate([np.array(room.polygon) for room in world.scene.rooms])
    frame = PlanFrame.around(corners, width=_MAP, height=_MAP)
    plan = draw_surroundings(episode, world, frame, navmesh=navmesh)
    small = plan.resize((plan.width // PLAN_FINE, plan.height // PLAN_FINE))
    stream.send_blueprint(_blueprint(episode, with_sights=False))
    return RunStream(stream, episode, world, small, frame)


def _blueprint(episode: Episode, *, with_sights: bool) -> Any:
    import rerun.blueprint as rrb

    anchor = np.array(episode.target.anchor)
    away = np.array(episode.start_position) - anchor
    eye = anchor + 4.0 * away / max(float(np.linalg.norm(away)), 1e-6) + 6.5 * UP
    look = rrb.EyeControls3D(position=eye, look_target=anchor + 0.6 * UP, eye_up=UP)
    world = rrb.Spatial3DView(origin="world", name="World", eye_controls=look)
    map_ = rrb.Spatial2DView(origin="map", name="Map")
    images = rrb.Horizontal(
        rrb.Spatial2DView(origin="world/robot/camera/image", name="Camera"),
        rrb.Spatial2DView(origin="depth", name="Depth"),
    )
    below: list[Any] = [rrb.TextLogView(origin="events", name="Events")]
    right: list[Any] = [images]
    if with_sights:
        right.append(rrb.TimeSeriesView(origin="sights", name="Body in view"))
        below.append(rrb.TextDocumentView(origin="about", name="Run"))
    right.append(rrb.Horizontal(*below))
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(world, map_, row_shares=[1, 1]),
            rrb.Vertical(*right, row_shares=[3, 1, 1.6][-len(right) :] if with_sights else [3, 1]),
            column_shares=[1, 1.1],
        ),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE),
        collapse_panels=True,
    )


def _about(episode: Episode, caption: str) -> str:
    kind = (episode.challenge or episode.family).replace("_", " ")
    lines = [f"**{episode.episode_id}**: {kind}, {episode.emotion}, {episode.scene_id}"]
    return "\n\n".join([*lines, *(f"- {part.strip()}" for part in caption.split("\N{MIDDLE DOT}"))])


def _log_way(stream: Any, run: RecordedRun) -> None:
    """The whole way on the floor by phase, moves cut short, and the rings around the target."""
    import rerun as rr

    way = (run.positions + _LIFT_M * UP).astype(np.float32)
    moved = np.flatnonzero(run.lengths_m > 0.0)
    strips = [way[action : action + 2] for action in moved]
    colors = [PHASE_COLORS[run.phases[action]] for action in moved]
    stream.log("world/way", rr.LineStrips3D(strips, colors=colors, radii=0.025), static=True)
    clipped = way[1:][run.clipped]
    stream.log(
        "world/cut_short", rr.Points3D(clipped, colors=CLIPPED_COLOR, radii=0.05), static=True
    )
    angles = np.linspace(0.0, 2.0 * np.pi, 73)
    circle = np.stack([np.cos(angles), 0.0 * angles, np.sin(angles)], axis=1)
    anchor = np.array(run.episode.target.anchor) + _LIFT_M * UP
    rings = [(anchor + radius * circle).astype(np.float32) for radius in RING_DISTANCES_M]
    stream.log(
        "world/rings", rr.LineStrips3D(rings, colors=(110, 110, 118), radii=0.006), static=True
    )


def _log_events(stream: Any, run: RecordedRun, titles: dict[int, str]) -> None:
    """Moments, the first of moves cut short one after the other, and how it ended."""
    import rerun as rr

    for state, time_s in enumerate(run.times_s):
        stream.set_time(TIMELINE, duration=float(time_s))
        if titles.get(state):
            stream.log("events", rr.TextLog(titles[state], level=rr.TextLogLevel.INFO))
        if state and run.clipped[state - 1] and not (state > 1 and run.clipped[state - 2]):
            stream.log("events", rr.TextLog("move cut short", level=rr.TextLogLevel.WARN))
    stream.log("events", rr.TextLog(f"over: {run.end.replace('_', ' ')}"))


def _log_sights(stream: Any, run: RecordedRun, sights: Sights) -> None:
    import rerun as rr

    look = rr.SeriesLines(colors=(30, 120, 60), names="share of the body", widths=2)
    stream.log("sights/visible", look, static=True)
    limit = rr.SeriesLines(colors=(150, 150, 150), names=f"seen from {SEEN_SHARE:.0%}", widths=1)
    stream.log("sights/limit", limit, static=True)
    for time_s, share in zip(run.times_s, sights.visible, strict=True):
        stream.set_time(TIMELINE, duration=float(time_s))
        stream.log("sights/visible", rr.Scalars(float(share)))
        stream.log("sights/limit", rr.Scalars(SEEN_SHARE))


def _log_people(shown: RunStream, run: RecordedRun) -> None:
    for time_s in np.arange(0.0, float(run.times_s[-1]), 1.0 / _PEOPLE_FPS):
        shown.at(float(time_s))


def _log_looks(shown: RunStream, run: RecordedRun, world: World, renderer: Renderer) -> None:
    """Where the robot is in every state, and what it sees in so many of them."""
    stride = -(-(run.num_actions + 1) // _MAX_IMAGES)
    for state, time_s in enumerate(run.times_s):
        shown.stream.set_time(TIMELINE, duration=float(time_s))
        shown.place(run.positions[state], float(run.yaws[state]))
    states = np.arange(0, run.num_actions + 1, stride)
    for first in range(0, len(states), _BATCH):
        batch = states[first : first + _BATCH]
        images = looks_at(run, world, renderer, batch.tolist(), camera=world.camera)
        for state, rgb, depth in zip(batch, images.rgb, images.depth, strict=True):
            shown.stream.set_time(TIMELINE, duration=float(run.times_s[state]))
            shown.see(rgb, depth)
