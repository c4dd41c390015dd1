"""Results of simulations as tables in the records' own form: columns `name [unit]`, as CSV or Parquet."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sim.integration.simulate import Simulation
from stagecad.deferred import pyarrow
from stagecad.parameters.atomic import atomic_path
from workbench.operations.result import NUMBER, TEXT, Table

Columns = dict[str, np.ndarray]

ROWS = 20_001
"""Largest number of rows of a table: 1 kHz over the 20 s of a stick-slip run."""


def simulation_columns(run: Simulation, force: str, end: float | None = None, rows: int = ROWS) -> Columns:
    """Columns of one simulation, at most `rows` rows up to `end`, s; `force` names the drive's column."""
    last = run.time[-1] if end is None else end
    # Evenly spaced in time, whatever instants the run was read at besides; the share keeps an ulp from shifting a row.
    wanted = np.linspace(run.time[0], last, rows) - 1e-9 * last / rows
    taken = np.unique(np.minimum(np.searchsorted(run.time, wanted), run.time.size - 1))
    columns = {
        "time [s]": run.time,
        "position [m]": run.position,
        "velocity [m/s]": run.velocity,
        "friction_force [N]": run.friction,
        f"{force} [N]": run.drive,
        "level [N]": run.level,
        "bristle [m]": run.bristle[:, 0] if run.bristle.shape[1] else np.zeros(run.time.size),
        "core_work [J]": run.core_work,
        "other_work [J]": run.other_work,
        "stored [J]": run.stored,
        "kinetic [J]": run.kinetic,
    }
    return {name: values[taken] for name, values in columns.items()}


def write_table(path: Path, columns: Mapping[str, np.ndarray], kinds: tuple[str, ...]) -> list[Path]:
    """Write the columns to `path` with the suffix of each of `kinds` (csv, parquet); return the files."""
    table = pyarrow.table(dict(columns))
    written = []
    for kind in kinds:
        target = path.with_name(f"{path.name}.{kind}")
        with atomic_path(target) as temporary:
            if kind == "csv":
                from pyarrow import csv

                csv.write_csv(table, temporary, csv.WriteOptions(quoting_style="none"))
            else:
                from pyarrow import parquet

                parquet.write_table(table, temporary)
        written.append(target)
    return written


def feature_text(feature: Mapping[str, Any] | None) -> str:
    """A feature of a simulation in the unit that suits its size; a dash where there is none."""
    if feature is None:
        return "-"
    value, unit = feature["value"], feature["unit"]
    if unit == "m" and abs(value) < 1e-7:
        return f"{value * 1e9:.3f} nm"
    if unit == "m" and abs(value) < 1e-3:
        return f"{value * 1e6:.3f} um"
    if unit == "1":
        return f"{value:.4f}"
    return f"{value:.4f} {unit}" if abs(value) >= 1e-3 or value == 0.0 else f"{value:.3e} {unit}"


def feature_table(title: str, features: Mapping[str, Mapping[str, Any]], by_column: bool = False) -> Table:
    """Features in columns and what they are of in rows; with `by_column` the other way round."""
    names = list(next(iter(features.values())))
    words = [name.replace("_", " ") for name in names]
    if by_column:
        rows = [(word, *(feature_text(of[name]) for of in features.values())) for word, name in zip(words, names)]
        return Table(title, (("", TEXT), *((of, NUMBER) for of in features)), tuple(rows), plain=True)
    rows = [(of, *(feature_text(values[name]) for name in names)) for of, values in features.items()]
    return Table(title, (("", TEXT), *((word, NUMBER) for word in words)), tuple(rows), plain=True)


def tables_of(name: str, results: Mapping[str, Any]) -> dict[str, Columns]:
    """The tables of an experiment, by the name of their file."""
    tables: dict[str, Columns] = {}
    if name == "tip":
        for stroke, phases in results.items():
            for phase, path in phases.items():
                columns = {"time [s]": path.time, "tip_x [m]": path.x, "tip_y [m]": path.y}
                tables[f"tip_{stroke}_{phase.replace('/', '_over_')}"] = columns
    elif name == "presliding":
        for model, result in results.items():
            tables[f"presliding_{model}"] = simulation_columns(result.simulation, "drive_force")
    elif name == "stick-slip":
        from sim.experiments.stick_slip import PULL, SHOWN

        for model, result in results.items():
            columns = simulation_columns(result.simulation, "spring_force", SHOWN)
            columns["pull_position [m]"] = PULL * columns["time [s]"]
            tables[f"stick-slip_{model}"] = columns
    elif name == "limit-cycles":
        from sim.experiments.limit_cycles import SPEEDS

        for model, springs in results.items():
            columns = {"speed [m/s]": np.array(SPEEDS)}
            for spring, result in springs.items():
                columns[f"size_{spring} [N]"] = result.sizes
                columns[f"break_away_{spring} [N]"] = np.array([cycle.top for cycle in result.cycles])
                columns[f"dwell_{spring} [s]"] = np.array([cycle.dwell for cycle in result.cycles])
            tables[f"limit-cycles_{model}"] = columns
    else:
        for model, cases in results.items():
            for case, result in cases.items():
                # The motion is imposed as an acceleration: no mass has a kinetic energy.
                columns = simulation_columns(result.simulation, "acceleration", rows=2001)
                columns["acceleration [m/s^2]"] = columns.pop("acceleration [N]")
                del columns["kinetic [J]"]
                if name == "passivity":
                    del columns["acceleration [m/s^2]"]
                tables[f"{name}_{model}_{case}"] = columns
    return tables


