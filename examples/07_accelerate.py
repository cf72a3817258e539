"""You learn: Hugging Face Accelerate with this package's loader.

Prepare the model and the optimizer, not the loader: it shares the episodes among the processes
itself, and its token goes into the checkpoint. Run it as it is, or with `accelerate launch`.
"""

from __future__ import annotations

import torch
from accelerate import Accelerator
from torch import nn

from affectsim_data import AffectSimDataset, Sample, data_loader

EPOCHS, BATCH_SIZE = 3, 8


def features(sample: Sample) -> tuple[torch.Tensor, int]:
    """Joint positions around the pelvis `(8 * 22 * 3,)` and the label."""
    joints = sample["joint_positions"]
    return (joints - joints[:, :1]).flatten(), sample["label"]


def main() -> None:
    accelerator = Accelerator(cpu=not torch.cuda.is_available())
    dataset = AffectSimDataset(split="train", images=False, transform=features)
    loader = data_loader(
        dataset,
        batch_size=BATCH_SIZE,
        shuffle="scenes",
        rank=accelerator.process_index,
        world_size=accelerator.num_processes,
    )
    torch.manual_seed(0)
    model = nn.Linear(8 * 22 * 3, 5)
    optimizer = torch.optim.Adam(model.parameters(), lr=1e-3)
    model, optimizer = accelerator.prepare(model, optimizer)
    # The loader's state_dict and load_state_dict go into accelerator.save_state from here on.
    accelerator.register_for_checkpointing(loader)
    while loader.epoch < EPOCHS:
        epoch, total, count = loader.epoch, 0.0, 0
        for inputs, labels in loader:
            inputs, labels = inputs.to(accelerator.device), labels.to(accelerator.device)
            loss = nn.functional.cross_entropy(model(inputs), labels)
            optimizer.zero_grad()
            accelerator.backward(loss)
            optimizer.step()
            total, count = total + loss.item() * len(labels), count + len(labels)
        accelerator.print(f"epoch {epoch}: loss {total / count:.3f} over {count} samples a process")


if __name__ == "__main__":
    main()
