"""Plans of downloads as lines for a terminal."""

from __future__ import annotations

from affectsim_data.releases.planning import Plan, TableShare, format_bytes

__all__ = ["plan_lines"]

_HEADER = ("table", "files", "size", "here", "to fetch", "size")
_LISTED_SCENES = 8


def plan_lines(plan: Plan, *, limit: int) -> list[str]:
    """A table of what would be fetched; `limit` is what the local cache holds, in bytes."""
    rows = [_HEADER, *(_row(name, share) for name, share in plan.tables.items() if share.files)]
    rows.append(_row("total", plan.total))
    widths = [max(len(row[column]) for row in rows) for column in range(len(_HEADER))]
    lines = [f"{plan.uri}: {_part(plan)}"]
    for row in rows:
        first, *others = zip(row, widths, strict=True)
        cells = [first[0].ljust(first[1]), *(text.rjust(width) for text, width in others)]
        lines.append("  " + "  ".join(cells))
    lines.append(f"  the local cache holds at most {format_bytes(limit)}")
    if plan.uri.startswith("hf:") and plan.total.bytes > limit:
        lines.append("  which is less than the selection: give `affectsim download` an --out")
    return lines


def _part(plan: Plan) -> str:
    text = f"split{'s' * (len(plan.selection.splits) != 1)} {', '.join(plan.selection.splits)}"
    scenes = plan.selection.scene_ids
    if scenes is None:
        return text
    listed = ", ".join(scenes[:_LISTED_SCENES]) + (", ..." if len(scenes) > _LISTED_SCENES else "")
    return f"{text}, {len(scenes)} scene{'s' * (len(scenes) != 1)}: {listed}"


def _row(name: str, share: TableShare) -> tuple[str, ...]:
    left = share.to_json()
    return (
        name,
        str(share.files),
        format_bytes(share.bytes),
        str(share.local_files),
        str(left["fetch_files"]),
        format_bytes(left["fetch_bytes"]),
    )
