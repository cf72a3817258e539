"""Markers, a cache of our own, no network, and the small release all tests share."""

from __future__ import annotations

import functools
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

# As many processes run tests as there are cores; threads that wait for one another would spin, and
# what takes a second alone takes minutes. Before NumPy and torch, which read it once.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import hypothesis
import pytest

import affectsim_data

TESTS = Path(__file__).resolve().parent
if str(TESTS) not in sys.path:
    # So that `import small_release` works under --import-mode=importlib, here and in workers.
    sys.path.insert(0, str(TESTS))

if TYPE_CHECKING:
    from affectsim_data.releases import Release

# The same examples everywhere, nothing kept between runs, and no clock on a shared machine.
hypothesis.settings.register_profile("affectsim", deadline=None, derandomize=True, database=None)
hypothesis.settings.load_profile("affectsim")

_LOOPBACK = ("127.", "localhost", "::1", "0.0.0.0")
_PROBE = """
import moderngl
context = moderngl.create_standalone_context(backend="egl")
print(context.info["GL_RENDERER"])
"""


@functools.cache
def _egl_problem() -> str:
    """Why no headless device can be opened; empty if one can. Asked in a process of its own."""
    try:
        probe = subprocess.run(
            [sys.executable, "-c", _PROBE], capture_output=True, text=True, timeout=120, check=False
        )
    except subprocess.TimeoutExpired:
        return "the probe took more than 120 s"
    lines = probe.stderr.strip().splitlines()
    return "" if probe.returncode == 0 else (lines[-1] if lines else f"status {probe.returncode}")


def _realdata_path() -> Path:
    default = TESTS.parents[1] / "shared" / "data"
    return Path(os.environ.get("AFFECTSIM_REALDATA") or default)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skips, or fails where asked to, what this machine cannot run."""
    if item.get_closest_marker("egl") and _egl_problem():
        message = f"no headless OpenGL device: {_egl_problem()}"
        if os.environ.get("AFFECTSIM_REQUIRE_EGL") == "1":
            pytest.fail(message, pytrace=False)
        pytest.skip(message)
    if item.get_closest_marker("realdata") and not _realdata_path().is_dir():
        pytest.skip(f"no real corpora in {_realdata_path()}; set AFFECTSIM_REALDATA")


@pytest.fixture
def realdata() -> Path:
    """Folder of the real corpora; for tests marked `realdata`."""
    return _realdata_path()


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Builds `mini` once per test session, in a folder of the session unless the caller has one."""
    with pytest.MonkeyPatch.context() as patch:
        if not os.environ.get("AFFECTSIM_CACHE"):
            patch.setenv("AFFECTSIM_CACHE", str(tmp_path_factory.mktemp("cache")))
        # Processes that tests start find the helpers here and the very package under test.
        package = str(Path(affectsim_data.__file__).parents[1])
        paths = [str(TESTS), package, *filter(None, [os.environ.get("PYTHONPATH")])]
        patch.setenv("PYTHONPATH", os.pathsep.join(paths))
        yield


@pytest.fixture(scope="session", autouse=True)
def no_network() -> Iterator[None]:
    """Lets sockets reach this machine only."""
    connect = socket.socket.connect

    def guarded(self: socket.socket, address: Any) -> None:
        if self.family in (socket.AF_INET, socket.AF_INET6):
            host = str(address[0])
            if not host.startswith(_LOOPBACK):
                raise PermissionError(f"tests may not reach the network, tried {host}")
        connect(self, address)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(socket.socket, "connect", guarded)
        yield


@pytest.fixture(scope="session")
def small_release_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the small release; not to be changed by a test."""
    from small_release import write_release

    out = tmp_path_factory.mktemp("releases") / "small"
    write_release(out)
    return out


@pytest.fixture
def release_copy(small_release_path: Path, tmp_path: Path) -> Path:
    """A copy of the small release a test may break."""
    return Path(shutil.copytree(small_release_path, tmp_path / "release"))


@pytest.fixture(scope="session")
def small(small_release_path: Path) -> Release:
    """The small release, open."""
    from affectsim_data.releases import open_release

    return open_release(small_release_path)
