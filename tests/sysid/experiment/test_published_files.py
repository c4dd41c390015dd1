"""Public measurements load as their authors published them, without a conversion by hand.

The data are not part of the project; where they lie beside it they are converted. Each is written back into the form of
its publication (names, units, matrix or columns without a header), and read by the settings of an experiment.
"""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from sysid.experiment.experiment import load_experiment
from sysid.experiment.record import load_records
from tests.beside import beside
from tests.reference.tables import reference

KIP, INCH, AREA = 4448.2216, 0.0254, 490.87e-6


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


WRITERS = {
    "pneumatic_seal": _text("\t", "", lambda c: 1e3 * c["time"], lambda c: 3.5 + 0 * c["time"],
              lambda c: 0.5 + 0 * c["time"], lambda c: 1.0 + 0 * c["time"], lambda c: 1e3 * c["position"],
              lambda c: c["normal_load"] / AREA / 1e5, lambda c: c["friction_force"] + c["normal_load"]),
    "piezo": _text(",", "", lambda c: c["time"], lambda c: 1e6 * c["tip_y"], lambda c: c["voltage_1"], before=","),
    "brfd": _json,
    "hsm150": _mat(J=lambda c: np.array([[1.2e-4]]), Iz=lambda c: c["time"][:, None], data=lambda c: np.column_stack(
            [c["time"], 0 * c["time"], c["position"], c["velocity"], c["drive_force"]])),
    "laas_cogging": _text(", ", "Time, Position, Velocity, Iq, Uq, Vsupply, Error Position", lambda c: c["time"],
              lambda c: c["position"], lambda c: 0 * c["time"], lambda c: c["friction_force"] / 0.05,
              lambda c: 0 * c["time"], lambda c: 0 * c["time"], lambda c: 0 * c["time"]),
    "dfki_gravity": _text(",", "time,position,velocity,torque",
              *(lambda c, n=n: c[n] for n in ("time", "position", "velocity", "torque"))),
    "franka": _text(",", "time,q7,dq7,ddq7,q7_tau_J_compensate,CV", lambda c: c["time"], lambda c: c["q7"],
              lambda c: c["dq7"], lambda c: 0 * c["time"], lambda c: c["q7_tau_J_compensate"], lambda c: 0 * c["time"]),
    "oartec": _text("", "", lambda c: np.append(0.9358429999999771, np.diff(c["time"]))),
}  # fmt: skip
"""Each writes the published form of converted columns (by name without unit)."""
MACHINES = reference("published_files")
ROLES = ('role = "fit"', 'role = "validate"\nname = "again"')
SI = {"mm": 1e-3, "ms": 1e-3, "um": 1e-6}


@pytest.mark.parametrize("name", WRITERS)
def test_a_published_file_is_read_as_it_is(name: str, tmp_path: Path) -> None:
    machine = MACHINES[name]
    file = machine["published"]
    table = pd.read_csv(beside("data", machine["converted"]), nrows=4000)
    columns = {}
    for label in map(str, table):
        column, _, unit = label.removesuffix("]").partition(" [")
        columns[column] = table[label].to_numpy(float) * SI.get(unit, 1.0)
    WRITERS[name](columns, tmp_path / file)
    records = "".join(f'[[record]]\nfile = "{file}"\n{more}\n' for more in ROLES)
    (tmp_path / "experiment.toml").write_text(
        f"schema = 1\n[rig]\n{machine['rig']}\n[model]\neffects = []\n[channels]\n{machine['channels']}\n{records}"
    )
    record = load_records(load_experiment(tmp_path))[0]
    assert record.size == len(table)
    np.testing.assert_allclose(np.diff(record.time), np.diff(columns["time"]), rtol=0, atol=1e-9)
    if name == "oartec":
        # Time and angle count from the pulse before the first row.
        np.testing.assert_allclose(np.diff(record.channels["position"]), np.diff(columns["position"]), atol=2e-4)
        assert record.rotary and not record.channels["drive_force"].any()
    for channel, column in machine["compared"].items():
        expected = columns[column]
        size = np.max(np.abs(expected))
        np.testing.assert_allclose(record.channels[channel], expected, rtol=0, atol=2e-9 * size, err_msg=channel)
