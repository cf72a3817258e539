"""What a run would do, said before it does anything."""

from __future__ import annotations

from pathlib import Path
from textwrap import indent
from typing import Any

from affectsim_data.loaders import concatenate
from affectsim_data.recognizers.clips import Clips, clip_batches, clip_keys, run_header
from affectsim_data.recognizers.frames import frame_strip
from affectsim_data.recognizers.opening import open_recognizer
from affectsim_data.recognizers.prompts import option_order, question
from affectsim_data.releases.journals import journal_path

__all__ = ["dry_run", "strip_path"]

_ASKS = ("openai", "transformers")
"""Kinds of recognizers that are asked the project's question."""


def strip_path(out: Path) -> Path:
    """Where a dry run shows the frames of the first clip of each condition."""
    return out.with_suffix(".frames.png")


def dry_run(spec: str, dataset: Clips, out: Path, **options: Any) -> list[str]:
    """Lines that say what `predict` would do; draws the first clip of each condition beside `out`.

    No model is loaded, and nothing is sent anywhere.

    Args:
        spec: The recognizer, as `open_recognizer` takes it.
        dataset: The clips.
        out: The table it would write.
        options: Of the recognizer.

    Raises:
        ValueError: The run would end with this error at once.
    """
    keys, header = clip_keys(dataset), run_header(spec, dataset)
    parts = concatenate([dataset]).parts
    clip = parts[0].clip
    firsts = [next(clip_batches(part, [0], batch_size=1)).samples[0] for part in parts]
    picture = strip_path(out)
    picture.parent.mkdir(parents=True, exist_ok=True)
    frame_strip([sample["video"] for sample in firsts]).save(picture)
    conditions = ", ".join(dict.fromkeys(name for _, name in keys))
    lines = [
        f"release     {header.release}, {header.split}",
        f"clips       {len(keys):,}: {conditions}; {clip.num_frames} frames of "
        f"{clip.width} x {clip.height}",
        f"recognizer  {spec}",
        f"table       {out}{_what_is_there(out)}",
        f"frames      {picture}: what it is shown of {keys[0][0]}, a condition below another",
    ]
    kind = spec.partition(":")[0]
    if kind in _ASKS:
        num_frames = len(firsts[0]["video"])
        asked = question(option_order(options.get("option_seed")), num_frames=num_frames)
        lines += ["question", indent(asked, "    ")]
    if kind == "openai":
        # Nothing is sent, so any key will do.
        recognizer: Any = open_recognizer(spec, **{**options, "api_key": "dry-run"})
        lines.append("endpoint, if nothing has to be asked twice")
        lines += [f"    {line}" for line in recognizer.estimate(len(keys), firsts[0]).lines()]
    return lines


def _what_is_there(out: Path) -> str:
    if journal_path(out).exists():
        return ", begun: what is answered is not asked again"
    return ", there already: what it holds is not asked again" if out.exists() else ""
