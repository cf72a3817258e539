"""The `pyrender` backend: slow, independent of the other one, and there to keep it honest.

People are skinned in NumPy and put into the scene anew for every frame. Colours come from a flat
pass; bodies get the same light as in the `egl` backend, computed here. Depth and instance ids come
from a second, segmentation pass, which pyrender draws without multisampling: its depth is that of
the pixel's centre, where that of the first pass is the depth of a sample up to half a pixel away.
"""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.avatars import AvatarMesh
from affectsim_data.errors import RendererUnavailableError
from affectsim_data.poses import FloatArray
from affectsim_data.render.egl import INSTALL_HINT, claim_display, default_device, egl_devices
from affectsim_data.render.framing import BACKGROUND, FAR_M, NEAR_M, choose_mesh
from affectsim_data.render.lighting import light_on
from affectsim_data.render.processes import Owner, survive_forks
from affectsim_data.render.protocol import ClipSpec, RenderedClip, RendererName
from affectsim_data.scenes import Scene, Surface

__all__ = ["PyrenderRenderer", "import_pyrender", "surface_primitive"]


def import_pyrender() -> Any:
    """pyrender, on EGL, with the one name NumPy 2 took from under it.

    `PYOPENGL_PLATFORM` counts when OpenGL is first imported in the process, never again.
    """
    os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
    if not hasattr(np, "infty"):
        vars(np)["infty"] = np.inf
    import pyrender

    return pyrender


class PyrenderRenderer:
    """Draws clips with pyrender; see `Renderer`."""

    name: RendererName = "pyrender"

    def __init__(self, device: int | None = None, *, exact: bool = True) -> None:
        """Prepares a renderer without opening anything.

        Args:
            device: EGL device index; `None` for `AFFECTSIM_EGL_DEVICE`, else the first.
            exact: `False` leaves the second pass out: depth of a sample near the pixel's centre.
        """
        self._device = device
        self._exact = exact
        self._offscreen: Any = None
        self._owner = Owner()
        self._scene: tuple[Scene, Any] | None = None
        self._closed = False
        survive_forks(self)

    def render(self, spec: ClipSpec, *, instances: bool = False) -> RenderedClip:
        """The images of `spec`.

        Raises:
            ForkedContextError: The context was opened before a fork it could not survive.
            RendererUnavailableError: No device opens.
            RuntimeError: Closed, or called on another thread than the first clip.
        """
        if self._closed:
            raise RuntimeError("this renderer was closed; open a new one with open_renderer()")
        pyrender = import_pyrender()
        camera = spec.camera
        offscreen = self._open(pyrender, camera.width, camera.height)
        scene = self._static_scene(pyrender, spec.scene)
        focal = spec.camera.intrinsics[0, 0]
        lens = pyrender.IntrinsicsCamera(
            focal, focal, camera.width / 2, camera.height / 2, znear=NEAR_M, zfar=FAR_M
        )
        eye = scene.add(lens)
        scene.main_camera_node = eye
        meshes = [choose_mesh(person, spec) for person in spec.people]
        images = []
        try:
            for frame, T_world_camera in enumerate(spec.trajectory.T_world_camera):
                scene.set_pose(eye, T_world_camera)
                posed = [person.joint_matrices[frame] for person in spec.people]
                images.append(self._draw(pyrender, offscreen, scene, meshes, posed))
        finally:
            scene.remove_node(eye)
        rgb, depth, ids = (np.stack(parts) for parts in zip(*images, strict=True))
        return RenderedClip(rgb, depth, ids if instances else None)

    def close(self) -> None:
        """Frees the device; the renderer cannot be used again."""
        self._closed = True
        if self.is_open and self._owner.is_here:
            self._release()
        self._offscreen = self._scene = None

    @property
    def is_open(self) -> bool:
        """Whether it holds a context."""
        return self._offscreen is not None

    @property
    def can_suspend(self) -> bool:
        """Whether its driver can be shut down by the calling thread."""
        if not self.is_open or not self._owner.is_here:
            return not self.is_open
        from OpenGL import GL

        self._offscreen._platform.make_current()
        return b"llvmpipe" in GL.glGetString(GL.GL_RENDERER)

    def suspend(self) -> None:
        """Gives up the context, to be opened again by the next clip, in whichever process."""
        if self.is_open:
            self._release()

    def _release(self) -> None:
        """Frees the context.

        pyrender's own `delete` would terminate the display and every other context on it.
        """
        from OpenGL import EGL
        from OpenGL.error import GLError

        offscreen, self._offscreen, self._scene = self._offscreen, None, None
        platform = offscreen._platform
        display = platform._egl_display
        try:
            platform.make_current()
            offscreen._renderer.delete()
        except GLError:
            pass  # Lost: another user of EGL terminated the display.
        else:
            none = EGL.EGL_NO_SURFACE
            EGL.eglMakeCurrent(display, none, none, EGL.EGL_NO_CONTEXT)
            EGL.eglDestroyContext(display, platform._egl_context)
        platform._egl_display = platform._egl_context = None
        # Its finalizer still calls `delete`.
        offscreen._platform, offscreen._renderer = _Nothing(), _Nothing()

    def _is_lost(self) -> bool:
        """Whether another user of EGL terminated the display, and the context with it."""
        from OpenGL.error import GLError

        try:
            self._offscreen._platform.make_current()
        except GLError:
            return True
        return False

    def _open(self, pyrender: Any, width: int, height: int) -> Any:
        if self._offscreen is not None:
            self._owner.check()
            if self._is_lost():
                self._release()
        if self._offscreen is None:
            index = default_device() if self._device is None else self._device
            devices = egl_devices()
            if not (index or 0) < len(devices):
                raise RendererUnavailableError(
                    f"EGL device {index} does not exist, there are {len(devices)}; {INSTALL_HINT}"
                )
            claim_display(devices[index or 0])
            os.environ["EGL_DEVICE_ID"] = str(index or 0)
            try:
                self._offscreen = pyrender.OffscreenRenderer(width, height)
            except Exception as error:
                raise RendererUnavailableError(f"pyrender: {error!r}; {INSTALL_HINT}") from error
            self._owner = Owner()
        self._offscreen.viewport_width, self._offscreen.viewport_height = width, height
        return self._offscreen

    def _static_scene(self, pyrender: Any, source: Scene) -> Any:
        """The scene without people; the last one is kept."""
        if self._scene is None or self._scene[0] is not source:
            color = [value / 255.0 for value in BACKGROUND]
            scene = pyrender.Scene(bg_color=[*color, 1.0], ambient_light=[1.0, 1.0, 1.0])
            for surface in source.surfaces:
                scene.add(pyrender.Mesh([surface_primitive(pyrender, surface)]))
            self._scene = (source, scene)
        return self._scene[1]

    def _draw(
        self,
        pyrender: Any,
        offscreen: Any,
        scene: Any,
        meshes: list[AvatarMesh],
        poses: list[FloatArray],
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32], NDArray[np.uint8]]:
        flags = pyrender.RenderFlags
        eye = scene.get_pose(scene.main_camera_node)[:3, 3]
        ids = dict.fromkeys(scene.mesh_nodes, 0)
        bodies = []
        for place, (mesh, pose) in enumerate(zip(meshes, poses, strict=True), start=1):
            node = scene.add(pyrender.Mesh([_posed_primitive(pyrender, mesh, pose, eye)]))
            bodies.append(node)
            ids[node] = place
        try:
            rgb, depth = offscreen.render(scene, flags=flags.FLAT | flags.SKIP_CULL_FACES)
            labels = np.zeros(depth.shape, np.uint8)
            if self._exact:
                segments = flags.SEG | flags.SKIP_CULL_FACES
                marked, depth = offscreen.render(scene, flags=segments, seg_node_map=ids)
                labels = marked[..., 0].copy()
        finally:
            for node in bodies:
                scene.remove_node(node)
        return rgb, np.where(depth == 0.0, np.inf, depth).astype(np.float32), labels


