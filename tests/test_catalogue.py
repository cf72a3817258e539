"""Furniture catalogues: models to size, upright, light, with their seats; the rest is listed."""

from __future__ import annotations

import pickle
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from mesh_files import boxes_obj, halves, png, square_glb, textured, write

from affectsim_data.builders.homes.catalogue import Catalogue, read_catalogue
from affectsim_data.builders.homes.catalogue.kinds import kinds_of
from affectsim_data.builders.homes.pieces import Furniture
from affectsim_data.builders.homes.textures import MATERIALS
from affectsim_data.errors import MissingExtraError

Boxes = dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]]
CHAIR: Boxes = {
    "oak seat": ((0, 4.2, 0), (4, 4.5, 4)),
    "back": ((0, 4.5, 0), (4, 9, 0.5)),
    "legs": ((0.2, 0, 0.2), (3.8, 4.2, 3.8)),
}
"""A chair in decimetres, its corner at the origin, its front towards +Z."""
SOFA: Boxes = {
    "seat": ((0.1, 0, 0), (1.9, 0.45, 0.9)),
    "back": ((0, 0, 0), (2, 0.85, 0.2)),
    "left arm": ((0, 0, 0), (0.1, 0.6, 0.9)),
    "right arm": ((1.9, 0, 0), (2.0, 0.6, 0.9)),
}
TABLE: Boxes = {
    "top": ((0, 0.7, 0), (1.6, 0.74, 0.9)),
    "foot": ((0.6, 0, 0.3), (1.0, 0.7, 0.6)),
}
LIBRARY = "name=Test\nlicense=CC0 \\u2014 free\n# a comment\n"


def row(number: int, name: str, model: str, size: tuple[float, float, float], **more: str) -> str:
    """The lines of one piece in a library; sizes in centimetres: width, depth, height."""
    fields = {
        "id": f"test#{model}", "name": name, "category": "Living room", "model": f"/m/{model}",
        "width": size[0], "depth": size[1], "height": size[2], "doorOrWindow": "false", **more,
    }  # fmt: skip
    return "".join(f"{key}#{number}={value}\n" for key, value in fields.items())


