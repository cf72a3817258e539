"""Engines: the same results wherever the work is done; errors, deaths and what is left behind."""

from __future__ import annotations

import functools
import math
import multiprocessing
import operator
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tiny_build import tree, write_tiny

from affectsim_data.builders.building import build_release
from affectsim_data.engines import Engine, LocalEngine, RayEngine, open_engine
from affectsim_data.engines.protocol import in_order


@given(st.permutations(range(6)))
def test_results_come_in_order_however_they_are_ready(order: list[int]) -> None:
    results = ((place, str(place)) for place in order)
    assert list(in_order(results)) == [str(place) for place in range(6)]


@pytest.mark.parametrize("jobs", [1, 2])
def test_every_item_is_done_and_nobody_is_left(jobs: int) -> None:
    with LocalEngine(jobs) as engine:
        assert sorted(engine.run(math.factorial, range(5))) == [
            *((0, 1), (1, 1), (2, 2), (3, 6), (4, 24))
        ]
        assert sorted(engine.run(operator.neg, [3])) == [(0, -3)]
        assert list(engine.run(operator.neg, [])) == []
        assert bool(multiprocessing.active_children()) == (jobs > 1)
    assert multiprocessing.active_children() == []


def test_items_are_made_when_there_is_room_for_them() -> None:
    made: list[int] = []

    def items() -> Iterator[int]:
        for number in range(50):
            made.append(number)
            yield number

    with LocalEngine(2) as engine:
        results = engine.run(operator.neg, items())
        next(results)
        assert len(made) < 10


def test_errors_of_a_task_reach_the_caller() -> None:
    with LocalEngine(2) as engine, pytest.raises(ValueError, match="not defined for negative"):
        list(engine.run(math.factorial, [1, -1, 2]))


def test_a_worker_that_dies_is_an_error_that_says_what_may_help() -> None:
    with (
        LocalEngine(2) as engine,
        pytest.raises(ChildProcessError, match=r"killed, or memory ran out; with fewer --jobs"),
    ):
        list(engine.run(os._exit, [7]))


def test_leaving_an_engine_ends_what_still_works() -> None:
    start = time.monotonic()
    with LocalEngine(2) as engine:
        assert next(engine.run(time.sleep, [0.0, 600.0])) == (0, None)
    assert time.monotonic() - start < 60.0
    assert multiprocessing.active_children() == []


def test_engines_that_cannot_be_had_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match="jobs must be at least 1, got 0"):
        LocalEngine(0)
    with pytest.raises(ValueError, match="engine must be one of local, ray, got 'mars'"):
        open_engine("mars")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="--ray-address is for --engine ray"):
        open_engine("local", address="auto")
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(ImportError, match=r"pip install 'affectsim-data\[scale\]'"):
        open_engine("ray")


@pytest.fixture(scope="module")
def cluster() -> Iterator[Engine]:
    """A Ray cluster of two workers on this machine."""
    pytest.importorskip("ray", reason="the extra `scale` is not installed")
    with RayEngine(jobs=2) as engine:
        yield engine


def test_ray_gives_what_processes_give(cluster: Engine) -> None:
    task = functools.partial(round, ndigits=1)
    items = [0.11, 2.22, 3.33, 4.44, 5.55]
    with LocalEngine(1) as engine:
        assert sorted(cluster.run(task, items)) == sorted(engine.run(task, items))


def test_ray_reports_errors_as_they_are_and_no_use_to_its_makers(cluster: Engine) -> None:
    assert os.environ["RAY_USAGE_STATS_ENABLED"] == "0"
    with pytest.raises(ValueError, match="not defined for negative"):
        list(cluster.run(math.factorial, [1, -1]))


def test_ray_does_again_what_a_lost_worker_did(cluster: Engine, tmp_path: Path) -> None:
    def die_once(marker: Path) -> int:
        if not marker.exists():
            marker.touch()
            os._exit(1)
        return os.getpid()

    ((place, process),) = cluster.run(die_once, [tmp_path / "died"])
    assert place == 0
    assert process != os.getpid()


def test_a_build_on_ray_has_the_bytes_of_one_on_processes(cluster: Engine, tmp_path: Path) -> None:
    assert isinstance(cluster, RayEngine)
    recipe, source = write_tiny(tmp_path)
    build_release(recipe, tmp_path / "ray", source=source, jobs=2, engine="ray")
    build_release(recipe, tmp_path / "local", source=source, jobs=1)
    assert tree(tmp_path / "ray") == tree(tmp_path / "local")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == [
        *("local", "ray", "rooms", "tiny.toml")
    ]
