"""Mesh files: what is in them is read as their formats mean it, and nothing is lost in silence."""

from __future__ import annotations

import base64
import io
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_files import (
    KTX2_ETC1S,
    KTX2_UASTC,
    SQUARE,
    SQUARE_FACES,
    SQUARE_UVS,
    Document,
    boxes_obj,
    document_of,
    halves,
    pack,
    plain_ktx2,
    png,
    png_header,
    square_glb,
    textured,
    write,
)
from PIL import Image

from affectsim_data.builders.meshes import MeshAsset, MeshLimits, MeshPart, read_mesh
from affectsim_data.builders.meshes.ktx2 import decode_ktx2


def read(folder: Path, payload: bytes, **limits: int) -> MeshAsset:
    """A GLB read from disk."""
    return read_mesh(write(folder / "model.glb", payload), limits=MeshLimits(**limits))


def only(asset: MeshAsset) -> MeshPart:
    """The one part of an asset."""
    assert len(asset.parts) == 1
    return asset.parts[0]


def face_normals(part: MeshPart) -> np.ndarray:
    """Of its triangles, unit, `(num_faces, 3)`."""
    a, b, c = (part.positions[part.faces[:, k]].astype(np.float64) for k in range(3))
    across = np.cross(b - a, c - a)
    return np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))


def changed(change: Callable[[Document], object], **parts: Any) -> bytes:
    """The square with its JSON changed."""
    document, blob = document_of(square_glb(**parts))
    change(document)
    return pack(document, blob)


# glTF as it is meant


def test_a_textured_square_comes_out_as_it_went_in(tmp_path: Path) -> None:
    asset = read(tmp_path, square_glb(images=[png(halves())], material=textured()))
    part = only(asset)
    assert (part.node, part.material, part.name) == ("square", "paint", "square:paint")
    assert asset.num_triangles == 2
    np.testing.assert_array_equal(asset.bounds, [[0, 0, 0], [1, 1, 0]])
    np.testing.assert_array_equal(part.texture, halves())
    assert part.uvs is not None
    corner = np.flatnonzero((part.positions == [1, 1, 0]).all(axis=1))[0]
    np.testing.assert_array_equal(part.uvs[corner], [1, 0])
    assert (part.colors == 255).all()
    surface = part.to_surface("wall")
    assert surface.name == "wall"
    assert surface.texture is part.texture
    assert not asset.notes


def test_node_poses_are_applied_from_the_root_down(tmp_path: Path) -> None:
    half = float(np.sqrt(0.5))
    # The inner node is scaled, then turned 90 degrees about +Y, then moved; the outer one moves on.
    inner = {"scale": [2, 3, 4], "rotation": [0, half, 0, half], "translation": [5, 0, 0]}
    outer = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 10, 0, 1]
    nodes = [{"children": [1], "matrix": outer}, {"mesh": 0, "name": "inner", **inner}]
    part = only(read(tmp_path, square_glb(extra={"nodes": nodes})))
    corner = part.positions[np.argmax(part.positions[:, 1] - part.positions[:, 2])]
    np.testing.assert_allclose(corner, [5, 13, -2], atol=1e-5)
    np.testing.assert_allclose(part.normals, np.tile([1, 0, 0], (4, 1)), atol=1e-6)
    np.testing.assert_allclose(face_normals(part), np.tile([1, 0, 0], (2, 1)), atol=1e-6)


def test_mirrored_nodes_still_face_outwards(tmp_path: Path) -> None:
    part = only(read(tmp_path, square_glb(node={"scale": [-1, 1, 1]})))
    assert part.positions[:, 0].min() == -1.0
    np.testing.assert_allclose(part.normals, np.tile([0, 0, 1], (4, 1)), atol=1e-6)
    np.testing.assert_allclose(face_normals(part), np.tile([0, 0, 1], (2, 1)), atol=1e-6)


def test_uneven_scale_keeps_normals_across_the_surface(tmp_path: Path) -> None:
    slope = np.array([[0, 0, 0], [1, 0, 0], [1, 1, -1], [0, 1, -1]], np.float32)
    normal = np.tile(np.array([[0, 0.5, 0.5]], np.float32), (4, 1))
    attributes = {"POSITION": slope, "NORMAL": normal}
    part = only(read(tmp_path, square_glb(attributes=attributes, node={"scale": [1, 3, 1]})))
    np.testing.assert_allclose(part.normals[:2], face_normals(part), atol=1e-6)


