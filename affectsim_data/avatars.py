"""Avatars: bodies skinned to the 22 joints, posed by matrix products in NumPy or in a renderer."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.glb import GlbBuilder, GlbFile
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import BODY, JOINT_NAMES, JOINT_PARENTS, NUM_JOINTS, Skeleton

__all__ = ["Avatar", "AvatarMesh", "SurfaceSamples"]


@dataclasses.dataclass(frozen=True)
class AvatarMesh:
    """One level of detail of a body in its rest pose (T-pose, standing on the floor, facing +Z)."""

    positions: NDArray[np.float32]
    """Vertices, metres, `(num_vertices, 3)`."""
    normals: NDArray[np.float32]
    """Unit vertex normals, `(num_vertices, 3)`."""
    colors: NDArray[np.uint8]
    """sRGB vertex colours, `(num_vertices, 4)`."""
    joint_indices: NDArray[np.uint8]
    """The four joints that move a vertex, `(num_vertices, 4)`."""
    joint_weights: NDArray[np.uint8]
    """Their weights in 1/255, rows sum to 255, `(num_vertices, 4)`."""
    faces: NDArray[np.uint32]
    """Triangles, counter-clockwise from outside, `(num_faces, 3)`."""

    def __post_init__(self) -> None:
        count = len(self.positions)
        shapes = {"positions": 3, "normals": 3, "colors": 4, "joint_indices": 4, "joint_weights": 4}
        for field, width in shapes.items():
            if getattr(self, field).shape != (count, width):
                raise ValueError(
                    f"avatar mesh: {field} must be ({count}, {width}), "
                    f"got {getattr(self, field).shape}"
                )
        if not np.isfinite(self.positions).all():
            raise ValueError("avatar mesh: positions must be finite")
        if self.faces.ndim != 2 or self.faces.shape[1] != 3 or not len(self.faces):
            raise ValueError(f"avatar mesh: faces must be (n >= 1, 3), got {self.faces.shape}")
        if int(self.faces.max()) >= count:
            raise ValueError("avatar mesh: a face names a vertex that is not there")
        if int(self.joint_indices.max()) >= NUM_JOINTS:
            raise ValueError(f"avatar mesh: a vertex names a joint >= {NUM_JOINTS}")

    def skin(self, joint_matrices: ArrayLike) -> FloatArray:
        """Vertices under joint matrices `(..., 22, 4, 4)`, as `(..., num_vertices, 3)`."""
        return _skin(self.positions, self.joint_indices, self.joint_weights / 255.0, joint_matrices)


@dataclasses.dataclass(frozen=True)
class SurfaceSamples:
    """Area-weighted points of a body surface that move with it; the basis of visible shares."""

    positions: FloatArray
    """Rest positions, metres, `(num_points, 3)`."""
    joint_indices: NDArray[np.uint8]
    """`(num_points, 4)`."""
    joint_weights: FloatArray
    """Rows sum to one, `(num_points, 4)`."""

    def skin(self, joint_matrices: ArrayLike) -> FloatArray:
        """Points under joint matrices `(..., 22, 4, 4)`, as `(..., num_points, 3)`."""
        return _skin(self.positions, self.joint_indices, self.joint_weights, joint_matrices)


def _skin(
    positions: NDArray[Any], indices: NDArray[np.uint8], weights: NDArray[Any], matrices: ArrayLike
) -> FloatArray:
    joints = np.asarray(matrices, np.float64)[..., :3, :]
    blended = np.einsum("vk,...vkij->...vij", weights, joints[..., indices, :, :])
    moved: FloatArray = np.einsum("...vij,vj->...vi", blended[..., :3], positions)
    moved += blended[..., 3]
    return moved


@dataclasses.dataclass(frozen=True)
class Avatar:
    """A body anyone's motion can drive: levels of detail over one skeleton."""

    avatar_id: str
    """Unique in a release."""
    skeleton: Skeleton
    """The 22 joints in this body's proportions."""
    meshes: tuple[AvatarMesh, ...]
    """Levels of detail, finest first."""
    source: str = ""
    """Where the body comes from."""
    licence: str = ""
    """Its licence, SPDX."""

    def __post_init__(self) -> None:
        if self.skeleton.joint_names != JOINT_NAMES:
            raise ValueError(f"avatar {self.avatar_id!r}: needs the 22 body joints in their order")
        if not self.meshes:
            raise ValueError(f"avatar {self.avatar_id!r}: needs at least one mesh")

    @property
    def motion_scale(self) -> float:
        """Factor on root translations of motions, which are stored for the canonical body."""
        return self.skeleton.hip_height / BODY.hip_height

    def mesh(self, *, max_triangles: int | None = None) -> AvatarMesh:
        """The finest level of detail within a triangle budget, else the coarsest."""
        if max_triangles is None:
            return self.meshes[0]
        fitting = [mesh for mesh in self.meshes if len(mesh.faces) <= max_triangles]
        return fitting[0] if fitting else self.meshes[-1]

    def pose(
        self,
        root_translation: ArrayLike,
        joint_rotations: ArrayLike,
        *,
        T_world_performance: ArrayLike | None = None,
    ) -> FloatArray:
        """Joint frames in the performance frame, `(num_frames, 22, 4, 4)`, in this body's size.

        Args:
            root_translation: Of the canonical body, metres, `(num_frames, 3)`.
            joint_rotations: `(num_frames, 22, 4)`.
            T_world_performance: Gives them in the world instead, `(4, 4)`.
        """
        root = np.asarray(root_translation, np.float64) * self.motion_scale
        return self.skeleton.joint_frames(
            root, joint_rotations, T_world_performance=T_world_performance
        )

    def joint_matrices(
        self,
        root_translation: ArrayLike,
        joint_rotations: ArrayLike,
        *,
        T_world_performance: ArrayLike | None = None,
    ) -> FloatArray:
        """Matrices that take rest vertices into the performance frame, `(num_frames, 22, 4, 4)`;
        with `T_world_performance` into the world."""
        matrices = self.pose(
            root_translation, joint_rotations, T_world_performance=T_world_performance
        )
        turned = matrices[..., :3, :3] @ self.skeleton.rest_positions[:, :, None]
        matrices[..., :3, 3] -= turned[..., 0]
        return matrices

    def surface_samples(self, num_points: int, *, rng: np.random.Generator) -> SurfaceSamples:
        """Points drawn uniformly by area on the rest surface."""
        mesh = self.meshes[-1]
        corners = mesh.positions[mesh.faces].astype(np.float64)
        doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = np.linalg.norm(doubled, axis=1)
        # Stratified along the cumulative area: even cover for few points.
        strata = (np.arange(num_points) + rng.random(num_points)) / num_points
        chosen = np.searchsorted(np.cumsum(area) / area.sum(), strata).clip(max=len(area) - 1)
        u, v = np.sqrt(rng.random(num_points)), rng.random(num_points)
        barycentric = np.stack([1.0 - u, u * (1.0 - v), u * v], axis=1)
        positions = np.einsum("nk,nki->ni", barycentric, corners[chosen])
        heaviest = mesh.faces[chosen, barycentric.argmax(axis=1)]
        return SurfaceSamples(
            positions, mesh.joint_indices[heaviest], mesh.joint_weights[heaviest] / 255.0
        )

    def rounded(self) -> Avatar:
        """The body as releases store it: positions to 1/4 mm, normals to 1/128.

        Too little to see at the sizes clips are drawn in, and shards compress it far better.
        """
        meshes = tuple(
            dataclasses.replace(
                mesh,
                positions=_rounded(mesh.positions, bits=12),
                normals=_rounded(mesh.normals, bits=7),
            )
            for mesh in self.meshes
        )
        return dataclasses.replace(self, meshes=meshes)

    def to_glb(self) -> bytes:
        """A skinned glTF any viewer opens; levels of detail are its meshes, finest first."""
        builder = GlbBuilder()
        rest = self.skeleton.rest_positions
        inverse_bind = np.tile(np.eye(4, dtype=np.float32), (NUM_JOINTS, 1, 1))
        inverse_bind[:, :3, 3] = -rest
        meshes = [
            {
                "name": f"level_{level}",
                "primitives": [
                    {
                        "attributes": {
                            "POSITION": builder.accessor(mesh.positions),
                            "NORMAL": builder.accessor(mesh.normals),
                            "COLOR_0": builder.accessor(mesh.colors, normalized=True),
                            "JOINTS_0": builder.accessor(mesh.joint_indices),
                            "WEIGHTS_0": builder.accessor(mesh.joint_weights, normalized=True),
                        },
                        "indices": builder.accessor(mesh.faces.reshape(-1)),
                        "material": 0,
                    }
                ],
            }
            for level, mesh in enumerate(self.meshes)
        ]
        nodes: list[dict[str, Any]] = []
        for joint, name in enumerate(JOINT_NAMES):
            node: dict[str, Any] = {
                "name": name,
                "translation": [float(x) for x in self.skeleton.joint_offsets[joint]],
            }
            children = [i for i, parent in enumerate(JOINT_PARENTS) if parent == joint]
            nodes.append({**node, "children": children} if children else node)
        nodes.append({"name": self.avatar_id, "mesh": 0, "skin": 0})
        document = {
            "scene": 0,
            "scenes": [{"nodes": [0, NUM_JOINTS]}],
            "nodes": nodes,
            "meshes": meshes,
            "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1}}],
            "skins": [
                {
                    "joints": list(range(NUM_JOINTS)),
                    "skeleton": 0,
                    "inverseBindMatrices": builder.accessor(inverse_bind),
                }
            ],
            "extras": {
                "avatar_id": self.avatar_id,
                "source": self.source,
                "licence": self.licence,
            },
        }
        return builder.to_bytes(document)

    @classmethod
    def from_glb(cls, payload: bytes, *, name: str) -> Avatar:
        """Reads what `to_glb` wrote.

        Raises:
            ValueError: Not such a GLB; the message starts with `name`.
        """
        glb = GlbFile.from_bytes(payload, name=name)
        try:
            nodes, extras = glb.document["nodes"], glb.document["extras"]
            found = tuple(node["name"] for node in nodes[:NUM_JOINTS])
            offsets = np.array([node["translation"] for node in nodes[:NUM_JOINTS]], np.float64)
            meshes = tuple(_read_mesh(glb, entry) for entry in glb.document["meshes"])
            return cls(
                avatar_id=extras["avatar_id"],
                skeleton=Skeleton(found, JOINT_PARENTS, offsets),
                meshes=meshes,
                source=extras["source"],
                licence=extras["licence"],
            )
        except (KeyError, IndexError, TypeError, AttributeError) as error:
            raise ValueError(f"{name}: not an avatar GLB: {error!r}") from error
        except ValueError as error:
            if str(error).startswith(name):
                raise
            raise ValueError(f"{name}: {error}") from error


def _rounded(values: NDArray[np.float32], *, bits: int) -> NDArray[np.float32]:
    scale = np.float32(2**bits)
    return np.asarray(np.round(values * scale) / scale, np.float32)


def _read_mesh(glb: GlbFile, entry: dict[str, Any]) -> AvatarMesh:
    primitive = entry["primitives"][0]
    attributes = primitive["attributes"]
    return AvatarMesh(
        positions=glb.array(attributes["POSITION"]),
        normals=glb.array(attributes["NORMAL"]),
        colors=glb.array(attributes["COLOR_0"]),
        joint_indices=glb.array(attributes["JOINTS_0"]),
        joint_weights=glb.array(attributes["WEIGHTS_0"]),
        faces=glb.array(primitive["indices"]).reshape(-1, 3),
    )
