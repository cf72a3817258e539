"""The world S: round trip through GLB, other readers, and what is refused."""

from __future__ import annotations

import dataclasses
import io
import struct
import zlib
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import trimesh
from small_release import box_quads, box_room, surface
from test_glb import changed, pack

from affectsim_data.glb import GlbBuilder, GlbFile
from affectsim_data.scenes import Chunks, Room, Scene, Surface
from affectsim_data.scenes.chunks import chunk_surfaces

TABLE = ((1.0, 0.0, 1.0), (2.0, 0.7, 2.0))
CRATE = surface("crate", box_quads((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))


def textured() -> Surface:
    """The crate with a texture of 3 x 2 pixels."""
    texture = np.arange(18, dtype=np.uint8).reshape(2, 3, 3)
    uvs = np.tile(np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32), (6, 1))
    return dataclasses.replace(CRATE, uvs=uvs, texture=texture)


def scene() -> Scene:
    """A room with a table and a textured crate."""
    room = box_room("flat/7", boxes=[TABLE])
    return dataclasses.replace(room, surfaces=(*room.surfaces, textured()))


def test_a_scene_survives_its_glb() -> None:
    before = scene()
    after = Scene.from_glb(before.to_glb(), name="file")
    assert after.semantics() == before.semantics()
    assert (after.rooms, after.seats, after.doors) == (before.rooms, before.seats, before.doors)
    for a, b in zip(after.surfaces, before.surfaces, strict=True):
        assert a.name == b.name
        for field in ("positions", "normals", "colors", "faces"):
            assert getattr(a, field).dtype == getattr(b, field).dtype
            np.testing.assert_array_equal(getattr(a, field), getattr(b, field))
    assert after.surfaces[0].texture is None
    texture, uvs = after.surfaces[-1].texture, after.surfaces[-1].uvs
    np.testing.assert_array_equal(texture, before.surfaces[-1].texture)
    np.testing.assert_array_equal(uvs, before.surfaces[-1].uvs)


def test_the_same_scene_gives_the_same_bytes() -> None:
    payload = scene().to_glb()
    assert scene().to_glb() == payload
    assert Scene.from_glb(payload, name="file").to_glb() == payload
    assert scene().mesh_sha256() == Scene.from_glb(payload, name="file").mesh_sha256()


def chunked() -> Scene:
    """The scene with its chunks, the crate's in the room, one of the table's in none."""
    before = scene()
    surfaces, chunks = chunk_surfaces(before.surfaces, before.rooms)
    return dataclasses.replace(before, surfaces=surfaces, chunks=chunks)


def test_chunks_survive_the_glb() -> None:
    before = chunked()
    after = Scene.from_glb(before.to_glb(), name="file")
    assert before.chunks is not None
    assert after.chunks is not None
    assert set(before.chunks.room) == {0}
    assert np.isinf(before.chunks.solid_low).any()
    assert np.isfinite(before.chunks.solid_low).any()
    for field in dataclasses.fields(Chunks):
        a, b = getattr(after.chunks, field.name), getattr(before.chunks, field.name)
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)
    assert after.to_glb() == before.to_glb()
    opened = trimesh.load_scene(io.BytesIO(before.to_glb()), file_type="glb")
    assert len(opened.to_mesh().faces) == before.num_triangles


def test_a_texture_that_surfaces_share_is_stored_and_decoded_once() -> None:
    twin = dataclasses.replace(textured(), name="twin", positions=CRATE.positions + 2)
    both = dataclasses.replace(scene(), surfaces=(textured(), twin))
    glb = GlbFile.from_bytes(both.to_glb(), name="file")
    assert len(glb.document["images"]) == 1
    after = Scene.from_glb(both.to_glb(), name="file")
    assert after.surfaces[0].texture is after.surfaces[1].texture


def test_the_mesh_hash_follows_the_geometry() -> None:
    moved = dataclasses.replace(CRATE, positions=CRATE.positions + np.float32(1e-3))
    hashes = {
        dataclasses.replace(box_room("r"), surfaces=(one,)).mesh_sha256() for one in (CRATE, moved)
    }
    assert len(hashes) == 2


