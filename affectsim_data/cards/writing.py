"""Puts a release's pages beside its data: README.md, croissant.json and pictures."""

from __future__ import annotations

import datetime
import json
import os
import re
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path

from affectsim_data.cards.croissant import croissant_text
from affectsim_data.cards.facts import Facts, read_facts
from affectsim_data.cards.pages import LOCAL_PLACE, card_text
from affectsim_data.cards.plots import PLOT_TITLES, draw_plots
from affectsim_data.cards.signature import Signature, read_signature, signed
from affectsim_data.cards.validation import VALIDATION_NAME, validation_text
from affectsim_data.releases import Release

__all__ = ["dataset_card", "has_own_card", "published_pages", "write_card", "write_pages"]

CARD_NAME, CROISSANT_NAME, ASSETS_NAME = "README.md", "croissant.json", "assets"
_REMEDY = "move it away, or name another folder with --out"


def dataset_card(release: Release, *, place: str = LOCAL_PLACE) -> str:
    """The text of a release's README.md, without pictures.

    Args:
        release: What to describe.
        place: What a reader writes to open it: a folder or `hf://datasets/ORG/NAME@REVISION`.

    Raises:
        ValueError: The release is a partial copy.
    """
    return signed(card_text(read_facts(release), place=place), Signature())


def write_card(release: Release, folder: Path) -> None:
    """Writes README.md into the folder of a release, whole or not at all; without pictures."""
    _put(folder, {CARD_NAME: dataset_card(release).encode()})


def write_pages(
    release: Release, folder: Path, *, contact: str | None = None, published: str | None = None
) -> list[str]:
    """Writes README.md, croissant.json and the pictures it shows, whole or not at all.

    The same release, options and version of matplotlib give the same bytes.

    Args:
        release: What to describe.
        folder: Where they go; made if it is not there. A `validation.parquet` in it is summed up.
        contact: Whom to tell of misuse, in the card: an address of mail or of a page.
        published: Day of publication, `YYYY-MM-DD`, for Croissant.

    Returns:
        Their names in the folder.

    Raises:
        ValueError: The release is a partial copy, or an option is malformed.
        FileExistsError: A page there was written or edited by somebody.
        ModuleNotFoundError: matplotlib is not installed.
    """
    told = Signature(contact=_checked_contact(contact), published=_checked_day(published))
    facts = read_facts(release)
    _check_replaceable(facts, folder)
    card = _card(facts, folder, told, PLOT_TITLES if facts.splits else ())
    plots = draw_plots(facts) if facts.splits else {}
    pages = {f"{ASSETS_NAME}/{name}": payload for name, payload in plots.items()}
    pages[CROISSANT_NAME] = croissant_text(facts, published=told.published).encode()
    pages[CARD_NAME] = card.encode()
    _put(folder, pages)
    return sorted(pages)


def _checked_contact(contact: str | None) -> str | None:
    if contact is not None and not re.fullmatch(r"[^\s<>@]+@[^\s<>@]+|https?://[^\s<>]+", contact):
        raise ValueError(f"--contact must be an address of mail or of a page, got {contact!r}")
    return contact


def _checked_day(day: str | None) -> str | None:
    if day is None:
        return None
    try:
        known = datetime.date.fromisoformat(day).isoformat()
    except ValueError:
        known = ""
    if known != day:
        raise ValueError(f"--published must be a day, YYYY-MM-DD, got {day!r}")
    return day


def _check_replaceable(facts: Facts, folder: Path) -> None:
    """Raises if a page that is there holds work of somebody's own."""
    croissant = folder / CROISSANT_NAME
    if has_own_card(folder):
        raise FileExistsError(f"{folder / CARD_NAME}: was written or edited by somebody; {_REMEDY}")
    if croissant.is_file() and not _is_generated(croissant, facts):
        raise FileExistsError(
            f"{croissant}: was written or edited by somebody, or describes other files than "
            f"those of this release; {_REMEDY}"
        )


def _is_generated(croissant: Path, facts: Facts) -> bool:
    """Whether a croissant.json is just what would be written for the release."""
    text = croissant.read_text(encoding="utf-8")
    try:
        published = json.loads(text).get("datePublished")
    except (ValueError, AttributeError):
        return False
    return text == croissant_text(facts, published=published)


def has_own_card(folder: Path) -> bool:
    """Whether the README.md of a folder was written or edited by somebody."""
    path = folder / CARD_NAME
    return path.is_file() and read_signature(path.read_text(encoding="utf-8")) is None


def published_pages(release: Release, folder: Path, *, place: str) -> dict[str, bytes]:
    """The pages to publish with the release in a folder, by name.

    README.md and croissant.json are new ones that name the place, told what those of the folder
    were; but what somebody wrote or edited stays as it is.

    Args:
        release: The release.
        folder: Where it is.
        place: What a reader will write to open it.
    """
    facts, told = read_facts(release), Signature()
    card, croissant = folder / CARD_NAME, folder / CROISSANT_NAME
    if card.is_file() and not has_own_card(folder):
        told = read_signature(card.read_text(encoding="utf-8")) or told
    pages = {
        f"{ASSETS_NAME}/{path.name}": path.read_bytes()
        for path in sorted((folder / ASSETS_NAME).glob("*"))
        if path.is_file()
    }
    if croissant.is_file() and not _is_generated(croissant, facts):
        pages[CROISSANT_NAME] = croissant.read_bytes()
    else:
        text = croissant_text(facts, place=place, published=told.published)
        pages[CROISSANT_NAME] = text.encode()
    if has_own_card(folder):
        return pages | {CARD_NAME: card.read_bytes()}
    plots = [name for name in PLOT_TITLES if f"{ASSETS_NAME}/{name}" in pages]
    return pages | {CARD_NAME: _card(facts, folder, told, plots, place=place).encode()}


def _card(
    facts: Facts, folder: Path, told: Signature, plots: Iterable[str], *, place: str = LOCAL_PLACE
) -> str:
    """The signed card of a release with the pages of a folder."""
    text = card_text(
        facts,
        place=place,
        contact=told.contact,
        plots={name: PLOT_TITLES[name] for name in plots},
        validation=validation_text(folder / VALIDATION_NAME),
    )
    return signed(text, told)


def _put(folder: Path, pages: Mapping[str, bytes]) -> None:
    """Puts files in place once all of them are written; the last one last."""
    folder.mkdir(parents=True, exist_ok=True)
    staged = Path(tempfile.mkdtemp(prefix=".card.", dir=folder))
    try:
        for name, payload in pages.items():
            path = staged / name
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(payload)
        for name in pages:
            (folder / name).parent.mkdir(exist_ok=True)
            os.replace(staged / name, folder / name)
    finally:
        shutil.rmtree(staged)
