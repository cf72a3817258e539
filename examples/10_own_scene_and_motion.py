"""You learn: how a mesh file and a folder of BVH files of your own become a dataset.

Both are made here. With your own, write the two recipes alone; the keys are in `docs/`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from PIL import ImageColor

from affectsim_data import AffectSimDataset, open_release
from affectsim_data.builders.building import build_release
from affectsim_data.builders.performances import perform
from affectsim_data.content import content_path
from affectsim_data.inspection.episode_sheets import sampled_episodes, write_episode_sheets
from affectsim_data.motions import EMOTIONS
from affectsim_data.motions.bvh_writing import write_bvh
from affectsim_data.render import open_renderer

STUDIO = {  # name of the node: colour, least and greatest corner in metres, +Y up
    "floor": ("peru", (0, -0.1, 0), (8, 0, 6)),
    "wall_north": ("lightsteelblue", (0, 0, -0.1), (8, 2.6, 0)),
    "wall_south": ("linen", (0, 0, 6), (8, 2.6, 6.1)),
    "wall_west": ("lightsteelblue", (-0.1, 0, 0), (0, 2.6, 6)),
    "wall_east": ("linen", (8, 0, 0), (8.1, 2.6, 6)),
    "counter": ("seagreen", (4.6, 0, 1.6), (5.2, 1.1, 3.4)),
}
OWN = {  # what differs from the recipe for folders of BVH files, which is copied
    'name = "bvh"': 'name = "recordings"',
    'licence = "NOASSERTION"': 'licence = "CC0-1.0"',
    "redistribution = false": "redistribution = true",
}
RELEASE = """
name = "studio"
seed = 1
corpora = ["recordings.toml"]
camera = { width = 224, height = 224, hfov_deg = 60.0 }
scenes = { meshes = "*.glb", name = "rooms", licence = "CC0-1.0" }
avatars = { ids = ["ada", "ben", "gita"] }
splits = { by = "performer", train = ["ann"], validation = ["bob"], test = ["cleo"] }
screening.off.frozen = "the hands of built-in performances rest"
[[compose]]
family = "observation_controlled"
actions = ["scenario"]
challenges = ["rear_view", "partial_occlusion"]
"""


def main() -> None:
    Path("rooms").mkdir(exist_ok=True)
    studio = trimesh.Scene()
    for name, (color, *corners) in STUDIO.items():
        box = trimesh.creation.box(bounds=corners)
        box.visual.face_colors = ImageColor.getrgb(color)
        studio.add_geometry(box, node_name=name, geom_name=name)
    studio.export("rooms/studio.glb")  # type: ignore[no-untyped-call]  # trimesh's own
    for number, who in enumerate(("ann", "bob", "cleo")):
        for emotion in EMOTIONS:
            path = Path("recordings", who, emotion, "scenario_0.bvh")
            path.parent.mkdir(parents=True, exist_ok=True)
            write_bvh(perform("scenario", emotion, who, rng=np.random.default_rng(number)), path)
    recipe = content_path("builders", "bvh.toml").read_text(encoding="utf-8")
    for copied, own in OWN.items():
        recipe = recipe.replace(copied, own)
    Path("recordings.toml").write_text(recipe, encoding="utf-8")
    Path("studio.toml").write_text(RELEASE, encoding="utf-8")
    sources = {name: Path(name) for name in ("recordings", "rooms")}
    build_release("studio.toml", Path("studio"), source=sources, overwrite=True)
    release = open_release("studio")
    episodes = sampled_episodes(release, 6, rng=np.random.default_rng(0))
    print(*write_episode_sheets(release, episodes, open_renderer(), Path("sheets")))
    print(AffectSimDataset(release, split="test", condition="p_ref")[0]["video"].shape)


if __name__ == "__main__":
    main()
