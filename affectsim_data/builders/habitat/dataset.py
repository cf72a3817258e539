"""Habitat scene datasets: what `*.scene_dataset_config.json` and the files it names hold."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from affectsim_data.builders.habitat.fields import Table
from affectsim_data.builders.habitat.files import DatasetFolder, OutsideError, read_json
from affectsim_data.builders.habitat.licences import folder_licence
from affectsim_data.builders.habitat.templates import CONFIG_SUFFIXES, TemplateLibrary
from affectsim_data.builders.imports import ImportLog, ImportReport

__all__ = ["Dataset", "read_dataset"]

CONFIG = ".scene_dataset_config.json"
SCENE = ".scene_instance.json"
_SEMANTIC = ".semantic_config.json"
_LIGHTING = ".lighting_config.json"
_SECTIONS = {"stages": "stage", "objects": "object", "articulated_objects": "articulated object"}
_CHOICES_SHOWN = 12


@dataclasses.dataclass(frozen=True)
class Dataset:
    """A dataset, listed; its templates and scenes are read when they are asked for."""

    name: str
    folder: DatasetFolder
    scenes: Mapping[str, Path]
    """Scene instance file of each scene handle."""
    stages: TemplateLibrary
    objects: TemplateLibrary
    articulated: TemplateLibrary
    descriptors: Mapping[str, Path]
    """Semantic descriptor of each handle."""
    scene_defaults: Mapping[str, Any]
    """Attributes of a scene that does not give them."""
    licence: str
    """SPDX id of the licence file; empty if there is none or it is not known."""
    report: ImportReport
    """What reading the dataset found, ignored and refused."""

    @property
    def scene_handles(self) -> tuple[str, ...]:
        """What can be imported: the scene instances, else the stages."""
        if self.scenes:
            return tuple(self.scenes)
        return self.stages.handles

    def find_scene(self, handle: str) -> str:
        """The scene instance of this handle, else the first that contains it; "" for a stage alone.

        Raises:
            KeyError: There is neither such a scene nor such a stage.
        """
        if handle in self.scenes:
            return handle
        wanted = handle.lower()
        for name, path in sorted(self.scenes.items()):
            if wanted and wanted in self.folder.relative(path).lower():
                return name
        if wanted and self.stages.find(handle) is not None:
            return ""
        known = self.scene_handles
        listed = ", ".join(known[:_CHOICES_SHOWN])
        more = f" and {len(known) - _CHOICES_SHOWN} more" if len(known) > _CHOICES_SHOWN else ""
        raise KeyError(f"{self.name}: has no scene {handle!r}; it has {listed or 'none'}{more}")


def read_dataset(config: Path) -> Dataset:
    """Reads a dataset from its config, or from a folder that has one.

    A folder without a config is searched for scene instances and templates. Whatever lies outside
    the dataset's folder is refused and named in the report.

    Args:
        config: A `*.scene_dataset_config.json`, or a folder.

    Raises:
        FileNotFoundError: There is nothing there, or no dataset in it.
        ValueError: The folder has several configs, or the config is broken.
    """
    config = Path(config)
    if config.is_dir():
        choices = sorted(config.glob(f"*{CONFIG}"))
        if len(choices) > 1:
            names = ", ".join(path.name for path in choices)
            raise ValueError(f"{config}: has {len(choices)} datasets, name one of them: {names}")
        if not choices:
            return _Reader(config).without_config()
        config = choices[0]
    if not config.is_file():
        raise FileNotFoundError(f"{config}: no such file")
    return _Reader(config.parent).with_config(config.name)


class _Reader:
    """Fills the libraries of a dataset."""

    def __init__(self, root: Path) -> None:
        self.folder = DatasetFolder(root.resolve())
        self.log = ImportLog()
        self.scenes: dict[str, Path] = {}
        self.descriptors: dict[str, Path] = {}
        self.source = ""

    def with_config(self, name: str) -> Dataset:
        self.source = name
        root = read_json(self.folder.root / name, where=str(self.folder.root / name))
        root = dataclasses.replace(root, where=name)
        libraries = {}
        for section, kind in _SECTIONS.items():
            part = root.table(section)
            library = TemplateLibrary(kind, self.folder, part.table("default_attributes").values)  # type: ignore[arg-type]  # a value of the literal, from the table above
            self._fill(library, part, CONFIG_SUFFIXES[library.kind])
            libraries[section] = library
        part = root.table("scene_instances")
        for path in self._files(part, SCENE):
            self._add_scene(path)
        self._semantics(root.table("semantic_scene_descriptor_instances"))
        self._ignored(root)
        name = name.removesuffix(CONFIG)
        return self._dataset(name, libraries, dict(part.table("default_attributes").values))

    def without_config(self) -> Dataset:
        self.source = str(self.folder.root)
        libraries = {
            section: TemplateLibrary(kind, self.folder)  # type: ignore[arg-type]  # as above
            for section, kind in _SECTIONS.items()
        }
        suffixes = {CONFIG_SUFFIXES[lib.kind]: lib for lib in libraries.values()}
        suffixes[".urdf"] = libraries["articulated_objects"]
        for path in self.folder.walk():
            if not path.resolve().is_relative_to(self.folder.root):
                continue
            library = next((lib for end, lib in suffixes.items() if path.name.endswith(end)), None)
            if library is not None:
                library.add_file(path)
            elif path.name.endswith(SCENE):
                self._add_scene(path)
            elif path.name.endswith((_SEMANTIC, "_semantic_lexicon.json")):
                self.descriptors[self.folder.relative(path)] = path
        if not self.scenes and not len(libraries["stages"]):
            raise FileNotFoundError(
                f"{self.folder.root}: has no *{CONFIG}, no *{SCENE} and no *.stage_config.json; "
                "name the folder of a Habitat scene dataset"
            )
        self.log.note("the folder has no dataset config: templates were taken as they lie")
        return self._dataset(self.folder.root.name, libraries, {})

    def _dataset(
        self, name: str, libraries: Mapping[str, TemplateLibrary], defaults: Mapping[str, Any]
    ) -> Dataset:
        for section, library in libraries.items():
            if len(library):
                self.log.add("found", "templates", section, count=len(library))
        if self.scenes:
            self.log.add("found", "scene instances", name, count=len(self.scenes))
        return Dataset(
            name=name,
            folder=self.folder,
            scenes=self.scenes,
            stages=libraries["stages"],
            objects=libraries["objects"],
            articulated=libraries["articulated_objects"],
            descriptors=self.descriptors,
            scene_defaults=defaults,
            licence=folder_licence(self.folder.root),
            report=self.log.report(name, source=self.source),
        )

    def _fill(self, library: TemplateLibrary, part: Table, suffix: str) -> None:
        for path in self._files(part, suffix):
            library.add_file(path)
        for index, row in enumerate(part.rows("configs")):
            place = f"{part.where}: configs[{index}]"
            try:
                library.add_config(Table.of(row, where=place))
            except ValueError as error:
                self.log.add("skipped", "template", place, reason=str(error))

    def _files(self, part: Table, suffix: str) -> Iterator[Path]:
        """Files that a `paths` block names: by ending, folders searched but not those in them."""
        paths = part.table("paths")
        for ending in paths.values:
            wanted = suffix if ending.endswith(".json") else ending
            for pattern in paths.rows(ending):
                if not isinstance(pattern, str):
                    raise paths.wrong(ending, "a list of texts")
                yield from self._matching(pattern, wanted, part.where)

    def _matching(self, pattern: str, ending: str, where: str) -> Iterator[Path]:
        try:
            # Habitat also takes the name of a file without its ending.
            root = self.folder.root
            found = self.folder.expand(root, pattern) or self.folder.expand(root, pattern + ending)
        except OutsideError as error:
            self.log.add("skipped", "path", pattern, reason=str(error), asked_by=where)
            return
        if not found:
            self.log.add("missing", "path", pattern, reason="nothing there", asked_by=where)
        for path in found:
            inside = sorted(path.iterdir()) if path.is_dir() else [path]
            for file in inside:
                if file.name.endswith(ending) and file.is_file():
                    yield from self._safe(file, where)

    def _safe(self, file: Path, where: str) -> Iterator[Path]:
        """The file, unless it is a link that leads out."""
        try:
            yield self.folder.inside(file.parent, file.name)
        except OutsideError as error:
            self.log.add("skipped", "path", file.name, reason=str(error), asked_by=where)

    def _add_scene(self, path: Path) -> None:
        name = path.name.removesuffix(SCENE)
        self.scenes[self.folder.relative(path) if name in self.scenes else name] = path

    def _semantics(self, part: Table) -> None:
        """Descriptors by path or by handle; files that are not there are found out when used."""
        for path in self._files(part, _SEMANTIC):
            self.descriptors[self.folder.relative(path)] = path
        for handle, name in part.values.items():
            if handle in ("paths", "configs", "default_attributes"):
                continue
            if not isinstance(name, str):
                raise part.wrong(handle, "the path of a file")
            try:
                self.descriptors[handle] = self.folder.inside(self.folder.root, name)
            except OutsideError as error:
                self.log.add("skipped", "path", name, reason=str(error), asked_by=part.where)

    def _ignored(self, root: Table) -> None:
        """Parts of a dataset that we have no use for, counted."""
        lights = root.table("light_setups")
        count = len(list(self._files(lights, _LIGHTING))) + len(lights.rows("configs"))
        if count:
            reason = "light is baked by the builder"
            self.log.add("ignored", "light setups", "light_setups", count=count, reason=reason)
        meshes = root.table("navmesh_instances").values
        if meshes:
            reason = "navmeshes are built from the scene"
            self.log.add(
                "ignored", "navmeshes", "navmesh_instances", count=len(meshes), reason=reason
            )
        for name in sorted(set(root.values) & {"pbr_ibl_configs"}):
            self.log.add("ignored", "shaders", name, reason="surfaces are drawn unlit")
