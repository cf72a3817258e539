"""What became of an import: things found, missing, skipped and ignored, by kind and by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from typing import Any, Literal, get_args

__all__ = ["ImportEntry", "ImportLog", "ImportReport", "ImportStatus"]

ImportStatus = Literal["found", "missing", "skipped", "ignored"]
"""Missing: asked for and not there. Skipped: there, not used. Ignored: of a kind never used."""

_NAMES_SHOWN = 6


@dataclasses.dataclass(frozen=True)
class ImportEntry:
    """Things of one name that came to the same."""

    status: ImportStatus
    kind: str
    """`stage`, `object`, `template`, `mesh`, `texture`, `node`, `light setup`, ..."""
    name: str
    """What the files call it."""
    count: int = 1
    """How many of it."""
    reason: str = ""
    """Why; empty for what was found."""
    asked_by: str = ""
    """The file that asked for it; empty if it was asked for directly."""


@dataclasses.dataclass(frozen=True)
class ImportReport:
    """The outcome of one import, of a scene of a dataset or of a single mesh file."""

    scene_id: str
    source: str
    """The file it was read from."""
    entries: tuple[ImportEntry, ...]
    """Sorted by status, kind, name."""
    notes: Mapping[str, int]
    """What else is to be known, and how often it happened."""
    triangles: int = 0
    """Of the scene as imported."""
    textures: int = 0
    """Decoded."""
    textures_replaced: int = 0
    """Not decoded: the colour of the material stands for them."""

    def total(self, status: ImportStatus, kind: str | None = None) -> int:
        """How many things came to this, of one kind or of all."""
        return sum(entry.count for entry in self._chosen(status, kind))

    def names(self, status: ImportStatus, kind: str | None = None) -> tuple[str, ...]:
        """Their names, each once, in order."""
        return tuple(dict.fromkeys(entry.name for entry in self._chosen(status, kind)))

    def _chosen(self, status: ImportStatus, kind: str | None) -> Iterator[ImportEntry]:
        return (e for e in self.entries if e.status == status and kind in (None, e.kind))

    def lines(self, *, max_names: int = _NAMES_SHOWN) -> list[str]:
        """For a terminal: a line of totals, one per status and kind, one per note.

        Args:
            max_names: Names shown in a line; the rest is counted.
        """
        head = (
            f"{self.scene_id}: {self.triangles} triangles, {self.textures} textures"
            f" ({self.textures_replaced} replaced by a colour), from {self.source}"
        )
        lines = [head]
        groups: dict[tuple[str, str, str], list[ImportEntry]] = {}
        for entry in self.entries:
            groups.setdefault((entry.status, entry.kind, entry.reason), []).append(entry)
        for (status, kind, reason), members in groups.items():
            why = f" ({reason})" if reason else ""
            total = sum(entry.count for entry in members)
            lines.append(f"  {status:8} {kind}: {total}{why}: {_listed(members, max_names)}")
        lines += [f"  note     {text}: {count}" for text, count in self.notes.items()]
        return lines

    def to_rows(self) -> list[dict[str, Any]]:
        """JSON rows, one per entry and note; all have the same keys."""
        rows = [dataclasses.asdict(entry) for entry in self.entries]
        rows += [
            dataclasses.asdict(ImportEntry("ignored", "note", text, count)) | {"status": "note"}
            for text, count in self.notes.items()
        ]
        totals = {
            "triangles": self.triangles,
            "textures": self.textures,
            "textures_replaced": self.textures_replaced,
        }
        rows += [
            dataclasses.asdict(ImportEntry("found", "total", name, count))
            for name, count in totals.items()
        ]
        return [{"scene_id": self.scene_id, "source": self.source, **row} for row in rows]


def _listed(members: list[ImportEntry], max_names: int) -> str:
    """Names with their counts and who asked for the first of them."""
    names = [
        entry.name if entry.count == 1 else f"{entry.name} x{entry.count}" for entry in members
    ]
    text = ", ".join(names[:max_names])
    if len(names) > max_names:
        text += f" and {len(names) - max_names} more names"
    askers = sorted({entry.asked_by for entry in members} - {""})
    if askers:
        text += f"; asked for by {askers[0]}"
        text += f" and {len(askers) - 1} more files" if len(askers) > 1 else ""
    return text


class ImportLog:
    """Collects what happens during an import; `report` freezes it."""

    def __init__(self) -> None:
        self._counts: dict[tuple[str, ...], int] = {}
        self._notes: dict[str, int] = {}

    def add(
        self,
        status: ImportStatus,
        kind: str,
        name: str,
        *,
        reason: str = "",
        asked_by: str = "",
        count: int = 1,
    ) -> None:
        """Counts a thing; equal ones become one entry."""
        key = (status, kind, name, reason, asked_by)
        self._counts[key] = self._counts.get(key, 0) + count

    def note(self, text: str, count: int = 1) -> None:
        """Counts something to be known that is no thing of its own."""
        self._notes[text] = self._notes.get(text, 0) + count

    def report(
        self,
        scene_id: str,
        *,
        source: str,
        triangles: int = 0,
        textures: int = 0,
        textures_replaced: int = 0,
    ) -> ImportReport:
        """What was collected so far."""
        order = {status: rank for rank, status in enumerate(get_args(ImportStatus))}
        entries: list[ImportEntry] = []
        for key in sorted(self._counts, key=lambda key: (order[key[0]], *key[1:])):
            status: Any = key[0]
            entries.append(ImportEntry(status, key[1], key[2], self._counts[key], *key[3:]))
        return ImportReport(
            scene_id,
            source,
            tuple(entries),
            dict(sorted(self._notes.items())),
            triangles,
            textures,
            textures_replaced,
        )
