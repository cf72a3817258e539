"""You learn: what a sample is, and how to see it.

Writes `first_sample.png`: the eight frames of one clip, colour above depth.
"""

from __future__ import annotations

import numpy as np
from PIL import Image

from affectsim_data import AffectSimDataset


def main() -> None:
    dataset = AffectSimDataset(split="test", condition="p_ref")
    sample = dataset[0]
    print(f"{len(dataset)} episodes; the first is {sample['episode_id']}: {sample['emotion']}")
    for name in ("video", "depth", "T_world_camera", "intrinsics", "time_s"):
        print(f"  {name:15} {sample[name].dtype} {tuple(sample[name].shape)}")

    frames = sample["video"].permute(0, 2, 3, 1).numpy()
    depth = sample["depth"][:, 0].numpy()
    near = np.clip(255.0 * (1.0 - depth / 6.0), 0, 255).astype(np.uint8)
    top = np.concatenate(list(frames), axis=1)
    bottom = np.repeat(np.concatenate(list(near), axis=1)[..., None], 3, axis=2)
    Image.fromarray(np.concatenate([top, bottom])).save("first_sample.png")
    print("look at first_sample.png")


if __name__ == "__main__":
    main()
