"""A rung says what came and what went, on the terminal and in the ladder's document."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from workbench import cli
from workbench.commands.demo import fresh_copy
from workbench.console.rung_words import change_words


@pytest.mark.parametrize(
    ("number", "added", "removed", "words"),
    [
        (0, [], [], "the beginning"),
        (1, ["stribeck"], [], "stribeck"),
        (2, ["presliding", "stribeck"], ["coulomb"], "presliding, stribeck, without coulomb"),
        (3, [], ["viscous", "backlash"], "without viscous and backlash"),
        (4, [], [], "[model] edited by hand"),
    ],
)
def test_words(number: int, added: list[str], removed: list[str], words: str) -> None:
    assert change_words({"rung": number, "added": added, "removed": removed}, "the beginning") == words


def test_an_effect_dropped_is_said_to_be_gone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = fresh_copy(tmp_path / "rig")
    assert cli.run(["add", str(folder), "--drop", "viscous", "--json"]) == 0
    said = capsys.readouterr()
    assert "Rung 001: - viscous" in said.err
    document = json.loads(said.out)
    assert (document["added"], document["removed"]) == ([], ["viscous"])
    assert cli.run(["ladder", str(folder), "--out", str(tmp_path / "out"), "--json"]) == 0
    said = capsys.readouterr()
    assert "without viscous" in said.err
    assert "by hand" not in said.err
    assert [rung["removed"] for rung in json.loads(said.out)] == [[], ["viscous"]]
    assert "without viscous" in (tmp_path / "out" / "rig" / "report.html").read_text(encoding="utf-8")
