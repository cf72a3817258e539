"""Stand-ins of what the recipe `paper` reads: folders and names of the originals, acted by code.

Nothing here comes from a corpus. Files hold built-in performances of our own body, whose joints
have the names that the corpus' recipe maps; houses are boxes. Made by code; CC0.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from habitat_files import CHAIR, SOFA, Box, DatasetFiles

from affectsim_data.builders.corpora import CorpusRecipe, load_recipe
from affectsim_data.builders.performances import PerformanceAction, perform, perform_dyad
from affectsim_data.motions import EMOTIONS, Emotion, Motion
from affectsim_data.motions.bvh_writing import write_bvh
from affectsim_data.poses import (
    FloatArray,
    compose_pose,
    matrix_quaternion,
    quaternion_multiply,
    transform_points,
    yaw_quaternion,
)
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["PaperSources", "moved", "write_clip", "write_dyads", "write_emilya", "write_kdae"]

EMILYA_ACTIONS: dict[str, PerformanceAction] = {
    "Simple Walk": "simple_walk",
    "Sitting Down": "sit_down",
    "Being Seated": "being_seated",
    "Knocking on the Door": "knock_door",
}
EMILYA_EMOTIONS: dict[Emotion, str] = {
    "angry": "Anger",
    "fearful": "Panic Fear",
    "happy": "Joy",
    "neutral": "Neutral",
    "sad": "Sadness",
}
EMILYA_ACTORS = (
    *("Brian", "Elie", "Florian", "Hu", "Janina", "Jessica", "Maria", "Muriel", "Robert"),
    *("Sally", "Samih", "Tatiana"),
)
KDAE_EMOTIONS: dict[Emotion, str] = {
    "angry": "A",
    "fearful": "F",
    "happy": "H",
    "neutral": "N",
    "sad": "SA",
}
STOOL_HEIGHTS = {"low_stool": 0.42, "stool": 0.45, "high_stool": 0.48}
STOOLS = (
    *(("low_stool", -3.5, -2.6, 180.0), ("stool", -1.5, -2.6, 180.0), ("stool", -3.5, 2.6, 0.0)),
    *(("high_stool", 6.0, 2.2, 0.0), ("high_stool", 0.0, 2.9, 0.0), ("low_stool", 3.0, 1.0, 90.0)),
)
PAIRS = (("ann", "bob"), ("cai", "dee"), ("eva", "fay"))


@dataclasses.dataclass(frozen=True)
class PaperSources:
    """Folders of the recipe's sources below one root."""

    root: Path

    def folders(self) -> dict[str, Path]:
        """By the names that the recipe gives them."""
        return {name: self.root / name for name in ("emilya", "kdae", "dyads", "hssd")}

    def touch(self, *, actors: int, kdae_actors: int, sequences: int) -> None:
        """Empty files in place of motions, for what looks at names alone."""
        folders = self.folders()
        names = [
            folders["emilya"] / "PerAction" / action / style / actor / f"{actor}_01.bvh"
            for action, style, actor in itertools.product(
                EMILYA_ACTIONS, EMILYA_EMOTIONS.values(), EMILYA_ACTORS[:actors]
            )
        ]
        for number, letter in itertools.product(range(1, kdae_actors + 1), KDAE_EMOTIONS.values()):
            names.append(folders["kdae"] / "BVH" / f"F{number:02}" / f"F{number:02}{letter}1V1.bvh")
        for number in range(sequences):
            folder = folders["dyads"] / EMOTIONS[number % 5] / f"sequence_{number:02}"
            names += [folder / "target_ann.bvh", folder / "partner_bob.bvh"]
        for name in names:
            name.parent.mkdir(parents=True, exist_ok=True)
            name.touch()

    @classmethod
    def write(
        cls,
        root: Path,
        *,
        actors: Sequence[str] = EMILYA_ACTORS[:3],
        kdae_actors: Sequence[str] = ("F01", "F02", "M03"),
        scenarios: Sequence[int] = (1,),
        sequences: int = 3,
        houses: int = 2,
    ) -> PaperSources:
        """All four, as many of each as asked for."""
        sources = cls(root)
        folders = sources.folders()
        write_emilya(folders["emilya"], actors)
        write_kdae(folders["kdae"], kdae_actors, scenarios)
        write_dyads(folders["dyads"], sequences)
        write_hssd(folders["hssd"], houses)
        return sources


