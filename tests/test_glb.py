"""GLB files: what goes in comes out, and nothing broken gets through."""

from __future__ import annotations

import json
import struct
import tracemalloc
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_release import box_room, limb_avatar

from affectsim_data.avatars import Avatar
from affectsim_data.glb import GlbBuilder, GlbFile
from affectsim_data.scenes import Scene

ROOM = box_room("room").to_glb()
Document = dict[str, Any]


def pack(document: Any, blob: bytes) -> bytes:
    """A GLB of any JSON, well formed or not."""
    text = document if isinstance(document, bytes) else json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text
    body += struct.pack("<II", len(blob), 0x004E4942) + blob
    return struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body


def changed(change: Callable[[Document], object]) -> bytes:
    """The room with its JSON changed."""
    glb = GlbFile.from_bytes(ROOM, name="room")
    change(glb.document)
    return pack(glb.document, glb.blob)


ARRAYS: list[np.ndarray] = [
    np.arange(5, dtype=np.uint32),
    np.arange(8, dtype=np.float32).reshape(4, 2),
    np.arange(9, dtype=np.float32).reshape(3, 3),
    np.arange(12, dtype=np.uint8).reshape(3, 4),
    np.arange(6, dtype=np.int16),
    np.arange(48, dtype=np.float32).reshape(3, 4, 4),
    np.zeros((0, 3), np.float32),
]


def test_arrays_and_images_round_trip() -> None:
    builder = GlbBuilder()
    indices = [builder.accessor(array) for array in ARRAYS]
    image = builder.png(b"not looked at")
    glb = GlbFile.from_bytes(builder.to_bytes({"extras": {"x": 1}}), name="file")
    assert glb.document["extras"] == {"x": 1}
    for index, array in zip(indices, ARRAYS, strict=True):
        back = glb.array(index)
        assert back.dtype == array.dtype
        np.testing.assert_array_equal(back, array)
    assert glb.image(image) == b"not looked at"


def test_matrices_are_stored_by_columns() -> None:
    builder = GlbBuilder()
    matrix = np.arange(16, dtype=np.float32).reshape(1, 4, 4)
    builder.accessor(matrix)
    glb = GlbFile.from_bytes(builder.to_bytes({}), name="file")
    np.testing.assert_array_equal(np.frombuffer(glb.blob, "<f4"), matrix[0].T.reshape(-1))


def test_views_are_aligned_and_positions_have_bounds() -> None:
    builder = GlbBuilder()
    builder.accessor(np.arange(3, dtype=np.uint8))
    builder.accessor(np.array([[1, -2, 3], [0, 5, 3]], np.float32))
    document = GlbFile.from_bytes(builder.to_bytes({}), name="file").document
    assert [view["byteOffset"] for view in document["bufferViews"]] == [0, 4]
    assert document["accessors"][1]["min"] == [0.0, -2.0, 3.0]
    assert document["accessors"][1]["max"] == [1.0, 5.0, 3.0]


def test_an_accessor_may_start_inside_its_view() -> None:
    payload = np.arange(6, dtype="<f4").tobytes()
    document = {
        "accessors": [
            {"bufferView": 0, "byteOffset": 8, "componentType": 5126, "count": 2, "type": "VEC2"}
        ],
        "bufferViews": [{"buffer": 0, "byteLength": len(payload)}],
    }
    glb = GlbFile.from_bytes(pack(document, payload), name="file")
    np.testing.assert_array_equal(glb.array(0), [[2.0, 3.0], [4.0, 5.0]])


@pytest.mark.parametrize("dtype", [np.float64, np.int64, np.bool_])
def test_gltf_lacks_some_types(dtype: type) -> None:
    with pytest.raises(ValueError, match="glTF has no component type for"):
        GlbBuilder().accessor(np.zeros(3, dtype))


def test_gltf_lacks_wide_vectors() -> None:
    with pytest.raises(ValueError, match=r"glTF has no accessor type for arrays \(3, 5\)"):
        GlbBuilder().accessor(np.zeros((3, 5), np.float32))


