"""Puts measured results into docs/performance.md, between its markers."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

__all__ = ["write_tables"]

_START, _END = "<!-- results start -->", "<!-- results end -->"
_TITLES = {
    "reference": "Planning a reference view, one core",
    "render": "Renderer: frames per second, one skinned body",
    "home": "Renderer: a walk through a furnished home, one skinned body",
    "throughput": "Dataset against video decoding, one core, 8 x 224 x 224",
    "memory": "Memory over 2,000 samples",
    "startup": "Start-up, seconds",
    "wide": "The wide release that loading is measured on",
    "opening": "Its index: milliseconds to open a dataset, one core",
    "episodes": "Its episodes: rows read one by one in random order, one core",
    "specs": "Specifications without drawing, 8 frames, one core",
    "fetching": "Fetching 4 scenes and 64 motions at 100 Mbit/s, 30 ms",
    "cold_start": "Training from the Hub at 100 Mbit/s, 30 ms, nothing cached",
    "epoch_memory": "Memory of a worker that streams 2,000 samples",
    "scene_order": "Plain against scene-aware order, one core, room for 4 of 57 scenes",
    "randomness": "What scene-aware order costs in randomness",
    "training": "What that does to a linear classifier, one epoch in batches of 16",
    "retargeting": "Taking over a clip of 22 joints, one core",
    "homes": "Building a furnished home: core seconds by stage, one core",
    "scenes": "Scenes from their shard to the device, one core",
    "navigation": "Moving about in a home, one core",
    "statistics": "Evaluating 24 models x 4 conditions x 3,941 episodes with 2,000 draws",
    "environment": "Steps of the environment, RGB-D 224 x 224, one core",
    "environment_memory": "Memory over many episodes in one process",
    "acquisition": "What policies acquire in nine episodes of `mini`, one core",
}


def write_tables(page: Path, results: Sequence[Path]) -> None:
    """Rewrites the part of `page` between the markers from result files."""
    text = page.read_text(encoding="utf-8")
    before, rest = text.split(_START)
    after = rest.split(_END)[1]
    blocks = [_machine_block(json.loads(path.read_text())) for path in results]
    page.write_text(f"{before}{_START}\n\n{''.join(blocks)}{_END}{after}", encoding="utf-8")


def _machine_block(result: dict[str, Any]) -> str:
    machine = result["machine"]
    lines = [
        f"### {machine['gl_renderer']}",
        "",
        f"{machine['cpu']}, {machine['cores']} cores; OpenGL {machine['gl_version']}; "
        f"Python {machine['python']}; affectsim-data {machine['affectsim_data']}.",
        "",
    ]
    for part, title in _TITLES.items():
        if part in result:
            lines += [f"**{title}**", "", *_table(result[part]), ""]
    return "\n".join(lines) + "\n"


def _table(rows: Sequence[dict[str, Any]]) -> list[str]:
    names = list(rows[0])
    head = [" | ".join(name.replace("_", " ") for name in names), "|".join("---" for _ in names)]
    body = [" | ".join(_cell(row[name]) for name in names) for row in rows]
    return [f"| {line} |" if "---" not in line else f"|{line}|" for line in [*head, *body]]


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.2f}" if abs(value) < 10 else f"{value:,.1f}"
    return f"{value:,}" if isinstance(value, int) else str(value)
