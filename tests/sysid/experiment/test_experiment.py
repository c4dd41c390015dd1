"""What an experiment file says, one line for each way it can be wrong, and Python files, which run after a consent."""

import hashlib
import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

import sysid.prediction.problem as module
from stagecad.parameters.errors import InputError
from sysid.experiment.experiment import load_experiment, trust_experiment
from sysid.experiment.record import load_records
from sysid.prediction.problem import load_problem
from tests.beside import beside
from tests.experiments import record_text, replace_in, write_rig
from tests.refusals import refused

SPRING = "time [s],pull_position [m],position [m]"


def _experiment(folder: Path, rig: str, header: str, model: str = "effects = []", record: str = "", rest: str = ""):
    rows = "".join(",".join([f"{0.01 * i:g}"] + [f"{0.1 * i:g}"] * header.count(",")) + "\n" for i in range(40))
    (folder / "fit.csv").write_text(f"{header}\n{rows}")
    text = f"schema = 1\n[rig]\n{rig}\n[model]\n{model}\n{record_text('fit.csv', record)}{rest}\n"
    (folder / "experiment.toml").write_text(text)
    return folder


def test_known_values_in_si_and_the_text_of_the_file(tmp_path):
    rig = 'kind = "spring-pull"\nknown = {mass = "1790 +- 10 g", pull_stiffness = "5.752 N/mm"}'
    folder = _experiment(tmp_path, rig, SPRING)
    known = load_experiment(folder).rig.known
    assert (known["mass"].value, known["mass"].std) == (pytest.approx(1.79), pytest.approx(0.01))
    assert known["pull_stiffness"].value == pytest.approx(5752.0) and known["pull_stiffness"].std is None
    assert known["mass"].origin == "given"
    folder = _experiment(tmp_path, 'kind = "spring-pull"\ninput_hold = "linear"  # ramp', SPRING)
    experiment = load_experiment(folder / "experiment.toml")
    assert experiment.folder == folder and "# ramp" in experiment.text and experiment.rig.input_hold == "linear"


def test_design_values_are_asked_for_by_name_and_only_when_needed(tmp_path):
    known = 'known = {piezo_spacing = "design", tip_height = "21 mm", bias_voltage = "50 V"}'
    header = "time [s],voltage_1 [V],voltage_2 [V],tip_x [um],tip_y [nm]"
    folder = _experiment(tmp_path, f'kind = "actuator-tip"\n{known}', header)
    asked = []

    def design(name):
        asked.append(name)
        return 0.046

    rig = load_experiment(folder, design).rig
    assert asked == ["piezo_spacing"]
    assert rig.known["piezo_spacing"].value == 0.046 and rig.known["piezo_spacing"].origin == "design"
    assert rig.known["tip_height"].value == pytest.approx(0.021)
    with pytest.raises(InputError, match=r"rig\.known\.piezo_spacing: the design has no 'piezo_spacing'"):
        load_experiment(folder, {"tip_height": 0.02})


@pytest.mark.parametrize("key", ["mass", "inertia"])
def test_a_rotary_axis_is_told_by_its_units(tmp_path, key):
    rig = f'kind = "force-drive"\nknown = {{{key} = "4.1 kg*cm^2"}}'
    header = "time [ms],drive_force [mN*m],position [deg],normal_load [N*m]"
    model = 'effects = ["viscous"]\nparameters = {"viscous.coefficient" = {start = "2e-3 N*m*s/rad", fixed = true}}'
    folder = _experiment(tmp_path, rig, header, model, rest='[noise]\nposition = "0.001 deg"\ndrive_force = "1 mN*m"')
    experiment = load_experiment(folder)
    assert experiment.rig.rotary and experiment.rig.known["mass"].value == pytest.approx(4.1e-4)
    assert experiment.noise["position"] == pytest.approx(math.radians(0.001))
    assert experiment.parameters["viscous.coefficient"].fixed
    assert experiment.records[0].sources["time"].terms[0].factor == pytest.approx(1e-3)


def test_model_effects_variants_sensors_and_settings(tmp_path):
    model = (
        'effects = ["presliding:lugre", "stribeck", "sensor_lag@position", "sensor_drift@spring_force"]\n'
        '[model.parameters]\nstribeck.velocity = {start = "2 mm/s", low = "0.1 mm/s", high = inf}\n'
        '"sensor_lag@position.time_constant" = "3 ms"\n"sensor_drift@spring_force.amplitude" = {low = "-1 mN"}'
    )
    experiment = load_experiment(_experiment(tmp_path, 'kind = "spring-pull"', SPRING + ",spring_force [N]", model))
    assert experiment.effects[0] == "presliding:lugre"
    setting = experiment.parameters["stribeck.velocity"]
    assert (setting.start, setting.low, setting.high) == (pytest.approx(2e-3), pytest.approx(1e-4), math.inf)
    assert experiment.parameters["sensor_lag@position.time_constant"].start == pytest.approx(3e-3)
    assert experiment.parameters["sensor_drift@spring_force.amplitude"].low == pytest.approx(-1e-3)


