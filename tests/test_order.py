"""The order of an epoch: fixed for ever, uniform, and grouped by scene within bounds."""

from __future__ import annotations

import hashlib
import itertools
from collections import Counter
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from tiny_episodes import TinyEpisodes

from affectsim_data.loaders.order import EpisodeOrder, epoch_order, scene_aware

GOLDEN = [5, 4, 2, 6, 8, 0, 3, 9, 1, 7]


def philox_words(key: tuple[int, int], count: int) -> list[int]:
    """Philox-4x64-10 as Salmon et al. (2011) write it; NumPy's first block has counter 1."""
    mask, words = 2**64 - 1, []
    for block in itertools.count(1):
        c, (k0, k1) = [block, 0, 0, 0], key
        for _ in range(10):
            left, right = 0xD2E7470EE14C6C93 * c[0], 0xCA5A826395121157 * c[2]
            c = [(right >> 64) ^ c[1] ^ k0, right & mask, (left >> 64) ^ c[3] ^ k1, left & mask]
            k0, k1 = (k0 + 0x9E3779B97F4A7C15) & mask, (k1 + 0xBB67AE8584CAA73B) & mask
        words.extend(c)
        if len(words) >= count:
            return words[:count]
    raise AssertionError


def grouped(order: list[int], scenes: list[int], window: int) -> list[int]:
    """`scene_aware`, said plainly."""
    out: list[int] = []
    for start in range(0, len(order), window):
        rows = order[start : start + window]
        for scene in dict.fromkeys(scenes[row] for row in rows):
            out += [row for row in rows if scenes[row] == scene]
    return out


def test_the_order_is_the_one_it_always_was() -> None:
    assert epoch_order(10, seed=7, epoch=3, fingerprint="abc").tolist() == GOLDEN


def test_the_order_sorts_the_words_of_a_philox_keyed_by_a_hash() -> None:
    digest = hashlib.sha256(b"7 3 abc").digest()
    key = (int.from_bytes(digest[:8], "little"), int.from_bytes(digest[8:16], "little"))
    words = philox_words(key, 10)
    assert sorted(range(10), key=words.__getitem__) == GOLDEN


@given(n=st.integers(0, 300), seed=st.integers(0, 2**80), epoch=st.integers(0, 2**40))
def test_every_episode_comes_once(n: int, seed: int, epoch: int) -> None:
    order = epoch_order(n, seed=seed, epoch=epoch, fingerprint="f")
    assert order.dtype == np.int64
    assert sorted(order.tolist()) == list(range(n))
    again = epoch_order(n, seed=seed, epoch=epoch, fingerprint="f")
    assert np.array_equal(order, again)


def test_seed_epoch_and_fingerprint_each_change_the_order() -> None:
    orders = [
        epoch_order(50, seed=seed, epoch=epoch, fingerprint=fingerprint).tolist()
        for seed, epoch, fingerprint in itertools.product((0, 1, 11), (0, 1, 11), ("", "1", "a"))
    ]
    assert len({tuple(order) for order in orders}) == 27


def test_all_orders_are_equally_likely() -> None:
    epochs = 4800
    counts = Counter(
        tuple(epoch_order(4, seed=0, epoch=epoch, fingerprint="f").tolist())
        for epoch in range(epochs)
    )
    expected = epochs / 24
    permutations = itertools.permutations(range(4))
    chi_square = sum((counts[one] - expected) ** 2 / expected for one in permutations)
    assert chi_square < 49.7  # 23 degrees of freedom, p = 0.001
    assert chi_square > 7.5  # nor more even than chance, p = 0.999


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"seed": -1}, r"seed must be a whole number from 0 up, got -1"),
        ({"seed": 0.5}, r"seed must be a whole number from 0 up, got 0.5"),
        ({"epoch": -2}, r"epoch must be a whole number from 0 up, got -2"),
        ({"num_episodes": -3}, r"num_episodes must be a whole number from 0 up, got -3"),
    ],
)
def test_numbers_out_of_range_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        epoch_order(**{"num_episodes": 3, "seed": 0, "epoch": 0, "fingerprint": "f", **options})