class _Nothing:
    """Stands in for what was freed already; takes the calls of a finalizer."""

    def make_current(self) -> None:
        return None

    def delete(self) -> None:
        return None

    def delete_context(self) -> None:
        return None


def surface_primitive(pyrender: Any, surface: Surface) -> Any:
    """A `pyrender.Primitive`, two-sided, with vertex colours and texture."""
    material = pyrender.MetallicRoughnessMaterial(doubleSided=True)
    uvs = None
    if surface.texture is not None and surface.uvs is not None:
        # pyrender turns textures over on upload, so its v runs up and ours, as in glTF, down.
        uvs = np.stack([surface.uvs[:, 0], 1.0 - surface.uvs[:, 1]], axis=1)
        sampler = pyrender.Sampler(magFilter=0x2601, minFilter=0x2703, wrapS=0x2901, wrapT=0x2901)
        material.baseColorTexture = pyrender.Texture(
            source=surface.texture, source_channels="RGB", sampler=sampler
        )
    return pyrender.Primitive(
        positions=surface.positions,
        color_0=surface.colors.astype(np.float32) / 255.0,
        texcoord_0=uvs,
        indices=surface.faces,
        material=material,
    )


def _posed_primitive(pyrender: Any, mesh: AvatarMesh, pose: FloatArray, eye: FloatArray) -> Any:
    positions = mesh.skin(pose)
    weights = mesh.joint_weights / 255.0
    blended = np.einsum("vk,vkij->vij", weights, pose[mesh.joint_indices, :3, :3])
    normals = np.einsum("vij,vj->vi", blended, mesh.normals)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    colors = mesh.colors.astype(np.float32) / 255.0
    colors[:, :3] *= light_on(normals, positions - eye)[:, None]
    colors[:, 3] = 1.0
    return pyrender.Primitive(
        positions=positions.astype(np.float32),
        color_0=np.clip(colors, 0.0, 1.0),
        indices=mesh.faces,
        material=pyrender.MetallicRoughnessMaterial(doubleSided=True),
    )
