"""Every example, every doctest and the code in the README run as they stand."""

from __future__ import annotations

import doctest
import importlib
import pkgutil
import re
import subprocess
import sys
from pathlib import Path

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


def readme_blocks() -> list[str]:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    return re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)


@pytest.mark.egl
def test_readme_code_runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    blocks = readme_blocks()
    assert blocks
    for block in blocks:
        # Places that only a reader has: a folder and a dataset of theirs.
        lines = [line for line in block.splitlines() if not re.search(r"path/to|hf://", line)]
        code = "\n".join(lines)
        code += "\nbatch = next(iter(loader))\nassert batch['video'].shape[2:] == (3, 224, 224)\n"
        subprocess.run([sys.executable, "-c", code], check=True, timeout=250)


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
