"""The main job with an installed wheel, away from the checkout; run by `.ci/run`, not by pytest."""

from __future__ import annotations

from pathlib import Path

import affectsim_data
from affectsim_data import AffectSimDataset, Orbit
from affectsim_data.content import content_path


def main() -> None:
    package = Path(affectsim_data.__file__).parent
    assert "site-packages" in package.parts, f"not the installed wheel: {package}"
    assert content_path("loaders").is_relative_to(package / "content")
    for condition in ("p_init", "p_ref", "p_mon", Orbit(distance_m=2.0, azimuth_deg=135.0)):
        sample = AffectSimDataset(split="test", condition=condition)[0]
        assert tuple(sample["video"].shape) == (8, 3, 224, 224)
        assert sample["video"].float().std() > 5.0, "a blank picture"
        print(f"{sample['condition']}: {sample['episode_id']} {sample['emotion']}")


if __name__ == "__main__":
    main()
