"""You learn: a PyTorch Lightning training that resumes in the middle of an epoch.

Two switches matter: `use_distributed_sampler=False`, because the loader shares the episodes among
ranks itself, and a checkpoint saved by step, which carries the loader's place.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import lightning
import torch
from lightning.pytorch.callbacks import ModelCheckpoint
from torch import nn

from affectsim_data import AffectSimDataset, Sample, data_loader

BATCH_SIZE, STOP_AT, STEPS = 8, 5, 12


def features(sample: Sample) -> tuple[torch.Tensor, int, str]:
    """Joint positions around the pelvis `(8 * 22 * 3,)`, the label, the episode."""
    joints = sample["joint_positions"]
    return (joints - joints[:, :1]).flatten(), sample["label"], sample["episode_id"]


class Recognizer(lightning.LightningModule):
    """A linear model that notes which episodes it saw."""

    def __init__(self) -> None:
        super().__init__()
        self.model = nn.Linear(8 * 22 * 3, 5)
        self.seen: list[str] = []

    def training_step(self, batch: Any, batch_idx: int) -> torch.Tensor:
        """The loss of a batch."""
        inputs, labels, episode_ids = batch
        self.seen.extend(episode_ids)
        return nn.functional.cross_entropy(self.model(inputs), labels)

    def configure_optimizers(self) -> torch.optim.Optimizer:
        """Adam."""
        return torch.optim.Adam(self.parameters(), lr=1e-3)


def fit(folder: Path, *, max_steps: int, checkpoint: Path | None = None) -> list[str]:
    """Episodes in the order in which a training saw them."""
    dataset = AffectSimDataset(split="train", images=False, transform=features)
    loader = data_loader(dataset, batch_size=BATCH_SIZE, shuffle="scenes", seed=3)
    recognizer = Recognizer()
    trainer = lightning.Trainer(
        max_steps=max_steps,
        accelerator="cpu",
        use_distributed_sampler=False,
        callbacks=[ModelCheckpoint(folder, save_top_k=-1, every_n_train_steps=1)],
        enable_progress_bar=False,
        enable_model_summary=False,
        logger=False,
    )
    trainer.fit(recognizer, loader, ckpt_path=checkpoint, weights_only=False)
    return recognizer.seen


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        whole = fit(Path(folder) / "a", max_steps=STEPS)
        first = fit(Path(folder) / "b", max_steps=STOP_AT)
        checkpoint = next((Path(folder) / "b").glob(f"*step={STOP_AT}.ckpt"))
        rest = fit(Path(folder) / "c", max_steps=STEPS, checkpoint=checkpoint)
    print(f"{len(whole)} samples; stopped after {len(first)}, resumed with {len(rest)} more")
    print(f"the same episodes in the same order: {first + rest == whole}")
    assert first + rest == whole


if __name__ == "__main__":
    main()
