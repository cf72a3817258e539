"""You learn: what each kind of split holds out, and how to compare emotions in one placement.

The paper's split tests on people never seen, `scene` on homes never seen, `both` on either at once.
Episodes of one placement differ in the motion alone: what changes with them is due to emotion.
"""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

from affectsim_data import AffectSimDataset, open_release
from affectsim_data.inspection.contact_sheet import contact_sheet
from affectsim_data.releases.splits import SPLIT_BYS
from affectsim_data.render import open_renderer

OUT = Path("splits")


def main() -> None:
    release = open_release("mini")
    for split_by in SPLIT_BYS:
        print(f"by {split_by}:")
        for column in ("performer_id", "scene_id"):
            train, test = (
                set(release.split_table(split, split_by).index.column(column).to_pylist())
                for split in ("train", "test")
            )
            shared = ", ".join(sorted(train & test)) or "none"
            print(f"  {column:12} shared by train and test: {shared}")
        dataset = AffectSimDataset(release, split="test", split_by=split_by, images=False)
        print(f"  {len(dataset)} episodes to test on, fingerprint {dataset.fingerprint[:16]}")

    placements = defaultdict(list)
    for place, name in enumerate(release.episode_index("test").column("placement_id").to_pylist()):
        placements[name].append(release.episode("test", place))
    matched = max(placements.values(), key=len)
    matched.sort(key=lambda episode: episode.label)
    first = matched[0]
    print(f"{len(placements)} placements; {first.placement_id}:")
    for episode in matched:
        same = episode.start_position == first.start_position
        share = episode.visible_share_init
        print(f"  {episode.emotion:8} same start {same}, visible at first {share:.2f}")

    OUT.mkdir(exist_ok=True)
    conditions = ("p_init", "p_ref", "p_mon")
    sheet = contact_sheet(release, matched, open_renderer(), conditions=conditions, plans=True)
    sheet.save(OUT / "placement.png")
    print(f"{OUT / 'placement.png'}: one placement, {len(matched)} emotions")


if __name__ == "__main__":
    main()
