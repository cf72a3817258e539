"""Every example, every doctest and the code in the README run as they stand."""

from __future__ import annotations

import doctest
import importlib
import pkgutil
import re
import subprocess
import sys
from pathlib import Path
from textwrap import indent

import pytest

import affectsim_data

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("[0-9]*.py"))


@pytest.mark.egl
@pytest.mark.slow
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_run(path: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(path)], cwd=tmp_path, capture_output=True, text=True, timeout=250
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.strip()
    lines = path.read_text(encoding="utf-8").splitlines()
    assert len(lines) < 80
    assert "You learn" in lines[0]


def code_blocks(page: str) -> list[str]:
    """Python of a page, block by block, without places that only a reader has."""
    text = (ROOT / page).read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    return [re.sub(r"^.*\((?:\"path/to|\"hf://).*\n", "", block, flags=re.M) for block in blocks]


@pytest.mark.egl
@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [
        *("README.md", "docs/loading.md", "docs/motions.md", "docs/descriptors.md"),
        *("docs/evaluation.md", "docs/recognizers.md", "docs/endpoints.md"),
        *("docs/simulation.md", "docs/policies.md", "docs/trajectories.md"),
    ],
)
def test_the_code_in_the_docs_runs(page: str, tmp_path: Path) -> None:
    body = indent("\n".join(code_blocks(page)), "    ")
    script = tmp_path / "page.py"
    script.write_text(f"def main():\n{body}\n\nif __name__ == '__main__':\n    main()\n")
    done = subprocess.run(
        [sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, timeout=250
    )
    assert done.returncode == 0, done.stderr[-2000:]


def module_names() -> list[str]:
    found = pkgutil.walk_packages(affectsim_data.__path__, "affectsim_data.")
    return [module.name for module in found if not module.name.endswith("__main__")]


def test_doctests_hold() -> None:
    attempted = 0
    for name in module_names():
        if ".bodies." in name:
            continue  # a maintainer's tool that needs the build extra
        results = doctest.testmod(importlib.import_module(name))
        assert results.failed == 0, name
        attempted += results.attempted
    assert attempted >= 5
