"""EGL through ctypes: devices, one headless OpenGL context, and what it takes to survive a fork.

`glcontext` cannot terminate a display, which a fork needs (see `processes`), and hides why a device
did not open; so the context is made here and handed to moderngl, which only asks it for functions.
"""

from __future__ import annotations

import ctypes
import dataclasses
import os
from collections.abc import Mapping, Sequence
from typing import Any

from affectsim_data.errors import ForkedContextError, RendererUnavailableError

__all__ = [
    "INSTALL_HINT",
    "EglContext",
    "EglDevice",
    "FORK_REMEDY",
    "choose_device",
    "claim_display",
    "default_device",
    "egl_devices",
    "terminate_displays",
]

INSTALL_HINT = (
    "install the system libraries with `apt-get install -y libegl1 libgl1-mesa-dri libgles2` "
    "(Debian, Ubuntu) and run `affectsim doctor` to see what renders here"
)
FORK_REMEDY = (
    "start workers with multiprocessing_context='forkserver', or use "
    "affectsim_data.loaders.data_loader, which does"
)

_EXTENSIONS, _VENDOR, _VERSION = 0x3055, 0x3053, 0x3054
_PLATFORM_DEVICE = 0x313F
_OPENGL_API, _OPENGL_BIT, _PBUFFER_BIT = 0x30A2, 0x0008, 0x0001
_NONE = 0x3038
_CONFIG = (0x3033, _PBUFFER_BIT, 0x3024, 8, 0x3023, 8, 0x3022, 8, 0x3040, _OPENGL_BIT, _NONE)
_CORE_3_3 = (0x3098, 3, 0x30FB, 3, 0x30FD, 1, _NONE)
_FIRST_CONFIG_ONLY = 1
_CUDA = "EGL_NV_device_cuda"

_P, _I, _S = ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p
_SIGNATURES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "eglGetError": (_I, ()),
    "eglGetProcAddress": (_P, (_S,)),
    "eglQueryString": (_S, (_P, _I)),
    "eglInitialize": (_I, (_P, _P, _P)),
    "eglTerminate": (_I, (_P,)),
    "eglBindAPI": (_I, (_I,)),
    "eglChooseConfig": (_I, (_P, _P, _P, _I, _P)),
    "eglCreateContext": (_P, (_P, _P, _P, _P)),
    "eglDestroyContext": (_I, (_P, _P)),
    "eglMakeCurrent": (_I, (_P, _P, _P, _P)),
    "eglGetCurrentContext": (_P, ()),
    "eglReleaseThread": (_I, ()),
}
_EXTENSION_SIGNATURES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "eglQueryDevicesEXT": (_I, (_I, _P, _P)),
    "eglQueryDeviceStringEXT": (_S, (_P, _I)),
    "eglGetPlatformDisplayEXT": (_P, (_I, _P, _P)),
}


class _Library:
    """`libEGL.so.1` with typed functions."""

    def __init__(self) -> None:
        try:
            self._handle = ctypes.CDLL("libEGL.so.1")
        except OSError as error:
            raise RendererUnavailableError(f"no EGL: {error}; {INSTALL_HINT}") from error
        for name, (result, arguments) in _SIGNATURES.items():
            function = getattr(self._handle, name)
            function.restype, function.argtypes = result, arguments
            setattr(self, name, function)
        for name, (result, arguments) in _EXTENSION_SIGNATURES.items():
            address = self.eglGetProcAddress(name.encode())
            if not address:
                raise RendererUnavailableError(f"this EGL has no {name}; {INSTALL_HINT}")
            setattr(self, name, ctypes.CFUNCTYPE(result, *arguments)(address))

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(name)


_library: _Library | None = None


def _egl() -> _Library:
    global _library
    if _library is None:
        _library = _Library()
    return _library


