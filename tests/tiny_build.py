"""A release that builds in a second or two: one performer who walks in two empty rooms."""

from __future__ import annotations

from pathlib import Path

from small_release import box_room

RECIPE = """
name = "tiny"
seed = 3

[camera]
width = 64
height = 64
hfov_deg = 60.0

[scenes]
meshes = "*.glb"
licence = "CC0-1.0"
redistribution = true

[avatars]
ids = ["ada"]

[performances]
performers = ["p1"]
actions = ["simple_walk"]

[splits]
by = "performer"
train = ["p1"]
validation = []
test = []

[[compose]]
family = "action_grounded"
actions = ["simple_walk"]
repeats = 2
"""


def write_tiny(folder: Path) -> tuple[Path, Path]:
    """The recipe and the source of the tiny release, written into a folder."""
    source = folder / "rooms"
    source.mkdir(parents=True)
    for name in ("first", "second"):
        (source / f"{name}.glb").write_bytes(box_room(name).to_glb())
    recipe = folder / "tiny.toml"
    recipe.write_text(RECIPE, encoding="utf-8")
    return recipe, source


def tree(folder: Path) -> dict[str, bytes]:
    """Every file of a folder, by its path there."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
