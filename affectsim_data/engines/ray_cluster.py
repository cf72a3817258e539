"""A Ray cluster: items are worked on many machines; results come back to who asked."""

from __future__ import annotations

import importlib
import logging
import os
from collections.abc import Callable, Iterable, Iterator
from types import TracebackType
from typing import Any, TypeVar

from affectsim_data.engines.code import code_fingerprint

__all__ = ["RayEngine"]

_In = TypeVar("_In")
_Out = TypeVar("_Out")

_RETRIES = 5
"""How often an item whose worker was lost is given to another."""

_tasks: dict[str, Callable[[Any], Any]] = {}
"""In a worker: the task it has, by name; the last one only."""


class RayEngine:
    """Ray tasks, one per item and core.

    Every machine of the cluster needs this version of the package; folders that a command names
    must be reachable there under the same path.
    """

    def __init__(self, address: str | None = None, jobs: int | None = None) -> None:
        """Joins a cluster, or starts one on this machine.

        Args:
            address: Of a cluster that runs; `RAY_ADDRESS` says it too. None starts one here.
            jobs: Items in work at once; what the cluster has cores for if not given.

        Raises:
            ImportError: Ray is not installed.
            ConnectionError: There is no cluster at the address.
        """
        # Ray would report its use to its makers.
        os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
        ray = self._ray = _import_ray()
        self._owner = not ray.is_initialized()
        address = address or os.environ.get("RAY_ADDRESS")
        if self._owner:
            own = {} if address else {"num_cpus": jobs, "include_dashboard": False}
            ray.init(
                address=address or "local",
                log_to_driver=False,
                logging_level=logging.ERROR,
                **own,
            )
        self._jobs = jobs or max(1, int(ray.cluster_resources().get("CPU", 1)))
        self._call = ray.remote(num_cpus=1, max_retries=_RETRIES)(_call)
        self._task: object = None
        self._stored: Any = None
        self._number = 0

    def run(self, task: Callable[[_In], _Out], items: Iterable[_In]) -> Iterator[tuple[int, _Out]]:
        """As `Engine.run` says.

        Raises:
            ChildProcessError: Worker after worker died with an item.
        """
        if task is not self._task:
            self._task, self._stored = task, self._ray.put(task)
            self._number += 1
        name = f"{os.getpid()}-{id(self)}-{self._number}"
        places: dict[Any, int] = {}
        left = enumerate(items)
        while True:
            while len(places) < 2 * self._jobs:
                place, item = next(left, (-1, None))
                if place < 0:
                    break
                places[self._call.remote(name, [self._stored], code_fingerprint(), item)] = place
            if not places:
                return
            done, _ = self._ray.wait(list(places), num_returns=1)
            yield places.pop(done[0]), self._result(done[0])

    def _result(self, reference: Any) -> Any:
        try:
            return self._ray.get(reference)
        except self._ray.exceptions.RayTaskError as error:
            raise error.cause from error
        except self._ray.exceptions.RayError as error:
            raise ChildProcessError(f"Ray lost an item for good: {error}") from error

    def __enter__(self) -> RayEngine:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._owner:
            self._ray.shutdown()


def _import_ray() -> Any:
    try:
        return importlib.import_module("ray")
    except ImportError as error:
        raise ImportError(
            f"the engine `ray` needs Ray: pip install 'affectsim-data[scale]' ({error})"
        ) from error


def _call(name: str, stored: list[Any], code: str, item: Any) -> Any:
    """Calls a task in a worker, where it is fetched once.

    Args:
        name: Of the task.
        stored: Reference to it; in a list, else Ray would fetch it for every call.
        code: Fingerprint of the code it is to be done with.
        item: What it is called with.

    Raises:
        ValueError: This machine has other code.
    """
    if name not in _tasks:
        ray = _import_ray()
        if code_fingerprint() != code:
            raise ValueError(
                f"{ray.util.get_node_ip_address()}: this machine of the cluster has another "
                "affectsim-data, or other recipes; install there what runs here"
            )
        _tasks.clear()
        _tasks[name] = ray.get(stored[0])
    return _tasks[name](item)