def stage_tables(studies: Mapping[str, Any]) -> dict[str, Columns]:
    """Every table of every study, by the name of its file."""
    found: dict[str, Columns] = {}
    for name, study in studies.items():
        found |= _STUDIES[name](study)
    return found


def motion_columns(run: Any, rows: int = 5000) -> Columns:
    """Motion, forces and voltages of a run with one actuator, at most `rows` evenly spaced rows."""
    position, apex, force, volts = run.position, run.apex(0), run.tip_force(0), run.voltage(0)
    columns = {"time [s]": run.time}
    columns |= {
        f"{name} [{unit}]": position[:, i] for i, (name, unit) in enumerate((("x", "m"), ("y", "m"), ("yaw", "rad")))
    }
    columns |= {"heave [m]": run.attitude[:, 0], "roll [rad]": run.attitude[:, 1], "pitch [rad]": run.attitude[:, 2]}
    columns |= {f"tip_{axis} [m]": apex[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"tip_force_{axis} [N]": force[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"voltage_{i + 1} [V]": volts[:, i] for i in range(3)}
    for pad in range(len(run.machine.pads.places)):
        columns[f"pad_load_{pad + 1} [N]"] = run.pad_force(pad)[:, 2]
    return {name: _thinned(values, rows) for name, values in columns.items()}


def _steps(study: Any) -> dict[str, Columns]:
    return {f"stage_steps_{name}": motion_columns(stairs.run) for name, stairs in study.staircases.items()}


def _speed(study: Any) -> dict[str, Columns]:
    columns: Columns = {"frequency [Hz]": study.frequencies}
    for height, points in study.points.items():
        columns[f"speed_{height} [m/s]"] = study.speed(height)
        columns[f"swing_{height} [m]"] = study.swing(height)
        columns[f"ratio_{height} [1]"] = study.ratio(height)
        columns[f"still_changing_{height} [m/s]"] = np.array([point.changed for point in points])
        columns[f"tip_load_{height} [N]"] = np.array([point.tip_load for point in points])
        columns[f"contact_share_{height} [1]"] = np.array([point.contact_share for point in points])
        columns[f"lifted_share_{height} [1]"] = np.array([point.lifted_share for point in points])
    columns["speed_raised_again [m/s]"] = np.array([point.velocity[0] for point in study.again])
    return {"stage_speed": columns}


def _travel_map(study: Any) -> dict[str, Columns]:
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


def _ellipse(study: Any) -> dict[str, Columns]:
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


def _planar(study: Any) -> dict[str, Columns]:
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


def _positioning(study: Any) -> dict[str, Columns]:
    found = {
        f"stage_positioning_{name}": motion_columns(move.run) | {"error [m]": _thinned(move.error)}
        for name, move in study.moves.items()
    }
    for motion, followed in (("tracking", study.tracked), ("short_move", study.moved)):
        for name, one in followed.items():
            table = found.setdefault(f"stage_positioning_{motion}", {"time [s]": one.time, "wanted [m]": one.wanted})
            table[f"error_{name} [m]"] = one.error
    return found


def _hunting(study: Any) -> dict[str, Columns]:
    from sim.stage.studies.hunting import HOLDS

    units = {name: "m" if hold.moves == "lean" else "1" for name, hold in HOLDS.items()}
    return {
        f"stage_hunting_{name}": motion_columns(held.run)
        | {"error [m]": _thinned(held.error), f"output [{units[name]}]": _thinned(held.output)}
        for name, held in study.holds.items()
    }


def _tip_motion(study: Any) -> dict[str, Columns]:
    columns: Columns = {"turn [rad]": np.linspace(0.0, 2.0 * np.pi, 201)}
    for name, motion in study.motions.items():
        along, up = motion.path.at(columns["turn [rad]"])
        columns |= {f"along_{name} [m]": along, f"up_{name} [m]": up + motion.height}
    return {"stage_tip_motion": columns}


def _thinned(values: np.ndarray, rows: int = 5000) -> np.ndarray:
    return values[np.unique(np.linspace(0, values.size - 1, min(rows, values.size)).astype(int))]


_STUDIES = {
    "steps": _steps,
    "speed": _speed,
    "travel_map": _travel_map,
    "ellipse": _ellipse,
    "coupling": lambda study: {f"stage_coupling_{k}": motion_columns(run, 1001) for k, run in study.runs.items()},
    "planar": _planar,
    "positioning": _positioning,
    "hunting": _hunting,
    "tip_motion": _tip_motion,
}
