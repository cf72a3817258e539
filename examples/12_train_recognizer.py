"""You learn: train a recognizer on reference views, and see what it loses from the first pose.

On `mini` this shows how it goes; there is too little in it to learn from. For a result, with
`affectsim build small --out SMALL` or `full`, two cores and some ten minutes:

    python 12_train_recognizer.py --release SMALL --clips 5000 --out network.safetensors
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from rich.console import Console

from affectsim_data import AffectSimDataset, open_release
from affectsim_data.evaluation.evaluating import evaluate
from affectsim_data.evaluation.tables import read_predictions, score_predictions
from affectsim_data.recognizers import predict
from affectsim_data.recognizers.network import NetworkRecognizer
from affectsim_data.recognizers.training import load_clips, train_network
from affectsim_data.reports.tables import print_tables


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--release", default="mini")
    parser.add_argument("--clips", type=int, default=60, help="of the train split, at most")
    parser.add_argument("--joint-epochs", type=int, default=3)
    parser.add_argument("--emotion-epochs", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=0, help="processes that draw clips")
    parser.add_argument("--out", type=Path, default=Path("network.safetensors"))
    options = parser.parse_args()

    release = open_release(options.release)
    train = AffectSimDataset(release, split="train", condition="p_ref")
    chosen = np.random.default_rng(options.seed).permutation(len(train))[: options.clips]
    clips = load_clips(train.subset(np.sort(chosen)), num_workers=options.workers)
    network = train_network(
        clips,
        joint_epochs=options.joint_epochs,
        emotion_epochs=options.emotion_epochs,
        seed=options.seed,
    )
    recognizer = NetworkRecognizer(network, name=f"clip network, {len(clips)} clips")
    recognizer.save(options.out)

    # Performers and performances of the test split are in no other.
    p_init, p_ref, p_mon = (
        AffectSimDataset(release, split="test", condition=condition)
        for condition in ("p_init", "p_ref", "p_mon")
    )
    table = options.out.with_suffix(".predictions.parquet")
    predict(recognizer, p_init + p_ref + p_mon, table, overwrite=True, num_workers=options.workers)
    scored = score_predictions(read_predictions([table]), release, split="test")
    print_tables(evaluate(scored, seed=options.seed), Console(), brief=True)
    print(f"affectsim report {table} --release {options.release} --out report   # the whole of it")


if __name__ == "__main__":
    main()
