"""The world S: static geometry with its light baked in, and what a person can do in it."""

from __future__ import annotations

import dataclasses
import hashlib
import io
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from affectsim_data.glb import GlbBuilder, GlbFile
from affectsim_data.poses import FloatArray

__all__ = ["Door", "Room", "Scene", "Seat", "Surface"]

MAX_TEXTURE_SIZE = 8192


@dataclasses.dataclass(frozen=True)
class Surface:
    """All triangles of one material, ready to draw."""

    name: str
    """Material, for example `oak`; unique in its scene."""
    positions: NDArray[np.float32]
    """Vertices in the world, metres, `(num_vertices, 3)`."""
    normals: NDArray[np.float32]
    """Unit vertex normals, `(num_vertices, 3)`."""
    colors: NDArray[np.uint8]
    """sRGB vertex colours with the baked light multiplied in, `(num_vertices, 4)`."""
    faces: NDArray[np.uint32]
    """Triangles, counter-clockwise from outside, `(num_faces, 3)`."""
    uvs: NDArray[np.float32] | None = None
    """Texture coordinates, v down from the top left as in glTF, `(num_vertices, 2)`."""
    texture: NDArray[np.uint8] | None = None
    """sRGB texture multiplied by the colours, repeated, `(height, width, 3)`."""

    def __post_init__(self) -> None:
        count = len(self.positions)
        shapes = {"positions": 3, "normals": 3, "colors": 4}
        for field, width in shapes.items():
            if getattr(self, field).shape != (count, width):
                raise ValueError(
                    f"surface {self.name!r}: {field} must be ({count}, {width}), "
                    f"got {getattr(self, field).shape}"
                )
        if not np.isfinite(self.positions).all():
            raise ValueError(f"surface {self.name!r}: positions must be finite")
        if self.faces.ndim != 2 or self.faces.shape[1] != 3:
            raise ValueError(f"surface {self.name!r}: faces must be (n, 3), got {self.faces.shape}")
        if self.faces.size and not 0 <= int(self.faces.min()) <= int(self.faces.max()) < count:
            raise ValueError(f"surface {self.name!r}: a face names a vertex that is not there")
        if self.texture is not None and (self.uvs is None or self.uvs.shape != (count, 2)):
            raise ValueError(f"surface {self.name!r}: a texture needs uvs ({count}, 2)")


@dataclasses.dataclass(frozen=True)
class Room:
    """A room as a polygon on the floor plan."""

    room_id: str
    """Unique in its scene."""
    purpose: str
    """`living`, `kitchen`, `bedroom`, ..."""
    polygon: tuple[tuple[float, float], ...]
    """Corners `(x, z)`, metres, in order."""
    floor_y: float = 0.0
    """Height of its floor."""
    ceiling_y: float = 2.6
    """Height of its ceiling."""

    def __post_init__(self) -> None:
        if len(self.polygon) < 3 or any(len(corner) != 2 for corner in self.polygon):
            raise ValueError(
                f"room {self.room_id!r}: polygon must be three or more corners (x, z), "
                f"got {self.polygon}"
            )


@dataclasses.dataclass(frozen=True)
class Seat:
    """A place to sit."""

    position: tuple[float, float, float]
    """Middle of the seat surface's front half, where a sitter's pelvis rests, metres."""
    yaw_deg: float
    """Which way a sitter looks: 0 is +Z, counter-clockwise from above."""
    depth: float
    """Free depth of the seat surface, metres."""


@dataclasses.dataclass(frozen=True)
class Door:
    """A door leaf one can knock on."""

    knock_point: tuple[float, float, float]
    """On the leaf, about 1.4 m high, metres."""
    yaw_deg: float
    """Which way the leaf faces, towards its free side: 0 is +Z, counter-clockwise from above."""
    width: float
    """Of the leaf, metres."""


