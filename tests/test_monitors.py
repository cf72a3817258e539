"""Monitor cameras: inside the room and out of things, in rooms of any shape."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from small_release import CAMERA, Point, box_room

from affectsim_data.builders.monitors import plan_monitor
from affectsim_data.scenes import Room
from affectsim_data.visibility import scene_caster

CUPBOARD = ((3.2, 0.0, 3.2), (4.0, 2.5, 4.0))
SHAPES = {
    "L": ((-4.0, -4.0), (4.0, -4.0), (4.0, 0.0), (0.0, 0.0), (0.0, 4.0), (-4.0, 4.0)),
    # Shrunk by the distance of a camera from walls it falls in two.
    "dumbbell": (
        *((-4.0, -4.0), (4.0, -4.0), (4.0, -1.0), (0.2, -1.0), (0.2, 1.0), (4.0, 1.0)),
        *((4.0, 4.0), (-4.0, 4.0), (-4.0, 1.0), (-0.2, 1.0), (-0.2, -1.0), (-4.0, -1.0)),
    ),
    "closet": ((0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5)),
    "shaft": ((0.0, 0.0), (0.2, 0.0), (0.2, 0.2), (0.0, 0.2)),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_monitors_hang_inside_rooms_of_any_shape(shape: str) -> None:
    room = Room("room", "living", SHAPES[shape])
    monitor = plan_monitor(room, CAMERA, scene_caster(box_room("monitored")))
    x, y, z = monitor.position
    assert shapely.contains_xy(shapely.Polygon(room.polygon), x, z)
    assert 2.0 < y < room.ceiling_y
    assert 0.0 <= monitor.floor_share <= 1.0


@pytest.mark.parametrize("crate", [CUPBOARD, ((3.5, 2.2, 3.5), (3.8, 2.5, 3.8))])
def test_monitors_keep_out_of_things_that_fill_a_corner(crate: tuple[Point, Point]) -> None:
    scene = box_room("cupboard", boxes=[crate])
    monitor = plan_monitor(scene.rooms[0], CAMERA, scene_caster(scene))
    position = np.array(monitor.position)
    outside = np.maximum(np.array(crate[0]) - position, position - np.array(crate[1])).max()
    assert outside >= 0.1
    assert monitor.floor_share > 0.25
