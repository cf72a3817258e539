"""The main job in one go: what `affectsim demo` and `make demo` do."""

from __future__ import annotations

import time
from collections import Counter
from pathlib import Path

from tqdm import tqdm

from affectsim_data.inspection.contact_sheet import contact_sheet, representative_episodes
from affectsim_data.inspection.recording import record_episode
from affectsim_data.inspection.summary import release_summary, summary_lines
from affectsim_data.loaders import AffectSimDataset
from affectsim_data.releases import open_release
from affectsim_data.render import process_renderer
from affectsim_data.render.device import describe_device

__all__ = ["run_demo"]

_TIMED_SAMPLES = 24


def run_demo(out: Path) -> None:
    """Builds `mini` if need be, draws samples, and writes `contact_sheet.png` and `episode.rrd`."""
    out.mkdir(parents=True, exist_ok=True)
    release = open_release("mini")
    print("\n".join(summary_lines(release_summary(release))))
    print(f"rendering on {describe_device().renderer}")
    for condition in ("p_init", "p_ref", "p_mon"):
        dataset = AffectSimDataset(release, split="test", condition=condition)
        dataset[0]
        start = time.perf_counter()
        count = min(_TIMED_SAMPLES, len(dataset))
        samples = [dataset[i] for i in tqdm(range(count), desc=condition, leave=False)]
        rate = count / (time.perf_counter() - start)
        emotions = dict(sorted(Counter(sample["emotion"] for sample in samples).items()))
        shape = tuple(samples[0]["video"].shape)
        print(f"  {condition:7} video {shape}, {rate:5.1f} samples/s, labels {emotions}")
    renderer = process_renderer("egl")
    episodes = representative_episodes(release)
    sheet = out / "contact_sheet.png"
    contact_sheet(release, episodes, renderer).save(sheet)
    recording = out / "episode.rrd"
    record_episode(episodes[0], release.world(episodes[0]), renderer, recording)
    print(f"look at {sheet}")
    print(f"explore with: rerun {recording}  ({recording.stat().st_size / 1e6:.1f} MB)")
