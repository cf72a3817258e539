"""You learn: a training run that is killed and resumed with other workers loses nothing.

Of two runs of a training one is killed without warning in the middle of an epoch and goes on from
its checkpoint with another number of workers. The loss curves are the same to the last bit.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import torch
from torch import nn

from affectsim_data import AffectSimDataset, Sample, data_loader

EPOCHS, BATCH_SIZE, CHECKPOINT_EVERY, KILLED_AT = 2, 8, 3, 11


def silhouettes(sample: Sample) -> tuple[torch.Tensor, int]:
    """Person masks `(8, 16, 16)` and the label."""
    masks = (sample["instances"][:, 0] == 1).float()
    return nn.functional.adaptive_avg_pool2d(masks, 16), sample["label"]


def train(checkpoint: Path, *, num_workers: int, killed_at: int = -1) -> list[float]:
    """Losses of all steps, those before a resume included."""
    dataset = AffectSimDataset(
        split="train", condition="p_mon", instances=True, transform=silhouettes
    )
    loader = data_loader(
        dataset, batch_size=BATCH_SIZE, shuffle="scenes", seed=1, num_workers=num_workers
    )
    torch.manual_seed(0)
    model = nn.Sequential(nn.Flatten(), nn.Linear(8 * 16 * 16, 32), nn.ReLU(), nn.Linear(32, 5))
    optimizer = torch.optim.Adam(model.parameters(), lr=1e-3)
    losses, staged = list[float](), checkpoint.with_suffix(".partial")
    if checkpoint.exists():
        saved = torch.load(checkpoint)
        model.load_state_dict(saved["model"])
        optimizer.load_state_dict(saved["optimizer"])
        loader.load_state_dict(saved["loader"])
        losses = saved["losses"]
    while loader.epoch < EPOCHS:
        for masks, labels in loader:
            optimizer.zero_grad()
            loss = nn.functional.cross_entropy(model(masks), labels)
            loss.backward()  # type: ignore[no-untyped-call]  # torch's own
            optimizer.step()
            losses.append(loss.item())
            if len(losses) == killed_at:
                os.kill(os.getpid(), signal.SIGKILL)
            if len(losses) % CHECKPOINT_EVERY == 0:
                state = {"model": model.state_dict(), "optimizer": optimizer.state_dict()}
                torch.save({**state, "loader": loader.state_dict(), "losses": losses}, staged)
                staged.replace(checkpoint)
    return losses


def main() -> None:
    if len(sys.argv) > 1:
        train(Path(sys.argv[1]), num_workers=2, killed_at=KILLED_AT)
    with tempfile.TemporaryDirectory() as folder:
        undisturbed = train(Path(folder) / "one.pt", num_workers=2)
        path = Path(folder) / "two.pt"
        status = subprocess.run([sys.executable, __file__, str(path)], check=False).returncode
        resumed = train(path, num_workers=0)
    print(f"killed at step {KILLED_AT} of {len(undisturbed)} (exit status {status}), resumed")
    print(f"losses {resumed[0]:.4f} ... {resumed[-1]:.4f}; the same: {resumed == undisturbed}")
    assert status < 0
    assert resumed == undisturbed


if __name__ == "__main__":
    main()
