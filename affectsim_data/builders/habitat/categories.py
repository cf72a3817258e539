"""What things are: categories from a dataset's lexicon, its metadata, or the names of templates."""

from __future__ import annotations

import csv
import dataclasses
import re
from collections.abc import Mapping
from pathlib import Path

from affectsim_data.builders.habitat.dataset import Dataset
from affectsim_data.builders.habitat.fields import Table
from affectsim_data.builders.habitat.files import read_json
from affectsim_data.builders.habitat.templates import Template
from affectsim_data.builders.imports import ImportLog

__all__ = ["Categories", "category_word", "lexicon_classes", "read_categories"]

_SAME = {
    "couch": "sofa", "loveseat": "sofa", "settee": "sofa",
    "indoor_plant": "plant", "potted_plant": "plant", "plant_stand": "plant",
    "tv_screen": "tv", "television": "tv", "tvstand": "tv_stand", "tv_object": "remote_control",
    "refrigerator": "fridge", "wall_cabinet": "cabinet", "base_cabinet": "cabinet",
    "chest_of_drawers": "dresser", "chestofdrawers": "dresser",
    "dining_table": "table", "coffee_table": "table", "dining_chair": "chair",
    "office_chair": "chair", "folding_chair": "chair", "bar_stool": "stool",
    "countertop": "counter", "carpet": "rug", "painting": "picture", "floor_lamp": "lamp",
    "table_lamp": "lamp",
}  # fmt: skip
"""Words of datasets, and ours."""
_WORDS = (
    "armchair", "beanbag", "bench", "bed", "bike", "bin", "book", "bowl", "cabinet", "carpet",
    "chair", "chestofdrawers", "couch", "counter", "cup", "curtain", "cushion", "desk", "door",
    "dresser", "fridge", "indoor_plant", "lamp", "mat", "monitor", "nightstand", "picture", "plant",
    "plate", "potted_plant", "rack", "refrigerator", "rug", "shelf", "shoe", "sink", "sofa",
    "stool", "table", "toilet", "tvstand", "tv_stand", "tv_screen", "tv", "wardrobe", "washbasin",
)  # fmt: skip
"""Words that a template's name may hold."""
_HSSD_LEXICON = "hssd_ssd_map"
_HSSD_IDS = {27: "bed", 94: "sofa", 243: "plant", 275: "chair", 324: "chair", 349: "toilet",
             369: "tv"}  # fmt: skip
"""Semantic ids of HSSD that its ObjectNav episodes name; for layouts that come without lexicon."""
_METADATA_FOLDERS = ("semantics", "metadata")
_METADATA_COLUMNS = ("main_category", "clean_category", "category", "super_category", "name")
_MAX_CSV_BYTES = 64 * 2**20


@dataclasses.dataclass(frozen=True)
class Categories:
    """Looks up what a template is."""

    by_id: Mapping[int, str]
    """Category of a semantic id."""
    by_model: Mapping[str, str]
    """Category of a model, by the stem of its mesh file."""

    def of(self, template: Template) -> str:
        """The category, one of our words where there is one; empty if nothing tells."""
        model = Path(template.table.text("render_asset")).name.split(".", 1)[0]
        if model in self.by_model:
            return category_word(self.by_model[model])
        found = self.by_id.get(template.table.whole("semantic_id") or 0, "")
        return category_word(found) if found else _from_name(template.stem)


def category_word(name: str) -> str:
    """A category in our words.

    Examples:
        >>> category_word("Potted Plant"), category_word("wardrobe")
        ('plant', 'wardrobe')
    """
    plain = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")
    return _SAME.get(plain, plain)


def _from_name(stem: str) -> str:
    """A category that a name holds as a word of its own."""
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", stem).lower()
    for text in (
        f"_{re.sub('[^a-z]+', '_', spaced)}_",
        f"_{re.sub('[^a-z]+', '_', stem.lower())}_",
    ):
        found = [word for word in _WORDS if f"_{word}_" in text]
        if found:
            return category_word(max(found, key=len))
    return ""


def read_categories(
    dataset: Dataset, *, named: str, lexicon: Path | None, log: ImportLog
) -> Categories:
    """All a dataset says about categories.

    Args:
        dataset: The dataset.
        named: The semantic descriptor that the scene names; others need not be there.
        lexicon: A semantic lexicon to use instead of the dataset's own.
        log: Gets what is not there or cannot be read.
    """
    by_id: dict[int, str] = {}
    if lexicon is not None:
        by_id = lexicon_classes(read_json(lexicon, where=str(lexicon)))
    else:
        for handle, path in sorted(dataset.descriptors.items()):
            if path.name.endswith(".semantic_config.json"):
                continue
            if path.is_file() or handle == named:
                by_id.update(_descriptor_classes(dataset, handle, path, log))
    return Categories(by_id, _models(dataset, log))


def _descriptor_classes(
    dataset: Dataset, handle: str, path: Path, log: ImportLog
) -> dict[int, str]:
    where = dataset.folder.relative(path)
    if path.is_file() and path.suffix != ".json":
        reason = "of a format with meshes of its own"
        log.add("ignored", "semantic descriptor", handle, reason=reason)
        return {}
    try:
        return lexicon_classes(read_json(path, where=where))
    except FileNotFoundError:
        log.add("missing", "semantic descriptor", handle, reason=f"no file {where}")
    except ValueError as error:
        log.add("skipped", "semantic descriptor", handle, reason=str(error))
    if handle != _HSSD_LEXICON:
        return {}
    log.note("HSSD's lexicon is not there: chairs, sofas, beds, plants, TVs and toilets are known")
    return dict(_HSSD_IDS)


def lexicon_classes(table: Table) -> dict[int, str]:
    """Names of semantic ids in a lexicon `{"classes": [{"id": 1, "name": "chair"}, ...]}`.

    Raises:
        ValueError: An entry has no id or no name.
    """
    classes = {}
    for index, row in enumerate(table.rows("classes")):
        entry = Table.of(row, where=f"{table.where}: classes[{index}]")
        number, name = entry.whole("id"), entry.text("name")
        if number is None or not name:
            raise ValueError(f"{entry.where} needs an id and a name")
        classes[number] = name
    return classes


def _models(dataset: Dataset, log: ImportLog) -> dict[str, str]:
    """Categories in CSV tables of models, as HSSD has them."""
    models: dict[str, str] = {}
    for folder in _METADATA_FOLDERS:
        for path in sorted((dataset.folder.root / folder).glob("*.csv")):
            where = dataset.folder.relative(path)
            try:
                models.update(_csv_models(path))
            except (ValueError, csv.Error, OSError) as error:
                log.add("skipped", "metadata", where, reason=str(error))
    return models


def _csv_models(path: Path) -> dict[str, str]:
    if path.stat().st_size > _MAX_CSV_BYTES:
        raise ValueError(f"has more than {_MAX_CSV_BYTES} bytes")
    with path.open(newline="", encoding="utf-8") as stream:
        reader = csv.DictReader(stream)
        columns = reader.fieldnames or []
        column = next((name for name in _METADATA_COLUMNS if name in columns), None)
        if "id" not in columns or column is None:
            return {}
        return {row["id"]: row[column] for row in reader if row["id"] and row[column]}