def library(path: Path, rows: str, models: dict[str, str | bytes]) -> Path:
    """A Sweet Home 3D library as a zip."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("PluginFurnitureCatalog.properties", LIBRARY + rows)
        for name, content in models.items():
            archive.writestr(f"m/{name}", content)
    return path


def one(catalogue: Catalogue, category: str, *, seed: int = 0) -> Furniture:
    """Any piece of a category."""
    rng = np.random.default_rng(seed)
    found = catalogue.piece(category, rng=rng, max_size=(4.0, 4.0, 4.0), least_share=0.0)
    assert found is not None, catalogue.left_out
    return found


def bounds(made: Furniture) -> np.ndarray:
    """Lowest and highest corner of a piece."""
    points = np.concatenate([part.positions for part in made.parts])
    return np.stack([points.min(axis=0), points.max(axis=0)])


@pytest.fixture
def shop(tmp_path: Path) -> Catalogue:
    """A chair, a sofa and a table."""
    rows = row(1, "Oak chair", "chair.obj", (45, 50, 90))
    rows += row(2, "Sofa", "sofa.obj", (200, 90, 85))
    rows += row(3, "Dining table", "table.obj", (160, 90, 74), dropOnTopElevation="74")
    models: dict[str, str | bytes] = {
        "chair.obj": boxes_obj(CHAIR), "sofa.obj": boxes_obj(SOFA), "table.obj": boxes_obj(TABLE),
    }  # fmt: skip
    return read_catalogue(library(tmp_path / "test.sh3f", rows, models))


def test_a_model_is_scaled_to_its_size_about_the_middle_of_its_underside(shop: Catalogue) -> None:
    chair = one(shop, "chair")
    assert (chair.width, chair.depth, chair.height) == (0.45, 0.5, 0.9)
    np.testing.assert_allclose(bounds(chair), [[-0.225, 0, -0.25], [0.225, 0.9, 0.25]], atol=1e-9)
    assert {part.material for part in chair.parts} == {"wood", "plain"}
    assert all(part.material in MATERIALS for part in chair.parts)
    for part in chair.parts:
        np.testing.assert_allclose(np.linalg.norm(part.normals, axis=1), 1.0)
        a, b, c = (part.positions[part.faces[:, k]] for k in range(3))
        across = np.cross(b - a, c - a)
        assert (np.einsum("ij,ij->i", across, part.normals[part.faces[:, 0]]) > 0.0).all()


def test_seats_are_found_before_the_back(shop: Catalogue) -> None:
    (seat,) = one(shop, "chair").seats
    assert seat.position[0] == pytest.approx(0.0, abs=0.02)
    assert seat.position[1] == pytest.approx(0.45, abs=0.005)
    # The back is the rearmost eighth of half a metre; the seat ends at the front edge.
    assert seat.depth == pytest.approx(0.4375, abs=0.03)
    assert seat.position[2] + seat.edge == pytest.approx(0.25, abs=0.02)
    places = one(shop, "sofa").seats
    assert [round(place.position[0], 1) for place in places] == [-0.6, 0.0, 0.6]
    assert all(place.depth == pytest.approx(0.7, abs=0.03) for place in places)


def test_things_can_be_put_on_tables(shop: Catalogue) -> None:
    (top,) = one(shop, "table").tops
    assert top.y == pytest.approx(0.74, abs=1e-3)
    assert 1.5 < top.width <= 1.6
    assert 0.8 < top.depth <= 0.9


def test_large_triangles_are_cut_for_the_light(shop: Catalogue) -> None:
    for part in one(shop, "table").parts:
        ends = part.positions[part.faces]
        longest = np.linalg.norm(np.roll(ends, 1, axis=1) - ends, axis=2).max(axis=1)
        across = np.cross(ends[:, 1] - ends[:, 0], ends[:, 2] - ends[:, 0])
        thin = np.linalg.norm(across, axis=1) < 0.06 * longest
        assert (longest[~thin] <= 0.5 + 1e-9).all()
        assert not thin.all()


def test_only_what_fits_is_given_and_the_choice_is_the_seeds(shop: Catalogue) -> None:
    rng = np.random.default_rng(0)
    assert shop.piece("chair", rng=rng, max_size=(0.44, 1, 1), least_share=0.0) is None
    assert shop.piece("chair", rng=rng, max_size=(0.9, 0.9, 0.9)) is None
    assert shop.piece("chair", rng=rng, max_size=(0.46, 0.52, 0.95)) is not None
    assert shop.piece("piano", rng=rng, max_size=(3, 3, 3)) is None
    assert shop.categories == ("chair", "sofa", "table")
    assert one(shop, "sofa", seed=3) is one(shop, "sofa", seed=3)


def test_a_catalogue_travels_and_gives_the_same_there(shop: Catalogue) -> None:
    copy = pickle.loads(pickle.dumps(shop))
    for mine, theirs in zip(one(shop, "chair").parts, one(copy, "chair").parts, strict=True):
        np.testing.assert_array_equal(mine.positions, theirs.positions)
        np.testing.assert_array_equal(mine.colors, theirs.colors)


def test_rotation_elevation_and_light_of_the_library_count(tmp_path: Path) -> None:
    lying: Boxes = {
        name: ((low[0], -high[2], low[1]), (high[0], -low[2], high[1]))
        for name, (low, high) in CHAIR.items()
    }
    # Y up of the chair has become Z of the file; this takes it back.
    rows = row(1, "Chair", "chair.obj", (45, 50, 90), modelRotation="1 0 0 0 0 1 0 -1 0")
    rows += row(2, "Washbasin", "box2.obj", (60, 45, 40), elevation="50")
    rows += row(3, "Desk lamp", "box3.obj", (20, 20, 40), lightSourceZ="30")
    rows += row(4, "TV", "box.obj", (90, 10, 50), elevation="120")
    box = boxes_obj({"box": ((0, 0, 0), (1, 1, 1))})
    models: dict[str, str | bytes] = {"chair.obj": boxes_obj(lying)}
    models |= {"box.obj": box, "box2.obj": box, "box3.obj": box}
    shop = read_catalogue(library(tmp_path / "test.sh3f", rows, models))
    (seat,) = one(shop, "chair").seats
    assert seat.position[1] == pytest.approx(0.45, abs=0.005)
    assert seat.position[2] > 0.0
    basin = one(shop, "basin")
    np.testing.assert_allclose(bounds(basin)[:, 1], [0.5, 0.9])
    assert basin.height == pytest.approx(0.9)
    assert one(shop, "lamp").lamp_y == pytest.approx(0.3)
    assert shop.piece("tv", rng=np.random.default_rng(0), max_size=(2, 2, 2), least_share=0) is None
    assert shop.left_out == {"test/test#box.obj": "hangs 1.2 m above the floor"}


def test_what_cannot_be_used_is_listed_with_its_reason(tmp_path: Path) -> None:
    rows = row(1, "Chair", "good.obj", (45, 50, 90))
    rows += row(2, "Chair", "broken.obj", (45, 50, 90))
    rows += row(3, "Chair", "gone.obj", (45, 50, 90))
    rows += row(4, "Chair", "flat.glb", (45, 50, 90))
    rows += row(5, "Chair", "seatless.obj", (45, 50, 90))
    rows += row(6, "Chair", "huge.obj", (4500, 50, 90))
    rows += row(7, "Chair", "nosize.obj", (45, 50, 90), height="tall")
    rows += row(8, "Chair", "chair.3ds", (45, 50, 90))
    rows += row(9, "Chair", "../../etc/passwd.obj", (45, 50, 90))
    rows += row(10, "Chair", "turned.obj", (45, 50, 90), modelRotation="1 0 0")
    rows += row(11, "Front door", "door.obj", (90, 10, 200), doorOrWindow="true")
    rows += row(12, "Rocket", "rocket.obj", (90, 10, 200))
    rows += row(13, "Chair", "good.obj", (45, 50, 90))
    models: dict[str, str | bytes] = {
        "good.obj": boxes_obj(CHAIR), "broken.obj": "v 1 2\nf 1 2 3\n", "flat.glb": square_glb(),
        "seatless.obj": boxes_obj({"box": ((0, 0, 0), (1, 1, 1))}),
    }  # fmt: skip
    shop = read_catalogue(library(tmp_path / "test.sh3f", rows, models))
    assert len(shop.entries) == 5
    for seed in range(5):
        one(shop, "chair", seed=seed)
    assert shop.left_out.pop("test/test#good.obj, again") == "its id is there twice"
    reasons = {name.split("#")[1]: why for name, why in shop.left_out.items()}
    assert set(reasons) == {
        "broken.obj", "gone.obj", "flat.glb", "seatless.obj", "huge.obj", "nosize.obj",
        "chair.3ds", "../../etc/passwd.obj", "turned.obj",
    }  # fmt: skip
    assert reasons["huge.obj"] == "width must be 0.01 to 6.0 m, got 45"
    assert reasons["nosize.obj"] == "height must be a number, got 'tall'"
    assert reasons["flat.glb"] == "the model is flat: 1 x 1 x 0"
    assert "without a seat" in reasons["seatless.obj"]
    assert "outside the folder" in reasons["../../etc/passwd.obj"]
    assert "nine numbers" in reasons["turned.obj"]
    assert "is not there" in reasons["gone.obj"]
    assert "must end in .glb" in reasons["chair.3ds"]


def test_licences_are_kept_per_model(shop: Catalogue) -> None:
    assert shop.licences["test/test#chair.obj"] == "CC0 \N{EM DASH} free"
    chair = one(shop, "chair")
    assert chair.licence == "CC0 \N{EM DASH} free"
    assert chair.credit.startswith(next(e.name for e in shop.entries if "chair" in e.entry_id))


def test_textures_become_vertex_colours(tmp_path: Path) -> None:
    payload = square_glb(images=[png(halves())], material=textured())
    write(tmp_path / "plant.glb", payload)
    write(tmp_path / "catalogue.csv", "name,width,depth,height,category,licence\n"
          "plant.glb,0.5,0.5,1,plant,MIT\n")  # fmt: skip
    shop = read_catalogue(tmp_path)
    assert shop.licences == {"plant.glb": "MIT"}
    assert (
        shop.piece("plant", rng=np.random.default_rng(0), max_size=(1, 1, 2), least_share=0) is None
    )
    assert shop.left_out == {"plant.glb": "the model is flat: 1 x 1 x 0"}
    slope = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 1]], np.float32)
    payload = square_glb(
        images=[png(halves())], material=textured(), attributes={"POSITION": slope}, normals=False
    )
    write(tmp_path / "plant.glb", payload)
    (part,) = one(read_catalogue(tmp_path), "plant").parts
    left = part.positions[:, 0] < -0.2
    np.testing.assert_allclose(part.colors[left], np.tile([1.0, 0.0, 0.0], (left.sum(), 1)))


def test_folders_of_models_take_their_sizes_from_tables_or_names(tmp_path: Path) -> None:
    write(tmp_path / "names/oak_chair_45x50x90cm.obj", boxes_obj(CHAIR))
    write(tmp_path / "names/table-1.6x0.9x0.74m.obj", boxes_obj(TABLE))
    write(tmp_path / "names/sofa.obj", boxes_obj(SOFA))
    write(tmp_path / "names/thing_10x10x10.obj", boxes_obj(TABLE))
    shop = read_catalogue(tmp_path / "names")
    assert one(shop, "chair").depth == 0.5
    assert one(shop, "table").width == 1.6
    assert set(shop.left_out) == {"sofa.obj", "thing_10x10x10.obj"}
    assert "an OBJ has no unit" in shop.left_out["sofa.obj"]
    write(tmp_path / "table/a.obj", boxes_obj(CHAIR))
    write(
        tmp_path / "table/catalogue.toml",
        '[[model]]\nname = "a.obj"\nwidth = 0.45\ndepth = 0.5\nheight = 0.9\ncategory = "chair"\n'
        '[[model]]\nname = "b.obj"\nwidth = 1\ndepth = 1\nheight = 1\ncategory = "chair"\n'
        '[[model]]\nname = "a.obj"\nwidth = "x"\ndepth = 1\nheight = 1\ncategory = "chair"\n'
        '[[model]]\nname = "a.obj"\nwidth = 1\ndepth = 1\nheight = 1\n',
    )
    shop = read_catalogue(tmp_path / "table")
    assert one(shop, "chair").height == 0.9
    assert [why.split()[0] for why in shop.left_out.values()] == ["b.obj", "width", "category"]


def test_models_with_too_many_triangles_are_simplified(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("fast_simplification")
    # A ball of 20,000 triangles.
    rings, sides = 101, 100
    down, around = np.meshgrid(
        np.linspace(0, np.pi, rings), np.arange(sides) * 2 * np.pi / sides, indexing="ij"
    )
    points = np.stack(
        [np.sin(down) * np.cos(around), np.cos(down), np.sin(down) * np.sin(around)], axis=-1
    ).reshape(-1, 3)
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in points]
    for ring in range(rings - 1):
        for side in range(sides):
            a, b = ring * sides + side + 1, ring * sides + (side + 1) % sides + 1
            lines.append(f"f {a} {b} {b + sides} {a + sides}")
    rows = row(1, "Potted plant", "plant.obj", (50, 50, 50))
    path = library(tmp_path / "test.sh3f", rows, {"plant.obj": "\n".join(lines)})
    made = one(read_catalogue(path), "plant")
    count = sum(len(part.faces) for part in made.parts)
    assert 1000 < count < 2500
    radius = np.linalg.norm(
        np.concatenate([p.positions for p in made.parts]) - [0, 0.25, 0], axis=1
    )
    np.testing.assert_allclose(radius, 0.25, atol=0.01)
    monkeypatch.setitem(sys.modules, "fast_simplification", None)
    with pytest.raises(MissingExtraError, match=r"affectsim-data\[build\]"):
        one(read_catalogue(path), "plant")


def test_what_is_no_library_is_told(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="none: no such furniture library"):
        read_catalogue(tmp_path / "none")
    with pytest.raises(ValueError, match=r"x.sh3f: not a furniture library"):
        read_catalogue(write(tmp_path / "a/x.sh3f", b"PK no zip"))
    (tmp_path / "empty").mkdir()
    with pytest.raises(ValueError, match="empty: no furniture here; expected"):
        read_catalogue(tmp_path / "empty")
    with zipfile.ZipFile(tmp_path / "bare.sh3f", "w") as archive:
        archive.writestr("readme.txt", "")
    with pytest.raises(ValueError, match=r"bare.sh3f: .* must have PluginFurnitureCatalog"):
        read_catalogue(tmp_path / "bare.sh3f")
    rows = row(1, "Chair", "gone.3ds", (45, 50, 90))
    with pytest.raises(ValueError, match=r"none.sh3f: no furniture that can be used \(none/test#"):
        read_catalogue(library(tmp_path / "none.sh3f", rows, {}))
    write(tmp_path / "bad/catalogue.toml", "[[model]\n")
    with pytest.raises(ValueError, match=r"catalogue.toml: does not parse"):
        read_catalogue(tmp_path / "bad")


def test_members_larger_than_they_may_be_are_not_unpacked(tmp_path: Path) -> None:
    rows = row(1, "Chair", "bomb.obj", (45, 50, 90)) + row(2, "Chair", "ok.obj", (45, 50, 90))
    path = tmp_path / "test.sh3f"
    library(path, rows, {"bomb.obj": b"\n" * (65 * 2**20), "ok.obj": boxes_obj(CHAIR)})
    assert path.stat().st_size < 2**20
    shop = read_catalogue(path)
    for seed in range(4):
        one(shop, "chair", seed=seed)
    assert "more than the 67108864 allowed" in shop.left_out["test/test#bomb.obj"]


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("Oak chair", ("chair",)), ("Desk lamp", ("lamp",)), ("Bedside table", ("nightstand",)),
        ("Office chair", ("desk_chair",)), ("Pool table", ()), ("Baby bed", ("crib",)),
        ("Television cabinet", ("sideboard",)), ("TV 16:9", ("tv",)), ("Piano bench", ("bench",)),
        ("Wall light", ()), ("Rattan sofa", ()), ("Coffee table", ("coffee_table",)),
    ],
)  # fmt: skip
def test_names_say_what_a_piece_is(name: str, kinds: tuple[str, ...]) -> None:
    assert kinds_of(name)[:1] == kinds


@pytest.mark.realdata
def test_real_models_are_furniture(realdata: Path) -> None:
    shop = read_catalogue(realdata / "sweethome3d_cc0")
    assert len([why for why in shop.left_out.values() if "is not there" in why]) > 20
    made = {}
    for entry in shop.entries:
        found = shop.furniture(entry, entry.kinds[0])
        assert found is not None, shop.left_out
        made[entry.entry_id.split("#")[-1]] = found
    assert len(made) >= 9
    for name, piece in made.items():
        count = sum(len(part.faces) for part in piece.parts)
        assert 0 < count <= 8000, name
        low, high = bounds(piece)
        np.testing.assert_allclose(high - low, [piece.width, piece.height, piece.depth], rtol=0.03)
        np.testing.assert_allclose((low + high)[[0, 2]] / 2.0, 0.0, atol=0.02)
    assert made["plasticChair"].seats[0].position[1] == pytest.approx(0.45, abs=0.04)
    assert made["armchair"].seats[0].position[1] == pytest.approx(0.45, abs=0.05)
    assert made["oakTable"].tops[0].y == pytest.approx(0.74, abs=0.03)
    assert set(shop.licences.values()) == {"Public domain"}
