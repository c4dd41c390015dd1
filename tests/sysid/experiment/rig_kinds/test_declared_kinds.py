"""Rig kinds in declaration files: the base's channels follow from what is logged as the mechanics says.

Each record is written from a motion in closed form and the forces that it takes, and never by the formulas of the
declaration.
"""

import re
from pathlib import Path

import numpy as np
import pytest

from sysid.compare import compare
from sysid.experiment.experiment import Experiment, load_experiment
from sysid.experiment.record import Record, load_records
from sysid.experiment.rig_kinds.declaration import FOLDER, find_rig, kinds
from tests.experiments import replace_in, write_rig
from tests.reference.tables import cases
from tests.refusals import refused

T = 0.002 * np.arange(500)
X = 0.3 * np.sin(7.0 * T)
V = 2.1 * np.cos(7.0 * T)
A = -14.7 * np.sin(7.0 * T)
FRICTION = 0.4 * np.sign(V) + 0.05 * V


def _write(folder: Path, kind: str, known: dict[str, str], channels: dict[str, np.ndarray], rest: str = "") -> None:
    effects = [] if "piezo" in kind else ["coulomb", "viscous"]
    write_rig(folder, kind, {"fit": channels}, effects, known=known, rest=rest)
    # The records are samples of smooth curves.
    replace_in(folder / "experiment.toml", "[rig]\n", '[rig]\ninput_hold = "linear"\n')


def _load(folder: Path, *arguments) -> tuple[Experiment, Record]:
    _write(folder, *arguments)
    experiment = load_experiment(folder)
    return experiment, load_records(experiment)[0]


MOTOR = {"torque_constant": "50 mN*m/A", "gear_ratio": "20", "motor_inertia": "1e-5 kg*m^2"}
MOTOR |= {"load_inertia": "0.1 kg*m^2"}
SPINDLE = {"torque_constant": "0.1 N*m/A", "back_emf_constant": "0.1 V*s/rad", "winding_resistance": "1.5 ohm"}
SPINDLE |= {"inertia": "0.02 kg*m^2"}
INERTIA = 0.1 + 20.0**2 * 1e-5
TORQUE = INERTIA * A + FRICTION
CURRENT = TORQUE / (20.0 * 0.05)


DRIVEN = {"time": T, "position [rad]": X, "motor_current [mA]": 1e3 * CURRENT}


def test_a_motor_with_current_and_gearbox(tmp_path):
    experiment, record = _load(tmp_path, "motor-current", MOTOR, DRIVEN)
    assert experiment.rig.kind == "force-drive" and experiment.rig.rotary
    assert experiment.rig.known["mass"].value == pytest.approx(INERTIA)
    assert set(record.channels) == {"position", "drive_force"} and record.units["drive_force"] == "N*m"
    assert np.allclose(record.channels["drive_force"], TORQUE[: record.size])


def test_bare_numbers_and_computed_noise_of_a_motor(tmp_path):
    _write(tmp_path, "motor-current", MOTOR, DRIVEN)
    replace_in(tmp_path / "experiment.toml", '"gear_ratio" = "20"', "gear_ratio = 20")
    record = load_records(load_experiment(tmp_path))[0]
    assert np.allclose(record.channels["drive_force"], TORQUE[: record.size])
    noise = '[noise]\nmotor_current = "3 mA"\nposition = "1e-6 rad"\n'
    record = _load(tmp_path, "motor-current", MOTOR, DRIVEN, noise)[1]
    assert record.noise["drive_force"] == pytest.approx(20.0 * 0.05 * 3e-3, rel=0.1)
    assert record.noise["position"] == 1e-6 and "motor_current" not in record.noise