def write_clip(motion: Motion, path: Path, corpus: CorpusRecipe) -> None:
    """A motion as BVH with the joint names of a corpus."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_bvh(_restless(motion), path)
    names = {joint: own if isinstance(own, str) else own[0] for joint, own in corpus.joints.items()}
    head, frames = path.read_text(encoding="utf-8").split("MOTION", 1)
    head = re.sub(
        r"(ROOT|JOINT) (\w+)", lambda found: f"{found[1]} {names.get(found[2], found[2])}", head
    )
    path.write_text(f"{head}MOTION{frames}", encoding="utf-8")


def _restless(motion: Motion) -> Motion:
    """The motion with wrists that never rest exactly, as nobody's do; screening looks for it."""
    swing = np.radians(4.0) * np.sin(np.arange(motion.num_frames) * np.pi * 2.0 / 40.0)
    turn = np.stack([np.cos(swing / 2.0), np.sin(swing / 2.0), 0.0 * swing, 0.0 * swing], axis=-1)
    rotations = motion.joint_rotations.copy()
    for side in ("left", "right"):
        wrist = JOINT_NAMES.index(f"{side}_wrist")
        rotations[:, wrist] = quaternion_multiply(rotations[:, wrist], turn)
    return dataclasses.replace(motion, joint_rotations=rotations)


@functools.cache
def acted(action: PerformanceAction, emotion: Emotion, take: int = 0) -> Motion:
    """A built-in performance; everybody of a stand-in shows the same."""
    return perform(action, emotion, "p1", take=take, rng=np.random.default_rng([7, take]))


def write_emilya(root: Path, actors: Sequence[str]) -> None:
    """`PerAction/Simple Walk/Panic Fear/Brian/Brian_01.bvh`, a file of each."""
    corpus = load_recipe("emilya")
    for (word, action), (emotion, style), actor in itertools.product(
        EMILYA_ACTIONS.items(), EMILYA_EMOTIONS.items(), actors
    ):
        path = root / "PerAction" / word / style / actor / f"{actor}_01.bvh"
        write_clip(acted(action, emotion), path, corpus)


def write_kdae(root: Path, actors: Sequence[str], scenarios: Sequence[int]) -> None:
    """`BVH/F01/F01A1V1.bvh`, a version of each scenario in five emotions."""
    corpus = load_recipe("kdae")
    for actor, scenario, (emotion, letter) in itertools.product(
        actors, scenarios, KDAE_EMOTIONS.items()
    ):
        path = root / "BVH" / actor / f"{actor}{letter}{scenario}V1.bvh"
        write_clip(acted("scenario", emotion, (scenario - 1) % 5), path, corpus)


def moved(motion: Motion, pose: FloatArray) -> Motion:
    """The motion as recorded in a space in which its performance frame is at a pose `(4, 4)`."""
    rotations = motion.joint_rotations.copy()
    rotations[:, 0] = quaternion_multiply(matrix_quaternion(pose[:3, :3]), rotations[:, 0])
    root = transform_points(pose, motion.root_translation)
    return dataclasses.replace(motion, root_translation=root, joint_rotations=rotations)


