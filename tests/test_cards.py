"""Dataset cards: complete, the same every time, and never markup from somebody's data."""

from __future__ import annotations

import ast
import dataclasses
import json
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import pytest
from PIL import Image
from small_release import small_rows, small_scenes, write_release

from affectsim_data import Release, open_release
from affectsim_data.builders.validation import Check, Measure, ValidationReport
from affectsim_data.builders.validation.findings import gather
from affectsim_data.cards import dataset_card, has_own_card, write_card, write_pages
from affectsim_data.cards.facts import Facts, Origin, read_facts
from affectsim_data.cards.markdown import code_block, code_span, linked, per_cent, plain, table
from affectsim_data.cards.pages import card_text
from affectsim_data.cards.signature import Signature, read_signature, signed
from affectsim_data.cards.validation import validation_text
from affectsim_data.cli import main
from affectsim_data.releases.manifest import Source
from affectsim_data.schemas import SPLITS

HOSTILE = (
    '"]\n---\nlicense: mit\n# <script>x</script> [a](b) ![c](d) `e` | *f* $x$ {g}: &amp; \u202e'
)
"""Ends a YAML value, begins headings, links, tables, markup, maths; turns the direction of text."""


@pytest.fixture(scope="module")
def facts(small: Release) -> Facts:
    return read_facts(small)


def hostile(facts: Facts) -> Facts:
    """The same with hostile text wherever text comes from data."""
    source = Source(
        HOSTILE, "motions", HOSTILE, False, HOSTILE, f"https://example.org/a_b {HOSTILE}"
    )
    manifest = dataclasses.replace(
        facts.manifest,
        name=HOSTILE,
        recipe=HOSTILE,
        code_version=HOSTILE,
        licences=(HOSTILE,),
        sources=(source,),
        redistribution=False,
        recipe_toml=f"name = 1\n```\n</details>\n# {HOSTILE}\n````\n",
    )
    scenes = facts.scenes.set_column(0, "scene_id", [[HOSTILE] * facts.scenes.num_rows])
    origins = (Origin("motions", HOSTILE, HOSTILE, 7),)
    return dataclasses.replace(facts, manifest=manifest, scenes=scenes, origins=origins)


def front(card: str) -> dict[str, Any]:
    """The front matter, as the Hub's own client reads it."""
    from huggingface_hub import DatasetCard

    return dict(vars(DatasetCard(card).data))


def outside_code(card: str) -> str:
    """The card without its front matter, blocks of code and code in lines."""
    body = card.split("\n---\n", 1)[1]
    body = re.sub(r"^(`{3,}).*?^\1$", "", body, flags=re.M | re.S)
    return re.sub(r"(`+)(?!`).*?(?<!`)\1(?!`)", "", body)


# What a card says


def test_the_front_matter_is_what_the_hub_reads(small: Release) -> None:
    head = front(dataset_card(small))
    assert head["pretty_name"] == "small"
    assert head["license"] == "cc0-1.0"
    assert head["size_categories"] == ["n<1K"]
    configs = {one["config_name"]: one for one in head["configs"]}
    assert list(configs) == ["episodes", "index", "motions", "scenes", "avatars"]
    assert [name for name, one in configs.items() if one.get("default")] == ["episodes"]
    assert configs["episodes"]["data_files"] == [
        {"split": split, "path": f"episodes/{split}-*.parquet"} for split in SPLITS
    ]


def test_file_patterns_are_those_of_the_release(small: Release) -> None:
    patterns = [
        file["path"] for one in front(dataset_card(small))["configs"] for file in one["data_files"]
    ]
    found = [name for pattern in patterns for name in Path(small.uri).glob(pattern)]
    assert sorted(found) == sorted(Path(small.uri) / name for name in small.manifest.files)


def test_counts_are_those_of_the_rows(small: Release) -> None:
    card = dataset_card(small)
    assert "6 replayable episodes" in card
    # splits.csv's columns: performers and episodes, motions and episodes, sequences and episodes.
    assert "| train | 0 | 0 | 2 | 2 | 0 | 0 | 2 |" in card
    assert "| test | 0 | 0 | 1 | 1 | 1 | 1 | 2 |" in card
    assert "| **total** | 0 | 0 | 5 | 5 | 1 | 1 | 6 |" in card
    assert "| train | 1 | 0 | 0 | 0 | 1 | 2 |" in card
    assert "| `rear_view` | 1 | 1 | 1 | 1 | 1 | 5 |" in card
    assert "| `dyadic` | 0 | 0 | 0 | 0 | 1 | 1 |" in card
    assert "| `simple_walk` | 0 | 0 | 0 | 0 | 1 | 1 |" in card
    for scene_id in small_scenes():
        assert re.search(rf"\| `{scene_id}` \| 1 \| \d+\.\d \| 1 \| 1 \| \d+ \| 3 \|", card)
    distances = [2.5] * 6
    assert f"{distances[0]:.2f} m (2.50 to 2.50) | 100 % | 100 % | 90 % |" in card


