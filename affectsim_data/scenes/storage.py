"""Scenes as binary glTF: geometry any viewer opens, and everything else in its `extras`."""

from __future__ import annotations

import dataclasses
import io
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from affectsim_data.glb import GlbBuilder, GlbFile
from affectsim_data.scenes.chunks import Chunks
from affectsim_data.scenes.scene import Scene
from affectsim_data.scenes.semantics import Door, Doorway, Room, SceneObject, Seat
from affectsim_data.scenes.surfaces import Surface

__all__ = ["scene_from_glb", "scene_to_glb"]

MAX_TEXTURE_SIZE = 8192


def scene_to_glb(scene: Scene) -> bytes:
    """One mesh with one primitive per surface; equal scenes give equal bytes."""
    builder = GlbBuilder()
    materials: list[dict[str, Any]] = []
    textures: list[dict[str, Any]] = []
    primitives: list[dict[str, Any]] = []
    for surface in scene.surfaces:
        attributes = {
            "POSITION": builder.accessor(surface.positions),
            "NORMAL": builder.accessor(surface.normals),
            "COLOR_0": builder.accessor(surface.colors, normalized=True),
        }
        pbr: dict[str, Any] = {"metallicFactor": 0, "roughnessFactor": 1}
        if surface.texture is not None and surface.uvs is not None:
            attributes["TEXCOORD_0"] = builder.accessor(surface.uvs)
            textures.append({"source": builder.png(_encode_png(surface.texture))})
            pbr["baseColorTexture"] = {"index": len(textures) - 1}
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
        extras["chunks"] = _chunks_to_json(scene.chunks)
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
        return Scene(
            scene_id=extras["scene_id"],
            surfaces=tuple(_read_surface(glb, primitive) for primitive in primitives),
            rooms=tuple(Room(**_with_tuples(one)) for one in extras["rooms"]),
            seats=tuple(Seat(**_with_tuples(one)) for one in extras["seats"]),
            doors=tuple(Door(**_with_tuples(one)) for one in extras["doors"]),
            doorways=tuple(Doorway(**_with_tuples(one)) for one in extras["doorways"]),
            objects=tuple(SceneObject(**_with_tuples(one)) for one in extras["objects"]),
            source=extras["source"],
            licence=extras["licence"],
            chunks=None if chunks is None else _chunks_from_json(chunks),
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


def _chunks_to_json(chunks: Chunks) -> dict[str, Any]:
    """Lists; a bound that is not finite is null."""
    table: dict[str, Any] = {}
    for field in dataclasses.fields(chunks):
        values = getattr(chunks, field.name)
        if values.dtype.kind == "f":
            values = np.where(np.isfinite(values), values.astype(object), None)
        table[field.name] = values.tolist()
    return table


def _chunks_from_json(table: dict[str, Any]) -> Chunks:
    columns: dict[str, Any] = {}
    for field in dataclasses.fields(Chunks):
        if field.name in ("surface", "first", "count", "room"):
            columns[field.name] = np.array(table[field.name], np.int32)
            continue
        endless = -np.inf if field.name.endswith("low") else np.inf
        rows = [[endless if x is None else x for x in row] for row in table[field.name]]
        columns[field.name] = np.array(rows, np.float64).reshape(-1, 3)
    return Chunks(**columns)


def _encode_png(pixels: NDArray[np.uint8]) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="PNG", optimize=False)
    return buffer.getvalue()


def _decode_texture(payload: bytes, *, name: str) -> NDArray[np.uint8]:
    try:
        with Image.open(io.BytesIO(payload), formats=["PNG"]) as image:
            if max(image.size) > MAX_TEXTURE_SIZE:
                raise ValueError(f"texture is {image.size}, more than {MAX_TEXTURE_SIZE}")
            return np.asarray(image.convert("RGB"))
    except (ValueError, OSError, SyntaxError, Image.DecompressionBombError) as error:
        # Pillow reports a broken PNG as any of these.
        raise ValueError(f"{name}: a texture cannot be read: {error}") from error


def _read_surface(glb: GlbFile, primitive: dict[str, Any]) -> Surface:
    attributes = primitive["attributes"]
    material = glb.document["materials"][primitive["material"]]
    texture_entry = material["pbrMetallicRoughness"].get("baseColorTexture")
    texture = None
    if texture_entry is not None:
        image = glb.document["textures"][texture_entry["index"]]["source"]
        texture = _decode_texture(glb.image(image), name=glb.name)
    return Surface(
        name=material["name"],
        positions=glb.array(attributes["POSITION"]),
        normals=glb.array(attributes["NORMAL"]),
        colors=glb.array(attributes["COLOR_0"]),
        faces=glb.array(primitive["indices"]).reshape(-1, 3),
        uvs=glb.array(attributes["TEXCOORD_0"]) if texture is not None else None,
        texture=texture,
    )
