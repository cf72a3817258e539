"""`data_loader`: goes from epoch to epoch and resumes where its user was, not its workers."""

from __future__ import annotations

import gc
import itertools
import json
import multiprocessing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tiny_episodes import Seen, TinyEpisodes, interleaved, seen, seen_in
from torch.utils.data import default_collate

from affectsim_data import AffectSimDataset, Clip, Sample
from affectsim_data.loaders import EpisodeBatches, EpisodeLoader, data_loader
from affectsim_data.loaders.batches import DEFAULT_WINDOW
from affectsim_data.loaders.order import EpisodeOrder, Shuffle, epoch_order

NUM_EPISODES = 20
CONFIGURATIONS = [(0, False), (1, False), (2, False), (2, True)]


def loader(num_workers: int = 0, persistent: bool = False, **options: Any) -> EpisodeLoader:
    """A loader of 20 episodes in 7 batches, shuffled; forked workers start fast."""
    return data_loader(
        TinyEpisodes(NUM_EPISODES),
        **{
            "batch_size": 3,
            "shuffle": True,
            "num_workers": num_workers,
            "persistent_workers": persistent,
            "multiprocessing_context": "fork" if num_workers else None,
            "timeout": 60 if num_workers else 0,
            **options,
        },
    )


def epochs(count: int, **options: Any) -> Seen:
    """What an undisturbed run of whole epochs sees."""
    one = loader(**options)
    return [sample for _ in range(count) for sample in seen(one)]


def take(batches: Iterator[Any], count: int) -> Seen:
    return seen(itertools.islice(batches, count))


def test_the_union_of_epochs_is_shuffled_anew_without_set_epoch() -> None:
    found = epochs(3)
    for epoch in range(3):
        part = found[epoch * NUM_EPISODES : (epoch + 1) * NUM_EPISODES]
        expected = epoch_order(NUM_EPISODES, seed=0, epoch=epoch, fingerprint="tiny").tolist()
        assert [row for row, *_ in part] == expected
        assert {number for _, number, *_ in part} == {epoch}


@pytest.mark.parametrize("shuffle", [False, True, "scenes"])
def test_the_order_depends_on_neither_workers_nor_batch_size(shuffle: Shuffle) -> None:
    expected = epochs(2, shuffle=shuffle)
    assert epochs(2, shuffle=shuffle, num_workers=2, persistent=True) == expected
    assert epochs(2, shuffle=shuffle, num_workers=1, batch_size=7) == expected
    if shuffle is False:
        assert [row for row, *_ in expected] == [*range(NUM_EPISODES), *range(NUM_EPISODES)]


@pytest.mark.parametrize(("num_workers", "persistent"), CONFIGURATIONS)
@pytest.mark.parametrize("stop", [0, 1, 4, 6, 7])
def test_a_resume_gives_the_very_next_sample(num_workers: int, persistent: bool, stop: int) -> None:
    first = loader(num_workers, persistent)
    got = take(iter(first), stop)
    token = json.loads(json.dumps(first.state_dict()))
    assert token["consumed"] == (3 * stop if stop < 7 else 0)
    second = loader(num_workers, persistent, resume=token)
    assert second.state_dict() == token
    got += seen(second)
    got += seen(second)
    assert got == epochs(3)[: len(got)]
    assert second.epoch == (2 if stop < 7 else 3)


@pytest.mark.parametrize(("num_workers", "persistent"), CONFIGURATIONS)
def test_what_was_fetched_ahead_does_not_count(num_workers: int, persistent: bool) -> None:
    one = loader(num_workers, persistent)
    whole = epochs(2)
    # Two workers are given four batches ahead: the sampler has been run through by the fifth.
    assert take(iter(one), 5) == whole[:15]
    assert (one.epoch, one.state_dict()["consumed"]) == (0, 15)
    assert seen(one) == whole[:NUM_EPISODES]
    assert one.epoch == 1
    assert seen(one) == whole[NUM_EPISODES:]


@pytest.mark.parametrize(("num_workers", "persistent"), CONFIGURATIONS)
def test_the_last_batch_ends_the_epoch_though_nobody_asks_for_one_more(
    num_workers: int, persistent: bool
) -> None:
    one = loader(num_workers, persistent)
    got = take(iter(one), 6)
    assert one.epoch == 0
    got = take(iter(one), 7)
    assert one.epoch == 1
    assert (one.state_dict()["epoch"], one.state_dict()["consumed"]) == (1, 0)
    assert got + take(iter(one), 7) == epochs(2)


