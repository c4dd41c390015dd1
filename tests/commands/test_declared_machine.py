"""Machines declared in a parameter file take every command that the packaged machine takes."""

import shutil
from pathlib import Path
from typing import Any

import pytest

from designcalc.checks.run import OWN
from tests.experiments import replace_in

EXAMPLES = Path(__file__).parents[2] / "examples"
LONGER = ("340.0 mm", "360.0 mm")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    yield
    OWN.clear()


@pytest.fixture
def slide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(shutil.copytree(EXAMPLES / "ball_screw_slide", "slide"))


LIFE = """from designcalc.checks.check import Check, at_least
def check(r):
    return Check("life", at_least(2000, 1000, "h"), source="catalogue", formula="given")
"""


def test_differences_have_the_margins_of_own_checks(slide: None, command: Any) -> None:
    Path("longer.toml").write_text(Path("stage.toml").read_text("utf-8").replace(*LONGER), encoding="utf-8")
    check = Path("checks/critical_speed.py")
    check.write_text(check.read_text("utf-8").replace("; carriage {r('carriage.mass'):.3g} kg", ""), encoding="utf-8")
    words = ("diff", "stage.toml", "longer.toml", "--no-solids")
    assert "--trust" in command(*words, status=2).err
    said = command(*words, "--trust").out
    assert "critical speed of the screw" in said and "margins" in said


def test_differences_name_the_files_of_parts_and_checks_that_changed(slide: None, command: Any) -> None:
    shutil.copytree(".", "other", ignore=shutil.ignore_patterns("other"))
    words = ("diff", "stage.toml", "other/stage.toml", "--no-solids", "--trust")
    assert "do not differ" in command(*words).out
    with Path("other/ball_screw.py").open("a", encoding="utf-8") as file:
        file.write("# another chamfer\n")
    Path("other/checks/critical_speed.py").rename("other/checks/whirl.py")
    first = command(*words)
    assert "do not differ" not in first.out and "file ball_screw.py: changed" in first.out
    assert "other/ball_screw.py" in first.err
    assert command.json(*words)["code"] == [
        {"file": "ball_screw.py", "change": "changed"},
        {"file": "checks/critical_speed.py", "change": "only in the first"},
        {"file": "checks/whirl.py", "change": "only in the second"},
    ]


def test_numbers_of_an_own_check_have_its_unit_and_its_document_is_in_si(tmp_path: Path, command: Any) -> None:
    Path("checks").mkdir()
    Path("stage.toml").write_text('extends = "thesis"\n', encoding="utf-8")
    Path("checks/life.py").write_text(LIFE, encoding="utf-8")
    (found,) = [one for one in command.json("check", "--no-solids", "--trust", status=1) if one["name"] == "life"]
    assert found["value"] == {"value": 7.2e6, "unit": "s"} and found["margin"] == pytest.approx(1.0)


def test_ball_screw_slide_of_three_parts(slide: None, command: Any) -> None:
    with Path("ball_screw.py").open("a", encoding="utf-8") as file:
        # Of a file whose part is in the cache nothing is run.
        file.write(f"# {Path.cwd()}\n")
    assert "--trust" in command("parts", status=2).err
    found = command.json("parts", "--trust")
    shaft = 3.141592653589793 / 4 * (16**2 * 340 + 2 * 12**2 * 20) * 1e-9
    assert found["parts"]["screw"]["volume"]["value"] == pytest.approx(shaft, rel=1e-6)
    whole = sum(found["parts"][name]["mass"]["value"] for name in ("bed", "carriage", "screw"))
    assert found["assembly"]["mass"]["value"] == pytest.approx(whole)
    # The thread of the nut is the ring between its core and the screw.
    pairs = {frozenset((one["first"], one["second"])): one for one in found["interference"]}
    thread = pairs[frozenset(("screw", "carriage"))]
    assert thread["kind"] == "overlap"
    assert thread["common_volume"] == pytest.approx(3.141592653589793 / 4 * (16**2 - 14**2) * 80e-9, rel=1e-6)
    assert {one["kind"] for one in found["interference"]} <= {"overlap", "contact", "gap"}
    rows = Path("build/parts/bill_of_materials.csv").read_text("utf-8").splitlines()
    assert len(rows) == 5 and "BS 16x5" in rows[2]
    assert "PRODUCT" in Path("build/parts/assembly.step").read_text("ascii")
    one = command.json("parts", "screw", "--out", "one")
    assert list(one["parts"]) == ["screw"] and not Path("one/assembly.step").exists()
    # Quantities that only its checks read; masses only with solids.
    replace_in(Path("slide_carriage.py"), '"axis_height": "35.0 mm",', '"axis_height": "35.0 mm", "payload": "350 g",')
    assert command.json("params", "carriage.payload")["parameters"]["carriage.payload"]["unit"] == "kg"
    printed = command("check", "--no-solids", "--trust").out
    assert "'carriage.mass' is measured from the solids, which are left out here" in " ".join(printed.split())
    assert "ball screw: critical speed" in printed and "undecidable" in printed
    # Without the permission the thread is a clash.
    replace_in(Path("stage.toml"), "overlaps =", "# overlaps =")
    found = command.json("parts")
    assert [one["kind"] for one in found["interference"]].count("clash") == 1


