"""Every way a command can fail for reasons outside the program is one line and exit status 2."""

import errno
import os
import sys

import pytest

import workbench.cli.commands.parts as command
from stagecad.parameters.errors import LostProcessError
from workbench.cli import run


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (LostProcessError("'base': its process ended without a result, twice"), "'base': its process ended"),
        (MemoryError(), "there is not enough memory"),
        (ImportError("lib.so: failed to map segment from shared object"), "there is not enough memory"),
        (TimeoutError("'base' took more than 120 s"), "'base' took more than 120 s"),
        (OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)), "no space is left to write to"),
        (OSError(errno.EFBIG, "File too large", "out\x1b/base.step"), r"out\x1b/base.step: File too large"),
        (OSError("libllvmlite.so: failed to map segment"), "libllvmlite.so: failed to map segment"),
    ],
)
def test_one_line(
    error: Exception, line: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def failing(*arguments: object) -> None:
        raise error

    monkeypatch.setattr(command, "parts", failing)
    with monkeypatch.context() as patch:
        # A full disk closes it.
        patch.setattr(sys, "stdout", sys.stdout)
        assert run(["parts"]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"stagecad: {line}") and said.count("\n") == 1 and said[:-1].isprintable()


def test_a_library_that_is_missing_is_no_lack_of_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*arguments: object) -> None:
        raise ImportError("No module named 'cadquery'")

    monkeypatch.setattr(command, "parts", failing)
    with pytest.raises(ImportError, match="cadquery"):
        run(["parts"])