@pytest.mark.parametrize(
    "heading",
    [
        *("Load it", "How labels were made", "What a label is not", "Sources and licences"),
        *("Uses", "Limits", "Biases", "Privacy", "Validation", "Maintenance", "How to cite"),
    ],
)
def test_every_part_is_there_and_says_something(small: Release, heading: str) -> None:
    part = re.search(rf"^##+ {heading}\n+(.*?)(?=^##|\Z)", dataset_card(small), re.M | re.S)
    assert part is not None
    assert len(part[1]) > 80


def test_it_says_plainly_what_must_not_be_done(small: Release) -> None:
    card = dataset_card(small)
    assert "**Synthetic data.**" in card
    for word in ("Surveillance", "hiring", "Policing", "Inferring what an individual feels"):
        assert word in card.split("Out of scope.")[1].split("## Limits")[0]


def test_labels_are_told_as_they_came_about(facts: Facts) -> None:
    performed = Origin("motions", "kdae", "LicenseRef-Closed", 5)
    computed = Origin("motions", "procedural performance", "CC0-1.0", 2)
    only_people = card_text(dataclasses.replace(facts, origins=(performed,)))
    assert "5 of 7 motions are **recorded**" in only_people
    assert "**procedural**" not in only_people
    assert front(only_people)["annotations_creators"] == ["found"]
    both = card_text(dataclasses.replace(facts, origins=(computed, performed)))
    assert "2 of 7 motions are **procedural**" in both
    assert "5 of 7 motions are **recorded**" in both
    assert front(both)["annotations_creators"] == ["machine-generated", "found"]


def test_missing_episodes_are_told_with_their_reason(facts: Facts) -> None:
    full = {"split": "train", "family": "dyadic", "challenge": None, "action": "interaction"}
    rows = [
        {**full, "emotion": "sad", "planned": 30, "composed": 30, "binding_constraint": None},
        {
            **full,
            "emotion": "happy",
            "planned": 30,
            "composed": 25,
            "binding_constraint": "visible",
        },
    ]
    schema = facts.cells.schema
    whole = dataclasses.replace(facts, cells=schema.empty_table().from_pylist(rows[:1], schema))
    assert "asks for 30 episodes in 1 cells (split, family" in card_text(whole)
    short = dataclasses.replace(facts, cells=schema.empty_table().from_pylist(rows, schema))
    card = card_text(short)
    assert "asks for 60 episodes in 2 cells; 55 are there" in card
    assert "| train | `dyadic` | `interaction` | happy | `visible` | 30 | 25 |" in card
    assert "| sad |" not in card.split("55 are there")[1].split("##")[0]


def test_sources_come_with_their_terms(facts: Facts) -> None:
    source = Source(
        "kdae", "motions", "LicenseRef-Closed", False, "Zhang 2020.", "https://a.org/b_c"
    )
    manifest = dataclasses.replace(
        facts.manifest, sources=(source,), licences=("CC0-1.0", "LicenseRef-Closed")
    )
    card = card_text(dataclasses.replace(facts, manifest=manifest))
    assert (
        "- kdae (motions), `LicenseRef-Closed`, may **not** be passed on. Zhang 2020. "
        "To get it: <https://a.org/b_c>"
    ) in card
    head = front(card)
    assert (head["license"], head["license_name"]) == ("other", "mixed")
    assert head["license_link"] == "https://a.org/b_c"
    assert "This release may not be passed on" not in card, "that is the recipe's word"


# Text from data


def test_hostile_text_adds_no_front_matter(facts: Facts) -> None:
    expected, head = front(card_text(facts)), front(card_text(hostile(facts)))
    assert head["pretty_name"] == HOSTILE
    assert (head["license"], head["configs"]) == ("other", expected["configs"])
    assert head.keys() - expected.keys() == {"license_name", "license_link"}
    assert re.fullmatch(r"[a-z0-9.-]+", head["license_name"])


