"""You learn: how a folder of BVH files becomes labelled motions, with a recipe of one page.

The folder is made here, from built-in performances, and the motions come back as `my_corpus/...`.
With your own recordings, write the recipe alone; `docs/motions.md` explains every key.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from affectsim_data.builders.corpora import load_recipe, read_corpus
from affectsim_data.builders.performances import PerformanceAction, perform
from affectsim_data.motions import EMOTIONS
from affectsim_data.motions.bvh_writing import write_bvh
from affectsim_data.skeletons import JOINT_NAMES

ACTIONS: dict[str, PerformanceAction] = {"knocking": "knock_door", "sitting": "being_seated"}
RECIPE = """
[corpus]
name = "my_corpus"
licence = "CC0-1.0"
redistribution = true
pattern = '(?P<who>\\w+)/(?P<style>\\w+)/(?P<action>\\w+)\\.bvh'
performer = "{who}"
motion_id = "{who}_{style}_{action}"
fps = 30
metres_per_unit = 0.01
up_axis = "y"

[labels]
ANG = "angry"
HAP = "happy"
NEU = "neutral"
SAD = "sad"

[excluded]
FEA = "left out here to show that it is counted"

[actions]
knocking = "knock_door"
sitting = "being_seated"

[joints]
"""


def write_folder(folder: Path) -> None:
    """Twenty clips of two people, and a file that is none."""
    for number, who in enumerate(("ann", "bob")):
        for emotion in EMOTIONS:
            place = folder / who / emotion[:3].upper()
            place.mkdir(parents=True, exist_ok=True)
            for name, action in ACTIONS.items():
                motion = perform(action, emotion, who, rng=np.random.default_rng(number))
                write_bvh(motion, place / f"{name}.bvh")
    (folder / "bob" / "SAD" / "knocking.bvh").write_text("cut short")


def main() -> None:
    folder = Path("my_corpus")
    write_folder(folder)
    recipe_path = Path("my_corpus.toml")
    joints = "\n".join(f'{name} = "{name}"' for name in JOINT_NAMES)
    recipe_path.write_text(RECIPE + joints, encoding="utf-8")

    reading = read_corpus(load_recipe(recipe_path), folder)
    print(reading.summary())
    for (action, emotion), count in reading.scan.counts().items():
        print(f"  {action:12} {emotion:8} {count}")
    for failure in reading.failures:
        print(f"failed: {failure.reason}")
    for motion in reading.motions[:3]:
        print(f"{motion.motion_id}: {motion.duration_s:.1f} s, {motion.num_frames} frames")


if __name__ == "__main__":
    main()
