"""The recipe `paper`: its sources, what it says of what lacks, and a scaled-down build of it."""

from __future__ import annotations

import re
import shutil
from collections import Counter
from pathlib import Path

import pytest
from paper_sources import PaperSources, write_hssd

from affectsim_data.builders.building import build_release
from affectsim_data.builders.inventory import check_inventory
from affectsim_data.builders.recipes import read_recipe
from affectsim_data.builders.sources import find_sources, read_sources
from affectsim_data.releases import open_release
from affectsim_data.schemas import SPLITS

NAMES = ("emilya", "kdae", "dyads", "hssd")
SMALLER = {
    "count = 57": "count = 2",
    "{ train = 8, validation = 2, test = 2 }": "{ train = 1, validation = 1, test = 1 }",
    "{ train = 282, validation = 70, test = 70 }": "{ train = 20, validation = 20, test = 20 }",
    "train = 11999, validation = 3003, test = 2899": "train = 24, validation = 12, test = 8",
    "{ train = 669, validation = 84, test = 84 }": "{ train = 5, validation = 5, test = 5 }",
    "{ train = 6643, validation = 831, test = 832 }": "{ train = 23, validation = 8, test = 6 }",
    "{ train = 34, validation = 7, test = 7 }": "{ train = 1, validation = 1, test = 1 }",
    "repeats = 30": "repeats = 3",
    # Furniture of the stand-ins is made of boxes; these three can sit on it.
    '"ada", "ben", "cleo", "dan", "ela", "finn", "gita", "hugo"': '"ada", "ben", "cleo"',
}
"""Counts of the recipe, and those of a release that is built in a minute."""


def smaller(folder: Path, numbers: dict[str, str] = SMALLER) -> Path:
    """The recipe with other counts."""
    text = read_recipe("paper").path.read_text(encoding="utf-8")
    for old, new in numbers.items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = folder / "smaller.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture
def folders(tmp_path: Path) -> dict[str, Path]:
    """Empty folders for the four sources."""
    made = {name: tmp_path / name for name in NAMES}
    for folder in made.values():
        folder.mkdir()
    return made


