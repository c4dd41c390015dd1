"""Comparison of the stated model with its records: misfit over the noise, and residual maps."""

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from sysid.diagnosis.consistency import consistency_warnings
from sysid.diagnosis.residual_maps import ResidualMap, residual_maps
from sysid.estimation.misfit import ChannelMisfit, misfit
from sysid.estimation.reference_fit import ReferenceFit, fit_stated_model, reported_fit
from sysid.experiment.experiment import DesignValues
from sysid.prediction.problem import Problem, load_problem
from sysid.prediction.simulation_error import SimulationErrors, simulation_errors


@dataclass(frozen=True)
class Comparison:
    """A fitted model compared with its records."""

    # problem, base: the identification problem and the fitted model
    problem: Problem
    base: ReferenceFit
    # fit, validate: misfit by channel on the records of the fit and the held-out ones
    fit: dict[str, ChannelMisfit]
    validate: dict[str, ChannelMisfit]
    maps: tuple[ResidualMap, ...]  # of the residual over every coordinate, largest explained share first
    simulation: SimulationErrors  # errors of a free run, and of simulations over short horizons
    seconds: float  # run time
    warnings: tuple[str, ...] = ()  # contradictions in the records, one line each


def compare(source: str | Path | Problem, design: DesignValues | None = None) -> Comparison:
    """Fit the stated model of an experiment and compare it with the records."""
    began = perf_counter()
    problem = source if isinstance(source, Problem) else load_problem(source, design)
    problem, base = reported_fit(problem, fit_stated_model(problem))
    model = base.fitted.model
    fit = misfit(model, problem.fit_records)
    massless = "rig.mass is at its bound: the motion of so small a mass is not simulated"
    return Comparison(
        problem=problem,
        base=base,
        fit=fit,
        validate=misfit(model, problem.validate_records),
        maps=tuple(residual_maps(model, problem, base)),
        simulation=SimulationErrors({}, {}, massless)
        if "rig.mass" in base.fitted.fit.at_bound
        else simulation_errors(problem, model),
        seconds=perf_counter() - began,
        warnings=tuple(consistency_warnings(problem, fit)),
    )
