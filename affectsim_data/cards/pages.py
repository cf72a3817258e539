"""The README.md of a release: a dataset card the Hugging Face Hub understands."""

from __future__ import annotations

import json
from collections.abc import Mapping
from string import Template
from types import MappingProxyType

from affectsim_data.cards.facts import Facts
from affectsim_data.cards.front_matter import front_matter
from affectsim_data.cards.markdown import code_block, code_span, linked, plain, table
from affectsim_data.cards.statements import Statements
from affectsim_data.cards.statistics import (
    cells_text,
    count_tables,
    measured_table,
    scenes_table,
    splits_table,
)
from affectsim_data.content import content_path

__all__ = ["LOCAL_PLACE", "NOT_PASSED_ON", "REPORT_CITATION", "card_text"]

LOCAL_PLACE = "path/to/this/folder"
"""What a reader writes to open a release in a folder."""
REPORT_CITATION = (
    "Xing, Wang, Lian, Zhao, Lu, Zhang, Yu, Peng, Huang, Zeng, Hu. AffectSim: A Controllable "
    "Interactive 3D Simulation Benchmark for Embodied Affective Perception. Technical report, 2026."
)
"""The report that defines the episodes, conditions and metrics."""
NOT_PASSED_ON = (
    "**This release may not be passed on.** Share its recipe: whoever has the sources builds it "
    "from that."
)
_CONTACT = (
    "the maintainers of this repository on the Hub, under *Community*, or to whoever gave you "
    "the release"
)


def card_text(
    facts: Facts,
    *,
    place: str = LOCAL_PLACE,
    contact: str | None = None,
    plots: Mapping[str, str] = MappingProxyType({}),
    validation: str = "",
) -> str:
    """The text of a release's README.md.

    Args:
        facts: Of the release.
        place: What a reader writes to open it: a folder or `hf://datasets/ORG/NAME@REVISION`.
        contact: Whom to tell of misuse: an address of mail or of a page.
        plots: Pictures of `assets/` to show, with what they are of.
        validation: What `affectsim validate` found, Markdown.
    """
    manifest, says = facts.manifest, Statements(facts)
    values: dict[str, str] = {
        "front_matter": front_matter(facts),
        "name": plain(manifest.name),
        "place": json.dumps(place, ensure_ascii=False),
        "synthetic": _quoted(says.text("synthetic")),
        "scenes_table": scenes_table(facts, episodes=bool(facts.splits)),
        "origins_table": _origins_table(facts),
        "sources": _sources(facts),
        "terms": "" if manifest.redistribution else NOT_PASSED_ON,
        "contact": linked(contact) if contact else _CONTACT,
        "validation": validation or _not_validated(),
        "maintenance": says.text("maintenance"),
        "report": REPORT_CITATION,
        "code_version": code_span(manifest.code_version),
        "recipe": code_span(manifest.recipe),
        "seed": str(manifest.seed),
        "schema_version": code_span(manifest.schema_version),
        "recipe_text": _recipe_text(facts),
    }
    if not facts.splits:
        values["scene_id"] = json.dumps(_first_scene(facts), ensure_ascii=False)
        values["limits"] = says.text("scenes_limits")
        return _filled("scenes_card.md", values)
    values |= _episode_values(facts, says)
    values["plots"] = "\n\n".join(f"![{title}](assets/{name})" for name, title in plots.items())
    return _filled("dataset_card.md", values)


def _episode_values(facts: Facts, says: Statements) -> dict[str, str]:
    """What only a card of episodes says."""
    names = ("subjectivity", "uses", "misuses", "social_impact", "limits", "biases", "privacy")
    values = {name: says.text(name) for name in names}
    values |= {
        f"num_{table}": f"{facts.manifest.num_rows(table):,}"
        for table in ("scenes", "motions", "avatars")
    }
    return values | {
        "summary": _summary(facts),
        "split": facts.splits[-1],
        "splits_table": splits_table(facts),
        "count_tables": count_tables(facts),
        "cells": cells_text(facts),
        "measured_table": measured_table(facts),
        "labels": "\n\n".join(says.labels()),
    }


def _filled(template: str, values: dict[str, str]) -> str:
    text = Template(content_path("cards", template).read_text(encoding="utf-8")).substitute(values)
    # Where a part has nothing to say, one empty line remains.
    while "\n\n\n" in text:
        text = text.replace("\n\n\n", "\n\n")
    return text.rstrip() + "\n"


def _summary(facts: Facts) -> str:
    manifest = facts.manifest
    return (
        f"{facts.episodes.num_rows:,} replayable episodes of emotion-labelled body motion in "
        f"{manifest.num_rows('scenes'):,} scenes: a release of AffectSim, where observation is an "
        "experimental variable."
    )


def _quoted(text: str) -> str:
    return text.replace("\n", "\n> ")


def _first_scene(facts: Facts) -> str:
    names: list[str] = facts.scenes.column("scene_id").to_pylist()
    return names[0] if names else ""


def _origins_table(facts: Facts) -> str:
    rows: list[list[str | int]] = [
        [one.table, linked(one.source), code_span(one.licence) or "none stated", one.count]
        for one in facts.origins
    ]
    return table(["table", "made from", "licence", "rows"], rows, left=3)


def _sources(facts: Facts) -> str:
    """The sources the manifest names, with their terms."""
    return "\n".join(
        f"- {plain(one.name)} ({plain(one.kind)}), {code_span(one.licence)}, "
        f"{'may' if one.redistribution else 'may **not**'} be passed on."
        + (f" {linked(one.citation)}" if one.citation else "")
        + (f" To get it: {linked(one.obtain)}" if one.obtain else "")
        for one in facts.manifest.sources
    )


def _not_validated() -> str:
    return (
        "No report of `affectsim validate` lies beside this release. To check it: "
        "`affectsim validate FOLDER --report FOLDER/validation.parquet`."
    )


def _recipe_text(facts: Facts) -> str:
    if not facts.manifest.recipe_toml:
        return ""
    block = code_block(facts.manifest.recipe_toml, "toml")
    return f"\n<details>\n<summary>The recipe</summary>\n\n{block}\n\n</details>"