def test_mirror_mount_with_standard_parts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: Any) -> None:
    monkeypatch.chdir(shutil.copytree(EXAMPLES / "mirror_mount", "mount"))
    found = command.json("parts", "--trust")
    pairs = {frozenset((one["first"], one["second"])): one["kind"] for one in found["interference"]}
    assert "clash" not in pairs.values()
    threads = {pair for pair, kind in pairs.items() if kind == "thread engagement"}
    plate, screws = "back_plate", ("adjuster_1", "adjuster_2", "foot_screws_1", "foot_screws_2")
    assert threads == {*(frozenset((plate, screw)) for screw in screws), frozenset(("front_plate", "clamp_screw"))}
    rows = Path("build/parts/bill_of_materials.csv").read_text("utf-8").splitlines()
    assert any("ISO 4762 - M4 x 12,2," in row for row in rows) and any("ISO 4026 - M3 x 12,1," in row for row in rows)
    assert "lint: 0 hits on 6 sheets" in command("drawings", "--lint", "--out", "sheets").out
    # Every kind of part has a balloon on the assembly sheet.
    text = Path("sheets/assembly.dxf").read_text("utf-8")
    assert all(f"\n{item}\n" in text for item in range(1, 8))
    assert command("check", "--no-solids").out.startswith("this machine has no checks; 'stagecad new check NAME'")
    # 10.4 mm of a screw in 10 mm of thread, which the drill of 13 mm has room for.
    replace_in(Path("stage.toml"), "M4x12", "M4x16")
    clashes = [one for one in command.json("parts")["interference"] if one["kind"] == "clash"]
    assert [(one["first"], one["second"]) for one in clashes] == [(plate, screws[2]), (plate, screws[3])]


def test_checks_sweeps_tolerances_and_searches(slide: None, command: Any) -> None:
    with Path("stage.toml").open("a", encoding="utf-8") as file:
        file.write('[machine.chains]\n"between the journals" = "=screw.length - 2*screw.journal_length"\n')
    (check,) = command.json("check", "--trust")
    assert check["verdict"] == "passes" and check["inputs"]["screw.length"]["value"] == pytest.approx(0.340)
    assert check["inputs"]["carriage.mass"]["value"] == pytest.approx(0.939, rel=0.01)
    # The parameters of a part's file are keys of the parameter file.
    found = command.json("check", "--chains", "--sweep", "screw.length=300mm:380mm:2", "--set", "screw.journal=13mm")
    margins = found["sweep"]["checks"]["critical speed of the screw"]["margin"]
    (chain,) = found["chains"]
    assert [link["coefficient"] for link in chain["links"]] == pytest.approx([1.0, -2.0])
    assert [value["value"] for value in chain["worst_case"]] == pytest.approx([0.2997, 0.3003])
    assert margins == sorted(margins, reverse=True) and len(set(margins)) == 2
    study = command.json("check", "--tolerance", "--samples", "100")["tolerance"]
    assert {"screw.length", "screw.journal"} <= {one["key"] for one in study["matter_most"]}
    changed = command.json("optimize", "--free", "screw.length=300 mm:500 mm", "--set", "screw.length=490 mm")
    assert changed["feasible"] is True and [one["key"] for one in changed["changes"]] == ["screw.length"]


