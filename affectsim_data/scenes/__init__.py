"""The world S: static geometry with its light baked in, and what a person can do in it."""

from affectsim_data.scenes.chunks import Chunks
from affectsim_data.scenes.scene import Scene
from affectsim_data.scenes.semantics import Door, Doorway, Room, SceneObject, Seat
from affectsim_data.scenes.surfaces import Surface

__all__ = ["Chunks", "Door", "Doorway", "Room", "Scene", "SceneObject", "Seat", "Surface"]
