"""Ctrl-C at any moment ends a command with one word and status 130, and nothing it started outlives it."""

import os
import signal
import subprocess
import time

import pytest

from tests.process_state import PROGRAM, begun, group_runs, python, wait_until

INTERRUPTED_IMPORT = """
import sys

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == {name!r}:
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interrupt())
from workbench.cli import main
sys.argv = ["stagecad", *{words!r}]
main()
"""


@pytest.mark.parametrize(("name", "words"), [
    ("click", ["--help"]), ("stagecad.parameters.errors", ["check"]),
    ("workbench.cli.commands.simulate", ["simulate", "tip"]), ("numpy", ["simulate", "tip"]),
])  # fmt: skip
def test_an_interrupt_while_python_imports_prints_no_traceback(name, words):
    found = python("-c", INTERRUPTED_IMPORT.format(name=name, words=words), status=130)
    assert (found.stderr.strip(), found.stdout) == ("stopped", "")


def test_an_interrupt_of_parallel_runs_ends_their_processes(tmp_path):
    """As a terminal sends it: to the program and to every process it has started."""
    words = [*PROGRAM, "simulate", "stick-slip", "--draws", "100000", "--set", "friction.breakaway=1.5 +- 0.01 N"]
    started = begun(*words, "--out", tmp_path)
    try:
        wait_until(lambda: _children(started.pid) >= 3)
        time.sleep(0.5)
        os.killpg(started.pid, signal.SIGINT)
        error = started.communicate(timeout=240)[1]
    finally:
        if started.poll() is None:
            os.killpg(started.pid, signal.SIGKILL)
            started.wait()
    assert started.returncode == 130 and error.strip() == "stopped"
    # The helper that multiprocessing keeps for its semaphores notices a moment later that it is alone.
    wait_until(lambda: not group_runs(started.pid))
    assert list(tmp_path.rglob("draws.csv")) == []


def _children(group: int) -> int:
    """Processes of a group, the first among them."""
    found = subprocess.run(["ps", "-o", "pid=", "--ppid", str(group)], capture_output=True, text=True)
    return 1 + len(found.stdout.split())
