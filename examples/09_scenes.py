"""You learn: what a scene knows of itself, how far a robot has to go in it, and how to see it.

Draws the plan of a home with the way from the robot's start to a person, at 1 m from them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from affectsim_data import open_release
from affectsim_data.affordances import knockable_doors, reachable_seats, rooms_of
from affectsim_data.inspection.scene_plans import scene_sheet

OUT = Path("runs/scenes")


def main() -> None:
    """Describes a home of the built-in release and moves a robot in it."""
    release = open_release("mini")
    episode = release.episode("test", 0)
    scene, navmesh = release.scene(episode.scene_id), release.navmesh(episode.scene_id)
    for room in scene.rooms:
        inside = [thing.category for thing in scene.objects if thing.room_id == room.room_id]
        print(f"{room.room_id}: {', '.join(sorted(set(inside)))}")
    seats, doors = reachable_seats(scene, navmesh), knockable_doors(scene, navmesh)
    print(
        f"seats one can take, with a robot near: {int(seats.is_usable.sum())} of {len(scene.seats)}"
    )
    print(f"doors one can knock at: {int(doors.is_knockable.sum())} of {len(scene.doors)}")

    start, person = np.array(episode.start_position), np.array(episode.target.anchor)
    for radius_m in (1.0, 3.0, 5.0):
        way = navmesh.ring_distance(start, person, radius_m)
        print(f"shortest way to {radius_m:.0f} m from the person: {way:.2f} m")
    towards = start + 0.25 * (person - start) / np.linalg.norm(person - start)
    step = navmesh.step(start, towards)
    print(f"a step of 0.25 m towards them ends at {step.position.round(2)}, clipped {step.clipped}")
    print(f"the robot starts in room {scene.rooms[int(rooms_of(scene, start))].room_id}")

    OUT.mkdir(parents=True, exist_ok=True)
    scene_sheet(scene, navmesh).save(OUT / "plan.png")
    print(f"{OUT / 'plan.png'}: the home from above")


if __name__ == "__main__":
    main()
