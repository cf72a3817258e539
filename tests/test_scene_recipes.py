"""`[scenes]` of recipes: what is read, what is refused."""

from __future__ import annotations

from typing import Any

import pytest

from affectsim_data.builders.recipes import read_recipe
from affectsim_data.builders.scene_recipe import read_scene_recipe
from affectsim_data.content import content_names, content_path


def test_scenes_of_a_dataset_are_chosen_by_name() -> None:
    table = {"habitat": "*.json", "include": ["apt_*"], "exclude": ["*_3"], "shell": True}
    recipe = read_scene_recipe(table, where="a.toml: [scenes]")
    assert recipe.kind == "habitat"
    assert recipe.files == "*.json"
    assert recipe.shell
    assert [recipe.wants(name) for name in ("apt_1", "apt_3", "villa")] == [True, False, False]


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({}, r"a\.toml: \[scenes\] must have exactly one of homes, habitat, meshes, got none"),
        ({"homes": "h", "meshes": "*"}, r"exactly one of .*got homes, meshes"),
        ({"homes": ""}, r"\[scenes\] homes must be a text, got ''"),
        ({"homes": "h", "shel": True}, r"\[scenes\] knows no 'shel'; is it 'shell'\?"),
        ({"homes": "h", "shell": "yes"}, r"\[scenes\] shell must be true or false, got 'yes'"),
        ({"meshes": "*", "include": "a"}, r"include must be a list of texts, got 'a'"),
        ({"meshes": "*", "max_triangles": -1}, r"max_triangles must be a whole number .*got -1"),
        ([], r"\[scenes\] must be a table, got \[\]"),
    ],
)
def test_broken_tables_are_refused(table: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        read_scene_recipe(table, where="a.toml: [scenes]")


def test_recipes_of_scenes_alone_need_neither_bodies_nor_splits() -> None:
    recipe = read_recipe("homes")
    assert recipe.compositions == ()
    assert recipe.avatar_ids == ()
    assert recipe.redistribution


def test_what_others_may_not_pass_on_stays() -> None:
    for name in ("replica_cad", "hssd", "habitat", "places"):
        recipe = read_recipe(name)
        assert recipe.scenes.needs_source
        assert not recipe.redistribution


def test_every_recipe_that_is_listed_can_be_read() -> None:
    with pytest.raises(FileNotFoundError) as error:
        read_recipe("none")
    listed = str(error.value).rsplit("one of ", 1)[1].split(", ")
    assert {"mini", "homes", "habitat"} <= set(listed) <= set(content_names("builders", ".toml"))
    for name in listed:
        assert read_recipe(name).path == content_path("builders", f"{name}.toml")
