"""Zero-order hold or linear interpolation of a logged drive force, where the experiment does not state it.

A command is held from each row to the next, and acts half a row late; the samples of a force sensor lie on a smooth
curve. If the force F was sampled and is taken as held, the balance of a true model is left with -b h/2 dF/dt, b = 1; if
it was held, b = 0. The noise of h/2 dF/dt is subtracted from its square (Fuller, Measurement Error Models, 1987, 1.2).
"""

from dataclasses import replace

import numpy as np

from sysid.estimation.fit import FittedModel
from sysid.estimation.screening import profiled_residual, project_out
from sysid.experiment.record import load_records, load_whole_records
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.problem import Problem, build_problem

BLOCKS = 24
"""Blocks of a record, from whose scatter the standard deviation of b follows."""

SIGMAS, NEARER = 3.0, 0.5
"""Standard deviations of b, and distance from 1 within which all of them are nearer to 1 than to 0: b is not exactly 1
of a force that was sampled at uneven times."""

SAMPLED = (
    "the drive force is not held from row to row, but linear between rows, as the residual shows; "
    'input_hold = "linear" or "zero" under [rig] states it'
)


def with_sampled_input(problem: Problem, fitted: FittedModel) -> Problem | None:
    """The problem with a drive force that is linear between rows, where the residual of a fitted model is that of a
    sampled one, or may be."""
    experiment = problem.experiment
    driven = [isinstance(r, ForceBalanceRecord) and "drive_force" in r.measured for r in problem.fit_records]
    if experiment.rig.states_hold or experiment.rig.input_hold == "linear" or not all(driven):
        return None
    if follows_motion(problem):
        return _sampled(problem)
    basis, residual = profiled_residual(fitted)
    late, by_noise = (project_out(column[:, None], basis)[:, 0] for column in _half_row_late(problem, fitted))
    blocks = np.array_split(np.arange(residual.size), BLOCKS)
    weights = np.array([late[rows] @ late[rows] - by_noise[rows] @ by_noise[rows] for rows in blocks])
    products = np.array([late[rows] @ residual[rows] for rows in blocks])
    if not weights.sum() > 0.0:
        return None
    b = float(products.sum() / weights.sum())
    std = float(np.linalg.norm(products - b * weights) / weights.sum())
    if abs(1.0 - b) + SIGMAS * std > NEARER:
        return None
    return _sampled(problem)


def follows_motion(problem: Problem) -> bool:
    """Whether the drive force is computed from what a motor is given and from its motion: then it is no smooth curve
    where the former is held, and either hold is tried."""
    return any(spec.balance is not None and spec.balance.follows_motion for spec in problem.experiment.records)


def _sampled(problem: Problem) -> Problem:
    """The problem with a drive force that is linear between rows."""
    rig = replace(problem.experiment.rig, input_hold="linear", states_hold=True)
    experiment, records = replace(problem.experiment, rig=rig), problem.records
    if follows_motion(problem):
        specs = [replace(s, balance=s.balance and replace(s.balance, held=False)) for s in experiment.records]
        experiment = replace(experiment, records=tuple(specs))
        records = load_whole_records(experiment) if problem.crossed else load_records(experiment)
    found = build_problem(experiment, records, custom=problem.custom)
    prepared = {"fit_records": found.fit_records, "validate_records": found.validate_records}
    return replace(problem, experiment=experiment, notes=(*problem.notes, SAMPLED), **prepared)


def _half_row_late(problem: Problem, fitted: FittedModel) -> tuple[np.ndarray, np.ndarray]:
    """-h/2 dF/dt over the standard deviation at the scored samples (n,), and a draw of the noise in it; zero where
    friction balances the force, whatever its course."""
    known, parts = problem.noise.get("drive_force"), []
    weights = fitted.weights
    for record, stds, samples in zip(problem.fit_records, weights.scored_std, weights.samples, strict=True):
        assert isinstance(record, ForceBalanceRecord) and record.full_filter is not None
        assert record.applied is not None and record.stick_fraction is not None
        drawn = np.zeros(record.size)
        if known is not None:
            drawn = known.value * known.spectrum.drawn(record.size, np.random.default_rng(0))
        for channel, pick in samples.items():
            scale = np.zeros(pick.size)
            if channel == "drive_force":
                scale = np.where(record.stick_fraction[pick] > 0.0, 0.0, -0.5 * record.step / stds[channel])
            parts.append([scale * record.full_filter(force, 1)[pick] for force in (record.applied, drawn)])
    late, by_noise = np.concatenate(parts, axis=1)
    return late, by_noise
