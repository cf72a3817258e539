"""What is drawn: triangles of one material, with their light baked into their colours."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

__all__ = ["Surface"]


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
        for field in ("positions", "normals", "uvs"):
            values = getattr(self, field)
            if values is not None and not np.isfinite(values).all():
                raise ValueError(f"surface {self.name!r}: {field} must be finite")
        if self.faces.ndim != 2 or self.faces.shape[1] != 3:
            raise ValueError(f"surface {self.name!r}: faces must be (n, 3), got {self.faces.shape}")
        if self.faces.size and not 0 <= int(self.faces.min()) <= int(self.faces.max()) < count:
            raise ValueError(f"surface {self.name!r}: a face names a vertex that is not there")
        if self.uvs is not None and self.uvs.shape != (count, 2):
            raise ValueError(
                f"surface {self.name!r}: uvs must be ({count}, 2), got {self.uvs.shape}"
            )
        if self.texture is None:
            return
        if self.uvs is None:
            raise ValueError(f"surface {self.name!r}: a texture needs uvs ({count}, 2)")
        shape = self.texture.shape
        if len(shape) != 3 or shape[2] != 3 or not all(shape) or self.texture.dtype != np.uint8:
            raise ValueError(
                f"surface {self.name!r}: texture must be uint8 (height, width, 3), "
                f"got {self.texture.dtype} {shape}"
            )
