"""glTF materials as `Look`s: what the fast shader can draw of them, and notes about the rest."""

from __future__ import annotations

import functools
import math
from typing import Any, cast

import numpy as np

from affectsim_data.builders.meshes.asset import Notes
from affectsim_data.builders.meshes.gltf_document import GltfDocument
from affectsim_data.builders.meshes.images import Pixels, Textures
from affectsim_data.builders.meshes.looks import AlphaMode, Look, Wrap, linear_to_srgb

__all__ = ["GltfMaterials"]

_SPECULAR = "KHR_materials_pbrSpecularGlossiness"
_TRANSMISSION = "KHR_materials_transmission"
_REPEAT, _CLAMP, _MIRROR = 10497, 33071, 33648


class GltfMaterials:
    """The materials of one glTF, each read once."""

    def __init__(self, document: GltfDocument, textures: Textures, *, notes: Notes) -> None:
        self._document, self._textures, self._notes = document, textures, notes
        self._looks: dict[int, Look] = {}

    def look(self, index: Any) -> Look:
        """The material at `index`; white where a primitive has none."""
        if index is None:
            return Look()
        entry = self._document.entry("materials", index)
        if index not in self._looks:
            self._looks[index] = self._read(entry, f"materials[{index}]")
        return self._looks[index]

    def _read(self, entry: dict[str, Any], where: str) -> Look:
        factor, info = self._base(entry, where)
        mode = entry.get("alphaMode", "OPAQUE")
        if mode not in ("OPAQUE", "MASK", "BLEND"):
            raise ValueError(f"{where}: alphaMode must be OPAQUE, MASK or BLEND, got {mode!r}")
        glass = _extension(entry, _TRANSMISSION).get("transmissionFactor", 0.0)
        if isinstance(glass, int | float) and glass > 0.0:
            mode, factor[3] = "BLEND", factor[3] * (1.0 - min(float(glass), 1.0))
        if info is None and not factor[:3].any():
            # A screen or a lamp: black itself, it shows what it gives off.
            factor[:3] = _factor(entry, "emissiveFactor", where, [0.0, 0.0, 0.0])
            info = entry.get("emissiveTexture")
        elif "emissiveTexture" in entry or any(entry.get("emissiveFactor", ())):
            self._notes["emission ignored"] += 1
        cutoff = entry.get("alphaCutoff", 0.5)
        color = (*(float(x) for x in linear_to_srgb(factor[:3])), float(np.clip(factor[3], 0, 1)))
        return Look(
            name=str(entry.get("name") or ""),
            color=cast(tuple[float, float, float, float], color),
            texture=None if info is None else self._texture(info, where),
            uv_set=_uv_set(info),
            uv_transform=_uv_transform(info, where),
            wrap="repeat" if info is None else self._wrap(info),
            alpha_mode=cast(AlphaMode, mode),
            alpha_cutoff=float(cutoff) if isinstance(cutoff, int | float) else 0.5,
        )

    def _base(self, entry: dict[str, Any], where: str) -> tuple[np.ndarray, Any]:
        """Linear base colour and opacity `(4,)`, and the texture reference or none."""
        white = [1.0, 1.0, 1.0, 1.0]
        glossy = _extension(entry, _SPECULAR)
        if glossy and "pbrMetallicRoughness" not in entry:
            self._notes[f"{_SPECULAR}: diffuse part only"] += 1
            return _factor(glossy, "diffuseFactor", where, white), glossy.get("diffuseTexture")
        pbr = entry.get("pbrMetallicRoughness", {})
        if not isinstance(pbr, dict):
            raise ValueError(f"{where}: pbrMetallicRoughness must be an object, got {pbr!r}")
        return _factor(pbr, "baseColorFactor", where, white), pbr.get("baseColorTexture")

    def _texture(self, info: Any, where: str) -> Pixels | None:
        if not isinstance(info, dict):
            raise ValueError(f"{where}: a texture reference must be an object, got {info!r}")
        texture = self._document.entry("textures", info.get("index"))
        sources = [texture.get("source")]
        sources += [
            _extension(texture, name).get("source")
            for name in ("EXT_texture_webp", "KHR_texture_basisu")
        ]
        source = next((one for one in sources if one is not None), None)
        if source is None:
            self._notes[f"textures[{info.get('index')}] has no image, base colour instead"] += 1
            return None
        image = self._document.entry("images", source)
        label = str(image.get("name") or image.get("uri") or "")
        label = f"images[{source}]" + (f" {label[:80]}" if label[:5] not in ("", "data:") else "")
        return self._textures.get(label, functools.partial(self._encoded, image, source))

    def _wrap(self, info: dict[str, Any]) -> Wrap:
        """Of both directions, the one that does not repeat."""
        sampler = self._document.entry("textures", info.get("index")).get("sampler")
        entry = {} if sampler is None else self._document.entry("samplers", sampler)
        codes = {entry.get("wrapS", _REPEAT), entry.get("wrapT", _REPEAT)}
        return "clamp" if _CLAMP in codes else "mirror" if _MIRROR in codes else "repeat"

    def _encoded(self, image: dict[str, Any], source: int) -> bytes:
        if "bufferView" in image:
            return self._document.view(image["bufferView"])
        if "uri" not in image:
            raise ValueError(f"images[{source}] has neither a bufferView nor a uri")
        return self._document.resource(image["uri"])


def _extension(entry: dict[str, Any], name: str) -> dict[str, Any]:
    extensions = entry.get("extensions", {})
    found = extensions.get(name, {}) if isinstance(extensions, dict) else {}
    return found if isinstance(found, dict) else {}


def _factor(entry: dict[str, Any], key: str, where: str, default: list[float]) -> np.ndarray:
    value = entry.get(key, default)
    try:
        factor = np.asarray(value, np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{where}: {key} must be numbers, got {value!r}") from error
    if factor.shape != (len(default),) or not np.isfinite(factor).all():
        raise ValueError(f"{where}: {key} must be {len(default)} finite numbers, got {value!r}")
    return factor.copy()


def _uv_set(info: Any) -> int:
    if not isinstance(info, dict):
        return 0
    moved = _extension(info, "KHR_texture_transform").get("texCoord")
    number = info.get("texCoord", 0) if moved is None else moved
    return number if type(number) is int and number >= 0 else 0


def _uv_transform(
    info: Any, where: str
) -> tuple[tuple[float, float, float], tuple[float, float, float]] | None:
    """Offset x rotation x scale of `KHR_texture_transform`."""
    entry = _extension(info, "KHR_texture_transform") if isinstance(info, dict) else {}
    if not entry:
        return None
    offset = _factor(entry, "offset", where, [0.0, 0.0])
    scale = _factor(entry, "scale", where, [1.0, 1.0])
    angle = float(_factor({"rotation": [entry.get("rotation", 0.0)]}, "rotation", where, [0.0])[0])
    c, s = math.cos(angle), math.sin(angle)
    first = (c * scale[0], s * scale[1], offset[0])
    second = (-s * scale[0], c * scale[1], offset[1])
    return (
        (float(first[0]), float(first[1]), float(first[2])),
        (float(second[0]), float(second[1]), float(second[2])),
    )
