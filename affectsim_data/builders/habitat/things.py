"""The things of a scene: their templates found, their meshes read and put in their places."""

from __future__ import annotations

import dataclasses
import functools
import re

import numpy as np

from affectsim_data.builders.habitat.assets import AssetError, Assets, MeshReader
from affectsim_data.builders.habitat.categories import Categories
from affectsim_data.builders.habitat.dataset import Dataset
from affectsim_data.builders.habitat.instances import Instance, SceneInstance
from affectsim_data.builders.habitat.placement import AssetFrame, asset_frame, place, placed_surface
from affectsim_data.builders.habitat.shapes import (
    box_part,
    cylinder_part,
    sphere_part,
    with_color,
)
from affectsim_data.builders.habitat.stand_ins import (
    STAND_IN_COLOR,
    facing_deg,
    floor_height,
    nominal_box,
)
from affectsim_data.builders.habitat.templates import Template, TemplateLibrary
from affectsim_data.builders.habitat.urdf import Visual, read_urdf
from affectsim_data.builders.imports import ImportLog
from affectsim_data.builders.meshes import MeshAsset, MeshPart
from affectsim_data.poses import FloatArray, compose_pose, quaternion_rotate
from affectsim_data.scenes import Surface

__all__ = ["MAX_TRIANGLES", "Thing", "Things"]

MAX_TRIANGLES = 8_000_000
"""Of a scene as imported; later instances are skipped and counted."""
_PRIMITIVE = re.compile(r"^[A-Za-z]+(Solid|Wireframe)(_|$)")


@dataclasses.dataclass(frozen=True)
class Thing:
    """A stage or an object in its place."""

    name: str
    """What its scene calls its template."""
    category: str
    surfaces: tuple[Surface, ...]
    yaw_deg: float
    """Which way the front of its template faces."""
    upright: bool
    """Whether the top of its template is up."""
    stand_in: bool = False
    """Whether something else stands for its mesh."""

    @property
    def points(self) -> FloatArray:
        """Its vertices, metres, `(n, 3)`."""
        return np.concatenate([one.positions for one in self.surfaces]).astype(np.float64)