def test_a_window_worked_by_hand() -> None:
    scenes = [5, -1, 5, -1, 5, -1]
    # Windows (0 1 2 3) and (4 5): scene 5 comes first in both.
    assert scene_aware(range(6), scenes, window=4).tolist() == [0, 2, 1, 3, 4, 5]
    assert scene_aware([1, 0, 3, 2, 5, 4], scenes, window=6).tolist() == [1, 3, 5, 0, 2, 4]


@given(st.data(), st.integers(1, 40))
def test_scenes_are_grouped_inside_windows_and_nothing_moves_far(
    data: st.DataObject, window: int
) -> None:
    order = data.draw(st.permutations(range(data.draw(st.integers(0, 60)))))
    scenes = data.draw(
        st.lists(st.integers(-2, 4), min_size=len(order), max_size=len(order)), label="scenes"
    )
    found = scene_aware(order, scenes, window=window).tolist()
    assert found == grouped(list(order), scenes, window)
    assert sorted(found) == sorted(order)
    places: NDArray[np.int64] = np.argsort(found)[list(order)] - np.arange(len(order))
    assert not len(places) or int(np.abs(places).max()) < window


def test_a_window_of_one_is_the_plain_shuffle() -> None:
    order = epoch_order(40, seed=0, epoch=0, fingerprint="f")
    assert np.array_equal(scene_aware(order, np.arange(40) % 3, window=1), order)


def test_a_window_of_everything_opens_each_scene_once() -> None:
    order, scenes = epoch_order(60, seed=0, epoch=0, fingerprint="f"), np.arange(60) % 7
    found = scenes[scene_aware(order, scenes, window=1000)]
    assert int((found[1:] != found[:-1]).sum()) == 6


@pytest.mark.parametrize("window", [0, -1, 1.5])
def test_a_window_below_one_is_refused(window: Any) -> None:
    with pytest.raises(ValueError, match=f"window must be .* from 1 up, got {window}"):
        scene_aware([0, 1], [0, 0], window=window)


def test_one_scene_per_episode_is_asked_for() -> None:
    with pytest.raises(ValueError, match=r"one scene per episode, \(3,\), got \(2,\)"):
        scene_aware([0, 1, 2], [0, 0], window=2)


def test_without_shuffling_the_order_is_the_table_in_every_epoch() -> None:
    order = EpisodeOrder(TinyEpisodes(9), shuffle=False, window=4, seed=3)
    assert order.rows(0).tolist() == order.rows(5).tolist() == list(range(9))


def test_the_order_of_a_dataset_is_the_pure_function() -> None:
    dataset = TinyEpisodes(30, num_scenes=4, fingerprint="abc")
    plain = epoch_order(30, seed=7, epoch=2, fingerprint="abc")
    shuffled = EpisodeOrder(dataset, shuffle=True, window=10, seed=7)
    assert np.array_equal(shuffled.rows(2), plain)
    scenes = EpisodeOrder(dataset, shuffle="scenes", window=10, seed=7)
    assert np.array_equal(scenes.rows(2), scene_aware(plain, dataset.scene_codes, window=10))
    assert not np.array_equal(scenes.rows(3), scenes.rows(2))


@pytest.mark.parametrize(
    ("dataset", "options", "message"),
    [
        ([1, 2], {}, r"fingerprint, scene_codes and source: AffectSimDataset.*got list"),
        (TinyEpisodes(0), {}, r"tests/tiny: there is no episode to load"),
        (TinyEpisodes(3), {"shuffle": "scene"}, r"shuffle must be .*'scenes', got 'scene'"),
        (TinyEpisodes(3), {"shuffle": 1}, r"shuffle must be .*'scenes', got 1"),
        (TinyEpisodes(3), {"window": 0}, r"window must be .* from 1 up, got 0"),
        (TinyEpisodes(3), {"seed": -1}, r"seed must be .* from 0 up, got -1"),
    ],
)
def test_what_cannot_be_ordered_is_refused(
    dataset: Any, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        EpisodeOrder(dataset, **{"shuffle": True, "window": 4, "seed": 0, **options})
