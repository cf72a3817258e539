"""Whether the stage of a scene is there: the first that lacks where a download is incomplete."""

from __future__ import annotations

from affectsim_data.builders.habitat.dataset import Dataset
from affectsim_data.builders.habitat.files import OutsideError
from affectsim_data.builders.habitat.instances import read_scene_instance
from affectsim_data.builders.imports import ImportLog

__all__ = ["missing_stage"]


def missing_stage(dataset: Dataset, handle: str) -> str:
    """What of a scene's stage is not there: its name, or its mesh; empty if nothing lacks.

    Opens no mesh. A stage that is no file, or whose template is broken, counts as there: importing
    the scene says what is wrong with it.

    Raises:
        KeyError: The dataset has no such scene.
        ValueError: The scene's file is broken.
    """
    name = dataset.find_scene(handle)
    wanted = handle
    if name:
        path = dataset.scenes[name]
        scene = read_scene_instance(
            path,
            handle=name,
            where=dataset.folder.relative(path),
            defaults=dataset.scene_defaults,
            log=ImportLog(),
        )
        if scene.stage is None or scene.stage.template_name.upper() == "NONE":
            return "the scene names no stage"
        wanted = scene.stage.template_name
    match = dataset.stages.find(wanted)
    if match is None:
        return wanted
    try:
        template = dataset.stages.get(match.handle)
        mesh = template.table.text("render_asset")
        file = dataset.folder.inside(template.bases["render_asset"], mesh)
    except (KeyError, OutsideError, ValueError):
        return ""
    return "" if not mesh or file.is_file() else dataset.folder.relative(file)
