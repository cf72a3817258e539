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

from affectsim_data.glb import GlbFile
from affectsim_data.scenes import Room, Scene, Surface

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
