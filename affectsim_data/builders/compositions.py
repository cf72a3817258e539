"""`[[compose]]` of a recipe: which motions become episodes, how many, where, and in which split.

    [[compose]]
    family = "observation_controlled"
    actions = ["scenario"]              # or shares: { simple_walk = 3, sit_down = 1 }
    emotions = ["angry", "sad"]         # all five if not given
    challenges = ["far_visible", "rear_view"]   # or shares; this family alone has them
    placement = "floor"                 # what the action needs if not given
    split_by = "performance"            # or performer; [splits] of the recipe if not given
    performers = { train = 8, validation = 2, test = 2 }    # or names; with split_by performer
    motions = { train = 669, validation = 84, test = 84 }   # all there are if not given
    episodes = { train = 6643, validation = 831, test = 832 }   # or repeats = 30 for every motion

Episodes of a split are shared out to challenges and actions exactly, and to emotions evenly: the
motions of a matched set, one of each emotion, always share their placements. Where emotions shall
be unequal, several entries name them.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping
from typing import Any, Literal, cast, get_args

from affectsim_data.builders.recipe_keys import check_keys
from affectsim_data.motions import EMOTIONS, Emotion
from affectsim_data.schemas import CHALLENGES, FAMILIES, SPLITS, Challenge, Family, Split

__all__ = ["Composition", "PlacementKind", "SplitRule", "read_compositions", "read_split_rule"]

PlacementKind = Literal["floor", "seat", "before_seat", "door", "pair"]
"""Where a person goes: on free floor, on a seat, where the seat is behind who sits down, before a
closed door, or facing a partner."""
PLACEMENT_KINDS: tuple[PlacementKind, ...] = get_args(PlacementKind)
_PLACEMENT_OF: dict[str, PlacementKind] = {
    "being_seated": "seat",
    "sit_down": "before_seat",
    "knock_door": "door",
    "interaction": "pair",
}
"""Of actions that need something; all others need free floor."""
SplitBy = Literal["performer", "performance", "action"]
SPLIT_BY: tuple[SplitBy, ...] = get_args(SplitBy)
_KEYS = (
    *("family", "actions", "placement", "challenges", "repeats", "episodes", "motions"),
    *("emotions", "split_by", "performers"),
)


@dataclasses.dataclass(frozen=True)
class SplitRule:
    """What no two splits share, and who or what belongs to which."""

    by: SplitBy
    members: Mapping[Split, tuple[str, ...] | int]
    """By split, names of performers or actions, or how many performers, drawn by the seed. Empty
    for performances: `Composition.motions` says how many motions a split gets."""


@dataclasses.dataclass(frozen=True)
class Composition:
    """One `[[compose]]` entry: episodes of one family from the motions of some actions."""

    family: Family
    actions: Mapping[str, float]
    """Actions and their shares of the episodes."""
    placement: PlacementKind | None
    """Where the person goes; what the action needs if not given."""
    challenges: Mapping[Challenge | None, float]
    """Challenges and their shares of the episodes; `{None: 1}` outside observation_controlled."""
    split_rule: SplitRule
    emotions: tuple[Emotion, ...] = EMOTIONS
    """Motions of others are left out."""
    motions: Mapping[Split, int] | None = None
    """How many motions each split uses; all there are if not given."""
    episodes: Mapping[Split, int] | None = None
    """How many episodes each split gets; `repeats` placements of every motion if not given."""
    repeats: int = 1
    """Placements per matched set of motions and challenge, without `episodes`."""

    def placement_of(self, action: str) -> PlacementKind:
        """Where who performs an action goes."""
        return self.placement or _PLACEMENT_OF.get(action, "floor")


def read_compositions(
    entries: Any, default: SplitRule | None, *, where: str
) -> tuple[Composition, ...]:
    """The `[[compose]]` entries of a recipe.

    Args:
        entries: As TOML has them.
        default: The recipe's `[splits]`, for entries that do not say `split_by`.
        where: Start of error messages: the recipe.

    Raises:
        ValueError: An entry lacks a key, has an unknown one or a value that is not allowed.
    """
    return tuple(
        _composition(entry, default, f"{where}: [[compose]] {number}")
        for number, entry in enumerate(entries, 1)
    )


def read_split_rule(table: Mapping[str, Any], *, where: str) -> SplitRule:
    """The recipe's `[splits]`: `by`, and names of performers or actions by split.

    Raises:
        ValueError: A key or value is not allowed.
    """
    check_keys(table, ("by", *SPLITS), where=where)
    by = table.get("by")
    if by not in ("performer", "action"):
        raise ValueError(f"{where} by must be performer or action, got {by!r}")
    return SplitRule(by, _members({k: v for k, v in table.items() if k != "by"}, where=where))


def _composition(entry: Any, default: SplitRule | None, where: str) -> Composition:
    check_keys(entry, _KEYS, where=where)
    for key in ("family", "actions"):
        if key not in entry:
            raise ValueError(f"{where} lacks {key!r}")
    family, placement = entry["family"], entry.get("placement")
    if family not in FAMILIES:
        raise ValueError(f"{where} family must be one of {FAMILIES}, got {family!r}")
    if placement is not None and placement not in PLACEMENT_KINDS:
        raise ValueError(
            f"{where} placement must be one of {', '.join(PLACEMENT_KINDS)}, got {placement!r}"
        )
    challenges = _shares(entry.get("challenges", []), least=0, where=f"{where} challenges")
    for challenge in challenges:
        if challenge not in CHALLENGES:
            raise ValueError(f"{where} challenge must be one of {CHALLENGES}, got {challenge!r}")
    if bool(challenges) != (family == "observation_controlled"):
        raise ValueError(f"{where} challenges are for observation_controlled, and it needs some")
    return Composition(
        family=cast(Family, family),
        actions=_shares(entry["actions"], least=1, where=f"{where} actions"),
        placement=cast(PlacementKind | None, placement),
        challenges=cast("dict[Challenge | None, float]", challenges) or {None: 1.0},
        split_rule=_split_rule(entry, default, where),
        emotions=_emotions(entry.get("emotions", EMOTIONS), where=f"{where} emotions"),
        motions=_counts(entry.get("motions"), where=f"{where} motions"),
        episodes=_counts(entry.get("episodes"), where=f"{where} episodes"),
        repeats=_repeats(entry, where=where),
    )


def _repeats(entry: Mapping[str, Any], *, where: str) -> int:
    repeats = entry.get("repeats", 1)
    if isinstance(repeats, bool) or not isinstance(repeats, int) or repeats < 1:
        raise ValueError(f"{where} repeats must be a whole number from 1, got {repeats!r}")
    if "repeats" in entry and "episodes" in entry:
        raise ValueError(f"{where} has both repeats and episodes; keep one of them")
    return repeats


def _emotions(value: Any, *, where: str) -> tuple[Emotion, ...]:
    """Emotions in label order."""
    names = list(value) if isinstance(value, list | tuple) else [value]
    if not names or any(name not in EMOTIONS for name in names):
        raise ValueError(f"{where} must be some of {', '.join(EMOTIONS)}, got {value!r}")
    return tuple(emotion for emotion in EMOTIONS if emotion in names)


def _split_rule(entry: Mapping[str, Any], default: SplitRule | None, where: str) -> SplitRule:
    by = entry.get("split_by")
    if by is None:
        if default is None:
            raise ValueError(f"{where} lacks split_by, and the recipe has no [splits]")
        return default
    if by not in SPLIT_BY:
        raise ValueError(f"{where} split_by must be one of {', '.join(SPLIT_BY)}, got {by!r}")
    if by == "performer" and "performers" not in entry:
        raise ValueError(f"{where} split_by performer needs performers = {{train = ...}}")
    if by == "performance" and "motions" not in entry:
        raise ValueError(f"{where} split_by performance needs motions = {{train = ...}}")
    if by == "action":
        raise ValueError(f"{where} split_by action goes into [splits], with the actions' names")
    return SplitRule(by, _members(entry.get("performers", {}), where=f"{where} performers"))


def _members(table: Any, *, where: str) -> dict[Split, tuple[str, ...] | int]:
    check_keys(table, SPLITS, where=where)
    members: dict[Split, tuple[str, ...] | int] = {}
    for split in (one for one in SPLITS if one in table):
        value = table[split]
        if isinstance(value, list) and all(isinstance(one, str) for one in value):
            members[split] = tuple(value)
        elif isinstance(value, int) and not isinstance(value, bool) and value >= 0:
            members[split] = value
        else:
            raise ValueError(f"{where} {split} must be names or how many, got {value!r}")
    named = Counter(
        name for value in members.values() if isinstance(value, tuple) for name in value
    )
    if repeated := [name for name, count in named.items() if count > 1]:
        raise ValueError(f"{where} names {repeated[0]!r} more than once")
    return members


def _shares(value: Any, *, least: int, where: str) -> dict[str, float]:
    """At least so many names with equal shares from a list, or those of a table; they sum to 1."""
    table = dict.fromkeys(value, 1.0) if isinstance(value, list) else value
    if not isinstance(table, Mapping) or not all(
        isinstance(name, str)
        and isinstance(share, int | float)
        and not isinstance(share, bool)
        and share > 0
        for name, share in table.items()
    ):
        raise ValueError(f"{where} must be names, or names with shares above 0, got {value!r}")
    if len(table) < least or (isinstance(value, list) and len(table) < len(value)):
        raise ValueError(f"{where} must be names, each once, got {value!r}")
    total = float(sum(table.values()))
    return {name: share / total for name, share in table.items()}


def _counts(value: Any, *, where: str) -> dict[Split, int] | None:
    if value is None:
        return None
    check_keys(value, SPLITS, where=where)
    for split, count in value.items():
        if isinstance(count, bool) or not isinstance(count, int) or count < 0:
            raise ValueError(f"{where} {split} must be a whole number from 0, got {count!r}")
    return {split: int(value.get(split, 0)) for split in SPLITS}
