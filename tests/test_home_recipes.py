"""Recipes of homes: both forms of a file, and what is said of one that is broken."""

from __future__ import annotations

import pickle
import re
from pathlib import Path

import numpy as np
import pytest

from affectsim_data.builders.homes import HomeRecipe, home_recipes
from affectsim_data.content import content_path

PALETTE = """
[palettes.plain]
wall = "#f1ece2"
accent_wall = "#c9d2cb"
floor = "#c9a67c"
wood = "#c79f6f"
dark_wood = "#7d5c41"
sofa = "#7f8f9c"
textile = "#d9cdb8"
rug = "#e4ddd0"
accent = "#c9764f"
cabinet = "#ff0000"
"""
HOME = """
[[home]]
scene_id = "flat"
seed = 3
rooms = ["living", "bath"]
area_m2 = 45
"""
SET = """
[set]
prefix = "some/home_"
count = 9
seed = 5
rooms = [2, 7]
area_m2 = [40.0, 180.0]
"""


def read(folder: Path, text: str) -> tuple[HomeRecipe, ...]:
    path = folder / "homes.toml"
    path.write_text(text, encoding="utf-8")
    return home_recipes(path)


def test_homes_are_named_one_by_one(tmp_path: Path) -> None:
    (recipe,) = read(tmp_path, PALETTE + HOME + 'palette = "plain"\n')
    assert (recipe.scene_id, recipe.seed, recipe.area_m2) == ("flat", 3, 45.0)
    assert recipe.rooms == ("living", "bath")
    assert recipe.palette is not None
    np.testing.assert_array_equal(recipe.palette.cabinet, [1.0, 0.0, 0.0])
    (plain,) = read(tmp_path, HOME.replace('["living", "bath"]', "3"))
    assert plain.palette is None
    assert plain.rooms == 3


def test_a_set_is_drawn_within_its_ranges(tmp_path: Path) -> None:
    recipes = read(tmp_path, SET)
    assert [recipe.scene_id for recipe in recipes] == [f"some/home_{k:02d}" for k in range(9)]
    assert {recipe.rooms for recipe in recipes} == {2, 3, 4, 5, 6, 7}
    assert all(40.0 <= recipe.area_m2 <= 180.0 for recipe in recipes)
    assert len({recipe.seed for recipe in recipes}) == 9
    assert recipes == read(tmp_path, SET)
    shorter = read(tmp_path, SET.replace("count = 9", "count = 4"))
    assert shorter == recipes[:4]


@pytest.mark.parametrize(("name", "count"), [("mini", 4), ("small", 12), ("full", 57)])
def test_the_files_that_come_along_are_read(name: str, count: int) -> None:
    recipes = home_recipes(content_path("builders", f"homes-{name}.toml"))
    assert len({recipe.scene_id for recipe in recipes}) == count
    assert len(pickle.dumps(recipes)) < 100_000


BROKEN = {
    "not TOML": ("[[home", "not TOML"),
    "neither": (PALETTE, r"needs either \[\[home\]\] tables or one \[set\]"),
    "both": (HOME + SET, r"needs either \[\[home\]\] tables or one \[set\]"),
    "unknown table": (HOME + "[sett]\n", "the file knows no 'sett'; is it 'set'"),
    "missing": (HOME.replace("seed = 3\n", ""), r"\[\[home\]\] 1 needs seed"),
    "unknown key": (HOME + "area = 3\n", r"\[\[home\]\] 1 knows no 'area'; is it 'area_m2'"),
    "seed": (HOME.replace("seed = 3", "seed = -3"), "seed must be a whole number from 0, got -3"),
    "area": (HOME.replace("= 45", "= '45'"), "area_m2 must be a number, got '45'"),
    "rooms": (HOME.replace('["living", "bath"]', "2.5"), "rooms must be purposes or how many"),
    "purpose": (HOME.replace('"bath"', '"attic"'), r"\[\[home\]\] 1: .* got 'attic'"),
    "too many": (HOME.replace('["living", "bath"]', "60"), "rooms must be 2 to 7, got 60"),
    "too small": (HOME.replace("= 45", "= 9"), "area_m2 of 2 such rooms must be 22 to .*, got 9"),
    "palette": (PALETTE + HOME + 'palette = "plane"\n', "must be one of .*: plain; got 'plane'"),
    "colour": (PALETTE.replace("#ff0000", "red") + HOME, r"cabinet must be a colour .* got 'red'"),
    "digits": (PALETTE.replace("#ff0000", "#ffg000") + HOME, "cabinet must be .* got '#ffg000'"),
    "no sofa": (PALETTE.replace('sofa = "#7f8f9c"\n', "") + HOME, "palettes.plain. needs sofa"),
    "twice": (HOME + HOME, "scene_id repeats: flat"),
    "count": (SET.replace("count = 9", "count = 0"), r"\[set\]: count must be 1 to \d+, got 0"),
    "no prefix": (SET.replace('prefix = "some/home_"\n', ""), r"\[set\] needs prefix"),
    "range": (SET.replace("[2, 7]", "[7, 2]"), r"\[set\]: rooms must be \[least, most\]"),
    "rooms of a set": (SET.replace("[2, 7]", "[2, 60]"), r"rooms must lie in 2 to 7, got \[2, 60"),
    "area of a set": (
        SET.replace("180.0", "60.0"), r"area_m2 \[40, 60\] suits no home of \d rooms, which has",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_file_says_what_and_where(name: str, tmp_path: Path) -> None:
    text, message = BROKEN[name]
    with pytest.raises(ValueError, match=message) as caught:
        read(tmp_path, text)
    assert re.match(r".*homes\.toml: ", str(caught.value))
