"""Files of weights come back as they were, and nothing else is taken for one."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import torch
from safetensors.torch import save_file
from torch import nn

from affectsim_data.weights import WeightsFile

FILE = WeightsFile(network="Linear", mark="linear-1", max_bytes=1000, making="`make` makes one")


def test_weights_come_back_with_what_is_said_of_them(tmp_path: Path) -> None:
    torch.manual_seed(0)
    path, network, again = tmp_path / "new/a.safetensors", nn.Linear(3, 2), nn.Linear(3, 2)
    FILE.save(path, network.state_dict(), training={"epochs": 2}, name="straight")
    told = FILE.load(path, again)
    assert told == {"format": "linear-1", "name": "straight", "training": '{"epochs": 2}'}
    assert torch.equal(again.weight, network.weight)
    assert torch.equal(again.bias, network.bias)


def test_half_precision_becomes_that_of_the_network(tmp_path: Path) -> None:
    network = nn.Linear(3, 2)
    half = {name: value.half() for name, value in network.state_dict().items()}
    FILE.save(tmp_path / "half", half, training={})
    FILE.load(tmp_path / "half", network)
    assert network.weight.dtype == torch.float32
    assert torch.equal(network.weight, half["weight"].float())


def test_other_files_are_refused(tmp_path: Path) -> None:
    path, network = tmp_path / "a.safetensors", nn.Linear(3, 2)
    with pytest.raises(FileNotFoundError, match="no such file of weights; `make` makes one"):
        FILE.load(path, network)
    path.write_bytes(b"\x80\x04pickled")
    with pytest.raises(ValueError, match=r"a\.safetensors: must be a file in safetensors"):
        FILE.load(path, network)
    path.write_bytes(bytes(1001))
    with pytest.raises(ValueError, match="is larger than 1000 bytes, so no Linear"):
        FILE.load(path, network)
    save_file(network.state_dict(), str(path), metadata={"format": "another"})
    message = re.escape("must be weights of a Linear (linear-1), got format 'another'; `make`")
    with pytest.raises(ValueError, match=message):
        FILE.load(path, network)
    FILE.save(path, nn.Linear(1, 1).state_dict(), training={})
    with pytest.raises(ValueError, match="weights do not fit the network"):
        FILE.load(path, network)
