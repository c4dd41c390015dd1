"""Functions that tests of the pool have computed in other processes, and the state of these processes."""

import os
import time
from pathlib import Path


def square(n: int) -> int:
    return n * n


def die_once(folder: Path, n: int) -> int:
    """Ends its process the first time."""
    if n == 1 and not (folder / "died").exists():
        (folder / "died").touch()
        os._exit(3)
    return n


def running(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_until_ended(*processes: int) -> None:
    deadline = time.monotonic() + 120.0
    while any(map(running, processes)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(running, processes))
