"""`stagecad new`: templates that work as they are written."""

from pathlib import Path
from typing import Any

import pytest

from designcalc.checks.run import OWN
from designcalc.optimisation.search import free_parameters
from sim.effects.custom import load_custom
from stagecad.consent import give_consent
from stagecad.parameters.file import read_parameter_file
from stagecad.parameters.load import load_design, part_design
from tests.experiments import replace_in


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


def test_part_is_drawn_after_consent(command: Any) -> None:
    assert command("new", "part", "bracket").out == "written: bracket.py\n"
    assert "--trust" in command("drawings", "--part", "bracket.py", status=2).err
    document = command.json("drawings", "--part", "bracket.py", "--trust", "--lint", "--out", "out")
    holes = 2 * 3.141592653589793 / 4 * 6.6**2 * 8
    assert document["volume"]["value"] == pytest.approx((60 * 40 * 8 - holes) * 1e-9, rel=1e-6)
    assert [sheet["hits"] for sheet in document["sheets"]] == [[]]
    assert all(Path(file).stat().st_size > 100 for file in document["files"])
    model = Path("out/bracket_ap242.step").read_text("ascii")
    assert "AP242" in model and "DIMENSIONAL_SIZE" in model
    # The same content needs no second consent; a changed file does.
    command("drawings", "--part", "bracket.py", "--out", "out")
    text = Path("bracket.py").read_text("utf-8")
    Path("bracket.py").write_text(text.replace('(x, -y, z), view="top")', '(x + 1, -y, z), view="top")'), "utf-8")
    command("drawings", "--part", "bracket.py", "--out", "out", status=2)
    # A dimension that is not on the solid is refused.
    assert "length" in command("drawings", "--part", "bracket.py", "--trust", "--out", "out", status=2).err
    # Without declarations they are proposed.
    Path("bracket.py").write_text(text.partition("def dimensions")[0], "utf-8")
    drawn = command.json("drawings", "--part", "bracket.py", "--trust", "--lint", "--out", "bare")
    assert drawn["proposed"] and any(Path(file).name == "bracket_proposed.py" for file in drawn["files"])


def test_check_of_a_project_runs_as_written_and_after_consent_when_edited(command: Any, monkeypatch) -> None:
    printed = command("new", "machine", "mill").out
    monkeypatch.chdir("mill")
    assert printed.splitlines()[-1] == "next: cd mill, then: stagecad check"
    try:
        found = command.json("check", "--no-solids")
        OWN.clear()
        replace_in(Path("checks/mill_check.py"), "SUBJECT = ", "# Edited.\nSUBJECT = ")
        assert "mill_check.py: is Python code that has changed" in command("check", "--no-solids", status=2).err
        assert command.json("check", "--no-solids", "--trust") == found
        # A value of the file keeps the class of the part's; one part alone has no values of the others.
        assert command.json("params", "plate")["parameters"]["plate.thickness"]["tolerance"] == "X.X"
        # The packaged ranges are of parts that the machine has not.
        assert "no design was found" in command("optimize", "--no-solids", "--set", "plate.length=400 mm").out
        assert [one.key for one in free_parameters(load_design("stage.toml"), ())] == ["plate.thickness"]
        command("new", "part", "lid")
        # A value that follows from another part is that of the whole machine.
        mates = "lid = {file = 'lid.py'}\n[machine.mates]\nlid = {datum = 'bottom', on = 'plate.top'}"
        replace_in(Path("stage.toml"), "[machine.mates]", mates)
        with Path("stage.toml").open("a", encoding="utf-8") as file:
            file.write("[lid]\nlength = '=2 * plate.length'\nwidth = '=lid.length / 4'\n")
        alone = part_design(read_parameter_file(Path("stage.toml")), (), Path("lid.py"))
        assert (alone.value("lid.length"), alone.value("lid.width")) == (120.0, 30.0)
        replace_in(Path("checks/mill_check.py"), '"plate.length"', '"plate.lenght"')
        said = command("check", "--no-solids", "--trust", status=2).err
        assert "mill_check.py: line 11: LookupError: no parameter 'plate.lenght'; did you mean 'plate.length'?" in said
        replace_in(
            Path("checks/mill_check.py"),
            'length, thickness = r("plate.lenght"), r("plate.thickness")',
            "length = thickness = 0.01",
        )
        assert "no tolerance moves a margin" in command("check", "--no-solids", "--trust", "--tolerance").out
    finally:
        OWN.clear()
    own = next(one for one in found if one["subject"] == "own checks")
    assert own["value"]["value"] == pytest.approx(60 / 8) and own["verdict"] == "passes"
    assert "plate.thickness" in own["inputs"]


def test_files_of_templates_are_read_and_never_overwritten(command: Any, monkeypatch) -> None:
    command("new", "effect", "bellows")
    give_consent((Path("bellows.py"),))
    assert [one.name for one in load_custom(Path("bellows.py"))] == ["bellows"]
    command("new", "part", "bracket")
    assert "is there already" in command("new", "part", "bracket", status=2).err
    monkeypatch.setenv("COLUMNS", "60")
    lines = command("new", "example", "own_rig").out.splitlines()
    assert lines[-1] == "next: stagecad compare own_rig"
    assert lines[0] == "written: own_rig" and max(map(len, lines)) <= 60 and len(lines) > 2


def test_hardware_table_of_a_project_takes_part_in_checks_and_list_of_parts(command: Any) -> None:
    assert 'piezos = "piezos.csv"' in command("new", "hardware", "piezos").out
    table = Path("piezos.csv").read_text("utf-8").replace("20,17", "20,38")
    table = table.replace("ASB170C801NP0,ASB170C801NP0", "mine,P-1")
    Path("piezos.csv").write_text(table, "utf-8")
    stage = 'extends = "thesis"\n[hardware]\npiezos = "piezos.csv"\n[piezo]\nrow = "mine"\n'
    Path("stage.toml").write_text(stage, "utf-8")
    found = command.json("check", "--no-solids", status=1)
    stroke = next(one for one in found if one["name"] == "piezo stroke of the drive")
    assert stroke["limit"]["value"] == pytest.approx(38e-6) and stroke["verdict"] == "passes"
    command("parts", "piezo", "assembly")
    assert ",P-1," in Path("build/parts/bill_of_materials.csv").read_text("utf-8")
    said = command("new", "hardware", "bolts", status=2).err
    assert "no such kind of table; allowed: materials, piezos, screws" in said
