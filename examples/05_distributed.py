"""You learn: data-parallel training; every process gets its share, and none waits for ever.

Run as it is it starts two processes on this machine. With several GPUs or machines:
torchrun --nproc-per-node 8 examples/05_distributed.py
"""

from __future__ import annotations

import os
import subprocess
import sys

import torch
from torch import distributed, nn
from torch.nn.parallel import DistributedDataParallel

from affectsim_data import AffectSimDataset, Sample, data_loader

EPOCHS, BATCH_SIZE = 2, 8


def features(sample: Sample) -> tuple[torch.Tensor, int, bool]:
    """Mean depth per frame and cell `(8 * 8 * 8,)`, the label, whether the sample is padding."""
    depth = sample["depth"].nan_to_num(posinf=10.0)
    return nn.functional.adaptive_avg_pool2d(depth, 8).flatten(), sample["label"], sample["padding"]


def train() -> None:
    """One process of the training; rank and world size come from torch.distributed."""
    dataset = AffectSimDataset(split="train", condition="p_mon", transform=features)
    loader = data_loader(dataset, batch_size=BATCH_SIZE, shuffle="scenes", num_workers=1)
    torch.manual_seed(0)
    model = DistributedDataParallel(nn.Linear(8 * 8 * 8, 5))
    optimizer = torch.optim.Adam(model.parameters(), lr=1e-3)
    for epoch in range(EPOCHS):
        seen = torch.zeros(2)
        for inputs, labels, padding in loader:
            losses = nn.functional.cross_entropy(model(inputs), labels, reduction="none")
            # Padding keeps all ranks in step; it is marked, so it need not count.
            loss = losses[~padding].sum() / max(1, int((~padding).sum()))
            optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]  # torch's own
            optimizer.step()
            seen += torch.tensor([float((~padding).sum()), float(padding.sum())])
        distributed.all_reduce(seen)
        if distributed.get_rank() == 0:
            world = distributed.get_world_size()
            print(f"epoch {epoch}: {int(seen[0])} episodes, {int(seen[1])} padded, {world} ranks")
            assert int(seen[0]) == len(dataset)


def main() -> None:
    if "RANK" not in os.environ:
        launch = ["-m", "torch.distributed.run", "--standalone", "--nproc-per-node", "2"]
        subprocess.run([sys.executable, *launch, __file__], check=True)
        return
    distributed.init_process_group("nccl" if torch.cuda.is_available() else "gloo")
    train()
    distributed.destroy_process_group()


if __name__ == "__main__":
    main()
