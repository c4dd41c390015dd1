"""The model as it stands against the records: how far above the noise it fails, and where."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from sysid.diagnosis.residual_maps import ResidualMap, residual_maps
from sysid.estimation.misfit import ChannelMisfit, misfit
from sysid.estimation.reference_fit import ReferenceFit, fit_stated_model
from sysid.experiment.experiment import DesignValues
from sysid.prediction.problem import Problem, load_problem


@dataclass(frozen=True)
class Comparison:
    """A fitted model held against its records.

    Args:
        problem, base: what was compared.
        fit, validate: misfit by channel on the records of the fit and the held-out ones.
        maps: of the residual against every coordinate, strongest first.
        seconds: taken.
    """

    problem: Problem
    base: ReferenceFit
    fit: dict[str, ChannelMisfit]
    validate: dict[str, ChannelMisfit]
    maps: tuple[ResidualMap, ...]
    seconds: float


def compare(source: str | Path | Problem, design: DesignValues | None = None) -> Comparison:
    """Fit the model of an experiment as it stands and see where it fails.

    Args:
        source: folder of the experiment, its `experiment.toml`, or a problem already built.
        design: what a known value of `"design"` stands for.

    Raises:
        InputError: a fault in a file, in one line.
    """
    began = perf_counter()
    problem = source if isinstance(source, Problem) else load_problem(source, design)
    base = fit_stated_model(problem)
    model = base.fitted.model
    maps = residual_maps(model, problem.fit_records, base.fitted.weights, problem.validate_records, base.weights)
    return Comparison(
        problem, base, misfit(model, problem.fit_records), misfit(model, problem.validate_records), tuple(maps),
        perf_counter() - began,
    )  # fmt: skip