def write_dyads(root: Path, sequences: int) -> None:
    """`angry/argue_00/target_ann.bvh` and the partner's, somewhere in a capture space."""
    corpus = load_recipe("dyads")
    space = compose_pose(yaw_quaternion(2.0), np.array([0.8, 0.0, -1.7]))
    for number in range(sequences):
        emotion = EMOTIONS[number % len(EMOTIONS)]
        rng = np.random.default_rng([9, number])
        dyad = perform_dyad(emotion, ("p1", "p2"), take=number // len(EMOTIONS) % 3, rng=rng)
        folder = root / emotion / f"{dyad.target.performance}_{number:02}"
        target, partner = PAIRS[number % len(PAIRS)]
        write_clip(moved(dyad.target, space), folder / f"target_{target}.bvh", corpus)
        where = space @ dyad.T_target_partner
        write_clip(moved(dyad.partner, where), folder / f"partner_{partner}.bvh", corpus)


def write_hssd(root: Path, houses: int) -> None:
    """A dataset laid out as HSSD is: houses of two rooms, with furniture and a closed door."""
    root.mkdir(parents=True, exist_ok=True)
    files = DatasetFiles(root)
    (root / "test.scene_dataset_config.json").rename(root / "hssd-hab.scene_dataset_config.json")
    files.add_object("sofa", *SOFA)
    files.add_object("chair", *CHAIR)
    for size, top in STOOL_HEIGHTS.items():
        files.add_object(size, ((-0.17, top - 0.03, -0.17), (0.17, top, 0.17)), *_legs(top - 0.03))
    files.add_object("table", ((-0.6, 0.0, -0.4), (0.6, 0.74, 0.4)))
    files.add_object("door", ((-0.45, 0.0, -0.04), (0.45, 2.05, 0.04)))
    files.add_object("wardrobe", ((-0.6, 0.0, -0.3), (0.6, 2.0, 0.3)))
    for number in range(houses):
        name = f"10234{number:04}"
        files.stage(name, *_house(9.0 + 0.5 * number))
        files.scene(*_furniture(), stage=f"stages/{name}", name=name)


def _house(length: float) -> tuple[Box, ...]:
    """Floor and walls: a room of 6 m, a wall with a way through and a door, and another room."""
    low, high, width, top = -6.0, length, 4.0, 2.6
    walls: list[Box] = [
        ((low, 0.0, -width - 0.1), (high, top, -width)),
        ((low, 0.0, width), (high, top, width + 0.1)),
        ((low - 0.1, 0.0, -width), (low, top, width)),
        ((high, 0.0, -width), (high + 0.1, top, width)),
        # Between the rooms: the way from z = 2 to 3.2, the door about z = -2.
        ((1.0, 0.0, -width), (1.1, top, -2.5)),
        ((1.0, 0.0, -1.5), (1.1, top, 2.0)),
        ((1.0, 0.0, 3.2), (1.1, top, width)),
        ((1.0, 2.1, -2.5), (1.1, top, -1.5)),
    ]
    return (((low, -0.1, -width), (high, 0.0, width)), *walls)


def _furniture() -> list[dict[str, object]]:
    return [
        _placed("door", 1.05, -2.0, 90.0),
        _placed("sofa", -5.4, 0.0, -90.0),
        _placed("chair", 4.0, 3.2, 0.0),
        _placed("chair", 7.0, -3.3, 180.0),
        _placed("table", -2.0, 1.6, 0.0),
        _placed("wardrobe", 4.5, -0.5, 0.0),
        _placed("sofa", 3.0, -3.4, 180.0),
        *(_placed(*stool) for stool in STOOLS),
    ]


def _legs(top: float) -> list[Box]:
    places = [(x, z) for x in (-0.16, 0.13) for z in (-0.16, 0.13)]
    return [((x, 0.0, z), (x + 0.03, top, z + 0.03)) for x, z in places]


def _placed(name: str, x: float, z: float, yaw_deg: float) -> dict[str, object]:
    half = np.radians(yaw_deg) / 2.0
    return {
        "template_name": name,
        "translation": [x, 0.0, z],
        "rotation": [float(np.cos(half)), 0.0, float(np.sin(half)), 0.0],
        "translation_origin": "asset_local",
    }
