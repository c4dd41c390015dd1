"""Intervals of fitted values by the wild bootstrap in blocks of time (Liu 1988; Shao 2010).

Each draw makes records

    y* = f(best) + s_b e_b + sum_j g_j c_j,    s_b = +1 or -1 for each block b,   g_j standard normal

and refits the model to them from its best values. Only one sign per block is random, so the errors of a draw have the
correlation and the local variance of the measured ones. `e_b` is the residual of block b corrected for its leverage,
(1 - H_b)^-1 times the residual (MacKinnon and Webb 2018). `c_j` are the changes of
`sysid.estimation.covariance`; the means of the priors are drawn too. Unlike `sysid.estimation.covariance`, the
method does not assume linearity, and values may be near their bounds.
"""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from sim.effects.catalogue import find
from sim.effects.custom import load_all_custom
from stagecad.consent import require_consent
from stagecad.parameters.errors import InputError
from stagecad.parameters.input_file import read_input
from sysid.estimation.covariance import BLOCKS_PER_RECORD, block_scores, systematic_errors
from sysid.estimation.fit import FittedModel, residual_function
from sysid.estimation.least_squares import least_squares
from sysid.estimation.misfit import ResidualWeights, blocks, weighted_residual
from sysid.estimation.reference_fit import along_observer
from sysid.experiment.experiment import Experiment
from sysid.experiment.known import Prior, Unknown
from sysid.experiment.record import Record
from sysid.prediction.model import Model
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.problem import Problem, build_problem

ITERATIONS = 15
"""Largest number of steps of a refit."""
LEAST_DRAWS = 20


@dataclass(frozen=True, eq=False)
class Refit:
    """A fitted problem as plain data that another process can refit: experiment without the contents of its files,
    records as read, names of the effects with their variants, best values and unknowns of the fit, its weights, whether
    it is along the motion of a state observer, and texts of the user's own effects by file name."""

    experiment: Experiment
    records: tuple[Record, ...]
    names: tuple[str, ...]
    values: dict[str, float]
    unknowns: tuple[Unknown, ...]
    weights: ResidualWeights
    observed: bool
    custom: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class _Prepared:
    model: Model
    records: tuple[PreparedRecord, ...]
    residual: np.ndarray  # (n,), at the best values
    basis: np.ndarray  # (n, p), orthonormal, of the Jacobian
    changes: tuple[np.ndarray, ...]


@lru_cache(maxsize=1)
def _prepared(refit: Refit) -> _Prepared:
    """Residual, basis and systematic errors from which draws are made; computed once per process."""
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for name, text in refit.custom:
            files.append(Path(folder) / name)
            files[-1].write_text(text, "utf-8")
        custom = load_all_custom(files)
    records = build_problem(refit.experiment, refit.records, refit.names, custom).fit_records
    model = Model(tuple(find(name, custom) for name in refit.names), refit.values, refit.unknowns).at({})
    if refit.observed:
        records = tuple(along_observer(record, model) for record in records)
    # A single step, to obtain the Jacobian at the best values.
    result = least_squares(residual_function(model, records, refit.weights), model.unknowns, iterations=1)
    residual = weighted_residual(model, records, refit.weights)
    columns = result.jacobian[:, np.linalg.norm(result.jacobian, axis=0) > 0.0]
    basis = np.linalg.qr(columns)[0] if columns.size else np.empty((residual.size, 0))
    changes = systematic_errors(FittedModel(model, result, refit.weights), records)
    return _Prepared(model, records, residual, basis, tuple(changes))


def refit_of(problem: Problem, fitted: FittedModel) -> Refit:
    """The data that another process needs for a refit."""
    if not fitted.model.unknowns:
        raise InputError(f"{problem.experiment.path}: the model has no value to fit, so there is nothing to bootstrap")
    files = [source for source in problem.experiment.custom if isinstance(source, Path)]
    if len(files) < len(problem.experiment.custom):
        raise InputError(f"{problem.experiment.path}: an effect declared in memory cannot be sent to other processes")
    return Refit(
        experiment=replace(problem.experiment, records=(), custom=()),
        records=problem.records,
        names=tuple(effect.name for effect in fitted.model.effects),
        values=dict(fitted.model.values),
        unknowns=fitted.model.unknowns,
        weights=fitted.weights,
        observed=any(getattr(record, "observer", None) is not None for record in problem.fit_records),
        custom=tuple((path.name, _source(path)) for path in files),
    )


def _source(path: Path) -> str:
    """Text of a user's effect, which another process runs without asking."""
    data = read_input(path)
    require_consent(path, data)
    return data.decode("utf-8")


def refitted(refit: Refit, seed: Sequence[int]) -> tuple[float, ...] | None:
    """Values of one draw, in the order of the unknowns; None if its fit did not converge."""
    ready = _prepared(refit)
    random = np.random.default_rng(seed)
    numbers = blocks(ready.records, refit.weights, BLOCKS_PER_RECORD, float(random.uniform()))
    signs = random.choice((-1.0, 1.0), int(numbers.max()) + 1)[numbers]
    shift = signs * _leverage_corrected(ready.residual, ready.basis, numbers) - ready.residual
    for change in ready.changes:
        shift = shift + random.normal() * change
    unknowns = tuple(
        u if u.prior is None else replace(u, prior=Prior(float(random.normal(u.prior.value, u.prior.std)), u.prior.std))
        for u in ready.model.unknowns
    )
    residual = residual_function(ready.model, ready.records, refit.weights)
    result = least_squares(lambda point: residual(point) + shift, unknowns, iterations=ITERATIONS)
    return tuple(result.values[u.key] for u in unknowns) if result.converged else None


def _leverage_corrected(residual: np.ndarray, basis: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """The residual (n,) corrected for the leverage of each block: (1 - U_b U_b^T)^-1 e_b, which is
    e_b + U_b (1 - U_b^T U_b)^-1 U_b^T e_b."""
    scores = block_scores(basis, np.ones(residual.size), residual, numbers)
    return residual + np.sum(basis * scores[numbers], axis=1)


@dataclass(frozen=True)
class Bootstrap:
    """Values of the draws."""

    keys: tuple[str, ...]  # of the fitted values
    best: np.ndarray  # of the fit itself, (p,)
    values: np.ndarray  # (draws, p), of the draws whose fit converged
    requested: int  # number of draws

    @property
    def std(self) -> np.ndarray:
        """Standard deviation of each value, (p,)."""
        return self.values.std(axis=0, ddof=1)

    @property
    def band(self) -> tuple[np.ndarray, np.ndarray]:
        """Limits of the central 95 % of the draws, (p,) each."""
        low, high = np.quantile(self.values, [0.025, 0.975], axis=0)
        return low, high


def bootstrap_of(refit: Refit, found: Sequence[tuple[float, ...] | None]) -> Bootstrap:
    """The result of all draws."""
    converged = [values for values in found if values is not None]
    if len(converged) < max(LEAST_DRAWS // 2, len(found) // 2):
        raise InputError(
            f"{refit.experiment.path}: only {len(converged)} of {len(found)} refits converged; the values of the model "
            "are not identifiable from these records (see the output of compare)"
        )
    keys = tuple(u.key for u in refit.unknowns)
    return Bootstrap(keys, np.array([refit.values[key] for key in keys]), np.array(converged), len(found))