def test_base_colour_and_vertex_colours_multiply_as_light(tmp_path: Path) -> None:
    material = {"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1.0, 1.0]}}
    colors = np.tile(np.array([[255, 128, 0, 255]], np.uint8), (4, 1))
    part = only(read(tmp_path, square_glb(material=material, attributes={"COLOR_0": colors})))
    # sRGB of 0.5, of 0.25 x 128 / 255 and of 0: 1.055 x^(1 / 2.4) - 0.055.
    expected = [round(255 * (1.055 * x ** (1 / 2.4) - 0.055)) for x in (0.5, 0.25)]
    assert part.colors[0, 0] == expected[0]
    assert abs(int(part.colors[0, 1]) - 0.734 * expected[1]) <= 2
    np.testing.assert_array_equal(part.colors[:, 2:], np.tile([0, 255], (4, 1)))


def test_second_texture_coordinates_and_texture_transforms_are_followed(tmp_path: Path) -> None:
    move = {"offset": [0.5, 0.25], "rotation": float(np.pi / 2), "scale": [2, 3], "texCoord": 1}
    material = textured(extensions={"KHR_texture_transform": move})
    second = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    payload = square_glb(
        images=[png(halves())], material=material, attributes={"TEXCOORD_1": second},
        extra={"extensionsUsed": ["KHR_texture_transform"]},
    )  # fmt: skip
    part = only(read(tmp_path, payload))
    assert part.uvs is not None
    # A quarter turn takes u to -v, as every viewer does (KhronosGroup/glTF issue 1563).
    order = [int(np.flatnonzero((part.positions == one).all(axis=1))[0]) for one in SQUARE]
    expected = [[0.5, 0.25], [0.5, -1.75], [3.5, -1.75], [3.5, 0.25]]
    np.testing.assert_allclose(part.uvs[order], expected, atol=1e-6)


@pytest.mark.parametrize(("code", "far", "note"), [(10497, 3.0, ""), (33071, 1.0, "cut off"),
                                                   (33648, 3.0, "unmirrored")])  # fmt: skip
def test_textures_that_do_not_repeat_are_noted(
    tmp_path: Path, code: int, far: float, note: str
) -> None:
    extra = {"textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": code}]}
    payload = square_glb(
        images=[png(halves())], material=textured(), attributes={"TEXCOORD_0": 3 * SQUARE_UVS},
        extra=extra,
    )  # fmt: skip
    asset = read(tmp_path, payload)
    uvs = only(asset).uvs
    assert uvs is not None
    assert uvs.max() == far
    assert note in "".join(asset.notes)
    assert bool(asset.notes) == bool(note)


def test_strips_and_fans_become_triangles_and_points_are_counted(tmp_path: Path) -> None:
    corners = np.array([0, 1, 3, 2], np.uint16)
    strip = only(read(tmp_path, square_glb(faces=corners, primitive={"mode": 5})))
    np.testing.assert_allclose(face_normals(strip)[:, 2], 1.0)
    fan = np.array([0, 1, 2, 3], np.uint16)
    assert only(read(tmp_path, square_glb(faces=fan, primitive={"mode": 6}))).faces.shape == (2, 3)
    whole, points = {"attributes": {"POSITION": 0}, "indices": 3}, {"attributes": {"POSITION": 0}}
    meshes = [{"primitives": [whole, {**points, "mode": 0}]}]
    assert read(tmp_path, square_glb(extra={"meshes": meshes})).notes == {
        "primitives of points dropped": 1
    }


def test_missing_normals_are_sharp_over_edges_and_smooth_over_bends(tmp_path: Path) -> None:
    box = only(read_obj(tmp_path, boxes_obj({"box": ((0, 0, 0), (1, 1, 1))})))
    assert len(box.positions) == 24
    np.testing.assert_allclose(np.abs(box.normals).max(axis=1), 1.0)
    flat = only(read(tmp_path, square_glb(normals=False)))
    np.testing.assert_allclose(flat.normals, np.tile([0, 0, 1], (4, 1)), atol=1e-6)
    angle = np.linspace(0, np.pi, 13)
    rows = [f"v {np.cos(a):.6f} {np.sin(a):.6f} {z}" for a in angle for z in (0, 1)]
    faces = [f"f {2 * k + 1} {2 * k + 2} {2 * k + 4} {2 * k + 3}" for k in range(12)]
    bent = only(read_obj(tmp_path, "\n".join(rows + faces)))
    assert len(bent.positions) == 26
    inner = np.abs(bent.positions[:, 1]) > 0.1
    along = np.einsum("ij,ij->i", bent.normals[inner, :2], bent.positions[inner, :2])
    np.testing.assert_allclose(np.abs(along), 1.0, atol=1e-3)