def test_a_users_own_effect_is_a_name_like_any_other(tmp_path):
    (tmp_path / "mine.py").write_text(CODE.format(flag=tmp_path / "flag"))
    folder = _experiment(tmp_path, 'kind = "spring-pull"', SPRING, 'effects = ["bellows"]\ncustom = ["mine.py"]')
    refused(r"mine\.py: is Python code, .* --trust", load_experiment, folder)
    trust_experiment(folder)
    experiment = load_experiment(folder)
    assert experiment.effects == ("bellows",) and experiment.custom == (tmp_path / "mine.py",)


def test_a_record_may_override_the_noise_and_continue_another(tmp_path):
    record = 'noise = {position = "3 um"}\n' + record_text("fit.csv", 'continues = "fit.csv"', role="validate")
    rest = '[noise]\nposition = "1 um"'
    folder = _experiment(tmp_path, 'kind = "spring-pull"', SPRING, record=record, rest=rest)
    first, second = load_experiment(folder).records
    assert first.noise["position"] == pytest.approx(3e-6) and not second.noise
    assert (second.name, second.continues) == ("fit#2", "fit")


@pytest.mark.slow
def test_every_practice_experiment_and_both_rigs_read():
    folders = [path.parent for path in beside().glob("practice*/*/experiment.toml")]
    assert len(folders) >= 42
    for folder in folders:
        records = load_records(load_experiment(folder))
        texts = [(folder / "experiment.toml").read_text(encoding="utf-8")]
        texts += [(folder / record.file).read_text(encoding="utf-8", errors="replace")[:500] for record in records]
        rotary = any(re.search(r"\b(m|u)?rad\b", text) for text in texts)
        assert {record.role for record in records} == {"fit", "validate"}
        for record in records:
            assert np.all(np.diff(record.time) > 0)
            # Other units of an angle, in other encodings, are not looked for.
            assert record.rotary or not rotary


CODE = """from pathlib import Path
Path(r"{flag}").write_text("it ran")
from sim import Effect, Parameter

def force(axis, p):
    return p.strength * axis.position**3

effect = Effect("bellows", "stiffens", force=force,
                parameters=[Parameter("strength", "N/m^3", 1.0, 0.0, 1e9, "stiffening", "assumed")])
"""


