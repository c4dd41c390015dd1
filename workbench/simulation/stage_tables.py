"""Data of the stage's studies as columns, `name [unit]`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from sim.stage.run import StageRun
from sim.stage.studies.coupling import CouplingStudy
from sim.stage.studies.ellipse import EllipseSearch
from sim.stage.studies.hunting import HOLDS, HuntingStudy
from sim.stage.studies.planar import PlanarStudy
from sim.stage.studies.positioning import PositioningStudy
from sim.stage.studies.speed import SpeedStudy
from sim.stage.studies.steps import StepStudy
from sim.stage.studies.travel_map import TravelMap

Columns = dict[str, np.ndarray]


def stage_tables(studies: Mapping[str, Any]) -> dict[str, Columns]:
    """Every table of every study, by the name of its file."""
    found: dict[str, Columns] = {}
    for study in studies.values():
        found |= _TABLES[type(study)](study)
    return found


def motion_columns(run: StageRun, rows: int = 5000) -> Columns:
    """Motion, forces and voltages of a run with one actuator, at most `rows` evenly spaced rows."""
    taken = np.unique(np.linspace(0, run.time.size - 1, min(rows, run.time.size)).astype(int))
    position, apex, force, volts = run.position, run.apex(0), run.tip_force(0), run.voltage(0)
    columns = {"time [s]": run.time}
    columns |= {
        f"{name} [{unit}]": position[:, i] for i, (name, unit) in enumerate((("x", "m"), ("y", "m"), ("yaw", "rad")))
    }
    columns |= {
        "heave [m]": run.attitude[:, 0],
        "roll [rad]": run.attitude[:, 1],
        "pitch [rad]": run.attitude[:, 2],
    }
    columns |= {f"tip_{axis} [m]": apex[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"tip_force_{axis} [N]": force[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"voltage_{i + 1} [V]": volts[:, i] for i in range(3)}
    for pad in range(len(run.machine.pads.places)):
        columns[f"pad_load_{pad + 1} [N]"] = run.pad_force(pad)[:, 2]
    return {name: values[taken] for name, values in columns.items()}


def _steps(study: StepStudy) -> dict[str, Columns]:
    return {f"stage_steps_{name}": motion_columns(stairs.run) for name, stairs in study.staircases.items()}


def _speed(study: SpeedStudy) -> dict[str, Columns]:
    columns: Columns = {"frequency [Hz]": study.frequencies}
    for height, points in study.points.items():
        columns[f"speed_{height} [m/s]"] = study.speed(height)
        columns[f"swing_{height} [m]"] = study.swing(height)
        columns[f"ratio_{height} [1]"] = study.ratio(height)
        columns[f"still_changing_{height} [m/s]"] = np.array([point.changed for point in points])
        columns[f"tip_load_{height} [N]"] = np.array([point.tip_load for point in points])
        columns[f"contact_share_{height} [1]"] = np.array([point.contact_share for point in points])
        columns[f"lifted_share_{height} [1]"] = np.array([point.lifted_share for point in points])
    return {"stage_speed": columns}


def _travel_map(study: TravelMap) -> dict[str, Columns]:
    heights, positions = np.meshgrid(study.heights, study.positions, indexing="ij")
    return {
        "stage_travel_map": {
            "position [m]": positions.ravel(),
            "height [m]": heights.ravel(),
            "pad_lifted_share [1]": study.lifted.ravel(),
            "tip_off_share [1]": study.tip_off.ravel(),
            "tip_load_share [1]": study.load_share.ravel(),
            "acceleration [m/s^2]": study.acceleration.ravel(),
        },
        "stage_tip_over": {
            "position [m]": study.positions,
            "share_pushed [1]": study.pushed,
            "share_limit [1]": study.limit,
        },
    }


def _ellipse(study: EllipseSearch) -> dict[str, Columns]:
    heights, phases = np.meshgrid(study.heights, study.phases, indexing="ij")
    flat = [point for row in study.points for point in row]
    return {
        "stage_ellipse": {
            "phase [rad]": phases.ravel(),
            "height_over_amplitude [1]": heights.ravel(),
            "speed [m/s]": study.speed.ravel(),
            "still_changing [m/s]": np.array([point.changed for point in flat]),
            "pad_lifted_share [1]": study.lifted.ravel(),
            "tip_load [N]": np.array([point.tip_load for point in flat]),
            "largest_tip_force [N]": np.array([point.largest_tip_force for point in flat]),
        }
    }


def _coupling(study: CouplingStudy) -> dict[str, Columns]:
    return {f"stage_coupling_{name}": motion_columns(run, 1001) for name, run in study.runs.items()}


def _planar(study: PlanarStudy) -> dict[str, Columns]:
    found = {}
    for drive in study.runs:
        ends = study.ends(drive)
        found[f"stage_planar_{drive}"] = {
            "direction [rad]": study.directions,
            "x [m]": ends[:, 0],
            "y [m]": ends[:, 1],
            "yaw [rad]": ends[:, 2],
            "direction_error [rad]": study.direction_errors(drive),
            "heave_rms [m]": study.heave(drive),
            "pad_lifted_share [1]": study.lifted(drive),
        }
    return found


def _positioning(study: PositioningStudy) -> dict[str, Columns]:
    return {
        f"stage_positioning_{name}": motion_columns(move.run) | {"error [m]": _thinned(move.error)}
        for name, move in study.moves.items()
    }


def _hunting(study: HuntingStudy) -> dict[str, Columns]:
    return {
        f"stage_hunting_{name}": motion_columns(held.run)
        | {"error [m]": _thinned(held.error), f"output [{HOLDS[name].output_unit}]": _thinned(held.output)}
        for name, held in study.holds.items()
    }


def _thinned(values: np.ndarray, rows: int = 5000) -> np.ndarray:
    return values[np.unique(np.linspace(0, values.size - 1, min(rows, values.size)).astype(int))]


_TABLES = {
    StepStudy: _steps,
    SpeedStudy: _speed,
    TravelMap: _travel_map,
    EllipseSearch: _ellipse,
    CouplingStudy: _coupling,
    PlanarStudy: _planar,
    PositioningStudy: _positioning,
    HuntingStudy: _hunting,
}