def test_normals_that_are_none_are_replaced(tmp_path: Path) -> None:
    normals = np.array([[0, 0, 0], [np.nan, 0, 1], [0, 0, 5], [0, 0, 1]], np.float32)
    part = only(read(tmp_path, square_glb(attributes={"NORMAL": normals})))
    np.testing.assert_allclose(part.normals, np.tile([0, 0, 1], (4, 1)), atol=1e-6)


def test_cut_outs_lose_what_shows_nothing(tmp_path: Path) -> None:
    material = {**textured(), "alphaMode": "MASK"}
    right = np.tile(np.array([[0.9, 0.5]], np.float32), (4, 1))
    three = np.concatenate([SQUARE, SQUARE + np.array([2, 0, 0], np.float32)])
    uvs = np.concatenate([SQUARE_UVS, right])
    faces = np.concatenate([SQUARE_FACES, SQUARE_FACES + 4]).astype(np.uint16)
    attributes = {"POSITION": three, "TEXCOORD_0": uvs}
    payload = square_glb(
        images=[png(halves(alpha=True))], material=material, attributes=attributes, faces=faces,
        normals=False,
    )  # fmt: skip
    asset = read(tmp_path, payload)
    assert asset.notes["masked triangles that show nothing dropped"] == 2
    assert only(asset).positions[:, 0].max() == 1.0
    texture = only(asset).texture
    assert texture is not None
    # The clear half takes the mean colour of the other, not the blue that was hidden there.
    np.testing.assert_array_equal(texture, np.broadcast_to([255, 0, 0], (4, 4, 3)))


def test_glass_is_drawn_pale_and_counted(tmp_path: Path) -> None:
    pbr = {"baseColorFactor": [0.0, 0.0, 0.0, 0.25]}
    asset = read(tmp_path, square_glb(material={"pbrMetallicRoughness": pbr, "alphaMode": "BLEND"}))
    assert asset.notes == {"see-through parts drawn opaque": 1}
    assert (only(asset).colors[:, 3] == 255).all()
    assert only(asset).colors[:, :3].min() > 140
    clear = {"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.0]}, "alphaMode": "BLEND"}
    with pytest.raises(ValueError, match=r"model.glb: has no triangle.*2 clear triangles dropped"):
        read(tmp_path, square_glb(material=clear))


def test_other_materials_give_their_colour(tmp_path: Path) -> None:
    name = "KHR_materials_pbrSpecularGlossiness"
    glossy = {"extensions": {name: {"diffuseFactor": [1.0, 0.0, 0.0, 1.0]}}}
    asset = read(tmp_path, square_glb(material=glossy, extra={"extensionsUsed": [name]}))
    np.testing.assert_array_equal(only(asset).colors[0], [255, 0, 0, 255])
    assert asset.notes == {f"{name}: diffuse part only": 1}
    screen = {
        "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]},
        "emissiveFactor": [0, 1, 0],
    }
    lit = read(tmp_path, square_glb(material=screen))
    np.testing.assert_array_equal(only(lit).colors[0], [0, 255, 0, 255])


def test_sparse_and_interleaved_accessors_are_read(tmp_path: Path) -> None:
    document, blob = document_of(square_glb(normals=False))
    start = len(blob)
    blob += np.array([2], "<u2").tobytes() + b"\0\0" + np.array([[1, 5, 0]], "<f4").tobytes()
    rows = np.concatenate([np.full((4, 3), 7, "<f4"), SQUARE_UVS], axis=1)
    document["bufferViews"] += [
        {"buffer": 0, "byteOffset": start, "byteLength": 2},
        {"buffer": 0, "byteOffset": start + 4, "byteLength": 12},
        {"buffer": 0, "byteOffset": start + 16, "byteLength": 80, "byteStride": 20},
    ]
    blob += rows.astype("<f4").tobytes()
    first = len(document["bufferViews"]) - 3
    document["accessors"][0]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": first, "componentType": 5123},
        "values": {"bufferView": first + 1},
    }
    document["accessors"][1].update(bufferView=first + 2, byteOffset=12)
    document["buffers"] = [{"byteLength": len(blob)}]
    part = only(read(tmp_path, pack(document, blob)))
    assert part.positions[:, 1].max() == 5.0
    again = read(tmp_path, square_glb(images=[png(halves())], material=textured(), normals=False))
    assert only(again).uvs is not None