@dataclasses.dataclass(frozen=True)
class EglDevice:
    """One device EGL can draw with."""

    index: int
    """Place in EGL's list, the value of `AFFECTSIM_EGL_DEVICE`."""
    extensions: str
    """Device extensions, space separated."""
    handle: int
    """EGLDeviceEXT."""

    @property
    def software(self) -> bool:
        """Whether it is Mesa's software rasterizer, which needs no GPU."""
        return "EGL_MESA_device_software" in self.extensions


def egl_devices() -> tuple[EglDevice, ...]:
    """Every device of this machine.

    Raises:
        RendererUnavailableError: No EGL library, or one that cannot list its devices.
    """
    egl, count = _egl(), ctypes.c_int()
    if not egl.eglQueryDevicesEXT(0, None, ctypes.byref(count)):
        raise RendererUnavailableError(f"EGL lists no devices; {INSTALL_HINT}")
    handles = (ctypes.c_void_p * max(count.value, 1))()
    egl.eglQueryDevicesEXT(count.value, handles, ctypes.byref(count))
    return tuple(
        EglDevice(
            index,
            (egl.eglQueryDeviceStringEXT(handles[index], _EXTENSIONS) or b"").decode(),
            int(handles[index] or 0),
        )
        for index in range(count.value)
    )


def default_device() -> int | None:
    """The device this process is to draw with; `None` for the first that opens.

    Raises:
        RendererUnavailableError: Several devices to choose from, perhaps, but no EGL to ask.
        ValueError: See `choose_device`.
    """
    if os.environ.get("AFFECTSIM_EGL_DEVICE") or not os.environ.get("LOCAL_RANK"):
        return choose_device((), os.environ)
    return choose_device(egl_devices(), os.environ)


def choose_device(devices: Sequence[EglDevice], environment: Mapping[str, str]) -> int | None:
    """Index of the device that the environment gives a process; `None` if it does not say.

    `AFFECTSIM_EGL_DEVICE` names one. Else, where there are several GPUs, the processes that a
    launcher started on this machine take turns by `LOCAL_RANK`. Where some of the GPUs are NVIDIA's
    only these count: the others are the board's own, or Mesa's entries for the same cards.

    Raises:
        ValueError: One of the two variables is not a number from 0 up.
    """
    named = _index(environment, "AFFECTSIM_EGL_DEVICE", "a device index")
    if named is not None:
        return named
    hardware = [device for device in devices if not device.software]
    gpus = [device for device in hardware if _CUDA in device.extensions.split()] or hardware
    local_rank = _index(environment, "LOCAL_RANK", "a number from 0 up")
    if local_rank is None or len(gpus) < 2:
        return None
    return gpus[local_rank % len(gpus)].index


def _index(environment: Mapping[str, str], name: str, meaning: str) -> int | None:
    value = environment.get(name, "")
    if value and not value.isdecimal():
        raise ValueError(f"{name} must be {meaning}, got {value!r}")
    return int(value) if value else None


