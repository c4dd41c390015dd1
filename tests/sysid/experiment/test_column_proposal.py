"""Columns that are proposed for channels: units, axes and kinds of rig that compete for the same channel."""

from pathlib import Path

import numpy as np
import pytest

from stagecad.parameters.errors import InputError
from sysid.experiment.column_proposal import ExperimentProposal, Proposal, propose, read_numbers
from sysid.experiment.readers.open import open_record_file

TIME = 0.01 * np.arange(200)
SWING = np.sin(3.0 * TIME)
RATE = 3.0 * np.cos(3.0 * TIME)
FORCE = np.sign(RATE) + 0.1 * RATE


def _proposed(path: Path, columns: dict[str, np.ndarray], kind: str | None = None) -> ExperimentProposal:
    np.savetxt(path, np.stack([*columns.values()], axis=1), delimiter=",", header=",".join(columns), comments="")
    opened = open_record_file(path, path.name)
    return propose(opened, read_numbers(opened), kind)


def _chosen(proposal: ExperimentProposal) -> dict[str, Proposal]:
    return {column.channel: column for column in proposal.columns if column.channel}


def test_a_column_in_the_unit_of_its_channel_comes_before_the_output_of_its_transducer(tmp_path):
    raw = {"Force (V)": FORCE / 200.0, "Force (N)": FORCE, "Travel (V)": SWING / 9.0, "Travel (mm)": 20.0 * SWING}
    chosen = _chosen(_proposed(tmp_path / "log.csv", {"time [s]": TIME, **raw, "Temp (C)": 20.0 + SWING}))
    labels = {channel: column.label for channel, column in chosen.items()}
    assert labels["friction_force"] == "Force (N)" and labels["position"] == "Travel (mm)"
    assert not any("column" in chosen[name].question for name in ("friction_force", "position"))
    assert chosen["temperature"].unit == "degC" and "'degC'" in chosen["temperature"].question


def test_a_torque_comes_before_a_current_and_a_velocity_in_hertz_is_in_turns(tmp_path):
    logged = {"speed [Hz]": RATE, "motor current [A]": FORCE / 0.1, "motor torque [Nm]": FORCE}
    chosen = _chosen(_proposed(tmp_path / "log.csv", {"time [s]": TIME, **logged}))
    assert chosen["drive_force"].label == "motor torque [Nm]" and chosen["drive_force"].scale is None
    assert chosen["velocity"].unit == "rev/s" and chosen["velocity"].scale is None


def test_of_several_axes_the_one_that_moves_most_is_taken_in_every_channel(tmp_path):
    still, axes = 1e-4 * SWING, ("1", "2", "3")
    logged = {f"q.{k}": SWING if k == "2" else still for k in axes}
    logged |= {f"qd.{k}": RATE if k == "2" else 3.0 * still for k in axes}
    logged |= {f"tau.{k}": FORCE for k in axes}
    chosen = _chosen(_proposed(tmp_path / "log.csv", {"time": TIME, **logged}))
    assert [chosen[name].label for name in ("position", "velocity", "friction_force")] == ["q.2", "qd.2", "tau.2"]
    assert "or is column 2 or 4 'position'?" in chosen["position"].question


def test_the_axis_before_a_quantity_is_no_position(tmp_path):
    logged = {"q2": SWING, "dq2": RATE, "ddq2": 0.0 * SWING, "q2_tau_J": FORCE}
    proposal = _proposed(tmp_path / "log.csv", {"time": TIME, **logged})
    chosen = {channel: column.label for channel, column in _chosen(proposal).items()}
    assert chosen == {"time": "time", "position": "q2", "velocity": "dq2", "friction_force": "q2_tau_J"}
    assert proposal.columns[3].reason == "0 in every row" and "or is" not in proposal.columns[1].question


def test_a_semicolon_row_beyond_the_header_is_no_decimal_comma(tmp_path):
    (tmp_path / "log.csv").write_text("time;force\n" + "".join(f"0;{k};{k + 1}\n" for k in range(9)))
    with pytest.raises(InputError, match="has 3 cells, the header 2; name the columns by their numbers"):
        open_record_file(tmp_path / "log.csv", "log.csv")


def test_a_channel_of_a_declared_kind_is_found_by_the_words_of_its_name(tmp_path):
    logged = {"Displacement_15kv": 1e3 * SWING, "Voltage_15kv": 100.0 * SWING}
    chosen = _chosen(_proposed(tmp_path / "log.csv", {"time": TIME, **logged}, "piezo"))
    assert {"displacement", "voltage"} <= {*chosen}


def test_a_displacement_of_another_axis_is_left_out_beside_a_rotation(tmp_path):
    height = 0.01 * np.random.default_rng(1).normal(size=TIME.size)
    logged = {"time [s]": TIME, "Load (N)": 3.0 + height, "Speed (rpm)": 100.0 * RATE, "Torque (Nm)": FORCE}
    proposal = _proposed(tmp_path / "log.csv", {**logged, "Z Position (mm)": height})
    assert "position" not in _chosen(proposal) and "is not its derivative" in proposal.columns[-1].reason
    rack = _proposed(tmp_path / "rack.csv", {**logged, "Position (mm)": 20.0 * SWING})
    assert _chosen(rack)["position"].scale == "rad/m"