def test_gltf_takes_buffers_and_textures_beside_it_and_from_data_uris(tmp_path: Path) -> None:
    document, blob = document_of(square_glb(material=textured()))
    document["buffers"] = [{"byteLength": len(blob), "uri": "parts/my%20data.bin"}]
    data = "data:image/png;base64," + base64.b64encode(png(halves())).decode()
    document["textures"], document["images"] = [{"source": 0}], [{"uri": data}]
    write(tmp_path / "parts/my data.bin", blob)
    path = write(tmp_path / "model.gltf", json.dumps(document))
    np.testing.assert_array_equal(only(read_mesh(path)).texture, halves())
    document["images"] = [{"uri": "wood.png"}]
    write(path, json.dumps(document))
    asset = read_mesh(path)
    assert only(asset).texture is None
    assert list(asset.notes) == [
        "texture images[0] wood.png missing, base colour instead: wood.png is not there"
    ]


def test_skinned_meshes_stand_as_their_joints_do(tmp_path: Path) -> None:
    document, blob = document_of(
        square_glb(
            attributes={
                "JOINTS_0": np.zeros((4, 4), np.uint8),
                "WEIGHTS_0": np.tile(np.array([[1, 0, 0, 0]], np.float32), (4, 1)),
            }
        )
    )
    document["skins"] = [{"joints": [1]}]
    document["nodes"][0].update(skin=0, translation=[100, 0, 0])
    document["nodes"].append({"translation": [0, 0, 3]})
    document["scenes"] = [{"nodes": [0, 1]}]
    asset = read(tmp_path, pack(document, blob))
    np.testing.assert_array_equal(asset.bounds, [[0, 0, 3], [1, 1, 3]])
    assert asset.notes["skinned meshes in their rest pose"] == 1


def test_one_coloured_textures_become_colours(tmp_path: Path) -> None:
    grey = np.full((8, 8, 3), 128, np.uint8)
    part = only(read(tmp_path, square_glb(images=[png(grey)], material=textured())))
    assert part.texture is None
    np.testing.assert_array_equal(part.colors[:, :3], np.full((4, 3), 128))


# KTX2


@pytest.mark.parametrize(("payload", "within"), [(KTX2_ETC1S, 4), (KTX2_UASTC, 1)])
def test_basis_textures_are_decoded(tmp_path: Path, payload: bytes, within: int) -> None:
    pytest.importorskip("opengl_basisu")
    extra = {
        "textures": [{"extensions": {"KHR_texture_basisu": {"source": 0}}}],
        "extensionsUsed": ["KHR_texture_basisu"],
        "extensionsRequired": ["KHR_texture_basisu"],
    }
    asset = read(tmp_path, square_glb(images=[payload], material=textured(), extra=extra))
    texture = only(asset).texture
    assert texture is not None
    assert texture.shape == (8, 8, 3)
    assert np.abs(texture[0, 0].astype(int) - [200, 40, 60]).max() <= within
    assert np.abs(texture[7, 7].astype(int) - [30, 160, 90]).max() <= within
    assert not asset.notes


def test_without_the_decoder_the_note_names_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "opengl_basisu", None)
    material = textured([1.0, 0.0, 0.0, 1.0])
    asset = read(tmp_path, square_glb(images=[KTX2_UASTC], material=material))
    np.testing.assert_array_equal(only(asset).colors[0], [255, 0, 0, 255])
    note = "".join(asset.notes)
    assert note.startswith("texture images[0] not decoded, base colour instead")
    assert "pip install 'affectsim-data[ktx2]'" in note


@pytest.mark.parametrize("packed", [False, True])
def test_plain_ktx2_needs_no_decoder(packed: bool) -> None:
    pixels = np.random.default_rng(0).integers(0, 255, (6, 5, 4)).astype(np.uint8)
    payload = plain_ktx2(pixels, packed=packed)
    np.testing.assert_array_equal(decode_ktx2(payload, max_side=8), pixels)
    with pytest.raises(ValueError, match="5 x 6 pixels, more than 4 a side"):
        decode_ktx2(payload, max_side=4)
    with pytest.raises(ValueError, match="KTX2"):
        decode_ktx2(payload[:-8], max_side=8)
    with pytest.raises(ValueError, match="VkFormat 999"):
        decode_ktx2(payload[:12] + b"\xe7\x03\0\0" + payload[16:], max_side=8)


