"""`EpisodeStream`: what `EpisodeBatches` gives, for any number of workers, resumable."""

from __future__ import annotations

import itertools
import pickle
from typing import Any

import pytest
from tiny_episodes import Seen, TinyEpisodes, seen, seen_in
from torch.utils.data import DataLoader

from affectsim_data.loaders import EpisodeBatches, EpisodeStream, data_loader
from affectsim_data.loaders.distribution import Ends

NUM_EPISODES = 20


def stream(**options: Any) -> EpisodeStream:
    return EpisodeStream(
        TinyEpisodes(NUM_EPISODES), **{"batch_size": 3, "shuffle": True, **options}
    )


def loaded(one: EpisodeStream, num_workers: int = 0, **options: Any) -> DataLoader[Any]:
    if num_workers:
        options = {"multiprocessing_context": "fork", "timeout": 60, **options}
    return DataLoader(one, batch_size=None, num_workers=num_workers, **options)


def epochs(*numbers: int) -> Seen:
    """What `data_loader` gives in these epochs."""
    one = data_loader(TinyEpisodes(NUM_EPISODES), batch_size=3, shuffle=True)
    found: Seen = []
    for number in numbers:
        one.set_epoch(number)
        found += seen(one)
    return found


@pytest.mark.filterwarnings("ignore:This DataLoader will create 5 worker processes")
@pytest.mark.parametrize("num_workers", [0, 1, 2, 5])
@pytest.mark.parametrize("ends", ["pad", "drop", "full"])
def test_a_stream_yields_the_batches_of_the_sampler(num_workers: int, ends: Ends) -> None:
    for rank in range(3):
        options: dict[str, Any] = {"shuffle": "scenes", "window": 8, "ends": ends}
        options |= {"rank": rank, "world_size": 3}
        batches = EpisodeBatches(TinyEpisodes(NUM_EPISODES), batch_size=3, **options)
        expected = [[tuple(place[:4]) for place in batch] for batch in batches]
        one = stream(**options)
        assert [seen_in(batch) for batch in loaded(one, num_workers)] == expected
        assert len(one) == len(loaded(one, num_workers)) == len(expected)


@pytest.mark.parametrize("method", ["forkserver", "spawn"])
def test_a_stream_travels_to_workers_of_every_kind(method: str) -> None:
    one = stream()
    one.set_epoch(2)
    assert seen(loaded(one, 1, multiprocessing_context=method, timeout=120)) == epochs(2)


@pytest.mark.parametrize(("num_workers", "persistent"), [(0, False), (2, False), (2, True)])
def test_set_epoch_reaches_workers_that_are_already_running(
    num_workers: int, persistent: bool
) -> None:
    one = stream()
    loader = loaded(one, num_workers, persistent_workers=persistent)
    found: Seen = []
    for epoch in (0, 1, 4):
        one.set_epoch(epoch)
        found += seen(loader)
    assert found == epochs(0, 1, 4)
    # Nobody said otherwise: the same epoch, however the pass before ended.
    next(iter(loader))
    assert seen(loader) == epochs(4)


@pytest.mark.parametrize("num_workers", [0, 2])
@pytest.mark.parametrize("persistent", [False, True])
@pytest.mark.parametrize("stop", [0, 1, 5, 7])
def test_a_resume_gives_the_very_next_sample(num_workers: int, persistent: bool, stop: int) -> None:
    persistent = persistent and num_workers > 0
    first, whole = stream(), epochs(0, 1)
    got = seen(itertools.islice(loaded(first, num_workers), stop))
    second = stream(batch_size=2)
    loader = loaded(second, num_workers, persistent_workers=persistent)
    take_none = iter(loader)  # workers of another pass may be running already
    del take_none
    second.load_state_dict(first.state_dict(batches_taken=stop))
    got += seen(loader)
    assert got == whole[: 40 if stop == 7 else 20]
    second.set_epoch(1)
    assert seen(loader) == whole[20:]


def test_set_epoch_does_not_undo_a_resume() -> None:
    one = stream()
    one.load_state_dict({**one.state_dict(), "epoch": 3, "consumed": 12})
    one.set_epoch(3)
    assert one.state_dict()["consumed"] == 12
    assert one.state_dict(batches_taken=1)["consumed"] == 15
    one.set_epoch(4)
    assert (one.state_dict()["epoch"], one.state_dict()["consumed"]) == (4, 0)
    with pytest.raises(ValueError, match="epoch must be a whole number from 0 up, got -1"):
        one.set_epoch(-1)


def test_tokens_go_between_streams_and_loaders() -> None:
    one = data_loader(TinyEpisodes(NUM_EPISODES), batch_size=4, shuffle=True)
    got = seen(itertools.islice(one, 2))
    other = stream()
    other.load_state_dict(one.state_dict())
    assert got + seen(loaded(other)) == epochs(0)
    with pytest.raises(ValueError, match="the token is for seed=0, this loader has seed=1"):
        stream(seed=1).load_state_dict(one.state_dict())
    with pytest.raises(ValueError, match=r"batches_taken must be in \[0, 7\], .* got 8"):
        stream().state_dict(batches_taken=8)


@pytest.mark.filterwarnings("ignore:'set_vital' is deprecated")
@pytest.mark.parametrize(("num_workers", "persistent"), [(0, False), (2, False), (2, True)])
@pytest.mark.parametrize("stop", [0, 1, 2, 5, 6, 7])
def test_torchdatas_loader_resumes_a_stream_with_as_many_workers(
    num_workers: int, persistent: bool, stop: int
) -> None:
    stateful = pytest.importorskip("torchdata.stateful_dataloader")

    def loader(one: EpisodeStream) -> Any:
        return stateful.StatefulDataLoader(
            one,
            batch_size=None,
            num_workers=num_workers,
            persistent_workers=persistent,
            multiprocessing_context="fork" if num_workers else None,
        )

    one = stream()
    one.set_epoch(2)
    first = loader(one)
    got = seen(itertools.islice(first, stop))
    state = pickle.loads(pickle.dumps(first.state_dict()))
    again = stream()
    second = loader(again)
    second.load_state_dict(state)
    got += seen(second)
    assert got == epochs(2)
    again.set_epoch(3)
    assert seen(second) == epochs(3)


def test_a_batch_is_collated_as_the_user_wants() -> None:
    assert list(stream(collate_fn=len)) == [3, 3, 3, 3, 3, 3, 2]


def test_workers_are_told_which_batches_are_theirs() -> None:
    dataset = TinyEpisodes(NUM_EPISODES)
    one = EpisodeStream(dataset, batch_size=1, look_ahead=1)
    next(iter(one))
    assert dataset.asked[0].ahead == (1,)