def test_trimesh_opens_the_glb() -> None:
    before = scene()
    opened = trimesh.load_scene(io.BytesIO(before.to_glb()), file_type="glb")
    merged = opened.to_mesh()
    assert len(merged.faces) == before.num_triangles
    np.testing.assert_allclose(merged.bounds, [[-4.0, 0.0, -4.0], [4.0, 2.6, 4.0]], atol=1e-6)


def test_mesh_joins_the_surfaces() -> None:
    vertices, faces = scene().mesh()
    assert len(faces) == scene().num_triangles == 2 * (5 + 1 + 6 + 6)
    assert faces.max() == len(vertices) - 1
    # The last surface is the crate: its first triangle lies in the plane y = 1.
    np.testing.assert_array_equal(vertices[faces[-12]][:, 1], [1.0, 1.0, 1.0])


def test_walls_of_the_test_room_face_inwards() -> None:
    vertices, faces = box_room("r").mesh()
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    towards_middle = np.array([0.0, 1.3, 0.0]) - corners.mean(axis=1)
    assert (np.einsum("ij,ij->i", normals, towards_middle) > 0.0).all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"normals": CRATE.normals[:-1]}, r"normals must be \(24, 3\), got \(23, 3\)"),
        ({"colors": CRATE.colors[:, :3]}, r"colors must be \(24, 4\), got \(24, 3\)"),
        ({"positions": CRATE.positions[:, :2]}, r"positions must be \(24, 3\), got \(24, 2\)"),
        ({"positions": CRATE.positions * np.float32(np.nan)}, "positions must be finite"),
        ({"positions": np.where(CRATE.positions > 0, np.inf, -np.inf)}, "positions must be finite"),
        ({"normals": CRATE.normals + np.float32(np.inf)}, "normals must be finite"),
        ({"uvs": np.full((24, 2), np.nan, np.float32)}, "uvs must be finite"),
        ({"uvs": np.zeros((23, 2), np.float32)}, r"uvs must be \(24, 2\), got \(23, 2\)"),
        (
            {"uvs": np.zeros((24, 2), np.float32), "texture": np.zeros((4, 0, 3), np.uint8)},
            r"texture must be uint8 \(height, width, 3\), got uint8 \(4, 0, 3\)",
        ),
        (
            {"uvs": np.zeros((24, 2), np.float32), "texture": np.zeros((4, 4, 3), np.float32)},
            r"texture must be uint8 \(height, width, 3\), got float32 \(4, 4, 3\)",
        ),
        ({"faces": CRATE.faces.reshape(-1)}, r"faces must be \(n, 3\), got \(36,\)"),
        ({"faces": CRATE.faces + 20}, "a face names a vertex that is not there"),
        ({"faces": CRATE.faces.astype(np.int64) - 1}, "a face names a vertex that is not there"),
        ({"texture": np.zeros((2, 2, 3), np.uint8)}, r"a texture needs uvs \(24, 2\)"),
    ],
)
def test_bad_surfaces_are_refused_by_name(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=f"surface 'crate': {message}"):
        dataclasses.replace(CRATE, **changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"surfaces": ()}, "has no triangles"),
        ({"rooms": ()}, "has no room, so nobody can stand in it"),
        ({"surfaces": (CRATE, CRATE)}, r"surface names repeat: \['crate', 'crate'\]"),
    ],
)
def test_bad_scenes_are_refused_by_name(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=f"scene 'r': {message}"):
        dataclasses.replace(box_room("r"), **changes)


