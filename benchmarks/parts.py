"""Parts of a benchmark that run in a process of their own, so that none warms another."""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from typing import Any, TypeVar

__all__ = ["Part", "Rows", "in_fresh_process", "resident_mb", "run_part", "serve_part"]

Rows = list[dict[str, Any]]
"""One table: a dictionary per row, with the same keys in all."""
Part = Callable[[], Rows]

_In = TypeVar("_In")
_Out = TypeVar("_Out")


def run_part(module: str, name: str, *, cores: int | None = None) -> Rows:
    """Rows of a part, measured in a fresh process, pinned to some cores if asked.

    Args:
        module: Dotted name of the module, which calls `serve_part` when run.
        name: Of the part.
        cores: How many; all of them if not given.
    """
    command = [sys.executable, "-m", module, name]
    if cores is not None:
        command += ["--cores", str(cores)]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    rows: Rows = json.loads(done.stdout.splitlines()[-1])
    return rows


def serve_part(parts: Mapping[str, Part]) -> None:
    """The command line of a module of parts: runs one, prints its rows as the last line."""
    parser = argparse.ArgumentParser()
    parser.add_argument("part", choices=parts)
    parser.add_argument("--cores", type=int)
    options = parser.parse_args()
    if options.cores:
        os.sched_setaffinity(0, set(sorted(os.sched_getaffinity(0))[: options.cores]))
    print(json.dumps(parts[options.part]()))


def in_fresh_process(work: Callable[[_In], _Out], argument: _In) -> _Out:
    """What `work` returns in a process that has loaded and read nothing yet."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        return pool.submit(work, argument).result()


def resident_mb() -> float:
    """Resident set size of this process, MB."""
    with open("/proc/self/statm", encoding="ascii") as stream:
        pages = int(stream.read().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6
