"""`stagecad new`: what it proposes and asks for an experiment from files, and templates that work as written."""

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from designcalc.checks.run import OWN
from designcalc.optimisation.search import free_parameters
from sim.effects.custom import load_custom
from stagecad.consent import give_consent
from stagecad.parameters.file import read_parameter_file
from stagecad.parameters.load import load_design, part_design
from sysid.experiment.experiment import load_experiment
from sysid.experiment.record import Record, load_records
from tests.experiments import replace_in
from workbench import cli

TIME = 0.01 * np.arange(300)
ANGLE = np.sin(3.0 * TIME)
SPEED = 3.0 * np.cos(3.0 * TIME)
FORCE = np.sign(SPEED) + 0.1 * SPEED


def _write(path: Path, header: str, *columns: np.ndarray, between: str = ",") -> Path:
    rows = "\n".join(between.join(f"{cell:.9g}" for cell in row) for row in zip(*columns, strict=True))
    path.write_text(f"{header}\n{rows}\n" if header else f"{rows}\n")
    return path


def _new(folder: Path, *files: Path, **options: str) -> tuple[dict, str]:
    target = folder.parent / "out.json"
    rest = [word for key, value in options.items() for word in (f"--{key}", value)]
    assert cli.run(["new", "experiment", str(folder), *map(str, files), *rest, "--json", str(target)]) == 0
    return json.loads(target.read_text()), (folder / "experiment.toml").read_text()


def _answered(folder: Path, answers: dict[str, str]) -> Record:
    """The first record of an experiment whose questions are answered."""
    for question, answer in answers.items():
        replace_in(folder / "experiment.toml", question, answer)
    return load_records(load_experiment(folder))[0]


def test_clear_names_are_no_questions_and_the_experiment_loads(tmp_path):
    for name in ("one.csv", "two.csv"):
        _write(tmp_path / name, "Time (s);position [rad];friction_force [Nm]", TIME, ANGLE, FORCE, between=";")
    with (tmp_path / "one.csv").open("a") as file:
        file.write("3.00;0.4")
    document, text = _new(tmp_path / "rig", tmp_path / "one.csv", tmp_path / "two.csv")
    read_as = ["semicolon", "row 302 at the end is cut off; left out"]
    assert document["kind"] == "velocity-drive" and document["read_as"] == read_as
    assert list(document["channels"]) == ["time", "position", "friction_force"]
    assert list(document["channels"].values()) == ["Time (s)", "position [rad]", "friction_force [Nm]"]
    assert (tmp_path / "rig" / "columns.png").stat().st_size > 5000
    fit, held_out = load_records(load_experiment(tmp_path / "rig"))
    assert (fit.role, held_out.role) == ("fit", "validate") and fit.rotary
    assert np.allclose(fit.channels["friction_force"], FORCE, atol=1e-8)
    assert "# inertia = " in text and 'role = "validate"    # QUESTION' in text


def test_what_is_uncertain_is_a_question_and_a_missing_scale_stops_the_next_command(tmp_path, command):
    _write(tmp_path / "log.csv", "t [s],enc [deg],motor current [A],temp2", TIME, np.degrees(ANGLE), FORCE, TIME % 1.0)
    document, text = _new(tmp_path / "rig", tmp_path / "log.csv")
    assert document["kind"] == "force-drive"
    assert any("what is its scale in N*m/A" in question for question in document["questions"])
    assert "QUESTION" in next(line for line in text.splitlines() if line.startswith("position = "))
    tomllib.loads(text)
    line = command.refused("compare", tmp_path / "rig")
    assert "channels.drive_force.scale: '? N*m/A'" in line and "question" in line
    record = _answered(tmp_path / "rig", {"? N*m/A": "0.113 N*m/A"})
    assert np.allclose(record.channels["drive_force"], 0.113 * FORCE[: record.size], atol=1e-8)


def test_name_of_a_transducers_output_says_what_it_measures(tmp_path, command):
    header = "time [s],LVDT [mV],Load cell [V],Pressure [mA],piezo x [V],V1 [V]"
    _write(tmp_path / "log.csv", header, TIME, ANGLE, FORCE, 4.0 + ANGLE, ANGLE, SPEED)
    document, _ = _new(tmp_path / "rig", tmp_path / "log.csv")
    expected = {"position": "LVDT [mV]", "friction_force": "Load cell [V]", "normal_load": "Pressure [mA]"}
    assert document["channels"] == {"time": "time [s]"} | expected
    for unit in ("m/V", "N/V", "N/A"):
        assert any(f"what is its scale in {unit}?" in question for question in document["questions"])
    line = command.refused("compare", tmp_path / "log.csv")
    assert f"a record, not an experiment; 'stagecad new experiment FOLDER {tmp_path / 'log.csv'}' makes one" in line


