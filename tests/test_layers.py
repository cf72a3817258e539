"""Modules import only from the layers below their own; importing the package costs little."""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import affectsim_data
from affectsim_data.content import ContentFolder, content_path

PACKAGE = Path(affectsim_data.__file__).parent
LAYERS = (
    ("errors", "poses", "content", "naming", "weights"),
    ("cameras", "skeletons", "glb", "motions", "avatars"),
    ("scenes", "navmesh"),
    ("schemas", "episodes", "releases", "engines"),
    ("visibility", "affordances", "observations"),
    ("render",),
    ("loaders", "simulation", "builders", "evaluation"),
    ("recognizers",),
    ("cards", "inspection", "reports", "cli", "__main__"),
)
RANKS = {name: rank for rank, names in enumerate(LAYERS) for name in names}
STRANGERS = LAYERS[6]
HEAVY = ("torch", "rerun", "moderngl", "pyrender", "OpenGL", "pyarrow", "cv2", "trimesh", "scipy")


def modules() -> list[Path]:
    """Every module of the package, relative to it."""
    found = (path.relative_to(PACKAGE) for path in PACKAGE.rglob("*.py"))
    return sorted(path for path in found if path.parts[0] != "content")


def home(path: Path) -> str:
    """The name of a module's place in the layers; empty for the package itself."""
    name = path.parts[0].removesuffix(".py")
    return "" if name == "__init__" else name


def imported(tree: ast.Module, path: Path) -> Iterator[tuple[str, int]]:
    """Homes this module imports from, with the line, wherever in the file they stand."""
    for node in ast.walk(tree):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: relative import"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            parts = name.split(".")
            if parts[0] == "affectsim_data" and parts[1:2] and parts[1] in RANKS:
                yield parts[1], getattr(node, "lineno", 0)


def test_every_module_has_a_place() -> None:
    assert len(modules()) > 20
    homeless = [str(path) for path in modules() if home(path) and home(path) not in RANKS]
    assert not homeless, f"give these a line in LAYERS and in DESIGN section 2: {homeless}"


@pytest.mark.parametrize("path", modules(), ids=str)
def test_imports_point_down(path: Path) -> None:
    own = home(path)
    if not own:
        return  # the package's own names load lazily; the next tests hold it to that
    tree = ast.parse((PACKAGE / path).read_text(encoding="utf-8"))
    wrong = [
        f"{path}:{line} imports {other}"
        for other, line in imported(tree, path)
        if RANKS[other] > RANKS[own] or (own in STRANGERS and other in STRANGERS and other != own)
    ]
    assert not wrong


def test_the_layer_check_sees_imports_wherever_they_stand() -> None:
    code = (
        "import affectsim_data.render\n"
        "def f():\n    from affectsim_data import builders, __version__\n"
        "if x:\n    from affectsim_data.loaders.presets import Clip\n"
        "import numpy\n"
    )
    found = set(imported(ast.parse(code), Path("x.py")))
    assert found == {("render", 1), ("builders", 3), ("loaders", 5)}


@pytest.mark.parametrize("path", modules(), ids=str)
def test_modules_are_not_named_in_strings_to_get_round_the_layers(path: Path) -> None:
    own = home(path)
    named = []
    for node in ast.walk(ast.parse((PACKAGE / path).read_text(encoding="utf-8"))):
        if own and isinstance(node, ast.Constant) and isinstance(node.value, str):
            parts = re.split(r"[.:]", node.value)
            if parts[0] == "affectsim_data" and len(parts) > 1:
                named.append((node.lineno, node.value))
    assert not [name for _, name in named if RANKS.get(re.split(r"[.:]", name)[1], 0) > RANKS[own]]


@pytest.mark.parametrize("path", modules(), ids=str)
def test_modules_say_what_they_are(path: Path) -> None:
    tree = ast.parse((PACKAGE / path).read_text(encoding="utf-8"))
    assert ast.get_docstring(tree), f"{path} needs a docstring"


@pytest.mark.parametrize("folder", ["builders", "cards", "loaders", "schemas"])
def test_data_folders_hold_no_python(folder: ContentFolder) -> None:
    assert not [path.name for path in content_path(folder).rglob("*.py*")]


def _loaded_after(code: str) -> set[str]:
    script = f"{code}\nimport json, sys\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60
    )
    return {name.split(".")[0] for name in json.loads(done.stdout.splitlines()[-1])}


def test_importing_the_package_loads_nothing_heavy() -> None:
    loaded = _loaded_after("import affectsim_data; dir(affectsim_data)")
    assert "affectsim_data" in loaded
    assert not loaded & {*HEAVY, "numpy"}


def test_the_probe_for_heavy_modules_works() -> None:
    assert "pyarrow" in _loaded_after("from affectsim_data import Episode")


def test_episodes_and_conditions_need_neither_torch_nor_gl() -> None:
    loaded = _loaded_after("from affectsim_data import Orbit, Episode, Motion, open_release")
    assert not loaded & {"torch", "rerun", "moderngl", "pyrender", "OpenGL"}


def test_public_names_are_there() -> None:
    for name in affectsim_data.__all__:
        assert name in dir(affectsim_data)
    with pytest.raises(AttributeError, match="module 'affectsim_data' has no attribute 'Nothing'"):
        affectsim_data.Nothing  # noqa: B018  # the access is the test
