"""Workers do not outlive the process that started them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

_TRAINING = """
import os, sys, time
from affectsim_data import AffectSimDataset, data_loader

class Numbered(AffectSimDataset):
    def __getitems__(self, places):
        return [os.getpid() for place in places]

def greet(worker_id):
    print("hello from", worker_id, flush=True)

if __name__ == "__main__":
    dataset = Numbered(sys.argv[1], split="train", images=False)
    loader = data_loader(dataset, num_workers=2, worker_init_fn=greet, persistent_workers=True)
    pids = {int(batch) for batch in loader}
    print("workers", *pids, flush=True)
    time.sleep(60)
"""


def is_alive(pid: int) -> bool:
    """Whether there is such a process, zombies not counted."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def test_workers_end_with_a_training_run_that_is_killed(
    small_release_path: Path, tmp_path: Path
) -> None:
    script = tmp_path / "training.py"
    script.write_text(_TRAINING)
    with subprocess.Popen(
        [sys.executable, str(script), str(small_release_path)], stdout=subprocess.PIPE, text=True
    ) as training:
        assert training.stdout is not None
        lines = [training.stdout.readline().split() for _ in range(3)]
        assert sorted(lines[:2]) == [["hello", "from", "0"], ["hello", "from", "1"]]
        workers = [int(pid) for pid in lines[2][1:]]
        assert len(workers) == 2
        assert all(map(is_alive, workers))
        os.kill(training.pid, signal.SIGKILL)
        training.wait()
        deadline = time.monotonic() + 30.0
        while any(map(is_alive, workers)) and time.monotonic() < deadline:
            time.sleep(0.05)
        assert not any(map(is_alive, workers))
