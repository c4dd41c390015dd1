"""Processes that a test starts, which find the packages wherever they run: whether they run, and what they do."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
PROGRAM = ("-m", "workbench.cli")


def python(*words: Any, folder: Path | None = None, status: int = 0, **changed: str) -> subprocess.CompletedProcess:
    """Run Python with the words and `changed` environment variables; it must end with the status."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **changed}
    command = [sys.executable, *map(str, words)]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=240)
    assert done.returncode == status, done.stderr
    return done


def begun(*words: Any, **changed: str) -> subprocess.Popen[str]:
    """Begin such a process in a session of its own, which heeds Ctrl-C; its errors are at hand."""
    # What a shell starts in the background ignores interrupts, and so does all that is started from there.
    heed = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    return subprocess.Popen(
        [sys.executable, *map(str, words)],
        env={**os.environ, "PYTHONPATH": str(ROOT), **changed},
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heed,
    )


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