@pytest.fixture(scope="module")
def stand_ins(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Names of files as `paper` wants them for its smaller counts; most of the files are empty."""
    root = tmp_path_factory.mktemp("stand_ins")
    sources = PaperSources(root)
    sources.touch(actors=3, kdae_actors=3, sequences=3)
    write_hssd(root / "hssd", 2)
    return sources.folders()


def test_the_counts_are_those_of_the_paper() -> None:
    recipe = read_recipe("paper")
    grounded, controlled, dyadic = recipe.compositions
    performers = grounded.split_rule.members
    assert [performers[split] for split in SPLITS] == [8, 2, 2]
    assert grounded.episodes == {"train": 11999, "validation": 3003, "test": 2899}
    assert controlled.motions == {"train": 669, "validation": 84, "test": 84}
    assert controlled.episodes == {"train": 6643, "validation": 831, "test": 832}
    assert dyadic.motions == {"train": 34, "validation": 7, "test": 7}
    assert grounded.motions is not None
    assert sum(grounded.motions.values()) + 837 == 1259
    counts = {
        split: grounded.episodes[split]
        + controlled.episodes[split]
        + dyadic.motions[split] * dyadic.repeats
        for split in SPLITS
    }
    assert counts == {"train": 19662, "validation": 4044, "test": 3941}
    assert recipe.scenes.count == 57


def test_every_source_has_its_terms() -> None:
    recipe = read_recipe("paper")
    assert [one.name for one in recipe.needs] == list(NAMES)
    assert [one.kind for one in recipe.sources] == ["motions"] * 3 + ["scenes", "avatars"]
    assert not recipe.redistribution
    assert all(one.licence and one.obtain for one in recipe.sources)
    assert [path.stem for path in recipe.files] == ["paper", *NAMES]
    own = {one.name: one.kind for one in read_recipe("mini").sources}
    assert own == {"performances": "motions", "homes": "scenes", "anny": "avatars"}
    assert read_recipe("mini").redistribution


def test_folders_are_given_by_name(folders: dict[str, Path]) -> None:
    recipe = read_recipe("paper")
    values = [f"{name}={folder}" for name, folder in folders.items()]
    assert read_sources(values, recipe) == find_sources(recipe, folders) == folders
    hssd = read_recipe("hssd")
    odd = folders["hssd"] / "a=b"
    odd.mkdir()
    for value in (str(odd), f"hssd={odd}"):
        assert read_sources([value], hssd) == {"hssd": odd}
    assert find_sources(hssd, odd) == {"hssd": odd}
    assert find_sources(read_recipe("mini"), None) == {}


@pytest.mark.parametrize(
    ("values", "lines"),
    [
        (["{kdae}"], ["emilya: not given.*On request", "kdae: not given.*physionet.org",
                      "hssd: not given.*hssd-hab", "kdae: given without a name"]),
        (["kdea={kdae}", "hssd={hssd}"], ["kdae: not given", "kdea: given, but .* is it 'kdae'?"]),
        (["kdae={kdae}", "kdae={hssd}"], ["kdae: given 2 times"]),
        (["kdae={kdae}", "hssd={kdae}"], ["kdae and hssd: one folder for both"]),
    ],
)  # fmt: skip
def test_all_that_is_wrong_with_sources_is_told_at_once(
    folders: dict[str, Path], values: list[str], lines: list[str]
) -> None:
    given = [value.format(**folders) for value in values]
    with pytest.raises(ValueError, match="'paper' reads 4 of your folders\n") as error:
        read_sources(given, read_recipe("paper"))
    for line in lines:
        assert re.search(line, str(error.value)), (line, str(error.value))
    assert str(error.value).endswith("give each as --source NAME=FOLDER")


def test_folders_that_are_not_there_are_not_found(folders: dict[str, Path]) -> None:
    for name in ("kdae", "hssd"):
        folders[name].rmdir()
    with pytest.raises(FileNotFoundError, match=r"kdae: expected .*\n  hssd: expected .* scenes"):
        find_sources(read_recipe("paper"), folders)
    with pytest.raises(ValueError, match=r"'mini' reads no folder .*, got .*; leave out"):
        read_sources([str(folders["emilya"])], read_recipe("mini"))


def test_what_is_complete_passes(tmp_path: Path, stand_ins: dict[str, Path]) -> None:
    recipe = read_recipe(smaller(tmp_path))
    assert check_inventory(recipe, stand_ins) == (recipe, ())


def test_what_lacks_is_counted_before_the_work(tmp_path: Path, stand_ins: dict[str, Path]) -> None:
    own = {name: shutil.copytree(folder, tmp_path / name) for name, folder in stand_ins.items()}
    shutil.rmtree(own["emilya"] / "PerAction" / "Knocking on the Door" / "Panic Fear" / "Brian")
    next(own["dyads"].glob("happy/*/partner_*.bvh")).unlink()
    (own["hssd"] / "stages" / "102340001.glb").unlink()
    (own["kdae"] / "BVH" / "F01" / "F01SA1V1.bvh").unlink()
    recipe = read_recipe("paper")
    with pytest.raises(ValueError, match="recipe 'paper': 7 problems") as error:
        check_inventory(recipe, own)
    for line in (
        "emilya: 3 of 12 performers: emilya_Brian, emilya_Elie, emilya_Florian",
        "emilya: knock_door: no file under 'Knocking on the Door' for emilya_Brian in 'Panic Fear'",
        "emilya: 59 of 422 motions of simple_walk, sit_down, being_seated, knock_door",
        "kdae: 14 of 837 motions of scenario",
        "dyads: 2 of 48 sequences; 1 lack a file: dyads/happy/sequence_02 (pair without a partner)",
        "hssd: 2 of 57 scenes",
        "hssd: stage missing for 1 of 2 scenes: 102340001 (stages/102340001.glb)",
        "complete the folders, change the counts in a copy of the recipe, or add --skip-broken",
    ):
        assert line in str(error.value), (line, str(error.value))
    less, lines = check_inventory(recipe, own, skip_broken=True)
    assert len(lines) == 7
    assert less.scenes.count == 2


def test_a_source_that_holds_nothing_is_named(
    stand_ins: dict[str, Path], folders: dict[str, Path]
) -> None:
    mixed = {**stand_ins, "kdae": folders["kdae"], "dyads": folders["dyads"]}
    with pytest.raises(FileNotFoundError, match=r"(?s)kdae: expected files.*dyads: expected files"):
        check_inventory(read_recipe("paper"), mixed)


@pytest.mark.realdata
def test_real_layouts_without_meshes_are_told_or_given_a_shell(
    tmp_path: Path, realdata: Path, stand_ins: dict[str, Path]
) -> None:
    layouts = {**stand_ins, "hssd": realdata / "hssd_val_layouts"}
    recipe = read_recipe(smaller(tmp_path, {**SMALLER, "count = 57": "count = 5"}))
    with pytest.raises(ValueError, match=r"hssd: stage missing for 5 of 5 scenes: 10\d{7}.* \(st"):
        check_inventory(recipe, layouts)
    shelled = recipe.with_shell()
    assert check_inventory(shelled, layouts) == (shelled, ())


@pytest.mark.slow
def test_a_smaller_paper_is_built_with_its_counts(tmp_path: Path) -> None:
    sources = PaperSources.write(tmp_path / "sources")
    path, out = smaller(tmp_path), tmp_path / "out"
    built = build_release(path, out, source=sources.folders(), jobs=1)
    assert built.shortfalls == ()
    release = open_release(out)
    counts: Counter[tuple[str, str]] = Counter()
    performers: dict[str, set[str]] = {}
    for split in SPLITS:
        for row in release.episode_table(split, ["family", "performer_id"]).to_pylist():
            counts[split, row["family"]] += 1
            if row["family"] == "action_grounded":
                performers.setdefault(split, set()).add(row["performer_id"])
    wanted = {
        "action_grounded": (24, 12, 8),
        "observation_controlled": (23, 8, 6),
        "dyadic": (3,) * 3,
    }
    for family, numbers in wanted.items():
        assert tuple(counts[split, family] for split in SPLITS) == numbers
    assert sorted(map(len, performers.values())) == [1, 1, 1]
    assert len(set().union(*performers.values())) == 3
    assert [one.name for one in release.manifest.sources] == [*NAMES, "anny"]
    assert release.manifest.redistribution is False
    scenes = release.asset_ids("scenes")
    assert scenes == ["hssd/102340000", "hssd/102340001"]
