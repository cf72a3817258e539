"""Ranks and workers: together they get everything once, and all of them equally much."""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tiny_episodes import TinyEpisodes, interleaved, seen_in

from affectsim_data.loaders import EpisodeBatches, data_loader
from affectsim_data.loaders.distribution import Ends, Rank, Share, find_rank
from affectsim_data.loaders.places import Place
from affectsim_data.render.egl import EglDevice, choose_device

WORLDS, WORKERS, BATCH_SIZES = (1, 2, 3, 8), (0, 1, 2, 5), (1, 7, 32)
ENDS: tuple[Ends, ...] = ("pad", "drop", "full")
NUM_EPISODES = 517  # 517 = 2 * 256 + 5: uneven for every world and batch size above 1
GRID = list(itertools.product(WORLDS, BATCH_SIZES, ENDS))


def left_out(num_episodes: int, world_size: int, batch_size: int, ends: str) -> int:
    """How many episodes an epoch leaves out, as the documentation states it."""
    whole = {"pad": 1, "drop": world_size, "full": world_size * batch_size}[ends]
    return num_episodes % whole


def check_union(per_rank: list[list[list[Place]]], num_episodes: int, share: Share) -> None:
    """Everything once, in the global order, in equal parts; nothing twice but what is marked."""
    sizes = [[len(batch) for batch in batches] for batches in per_rank]
    assert all(one == sizes[0] for one in sizes)
    places = interleaved(per_rank)
    real = [place.position for place in places if not place.padding]
    missing = left_out(num_episodes, share.world_size, share.batch_size, share.ends)
    assert real == list(range(num_episodes - missing))
    padding = [place.position for place in places if place.padding]
    assert len(padding) < share.world_size
    assert padding == [number % num_episodes for number in range(len(padding))]
    assert share.ends == "pad" or not padding


@pytest.mark.parametrize("shuffle", [False, True, "scenes"])
@pytest.mark.parametrize(("world_size", "batch_size", "ends"), GRID)
def test_the_union_over_ranks_is_the_split(
    world_size: int, batch_size: int, ends: Ends, shuffle: Any
) -> None:
    dataset = TinyEpisodes(NUM_EPISODES)
    options: dict[str, Any] = {"batch_size": batch_size, "ends": ends, "shuffle": shuffle}
    per_rank = [
        list(EpisodeBatches(dataset, rank=rank, world_size=world_size, **options))
        for rank in range(world_size)
    ]
    share = Share(NUM_EPISODES, batch_size, 0, world_size, ends)
    check_union(per_rank, NUM_EPISODES, share)
    alone = [p for one in EpisodeBatches(dataset, rank=0, world_size=1, **options) for p in one]
    row_at = {place.position: place.row for place in alone}
    everything = [place for batches in per_rank for batch in batches for place in batch]
    assert all(row_at.get(place.position, place.row) == place.row for place in everything)


