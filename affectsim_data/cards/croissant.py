"""`croissant.json`: a release in the words of Croissant 1.1 and its extension for responsible AI.

Both are MLCommons': http://mlcommons.org/croissant/1.1, http://mlcommons.org/croissant/RAI/1.0.
Writing it needs nothing but JSON.
"""

from __future__ import annotations

import json
import re
from typing import Any

from affectsim_data.cards.croissant_records import (
    emotion_records,
    file_set_id,
    splits_records,
    table_records,
    tables_of,
)
from affectsim_data.cards.facts import Facts
from affectsim_data.cards.pages import LOCAL_PLACE, REPORT_CITATION
from affectsim_data.cards.statements import Statements, unmarked
from affectsim_data.releases.manifest import MANIFEST_NAME

__all__ = ["croissant_text"]

_VERSIONS = ["http://mlcommons.org/croissant/1.1", "http://mlcommons.org/croissant/RAI/1.0"]
_PREFIXES = {
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "dct": "http://purl.org/dc/terms/",
    "sc": "https://schema.org/",
}
_TERMS = (
    *("arrayShape", "citeAs", "column", "containedIn", "equivalentProperty", "extract", "field"),
    *("fileObject", "fileProperty", "fileSet", "format", "includes", "isArray", "isLiveDataset"),
    *("jsonPath", "key", "md5", "parentField", "path", "recordSet", "references", "regex"),
    *("repeated", "replace", "samplingRate", "separator", "source", "subField", "transform"),
)
"""Words of Croissant that stand without a prefix."""
_CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    **_PREFIXES,
    **{term: f"cr:{term}" for term in _TERMS},
    "conformsTo": "dct:conformsTo",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "description": {"@container": "@language"},
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "name": {"@container": "@language"},
}
_PARQUET = "application/x-parquet"
_NO_HASH = "https://github.com/mlcommons/croissant/issues/80"
"""In place of the hash of a Git repository, as the Hub's own Croissant files have it."""


def croissant_text(facts: Facts, *, place: str = LOCAL_PLACE, published: str | None = None) -> str:
    """The text of `croissant.json`.

    Args:
        facts: Of the release.
        place: Where it is; at `hf://datasets/ORG/NAME` files are named there, else beside this.
        published: Day of publication, `YYYY-MM-DD`.
    """
    url = _page(place)
    document = {
        "@context": _CONTEXT,
        "@type": "sc:Dataset",
        **_head(facts, url),
        **({"datePublished": published} if published else {}),
        **_responsibility(facts),
        "distribution": _distribution(facts, url),
        "recordSet": [
            *([splits_records(facts.splits), emotion_records()] if facts.splits else []),
            *(table_records(table) for table in tables_of(facts.manifest)),
        ],
    }
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def _page(place: str) -> str | None:
    match = re.match(r"hf://datasets/([\w.-]+/[\w.-]+)", place)
    return f"https://huggingface.co/datasets/{match[1]}" if match else None


def _head(facts: Facts, url: str | None) -> dict[str, Any]:
    manifest = facts.manifest
    episodes = (
        f"{facts.episodes.num_rows:,} replayable episodes of emotion-labelled body motion in "
    )
    what = episodes if facts.splits else ""
    cited = [REPORT_CITATION, *(one.citation for one in manifest.sources if one.obtain)]
    head: dict[str, Any] = {
        "name": manifest.name,
        "description": f"{what}{manifest.num_rows('scenes'):,} scenes. "
        + Statements(facts).sentence("synthetic"),
        "conformsTo": _VERSIONS,
        "license": [_licence_page(one) for one in manifest.licences] or ["NOASSERTION"],
        "citeAs": "\n".join(filter(None, dict.fromkeys(cited))),
        "version": _version(facts),
        "isLiveDataset": False,
        "keywords": ["affective computing", "emotion recognition", "embodied AI", "simulation"],
        "creator": {"@type": "Organization", "name": "The AffectSim-data authors"},
    }
    return {**head, "url": url} if url else head


def _licence_page(identifier: str) -> str:
    """The page of an SPDX licence; another identifier as it is."""
    known = re.fullmatch(r"[A-Za-z0-9.+-]+", identifier)
    spdx = known and not identifier.startswith(("LicenseRef", "NOASSERTION"))
    return f"https://spdx.org/licenses/{identifier}.html" if spdx else identifier


def _version(facts: Facts) -> str:
    """The schema's version, with the hash that names the content."""
    major, _, minor = facts.manifest.schema_version.partition(".")
    return f"{major}.{minor or 0}.0+{facts.manifest.sha256[:12]}"


def _responsibility(facts: Facts) -> dict[str, Any]:
    """The entries of the vocabulary for responsible AI."""
    says = Statements(facts)
    labels = [unmarked(text) for text in says.labels()]
    if not facts.splits:
        return {
            "rai:dataLimitations": says.items("scenes_limits"),
            "rai:dataReleaseMaintenancePlan": says.sentence("maintenance"),
            "rai:hasSyntheticData": True,
        }
    kinds = (("Synthetic", facts.num_procedural), ("Experiments", facts.num_recorded))
    return {
        "rai:dataCollection": " ".join(labels),
        "rai:dataCollectionType": [name for name, count in kinds if count],
        "rai:dataPreprocessingProtocol": [says.sentence("preprocessing")],
        "rai:dataAnnotationProtocol": labels,
        "rai:dataBiases": says.items("biases"),
        "rai:dataLimitations": [*says.items("limits"), *says.items("subjectivity")],
        "rai:dataUseCases": [
            *says.items("uses"),
            *(f"Not for: {item}" for item in says.items("misuses")),
        ],
        "rai:dataSocialImpact": says.sentence("social_impact"),
        "rai:personalSensitiveInformation": [says.sentence("privacy")],
        "rai:dataReleaseMaintenancePlan": says.sentence("maintenance"),
        # Not of RAI 1.0, but conferences ask for it by this name.
        "rai:hasSyntheticData": True,
    }


def _distribution(facts: Facts, url: str | None) -> list[dict[str, Any]]:
    """The repository if there is one, the manifest, every file with its hash, every table."""
    manifest = facts.manifest
    inside = {"containedIn": {"@id": "repository"}} if url else {}
    repository = {
        "@type": "cr:FileObject",
        "@id": "repository",
        "name": "repository",
        "description": "The Git repository on the Hub",
        "contentUrl": url,
        "encodingFormat": "git+https",
        "sha256": _NO_HASH,
    }
    contents = {
        "@type": "cr:FileObject",
        "@id": MANIFEST_NAME,
        "name": MANIFEST_NAME,
        "description": "Size, SHA-256 and rows of every file; camera, robot, recipe and sources",
        **inside,
        "contentUrl": MANIFEST_NAME,
        "encodingFormat": "application/json",
        "sha256": manifest.sha256,
    }
    files = [
        {
            "@type": "cr:FileObject",
            "@id": name,
            "name": name,
            **inside,
            "contentUrl": name,
            "contentSize": f"{entry.bytes} B",
            "encodingFormat": _PARQUET,
            "sha256": entry.sha256,
        }
        for name, entry in manifest.files.items()
    ]
    sets = [
        {
            "@type": "cr:FileSet",
            "@id": file_set_id(table),
            "name": file_set_id(table),
            "description": f"The files of the table {table}",
            **inside,
            "encodingFormat": _PARQUET,
            "includes": f"{table}/*.parquet",
        }
        for table in tables_of(manifest)
    ]
    return [*([repository] if url else []), contents, *files, *sets]
