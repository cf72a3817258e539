"""Box rooms, casts and slots that placements are tested with; all our own (CC0)."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from small_release import Point, box_room, limb_avatar, sway_motion

from affectsim_data.builders.assets import load_avatars
from affectsim_data.builders.compositions import PlacementKind
from affectsim_data.builders.measuring import Performance
from affectsim_data.builders.performances import PerformanceAction, perform, perform_dyad
from affectsim_data.builders.placement import Placement, Stage, find_placements
from affectsim_data.builders.recipes import Recipe, read_recipe
from affectsim_data.builders.slots import Slot
from affectsim_data.motions import EMOTIONS
from affectsim_data.navmesh import NavMesh
from affectsim_data.scenes import Scene
from affectsim_data.schemas import Challenge, Family

CHAIR = ((1.55, 0.0, -0.3), (2.15, 0.45, 0.3))
"""Under the seat of a box room."""
PARTITION = ((-0.1, 0.0, -5.0), (0.1, 2.6, 2.5))
"""Parts a room 10 m wide in two, but for 2.5 m at one end."""
CRATES = (
    ((-2.0, 0.0, -1.0), (-1.4, 1.1, 1.2)),
    ((1.0, 0.0, 1.5), (3.0, 1.0, 2.0)),
    ((-1.0, 0.0, -3.4), (1.5, 1.2, -3.0)),
)


@functools.cache
def recipe() -> Recipe:
    return read_recipe("mini")


def stage_of(scene: Scene) -> Stage:
    return Stage.prepare(scene, NavMesh.from_mesh(*scene.mesh()), recipe())


@functools.cache
def room(half: float = 5.0, boxes: tuple[tuple[Point, Point], ...] = (CHAIR, *CRATES)) -> Stage:
    """A box room, with a seat and a closed door unless they would be outside."""
    scene = box_room(f"room_{half:g}_{len(boxes)}", half=half, boxes=boxes)
    return stage_of(scene)


def bare(scene: Scene, **changes: object) -> Stage:
    """A stage of a scene with other fields, such as no seats."""
    return stage_of(dataclasses.replace(scene, **changes))  # type: ignore[arg-type]  # by tests


@functools.cache
def swaying() -> dict[str, Performance]:
    """Five people who stand and sway: one motion under five labels."""
    return {
        emotion: Performance(sway_motion(emotion, emotion), limb_avatar("plain"))
        for emotion in EMOTIONS
    }


@functools.cache
def acting(action: PerformanceAction, body: int = 0) -> dict[str, Performance]:
    """An action in every emotion, by one of the baked bodies, which have hands."""
    avatar = load_avatars(recipe())[body]
    return {
        emotion: Performance(
            perform(action, emotion, "p1", rng=np.random.default_rng(3)).rounded(), avatar
        )
        for emotion in EMOTIONS
    }


@functools.cache
def talking() -> dict[str, Performance]:
    """An interaction of two in two emotions."""
    bodies = limb_avatar("plain"), limb_avatar("tall", scale=1.1)
    found = {}
    for emotion in ("angry", "happy"):
        dyad = perform_dyad(emotion, ("p1", "p2"), rng=np.random.default_rng(4))
        found[emotion] = Performance(dyad.target, bodies[0], (dyad.partner, bodies[1]))
    return found


def slot_of(
    placement: PlacementKind = "floor",
    challenge: Challenge | None = None,
    *,
    key: str = "slot",
    motion_ids: tuple[str, ...] = EMOTIONS,
) -> Slot:
    family: Family = "observation_controlled" if challenge else "action_grounded"
    return Slot(key, "train", family, challenge, "sway", placement, motion_ids)


def placed(stage: Stage, slot: Slot, cast: dict[str, Performance]) -> Placement:
    """The placement of a slot that must have one."""
    (found,) = find_placements(stage, [slot], cast, recipe())
    assert isinstance(found, Placement), found
    return found
