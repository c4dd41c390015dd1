"""`stagecad new`: templates that work as they are written."""

import json
from pathlib import Path

import pytest

from designcalc.checks.run import OWN
from sim.effects.custom import load_custom
from stagecad.consent import give_consent
from workbench.cli import run as stagecad


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


def test_part_is_drawn_after_consent(capsys: pytest.CaptureFixture[str]) -> None:
    assert stagecad(["new", "part", "bracket"]) == 0
    assert capsys.readouterr().out == "written: bracket.py\n"
    assert stagecad(["drawings", "--part", "bracket.py"]) == 2
    assert "--trust" in capsys.readouterr().err
    assert stagecad(["drawings", "--part", "bracket.py", "--trust", "--lint", "--out", "out", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    holes = 2 * 3.141592653589793 / 4 * 6.6**2 * 8
    assert document["volume"]["value"] == pytest.approx((60 * 40 * 8 - holes) * 1e-9, rel=1e-6)
    assert [sheet["hits"] for sheet in document["sheets"]] == [[]]
    assert all(Path(file).stat().st_size > 100 for file in document["files"])
    model = Path("out/bracket_ap242.step").read_text("ascii")
    assert "AP242" in model and "DIMENSIONAL_SIZE" in model
    # The same content needs no second consent; a changed file does.
    assert stagecad(["drawings", "--part", "bracket.py", "--out", "out"]) == 0
    text = Path("bracket.py").read_text("utf-8")
    Path("bracket.py").write_text(text.replace('(x, -y, z), view="top")', '(x + 1, -y, z), view="top")'), "utf-8")
    assert stagecad(["drawings", "--part", "bracket.py", "--out", "out"]) == 2
    capsys.readouterr()
    # A dimension that is not on the solid is refused.
    assert stagecad(["drawings", "--part", "bracket.py", "--trust", "--out", "out"]) == 2
    assert "length" in capsys.readouterr().err


def test_check_of_a_project_runs_after_consent(capsys: pytest.CaptureFixture[str], monkeypatch) -> None:
    assert stagecad(["new", "machine", "mill"]) == 0
    monkeypatch.chdir("mill")
    assert capsys.readouterr().out.splitlines()[-1] == "next: cd mill, then: stagecad check --trust"
    assert stagecad(["check", "--no-solids"]) == 2
    assert "mill_check.py" in capsys.readouterr().err
    try:
        stagecad(["check", "--no-solids", "--trust", "--json"])
        found = json.loads(capsys.readouterr().out)
    finally:
        OWN.clear()
    own = next(one for one in found if one["subject"] == "own checks")
    assert own["value"]["value"] == pytest.approx(230 / 14) and own["verdict"] == "passes"
    assert "stage.thickness" in own["inputs"]


def test_effect_of_the_template_is_read(capsys: pytest.CaptureFixture[str]) -> None:
    assert stagecad(["new", "effect", "bellows"]) == 0
    give_consent((Path("bellows.py"),))
    assert [one.name for one in load_custom(Path("bellows.py"))] == ["bellows"]


@pytest.mark.parametrize(
    "words, message",
    [
        (["new", "part", "My-Part"], "small letters"),
        (["new", "effect", "stribeck"], "new effect 'stribeck': is an effect of the library; choose another name"),
        (["new", "prt", "x"], "no template of a 'prt'; did you mean 'part'?"),
    ],
)
def test_mistakes(words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert stagecad(words) == 2
    assert message in capsys.readouterr().err


def test_nothing_is_overwritten(capsys: pytest.CaptureFixture[str]) -> None:
    assert stagecad(["new", "part", "bracket"]) == 0
    assert stagecad(["new", "part", "bracket"]) == 2
    assert "is there already" in capsys.readouterr().err


def test_hardware_table_of_a_project_takes_part_in_checks_and_list_of_parts(capsys: pytest.CaptureFixture[str]) -> None:
    assert stagecad(["new", "hardware", "piezos"]) == 0
    assert 'piezos = "piezos.csv"' in capsys.readouterr().out
    table = Path("piezos.csv").read_text("utf-8").replace("20,17", "20,38")
    table = table.replace("ASB170C801NP0,ASB170C801NP0", "mine,P-1")
    Path("piezos.csv").write_text(table, "utf-8")
    Path("stage.toml").write_text(
        'extends = "thesis"\n[hardware]\npiezos = "piezos.csv"\n[piezo]\nrow = "mine"\n', "utf-8"
    )
    assert stagecad(["check", "--no-solids", "--json"]) == 1
    stroke = next(one for one in json.loads(capsys.readouterr().out) if one["name"] == "piezo stroke of the drive")
    assert stroke["limit"]["value"] == pytest.approx(38e-6) and stroke["verdict"] == "passes"
    assert stagecad(["parts", "piezo", "assembly"]) == 0
    assert ",P-1," in Path("build/parts/bill_of_materials.csv").read_text("utf-8")
    assert stagecad(["new", "hardware", "bolts"]) == 2
    assert "no such kind of table; allowed: materials, piezos, screws" in capsys.readouterr().err


def test_the_words_on_an_example_fit_the_width(capsys: pytest.CaptureFixture[str], monkeypatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    assert stagecad(["new", "example", "own_rig"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "written: own_rig" and max(map(len, lines)) <= 60 and len(lines) > 2