def test_iterators_may_follow_one_another() -> None:
    one, whole = loader(2), epochs(1)
    first, second = iter(one), iter(one)
    assert take(first, 2) == whole[:6]
    assert take(second, 1) == whole[:3]
    assert one.state_dict()["consumed"] == 3  # the newest pass is the one in progress
    assert take(first, 9) == whole[6:]
    assert (one.epoch, one.state_dict()["consumed"]) == (0, 3)
    assert take(second, 9) == whole[3:]
    assert one.epoch == 1


@pytest.mark.parametrize("persistent", [False, True])
def test_workers_end_with_the_loop_that_was_broken_off(persistent: bool) -> None:
    one, others = loader(2, persistent), set(multiprocessing.active_children())
    gc.disable()  # what ends them must not be a matter of luck
    try:
        for _ in one:
            break
        assert len(set(multiprocessing.active_children()) - others) == (2 if persistent else 0)
        del one
        assert not set(multiprocessing.active_children()) - others
    finally:
        gc.enable()


def test_persistent_workers_serve_one_iterator_at_a_time() -> None:
    one = loader(2, persistent=True)
    first = iter(one)
    next(first)
    second = iter(one)
    with pytest.raises(RuntimeError, match=r"a newer iterator .* taken its persistent workers"):
        next(first)
    assert seen(second) == epochs(1)


def test_set_epoch_leaves_the_order_of_epochs() -> None:
    one = loader(2, persistent=True)
    take(iter(one), 6)
    one.set_epoch(5)
    assert (one.epoch, one.state_dict()["consumed"]) == (5, 0)
    expected = epoch_order(NUM_EPISODES, seed=0, epoch=5, fingerprint="tiny").tolist()
    assert [row for row, *_ in seen(one)] == expected
    assert one.epoch == 6


def test_set_epoch_to_the_epoch_in_progress_changes_nothing() -> None:
    one = loader(2, resume={**loader().state_dict(), "epoch": 4, "consumed": 6})
    one.set_epoch(4)
    batches = iter(one)
    one.set_epoch(4)
    take(batches, 1)
    one.set_epoch(4)
    assert (one.epoch, one.state_dict()["consumed"]) == (4, 9)


def test_a_token_loaded_in_mid_pass_is_where_the_loader_stands() -> None:
    one = loader(2)
    batches = iter(one)
    take(batches, 3)
    token = {**one.state_dict(), "epoch": 2, "consumed": 12}
    one.load_state_dict(token)
    take(batches, 9)  # the old pass may run out, it is not the loader's any more
    assert one.state_dict() == token
    assert len(seen(one)) == 8


def test_lengths_are_those_of_an_epoch_and_what_is_left_of_it() -> None:
    one = loader(resume={**loader().state_dict(), "consumed": 12})
    assert (len(one), one.batches_left) == (7, 3)
    assert len(list(one)) == 3
    assert (len(one), one.batches_left) == (7, 7)


@pytest.mark.filterwarnings("ignore:This DataLoader will create 5 worker processes")
@pytest.mark.parametrize("shuffle", [True, "scenes"])
def test_three_resumes_in_an_epoch_with_other_worlds_workers_and_batches(shuffle: Shuffle) -> None:
    num_episodes, token = 211, None
    got: Seen = []
    order: dict[str, Any] = {"shuffle": shuffle, "window": 64, "seed": 8}
    schedule = [(2, 2, 7, 3), (3, 0, 5, 2), (8, 1, 3, 2), (1, 5, 10, None)]
    for world_size, num_workers, batch_size, steps in schedule:
        per_rank, tokens = [], []
        for rank in range(world_size):
            one = data_loader(
                TinyEpisodes(num_episodes),
                batch_size=batch_size,
                rank=rank,
                world_size=world_size,
                resume=token,
                num_workers=num_workers,
                multiprocessing_context="fork" if num_workers else None,
                **order,
            )
            per_rank.append([seen_in(batch) for batch in itertools.islice(one, steps)])
            tokens.append(one.state_dict())
        assert all(other == tokens[0] for other in tokens)
        token = tokens[0]
        got += [sample for sample in interleaved(per_rank) if not sample[3]]
    alone = seen(data_loader(TinyEpisodes(num_episodes), rank=0, world_size=1, **order))
    assert got == alone
    assert token is not None
    assert (token["epoch"], token["consumed"]) == (1, 0)