def test_columns_are_told_by_their_numbers_and_by_the_names_of_labview(tmp_path):
    document, text = _new(tmp_path / "rig", _write(tmp_path / "log.dat", "", TIME, ANGLE, SPEED, FORCE, between=" "))
    assert document["read_as"] == ["blanks", "no header"]
    assert document["channels"] == {"time": "column 1", "position": "column 2", "velocity": "column 3"}
    assert any("column 3 'column 3': it follows the derivative of column 2" in q for q in document["questions"])
    assert "QUESTION: which column is it? friction_force" in text
    _write(tmp_path / "log.lvm", "X_Value\tAngle\tSpeed\tTorque", TIME, ANGLE, SPEED, FORCE, between="\t")
    document, _ = _new(tmp_path / "labview", tmp_path / "log.lvm", kind="velocity-drive")
    channels = {"time": "X_Value", "position": "Angle", "velocity": "Speed", "friction_force": "Torque"}
    assert document["channels"] == channels


def test_units_at_the_end_of_names_are_proposed_with_a_question(tmp_path):
    _write(tmp_path / "log.csv", "time_s,position_mm,force", TIME, 1e3 * ANGLE, FORCE)
    document, text = _new(tmp_path / "rig", tmp_path / "log.csv")
    position = next(line for line in text.splitlines() if line.startswith("position = "))
    assert 'unit = "mm"' in position and "QUESTION" in position and "its unit 'mm' by its name" in position
    assert any("'force'" in question and "what is its unit?" in question for question in document["questions"])
    record = _answered(tmp_path / "rig", {'unit = "?"': 'unit = "N"'})
    assert np.allclose(record.channels["position"], ANGLE[: record.size], atol=1e-8)


def test_counts_two_forces_and_a_unit_in_the_name_of_a_current(tmp_path):
    counts = np.round(1e6 * ANGLE / 0.5)
    header = "k,ENC_counts,Force left (N),Force right (N)"
    _write(tmp_path / "log.csv", header, np.arange(TIME.size), counts, FORCE, FORCE)
    document, text = _new(tmp_path / "rig", tmp_path / "log.csv", kind="velocity-drive")
    assert any("how much is one count, such as '0.5 m'" in question for question in document["questions"])
    assert any("or their sum ([3, 4])" in question for question in document["questions"])
    answers = {
        'column = "k", unit = "?"': 'column = "k", unit = "2 ms"',
        'column = "ENC_counts", unit = "?"': 'column = "ENC_counts", unit = "0.5 um"',
        'friction_force = "Force left (N)"': "friction_force = [3, 4]",
    }
    record = _answered(tmp_path / "rig", answers)
    assert np.allclose(record.time, 2e-3 * np.arange(TIME.size)[: record.size])
    assert np.allclose(record.channels["position"], ANGLE[: record.size], atol=3e-7)
    assert np.allclose(record.channels["friction_force"], 2.0 * FORCE[: record.size], atol=1e-5)
    _, text = _new(tmp_path / "axis", _write(tmp_path / "drive.csv", "time [s],x [m],Iq_meas_A", TIME, ANGLE, FORCE))
    assert 'unit = "A", scale = "? N/A"' in text


def test_one_column_of_intervals_is_asked_for_its_pulses(tmp_path):
    steps = 0.02 + 0.005 * np.sin(0.1 * np.arange(200))
    (tmp_path / "coast.csv").write_text("\n".join(f"{step:.9f}" for step in steps))
    document, _ = _new(tmp_path / "rig", tmp_path / "coast.csv", kind="force-drive")
    assert any("is it the time from pulse to pulse" in question for question in document["questions"])
    answers = {
        'unit = "?"': 'unit = "s"',
        "# QUESTION: how far is it from pulse to pulse? position": "position",
        '# QUESTION: which column is it? drive_force = {column = 1, unit = "N"}': 'drive_force = {value = "0 N*m"}',
    }
    record = _answered(tmp_path / "rig", answers)
    assert np.allclose(record.time, np.cumsum(steps)[: record.size], rtol=1e-6)
    assert np.allclose(record.channels["position"], 2.0 * np.pi * np.arange(1, record.size + 1))


def test_an_experiment_is_never_overwritten(tmp_path, command):
    _new(tmp_path / "rig", _write(tmp_path / "a.csv", "time [s],position [m],friction_force [N]", TIME, ANGLE, FORCE))
    words = ["new", "experiment", tmp_path / "rig", tmp_path / "a.csv"]
    assert "experiment.toml: exists already" in command(*words, status=2).err
    _write(tmp_path / "b.csv", "time [s],x [m],friction_force [N]", TIME, ANGLE, FORCE)
    words = ["new", "experiment", tmp_path / "other", tmp_path / "a.csv", tmp_path / "b.csv"]
    assert "has other columns than" in (said := command(*words, status=2).err)
    assert "(column 2: 'x [m]' and 'position [m]')" in said
    assert not (tmp_path / "other").exists()


