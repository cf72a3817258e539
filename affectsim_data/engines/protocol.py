"""What an engine does: it calls one task for many items, wherever there is room."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from types import TracebackType
from typing import Protocol, TypeVar

__all__ = ["Engine", "in_order"]

_In = TypeVar("_In")
_Out = TypeVar("_Out")


class Engine(Protocol):
    """Used as a context manager; leaving it ends what it started, also what still works."""

    def run(self, task: Callable[[_In], _Out], items: Iterable[_In]) -> Iterator[tuple[int, _Out]]:
        """Place and result of every item, as soon as each is there.

        Items are taken one by one as there is room for them, so that they may be made (read from
        disk, say) when they are asked for. The task is sent to a worker once, not with every item;
        it stays there until another is run.

        Args:
            task: Called elsewhere; must pickle, and give the same for the same item everywhere.
            items: What it is called with.

        Raises:
            ChildProcessError: A worker died and its item could not be done by another.
        """
        ...

    def __enter__(self) -> Engine: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...


def in_order(results: Iterable[tuple[int, _Out]]) -> Iterator[_Out]:
    """Results of `Engine.run` in the order of the items; those that came early wait.

    Examples:
        >>> list(in_order([(1, "b"), (0, "a"), (2, "c")]))
        ['a', 'b', 'c']
    """
    waiting: dict[int, _Out] = {}
    due = 0
    for place, result in results:
        waiting[place] = result
        while due in waiting:
            yield waiting.pop(due)
            due += 1