def test_a_room_needs_three_corners() -> None:
    with pytest.raises(ValueError, match="room 'a': polygon must be three or more corners"):
        Room("a", "living", ((0.0, 0.0), (1.0, 0.0)))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"surface": [0, 0, 9]}, "chunk 2 is of surface 9, there are 4 surfaces"),
        ({"surface": [-1, 0, 1]}, "chunk 0 is of surface -1, there are 4 surfaces"),
        ({"first": [2**31 - 1, 0, 0]}, "chunk 0 has triangles 2147483647 to 21474836"),
        ({"first": [0, -1, 0]}, "chunk 1 has triangles -1 to"),
        ({"count": [2**31 - 1, 1, 1]}, "chunk 0 has triangles 0 to 2147483647 of a surface of 10"),
        ({"count": [0, 1, 1]}, "chunk 0 has triangles 0 to 0 of a surface of 10"),
        ({"count": [4, 2, 12]}, "chunks do not hold each of 36 triangles exactly once"),
        ({"room": [0, 1, 0]}, "chunk 1 is in room 1, there are 1 rooms"),
        ({"room": [0, -2, 0]}, "chunk 1 is in room -2, there are 1 rooms"),
        ({"first": [0.0, 0.0, 0.0]}, r"first must be integers \(3,\), got float64 \(3,\)"),
        ({"low": np.zeros((3, 2))}, r"low must be floats \(3, 3\), got float64 \(3, 2\)"),
        ({"low": np.full((3, 3), np.nan)}, "low and high must be finite, low <= high"),
        ({"high": np.full((3, 3), -9.0)}, "low and high must be finite, low <= high"),
        ({"solid_low": np.full((3, 3), np.nan)}, "solid_low must be <= solid_high"),
    ],
)
def test_bad_chunks_are_refused_by_name(changes: dict[str, Any], message: str) -> None:
    before = chunked().chunks
    assert before is not None
    first = {
        field.name: getattr(before, field.name)[:3].copy() for field in dataclasses.fields(Chunks)
    }
    with pytest.raises(ValueError, match=f"chunk.*{message}|{message}"):
        dataclasses.replace(
            chunked(), chunks=Chunks(**first | {k: np.asarray(v) for k, v in changes.items()})
        )


def _column(**columns: Any) -> Callable[[dict[str, Any]], object]:
    return lambda document: document["extras"]["chunks"].update(columns)


def _accessor(column: str, **fields: Any) -> Callable[[dict[str, Any]], object]:
    def change(document: dict[str, Any]) -> None:
        document["accessors"][document["extras"]["chunks"][column]].update(fields)

    return change


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d["extras"].update(chunks=[1]), "chunks must be a table"),
        (lambda d: d["extras"]["chunks"].pop("room"), "chunks: there is no column room"),
        (_column(first=9999), r"the GLB has no accessors\[9999\]"),
        (_column(first=None), r"the GLB has no accessors\[None\]"),
        (_column(low=0, high=0), "chunks: columns must be equally long|exactly once"),
        (_accessor("first", componentType=5126), "first must be uint32 of 1 axes, got float32"),
        (_accessor("low", componentType=5125), "low must be float32 of 2 axes, got uint32"),
        (_accessor("first", count=1), "columns must be equally long"),
        (_accessor("first", count=2**40), "leaves its buffer view"),
    ],
)
def test_chunk_tables_that_lie_are_refused_by_name(
    change: Callable[[dict[str, Any]], object], message: str
) -> None:
    glb = GlbFile.from_bytes(chunked().to_glb(), name="file")
    change(glb.document)
    with pytest.raises(ValueError, match=f"^shard: .*({message})"):
        Scene.from_glb(pack(glb.document, glb.blob), name="shard")


def test_chunk_numbers_beyond_31_bits_and_boxes_that_are_no_numbers_are_refused() -> None:
    glb = GlbFile.from_bytes(chunked().to_glb(), name="file")
    table = glb.document["extras"]["chunks"]
    for column, value, message in (
        ("room", np.uint32(2**32 - 1), "room must be below"),
        ("low", np.float32(np.nan), "low and high must be finite"),
    ):
        view = glb.document["bufferViews"][glb.document["accessors"][table[column]]["bufferView"]]
        blob, at = bytearray(glb.blob), view["byteOffset"]
        blob[at : at + 4] = value.tobytes()
        with pytest.raises(ValueError, match=f"^shard: .*{message}"):
            Scene.from_glb(pack(glb.document, bytes(blob)), name="shard")