def test_channels_of_a_declared_kind(tmp_path):
    _write(tmp_path / "log.csv", "t [s],angle [deg],i [A]", TIME, np.degrees(ANGLE), FORCE)
    document, text = _new(tmp_path / "rig", tmp_path / "log.csv", kind="motor-current")
    assert document["channels"] == {"time": "t [s]", "position": "angle [deg]", "motor_current": "i [A]"}
    assert '# torque_constant = "1 N*m/A"' in text
    record = _answered(tmp_path / "rig", {"[rig.known]": '[rig.known]\ntorque_constant = "0.2 N*m/A"'})
    assert np.allclose(record.channels["drive_force"], 0.2 * FORCE[: record.size], atol=1e-8)


def test_the_voltage_of_a_piezo_is_its_own_channel_and_its_model_has_no_friction(tmp_path, command):
    _write(tmp_path / "log.csv", "t [s];Spannung [V];Auslenkung [um]", TIME, 50.0 * ANGLE, 5.0 * ANGLE, between=";")
    document, text = _new(tmp_path / "rig", tmp_path / "log.csv")
    assert document["kind"] == "piezo" and any("voltage drive a motor" in one for one in document["questions"])
    stated, _ = _new(tmp_path / "stated", tmp_path / "log.csv", kind="piezo")
    channels = {"time": "t [s]", "voltage": "Spannung [V]", "displacement": "Auslenkung [um]"}
    assert document["channels"] == stated["channels"] == channels
    assert tomllib.loads(text)["model"]["effects"] == []
    assert len(load_records(load_experiment(tmp_path / "rig"))) == 2
    channels = command.json("look", tmp_path / "rig", "--no-figures")["records"][0]["channels"]
    assert channels.keys() == {"voltage", "displacement"}
    high = channels["displacement"]["high"]
    assert high["unit"] == "m" and np.isclose(high["value"], 5e-6, rtol=1e-3)


def test_a_scale_that_is_a_question_is_looked_at_with_one_unit(tmp_path, command):
    _new(tmp_path / "rig", _write(tmp_path / "log.csv", "t [s],x [mm],Motorstrom [A]", TIME, ANGLE, 3.0 * FORCE))
    assert "is still a question" in command("compare", tmp_path / "rig", status=2).err
    seen = command.json("look", tmp_path / "rig", "--no-figures")
    assert "drive_force: its scale is a question; shown with 1 N/A" in seen["warnings"]
    assert np.isclose(seen["records"][0]["channels"]["drive_force"]["high"]["value"], 3.0 * FORCE.max())


def test_rows_of_every_fault_are_counted_and_drawn(tmp_path, command):
    force = np.sign(np.cos(TIME)) + 0.01 * np.random.default_rng(1).standard_normal(TIME.size)
    path = np.concatenate([np.cumsum(np.ones(TIME.size // 2)), np.full(TIME.size - TIME.size // 2, TIME.size // 2)])
    off = np.where(path == TIME.size // 2, 0.0, force)
    for kind, position, logged in (("held", TIME, np.repeat(force[::5], 5)[: TIME.size]), ("unloaded", path, off)):
        header = "time [s],position [m],friction_force [N]"
        _write(tmp_path / f"{kind}.csv", header, TIME, position, logged)
        _new(tmp_path / kind, tmp_path / f"{kind}.csv")
        words = ["look", tmp_path / kind, "--out", tmp_path]
        assert command.json(*words)["records"][0]["channels"]["friction_force"][kind] > TIME.size // 4
        assert f" {kind}" in command(*words, "--no-figures").out


def test_rows_that_hold_one_channel_each_are_told_how_to_become_columns(tmp_path, command):
    rows = [f"{t:.2f},{name},{y:.9g}" for t, *values in zip(TIME, ANGLE, FORCE) for name, y in zip("xF", values)]
    (tmp_path / "log.csv").write_text("\n".join(["time [s],channel,value", *rows]))
    said = command("new", "experiment", tmp_path / "rig", tmp_path / "log.csv", "--kind", "velocity-drive").out
    assert "pivot(index='time [s]', columns='channel', values='value')" in " ".join(said.split())
    rows = [f"{t:.2f},{'ab'[k % 2]},{f:.9g}" for k, (t, f) in enumerate(zip(TIME, FORCE))]
    (tmp_path / "states.csv").write_text("\n".join(["time [s],state,force [N]", *rows]))
    said = command("new", "experiment", tmp_path / "other", tmp_path / "states.csv", "--kind", "velocity-drive").out
    assert "pivot" not in said


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
