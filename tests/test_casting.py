"""Casting: motions acted or imported, screened, what fails is told and left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from small_release import box_room

from affectsim_data.builders.assets import load_avatars
from affectsim_data.builders.building import build_release
from affectsim_data.builders.casting import make_cast
from affectsim_data.builders.measuring import partner_place
from affectsim_data.builders.performances import perform, perform_dyad
from affectsim_data.builders.recipes import Recipe, read_recipe
from affectsim_data.content import content_path
from affectsim_data.motions import EMOTIONS, Motion
from affectsim_data.motions.bvh_writing import write_bvh
from affectsim_data.motions.motion import emotion_label
from affectsim_data.poses import invert_pose, transform_points
from affectsim_data.releases import open_release
from affectsim_data.skeletons import JOINT_NAMES

CORPUS = """
[corpus]
name = "tiny"
licence = "CC-BY-NC-4.0"
redistribution = false
pattern = '(?P<who>\\w+)_(?P<style>\\w+)_(?P<action>\\w+)\\.bvh'
performer = "{who}"
motion_id = "{who}_{style}_{action}"
fps = 30
metres_per_unit = 0.01
up_axis = "y"

[labels]
angry = "angry"
sad = "sad"

[excluded]

[actions]
scenario = "scenario"

[joints]
"""


def write_recipe(tmp_path: Path, *, more: str = "") -> Path:
    """A release of two people standing in the homes of mini, from a corpus of four files."""
    mini = content_path("builders", "mini.toml").read_text(encoding="utf-8")
    release = mini[: mini.index("[performances]")] + (
        '[splits]\nby = "performer"\ntrain = ["ann"]\ntest = ["bob"]\n'
        '[[compose]]\nfamily = "observation_controlled"\nactions = ["scenario"]\n'
        'placement = "floor"\nchallenges = ["far_visible"]\n'
    )
    joints = "".join(f'{name} = "{name}"\n' for name in JOINT_NAMES)
    more += '[screening.off]\nfrozen = "acted by code, so wrists can rest exactly"\n'
    path = tmp_path / "tiny.toml"
    path.write_text(release.replace('"mini"', '"tiny"') + more + CORPUS + joints, encoding="utf-8")
    return path


@pytest.fixture
def corpus(tmp_path: Path) -> Path:
    folder = tmp_path / "corpus"
    folder.mkdir()
    for who in ("ann", "bob"):
        for emotion in ("angry", "sad"):
            motion = perform("scenario", emotion, who, rng=np.random.default_rng(1))
            write_bvh(motion, folder / f"{who}_{emotion}_scenario.bvh")
    return folder


def teleport(path: Path) -> None:
    """Moves the person of a BVH file sideways by two metres from the middle on."""
    lines = path.read_text(encoding="utf-8").splitlines()
    start = next(n for n, line in enumerate(lines) if line.startswith("Frame Time")) + 1
    for number in range((start + len(lines)) // 2, len(lines)):
        x, rest = lines[number].split(maxsplit=1)
        lines[number] = f"{float(x) + 200.0:.4f} {rest}"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def same(one: Motion, other: Motion) -> bool:
    return (
        one.motion_id == other.motion_id
        and np.array_equal(one.root_translation, other.root_translation)
        and np.array_equal(one.joint_rotations, other.joint_rotations)
    )


def small(recipe: Recipe) -> Recipe:
    """The recipe with one performer and one pair."""
    table = {**recipe.document["performances"], "performers": ["p1"], "pairs": [["p1", "p2"]]}
    recipe.document["performances"] = table
    return recipe


def test_processes_change_nothing_and_built_in_motions_pass() -> None:
    recipe = small(read_recipe("mini"))
    avatars = load_avatars(recipe)
    one, two = (make_cast(recipe, avatars, jobs=jobs) for jobs in (1, 2))
    actions = recipe.document["performances"]["actions"]
    assert len(one.performances) == (len(actions) + 1) * len(EMOTIONS)
    assert one.rejected == ()
    for first, second in zip(one.performances, two.performances, strict=True):
        assert same(first.motion, second.motion)
        assert (first.partner is None) == (second.partner is None)
        if first.partner and second.partner:
            assert same(first.partner[0], second.partner[0])
    assert one.screening.rows() == two.screening.rows()


def test_a_partner_stands_where_the_interaction_puts_it() -> None:
    recipe = small(read_recipe("mini"))
    cast = make_cast(recipe, load_avatars(recipe))
    pairs = [one for one in cast.performances if one.partner is not None]
    assert len(pairs) == len(EMOTIONS)
    for pair in pairs:
        rng = np.random.default_rng([recipe.seed, 2, 0, 0, emotion_label(pair.motion.emotion)])
        dyad = perform_dyad(
            pair.motion.emotion,
            ("p1", "p2"),
            take=pair.motion.take,
            rng=rng,
            collection="mini",
            reserved_takes=0.0,
        )
        assert pair.partner is not None
        hips = transform_points(partner_place(), pair.partner[0].joint_positions()[:, 0])
        wanted = transform_points(dyad.T_target_partner, dyad.partner.joint_positions()[:, 0])
        np.testing.assert_allclose(hips, wanted, atol=2e-3)
    start = transform_points(invert_pose(partner_place()), np.zeros(3))
    np.testing.assert_allclose(start, [[0.0, 0.0, 1.25]], atol=1e-12)


def test_a_broken_motion_is_left_out_told_and_reported(tmp_path: Path, corpus: Path) -> None:
    teleport(corpus / "ann_sad_scenario.bvh")
    path, report = write_recipe(tmp_path), tmp_path / "report.parquet"
    built = build_release(path, tmp_path / "out", source=corpus, jobs=1, screen_report=report)
    assert [motion.motion_id for motion in built.cast.rejected] == ["tiny/ann_sad_scenario"]
    release = open_release(tmp_path / "out")
    assert release.asset_ids("motions") == [
        "tiny/ann_angry_scenario",
        "tiny/bob_angry_scenario",
        "tiny/bob_sad_scenario",
    ]
    assert release.manifest.redistribution is False
    rows = pq.read_table(report).to_pylist()
    failed = {row["motion_id"] for row in rows if not row["passed"]}
    assert failed == {"tiny/ann_sad_scenario"}
    jump = next(row for row in rows if row["motion_id"] in failed and row["check"] == "root_jump")
    assert not jump["passed"]
    assert jump["value"] > jump["limit"]


def test_unreadable_files_stop_the_build_or_are_skipped_on_request(
    tmp_path: Path, corpus: Path
) -> None:
    for name in ("ann_sad", "bob_sad"):
        file = corpus / f"{name}_scenario.bvh"
        file.write_text(file.read_text(encoding="utf-8")[:-300], encoding="utf-8")
    path, report = write_recipe(tmp_path), tmp_path / "report.parquet"
    with pytest.raises(ValueError, match=r"tiny: 2 problems:\n(.*\n){2}.*add --skip-broken"):
        build_release(path, tmp_path / "out", source=corpus, jobs=1, screen_report=report)
    assert not (tmp_path / "out").exists()
    unread = [row for row in pq.read_table(report).to_pylist() if row["check"] == "read"]
    assert [row["source"] for row in unread] == ["ann_sad_scenario.bvh", "bob_sad_scenario.bvh"]
    built = build_release(path, tmp_path / "out", source=corpus, jobs=1, skip_broken=True)
    assert len(built.cast.failures) == 2
    assert len(open_release(tmp_path / "out").asset_ids("motions")) == 2


def test_limits_of_a_recipe_are_its_own(tmp_path: Path, corpus: Path) -> None:
    strict = write_recipe(tmp_path, more="[screening.root_jump]\nlimit = 0.0\n")
    with pytest.raises(ValueError, match=r"no motion passed the screening: 4 problems:"):
        build_release(strict, tmp_path / "out", source=corpus, jobs=1)
    odd = write_recipe(tmp_path, more="[screening.smell]\nlimit = 1.0\n")
    with pytest.raises(ValueError, match="smell"):
        build_release(odd, tmp_path / "out", source=corpus, jobs=1)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"takes": {"scenario": 6}}, r"takes of 'scenario': there are 5 different ones, got 6"),
        ({"takes": {"scenaryo": 1}}, r"takes has 'scenaryo'; expected one of simple_walk"),
        ({"reserve": 0.0}, r"unknown keys reserve; it takes performers, .*reserved_takes"),
    ],
)
def test_performances_that_cannot_be_had_are_refused(more: dict[str, object], message: str) -> None:
    recipe = small(read_recipe("mini"))
    recipe.document["performances"] |= more
    with pytest.raises(ValueError, match=message):
        make_cast(recipe, load_avatars(recipe))


OWN = """
name = "own"
seed = 3
corpora = ["tiny_corpus.toml"]
[camera]
width = 224
height = 224
hfov_deg = 60.0
[robot]
[scenes]
name = "flats"
meshes = "*.glb"
licence = "CC-BY-4.0"
[avatars]
ids = ["ada", "ben"]
[thresholds]
grounded_visible = 0.2
[reference]
weight_clearance = 0.05
[screening.off]
frozen = "acted by code, so wrists can rest exactly"
[splits]
by = "performer"
train = ["ann"]
test = ["bob"]
[[compose]]
family = "action_grounded"
actions = ["scenario"]
"""


def write_own(tmp_path: Path, text: str = OWN) -> Path:
    """A release of a corpus and mesh files, each in a folder of its own."""
    joints = "".join(f'{name} = "{name}"\n' for name in JOINT_NAMES)
    (tmp_path / "tiny_corpus.toml").write_text(CORPUS + joints, encoding="utf-8")
    path = tmp_path / "own.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_own_motions_and_own_scenes_make_one_release(tmp_path: Path, corpus: Path) -> None:
    flats = tmp_path / "flats"
    flats.mkdir()
    (flats / "hall.glb").write_bytes(box_room("any").to_glb())
    path = write_own(tmp_path)
    built = build_release(path, tmp_path / "out", source={"tiny": corpus, "flats": flats}, jobs=1)
    assert built.shortfalls == ()
    release = open_release(tmp_path / "out")
    assert release.asset_ids("scenes") == ["flats/hall"]
    assert [release.num_episodes(split) for split in ("train", "test")] == [2, 2]
    terms = {one.name: (one.licence, one.redistribution) for one in release.manifest.sources}
    assert terms["tiny"] == ("CC-BY-NC-4.0", False)
    assert terms["flats"] == ("CC-BY-4.0", True)
    assert release.manifest.redistribution is False


def test_recipes_say_which_others_they_read(tmp_path: Path) -> None:
    recipe = read_recipe(write_own(tmp_path))
    assert recipe.files == (tmp_path / "own.toml", tmp_path / "tiny_corpus.toml")
    assert recipe.thresholds.grounded_visible == 0.2
    assert recipe.reference.weight_clearance == 0.05
    assert [one.name for one in recipe.needs] == ["tiny", "flats"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("grounded_visible", "grounded_visibel", r"\[thresholds\] knows no .* 'grounded_visible'"),
        ("= 0.2\n[ref", '= "much"\n[ref', r"\[thresholds\] grounded_visible must be a number"),
        ("weight_clearance", "weight_clearence", r"\[reference\] knows no .* 'weight_clearance'"),
        ('name = "flats"', 'name = "tiny"', r"own.toml: two sources are called 'tiny'; give each"),
        ('"tiny_corpus.toml"', '"kdea"', r"no corpus recipe 'kdea': .* kdae"),
        ('["tiny_corpus.toml"]', '"kdae"', r"corpora must be a list of names or paths, got 'kdae'"),
        ("[robot]", "[robot]\nradius = 1", r"\[robot\] knows no 'radius'; is it 'radius_m'\?"),
        ('meshes = "*.glb"', 'recipe = "hsd"', r"no recipe 'hsd': .* hssd"),
        ('meshes = "*.glb"', 'meshes = "*"\ncount = -1', r"\[scenes\] count must be a whole"),
    ],
)  # fmt: skip
def test_recipes_that_do_not_fit_are_refused(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    assert OWN.count(old) >= 1
    with pytest.raises((ValueError, FileNotFoundError), match=message):
        read_recipe(write_own(tmp_path, OWN.replace(old, new, 1)))
