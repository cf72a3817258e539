"""Scenes as binary glTF: geometry any viewer opens, and everything else in its `extras`."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from affectsim_data.glb import GlbBuilder, GlbFile
from affectsim_data.scenes.chunk_tables import chunks_from_glb, chunks_to_glb
from affectsim_data.scenes.scene import Scene
from affectsim_data.scenes.semantics import Door, Doorway, Room, SceneObject, Seat
from affectsim_data.scenes.surfaces import Surface

__all__ = ["scene_from_glb", "scene_to_glb"]

MAX_TEXTURE_SIZE = 8192
MAX_TEXELS = 2**26
"""Of all textures of a scene: 200 MB when decoded."""
_FLOAT, _INDEX, _LEVEL = "<f4", "<u4", "|u1"


def scene_to_glb(scene: Scene) -> bytes:
    """One mesh with one primitive per surface; equal scenes give equal bytes.

    A texture that several surfaces share is stored once.
    """
    builder = GlbBuilder()
    materials: list[dict[str, Any]] = []
    textures: list[dict[str, Any]] = []
    primitives: list[dict[str, Any]] = []
    pictures: dict[bytes, int] = {}
    for surface in scene.surfaces:
        attributes = {
            "POSITION": builder.accessor(surface.positions),
            "NORMAL": builder.accessor(surface.normals),
            "COLOR_0": builder.accessor(surface.colors, normalized=True),
        }
        pbr: dict[str, Any] = {"metallicFactor": 0, "roughnessFactor": 1}
        if surface.texture is not None and surface.uvs is not None:
            attributes["TEXCOORD_0"] = builder.accessor(surface.uvs)
            picture = _encode_png(surface.texture)
            if picture not in pictures:
                pictures[picture] = len(textures)
                textures.append({"source": builder.png(picture)})
            pbr["baseColorTexture"] = {"index": pictures[picture]}
        primitives.append(
            {
                "attributes": attributes,
                "indices": builder.accessor(surface.faces.reshape(-1)),
                "material": len(materials),
            }
        )
        materials.append({"name": surface.name, "pbrMetallicRoughness": pbr})
    extras = scene.semantics()
    if scene.chunks is not None:
        extras["chunks"] = chunks_to_glb(builder, scene.chunks)
    document: dict[str, Any] = {
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": scene.scene_id, "mesh": 0}],
        "meshes": [{"primitives": primitives}],
        "materials": materials,
        "extras": extras,
    }
    if textures:
        document["textures"] = textures
    return builder.to_bytes(document)


def scene_from_glb(payload: bytes, *, name: str) -> Scene:
    """Reads what `scene_to_glb` wrote.

    Raises:
        ValueError: Not such a GLB; the message starts with `name`.
    """
    glb = GlbFile.from_bytes(payload, name=name)
    try:
        extras = glb.document["extras"]
        primitives = glb.document["meshes"][0]["primitives"]
        chunks = extras.get("chunks")
        pictures = _Pictures(glb)
        return Scene(
            scene_id=extras["scene_id"],
            surfaces=tuple(_read_surface(glb, primitive, pictures) for primitive in primitives),
            rooms=tuple(Room(**_with_tuples(one)) for one in extras["rooms"]),
            seats=tuple(Seat(**_with_tuples(one)) for one in extras["seats"]),
            doors=tuple(Door(**_with_tuples(one)) for one in extras["doors"]),
            doorways=tuple(Doorway(**_with_tuples(one)) for one in extras["doorways"]),
            objects=tuple(SceneObject(**_with_tuples(one)) for one in extras["objects"]),
            source=extras["source"],
            licence=extras["licence"],
            chunks=None if chunks is None else chunks_from_glb(glb, chunks),
        )
    except (KeyError, IndexError, TypeError, AttributeError) as error:
        raise ValueError(f"{name}: not a scene GLB: {error!r}") from error
    except ValueError as error:
        if str(error).startswith(name):
            raise
        raise ValueError(f"{name}: {error}") from error


def _with_tuples(table: dict[str, Any]) -> dict[str, Any]:
    """JSON lists as the tuples that were written."""
    return {key: _as_tuple(value) for key, value in table.items()}


def _as_tuple(value: Any) -> Any:
    return tuple(_as_tuple(item) for item in value) if isinstance(value, list) else value


def _encode_png(pixels: NDArray[np.uint8]) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="PNG", optimize=False)
    return buffer.getvalue()


class _Pictures:
    """The textures of a file, each decoded once, up to a number of texels."""

    def __init__(self, glb: GlbFile) -> None:
        self._glb = glb
        self._decoded: dict[int, NDArray[np.uint8]] = {}
        self._num_texels = 0

    def __getitem__(self, image: int) -> NDArray[np.uint8]:
        if image not in self._decoded:
            self._decoded[image] = self._decode(self._glb.image(image))
        return self._decoded[image]

    def _decode(self, payload: bytes | memoryview) -> NDArray[np.uint8]:
        try:
            with Image.open(io.BytesIO(payload), formats=["PNG"]) as image:
                width, height = image.size
                if max(width, height) > MAX_TEXTURE_SIZE:
                    raise ValueError(f"texture is {image.size}, more than {MAX_TEXTURE_SIZE}")
                self._num_texels += width * height
                if self._num_texels > MAX_TEXELS:
                    raise ValueError(f"textures have more than {MAX_TEXELS:,} texels in all")
                return np.asarray(image if image.mode == "RGB" else image.convert("RGB"))
        except (ValueError, OSError, SyntaxError, Image.DecompressionBombError) as error:
            # Pillow reports a broken PNG as any of these.
            raise ValueError(f"{self._glb.name}: a texture cannot be read: {error}") from error


def _read_surface(glb: GlbFile, primitive: dict[str, Any], pictures: _Pictures) -> Surface:
    attributes = primitive["attributes"]
    material = glb.document["materials"][primitive["material"]]
    name = material["name"]
    texture_entry = material["pbrMetallicRoughness"].get("baseColorTexture")
    texture = None
    if texture_entry is not None:
        texture = pictures[glb.document["textures"][texture_entry["index"]]["source"]]
    return Surface(
        name=name,
        positions=_array(glb, attributes["POSITION"], _FLOAT, f"surface {name!r}: positions"),
        normals=_array(glb, attributes["NORMAL"], _FLOAT, f"surface {name!r}: normals"),
        colors=_array(glb, attributes["COLOR_0"], _LEVEL, f"surface {name!r}: colors"),
        faces=_triples(glb, primitive["indices"], f"surface {name!r}: indices"),
        uvs=_array(glb, attributes["TEXCOORD_0"], _FLOAT, f"surface {name!r}: uvs")
        if texture is not None
        else None,
        texture=texture,
    )


def _triples(glb: GlbFile, accessor: int, what: str) -> NDArray[np.uint32]:
    indices = _array(glb, accessor, _INDEX, what)
    if indices.ndim != 1 or len(indices) % 3:
        raise ValueError(f"{glb.name}: {what} must be three per triangle, got {indices.shape}")
    return indices.reshape(-1, 3)


def _array(glb: GlbFile, accessor: int, dtype: str, what: str) -> NDArray[Any]:
    values = glb.array(accessor)
    if values.dtype.str != dtype:
        raise ValueError(f"{glb.name}: {what} must be {np.dtype(dtype)}, got {values.dtype}")
    return values