def test_every_truncation_is_refused_by_name() -> None:
    step = max(1, len(ROOM) // 300)
    for length in (*range(64), *range(64, len(ROOM), step), len(ROOM) - 1):
        with pytest.raises(ValueError, match=r"^shard\.parquet: "):
            GlbFile.from_bytes(ROOM[:length], name="shard.parquet")
        # And where the header tells the truth about the truncated length.
        honest = ROOM[:8] + struct.pack("<I", length) + ROOM[12:length]
        with pytest.raises(ValueError, match=r"^shard\.parquet: "):
            Scene.from_glb(honest, name="shard.parquet")


@pytest.mark.parametrize(
    ("payload", "message"),
    [
        (b"", "a GLB has at least 20 bytes, got 0"),
        (b"glTX" + ROOM[4:], "not a GLB 2.0 file"),
        (ROOM[:4] + struct.pack("<I", 1) + ROOM[8:], "not a GLB 2.0 file"),
        (ROOM + b"\0\0\0\0", "GLB header says"),
        (ROOM[:12] + struct.pack("<I", 0xFFFFFFF0) + ROOM[16:], "broken GLB JSON chunk"),
        (ROOM[:16] + b"BIN\0" + ROOM[20:], "broken GLB JSON chunk"),
        (pack(b"{never closed", b""), "GLB JSON does not parse"),
        (pack(b"\xff\xfe\xfd\xfc", b""), "GLB JSON does not parse"),
        (pack(b'{"x": NaN}', b""), "GLB JSON does not parse: NaN is no JSON number"),
        (pack(b"[" * 200_000, b""), "GLB JSON does not parse"),
        (pack([1, 2], b""), "GLB JSON must be an object, got list"),
    ],
)
def test_broken_containers_are_refused_by_name(payload: bytes, message: str) -> None:
    with pytest.raises(ValueError, match=f"^file: {message}"):
        GlbFile.from_bytes(payload, name="file")


def _accessor(**fields: Any) -> Callable[[Document], object]:
    return lambda document: document["accessors"][0].update(fields)


def _view(**fields: Any) -> Callable[[Document], object]:
    return lambda document: document["bufferViews"][0].update(fields)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (_accessor(count=21), "accessor 0 leaves its buffer view"),
        (_accessor(count=1 << 60), "accessor 0 leaves its buffer view"),
        (_accessor(count=-1), "count must be an integer >= 0, got -1"),
        (_accessor(count=1e308), "count must be an integer >= 0"),
        (_accessor(count=None), "count must be an integer >= 0, got None"),
        (_accessor(byteOffset=-4), "byteOffset must be an integer >= 0, got -4"),
        (_accessor(byteOffset=4), "accessor 0 leaves its buffer view"),
        (_accessor(componentType=5130), "accessor 0 has componentType 5130"),
        (_accessor(componentType=[]), r"accessor 0 has componentType \[\]"),
        (_accessor(type="MAT3"), "accessor 0 is of type 'MAT3'"),
        (_accessor(sparse={}), "or sparse"),
        (_accessor(bufferView=99), r"has no bufferViews\[99\]"),
        (_accessor(bufferView=-1), r"has no bufferViews\[-1\]"),
        (_accessor(bufferView="0"), r"has no bufferViews\['0'\]"),
        (_view(byteOffset=-8), "byteOffset must be an integer >= 0, got -8"),
        (_view(byteOffset=1 << 62), "buffer view 0 leaves the buffer"),
        (_view(byteLength=1 << 62), "buffer view 0 leaves the buffer"),
        (_view(byteLength=-1), "byteLength must be an integer >= 0, got -1"),
        (_view(byteStride=16), "buffer view 0 is interleaved"),
        (lambda document: document.update(accessors={}), r"has no accessors\[0\]"),
        (lambda document: document.pop("bufferViews"), r"has no bufferViews\[0\]"),
    ],
)
def test_lying_accessors_are_refused_by_name(
    change: Callable[[Document], object], message: str
) -> None:
    glb = GlbFile.from_bytes(changed(change), name="file")
    with pytest.raises(ValueError, match=f"^file: the GLB {message}|^file: GLB .*{message}"):
        glb.array(0)


def test_negative_accessor_indices_do_not_count_from_the_end() -> None:
    with pytest.raises(ValueError, match=r"the GLB has no accessors\[-1\]"):
        GlbFile.from_bytes(ROOM, name="file").array(-1)


def test_lies_about_sizes_allocate_nothing() -> None:
    glb = GlbFile.from_bytes(changed(_accessor(count=1 << 40)), name="file")
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match="leaves its buffer view"):
            glb.array(0)
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()


@settings(max_examples=150)
@given(st.data())
def test_flipped_bytes_raise_a_named_value_error_or_still_make_a_scene(data: st.DataObject) -> None:
    broken = bytearray(ROOM)
    for _ in range(data.draw(st.integers(1, 4))):
        broken[data.draw(st.integers(0, len(broken) - 1))] = data.draw(st.integers(0, 255))
    try:
        scene = Scene.from_glb(bytes(broken), name="file")
    except ValueError as error:
        assert str(error).startswith("file: ")  # noqa: PT017  # either outcome is right
    else:
        assert scene.num_triangles > 0


def test_avatars_round_trip_byte_for_byte() -> None:
    payload = limb_avatar("plain").to_glb()
    assert Avatar.from_glb(payload, name="file").to_glb() == payload
