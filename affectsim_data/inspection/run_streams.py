"""A Rerun stream of an episode being acted in: live, step by step, or from a recorded run."""

from __future__ import annotations

import io
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from affectsim_data.episodes import Episode, Person, World
from affectsim_data.inspection.scene_plans import PLAN_FINE, PlanFrame
from affectsim_data.inspection.scene_recording import log_scene
from affectsim_data.observations.still import head_camera_pose
from affectsim_data.poses import UP, FloatArray, matrix_quaternion

__all__ = ["TIMELINE", "RunStream"]

TIMELINE = "run"
"""Seconds since the start of the episode."""
_BODY_FPS, _BODY_BYTES, _BODY_TRIANGLES = 6.0, 1_000_000, 2_500
"""Poses of a cycle are logged once, however long the run: this many a second, if they fit."""
_HIDDEN = 1e-3
"""Scale of poses that are not due; the viewer takes no zero."""
_JPEG_QUALITY, _DEPTH_STRIDE = 80, 2
_ROBOT_COLOR, _WAY_COLOR = (66, 133, 244), (0, 114, 178)
_HEADING_PX = 22.0


class RunStream:
    """Logs a world once, and then where the robot is and what it sees.

    Below `world`: `scene`, `people`, `robot/camera/image`; beside it `depth` and `map`. People
    are there in every pose of a cycle; a switch shows the one that is due.
    """

    def __init__(
        self, stream: Any, episode: Episode, world: World, plan: Image.Image, frame: PlanFrame
    ) -> None:
        """Logs what does not change.

        Args:
            stream: A `rerun.RecordingStream`.
            episode: Which one.
            world: What its identifiers stand for.
            plan: The map, in pixels.
            frame: How the plan comes onto it.
        """
        import rerun as rr

        self.stream, self._episode, self._world = stream, episode, world
        self._frame = frame
        self._way: list[tuple[float, float]] = []
        stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Y_UP, static=True)
        log_scene(stream, world.scene)
        stream.log("map", rr.Image(np.asarray(plan)).compress(jpeg_quality=90), static=True)
        pinhole = rr.Pinhole(
            image_from_camera=world.camera.intrinsics,
            width=world.camera.width,
            height=world.camera.height,
            camera_xyz=rr.ViewCoordinates.RUB,
            image_plane_distance=0.5,
            color=_ROBOT_COLOR,
        )
        stream.log("world/robot/camera/image", pinhole, static=True)
        names = ("target", "partner")
        self._bodies = [
            _Body(stream, f"world/people/{name}", person)
            for person, name in zip(world.people, names, strict=False)
        ]

    def at(self, time_s: float) -> None:
        """Sets the time of what is logged next, and shows people as they are then."""
        self.stream.set_time(TIMELINE, duration=time_s)
        for body in self._bodies:
            body.show(self._episode.phase_s + time_s)

    def place(self, position: ArrayLike, yaw: float, *, keep_way: bool = False) -> None:
        """Where the robot is now, in the world and on the map.

        Args:
            position: On the floor, metres, `(3,)`.
            yaw: Radians, 0 looks along -Z.
            keep_way: Whether to draw the way so far on the map.
        """
        import rerun as rr

        here = np.asarray(position, np.float64)
        pose = head_camera_pose(here, np.array(yaw), self._world.robot)
        w, x, y, z = matrix_quaternion(pose[:3, :3])
        turn = rr.Quaternion(xyzw=[x, y, z, w])
        self.stream.log(
            "world/robot/camera", rr.Transform3D(translation=pose[:3, 3], rotation=turn)
        )
        robot = self._world.robot
        body = rr.Cylinders3D(
            lengths=robot.camera_height_m,
            radii=robot.radius_m,
            centers=[here + 0.5 * robot.camera_height_m * UP],
            # Cylinders stand along Z; a quarter turn about X makes it Y.
            quaternions=[rr.Quaternion(xyzw=[-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)])],
            colors=(*_ROBOT_COLOR, 120),
        )
        self.stream.log("world/robot/body", body)
        self._place_on_map(here, yaw, keep_way=keep_way)

    def _place_on_map(self, here: FloatArray, yaw: float, *, keep_way: bool) -> None:
        import rerun as rr

        u, v = self.pixels(here[[0, 2]])[0]
        ahead = (-_HEADING_PX * math.sin(yaw), -_HEADING_PX * math.cos(yaw))
        arrow = rr.Arrows2D(
            origins=[(u, v)], vectors=[ahead], colors=_ROBOT_COLOR, radii=3.0, draw_order=30.0
        )
        self.stream.log("map/robot", arrow)
        if keep_way:
            self._way.append((u, v))
            lines = rr.LineStrips2D([self._way], colors=_WAY_COLOR, radii=1.5, draw_order=20.0)
            self.stream.log("map/way", lines)

    def pixels(self, plan: ArrayLike) -> list[tuple[float, float]]:
        """Points of the plan, `(n, 2)` or one, in pixels of the map."""
        return [(x / PLAN_FINE, y / PLAN_FINE) for x, y in self._frame(plan)]

    def see(self, rgb: NDArray[np.uint8], depth: NDArray[np.float32]) -> None:
        """What the robot sees now: `(height, width, 3)`, and metres `(height, width)`.

        Depth is logged at half the size and to the millimetre; 0 is nothing.
        """
        import rerun as rr

        picture = rr.Image(rgb).compress(jpeg_quality=_JPEG_QUALITY)
        self.stream.log("world/robot/camera/image", picture)
        near = depth[::_DEPTH_STRIDE, ::_DEPTH_STRIDE]
        millimetres = np.where(np.isfinite(near), np.clip(near * 1000.0, 0, 65535), 0)
        file = io.BytesIO()
        Image.fromarray(millimetres.astype(np.uint16)).save(file, format="png")
        self.stream.log(
            "depth",
            rr.EncodedDepthImage(
                file.getvalue(), media_type="image/png", meter=1000.0, depth_range=(0, 8000)
            ),
        )

    def say(self, text: str) -> None:
        """Adds a line to the events."""
        import rerun as rr

        self.stream.log("events", rr.TextLog(text))