def test_hostile_text_is_no_markup(facts: Facts) -> None:
    honest, card = outside_code(card_text(facts)), outside_code(card_text(hostile(facts)))

    def marks(text: str) -> dict[str, int]:
        found = {
            "heading": r"^#",
            "rule": r"^---$",
            "picture": r"(?<!\\)!\[",
            "maths": r"(?<!\\)\$",
        }
        found |= {
            "link": r"(?<!\\)\]\(",
            "tag": r"<(?!https?://|!--)[a-z/]",
            "entity": r"&(?!amp;|lt;|gt;)",
        }
        return {name: len(re.findall(mark, text, re.M)) for name, mark in found.items()}

    assert marks(card) == marks(honest) | {"tag": marks(honest)["tag"] + 4}, "the recipe's details"
    assert "\u202e" not in card
    assert "<https://example.org/a_b>" in card
    rows = [line for line in card_text(hostile(facts)).splitlines() if line.startswith("|")]
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows if "script" in row} <= {5, 8}


def test_a_scene_name_stays_a_string_in_the_example(facts: Facts) -> None:
    bare = dataclasses.replace(facts, splits=(), episodes=facts.episodes.slice(0, 0))
    code = re.search(r"```python\n(.*?)```", card_text(hostile(bare), place=HOSTILE), re.S)
    assert code is not None
    calls = [node for node in ast.walk(ast.parse(code[1])) if isinstance(node, ast.Call)]
    arguments = [argument for call in calls for argument in call.args]
    assert len(arguments) == 3
    for argument in arguments:
        assert isinstance(argument, ast.Constant)
        assert argument.value == HOSTILE


def test_code_cannot_be_left() -> None:
    assert code_span("a ``b` c") == "``` a ``b` c ```"
    assert code_span("  \n ") == ""
    assert code_block("a\n```\nb\n", "toml") == "````toml\na\n```\nb\n````"
    assert plain("- a") == r"\- a"
    assert linked("javascript:alert(1) http://a.org)") == "javascript:alert(1) <http://a.org>)"
    assert table(["a", "b"], [["x", 1234]]) == "| a | b |\n| --- | ---: |\n| x | 1,234 |"
    assert per_cent(0.5) == "50 %"


# Writing