class Things:
    """Makes the things of one scene; what cannot be had is logged."""

    def __init__(
        self,
        dataset: Dataset,
        scene: SceneInstance,
        categories: Categories,
        *,
        log: ImportLog,
        read_mesh: MeshReader | None,
        stand_ins: bool,
    ) -> None:
        self._dataset = dataset
        self._scene = scene
        self._categories = categories
        self._log = log
        self._stand_ins = stand_ins
        self.assets = Assets(dataset.folder, log, read_mesh)
        self.triangles = 0
        self.anchors: list[FloatArray] = []
        """Where the objects stand that have no mesh."""
        self._taken: dict[str, int] = {}

    def stage(self) -> Thing | None:
        """The stage; `None` if the scene has none or it cannot be had."""
        instance = self._scene.stage
        if instance is None or instance.template_name.upper() == "NONE":
            self._log.note("the scene has no stage")
            return None
        return self._thing(instance, self._dataset.stages)

    def objects(self) -> list[Thing]:
        """Rigid objects, then articulated ones, in the order of the file."""
        rigid = (self._thing(one, self._dataset.objects) for one in self._scene.objects)
        joined = (self._thing(one, self._dataset.articulated) for one in self._scene.articulated)
        return [thing for thing in (*rigid, *joined) if thing is not None]

    def _thing(self, instance: Instance, library: TemplateLibrary) -> Thing | None:
        """An instance in its place, or what stands for it; `None` where nothing does."""
        kind, name = library.kind, instance.template_name
        if not instance.visible:
            self._log.add("skipped", kind, name, reason="not visible", asked_by=self._scene.where)
            return None
        template: Template | None = None
        try:
            template = self._template(instance, library)
            thing = self._placed(instance, template)
        except AssetError as error:
            status = "missing" if error.missing else "skipped"
            self._log.add(status, kind, name, reason=str(error), asked_by=self._scene.where)  # type: ignore[arg-type]  # one of two literals
            self._anchor(instance, kind)
            return self._instead(instance, template)
        except ValueError as error:
            self._log.add("skipped", kind, name, reason=str(error), asked_by=self._scene.where)
            self._anchor(instance, kind)
            return None
        return self._counted(thing, kind, name)

    def _counted(self, thing: Thing, kind: str, name: str) -> Thing | None:
        count = sum(len(surface.faces) for surface in thing.surfaces)
        if self.triangles + count > MAX_TRIANGLES:
            reason = f"the scene has more than {MAX_TRIANGLES} triangles"
            self._log.add("skipped", kind, name, reason=reason, asked_by=self._scene.where)
            return None
        self.triangles += count
        if not thing.stand_in:
            self._log.add("found", kind, name)
        return thing

    def _anchor(self, instance: Instance, kind: str) -> None:
        if kind != "stage":
            self.anchors.append(instance.translation)

    def _template(self, instance: Instance, library: TemplateLibrary) -> Template:
        match = library.find(instance.template_name)
        if match is None:
            name = instance.template_name
            self._log.add("missing", "template", name, asked_by=self._scene.where)
            raise AssetError("no template of this name", missing=True)
        template = library.get(match.handle)
        if match.others and template.stem != instance.template_name.rsplit("/", 1)[-1]:
            text = f"{instance.template_name!r} is in several handles: {match.handle!r} was taken"
            self._log.note(text)
        return template

    def _placed(self, instance: Instance, template: Template) -> Thing:
        if template.kind == "articulated object":
            return self._articulated(instance, template)
        frame = asset_frame(template.table, is_stage=template.kind == "stage")
        if frame.assumed_up:
            text = (
                f"stage {template.handle!r} does not say which way is up: Z, as habitat-sim has it"
            )
            self._log.note(text)
        asset = self._asset(template, "render_asset")
        return self._made(instance, template, frame, asset.parts, asset.bounds)

    def _asset(self, template: Template, key: str) -> MeshAsset:
        name = template.table.text(key)
        if not name:
            raise AssetError(f"its template names no {key}", missing=True)
        if _PRIMITIVE.match(name):
            raise AssetError(
                f"{key} {name!r} is a primitive of habitat-sim, no file", missing=False
            )
        return self.assets.get(template.bases[key], name, asked_by=template.table.where)

    def _made(
        self,
        instance: Instance,
        template: Template,
        frame: AssetFrame,
        parts: tuple[MeshPart, ...],
        bounds: FloatArray,
        *,
        stand_in: bool = False,
    ) -> Thing:
        pose = place(instance, frame, bounds)
        return self._named(instance, template, [(part, pose) for part in parts], stand_in=stand_in)

    def _named(
        self,
        instance: Instance,
        template: Template,
        parts: list[tuple[MeshPart, FloatArray]],
        *,
        stand_in: bool = False,
    ) -> Thing:
        """Parts with their poses as a thing whose surfaces have names of their own."""
        self._taken[template.stem] = self._taken.get(template.stem, 0) + 1
        own = f"{template.stem}_{self._taken[template.stem]:03}"
        surfaces = [
            placed_surface(part, pose, f"{own}/{index}") for index, (part, pose) in enumerate(parts)
        ]
        up = quaternion_rotate(instance.rotation, (0.0, 1.0, 0.0))
        category = "" if template.kind == "stage" else self._categories.of(template)
        return Thing(
            name=own,
            category=category,
            surfaces=tuple(surfaces),
            yaw_deg=facing_deg(instance.rotation),
            upright=bool(up[1] > 0.95),
            stand_in=stand_in,
        )

    def _articulated(self, instance: Instance, template: Template) -> Thing:
        table = template.table
        if table.text("render_mode") == "none":
            raise ValueError(f"{table.where}: render_mode is 'none'")
        if table.text("render_mode") in ("skin", "both") or table.text("render_asset"):
            self._log.note("skins of articulated objects ignored: their links are drawn")
        name, base = table.text("urdf_filepath"), template.bases["urdf_filepath"]
        path = self._dataset.folder.inside(base, name)
        where = self._dataset.folder.relative(path)
        if not path.is_file():
            reason = "no such file"
            self._log.add("missing", "urdf", where, reason=reason, asked_by=table.where)
            raise AssetError("its URDF is missing", missing=True)
        scale = instance.scale * table.number("uniform_scale", 1.0)
        root = compose_pose(instance.rotation, instance.translation) @ np.diag([*scale, 1.0])
        parts: list[tuple[MeshPart, FloatArray]] = []
        for visual in read_urdf(path, where=where, joints=instance.joints):
            parts += [(part, root @ visual.pose) for part in self._shape(visual, path, where)]
        if not parts:
            raise AssetError("its URDF shows nothing that can be had", missing=True)
        return self._named(instance, template, parts)

    def _shape(self, visual: Visual, path: object, where: str) -> tuple[MeshPart, ...]:
        """The parts of a shape; one whose mesh cannot be had is left out, and logged."""
        if visual.shape == "box":
            return (box_part(visual.size),)
        if visual.shape == "sphere":
            return (sphere_part(*visual.size),)
        if visual.shape == "cylinder":
            return (cylinder_part(*visual.size),)
        base = self._dataset.folder.root / where
        try:
            return self.assets.get(base.parent, visual.mesh, asked_by=where).parts
        except AssetError as error:
            self._log.add("missing", "link", f"{where}: {visual.link}", reason=str(error))
            return ()

    def _instead(self, instance: Instance, template: Template | None) -> Thing | None:
        """What stands for an object without a mesh: its collision mesh, or a nominal box."""
        if not self._stand_ins or template is None or template.kind != "object":
            return None
        try:
            frame = asset_frame(template.table, is_stage=False)
            thing = self._collision(instance, template, frame) or self._box(
                instance, template, frame
            )
        except ValueError:
            return None  # The template is broken; the log says so.
        return None if thing is None else self._counted(thing, "object", instance.template_name)

    def _collision(self, instance: Instance, template: Template, frame: AssetFrame) -> Thing | None:
        try:
            asset = self._asset(template, "collision_asset")
        except AssetError:
            return None
        self._log.note("stand-in: the collision mesh of an object whose own mesh is missing")
        parts = tuple(with_color(part, STAND_IN_COLOR, part.name) for part in asset.parts)
        return self._made(instance, template, frame, parts, asset.bounds, stand_in=True)

    def _box(self, instance: Instance, template: Template, frame: AssetFrame) -> Thing | None:
        """A box of the category's nominal size; its bottom is the asset's origin, as in HSSD."""
        category = self._categories.of(template)
        made = nominal_box(category, instance, instance.scale * frame.scale, floor_y=self._floor_y)
        if made is None:
            self._log.note(f"no size is known of missing objects: {category or 'unknown category'}")
            return None
        self._log.note(f"stand-in: a box of nominal size for a missing {category}")
        return self._named(instance, template, [made], stand_in=True)

    @functools.cached_property
    def _floor_y(self) -> float:
        """Height of the floor, as the origins of the instances tell."""
        heights = np.array([one.translation[1] for one in self._scene.objects])
        return floor_height(heights, heights)