def workers_of(number: int, rank: int) -> int:
    """Other numbers of workers for neighbours in the grid, and for the ranks of one world."""
    return WORKERS[(number + number // len(WORKERS) + rank) % len(WORKERS)]


def test_every_world_batch_and_end_meets_every_number_of_real_workers() -> None:
    met = {
        (value, workers_of(number, rank))
        for number, combination in enumerate(GRID)
        for rank in range(combination[0])
        for value in (f"world {combination[0]}", *combination[1:])
    }
    values = [*(f"world {world}" for world in WORLDS), *BATCH_SIZES, *ENDS]
    assert met == set(itertools.product(values, WORKERS))


@pytest.mark.filterwarnings("ignore:This DataLoader will create 5 worker processes")
@pytest.mark.parametrize("number", range(len(GRID)))
def test_the_union_over_ranks_and_real_workers_is_the_split(number: int) -> None:
    world_size, batch_size, ends = GRID[number]
    dataset = TinyEpisodes(61 if batch_size < 32 else NUM_EPISODES)
    per_rank = []
    for rank in range(world_size):
        num_workers = workers_of(number, rank)
        loader = data_loader(
            dataset,
            batch_size=batch_size,
            shuffle=True,
            rank=rank,
            world_size=world_size,
            ends=ends,
            num_workers=num_workers,
            multiprocessing_context="fork" if num_workers else None,
            timeout=60 if num_workers else 0,
        )
        batches = [[Place(*sample) for sample in seen_in(batch)] for batch in loader]
        assert len(batches) == len(loader)
        per_rank.append(batches)
    check_union(per_rank, len(dataset), Share(len(dataset), batch_size, 0, world_size, ends))


@settings(max_examples=300)
@given(
    num_episodes=st.integers(1, 200),
    batch_size=st.integers(1, 20),
    world_size=st.integers(1, 12),
    ends=st.sampled_from(ENDS),
    consumed=st.integers(0, 200),
)
def test_shares_are_equal_and_complete_from_any_point(
    num_episodes: int, batch_size: int, world_size: int, ends: Ends, consumed: int
) -> None:
    consumed = min(consumed, num_episodes)
    try:
        shares = [
            Share(num_episodes, batch_size, rank, world_size, ends) for rank in range(world_size)
        ]
    except ValueError:
        assert num_episodes < {"pad": 1, "drop": world_size}.get(ends, world_size * batch_size)
        return
    parts = [
        [share.positions(consumed, number) for number in range(share.num_batches(consumed))]
        for share in shares
    ]
    assert len({tuple(len(part) for part in rank) for rank in parts}) == 1
    assert all(0 < len(part) <= batch_size for rank in parts for part in rank)
    positions = interleaved(parts)
    assert positions == list(range(consumed, consumed + len(positions)))
    missing = left_out(num_episodes - consumed, world_size, batch_size, ends)
    assert len([one for one in positions if one < num_episodes]) == (
        num_episodes - consumed - missing
    )
    assert max(positions, default=0) < num_episodes + world_size - 1


def test_fewer_episodes_than_ranks() -> None:
    per_rank = [
        list(EpisodeBatches(TinyEpisodes(3), rank=rank, world_size=8, batch_size=2))
        for rank in range(8)
    ]
    assert [batches[0][0].row for batches in per_rank] == [0, 1, 2, 0, 1, 2, 0, 1]
    assert [batches[0][0].padding for batches in per_rank] == [False] * 3 + [True] * 5
    for ends in ENDS[1:]:
        with pytest.raises(ValueError, match=f"ends='{ends}' leaves nothing of 3 .* 8 ranks"):
            EpisodeBatches(TinyEpisodes(3), rank=0, world_size=8, ends=ends)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"batch_size": 0}, "batch_size must be a number of samples from 1 up, got 0"),
        ({"batch_size": None}, "batch_size must be a number of samples from 1 up, got None"),
        ({"ends": "trim"}, "ends must be one of pad, drop, full, got 'trim'"),
        ({"ends": "full", "batch_size": 8}, "ends='full' leaves nothing of 7 episodes"),
        ({"rank": 2, "world_size": 2}, r"rank must be in \[0, world_size\).* rank=2, world_size=2"),
        ({"rank": -1, "world_size": 2}, r"got rank=-1, world_size=2"),
        ({"rank": 0}, r"both be given or neither, got rank=0, world_size=None"),
        ({"world_size": 2}, r"both be given or neither, got rank=None, world_size=2"),
    ],
)
def test_impossible_shares_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        EpisodeBatches(TinyEpisodes(7), **options)


def test_a_trainer_that_would_share_the_batches_again_is_stopped() -> None:
    batches = data_loader(TinyEpisodes(7), rank=0, world_size=2).batch_sampler
    with pytest.raises(ValueError, match=r"one rank and cannot be sharded again; do not pass"):
        getattr(batches, "drop_last", False)  # the words of Accelerate's BatchSamplerShard


def test_the_rank_is_the_given_one_else_the_only_one() -> None:
    assert find_rank(3, 8) == Rank(3, 8, given=True)
    assert find_rank(environment={}) == Rank(0, 1, given=False)
    assert find_rank(environment={"WORLD_SIZE": "1"}) == Rank(0, 1, given=False)
    assert find_rank(0, 1, environment={"WORLD_SIZE": "4"}) == Rank(0, 1, given=True)


def test_processes_that_do_not_know_of_one_another_are_refused() -> None:
    with pytest.raises(ValueError, match=r"WORLD_SIZE is 4, .* call init_process_group before"):
        find_rank(environment={"WORLD_SIZE": "4"})


