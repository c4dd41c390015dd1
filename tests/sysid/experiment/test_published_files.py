"""Public measurements load as their authors published them, without a conversion by hand.

The data are not part of the project; where they lie beside it they are converted. Each is written back into the form of
its publication (names, units, matrix or columns without a header), and read by the settings of an experiment.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from sysid.experiment.experiment import load_experiment
from sysid.experiment.record import load_records

ROOT = Path(__file__).resolve().parents[3]
DATA = ROOT.parent / "shared" / "data"
KIP, INCH, AREA = 4448.2216, 0.0254, 490.87e-6


@dataclass(frozen=True)
class Machine:
    """A public measurement.

    Args:
        converted: its file beside the project.
        published: name of the published file.
        write: writes the published form of converted columns (by name without unit).
        rig, channels: of the experiment that reads it.
        compared: channel by converted column.
    """

    converted: str
    published: str
    write: Callable[[dict[str, np.ndarray], Path], None]
    rig: str
    channels: str
    compared: dict[str, str]


def _mat(**make: Callable[[dict[str, np.ndarray]], np.ndarray]) -> Callable[[dict[str, np.ndarray], Path], None]:
    def write(c: dict[str, np.ndarray], path: Path) -> None:
        from scipy.io import savemat

        savemat(path, {name: function(c) for name, function in make.items()})

    return write


def _text(separator: str, header: str, *make: Callable[[dict[str, np.ndarray]], np.ndarray], before: str = ""):
    def write(c: dict[str, np.ndarray], path: Path) -> None:
        columns = [np.asarray(function(c), float) for function in make]
        rows = [before + separator.join(f"{value:.10g}" for value in row) for row in zip(*columns, strict=True)]
        path.write_text("\n".join([*([header] if header else []), *rows]) + "\n")

    return write


def _json(c: dict[str, np.ndarray], path: Path) -> None:
    data = np.column_stack([c["time"], c["position"] / INCH, 0 * c["time"], c["friction_force"] / KIP])
    path.write_text(json.dumps({"data": data.tolist(), "dt": 0.0039, "friction force units": "kip"}))


FORCE = {"friction_force": "friction_force", "position": "position"}
MACHINES = {
    "emps": Machine(
        "emps/fit.csv",
        "DATA_EMPS.mat",
        _mat(t=lambda c: c["time"], qm=lambda c: c["position"], vir=lambda c: c["drive_force"] / 35.150651882),
        'kind = "force-drive"',
        'time = {column = "t", unit = "s"}\nposition = {column = "qm", unit = "m"}\n'
        'drive_force = {column = "vir", unit = "V", scale = "35.150651882 N/V"}',
        {"drive_force": "drive_force", "position": "position"},
    ),
    "tribometer": Machine(
        "reciprocating_tribometer/fit.csv",
        "test_data_2.txt",
        _text("\t", "Time [s]\tNormal [uN]\tPosition [mm]\tFriction [uN]", lambda c: c["time"],
              lambda c: 1e6 * c["normal_load"], lambda c: 1e3 * c["position"], lambda c: -1e6 * c["friction_force"]),
        'kind = "velocity-drive"',
        'position = "Position"\nfriction_force = {column = "Friction", sign = -1}\nnormal_load = "Normal"',
        FORCE,
    ),
    "pneumatic_seal": Machine(
        "pneumatic_seal/fit_NAPN_5bar.csv",
        "NAPN_5bar.csv",
        _text("\t", "", lambda c: 1e3 * c["time"], lambda c: 3.5 + 0 * c["time"], lambda c: 0.5 + 0 * c["time"],
              lambda c: 1.0 + 0 * c["time"], lambda c: 1e3 * c["position"],
              lambda c: c["normal_load"] / AREA / 1e5, lambda c: c["friction_force"] + c["normal_load"]),
        f'kind = "cylinder-seal"\n[rig.known]\npiston_area = "{AREA} m^2"',
        'time = {column = 1, unit = "ms"}\nposition = {column = 5, unit = "mm"}\n'
        'pressure = {column = 6, unit = "bar"}\nrod_force = {column = 7, unit = "N"}',
        {**FORCE, "normal_load": "normal_load"},
    ),
    "piezo": Machine(
        "piezo_1hz/fit.csv",
        "hysteresis_v_150_1hz.csv",
        _text(",", "", lambda c: c["time"], lambda c: 1e6 * c["tip_y"], lambda c: c["voltage_1"], before=","),
        'kind = "piezo"\n[rig.known]\nbias_voltage = "0 V"',
        'time = {column = 2, unit = "s"}\ndisplacement = {column = 3, unit = "um"}\nvoltage = {column = 4, unit = "V"}',
        {"tip_y": "tip_y", "voltage_1": "voltage_1"},
    ),
    "brfd": Machine(
        "brfd_backlash/fit_0.5Hz_0.5in.csv",
        "0.5Hz30lbtension0.5amplitude.json",
        _json,
        'kind = "velocity-drive"',
        'time = {column = "data.1", unit = "s"}\nposition = {column = "data.2", unit = "in"}\n'
        f'friction_force = {{column = "data.4", scale = "{KIP} N"}}',
        FORCE,
    ),
    "hsm150": Machine(
        "hsm150_two_motor/fit_idf_neg_0.045_1.csv",
        "idf_neg_0.045_1.mat",
        _mat(J=lambda c: np.array([[1.2e-4]]), Iz=lambda c: c["time"][:, None], data=lambda c: np.column_stack(
            [c["time"], 0 * c["time"], c["position"], c["velocity"], c["drive_force"]])),
        'kind = "force-drive"',
        'time = {column = "data.1", unit = "s"}\nposition = {column = "data.3", unit = "rad"}\n'
        'velocity = {column = "data.4", unit = "rad/s"}\ndrive_force = {column = "data.5", unit = "N*m"}',
        {"drive_force": "drive_force", "velocity": "velocity", "position": "position"},
    ),
    "laas_cogging": Machine(
        "laas_cogging_static_quarter/fit.csv",
        "stopped_data.txt",
        _text(", ", "Time, Position, Velocity, Iq, Uq, Vsupply, Error Position", lambda c: c["time"],
              lambda c: c["position"], lambda c: 0 * c["time"], lambda c: c["friction_force"] / 0.05,
              lambda c: 0 * c["time"], lambda c: 0 * c["time"], lambda c: 0 * c["time"]),
        'kind = "velocity-drive"',
        'time = {column = "Time", unit = "s"}\nposition = {column = "Position", unit = "rad"}\n'
        'velocity = {column = "Velocity", unit = "rad/s"}\n'
        'friction_force = {column = "Iq", unit = "A", scale = "0.05 N*m/A"}',
        FORCE,
    ),
    "dfki_gravity": Machine(
        "dfki_gravity/hand_moved.csv",
        "data_measured.csv",
        _text(",", "time,position,velocity,torque",
              *(lambda c, n=n: c[n] for n in ("time", "position", "velocity", "torque"))),
        'kind = "force-drive"',
        'time = {unit = "s"}\nposition = {unit = "rad"}\nvelocity = {unit = "rad/s"}\n'
        'drive_force = {column = "torque", unit = "N*m"}',
        {"drive_force": "torque", "position": "position"},
    ),
    "franka": Machine(
        "franka_joint7/fit_slow.csv",
        "case4_slow.csv",
        _text(",", "time,q7,dq7,ddq7,q7_tau_J_compensate,CV", lambda c: c["time"], lambda c: c["q7"],
              lambda c: c["dq7"], lambda c: 0 * c["time"], lambda c: c["q7_tau_J_compensate"], lambda c: 0 * c["time"]),
        'kind = "velocity-drive"',
        'time = {unit = "s"}\nposition = {column = "q7", unit = "rad"}\nvelocity = {column = "dq7", unit = "rad/s"}\n'
        'friction_force = {column = "q7_tau_J_compensate", unit = "N*m"}',
        {"friction_force": "q7_tau_J_compensate", "velocity": "dq7"},
    ),
    "oartec": Machine(
        "oartec_coast_forcedrive/coast_01.csv",
        "Oartec_Slider.csv",
        _text("", "", lambda c: np.append(0.9358429999999771, np.diff(c["time"]))),
        'kind = "force-drive"\n[rig.known]\nmass = "0.1057 kg*m^2"',
        'time = {column = 1, unit = "s", increments = true}\nposition = {pulses_per_turn = 3}\n'
        'drive_force = {value = "0 N*m"}',
        {},
    ),
}  # fmt: skip

SI = {"mm": 1e-3, "ms": 1e-3, "um": 1e-6}


@pytest.mark.parametrize("name", MACHINES)
def test_a_published_file_is_read_as_it_is(name: str, tmp_path: Path) -> None:
    machine = MACHINES[name]
    if not (DATA / machine.converted).is_file():
        pytest.skip(f"the records of {name} are not beside the project")
    table = pd.read_csv(DATA / machine.converted, nrows=4000)
    columns = {}
    for label in map(str, table):
        column, _, unit = label.removesuffix("]").partition(" [")
        columns[column] = table[label].to_numpy(float) * SI.get(unit, 1.0)
    machine.write(columns, tmp_path / machine.published)
    (tmp_path / "experiment.toml").write_text(
        f"schema = 1\n[rig]\n{machine.rig}\n[model]\neffects = []\n[channels]\n{machine.channels}\n"
        f'[[record]]\nfile = "{machine.published}"\nrole = "fit"\n[[record]]\nfile = "{machine.published}"\n'
        'role = "validate"\nname = "again"\n'
    )
    record = load_records(load_experiment(tmp_path))[0]
    assert record.size == len(table)
    np.testing.assert_allclose(np.diff(record.time), np.diff(columns["time"]), rtol=0, atol=1e-9)
    if name == "oartec":
        # Time and angle count from the pulse before the first row.
        np.testing.assert_allclose(np.diff(record.channels["position"]), np.diff(columns["position"]), atol=2e-4)
        assert record.rotary and not record.channels["drive_force"].any()
    for channel, column in machine.compared.items():
        expected = columns[column]
        size = np.max(np.abs(expected))
        np.testing.assert_allclose(record.channels[channel], expected, rtol=0, atol=2e-9 * size, err_msg=channel)
