"""`stagecad optimize` as the user types it."""

import json
import re
from pathlib import Path

import pytest

from stagecad.parameters.load import load_design
from workbench.cli import run as stagecad

FREE = ["--free", "actuator.stroke_amplitude=4 um:12 um"]


def _document(capsys: pytest.CaptureFixture[str], *words: str) -> dict:
    assert stagecad(["optimize", "--no-solids", "--budget", "30", *words, "--json"]) == 0
    said = capsys.readouterr()
    # While it searches.
    assert re.match(r"best so far: \d+ rules violated, \d+ of \d+ checks failed: ", said.err), said.err
    return json.loads(said.out)


@pytest.fixture(autouse=True)
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    # No parameter of this file is marked free.
    text = (
        'extends = "thesis"\n# why so much\n[actuator]\nstroke_amplitude = {value = "10 um", origin = "thesis 4.1"}\n'
    )
    Path("stage.toml").write_text(text, encoding="utf-8")


def test_writes_a_design_whose_origins_state_the_reasons(capsys: pytest.CaptureFixture[str]) -> None:
    found = _document(capsys, *FREE, "--keep", "piezo stroke of the drive", "--write", "new.toml")
    assert found["feasible"]
    change = next(one for one in found["changes"] if one["key"] == "actuator.stroke_amplitude")
    assert change["from"] == "10 um" and "piezo stroke of the drive" in change["reason"]
    margin = next(one for one in found["margins"] if one["check"] == "piezo stroke of the drive")
    assert (margin["before"]["verdict"], margin["after"]["verdict"]) == ("fails", "passes")
    text = Path("new.toml").read_text("utf-8")
    assert "# why so much" in text
    entry = load_design("new.toml").entry("actuator.stroke_amplitude")
    assert entry.origin.startswith("assumed: optimised from") and "piezo stroke of the drive" in entry.origin
    assert stagecad(["optimize", *FREE, "--write", "new.toml"]) == 2
    assert "is there already" in capsys.readouterr().err


def test_says_what_cannot_be_met(capsys: pytest.CaptureFixture[str]) -> None:
    found = _document(capsys, *FREE, "--keep", "LVDT range", "--write", "new.toml")
    assert not found["feasible"]
    assert found["conflicts"] == [["LVDT range"]]
    (relax,) = found["relax"]
    assert (relax["check"], relax["limit"]["value"]) == ("LVDT range", 0.2)
    assert relax["needed"]["value"] == pytest.approx(0.0254)
    assert not Path("new.toml").exists()
    assert stagecad(["optimize", "--no-solids", *FREE, "--keep", "LVDT range", "--budget", "30"]) == 0
    assert "no design within the ranges meets all 1 requirements" in capsys.readouterr().out


@pytest.mark.parametrize(
    "words, message",
    [
        (["--free", "stage.thicknes=8 mm:9 mm"], "did you mean 'stage.thickness'"),
        (["--keep", "LVDT rnge"], "did you mean 'LVDT range'"),
    ],
)
def test_mistakes_are_one_line(words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert stagecad(["optimize", "--no-solids", *words]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