@pytest.fixture
def rig(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    folder, t = tmp_path / "rig", np.arange(400) * 0.01
    columns = {"time": t, "position": 0.01 * np.sin(3.0 * t), "friction_force": np.sign(np.cos(3.0 * t))}
    write_rig(folder, "velocity-drive", {"fit": columns}, ["coulomb"])
    replace_in(folder / "experiment.toml", '["coulomb"]\n', '["coulomb"]\ncustom = ["mine.py"]\n')
    (folder / "mine.py").write_text(CODE.format(flag=tmp_path / "flag"))
    return folder


@pytest.mark.parametrize("name", ["compare", "diagnose", "suggest", "ladder", "simulate", "add"])
def test_no_command_runs_the_code_without_consent(rig: Path, tmp_path, command, name: str) -> None:
    words = [name, rig, *(["viscous"] if name == "add" else []), "--out", tmp_path / "out"]
    assert re.fullmatch(r"stagecad: \S+mine\.py: is Python code, .* --trust .*\n", command.refused(*words))
    assert not (tmp_path / "flag").exists()


def test_a_consent_is_for_the_content_of_the_file(rig: Path, tmp_path, command) -> None:
    words = ["ladder", rig, "--no-figures", "--out", tmp_path / "out"]
    assert f"trusted as it is now: {rig / 'mine.py'}" in command(*words, "--trust").err
    assert (tmp_path / "flag").read_text() == "it ran"
    command(*words)
    trusted = tmp_path / "state" / "stagecad" / "trusted"
    assert [path.name for path in trusted.iterdir()] == [hashlib.sha256((rig / "mine.py").read_bytes()).hexdigest()]
    assert trusted.stat().st_mode & 0o777 == 0o700
    (rig / "mine.py").write_text((rig / "mine.py").read_text() + "# changed\n")
    (tmp_path / "flag").unlink()
    assert "mine.py: is Python code that has changed since you consented to it" in command(*words, status=2).err
    assert not (tmp_path / "flag").exists()


def test_a_file_changed_between_reading_and_fitting_does_not_run(rig: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def changing(experiment: object) -> list[object]:
        (rig / "mine.py").write_text("raise RuntimeError('ran')")
        return records(experiment)

    records = module.load_records
    monkeypatch.setattr(module, "load_records", changing)
    trust_experiment(rig)
    refused("is Python code", load_problem, rig)


@pytest.mark.parametrize("way", ["above", "absolute", "link"])
def test_code_outside_the_folder_is_refused_whatever_the_consent(rig: Path, tmp_path: Path, way: str) -> None:
    other = tmp_path / "evil.py"
    (rig / "mine.py").rename(other)
    if way == "link":
        (rig / "mine.py").symlink_to(other)
    custom = {"above": "../evil.py", "absolute": str(other), "link": "mine.py"}[way]
    replace_in(rig / "experiment.toml", 'custom = ["mine.py"]', f'custom = ["{custom}"]')
    for function in (trust_experiment, load_experiment):
        refused(r"model.custom: .* is outside the folder of the experiment", function, rig)
    assert not (tmp_path / "flag").exists()


def test_simulated_records_take_a_copy_of_the_effect_with_them(rig: Path, tmp_path: Path, command) -> None:
    command("simulate", rig, "--trust", "--out", tmp_path / "out")
    made = tmp_path / "out" / "simulate" / "rig"
    assert (made / "mine.py").read_bytes() == (rig / "mine.py").read_bytes()
    assert load_experiment(made).custom == (made / "mine.py",)


CASES = tomllib.loads((Path(__file__).parent / "broken" / "cases.toml").read_text(encoding="utf-8"))

EXPERIMENT = """schema = 1

[rig]
kind = "spring-pull"

[rig.known]
mass = "1.79 kg"
pull_stiffness = "5752 N/m"

[model]
effects = ["coulomb"]

[[record]]
file = "fit.csv"
role = "fit"

[noise]
position = "2e-07 m"
"""
CSV = "time [s],pull_position [m],position [m],spring_force [N]\n" + "".join(
    f"{i / 100:g},{i / 1000:g},{i / 2000:g},{i / 10:g}\n" for i in range(40)
)


def _write(folder: Path, case: dict) -> None:
    toml = case.get("prepend", "") + EXPERIMENT.replace(*case.get("toml", ("", "")))
    csv = case.get("whole_csv", CSV).replace(*case.get("csv", ("", "")))
    assert (toml, csv) != (EXPERIMENT, CSV) or set(case) & {"encoding", "delete"}, "the case changes nothing"
    (folder / "experiment.toml").write_text(toml, encoding="utf-8")
    (folder / case.get("rename", "fit.csv")).write_bytes(csv.encode(case.get("encoding", "utf-8")))
    if "custom" in case:
        (folder / "mine.py").write_text(case["custom"])
    if "delete" in case:
        (folder / case["delete"]).unlink()


@pytest.mark.parametrize("name", CASES)
def test_line(tmp_path, name):
    case = CASES[name]
    _write(tmp_path, case)
    if "custom" in case:
        trust_experiment(tmp_path)
    with pytest.raises(InputError) as caught:
        load_records(load_experiment(tmp_path))
    assert str(caught.value) == case["line"].replace("{dir}", str(tmp_path))


def test_there_are_many_broken_files_and_good_ones_are_good(tmp_path):
    assert len(CASES) >= 40
    (tmp_path / "experiment.toml").write_text(EXPERIMENT)
    (tmp_path / "fit.csv").write_text(CSV)
    assert len(load_records(load_experiment(tmp_path))) == 2
    (tmp_path / "rig_1").mkdir()
    refused(r"rig_2: no such folder or file; did you mean 'rig_1'\?", load_experiment, tmp_path / "rig_2")
    (tmp_path / "fit.csv").write_text(CSV)
    (tmp_path / "experiment.toml").write_text(EXPERIMENT.replace("fit.csv", "x" * 5000 + ".csv"))
    with pytest.raises(InputError) as caught:
        load_experiment(tmp_path)
    assert len(str(caught.value)) < 300 and "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [b"PAR1", b"PAR1" + bytes(50) + b"PAR1"])
def test_a_damaged_parquet_file(tmp_path, content):
    (tmp_path / "experiment.toml").write_text(EXPERIMENT.replace("fit.csv", "fit.parquet"))
    (tmp_path / "fit.parquet").write_bytes(content)
    refused(r"fit\.parquet: is not a Parquet file", load_experiment, tmp_path)


def test_a_mat_file_without_vectors_or_of_another_version(tmp_path):
    (tmp_path / "experiment.toml").write_text(EXPERIMENT.replace("fit.csv", "fit.mat"))
    savemat(tmp_path / "fit.mat", {"comment": "nothing measured", "gain": 3.0})
    refused(r"fit\.mat: contains no vector of numbers", load_experiment, tmp_path)
    (tmp_path / "fit.mat").write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512))
    refused(r"version 7\.3", load_experiment, tmp_path)