def test_a_part_with_the_key_of_a_packaged_one_stands_in_its_place(slide: None, command: Any) -> None:
    for old, new in (("bed = {", "base = {"), ('"bed.', '"base.')):
        replace_in(Path("stage.toml"), old, new)
    assert command.json("check", "--tolerance", "--samples", "100", "--trust")["tolerance"]["matter_most"]
    assert "slide_bed.length" in command("params", "base").out
    changed = command.json("optimize", "--free", "base.length=300 mm:400 mm", "--keep", "critical*")
    assert changed["changes"] == []
    # The stage of the thesis, whose values are in the file, is not in this machine.
    assert 'no part "stage"' in command("simulate", "stick-slip", "--mass", "design", status=2).err
    Path("sheets.toml").write_text('[assembly]\nscale = "1:5"\n', "utf-8")
    assert "no sheet 'assembly' of a part" in command("drawings", "assembly", status=2).err


def test_rules_of_parts_that_are_not_in_the_machine_are_silent(slide: None, command) -> None:
    # Too short for the sensor bracket of the packaged machine, which this one does not have.
    command("params", "--set", "screws.bar.length=5mm", "screws.bar.length")
    with Path("stage.toml").open("a", encoding="utf-8") as file:
        file.write('\n[machine.parts.bolt]\npart = "bar_screw"\nparameters = {"screws.bar.length" = "25 mm"}\n')
        file.write('\n[machine.mates.bolt]\ndatum = "head"\non = "bed.top"\n')
    assert command.json("params", "screws.bar.length")
    Path("packaged.toml").write_text('extends = "thesis"\n[screws.bar]\nlength = "5 mm"\n', "utf-8")
    assert "screws.bar.length" in command("params", "--params", "packaged.toml", status=2).err


def test_wrong_parameters_and_parts_are_named(slide: None, command: Any) -> None:
    text = Path("stage.toml").read_text("utf-8")
    for old, new, words in (
        ('{length = "340.0 mm"}', '{lenght = "340.0 mm"}', "has no 'lenght'"),
        ("ball_screw.py", "ball_srew.py", "cannot be read"),
        ('datum = "shoulder"', 'datum = "sholder"', "did you mean 'shoulder'"),
    ):
        Path("stage.toml").write_text(text.replace(old, new), "utf-8")
        assert words in command("parts", "--trust", status=2).err
    Path("stage.toml").write_text(text, "utf-8")
    assert "did you mean 'screw.length'" in command("check", "--trust", "--set", "screw.lenght=1 mm", status=2).err


@pytest.mark.slow
def test_slide_is_made_and_compared(slide: None, command: Any) -> None:
    """Protects sheets, report and differences of a machine of the user's own, which take the CAD kernel minutes."""
    found = command.json("make", "--trust")
    assert set(found["drawings"]) == {"bed/slide_bed", "carriage/slide_carriage", "assembly", "procedure"}
    assert [sheet["hits"] for sheet in found["drawings"].values()] == [[]] * 4
    assert all(Path(file).stat().st_size > 100 for sheet in found["drawings"].values() for file in sheet["files"])
    page = Path("build/report.html").read_text("utf-8")
    assert "BALL-SCREW SLIDE WITH 200 MM OF TRAVEL" in page and "moving body" not in page
    assert "carriage.length" in page and "stop_bar.reach" not in page
    assert "critical speed of the screw" in page and "slide_bed" in page
    assert command.json("drawings", "bed")["sheets"].keys() == {"bed/slide_bed"}
    Path("longer.toml").write_text(Path("stage.toml").read_text("utf-8").replace(*LONGER), "utf-8")
    said = command("diff", "stage.toml", "longer.toml").out
    assert "screw.length" in said and "sheet assembly: changed" in said


@pytest.mark.slow
def test_two_axis_stage_is_made(command: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Protects a machine of packaged parts and one of the user's own: every sheet, and the procedure."""
    monkeypatch.chdir(shutil.copytree(EXAMPLES / "two_axis_stage", "two_axes"))
    found = command.json("make", "--trust")
    assert {"base_1", "base_2", "base_3", "holder", "stage", "tip", "assembly", "procedure"} < set(found["drawings"])
    assert not [one for one in found["interference"] if one["kind"] == "clash"]
    assert [sheet["hits"] for sheet in found["drawings"].values()] == [[]] * len(found["drawings"])


@pytest.mark.slow
def test_template_of_a_machine_is_made(command: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Protects the files that `stagecad new machine` writes."""
    command("new", "machine", "mill")
    monkeypatch.chdir("mill")
    found = command.json("make", "--trust")
    assert found["assembly"]["bounding_box"]["value"][1][2] == pytest.approx(0.028)
    assert not [hit for sheet in found["drawings"].values() for hit in sheet["hits"]]