class EglContext:
    """A headless OpenGL 3.3 core context on one device; current on the thread that made it.

    Has the four methods moderngl asks of a context: `load_opengl_function`, `release` and the
    context manager that makes it current.
    """

    def __init__(self, device: int | None = None) -> None:
        """Opens a device: by index, else the first that works.

        Raises:
            ForkedContextError: The device was open when this process was forked.
            RendererUnavailableError: No device opens; the message says why and what to install.
        """
        devices = egl_devices()
        if device is not None and not 0 <= device < len(devices):
            raise RendererUnavailableError(
                f"EGL device {device} does not exist, there are {len(devices)}; {INSTALL_HINT}"
            )
        reasons = []
        for candidate in devices if device is None else (devices[device],):
            reason = self._open(candidate)
            if reason is None:
                return
            reasons.append(f"device {candidate.index}: {reason}")
        raise RendererUnavailableError(
            f"no EGL device opens ({'; '.join(reasons) or 'none listed'}); {INSTALL_HINT}"
        )

    def _open(self, device: EglDevice) -> str | None:
        """`None` on success, else what failed."""
        egl = _egl()
        display = claim_display(device)
        if not display or not egl.eglInitialize(display, None, None):
            return f"eglInitialize failed with 0x{egl.eglGetError():x}"
        config, count = ctypes.c_void_p(), ctypes.c_int()
        wanted = (ctypes.c_int * len(_CONFIG))(*_CONFIG)
        found = egl.eglChooseConfig(
            display, wanted, ctypes.byref(config), _FIRST_CONFIG_ONLY, ctypes.byref(count)
        )
        if not found or count.value < 1 or not egl.eglBindAPI(_OPENGL_API):
            return "it offers no OpenGL configuration"
        version = (ctypes.c_int * len(_CORE_3_3))(*_CORE_3_3)
        handle = egl.eglCreateContext(display, config, None, version)
        if not handle:
            return f"eglCreateContext (OpenGL 3.3 core) failed with 0x{egl.eglGetError():x}"
        self.device = device
        self._display, self._handle, self._pid = display, handle, os.getpid()
        if not egl.eglMakeCurrent(display, None, None, handle):
            egl.eglDestroyContext(display, handle)
            return f"eglMakeCurrent failed with 0x{egl.eglGetError():x}"
        return None

    @property
    def vendor(self) -> str:
        """Who made the EGL driver."""
        return (_egl().eglQueryString(self._display, _VENDOR) or b"").decode()

    @property
    def version(self) -> str:
        """EGL version of the display."""
        return (_egl().eglQueryString(self._display, _VERSION) or b"").decode()

    def load_opengl_function(self, name: str) -> int:
        """Address of an OpenGL function, 0 if there is none."""
        return _egl().eglGetProcAddress(name.encode()) or 0

    def wrap(self) -> Any:
        """A `moderngl.Context` over this one."""
        import moderngl

        context: Any = self
        return moderngl.create_context(standalone=True, context=context, require=330)

    def make_current(self) -> bool:
        """Takes this thread's OpenGL calls; other libraries of the process may have had them.

        Returns:
            `False` if the context is lost: something else terminated its display.
        """
        egl = _egl()
        if egl.eglGetCurrentContext() == self._handle:
            return True
        # The API is bound per thread, and whoever had the thread may have bound another one.
        egl.eglBindAPI(_OPENGL_API)
        return bool(egl.eglMakeCurrent(self._display, None, None, self._handle))

    def __enter__(self) -> None:
        self.make_current()

    def __exit__(self, *_: object) -> None:
        return None

    def release(self) -> None:
        """Destroys the context; the display stays open, other contexts may use it."""
        # In a forked child the driver has lost its threads: touching it would wait forever.
        if not self._handle or self._pid != os.getpid():
            return
        egl = _egl()
        if egl.eglGetCurrentContext() == self._handle:
            egl.eglMakeCurrent(self._display, None, None, None)
        egl.eglDestroyContext(self._display, self._handle)
        self._handle = None


_displays: dict[int, tuple[int, bool]] = {}
"""Displays opened so far: by which process, and whether they are software."""


def claim_display(device: EglDevice) -> int:
    """The display of a device, one per device and process, about to be opened by this process.

    Raises:
        ForkedContextError: It was up when this process was forked, and lost its threads then.
    """
    display = int(_egl().eglGetPlatformDisplayEXT(_PLATFORM_DEVICE, device.handle, None) or 0)
    pid, _ = _displays.setdefault(display, (os.getpid(), device.software))
    if pid != os.getpid():
        raise ForkedContextError(
            f"EGL device {device.index} was opened in process {pid} and cannot be used after a "
            f"fork in process {os.getpid()}; {FORK_REMEDY}"
        )
    return display


def terminate_displays() -> None:
    """Shuts software displays down, with all their threads; contexts must be released before."""
    for display, (pid, software) in list(_displays.items()):
        if software and pid == os.getpid():
            _egl().eglTerminate(display)
            del _displays[display]
    if _library is not None:
        _library.eglReleaseThread()