@pytest.mark.parametrize("payload", [KTX2_ETC1S, KTX2_UASTC])
def test_broken_basis_textures_are_errors(payload: bytes) -> None:
    pytest.importorskip("opengl_basisu")
    for end in range(12, len(payload), 9):
        with pytest.raises(ValueError, match="KTX2"):
            decode_ktx2(payload[:end], max_side=64)


# Bounds


def test_textures_are_bounded_by_their_header(tmp_path: Path) -> None:
    bombs = {(9000, 10): "9000 x 10 pixels, more than 8192 a side", (30_000, 30_000): "900000000"}
    for (width, height), said in bombs.items():
        payload = square_glb(images=[png_header(width, height)], material=textured())
        bomb = read(tmp_path, payload)
        assert only(bomb).texture is None
        assert said in "".join(bomb.notes)
    broken = read(tmp_path, square_glb(images=[png_header(16, 16)], material=textured()))
    assert "not an image that can be read" in "".join(broken.notes)


def test_large_textures_are_scaled_down(tmp_path: Path) -> None:
    pixels = np.kron(halves(), np.ones((16, 8, 1), np.uint8))
    payload = square_glb(images=[png(pixels)], material=textured())
    texture = only(read(tmp_path, payload, texture_side=16)).texture
    assert texture is not None
    assert texture.shape == (16, 8, 3)
    np.testing.assert_array_equal(texture[:, 0], np.tile([255, 0, 0], (16, 1)))
    small = read(tmp_path, payload, max_texture_bytes=100)
    assert only(small).texture is None
    assert "over the 100 bytes a file may decode to" in "".join(small.notes)


def test_vertices_that_are_nowhere_take_their_triangles_with_them(tmp_path: Path) -> None:
    positions = SQUARE.copy()
    positions[3] = [np.nan, 0, 0]
    asset = read(tmp_path, square_glb(attributes={"POSITION": positions}))
    assert asset.num_triangles == 1
    assert asset.notes == {"triangles with vertices that are nan or beyond 100 km dropped": 1}
    with pytest.raises(ValueError, match=r"model.glb: has no triangle to draw; dropped: 2 tri"):
        read(tmp_path, square_glb(attributes={"POSITION": np.full_like(SQUARE, np.inf)}))


def test_triangles_without_area_are_dropped(tmp_path: Path) -> None:
    faces = np.array([0, 1, 2, 0, 0, 3], np.uint16)
    asset = read(tmp_path, square_glb(faces=faces))
    assert asset.notes == {"triangles without area dropped": 1}


def set_in(document: Document, *path: Any, value: Any) -> None:
    """Sets a member deep in a document."""
    for key in path[:-1]:
        document = document[key]
    document[path[-1]] = value


BROKEN: list[tuple[Callable[[Document], object], str]] = [
    (lambda d: set_in(d, "nodes", 0, "children", value=[0]), "reached twice"),
    (lambda d: set_in(d, "scenes", 0, "nodes", value=[0, 0]), "reached twice"),
    (lambda d: set_in(d, "scenes", 0, "nodes", value=[7]), r"no nodes\[7\]"),
    (lambda d: set_in(d, "scenes", 0, "nodes", value=[True]), r"no nodes\[True\]"),
    (lambda d: set_in(d, "nodes", value=[{}] * 100_001), "100001 nodes, more than"),
    (lambda d: set_in(d, "nodes", 0, "rotation", value=[0, 0, 0, 0]), "unit quaternion"),
    (lambda d: set_in(d, "nodes", 0, "scale", value=[1, "x", 1]), "scale must be numbers"),
    (lambda d: set_in(d, "nodes", 0, "matrix", value=[1]), "matrix must be 16 finite numbers"),
    (lambda d: set_in(d, "nodes", 0, "mesh", value=3), r"no meshes\[3\]"),
    (lambda d: set_in(d, "meshes", 0, "primitives", 0, "mode", value=9), "mode must be 0 to 6"),
    (lambda d: set_in(d, "meshes", 0, "primitives", value=[4]), "array of primitives"),
    (lambda d: set_in(d, "accessors", 0, "count", value=10**9), "1000000000 vertices, more than"),
    (lambda d: set_in(d, "accessors", 3, "count", value=3 * 10**8), "100000000 triangles"),
    (lambda d: set_in(d, "accessors", 0, "count", value=5), "5 elements need 60 bytes, got 48"),
    (lambda d: set_in(d, "accessors", 0, "count", value=-1), "count must be an integer >= 0"),
    (lambda d: set_in(d, "accessors", 0, "componentType", value=1), "componentType 1"),
    (lambda d: set_in(d, "accessors", 0, "type", value="VEC9"), "type 'VEC9'"),
    (lambda d: set_in(d, "accessors", 3, "componentType", value=5126), "need 24 bytes"),
    (lambda d: set_in(d, "bufferViews", 0, "byteLength", value=10**6), "needs bytes 0 to 1000000"),
    (lambda d: set_in(d, "materials", 0, "alphaMode", value="X"), "alphaMode must be"),
    (lambda d: set_in(d, "asset", "version", value="1.0"), "asset.version must be 2.x"),
    (lambda d: set_in(d, "scenes", value=4), "scenes must be an array"),
    (lambda d: set_in(d, "meshes", 0, "primitives", 0, "attributes", value=None), "broken mesh"),
    (lambda d: set_in(d, "extensionsRequired", value=["KHR_draco_mesh_compression"]), "KHR_draco"),
]


