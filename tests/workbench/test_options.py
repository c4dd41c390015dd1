"""What every command does with its options, and how it ends for reasons outside the program."""

import errno
import os
import py_compile
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import workbench.cli.commands.parts as command
from stagecad.parameters.errors import LostProcessError
from tests.reference.tables import cases
from workbench import cli
from workbench.cli import run
from workbench.operations.templates import fresh_copy


@pytest.mark.parametrize(("line", "message"), cases("mistaken_options", "mistakes"))
def test_a_mistake_is_one_line_and_nothing_is_written(tmp_path, monkeypatch, capsys, line, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "notes.toml").write_text("")
    assert cli.run(line.split()) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == f"stagecad: {message}\n"
    assert [path.name for path in tmp_path.iterdir()] == ["notes.toml"]


def test_a_json_file_that_cannot_be_written_stops_a_command_before_it_does_anything(tmp_path, capsys):
    folder = fresh_copy(tmp_path / "rig")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    (tmp_path / "is_folder.json").mkdir()
    for target, message in (
        ("is_folder.json", "is_folder.json: is a folder; a file is required"),
        ("rig/fit.csv/deeper/out.json", f"out.json: {folder / 'fit.csv'} is a file, not a folder"),
    ):
        assert cli.run(["add", str(folder), "stribeck", "--json", str(tmp_path / target)]) == 2
        said = capsys.readouterr()
        assert (said.out, said.err.count("\n")) == ("", 1)
        assert said.err.endswith(f"{message}\n")
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
@pytest.mark.parametrize("words", [["effects", "viscous"], ["effects", "--json"]])
def test_a_full_disk_is_one_line(words):
    with Path("/dev/full").open("w") as full:
        run = subprocess.run(
            [sys.executable, "-m", "workbench.cli", *words], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert run.returncode == 2
    # With a JSON document what is meant for a person stands there before it.
    assert run.stderr.splitlines()[-1] == "stagecad: no space is left to write to; no file is left half written"
    assert "Traceback" not in run.stderr


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
def test_one_line(error: Exception, line: str, monkeypatch, capsys) -> None:
    def failing(*arguments: object) -> None:
        raise error

    monkeypatch.setattr(command, "parts", failing)
    with monkeypatch.context() as patch:
        # A full disk closes it.
        patch.setattr(sys, "stdout", sys.stdout)
        assert run(["parts"]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"stagecad: {line}") and said.count("\n") == 1 and said[:-1].isprintable()


def test_a_module_whose_compiled_form_is_cut_off_is_named(tmp_path, monkeypatch, capsys) -> None:
    (tmp_path / "cut_module.py").write_text("value = 1\n")
    compiled = Path(py_compile.compile(str(tmp_path / "cut_module.py"), doraise=True) or "")
    compiled.write_bytes(compiled.read_bytes()[:20])
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(command, "parts", lambda *arguments: import_module("cut_module"))
    assert run(["parts"]) == 2
    assert capsys.readouterr().err.strip() == f"stagecad: {compiled}: is cut off; remove it"


def test_a_library_that_is_missing_is_no_lack_of_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*arguments: object) -> None:
        raise ImportError("No module named 'cadquery'")

    monkeypatch.setattr(command, "parts", failing)
    with pytest.raises(ImportError, match="cadquery"):
        run(["parts"])
