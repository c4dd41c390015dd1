"""What every command does with its options, whether or not it needs them."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.reference.tables import cases
from workbench import cli
from workbench.operations.measurement.demonstration import fresh_copy


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