def test_a_motor_with_voltage_gives_the_friction_without_its_back_emf(tmp_path):
    """u = R i + k_e n v: with the back EMF in it, the viscous coefficient would be n^2 k_t k_e/R = 0.5 more."""
    voltage = 2.0 * CURRENT + 0.05 * 20.0 * V
    known = {**MOTOR, "back_emf_constant": "0.05 V*s/rad", "winding_resistance": "2 ohm"}
    channels = {"time": T, "position [rad]": X, "velocity [rad/s]": V, "motor_voltage [V]": voltage}
    record = _load(tmp_path, "motor-voltage", known, channels)[1]
    assert np.allclose(record.channels["drive_force"], TORQUE[: record.size])
    channels.pop("velocity [rad/s]")
    record = _load(tmp_path, "motor-voltage", known, channels)[1]
    inner = slice(1, record.size - 1)
    assert np.allclose(record.channels["drive_force"][inner], TORQUE[inner], atol=1e-3)
    rows = np.column_stack([np.sign(V), V])[inner]
    coulomb, viscous = np.linalg.lstsq(rows, record.channels["drive_force"][inner] - INERTIA * A[inner])[0]
    assert viscous == pytest.approx(0.05, rel=1e-3)
    assert coulomb == pytest.approx(0.4, rel=1e-3)
    lossy = _load(tmp_path, "motor-voltage", known | {"gear_efficiency": "0.7"}, channels)[1]
    assert np.allclose(lossy.channels["drive_force"], 0.7 * record.channels["drive_force"])


def test_the_back_emf_changes_while_the_voltage_is_held(tmp_path):
    """The mean torque of a row is k_t/R (u - k_e dx/h), dx the way in the row; by the speed at its begin the back EMF
    would be late by half a row, and the torque wrong by k_t k_e/R w' h/2."""
    step, speed = 0.01, 90.0 + 60.0 * np.sin(3.0 * 0.01 * np.arange(1000))
    time = step * np.arange(speed.size)
    angle = 90.0 * time - 20.0 * np.cos(3.0 * time)
    columns = {"time": time, "motor_voltage [V]": np.full(time.size, 12.0), "position [rad]": angle}
    write_rig(tmp_path, "motor-voltage", {"fit": columns | {"velocity [rad/s]": speed}}, ["coulomb"], known=SPINDLE)
    found = load_records(load_experiment(tmp_path))[0].channels["drive_force"][:-1]
    mean = 0.1 / 1.5 * (12.0 - 0.1 * np.diff(angle) / step)[: found.size]
    late = 0.1 * 0.1 / 1.5 * 180.0 * step / 2.0
    assert np.max(np.abs(found - mean)) < 0.03 * late


@pytest.mark.parametrize("hold", ["zero", "linear"])
def test_whether_a_voltage_is_held_is_found(tmp_path, hold):
    """A spindle under a voltage that is held from row to row, or sampled from a smooth curve; both are exact."""
    step, inertia, loss, back = 0.01, 0.02, 4e-4, 0.1 * 0.1 / 1.5
    random, time = np.random.default_rng(5), 0.01 * np.arange(4000)
    rate = (back + loss) / inertia
    if hold == "linear":
        angle = 90.0 * time - 20.0 * np.cos(3.0 * time) - 2.0 * np.cos(11.0 * time)
        speed = 90.0 + 60.0 * np.sin(3.0 * time) + 22.0 * np.sin(11.0 * time)
        grows = 180.0 * np.cos(3.0 * time) + 242.0 * np.cos(11.0 * time)
        voltage = (inertia * (grows + rate * speed) + 0.03) * 15.0
    else:
        voltage, angle = 14.0 + 8.0 * np.sin(3.0 * time) + 4.0 * np.sin(11.0 * time), np.zeros(time.size)
        w = 60.0
        for k in range(time.size - 1):
            final = (voltage[k] / 15.0 - 0.03) / inertia / rate
            angle[k + 1] = angle[k] + final * step + (w - final) * -np.expm1(-rate * step) / rate
            w = final + (w - final) * np.exp(-rate * step)
    columns = {"time": time, "motor_voltage [V]": voltage}
    columns["position [rad]"] = angle + 1e-4 * random.standard_normal(time.size)
    noise = {"position": "1e-4 rad", "motor_voltage": "1 mV"}
    write_rig(tmp_path, "motor-voltage", {"fit": columns}, ["coulomb", "viscous"], known=SPINDLE, noise=noise)
    found = compare(tmp_path)
    assert found.problem.experiment.rig.input_hold == hold and found.validate["drive_force"].over_noise < 1.15


@pytest.mark.parametrize(
    "kind, parameter, key",
    [("motor-voltage", "mass", "inertia"), ("friction-drive", "gain", "piezo_gain"), ("piezo", "gain", None)],
)
def test_a_value_of_the_rig_is_stated_under_one_key(kind, parameter, key):
    assert find_rig(kind, "").key_of(parameter) == key


