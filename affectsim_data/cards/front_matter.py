"""The YAML block at the head of a card: what the Hub reads of a dataset."""

from __future__ import annotations

import re
from typing import Any

from affectsim_data.cards.facts import Facts
from affectsim_data.schemas import SPLITS

__all__ = ["front_matter", "hub_licence"]

_HUB_LICENCES = (
    *("apache-2.0", "mit", "bsd-3-clause", "cc0-1.0", "odbl-1.0"),
    *("cc-by-3.0", "cc-by-4.0", "cc-by-sa-3.0", "cc-by-sa-4.0"),
    *("cc-by-nc-3.0", "cc-by-nc-4.0", "cc-by-nc-sa-4.0", "cc-by-nc-nd-4.0", "cc-by-nd-4.0"),
)
"""Of the identifiers the Hub knows, those that data comes under."""
_SIZES = (
    *((1_000, "n<1K"), (10_000, "1K<n<10K"), (100_000, "10K<n<100K")),
    *((1_000_000, "100K<n<1M"), (10_000_000, "1M<n<10M")),
)
_TAGS = ("affectsim", "embodied-ai", "simulation", "synthetic")
_ADDRESS = re.compile(r"https?://[\w.~%#?=&:/-]*[\w~%#=&/-]", re.ASCII)


def front_matter(facts: Facts) -> str:
    """The block between the dashes."""
    from huggingface_hub import CardData

    manifest = facts.manifest
    entries: dict[str, Any] = {"pretty_name": manifest.name, **hub_licence(facts)}
    if facts.splits:
        entries["task_categories"] = ["video-classification", "robotics"]
        entries["tags"] = [*_TAGS, "emotion-recognition", "active-perception"]
        entries["annotations_creators"] = _annotators(facts)
    else:
        entries["tags"] = [*_TAGS, "3d-scenes"]
    rows = facts.episodes.num_rows or manifest.num_rows("scenes")
    entries["size_categories"] = [
        next((name for limit, name in _SIZES if rows < limit), "10M<n<100M")
    ]
    entries["configs"] = _configs(facts)
    text: str = CardData(**entries).to_yaml(line_break="\n")
    return text


def hub_licence(facts: Facts) -> dict[str, str]:
    """The entries that name the licence: the Hub's own identifier, or `other` and which."""
    licences = facts.manifest.licences
    if len(licences) == 1 and licences[0].lower() in _HUB_LICENCES:
        return {"license": licences[0].lower()}
    if not licences:
        return {"license": "unknown"}
    name = "mixed" if len(licences) > 1 else _slug(licences[0])
    entries = {"license": "other", "license_name": name}
    terms = [source.obtain for source in facts.manifest.sources if not source.redistribution]
    links = [match[0] for text in terms if (match := _ADDRESS.search(text))]
    return {**entries, "license_link": links[0]} if links else entries


def _slug(text: str) -> str:
    return re.sub(r"[^a-z0-9.]+", "-", text.lower()).strip("-.") or "other"


def _annotators(facts: Facts) -> list[str]:
    """Where labels come from: from the generator of a motion, or with a corpus."""
    kinds = (("machine-generated", facts.num_procedural), ("found", facts.num_recorded))
    return [name for name, count in kinds if count]


def _configs(facts: Facts) -> list[dict[str, Any]]:
    """What can be loaded by name, episodes first."""
    by_split = {table: _split_files(facts, table) for table in ("episodes", "index", "cells")}
    # The Hub wants a name for a split where there is none, too; `train` is its habit.
    whole = {
        table: [{"split": "train", "path": f"{table}/*.parquet"}]
        for table in ("motions", "scenes", "avatars", "trajectories", "predictions")
        if facts.manifest.num_rows(table)
    }
    found = [
        {"config_name": table, "data_files": files}
        for table, files in (by_split | whole).items()
        if files
    ]
    first, *others = found
    return [{"config_name": first.pop("config_name"), "default": True, **first}, *others]


def _split_files(facts: Facts, table: str) -> list[dict[str, str]]:
    return [
        {"split": split, "path": f"{table}/{split}-*.parquet"}
        for split in SPLITS
        if facts.manifest.num_rows(table, split)
    ]
