"""Errors of simulation: of a free run from the first valid row, and over short horizons from measured states.

    error = logged channel - simulated channel, at the rows with a logged value

A force balance compares forces along the measured motion; a simulation integrates the motion from the inputs alone, so
that its errors accumulate. Where the prediction of a rig is a simulation along its inputs (`output`), the free run is
the residual of the prediction. A start on a measured state then changes the position of a driven stage only: everything
else follows from the inputs, and horizons of the other rigs are the free run.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from sim.effects.effect import Effect
from sim.integration.simulate import SimulationError
from sim.numerics.elasto_plastic import stretch_along
from stagecad.parameters.errors import InputError
from sysid.experiment.experiment import Rig
from sysid.experiment.record import Record
from sysid.prediction.effect_terms import Values, axis_force, friction_axis, friction_level, values_of
from sysid.prediction.force_balance.driven_mass import simulate_driven_mass
from sysid.prediction.force_balance.predict import unfiltered_force
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.force_balance.state_observer import state_of_force
from sysid.prediction.model import Model, predict
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.problem import Problem, averaged
from sysid.prediction.rig_model import Start
from sysid.prediction.sensors import scaled, sensor_input, unscaled
from sysid.prediction.simulation import RIG_MODELS, uniform_inputs

HORIZONS = {"0.1 s": 0.1, "1 s": 1.0}
"""Lengths of the simulations from measured states, s."""

MOST_STARTS = 30
"""Measured states from which a set of records is simulated, evenly spread over it."""

MOST_ROWS = 10_000
"""Rows of a record, from its first, that are simulated in a free run of a driven mass."""

TOLERANCE = 1e-5
"""Relative error of a step of the integrator: far below the error of a model."""


class SimulationMisfit(NamedTuple):
    """Error of simulation of one channel: rms in its unit, and 100 (1 - |error| / |measured - mean|); NaN where the
    simulation failed."""

    rms: float
    fit_percent: float


Errors = dict[str, dict[str, SimulationMisfit]]
"""Errors by set of records (`fit`, `validate`) and channel."""


@dataclass(frozen=True)
class SimulationErrors:
    """Errors of simulation of a model; `note` states why there are none."""

    free_run: Errors
    horizon: dict[str, Errors]
    note: str = ""


Run = dict[str, tuple[np.ndarray, np.ndarray]]
"""Logged and simulated values (n,) of each channel over one simulation."""


class FreeRun(NamedTuple):
    """A simulation of a record from its inputs alone: time as logged (n,), s, and logged and simulated values by
    channel."""

    time: np.ndarray
    run: Run


def simulation_errors(problem: Problem, model: Model, horizons: Mapping[str, float] = HORIZONS) -> SimulationErrors:
    """Errors of simulation of a model on the records of a problem, over horizons of these lengths, s, by name."""
    sets = {"fit": problem.fit_records, "validate": problem.validate_records}
    free_run: Errors = {}
    horizon: dict[str, Errors] = {name: {} for name in horizons}
    try:
        for part, records in sets.items():
            starts = max(1, MOST_STARTS // max(len(records), 1))
            found = [_runs(*_logged(problem, r), r, model, starts, horizons)[1:] for r in records]
            free_run[part] = _misfits([run for run, _ in found])
            for name in horizons:
                horizon[name][part] = _misfits([windows for _, runs in found for windows in runs[name]])
    except InputError as failure:
        return SimulationErrors({}, {}, str(failure))
    return SimulationErrors(free_run, horizon)


def free_runs(problem: Problem, model: Model) -> dict[str, FreeRun]:
    """Simulations of all records from their inputs alone, by record; of a driven mass up to `MOST_ROWS` rows."""
    out = {}
    for prepared in (*problem.fit_records, *problem.validate_records):
        rig, record = _logged(problem, prepared)
        first, run, _ = _runs(rig, record, prepared, model, 1, {})
        rows = next(iter(run.values()))[0].size
        out[prepared.name] = FreeRun(record.time[0] + prepared.step * np.arange(first, first + rows), run)
    return out


def _logged(problem: Problem, prepared: PreparedRecord) -> tuple[Rig, Record]:
    """The rig, and the log of a prepared record, as they are simulated."""
    hold, logged = averaged(problem.experiment, problem.records)
    record = next(record for record in logged if record.name == prepared.name)
    return replace(problem.experiment.rig, input_hold=hold), record


def _misfits(runs: Sequence[Run]) -> dict[str, SimulationMisfit]:
    out = {}
    for channel in dict.fromkeys(name for run in runs for name in run):
        logged, simulated = (np.concatenate([run[channel][k] for run in runs]) for k in (0, 1))
        known = np.isfinite(logged)
        error, spread = (logged - simulated)[known], logged[known] - np.mean(logged[known])
        norm = float(np.linalg.norm(spread))
        percent = 100.0 * (1.0 - float(np.linalg.norm(error)) / norm) if norm > 0.0 else float("nan")
        out[channel] = SimulationMisfit(float(np.sqrt(np.mean(error**2))), percent)
    return out


def _runs(
    rig: Rig, record: Record, prepared: PreparedRecord, model: Model, starts: int, horizons: Mapping[str, float]
) -> tuple[int, Run, dict[str, list[Run]]]:
    """First row of the free run of a record, the run, and its simulations over each horizon."""
    if isinstance(prepared, ForceBalanceRecord) and prepared.acceleration is not None:
        return _driven_mass_runs(rig, record, prepared, model, starts, horizons)
    predicted = predict(prepared, model.effects, model.values)
    whole = {c: (np.where(prepared.valid[c], y, np.nan), predicted[c]) for c, y in prepared.measured.items()}
    if not RIG_MODELS[rig.kind].restarts:
        return 0, whole, {name: [whole] for name in horizons}

    def restarted(first: int, stop: int) -> Run:
        """The simulated motion of a window, from the measured position."""
        parts = {c: (y[first:stop], x[first:stop]) for c, (y, x) in whole.items()}
        return {c: (y, x + (y[0] - x[0])) for c, (y, x) in parts.items()}

    return 0, whole, _windows(prepared.valid["position"], prepared.step, starts, horizons, restarted)


def _windows(
    valid: np.ndarray, step: float, starts: int, horizons: Mapping[str, float], simulated: Callable[[int, int], Run]
) -> dict[str, list[Run]]:
    """Simulations over each horizon from valid rows (n,), evenly spread; none over a horizon longer than the record."""
    out: dict[str, list[Run]] = {}
    for name, length in horizons.items():
        rows = round(length / step) + 1
        firsts = np.flatnonzero(valid[: max(valid.size - rows, 0)]) if rows > 2 else np.empty(0, dtype=int)
        firsts = firsts[np.unique(np.linspace(0, firsts.size - 1, starts).astype(int))] if firsts.size else firsts
        out[name] = [simulated(int(first), int(first) + rows) for first in firsts]
    return out


def _driven_mass_runs(
    rig: Rig, record: Record, balance: ForceBalanceRecord, model: Model, starts: int, horizons: Mapping[str, float]
) -> tuple[int, Run, dict[str, list[Run]]]:
    time, logged, inputs = uniform_inputs(rig, record)
    measured = [name for name in rig.declaration.measured_channels if name in logged]
    states = _measured_states(balance, model.effects, model.values)

    def simulated(first: int, stop: int) -> Run:
        rows = slice(first, stop)
        window = unscaled({name: values[rows] for name, values in inputs.items()}, model.values)
        try:
            found = simulate_driven_mass(rig, time[rows], window, model.effects, model.values, states(first), TOLERANCE)
            found = scaled(found, model.values)
        except SimulationError:
            found = dict.fromkeys(measured, np.full(stop - first, np.nan))
        return {name: (logged[name][rows], found[name]) for name in measured}

    valid = balance.valid[balance.force_channel]
    first = int(np.argmax(valid))
    free_run = simulated(first, min(balance.size, first + MOST_ROWS))
    return first, free_run, _windows(valid, balance.step, starts, horizons, simulated)


def _measured_states(balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values) -> Callable[[int], Start]:
    """State of a driven mass at a row: filtered motion, and the friction state that gives the friction of the force
    balance, or follows from the motion where there are several elements."""
    axis, _ = friction_axis(balance, effects, values)
    assert balance.full_filter is not None and balance.raw_position is not None and balance.acceleration is not None
    smooth, path = balance.full_filter, balance.raw_position
    # A Gaussian filter of width w adds w^2/2 of the second derivative to a signal.
    blur = 0.5 * smooth.width**2
    position = smooth(path) - blur * balance.acceleration
    velocity = smooth(path, 1) - blur * np.gradient(balance.acceleration, balance.step)
    position = sensor_input(position, "position", effects, values, balance.step)
    velocity = sensor_input(velocity, "velocity", effects, values, balance.step)
    core = next((e for e in effects if e.friction_state is not None), None)
    level = np.broadcast_to(friction_level(balance, effects, values), (balance.size,))
    force = np.clip(unfiltered_force(balance, effects, values) - axis_force(balance, effects, values), -level, level)
    springs = None
    if core is not None and core.friction_state.springs is not None:
        springs = stretch_along(position, level, core.friction_state.springs(values_of(core, values)))

    def at(row: int) -> Start:
        bristle = None if springs is None else springs[:, row]
        if core is not None and springs is None:
            bristle = state_of_force(core, values, float(force[row]), float(velocity[row]), float(level[row]))
        age, gone = float(axis.contact_age[row]), float(axis.travelled[row])
        return Start(float(position[row]), float(velocity[row]), bristle, gone, age)

    return at
