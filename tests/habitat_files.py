"""Small Habitat scene datasets made of boxes, written for tests. Made by code; CC0."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from affectsim_data.builders.habitat import Dataset, import_scene, read_dataset
from affectsim_data.builders.imports import ImportReport
from affectsim_data.scenes import Scene

__all__ = ["BED", "CHAIR", "SOFA", "DatasetFiles", "bounds"]

Box = tuple[Sequence[float], Sequence[float]]
CHAIR: tuple[Box, ...] = (
    ((-0.2, 0.0, -0.25), (0.2, 0.45, 0.2)),
    ((-0.2, 0.45, 0.15), (0.2, 0.9, 0.2)),
)
"""A chair that looks along its own -Z: a block to sit on, and a back."""
SOFA: tuple[Box, ...] = (
    ((-1.0, 0.0, -0.4), (1.0, 0.3, 0.4)),
    ((-0.8, 0.3, -0.4), (0.8, 0.42, 0.3)),
    ((-1.0, 0.3, 0.3), (1.0, 0.85, 0.4)),
    ((-1.0, 0.3, -0.4), (-0.8, 0.6, 0.4)),
    ((0.8, 0.3, -0.4), (1.0, 0.6, 0.4)),
)
"""Cushions 1.6 m wide between two arms; its back is at +Z."""
BED: tuple[Box, ...] = (((-0.8, 0.0, -1.0), (0.8, 0.5, 1.0)), ((-0.8, 0.5, 0.9), (0.8, 1.1, 1.0)))
FLOOR: Box = ((-3.0, -0.1, -2.0), (3.0, 0.0, 2.0))
DEFAULT_CONFIG: dict[str, Any] = {
    "stages": {"paths": {".json": ["stages"]}},
    "objects": {"paths": {".json": ["objects"]}},
    "articulated_objects": {"paths": {".urdf": ["urdf"]}},
    "scene_instances": {"paths": {".json": ["scenes"]}},
}


class DatasetFiles:
    """A dataset in a folder, file by file."""

    def __init__(self, root: Path) -> None:
        self.root = root
        root.mkdir(exist_ok=True)
        self.json("test.scene_dataset_config.json", DEFAULT_CONFIG)

    def json(self, name: str, table: object) -> Path:
        """Writes a JSON file."""
        return self.text(name, json.dumps(table))

    def text(self, name: str, text: str) -> Path:
        """Writes a text file."""
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    def mesh(self, name: str, *boxes: Box) -> Path:
        """Writes a GLB of red boxes."""
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        made = [trimesh.creation.box(bounds=np.array(box, np.float64)) for box in boxes]
        for mesh in made:
            mesh.unmerge_vertices()
            mesh.visual.face_colors = (200, 30, 30, 255)
        trimesh.Scene(made).export(path, include_normals=True)  # type: ignore[no-untyped-call]  # untyped library
        return path

    def add_object(self, name: str, *boxes: Box, **attributes: object) -> None:
        """Writes an object template and its mesh."""
        self.mesh(f"objects/{name}.glb", *boxes)
        table = {"render_asset": f"{name}.glb", **attributes}
        self.json(f"objects/{name}.object_config.json", table)

    def stage(self, name: str = "floor", *boxes: Box, **attributes: object) -> None:
        """Writes a stage template and its mesh: a floor, unless other boxes are given."""
        self.mesh(f"stages/{name}.glb", *(boxes or (FLOOR,)))
        frame = {"up": [0, 1, 0], "front": [0, 0, -1]}
        table = {"render_asset": f"{name}.glb", **frame, **attributes}
        self.json(f"stages/{name}.stage_config.json", table)

    def scene(
        self, *objects: dict[str, Any], stage: str = "floor", name: str = "home", **more: object
    ) -> None:
        """Writes a scene instance."""
        table = {"stage_instance": {"template_name": stage}, "object_instances": objects, **more}
        self.json(f"scenes/{name}.scene_instance.json", table)

    def read(self) -> Dataset:
        """The dataset as it is now."""
        return read_dataset(self.root)

    def imported(self, handle: str = "home", **options: Any) -> tuple[Scene, ImportReport]:
        """A scene of the dataset as it is now."""
        return import_scene(self.read(), handle, **options)


def bounds(scene: Scene, name: str) -> NDArray[np.float64]:
    """Low and high corner of the surfaces whose name begins so, `(2, 3)`, to 0.1 mm."""
    chosen = [surface for surface in scene.surfaces if surface.name.startswith(name)]
    points = np.concatenate([surface.positions for surface in chosen]).astype(np.float64)
    # Adding zero makes -0 a 0.
    return np.stack([points.min(axis=0), points.max(axis=0)]).round(4) + 0.0
