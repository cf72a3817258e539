"""What a partial copy of a release says of itself: where it is from and which part it holds."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from affectsim_data.schemas import SPLITS, Split

__all__ = ["Partial", "SceneChoice", "join_scenes"]

SceneChoice = Mapping[Split, tuple[str, ...] | None]
"""By split that is chosen: the scenes whose episodes are, sorted, or `None` for all of them."""


@dataclasses.dataclass(frozen=True)
class Partial:
    """The release a copy is a part of, and the part."""

    uri: str
    """Where it was taken from; on the Hub, with the commit."""
    manifest_sha256: str
    """Hash of the whole release's manifest: two copies with the same one can be joined."""
    scene_ids: SceneChoice
    """Splits that are here, and of each the scenes whose episodes are."""
    splits: tuple[Split, ...]
    """Splits of the whole release that have episodes: by scene, each may hold some of any."""
    first_rows: Mapping[str, int]
    """Place in its split's table of the first row of each episodes shard that is here."""

    def describe(self) -> str:
        """The part in words, for example `split test, 3 scenes of split train`."""
        words = []
        for split, scenes in self.scene_ids.items():
            count = "" if scenes is None else f"{len(scenes)} scene{'s' * (len(scenes) != 1)} of "
            words.append(f"{count}split {split}")
        return ", ".join(words)

    def lacks(self, split: str, *, folder: str, split_by: str = "group") -> str:
        """What to tell who asks this copy, in `folder`, for a split that is not here."""
        option = "" if split_by == "group" else f" --split-by {split_by}"
        by = {"group": "", "scene": " by scene", "both": " by group and scene"}[split_by]
        return (
            f"{folder}: this copy holds only {self.describe()}; `affectsim download {self.uri}"
            f"{option} --split {split} --out {folder}` adds split {split}{by}"
        )

    def to_json(self) -> dict[str, Any]:
        """The entry as it stands in the manifest."""
        return {
            "uri": self.uri,
            "manifest_sha256": self.manifest_sha256,
            "scene_ids": {
                split: None if scenes is None else list(scenes)
                for split, scenes in self.scene_ids.items()
            },
            "splits": list(self.splits),
            "first_rows": dict(self.first_rows),
        }

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> Partial:
        """Reads the entry of a manifest.

        Raises:
            ValueError: It names a split there is none of.
        """
        choice, whole = document["scene_ids"], document["splits"]
        if unknown := sorted({*choice, *whole} - set(SPLITS)):
            raise ValueError(f"partial_of: unknown splits {', '.join(unknown)}")
        return cls(
            uri=str(document["uri"]),
            manifest_sha256=str(document["manifest_sha256"]),
            scene_ids={
                split: None if choice[split] is None else tuple(map(str, choice[split]))
                for split in SPLITS
                if split in choice
            },
            splits=tuple(split for split in SPLITS if split in whole),
            first_rows={str(name): int(row) for name, row in document["first_rows"].items()},
        )


def join_scenes(first: SceneChoice, second: SceneChoice) -> SceneChoice:
    """What is in either choice.

    Examples:
        >>> join_scenes({"test": ("a",), "train": ("a",)}, {"test": ("b", "a"), "train": None})
        {'train': None, 'test': ('a', 'b')}
    """
    joined: dict[Split, tuple[str, ...] | None] = {}
    for split in SPLITS:
        choices = [choice[split] for choice in (first, second) if split in choice]
        if choices:
            some = [scene for scenes in choices for scene in scenes or ()]
            joined[split] = None if None in choices else tuple(sorted(set(some)))
    return joined