@pytest.fixture(scope="module")
def paged(small_release_path: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A release with all its pages; not to be changed by a test."""
    copy = Path(shutil.copytree(small_release_path, tmp_path_factory.mktemp("paged") / "small"))
    assert main(["card", str(copy), "--contact", "a@b.org"]) == 0
    return copy


@pytest.fixture
def folder(paged: Path, tmp_path: Path) -> Path:
    """The same for a test to change."""
    return Path(shutil.copytree(paged, tmp_path / "folder"))


def pages(root: Path) -> dict[str, bytes]:
    """What lies beside the tables."""
    found = [*root.glob("*.*"), *(root / "assets").glob("*")]
    return {
        path.relative_to(root).as_posix(): path.read_bytes() for path in found if path.is_file()
    }


def test_the_same_release_gives_the_same_pages(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first = pages(folder)
    assert {"README.md", "croissant.json", "assets/emotions.png"} < first.keys()
    capsys.readouterr()
    assert main(["card", str(folder), "--contact", "a@b.org", "--json"]) == 0
    assert pages(folder) == first
    document = json.loads(capsys.readouterr().out)
    del first["MANIFEST.json"]
    assert document == {
        "release": str(folder),
        "folder": str(folder),
        "files": {name: len(payload) for name, payload in first.items()},
    }


def test_pictures_are_small_and_have_a_clear_background(paged: Path) -> None:
    card = (paged / "README.md").read_text()
    names = re.findall(r"!\[[^\]]+\]\((.+?)\)", card)
    assert len(names) == 3
    for name in names:
        path = paged / name
        assert path.stat().st_size < 300_000
        with Image.open(path) as picture:
            alpha = picture.convert("RGBA").getchannel("A")
        assert alpha.getextrema() == (0, 255)
        assert alpha.getpixel((0, 0)) == 0


def test_pages_that_somebody_wrote_are_left_alone(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("README.md", "croissant.json"):
        before = pages(folder)
        (folder / name).write_text((folder / name).read_text().replace("small", "ours"))
        edited = pages(folder)
        assert main(["card", str(folder)]) == 1
        assert f"{folder / name}: was written or edited by somebody" in capsys.readouterr().err
        assert pages(folder) == edited
        (folder / name).write_bytes(before[name])


def test_a_failure_leaves_nothing_half_written(
    release_copy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    release = open_release(release_copy)
    before = pages(release_copy)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    for out in (release_copy, tmp_path / "new"):
        with pytest.raises(ModuleNotFoundError, match=r"need matplotlib.*affectsim-data\[plots\]"):
            write_pages(release, out)
    assert pages(release_copy) == before
    assert not (tmp_path / "new").exists()
    write_card(release, release_copy)
    assert pages(release_copy).keys() - before.keys() == {"README.md"}, "that one needs no pictures"


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("contact", "write to me", "--contact must be an address of mail or of a page"),
        ("contact", "javascript:x", "--contact must be an address"),
        ("published", "21.11.2026", "--published must be a day, YYYY-MM-DD, got '21.11.2026'"),
    ],
)
def test_malformed_options_are_refused(
    small: Release, tmp_path: Path, option: str, value: str, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        write_pages(small, tmp_path, **{option: value})
    assert not list(tmp_path.iterdir())


def test_a_part_is_not_described_as_the_whole(
    small_release_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    part = tmp_path / "part"
    assert main(["download", str(small_release_path), "--split", "test", "--out", str(part)]) == 0
    assert main(["card", str(part), "--out", str(tmp_path / "card")]) == 1
    assert "holds only split test" in capsys.readouterr().err


def test_a_card_knows_whether_it_was_edited(small: Release, release_copy: Path) -> None:
    told = Signature(contact="https://a.org/--><b>", published=None)
    text = signed("# A card\n", told)
    assert read_signature(text) == told
    assert text.count("-->") == 1
    assert read_signature(text.replace("card\n", "page\n", 1)) is None
    assert read_signature("# A card\n") is None
    write_card(small, release_copy)
    assert not has_own_card(release_copy)
    (release_copy / "README.md").write_text("---\npretty_name: Ours\n---\n")
    assert has_own_card(release_copy)


# Validation


def test_a_report_beside_the_release_is_summed_up(facts: Facts, tmp_path: Path) -> None:
    assert validation_text(tmp_path / "none.parquet") == ""
    check = Check("phases", "clips", "episode", "s", "Phases out of the cycle | all", "build again")
    never = dataclasses.replace(check, name="doors")
    fine = gather(check, [Measure.of("phases", ["a", "b"], [0.1, 0.2], high=1.0)])
    bad = gather(check, [Measure.of("phases", ["a", "b"], [0.1, 2.0], high=1.0)])
    path = tmp_path / "validation.parquet"
    ValidationReport("here", 2, (fine, gather(never, []))).write(path)
    text = validation_text(path)
    assert "all 1 checks hold" in text
    assert r"| `phases` | Phases out of the cycle \| all | 2 | 0 |" in text
    assert "doors" not in text, "nothing was looked at"
    ValidationReport("here", 2, (fine, bad)).write(path)
    text = validation_text(path)
    assert "**1 of 2 checks fail**" in text
    assert text.index("| 2 | 1 |") < text.index("| 2 | 0 |"), "what fails comes first"
    assert text in card_text(facts, validation=text)
    assert "No report of `affectsim validate`" in card_text(facts)


def test_another_file_is_no_report(small_release_path: Path, release_copy: Path) -> None:
    scene = next((small_release_path / "scenes").glob("*.parquet"))
    shutil.copy(scene, release_copy / "validation.parquet")
    with pytest.raises(ValueError, match=r"validation\.parquet: not a report of .*delete it"):
        write_pages(open_release(release_copy), release_copy)
    (release_copy / "validation.parquet").write_text("nonsense")
    with pytest.raises(ValueError, match=r"validation\.parquet: not a report of"):
        write_pages(open_release(release_copy), release_copy)


# Scenes alone


def test_scenes_alone_have_pages_too(tmp_path: Path) -> None:
    rows = {**small_rows(), "episodes": [], "motions": [], "avatars": []}
    write_release(tmp_path / "scenes", rows=rows)
    before, out = pages(tmp_path / "scenes"), tmp_path / "new" / "pages"
    assert main(["card", str(tmp_path / "scenes"), "--out", str(out)]) == 0
    assert pages(tmp_path / "scenes") == before
    found = pages(out)
    assert found.keys() == {"README.md", "croissant.json"}
    card = found["README.md"].decode()
    assert [one["config_name"] for one in front(card)["configs"]] == ["scenes"]
    assert all(f"| `{scene_id}` | 1 |" in card for scene_id in small_scenes())
    assert "$" not in card
