"""You learn: the dataset in a stock DataLoader with workers, and a model that trains on it.

A small network learns emotions from 16 x 16 silhouettes of the reference view, and is tested on
another performer. The built-in performances are stylised, so this is easier than it is with people.
"""

from __future__ import annotations

import torch
from torch import nn
from torch.utils.data import DataLoader

from affectsim_data import AffectSimDataset, Sample


def silhouettes(sample: Sample) -> tuple[torch.Tensor, int]:
    """Person masks `(8, 16, 16)` and the label."""
    masks = (sample["instances"][:, 0] == 1).float()
    return nn.functional.adaptive_avg_pool2d(masks, 16), sample["label"]


def main() -> None:
    torch.manual_seed(0)
    loaders = {
        split: DataLoader(
            AffectSimDataset(split=split, condition="p_ref", instances=True, transform=silhouettes),
            batch_size=16,
            shuffle=split == "train",
            num_workers=2,
        )
        for split in ("train", "test")
    }
    batches = {split: list(loader) for split, loader in loaders.items()}
    model = nn.Sequential(nn.Flatten(), nn.Linear(8 * 16 * 16, 64), nn.ReLU(), nn.Linear(64, 5))
    optimizer = torch.optim.Adam(model.parameters(), lr=1e-3)
    for epoch in range(20):
        for frames, labels in batches["train"]:
            optimizer.zero_grad()
            loss = nn.functional.cross_entropy(model(frames), labels)
            loss.backward()  # type: ignore[no-untyped-call]  # torch's own
            optimizer.step()
        if epoch % 5 == 4:
            print(f"epoch {epoch + 1}: loss {loss.item():.3f}")
    with torch.no_grad():
        right = torch.cat([model(x).argmax(1) == y for x, y in batches["test"]]).float().mean()
    print(f"test accuracy {100 * right:.0f} % (chance 20 %)")


if __name__ == "__main__":
    main()
