"""`EpisodeBatches`: epochs, what comes soon, and tokens that hold for any share of the work."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tiny_episodes import Seen, TinyEpisodes, interleaved, seen, seen_in
from torch.utils.data import DataLoader

from affectsim_data.loaders import EpisodeBatches, ResumeToken
from affectsim_data.loaders.order import Shuffle, epoch_order
from affectsim_data.loaders.places import Place


def rows(passes: EpisodeBatches) -> list[int]:
    return [place.row for batch in passes for place in batch]


def loaded(batches: EpisodeBatches, **options: Any) -> DataLoader[Any]:
    return DataLoader(TinyEpisodes(20), batch_sampler=batches, **options)


def test_batches_worked_by_hand() -> None:
    dataset = TinyEpisodes(7)
    first, second = (
        list(EpisodeBatches(dataset, batch_size=2, rank=rank, world_size=2)) for rank in (0, 1)
    )
    assert [[place.position for place in batch] for batch in first] == [[0, 1], [4, 5]]
    assert [[place.position for place in batch] for batch in second] == [[2, 3], [6, 0]]
    assert [place.padding for place in second[-1]] == [False, True]
    assert all(place.row == place.position for batch in first + second for place in batch)


def test_batches_hold_the_rows_of_the_epochs_order() -> None:
    batches = EpisodeBatches(TinyEpisodes(20), batch_size=6, shuffle=True, seed=4)
    for epoch in range(3):
        expected = epoch_order(20, seed=4, epoch=epoch, fingerprint="tiny").tolist()
        places = [place for batch in batches for place in batch]
        assert [place.row for place in places] == expected
        assert [place.position for place in places] == list(range(20))
        assert {place.epoch for place in places} == {epoch}
        assert type(places[0].row) is int


def test_a_pass_that_was_broken_off_begins_again_where_it_began() -> None:
    batches = EpisodeBatches(TinyEpisodes(20), batch_size=6, shuffle=True)
    whole = rows(batches)
    batches.set_epoch(0)
    for _ in range(2):
        one = iter(batches)
        next(one)
    assert rows(batches) == whole
    assert batches.epoch == 1
    batches.load_state_dict({**batches.state_dict(), "epoch": 0, "consumed": 6})
    next(iter(batches))
    assert rows(batches) == whole[6:]


def test_set_epoch_moves_but_does_not_undo_a_resume() -> None:
    batches = EpisodeBatches(TinyEpisodes(20), batch_size=6, shuffle=True)
    batches.set_epoch(3)
    third = rows(batches)
    assert third == epoch_order(20, seed=0, epoch=3, fingerprint="tiny").tolist()
    assert batches.epoch == 4
    batches.set_epoch(3)
    assert rows(batches) == third
    batches.load_state_dict({**batches.state_dict(), "epoch": 3, "consumed": 12})
    batches.set_epoch(3)
    assert batches.batches_left == 2
    assert rows(batches) == third[12:]
    with pytest.raises(ValueError, match="epoch must be a whole number from 0 up, got -1"):
        batches.set_epoch(-1)


def test_an_epoch_named_after_a_pass_is_where_the_token_then_stands() -> None:
    batches = EpisodeBatches(TinyEpisodes(20), batch_size=6)
    rows(batches)
    batches.set_epoch(1)
    assert batches.state_dict(batches_taken=0)["epoch"] == 1
    next(iter(batches))
    batches.set_epoch(1)  # as trainers do, after the pass began: nothing changes
    assert batches.state_dict() == batches.state_dict(batches_taken=1)
    assert batches.state_dict()["consumed"] == 6


def test_lengths() -> None:
    batches = EpisodeBatches(TinyEpisodes(20), batch_size=6)
    assert (len(batches), batches.batches_left) == (4, 4)
    batches.load_state_dict({**batches.state_dict(), "consumed": 13})
    assert (len(batches), batches.batches_left) == (4, 2)
    assert len(list(batches)) == 2
    assert batches.batches_left == 4


def test_places_say_what_the_same_worker_is_asked_for_soon() -> None:
    batches = EpisodeBatches(TinyEpisodes(20), batch_size=3, look_ahead=2, num_workers=2)
    found = list(batches)
    assert found[0][0].ahead == (6, 7, 8, 12, 13, 14)
    assert found[3][0].ahead == (15, 16, 17)
    assert found[4][0].ahead == (18, 19)
    assert found[5][0].ahead == found[6][0].ahead == ()
    assert all(not place.ahead for batch in found for place in batch[1:])
    alone = next(iter(EpisodeBatches(TinyEpisodes(20), batch_size=3, look_ahead=1)))
    assert alone[0].ahead == (3, 4, 5)
    assert not next(iter(EpisodeBatches(TinyEpisodes(20), look_ahead=0)))[0].ahead
    with pytest.raises(ValueError, match=r"look_ahead must be .* from 0 up, got -1"):
        EpisodeBatches(TinyEpisodes(20), look_ahead=-1)


# Resuming.


def run(
    dataset: TinyEpisodes, token: ResumeToken | None, steps: int, **options: Any
) -> tuple[list[Place], ResumeToken]:
    """Some steps on all ranks from a token; what they got, and the token of every rank."""
    world_size = options["world_size"]
    ranks = [EpisodeBatches(dataset, rank=rank, **options) for rank in range(world_size)]
    per_rank, tokens = [], []
    for batches in ranks:
        if token is not None:
            batches.load_state_dict(json.loads(json.dumps(token)))
        count = min(steps, batches.batches_left)
        one = iter(batches)
        per_rank.append([next(one) for _ in range(count)])
        tokens.append(batches.state_dict(batches_taken=count))
    assert all(one == tokens[0] for one in tokens)
    return interleaved(per_rank), tokens[0]


@settings(max_examples=150)
@given(
    num_episodes=st.integers(1, 120),
    shuffle=st.sampled_from([False, True, "scenes"]),
    legs=st.lists(
        st.tuples(st.integers(1, 8), st.integers(1, 9), st.integers(0, 6)), min_size=1, max_size=8
    ),
)
def test_any_schedule_of_resumes_gives_the_uninterrupted_order(
    num_episodes: int, shuffle: Shuffle, legs: list[tuple[int, int, int]]
) -> None:
    dataset = TinyEpisodes(num_episodes, num_scenes=5)
    order: dict[str, Any] = {"shuffle": shuffle, "window": 16, "seed": 2}
    token, got = None, []
    for world_size, batch_size, steps in legs:
        options = {"world_size": world_size, "batch_size": batch_size, **order}
        places, token = run(dataset, token, steps, **options)
        got += [place for place in places if not place.padding]
    uninterrupted = EpisodeBatches(dataset, rank=0, world_size=1, **order)
    expected = [place for _ in range(len(legs)) for batch in uninterrupted for place in batch]
    assert [place[:3] for place in got] == [place[:3] for place in expected[: len(got)]]
    assert token is not None
    assert (token["epoch"], token["consumed"]) == divmod(len(got), num_episodes)


def test_the_end_of_an_epoch_is_the_start_of_the_next() -> None:
    batches = EpisodeBatches(TinyEpisodes(20), batch_size=6, rank=0, world_size=1)
    rows(batches)
    token = batches.state_dict()
    assert (token["epoch"], token["consumed"]) == (1, 0)
    batches.load_state_dict({**token, "epoch": 0, "consumed": 20})
    assert batches.state_dict() == token
    # What is left is less than eight ranks can share without padding: the epoch is over.
    drop = EpisodeBatches(TinyEpisodes(20), rank=0, world_size=8, ends="drop")
    drop.load_state_dict({**token, "epoch": 4, "consumed": 13})
    assert drop.state_dict()["epoch"] == 5


def test_nothing_is_asked_for_again_to_resume() -> None:
    dataset = TinyEpisodes(10_000)
    batches = EpisodeBatches(dataset, batch_size=10, shuffle=True)
    batches.load_state_dict({**batches.state_dict(), "consumed": 9_990})
    assert len(seen(DataLoader(dataset, batch_sampler=batches))) == 10
    assert [place.position for place in dataset.asked] == list(range(9_990, 10_000))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"fingerprint": "other"}, r"for the episodes 'other' of tests/tiny, these are 'tiny'"),
        ({"seed": 1}, r"the token is for seed=1, this loader has seed=0"),
        ({"window": 7}, r"the token is for window=7, this loader has window=1024"),
        ({"shuffle": True}, r"the token is for shuffle=True, this loader has shuffle='scenes'"),
        ({"shuffle": False}, r"the token is for shuffle=False, this loader has shuffle='scenes'"),
        ({"epoch": -1}, r"token: epoch must be a whole number from 0 up, got -1"),
        ({"epoch": "2"}, r"token: epoch must be a whole number from 0 up, got '2'"),
        ({"consumed": -1}, r"token: consumed must be a whole number from 0 up, got -1"),
        ({"consumed": 1.0}, r"token: consumed must be a whole number from 0 up, got 1.0"),
        ({"consumed": 21}, r"token: consumed must be in \[0, 20\], .*got 21"),
    ],
)
def test_tokens_of_another_order_are_refused(change: dict[str, Any], message: str) -> None:
    batches = EpisodeBatches(TinyEpisodes(20), shuffle="scenes")
    before = batches.state_dict()
    with pytest.raises(ValueError, match=message):
        batches.load_state_dict({**before, **change})
    assert batches.state_dict() == before


def test_what_does_not_change_the_order_is_not_compared() -> None:
    token = EpisodeBatches(TinyEpisodes(20), shuffle=False, seed=3, window=5).state_dict()
    EpisodeBatches(TinyEpisodes(20)).load_state_dict({**token, "release": "elsewhere"})


def test_a_state_of_something_else_is_refused() -> None:
    with pytest.raises(ValueError, match=r"not a resume token, it lacks seed, .*, release: {'a'"):
        EpisodeBatches(TinyEpisodes(20)).load_state_dict({"a": 1})


def test_more_batches_than_a_pass_has_are_refused() -> None:
    batches = EpisodeBatches(TinyEpisodes(20), batch_size=6)
    with pytest.raises(ValueError, match=r"batches_taken must be in \[0, 4\], .* got 5"):
        batches.state_dict(batches_taken=5)


# Other people's loaders.


@pytest.mark.parametrize("num_workers", [0, 2])
def test_the_plain_loader_resumes_with_the_batches_its_user_took(num_workers: int) -> None:
    fork = {"num_workers": num_workers, "multiprocessing_context": "fork" if num_workers else None}
    whole = seen(loaded(EpisodeBatches(TinyEpisodes(20), batch_size=3, shuffle=True), **fork))
    batches = EpisodeBatches(TinyEpisodes(20), batch_size=3, shuffle=True, num_workers=num_workers)
    got: Seen = []
    for taken, batch in enumerate(loaded(batches, **fork), start=1):
        got += seen_in(batch)
        if taken == 5:  # with two workers the sampler has given all seven by now
            break
    token = batches.state_dict(batches_taken=taken)
    resumed = EpisodeBatches(TinyEpisodes(20), batch_size=4, shuffle=True)
    resumed.load_state_dict(token)
    assert got + seen(loaded(resumed)) == whole


@pytest.mark.filterwarnings("ignore:'set_vital' is deprecated")
@pytest.mark.parametrize(("num_workers", "persistent"), [(0, False), (2, False), (2, True)])
@pytest.mark.parametrize(
    ("batch_size", "stop"),
    [(3, 0), (3, 1), (3, 3), (3, 6), (3, 7), (3, None), (8, 0), (8, 2), (8, 3), (8, None)],
)
def test_torchdatas_loader_resumes_exactly(
    num_workers: int, persistent: bool, batch_size: int, stop: int | None
) -> None:
    stateful = pytest.importorskip("torchdata.stateful_dataloader")

    def loader() -> Any:
        batches = EpisodeBatches(TinyEpisodes(20), batch_size=batch_size, shuffle=True, seed=9)
        return stateful.StatefulDataLoader(
            TinyEpisodes(20),
            batch_sampler=batches,
            num_workers=num_workers,
            persistent_workers=persistent,
            multiprocessing_context="fork" if num_workers else None,
        )

    expected = [
        (row, epoch, position, False)
        for epoch in range(3)
        for position, row in enumerate(epoch_order(20, seed=9, epoch=epoch, fingerprint="tiny"))
    ]
    first, got = loader(), []
    one = iter(first)
    for _ in range(len(first) if stop is None else stop):
        got += seen_in(next(one))
    if stop is None:  # the end of the epoch was seen, not only its last batch
        with pytest.raises(StopIteration):
            next(one)
    state = first.state_dict()
    second = loader()
    second.load_state_dict(state)
    for _ in range(3):
        got += seen(second)
    assert got[: len(expected)] == expected