def test_screws_and_elastic_gearboxes(tmp_path):
    """The work of the motor over a turn is that of the slide over a lead."""
    known = {"torque_constant": "0.1 N*m/A", "screw_lead": "5 mm"}
    channels = {"time": T, "position": X, "motor_current [A]": np.sin(T)}
    experiment, record = _load(tmp_path, "motor-screw", known, channels)
    assert not experiment.rig.rotary
    assert np.allclose(record.channels["drive_force"] * 5e-3, 2 * np.pi * 0.1 * np.sin(T)[: record.size])
    known = {"gear_ratio": "20", "pull_stiffness": "500 N*m/rad", "inertia": "0.1 kg*m^2"}
    channels = {"time": T, "position [deg]": np.degrees(X), "motor_position [rad]": 20.0 * (X + TORQUE / 500.0)}
    experiment, record = _load(tmp_path, "gearbox-torsion", known, channels)
    assert experiment.rig.kind == "spring-pull" and experiment.rig.rotary
    extension = record.channels["pull_position"] - record.channels["position"]
    assert np.allclose(500.0 * extension, TORQUE[: record.size])


def test_a_gearbox_before_a_torque_sensor(tmp_path):
    """What of the torque neither reaches the sensor nor accelerates the rotor is the friction of the gearbox."""
    sensor = 3.0 * np.sin(5.0 * T)
    current = (sensor + 20.0**2 * 1e-5 * A + FRICTION) / (20.0 * 0.05)
    known = {key: MOTOR[key] for key in ("torque_constant", "gear_ratio", "motor_inertia")}
    channels = {"time": T, "position [rad]": X, "motor_current [A]": current, "sensor_torque [Nm]": sensor}
    experiment, record = _load(tmp_path, "gearbox", known, channels)
    balance = record.channels["drive_force"] - experiment.rig.known["mass"].value * A[: record.size]
    assert np.allclose(balance, FRICTION[: record.size])
    assert np.allclose(record.channels["normal_load"], np.abs(sensor[: record.size]))


def test_gravity_external_forces_and_coupled_axes(tmp_path):
    """On a slope of 30 degrees half of the weight pulls back."""
    external = np.cos(3.0 * T)
    motor = 2.0 * A + FRICTION - external + 0.5 * 2.0 * 9.80665
    known = {"mass": "2 kg", "weight": f"{2.0 * 9.80665} N", "inclination": "30 deg"}
    channels = {"time": T, "position": X, "motor_force [N]": motor, "external_force [N]": external}
    record = _load(tmp_path, "external-force", known, channels)[1]
    assert np.allclose(record.channels["drive_force"], (2.0 * A + FRICTION)[: record.size])
    channels.pop("external_force [N]")
    alone = _load(tmp_path, "external-force", known, channels)[1].channels["drive_force"]
    assert np.allclose(alone, (2.0 * A + FRICTION - external)[: alone.size])
    other = 0.2 * np.sin(4.0 * T)
    force = 2.0 * A + FRICTION + 0.7 * (-16.0 * other)
    known = {"mass": "2 kg", "coupling_mass": "0.7 kg"}
    channels = {"time": T, "position": X, "axis_force [N]": force, "other_position [m]": other}
    record = _load(tmp_path, "coupled-axes", known, channels)[1]
    inner = slice(2, record.size)
    # A second difference of a sine differs from its derivative by (w h)^2/3, here 2e-5.
    assert np.allclose(record.channels["drive_force"][inner], (2.0 * A + FRICTION)[inner], atol=1e-3)


def test_pneumatic_cylinders(tmp_path):
    net = 2.0 * A + FRICTION
    first = 6e5 + net / 5e-4
    known = {"area_1": "5 cm^2", "area_2": "4 cm^2", "mass": "2 kg"}
    channels = {"time": T, "position": X, "pressure_1 [bar]": 1e-5 * first, "pressure_2 [bar]": 7.5 + 0.0 * T}
    record = _load(tmp_path, "pneumatic-cylinder", known, channels)[1]
    assert np.allclose(record.channels["drive_force"], net[: record.size])
    channels = {"time": T, "position [mm]": 1e3 * X, "rod_force [N]": FRICTION + 98.0, "pressure [bar]": 2 + 0 * T}
    record = _load(tmp_path, "cylinder-seal", {"piston_area": "490 mm^2"}, channels)[1]
    assert np.allclose(record.channels["friction_force"], FRICTION[: record.size])
    assert np.allclose(record.channels["normal_load"], 98.0)


