"""Files of weights: plain numbers in safetensors with a mark of their kind, never pickle."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import torch
    from torch import nn

__all__ = ["WeightsFile"]


@dataclasses.dataclass(frozen=True)
class WeightsFile:
    """What files with the weights of one network are."""

    network: str
    """Name of the network, for messages."""
    mark: str
    """Metadata `format` of every such file."""
    max_bytes: int
    """No file of it is larger."""
    making: str
    """How one gets such a file, for messages."""

    def load(self, path: Path, network: nn.Module) -> dict[str, str]:
        """Puts the weights of a file into a network.

        Args:
            path: Of the file.
            network: Of the kind the file is for; whatever its weights are is lost.

        Returns:
            The file's metadata.

        Raises:
            FileNotFoundError: No such file.
            ValueError: Not such a file.
        """
        metadata, weights = self._read(path)
        try:
            network.load_state_dict(weights)
        except RuntimeError as error:
            raise ValueError(f"{path}: weights do not fit the network: {error}") from error
        return metadata

    def _read(self, path: Path) -> tuple[dict[str, str], dict[str, torch.Tensor]]:
        from safetensors import SafetensorError, safe_open

        if not path.is_file():
            raise FileNotFoundError(f"{path}: no such file of weights; {self.making}")
        if path.stat().st_size > self.max_bytes:
            raise ValueError(f"{path}: is larger than {self.max_bytes} bytes, so no {self.network}")
        try:
            with safe_open(str(path), framework="pt") as file:
                metadata = file.metadata() or {}
                weights = {key: file.get_tensor(key) for key in file.keys()}  # noqa: SIM118  # no mapping
        except SafetensorError as error:
            raise ValueError(f"{path}: must be a file in safetensors: {error}") from error
        if metadata.get("format") != self.mark:
            raise ValueError(
                f"{path}: must be weights of a {self.network} ({self.mark}), "
                f"got format {metadata.get('format')!r}; {self.making}"
            )
        return metadata, weights

    def save(
        self,
        path: Path,
        weights: Mapping[str, torch.Tensor],
        *,
        training: Mapping[str, object],
        **metadata: str,
    ) -> None:
        """Writes what `load` reads.

        Args:
            path: Of the file; its folder is made if need be.
            weights: Of the network, by name.
            training: A note on how they were trained.
            metadata: What else the file says of itself.
        """
        from safetensors.torch import save_file

        plain = {key: value.detach().cpu().contiguous() for key, value in weights.items()}
        told = {"format": self.mark, **metadata, "training": json.dumps(dict(training))}
        path.parent.mkdir(parents=True, exist_ok=True)
        save_file(plain, str(path), metadata=told)
        path.chmod(0o644)