def test_workers_start_clean_unless_the_user_says_how() -> None:
    one = data_loader(TinyEpisodes(8), batch_size=4, num_workers=1, timeout=120)
    assert one.multiprocessing_context.get_start_method() == "forkserver"
    assert [row for row, *_ in seen(one)] == list(range(8))
    assert loader(1).multiprocessing_context.get_start_method() == "fork"


def rows_only(samples: list[dict[str, Any]]) -> Any:
    return default_collate([sample["row"] for sample in samples])


def test_options_are_those_of_the_stock_loader() -> None:
    one = loader(2, collate_fn=rows_only, prefetch_factor=1)
    assert [row for batch in one for row in batch.tolist()] == [row for row, *_ in epochs(1)]
    with pytest.raises(TypeError, match="unexpected keyword argument 'batchsize'"):
        loader(batchsize=3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"sampler": [1]}, r"data_loader takes no sampler: .* dataset.subset\(...\)"),
        ({"batch_sampler": [[1]]}, r"data_loader takes no batch_sampler: .* stock"),
        ({"drop_last": True}, r"data_loader takes no drop_last: .* ends='full'"),
        ({"in_order": False}, r"takes no in_order=False: a resume needs batches in order"),
        ({"batch_size": None}, r"batch_size must be .* from 1 up, got None"),
        ({"shuffle": "scene"}, r"shuffle must be False, True or 'scenes', got 'scene'"),
        ({"resume": {}}, r"not a resume token, it lacks seed, epoch"),
    ],
)
def test_contradictions_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        loader(**options)


def test_options_that_say_nothing_are_let_through() -> None:
    assert len(loader(drop_last=False, sampler=None, batch_sampler=None)) == 7


def test_workers_are_told_which_batches_are_theirs() -> None:
    one = loader(2, batch_size=1, shuffle=False, look_ahead=1)
    assert isinstance(one.batches, EpisodeBatches)
    assert [batch[0].ahead for batch in one.batches][:2] == [(2,), (3,)]


class Failing(TinyEpisodes):
    """Cannot read its sixth episode."""

    def __getitem__(self, place: Any) -> dict[str, Any]:
        if place.row == 5:
            raise OSError("the sixth episode is gone")
        return super().__getitem__(place)


@pytest.mark.parametrize("num_workers", [0, 2])
def test_a_batch_that_failed_was_not_had(num_workers: int) -> None:
    one = data_loader(
        Failing(12),
        batch_size=2,
        num_workers=num_workers,
        multiprocessing_context="fork" if num_workers else None,
    )
    batches = iter(one)
    take(batches, 2)
    with pytest.raises(OSError, match="the sixth episode is gone"):
        next(batches)
    assert one.state_dict()["consumed"] == 4


def place_of(sample: Sample) -> tuple[str, int, int, bool]:
    return sample["episode_id"], sample["epoch"], sample["position"], sample["padding"]


def as_they_are(samples: list[Any]) -> list[Any]:
    return samples


@pytest.mark.egl
def test_drawn_samples_say_their_place_and_resume(small_release_path: Path) -> None:
    dataset = AffectSimDataset(
        small_release_path,
        split="train",
        condition="p_init",
        clip=Clip(num_frames=1, width=16, height=16),
        transform=place_of,
    )
    order = EpisodeOrder(dataset, shuffle="scenes", window=DEFAULT_WINDOW, seed=0)
    expected = [
        (dataset.episode(int(row)).episode_id, epoch, position, False)
        for epoch in range(2)
        for position, row in enumerate(order.rows(epoch))
    ]
    options: dict[str, Any] = {"shuffle": "scenes", "collate_fn": as_they_are}
    first = data_loader(dataset, num_workers=1, timeout=120, **options)
    got = [one for batch in itertools.islice(first, 1) for one in batch]
    second = data_loader(dataset, batch_size=2, resume=first.state_dict(), **options)
    got += [one for _ in range(2) for batch in second for one in batch]
    assert got == expected
    assert second.state_dict()["release"] == dataset.source