def test_one_and_two_piezos(tmp_path):
    noise = 1e-3 * np.random.default_rng(1).standard_normal(T.size)
    channels = {"time": T, "voltage [V]": 100.0 * X, "displacement [um]": 10.0 * X + 3.0 + noise}
    _write(tmp_path, "piezo", {"bias_voltage": "0 V"}, channels)
    found = compare(tmp_path)
    assert found.base.fitted.model.values["rig.gain"] == pytest.approx(0.1e-6, rel=1e-3)
    assert found.validate["tip_y"].rms == pytest.approx(1e-9, rel=0.2)
    # That a single piezo does not tilt is stated by the kind: it is no fault of a sensor.
    assert found.warnings == () and not any("never changes" in note for note in found.problem.notes)
    random = np.random.default_rng(3)
    other = 0.4 * np.cos(11.0 * T)
    channels = {"time": T, "voltage_1": 100.0 * X, "voltage_2": 100.0 * other}
    for name, course in (("displacement_1 [um]", X), ("displacement_2 [um]", other)):
        channels[name] = 10.0 * course + 3.0 + 1e-3 * random.standard_normal(T.size)
    _write(tmp_path, "two-piezos", {"bias_voltage": "0 V"}, channels)
    record = load_records(load_experiment(tmp_path))[0]
    # tip_x = -h (d2 - d1)/D and tip_y = (d1 + d2)/2 of the two displacements.
    d1, d2 = (1e-6 * channels[f"displacement_{k} [um]"][: record.size] for k in (1, 2))
    np.testing.assert_allclose(record.channels["tip_x"], 0.5 * (d1 - d2), atol=1e-18)
    np.testing.assert_allclose(record.channels["tip_y"], 0.5 * (d1 + d2), atol=1e-18)
    found = compare(tmp_path)
    assert found.base.fitted.model.values["rig.gain"] == pytest.approx(0.1e-6, rel=1e-3)
    for channel in ("tip_x", "tip_y"):
        assert found.validate[channel].rms == pytest.approx(1e-9 / np.sqrt(2.0), rel=0.2)


OWN = """meaning = "a voice coil against a flexure"
base = "force-drive"

[channels]
coil_current = "A"

[known]
force_constant = "N/A"
flexure_stiffness = "N/m"

[balance]
drive_force = "known.force_constant * channel.coil_current - known.flexure_stiffness * channel.position"
"""
KNOWN = {"force_constant": "8 N/A", "flexure_stiffness": "300 N/m", "mass": "0.5 kg"}
CHANNELS = {"time": T, "position": X, "coil_current [A]": (0.5 * A + FRICTION + 300.0 * X) / 8.0}


def test_own_and_packaged_kinds_are_short_declarations(tmp_path):
    (tmp_path / "coil.toml").write_text(OWN)
    record = _load(tmp_path, "coil.toml", KNOWN, CHANNELS)[1]
    assert np.allclose(record.channels["drive_force"], (0.5 * A + FRICTION)[: record.size])
    assert OWN.count("\n") < 40
    files = list(FOLDER.glob("*.toml"))
    assert len(files) >= 10 and {file.stem for file in files} <= set(kinds())
    for file in files:
        text = file.read_text(encoding="utf-8")
        assert text.startswith("#") and text.count("\n") < 40


@pytest.mark.parametrize("old, new, line", cases("mistakes", "rig_kind"))
def test_a_fault_in_a_declaration_is_one_line(tmp_path, old, new, line):
    assert old in OWN
    (tmp_path / "coil.toml").write_text(OWN.replace(old, new, 1))
    refused(re.escape(line), _load, tmp_path, "coil.toml", KNOWN, CHANNELS)


@pytest.mark.parametrize("kind, leave, line", cases("mistakes", "rig"))
def test_what_is_missing_is_one_line(tmp_path, kind, leave, line):
    (tmp_path / "coil.toml").write_text(OWN)
    known = {key: value for key, value in KNOWN.items() if key != leave}
    channels = {key: values for key, values in CHANNELS.items() if key != leave}
    refused(re.escape(line.replace("{dir}", str(tmp_path))), _load, tmp_path, kind, known, channels)
