"""Processes that a test has started: whether they run, and waiting for what they do."""

import subprocess
import time
from collections.abc import Callable
from pathlib import Path


def running(process: int) -> bool:
    """Whether a process runs; one that has ended, and that nobody has waited for, does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def group_runs(group: int) -> bool:
    """Whether a process of the group runs; one that has ended, and that nobody has waited for, does not."""
    found = subprocess.run(["ps", "-eo", "pgid=,stat="], capture_output=True, text=True).stdout.split()
    return any(int(one) == group and not state.startswith("Z") for one, state in zip(found[::2], found[1::2]))


def wait_until(holds: Callable[[], object], seconds: float = 120.0) -> None:
    """Wait for a condition, on a busy machine too; it fails where the condition never holds."""
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.02)
