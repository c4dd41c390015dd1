"""What every command does with its options and their completion, and how it ends for reasons outside the program."""

import errno
import os
import py_compile
import shlex
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import click
import pytest

import workbench.cli.commands.parts as parts_command
from stagecad.parameters.errors import LostProcessError
from tests.process_state import python
from tests.reference.tables import cases, reference
from workbench.cli import run
from workbench.cli.dispatch import COMMANDS, _settled, stagecad
from workbench.operations.templates import fresh_copy

MISTAKES = [
    *((line.split(), f"stagecad: {message}\n") for line, message in cases("mistaken_options", "mistakes")),
    *(((*command.split(), *words), said) for command, rows in reference("mistakes")["command"].items()
      for words, said in rows),
]  # fmt: skip


@pytest.mark.parametrize(("words", "message"), MISTAKES, ids=[" ".join(words)[:60] for words, _ in MISTAKES])
def test_a_mistake_is_one_line_and_nothing_is_written(tmp_path, monkeypatch, command, words, message):
    """The whole line, or a part of it that no other line has."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "notes.toml").write_text("")
    line = command.refused(*words)
    assert line == message if message.endswith("\n") else message in line
    assert [path.name for path in tmp_path.iterdir()] == ["notes.toml"]


def test_a_json_file_that_cannot_be_written_stops_a_command_before_it_does_anything(tmp_path, command):
    folder = fresh_copy(tmp_path / "rig")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    (tmp_path / "is_folder.json").mkdir()
    for target, message in (
        ("is_folder.json", "is_folder.json: is a folder; a file is required"),
        ("rig/fit.csv/deeper/out.json", f"out.json: {folder / 'fit.csv'} is a file, not a folder"),
    ):
        assert command.refused("add", folder, "stribeck", "--json", tmp_path / target).endswith(f"{message}\n")
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

    monkeypatch.setattr(parts_command, "parts", failing)
    with monkeypatch.context() as patch:
        # A full disk closes it.
        patch.setattr(sys, "stdout", sys.stdout)
        assert run(["parts"]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"stagecad: {line}") and said.count("\n") == 1 and said[:-1].isprintable()


def test_a_module_whose_compiled_form_is_cut_off_is_named(tmp_path, monkeypatch, command) -> None:
    (tmp_path / "cut_module.py").write_text("value = 1\n")
    compiled = Path(py_compile.compile(str(tmp_path / "cut_module.py"), doraise=True) or "")
    compiled.write_bytes(compiled.read_bytes()[:20])
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(parts_command, "parts", lambda *arguments: import_module("cut_module"))
    assert command("parts", status=2).err.strip() == f"stagecad: {compiled}: is cut off; remove it"


def test_a_library_that_is_missing_is_no_lack_of_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*arguments: object) -> None:
        raise ImportError("No module named 'cadquery'")

    monkeypatch.setattr(parts_command, "parts", failing)
    with pytest.raises(ImportError, match="cadquery"):
        run(["parts"])


def _asked(instruction: str, line: str = "") -> subprocess.CompletedProcess[str]:
    words = {"_STAGECAD_COMPLETE": f"bash_{instruction}", "COMP_WORDS": line, "COMP_CWORD": "1"}
    # The name of the variable follows from that of the program.
    program = "import sys; from workbench.cli.main import main; sys.argv[0] = 'stagecad'; sys.exit(main())"
    return python("-c", program, **words)


def test_a_word_is_completed_without_a_message() -> None:
    done = _asked("complete", "stagecad dia")
    assert done.stdout.split() == ["plain,diagnose"] and done.stderr == "" and done.returncode == 0
    script = _asked("source")
    assert "stagecad" in script.stdout and script.stderr == ""


@pytest.mark.parametrize("name", COMMANDS)
def test_help_has_two_examples_that_the_command_line_accepts(name, command):
    examples, said = COMMANDS[name][1:], command(name, "--help").out
    assert len(examples) == 2
    for example in examples:
        assert f"  {example}\n" in said
        called, *words = _settled(shlex.split(example.removeprefix("stagecad ")))
        assert called in (name, "new")
        if called != "new" and words != ["rail", "--help"]:
            assert stagecad.get_command(click.Context(stagecad), called).make_context(called, words).params


def test_options_without_effect_are_accepted_and_not_in_the_help(command):
    assert "--params" not in command("effects", "--help").out and "--out" not in command("params", "--help").out
    assert "stribeck" in command("effects", "stribeck", "--set", "stage.thickness=14 mm").out


@pytest.mark.parametrize(
    ("word", "meant"),
    [("fit", "compare"), ("sheets", "drawings"), ("compar", "compare"), ("rigs", "new"), ("effect", "effects")],
)
def test_an_unknown_command_is_answered_by_the_one_whose_words_say_it(command, word, meant):
    assert f"no command '{word}'; did you mean '{meant}'?" in command(word, status=2).err
