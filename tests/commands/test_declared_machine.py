"""Machines declared in a parameter file, through the commands."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from workbench.cli import run as stagecad

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from designcalc.checks.run import OWN

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    yield
    OWN.clear()


def _document(capsys: pytest.CaptureFixture[str], *words: str) -> dict:
    capsys.readouterr()
    assert stagecad([*words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_ball_screw_slide_of_three_parts(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(EXAMPLES / "ball_screw_slide", "slide")
    monkeypatch.chdir("slide")
    assert stagecad(["parts"]) == 2
    assert "--trust" in capsys.readouterr().err
    found = _document(capsys, "parts", "--trust")
    shaft = 3.141592653589793 / 4 * (16**2 * 340 + 2 * 12**2 * 20) * 1e-9
    assert found["parts"]["screw"]["volume"]["value"] == pytest.approx(shaft, rel=1e-6)
    whole = sum(part["mass"]["value"] for part in found["parts"].values())
    assert found["assembly"]["mass"]["value"] == pytest.approx(whole)
    # The thread of the nut is the ring between its core and the screw.
    pairs = {frozenset((one["first"], one["second"])): one for one in found["interference"]}
    thread = pairs[frozenset(("screw", "carriage"))]
    assert thread["kind"] == "overlap"
    assert thread["common_volume"] == pytest.approx(3.141592653589793 / 4 * (16**2 - 14**2) * 80e-9, rel=1e-6)
    assert not [one for one in found["interference"] if one["kind"] == "clash"]
    rows = Path("build/bill_of_materials.csv").read_text("utf-8").splitlines()
    assert len(rows) == 5 and "BS 16x5" in rows[2]
    assert "PRODUCT" in Path("build/assembly.step").read_text("ascii")
    # Without the permission the thread is a clash.
    Path("stage.toml").write_text(Path("stage.toml").read_text("utf-8").replace("overlaps =", "# overlaps ="), "utf-8")
    found = _document(capsys, "parts")
    assert [one["kind"] for one in found["interference"]].count("clash") == 1


def test_own_checks_read_parameters_and_masses_of_the_parts(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(EXAMPLES / "ball_screw_slide", "slide")
    monkeypatch.chdir("slide")
    (check,) = _document(capsys, "check", "--trust")
    assert check["verdict"] == "passes"
    assert check["inputs"]["screw.length"]["value"] == pytest.approx(0.340)
    assert check["inputs"]["carriage.mass"]["value"] == pytest.approx(0.939, rel=0.01)
    assert stagecad(["check", "--sweep", "stage.thickness=8mm:9mm"]) == 2
    assert "declares another one" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("name, sheets", [("ball_screw_slide", 2), ("two_axis_stage", 7)])
def test_examples_are_made(
    name: str, sheets: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(EXAMPLES / name, "machine")
    monkeypatch.chdir("machine")
    found = _document(capsys, "make", "--trust")
    assert len(found["sheets"]) == sheets
    assert [sheet["hits"] for sheet in found["sheets"]] == [[]] * sheets
    assert not [one for one in found["interference"] if one["kind"] == "clash"]
    assert all(Path(file).stat().st_size > 100 for sheet in found["sheets"] for file in sheet.get("files", ()))


@pytest.mark.slow
def test_template_of_a_machine_is_made(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    assert stagecad(["new", "machine", "mill"]) == 0
    monkeypatch.chdir("mill")
    found = _document(capsys, "make", "--trust")
    assert found["assembly"]["bounding_box"]["value"][1][2] == pytest.approx(0.028)
    assert len(found["sheets"]) == 2 and not [hit for sheet in found["sheets"] for hit in sheet["hits"]]