@pytest.mark.parametrize(
    ("attribute", "array", "message"),
    [
        ("POSITION", np.zeros((24, 3), np.uint8), "positions must be float32, got uint8"),
        ("COLOR_0", np.zeros((24, 4), np.float32), "colors must be uint8, got float32"),
        ("TEXCOORD_0", np.zeros((24, 2), np.uint16), "uvs must be float32, got uint16"),
        ("indices", np.zeros(36, np.uint16), "indices must be uint32, got uint16"),
        ("indices", np.zeros(35, np.uint32), r"indices must be three per triangle, got \(35,\)"),
    ],
)
def test_arrays_of_other_types_are_refused_by_name(
    attribute: str, array: np.ndarray, message: str
) -> None:
    one = dataclasses.replace(scene(), surfaces=(textured(),))
    glb = GlbFile.from_bytes(one.to_glb(), name="file")
    extra = GlbBuilder()
    extra.accessor(array)
    other = GlbFile.from_bytes(extra.to_bytes({}), name="extra")
    document, start = glb.document, len(glb.blob)
    view = {**other.document["bufferViews"][0], "byteOffset": start}
    document["bufferViews"].append(view)
    number = len(document["bufferViews"]) - 1
    document["accessors"].append({**other.document["accessors"][0], "bufferView": number})
    primitive = document["meshes"][0]["primitives"][0]
    place = primitive if attribute == "indices" else primitive["attributes"]
    place[attribute] = len(document["accessors"]) - 1
    with pytest.raises(ValueError, match=f"^file: surface 'crate': {message}"):
        Scene.from_glb(pack(document, glb.blob + other.blob), name="file")


def test_textures_are_bounded_in_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("affectsim_data.scenes.storage.MAX_TEXELS", 5)
    with pytest.raises(ValueError, match=r"^file: .*textures have more than 5 texels in all"):
        Scene.from_glb(scene().to_glb(), name="file")


def _extras(**fields: Any) -> Callable[[dict[str, Any]], object]:
    return lambda document: document["extras"].update(fields)


@pytest.mark.parametrize(
    "change",
    [
        lambda document: document.pop("extras"),
        lambda document: document.update(extras=[]),
        lambda document: document.update(meshes=[]),
        lambda document: document.update(materials=3),
        lambda document: document["materials"][0].update(pbrMetallicRoughness=[]),
        lambda document: document["meshes"][0]["primitives"][0]["attributes"].pop("NORMAL"),
        lambda document: document["meshes"][0]["primitives"][0].update(indices=0),
        _extras(rooms=[]),
        _extras(rooms=[{"room_id": "a"}]),
        _extras(rooms=[{"room_id": "a", "purpose": "b", "polygon": [[0, 0]]}]),
        _extras(rooms=7),
        _extras(seats=[{"sofa": 1}]),
        _extras(doors=None),
    ],
)
def test_glbs_that_are_no_scenes_are_refused_by_name(
    change: Callable[[dict[str, Any]], object],
) -> None:
    with pytest.raises(ValueError, match=r"^shard: scenes 'x': "):
        Scene.from_glb(changed(change), name="shard: scenes 'x'")


def _png(width: int, height: int) -> bytes:
    """A PNG whose header claims a size and that holds next to nothing."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        return (
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        )

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    data = zlib.compress(bytes(16))
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")
    )


@pytest.mark.parametrize(
    "picture", [b"", b"GIF89a", _png(4, 4)[:20], _png(9000, 2), _png(60_000, 60_000), _png(4, 4)]
)
def test_broken_textures_are_refused_by_name(picture: bytes) -> None:
    glb = GlbFile.from_bytes(scene().to_glb(), name="file")
    view = glb.document["bufferViews"][glb.document["images"][0]["bufferView"]]
    view.update(byteOffset=len(glb.blob), byteLength=len(picture))
    payload = pack(glb.document, glb.blob + picture + bytes(-len(picture) % 4))
    with pytest.raises(ValueError, match=r"^file: a texture cannot be read"):
        Scene.from_glb(payload, name="file")


def test_scenes_are_frozen() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        CRATE.name = "other"  # type: ignore[misc]  # the point of the test
