"""Which slots are tried in which scene: every one, once, and in as few rounds as may be."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence

from hypothesis import given
from hypothesis import strategies as st

from affectsim_data.builders.placement import Unplaced
from affectsim_data.builders.scheduling import Batch, place_slots
from affectsim_data.builders.slots import Slot
from affectsim_data.schemas import Challenge

SCENES = [f"home{number}" for number in range(9)]


def slot(number: int) -> Slot:
    """One of two kinds."""
    kind: Challenge = "rear_view" if number % 2 else "far_visible"
    key = f"p{number}/scenario/0/{kind}/0"
    return Slot(key, "train", "observation_controlled", kind, "scenario", "floor", (f"m{number}",))


class Record:
    """Runs rounds, and keeps what was asked for; a rule says which scenes hold which slots."""

    def __init__(self, holds: Callable[[str, Slot], bool]) -> None:
        self.holds = holds
        self.rounds: list[list[Batch]] = []

    def __call__(self, batches: Sequence[Batch]) -> Iterator[list[Unplaced]]:
        self.rounds.append(list(batches))
        for batch in batches:
            yield [
                Unplaced(one.key, f"no room in {batch.scene_id}", {})
                for one in batch.slots
                if not self.holds(batch.scene_id, one)
            ]

    def tried(self) -> Counter[tuple[str, str]]:
        """How often each slot was tried in each scene."""
        return Counter(
            (batch.scene_id, one.key)
            for batches in self.rounds
            for batch in batches
            for one in batch.slots
        )


@given(
    st.integers(1, 40), st.integers(1, 9), st.sets(st.tuples(st.integers(0, 8), st.integers(0, 39)))
)
def test_slots_are_placed_if_any_scene_holds_them_and_tried_nowhere_twice(
    num_slots: int, num_scenes: int, room: set[tuple[int, int]]
) -> None:
    slots, scenes = [slot(number) for number in range(num_slots)], SCENES[:num_scenes]
    homes = {(SCENES[scene], slot(number).key) for scene, number in room}
    record = Record(lambda scene, one: (scene, one.key) in homes)
    unplaced = place_slots(slots, scenes, seed=1, run=record)
    hopeless = [one.key for one in slots if not any((scene, one.key) in homes for scene in scenes)]
    assert [one.key for one in unplaced] == hopeless
    assert set(record.tried().values()) <= {1}
    for key in hopeless:
        assert {scene for scene, tried in record.tried() if tried == key} == set(scenes)


def test_scenes_are_drawn_evenly_and_the_same_every_time() -> None:
    slots = [slot(number) for number in range(900)]
    first, second = Record(lambda *_: True), Record(lambda *_: True)
    for record in (first, second):
        assert place_slots(slots, SCENES, seed=1, run=record) == []
    assert first.rounds == second.rounds
    counts = Counter(scene for scene, _ in first.tried())
    assert all(60 <= counts[scene] <= 140 for scene in SCENES)
    other = Record(lambda *_: True)
    place_slots(slots, SCENES, seed=2, run=other)
    assert other.rounds != first.rounds


def test_the_second_try_is_where_such_slots_found_room() -> None:
    slots = [slot(number) for number in range(200)]
    record = Record(lambda scene, one: one.challenge == "far_visible" or scene == "home4")
    place_slots(slots, SCENES, seed=1, run=record)
    assert len(record.rounds) == 2
    assert {batch.scene_id for batch in record.rounds[1]} == {"home4"}


def test_few_slots_left_meet_in_few_scenes() -> None:
    slots = [slot(number) for number in range(60)]
    lost = {one.key for one in slots[:5]}
    record = Record(lambda scene, one: one.key not in lost)
    place_slots(slots, SCENES, seed=1, run=record)
    assert all(len(batches) <= 4 for batches in record.rounds[1:])


def test_many_slots_of_a_scene_are_parted() -> None:
    slots = [slot(number) for number in range(300)]
    record = Record(lambda *_: True)
    place_slots(slots, SCENES[:1], seed=1, run=record)
    (batches,) = record.rounds
    assert len(batches) > 1
    assert [one for batch in batches for one in batch.slots] == slots


def test_what_fits_nowhere_is_given_up_after_a_while() -> None:
    scenes = [f"home{number}" for number in range(57)]
    record = Record(lambda *_: False)
    (lost,) = place_slots([slot(0)], scenes, seed=1, run=record)
    assert lost.key == slot(0).key
    assert len(record.tried()) == 24
