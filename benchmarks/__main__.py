"""Runs every benchmark and writes the results as JSON and into docs/performance.md.

python -m benchmarks --out benchmarks/results [--only render throughput cold_start ...]
"""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

from benchmarks import (
    acquisition,
    environment,
    fetching,
    homes,
    index,
    loading,
    navigation,
    reference,
    render,
    retargeting,
    scenes,
    shuffling,
    statistics,
    streaming,
    wide,
)
from benchmarks.machine import describe_machine
from benchmarks.parts import run_part
from benchmarks.tables import write_tables

_PAGE = Path(__file__).resolve().parents[1] / "docs" / "performance.md"
_MODULES_WITH_PARTS = (
    *(loading, wide, index, fetching, streaming, shuffling, retargeting),
    *(homes, scenes, navigation, reference, statistics, environment, acquisition),
)
_MODULES = {part: module.__name__ for module in _MODULES_WITH_PARTS for part in module.PARTS}
"""Where the parts are that run in a process of their own."""
_ALL_ON_ONE_CORE = (
    *(index, retargeting, homes, scenes, navigation, reference, environment, acquisition),
)
_ON_ONE_CORE = (
    *("throughput", "scene_order"),
    *(part for module in _ALL_ON_ONE_CORE for part in module.PARTS),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("benchmarks/results"))
    parser.add_argument(
        "--only", nargs="*", choices=[*render.PARTS, *_MODULES], default=[*render.PARTS, *_MODULES]
    )
    options = parser.parse_args()
    machine = describe_machine()
    name = re.sub(r"[^a-z0-9]+", "-", str(machine["gl_renderer"]).lower()).strip("-")
    path = options.out / f"{name}.json"
    results = json.loads(path.read_text()) if path.is_file() else {}
    results["machine"] = machine
    for part in options.only:
        print(f"running {part} ...", flush=True)
        if part in render.PARTS:
            results[part] = render.PARTS[part]()
        else:
            cores = 1 if part in _ON_ONE_CORE else None
            results[part] = run_part(_MODULES[part], part, cores=cores)
        options.out.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(results, indent=2) + "\n")
    if _PAGE.is_file():
        write_tables(_PAGE, sorted(options.out.glob("*.json")))
    print(f"results in {path}")


if __name__ == "__main__":
    main()
