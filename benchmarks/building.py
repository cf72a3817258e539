"""What a build costs, stage by stage, and how that grows with the number of episodes.

python -m benchmarks.building [--recipe small] [--shares 0.1 0.5 1.0] [--jobs 2] [--out FILE.json]

Every share builds the recipe anew with that share of its episodes, in a folder that is removed
again; motions and scenes stay as many as they are. A cost per episode that stays the same says that
composing grows linearly.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import tempfile
from pathlib import Path
from typing import Any

from affectsim_data.builders.building import BuildReport, build_release
from affectsim_data.builders.recipes import read_recipe
from affectsim_data.inspection.building import cost_lines
from benchmarks.machine import describe_machine

__all__ = ["measure_build"]


def measure_build(recipe: str, share: float, jobs: int) -> BuildReport:
    """Builds a recipe with a share of its episodes, somewhere, and tells what it cost.

    Args:
        recipe: Name or path.
        share: Of the episodes of every `[[compose]]` that says how many it wants, in (0, 1].
        jobs: Processes.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "share.toml"
        path.write_text(_with_share(read_recipe(recipe).path, share), encoding="utf-8")
        return build_release(path, Path(folder) / "out", jobs=jobs)


def _with_share(path: Path, share: float) -> str:
    """The recipe's text with smaller numbers in its lines `episodes = {...}`."""
    lines = path.read_text(encoding="utf-8").splitlines()
    for place, line in enumerate(lines):
        if line.startswith("episodes = {"):
            words = [str(max(1, round(share * int(w)))) if w.isdigit() else w for w in _words(line)]
            lines[place] = " ".join(words)
    return "\n".join(lines)


def _words(line: str) -> list[str]:
    return line.partition("#")[0].replace(",", " ,").replace("}", " }").split()


def _result(report: BuildReport, share: float) -> dict[str, Any]:
    costs = {cost.name: dataclasses.asdict(cost) for cost in report.costs}
    episodes = costs["episodes"]
    return {
        "share": share,
        "stages": costs,
        "ms_per_episode": 1e3 * episodes["seconds"] / max(episodes["units"], 1),
        "peak_gb": max(cost.peak_bytes for cost in report.costs) / 2**30,
    }


def main() -> None:
    """Measures, prints, and writes the numbers if asked to."""
    parser = argparse.ArgumentParser(description="What a build costs, stage by stage.")
    parser.add_argument("--recipe", default="small")
    parser.add_argument("--shares", type=float, nargs="+", default=[0.1, 0.5, 1.0])
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    results = []
    for share in options.shares:
        report = measure_build(options.recipe, share, options.jobs)
        results.append(_result(report, share))
        print(f"{options.recipe}, {share:g} of its episodes, {options.jobs} jobs")
        print("\n".join(cost_lines(report)))
        print(f"  {results[-1]['ms_per_episode']:.1f} ms an episode")
    if options.out is not None:
        document = {"machine": describe_machine(), "builds": results}
        options.out.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