class _Body:
    """A person in every pose of a cycle, all but one of them shrunk to nothing."""

    def __init__(self, stream: Any, entity: str, person: Person) -> None:
        import rerun as rr

        mesh = person.avatar.mesh(max_triangles=_BODY_TRIANGLES)
        cycle = person.motion.duration_s
        most = _BODY_BYTES // mesh.positions.nbytes
        count = int(max(2, min(cycle * _BODY_FPS, most)))
        instants = np.arange(count) * cycle / count
        shapes = mesh.skin(person.joint_matrices(instants)).astype(np.float32)
        self.stream, self._entity = stream, entity
        self._count, self._cycle = count, cycle
        self._shown: int | None = None
        stream.set_time(TIMELINE, duration=0.0)
        for place, shape in enumerate(shapes):
            body = rr.Mesh3D(
                vertex_positions=shape, vertex_colors=mesh.colors, triangle_indices=mesh.faces
            )
            stream.log(self._pose(place), body, static=True)
            stream.log(self._pose(place), rr.Transform3D(scale=_HIDDEN))

    def _pose(self, place: int) -> str:
        return f"{self._entity}/pose_{place:03d}"

    def show(self, instant_s: float) -> None:
        """Switches to the pose that is nearest to an instant of the motion."""
        import rerun as rr

        place = round(instant_s / self._cycle * self._count) % self._count
        if place == self._shown:
            return
        if self._shown is not None:
            self.stream.log(self._pose(self._shown), rr.Transform3D(scale=_HIDDEN))
        self.stream.log(self._pose(place), rr.Transform3D(scale=1.0))
        self._shown = place