@pytest.mark.parametrize(("change", "match"), BROKEN)
def test_broken_glbs_are_one_error_that_names_the_file(
    tmp_path: Path, change: Callable[[Document], object], match: str
) -> None:
    with pytest.raises(ValueError, match=rf"^{tmp_path}/model.glb: .*{match}"):
        read(tmp_path, changed(change))


@pytest.mark.parametrize(
    ("payload", "match"),
    [
        (b"", "does not parse"),
        (b"glTF\x02\0\0\0", "at least 20 bytes"),
        (square_glb()[:-30], "GLB header says"),
        (b"[" * 10_000, "does not parse"),
        (b"[]", "must be an object"),
        (pack({}, b""), "asset.version"),
    ],
)
def test_what_is_no_gltf_is_told(tmp_path: Path, payload: bytes, match: str) -> None:
    with pytest.raises(ValueError, match=rf"^{tmp_path}/model.glb: .*{match}"):
        read(tmp_path, payload)


@pytest.mark.parametrize(
    "uri", ["../secret.bin", "/etc/passwd", "http://host/x.bin", "file:///etc/passwd", "c:\\x.bin"]
)
def test_buffers_outside_the_folder_are_refused(tmp_path: Path, uri: str) -> None:
    document, blob = document_of(square_glb())
    document["buffers"] = [{"byteLength": len(blob), "uri": uri}]
    write(tmp_path / "secret.bin", blob)
    path = write(tmp_path / "sub/model.gltf", json.dumps(document))
    with pytest.raises(ValueError, match=r"model.gltf: .* is outside the folder"):
        read_mesh(path)


def test_links_out_of_the_folder_and_oversized_files_are_refused(tmp_path: Path) -> None:
    document, blob = document_of(square_glb())
    document["buffers"] = [{"byteLength": len(blob), "uri": "data.bin"}]
    outside = write(tmp_path / "secret.bin", blob)
    path = write(tmp_path / "sub/model.gltf", json.dumps(document))
    (tmp_path / "sub/data.bin").symlink_to(outside)
    with pytest.raises(ValueError, match=r"data.bin is a link that leads out"):
        read_mesh(path)
    (tmp_path / "sub/data.bin").unlink()
    write(tmp_path / "sub/data.bin", blob + bytes(4000))
    with pytest.raises(ValueError, match=r"data.bin has \d+ bytes, more than the 3000 allowed"):
        read_mesh(path, limits=MeshLimits(max_file_bytes=3000))
    with pytest.raises(ValueError, match="more than the 100 allowed"):
        read_mesh(path, limits=MeshLimits(max_file_bytes=100))
    with pytest.raises(FileNotFoundError, match=r"none.glb: there is no such mesh file"):
        read_mesh(tmp_path / "none.glb")
    with pytest.raises(ValueError, match=r"x.stl: must end in .glb, .gltf, .obj"):
        read_mesh(write(tmp_path / "x.stl", b""))