@dataclasses.dataclass(frozen=True, eq=False)
class Scene:
    """A static place: what is drawn, what blocks rays and robots, and its semantics."""

    scene_id: str
    """Unique in a release."""
    surfaces: tuple[Surface, ...]
    """What is drawn, one draw call each."""
    rooms: tuple[Room, ...]
    """At least one."""
    seats: tuple[Seat, ...] = ()
    """Where one can sit."""
    doors: tuple[Door, ...] = ()
    """Where one can knock."""
    source: str = ""
    """Where the scene comes from."""
    licence: str = ""
    """Its licence, SPDX."""

    def __post_init__(self) -> None:
        if not self.surfaces or not any(len(surface.faces) for surface in self.surfaces):
            raise ValueError(f"scene {self.scene_id!r}: has no triangles")
        if not self.rooms:
            raise ValueError(f"scene {self.scene_id!r}: has no room, so nobody can stand in it")
        names = [surface.name for surface in self.surfaces]
        if len(set(names)) != len(names):
            raise ValueError(f"scene {self.scene_id!r}: surface names repeat: {names}")

    @property
    def num_triangles(self) -> int:
        """Triangles of all surfaces."""
        return sum(len(surface.faces) for surface in self.surfaces)

    def mesh(self) -> tuple[FloatArray, NDArray[np.int64]]:
        """All vertices `(n, 3)` and triangles `(m, 3)` as one mesh: for rays and the navmesh."""
        positions, faces, start = [], [], 0
        for surface in self.surfaces:
            positions.append(surface.positions.astype(np.float64))
            faces.append(surface.faces.astype(np.int64) + start)
            start += len(surface.positions)
        return np.concatenate(positions), np.concatenate(faces)

    def mesh_sha256(self) -> str:
        """Hash of the merged geometry; a navmesh stores it to say what it was built from."""
        vertices, faces = self.mesh()
        digest = hashlib.sha256(vertices.astype("<f4").tobytes())
        digest.update(faces.astype("<u4").tobytes())
        return digest.hexdigest()

    def to_glb(self) -> bytes:
        """A glTF any viewer opens; rooms, seats and doors are its `extras`."""
        builder = GlbBuilder()
        materials: list[dict[str, Any]] = []
        textures: list[dict[str, Any]] = []
        primitives: list[dict[str, Any]] = []
        for surface in self.surfaces:
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
        document: dict[str, Any] = {
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"name": self.scene_id, "mesh": 0}],
            "meshes": [{"primitives": primitives}],
            "materials": materials,
            "extras": self.semantics(),
        }
        if textures:
            document["textures"] = textures
        return builder.to_bytes(document)

    def semantics(self) -> dict[str, Any]:
        """Everything but the geometry, as JSON."""
        return {
            "scene_id": self.scene_id,
            "rooms": [dataclasses.asdict(room) for room in self.rooms],
            "seats": [dataclasses.asdict(seat) for seat in self.seats],
            "doors": [dataclasses.asdict(door) for door in self.doors],
            "source": self.source,
            "licence": self.licence,
        }

    @classmethod
    def from_glb(cls, payload: bytes, *, name: str) -> Scene:
        """Reads what `to_glb` wrote.

        Raises:
            ValueError: Not such a GLB; the message starts with `name`.
        """
        glb = GlbFile.from_bytes(payload, name=name)
        try:
            extras = glb.document["extras"]
            primitives = glb.document["meshes"][0]["primitives"]
            return cls(
                scene_id=extras["scene_id"],
                surfaces=tuple(_read_surface(glb, primitive) for primitive in primitives),
                rooms=tuple(
                    Room(**{**room, "polygon": tuple(map(tuple, room["polygon"]))})
                    for room in extras["rooms"]
                ),
                seats=tuple(
                    Seat(**{**seat, "position": tuple(seat["position"])})
                    for seat in extras["seats"]
                ),
                doors=tuple(
                    Door(**{**door, "knock_point": tuple(door["knock_point"])})
                    for door in extras["doors"]
                ),
                source=extras["source"],
                licence=extras["licence"],
            )
        except (KeyError, IndexError, TypeError, AttributeError) as error:
            raise ValueError(f"{name}: not a scene GLB: {error!r}") from error
        except ValueError as error:
            if str(error).startswith(name):
                raise
            raise ValueError(f"{name}: {error}") from error


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
