"""Runs every benchmark and writes the results as JSON and into docs/performance.md.

python -m benchmarks --out benchmarks/results [--only render throughput memory startup]
"""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

from benchmarks import loading, render
from benchmarks.machine import describe_machine
from benchmarks.tables import write_tables

_PAGE = Path(__file__).resolve().parents[1] / "docs" / "performance.md"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("benchmarks/results"))
    parser.add_argument("--only", nargs="*", default=["render", *loading.PARTS])
    options = parser.parse_args()
    machine = describe_machine()
    name = re.sub(r"[^a-z0-9]+", "-", str(machine["gl_renderer"]).lower()).strip("-")
    path = options.out / f"{name}.json"
    results = json.loads(path.read_text()) if path.is_file() else {}
    results["machine"] = machine
    for part in options.only:
        print(f"running {part} ...", flush=True)
        if part == "render":
            results[part] = render.run()
        else:
            results[part] = loading.run_part(part, cores=1 if part == "throughput" else None)
        options.out.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(results, indent=2) + "\n")
    if _PAGE.is_file():
        write_tables(_PAGE, sorted(options.out.glob("*.json")))
    print(f"results in {path}")


if __name__ == "__main__":
    main()