@settings(max_examples=60)
@given(st.data())
def test_damaged_files_are_read_or_refused_by_name(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    payload = bytearray(square_glb(images=[png(halves())], material=textured()))
    for _ in range(data.draw(st.integers(1, 4))):
        payload[data.draw(st.integers(12, len(payload) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.mktemp("damaged") / "model.glb"
    path.write_bytes(payload[: data.draw(st.integers(len(payload) // 2, len(payload)))])
    problem = ""
    try:
        assert np.isfinite(read_mesh(path).bounds).all()
    except ValueError as error:
        problem = str(error)
    assert not problem or problem.startswith(f"{path}: ")


# OBJ


def read_obj(folder: Path, text: str | bytes, **limits: int) -> MeshAsset:
    """An OBJ read from disk."""
    return read_mesh(write(folder / "model.obj", text), limits=MeshLimits(**limits))


def test_obj_faces_of_any_number_of_corners_are_cut_to_triangles(tmp_path: Path) -> None:
    # A dart and an L: fans from their first corners would turn over.
    text = "v 0 0 0\nv 2 -1 0\nv 0.5 0 0\nv 2 1 0\n" + "f 1 2 3 4\n"
    dart = only(read_obj(tmp_path, text))
    np.testing.assert_allclose(face_normals(dart)[:, 2], [1.0, 1.0])
    corners = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    text = "".join(f"v {x} {y} 0\n" for x, y in corners) + "f 2 3 4 5 6 1\n"
    part = only(read_obj(tmp_path, text))
    assert len(part.faces) == 4
    a, b, c = (part.positions[part.faces[:, k], :2] for k in range(3))
    areas = np.cross(b - a, c - a) / 2.0 if a.shape[1] == 3 else 0.5 * (
        (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    )  # fmt: skip
    assert areas.min() >= 0.0
    assert areas.sum() == pytest.approx(3.0)


def test_obj_indices_count_from_one_or_back_from_their_line(tmp_path: Path) -> None:
    text = (
        "v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nf -3 -2 -1\r\n"
        "v 0 0 5\nv 1 0 5\nv 1 1 \\\n5\nf -3 -2 -1\nf 1//1 2//1 3//1\nvn 0 0 1\n"
    )
    asset = read_obj(tmp_path, text)
    assert asset.num_triangles == 3
    np.testing.assert_array_equal(asset.bounds, [[0, 0, 0], [1, 1, 5]])


def test_obj_materials_give_colour_texture_and_opacity(tmp_path: Path) -> None:
    write(
        tmp_path / "model.mtl",
        "newmtl red\nKd 1 0 0\n"
        "newmtl old glass\nKd 0 0 0\nTr 0.75\n"
        "newmtl pic\nKd 1 1 1\nmap_Kd -s 2 2 1 -o 0.5 0 0 my wood.png\n",
    )
    write(tmp_path / "my wood.png", png(halves()))
    square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    faces = "f 1/1 2/2 3/3 4/4\n"
    text = f"mtllib model.mtl\n{square}g a\nusemtl red\n{faces}usemtl old glass\n{faces}"
    asset = read_obj(tmp_path, text + f"g b\nusemtl pic\n{faces}usemtl lost\n{faces}")
    parts = {part.material: part for part in asset.parts}
    assert [part.name for part in asset.parts] == ["a:red", "a:old glass", "b:pic", "b:lost"]
    np.testing.assert_array_equal(parts["red"].colors[0], [255, 0, 0, 255])
    assert parts["old glass"].colors[0, 0] > 140
    assert asset.notes == {
        "material 'lost' missing, grey instead": 1,
        "see-through parts drawn opaque": 1,
    }
    pic = parts["pic"]
    np.testing.assert_array_equal(pic.texture, halves())
    assert pic.uvs is not None
    corner = np.flatnonzero((pic.positions == [0, 0, 0]).all(axis=1))[0]
    # MTL coordinates point up: scaled by 2 and moved by 0.5 along u; ours point down.
    np.testing.assert_allclose(pic.uvs[corner], [0.5, 1.0])
    other = np.flatnonzero((pic.positions == [1, 1, 0]).all(axis=1))[0]
    np.testing.assert_allclose(pic.uvs[other], [2.5, -1.0])


def test_obj_libraries_and_pictures_that_are_missing_are_told(tmp_path: Path) -> None:
    text = "mtllib none.mtl\n" + boxes_obj({"box": ((0, 0, 0), (1, 1, 1))})
    assert read_obj(tmp_path, text).notes == {
        "material library missing, grey instead: none.mtl is not there": 1,
        "material 'box' missing, grey instead": 1,
    }
    write(tmp_path / "here.mtl", "newmtl box\nmap_Kd C:\\Users\\me\\oak.jpg\n")
    boxes = {"box": ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))}
    text = boxes_obj(boxes, library="here.mtl", textured=True)
    assert "C:\\Users\\me\\oak.jpg missing" in "".join(read_obj(tmp_path, text).notes)
    buffer = io.BytesIO()
    Image.fromarray(halves()).save(buffer, format="BMP")
    write(tmp_path / "oak.jpg", buffer.getvalue())
    # A path on its author's machine: the file of that name beside it is meant.
    assert only(read_obj(tmp_path, text)).texture is not None


def test_obj_vertex_colours_are_read(tmp_path: Path) -> None:
    part = only(read_obj(tmp_path, "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nf 1 2 3\n"))
    assert part.colors[0, 0] == 204
    np.testing.assert_array_equal(part.colors[0, 1:], [0, 0, 255])


TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("", "must have vertices"),
        ("f 1 2 3\n", "must have vertices"),
        (TRIANGLE, "must have faces"),
        (TRIANGLE + "f 1 2 4\n", "names v 4, the file has 3"),
        (TRIANGLE + "f 0 1 2\n", "names v 0"),
        (TRIANGLE + "f -4 1 2\n", "names v -4"),
        (TRIANGLE + "f 1/9 2/1 3/1\n", "names vt 9, the file has 0"),
        (TRIANGLE + "f 1 2 x\n", "f lines: "),
        (TRIANGLE + "f 1 2 2.5\n", "whole numbers"),
        (TRIANGLE + "f 1/1/1/1 2 3\n", "v, v/vt, v//vn or v/vt/vn"),
        (TRIANGLE + "f 1/ 2/ 3/\n", "whole numbers v, v/vt"),
        (TRIANGLE + "f 1 2\n", "no triangle to draw; dropped: 1 faces of fewer than three"),
        ("v 0 0\n" + TRIANGLE + "f 1 2 3\n", "v line must have 3 numbers or more, got 2"),
        ("v 0 0 zero\n" + TRIANGLE + "f 1 2 3\n", "v lines: "),
        ("v 0 0 " + "1" * 50 + "\n" + TRIANGLE + "f 1 2 3\n", "more than 40 characters"),
        (
            "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
            "no triangle to draw; dropped: .*1 triangles with",
        ),
        ("\0\1\2", "text, got binary"),
    ],
)
def test_broken_objs_are_one_error_that_names_the_file(
    tmp_path: Path, text: str, match: str
) -> None:
    with pytest.raises(ValueError, match=rf"^{tmp_path}/model.obj: .*{match}"):
        read_obj(tmp_path, text)


def test_obj_counts_are_bounded(tmp_path: Path) -> None:
    box = boxes_obj({"box": ((0, 0, 0), (1, 1, 1))})
    with pytest.raises(ValueError, match="6 faces make more than 11 triangles"):
        read_obj(tmp_path, box, max_triangles=11)
    with pytest.raises(ValueError, match="8 v lines, more than the 7 allowed"):
        read_obj(tmp_path, box, max_vertices=7)
    with pytest.raises(ValueError, match="groups, more than the 3 allowed"):
        read_obj(tmp_path, TRIANGLE + "g a\ng b\ng c\ng d\nf 1 2 3\n", max_nodes=3)


# Against another reader


@pytest.mark.realdata
def test_real_files_agree_with_trimesh(realdata: Path) -> None:
    import trimesh

    objects = realdata / "replica_cad/objects"
    names = ("chair_01", "sofa", "table_02", "lamp_01", "rug_01", "bin_01", "tv_screen", "bowl_06")
    paths = [objects / f"frl_apartment_{name}.glb" for name in names]
    assets = realdata / "habitat_sim_test_assets/data/test_assets"
    paths += [assets / "objects/transform_box.glb", assets / "scenes/simple_room.glb"]
    paths += [realdata / "morse_bsd/tum_kitchen.glb"]
    for path in paths:
        asset = read_mesh(path)
        other = trimesh.load_scene(path)
        np.testing.assert_allclose(asset.bounds, other.bounds, atol=1e-4)
        # The area of a scene leaves out the scale of its nodes.
        area = other.to_mesh().area
        merged = trimesh.Trimesh(*asset.mesh(), process=False)
        assert merged.area == pytest.approx(area, rel=1e-4), path.name
        flat = sum(count for note, count in asset.notes.items() if "without area" in note)
        triangles = sum(
            len(other.geometry[other.graph[node][1]].faces) for node in other.graph.nodes_geometry
        )
        assert asset.num_triangles + flat == triangles
        unit = np.linalg.norm(np.concatenate([part.normals for part in asset.parts]), axis=1)
        np.testing.assert_allclose(unit, 1.0, atol=1e-5)
    sofa = read_mesh(objects / "frl_apartment_sofa.glb")
    assert len(sofa.textures) == 1
    assert not sofa.notes