_RANK = """
import datetime, json, sys
import torch
from torch import distributed
from tiny_episodes import TinyEpisodes, seen_in
from affectsim_data.loaders import EpisodeBatches, EpisodeStream, data_loader

rank, world_size, store = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
early = EpisodeBatches(TinyEpisodes(5))
early_stream = EpisodeStream(TinyEpisodes(5))
distributed.init_process_group(
    "gloo", init_method=f"file://{store}", rank=rank, world_size=world_size,
    timeout=datetime.timedelta(seconds=60),
)
refusals = []
for one in (early, early_stream):
    try:
        iter(one)
    except ValueError as error:
        refusals.append(str(error))
passes = []
for ends in ("pad", "drop", "full"):
    dataset = TinyEpisodes(3 * 7 * world_size + world_size + 1)
    loader = data_loader(
        dataset, batch_size=7, shuffle=True, ends=ends, num_workers=rank,
        multiprocessing_context="fork" if rank else None,
    )
    steps = []
    for batch in loader:
        count = torch.tensor([len(batch["row"])])
        distributed.all_reduce(count)
        steps.append((int(count), seen_in(batch)))
    passes.append(steps)
distributed.barrier()
distributed.destroy_process_group()
print(json.dumps({"refusals": refusals, "passes": passes}))
"""


@pytest.mark.parametrize("world_size", [2, 3])
def test_real_processes_keep_in_step_to_the_uneven_end(world_size: int, tmp_path: Path) -> None:
    command = [sys.executable, "-c", _RANK]
    processes = [
        subprocess.Popen(
            [*command, str(rank), str(world_size), str(tmp_path / "store")],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for rank in range(world_size)
    ]
    try:
        printed = [process.communicate(timeout=120) for process in processes]
    finally:
        for process in processes:
            process.kill()
    assert all(not process.returncode for process in processes), [err for _, err in printed]
    found = [json.loads(out.splitlines()[-1]) for out, _ in printed]
    message = f"made for rank 0 of 1, but torch.distributed says rank 1 of {world_size}"
    assert [message in one for one in found[1]["refusals"]] == [True, True]
    num_episodes = 3 * 7 * world_size + world_size + 1
    for number, ends in enumerate(ENDS):
        per_rank = [
            [[Place(*sample) for sample in samples] for _, samples in one["passes"][number]]
            for one in found
        ]
        check_union(per_rank, num_episodes, Share(num_episodes, 7, 0, world_size, ends))
        for one in found:
            assert all(total == world_size * len(part) for total, part in one["passes"][number])


# The GPU of each process.

SOFTWARE = "EGL_MESA_device_software EGL_EXT_device_drm_render_node"
NVIDIA, OTHER = "EGL_NV_device_cuda EGL_EXT_device_drm", "EGL_EXT_device_drm"


def devices(*extensions: str) -> list[EglDevice]:
    return [EglDevice(index, one, index + 1) for index, one in enumerate(extensions)]


@pytest.mark.parametrize(
    ("extensions", "environment", "expected"),
    [
        ((NVIDIA, NVIDIA, SOFTWARE), {}, None),
        ((NVIDIA, NVIDIA, SOFTWARE), {"LOCAL_RANK": "0"}, 0),
        ((NVIDIA, NVIDIA, SOFTWARE), {"LOCAL_RANK": "3"}, 1),
        ((SOFTWARE, NVIDIA, NVIDIA), {"LOCAL_RANK": "1"}, 2),
        ((OTHER, NVIDIA, NVIDIA), {"LOCAL_RANK": "0"}, 1),
        ((OTHER, OTHER), {"LOCAL_RANK": "1"}, 1),
        ((NVIDIA, OTHER, SOFTWARE), {"LOCAL_RANK": "1"}, None),
        ((NVIDIA, SOFTWARE), {"LOCAL_RANK": "1"}, None),
        ((SOFTWARE,), {"LOCAL_RANK": "1"}, None),
        ((NVIDIA, NVIDIA), {"LOCAL_RANK": "1", "AFFECTSIM_EGL_DEVICE": "0"}, 0),
        ((NVIDIA, NVIDIA), {"LOCAL_RANK": "", "AFFECTSIM_EGL_DEVICE": ""}, None),
        ((), {"AFFECTSIM_EGL_DEVICE": "5"}, 5),
    ],
)
def test_local_ranks_take_turns_on_the_gpus(
    extensions: tuple[str, ...], environment: dict[str, str], expected: int | None
) -> None:
    assert choose_device(devices(*extensions), environment) == expected


@pytest.mark.parametrize("name", ["AFFECTSIM_EGL_DEVICE", "LOCAL_RANK"])
def test_a_device_that_is_no_number_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} must be .*, got 'one'"):
        choose_device(devices(NVIDIA, NVIDIA), {name: "one"})
