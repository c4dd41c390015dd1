"""Fit of a model to records: weighted residual, robust least squares, and the fitted model with its Jacobian."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sysid.estimation.least_squares import MOST_STEPS, FitResult, ResidualFunction, jacobian, least_squares
from sysid.estimation.misfit import (
    ResidualWeights,
    huber_square,
    residual_weights,
    shared_weights,
    weighted_residual,
)
from sysid.prediction.friction_drive.record import FrictionDriveRecord
from sysid.prediction.model import Model
from sysid.prediction.prepared_record import PreparedRecord


@dataclass(frozen=True)
class FittedModel:
    """A model at its best values, with the fit that found them and the residual weights of that fit."""

    model: Model
    fit: FitResult
    weights: ResidualWeights

    def __repr__(self) -> str:
        return f"<FittedModel: {self.model!r}>"

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Column (n,) of the Jacobian of each unknown, by key."""
        return dict(zip(self.fit.keys, self.fit.jacobian.T, strict=True))


def fit_model(
    model: Model,
    records: Sequence[PreparedRecord],
    weights: ResidualWeights | None = None,
    iterations: int = MOST_STEPS,
    near: FittedModel | None = None,
    final_jacobian: bool = True,
) -> FittedModel:
    """Fit the unknowns of a model to records.

    Without `weights` the standard deviations are computed from the model at its start, and again after a first fit.
    """
    known: Mapping[str, np.ndarray] = {}
    first = None
    if weights is None:
        first = fit_model(model, records, residual_weights(model, records), iterations)
        model, weights = first.model, residual_weights(first.model, records)
        ratio = std_ratio(first.weights, weights)
        known = {key: column * ratio for key, column in first.columns.items()}
    elif near is not None and not any(isinstance(record, FrictionDriveRecord) for record in records):
        # On a driven stage the times of slip depend on the values: a Jacobian at other values is not an approximation.
        known = near.columns
    residual = residual_function(model, records, weights)
    result = least_squares(
        residual,
        model.unknowns,
        iterations=iterations,
        known=known,
        exact_jacobian=first is not None,
        final_jacobian=final_jacobian,
    )
    found = FittedModel(model.at(result.values), result, weights)
    if first is None:
        return found
    # A wrong model may have next to no noise in some rows, which would decide alone.
    shared = shared_weights(first.weights, weights)
    errors = [root_mean_huber(weighted_residual(one.model, records, shared)) for one in (first, found)]
    return with_final_jacobian(first, records) if CLEARLY_WORSE * errors[0] < errors[1] else found


CLEARLY_WORSE = 1.5
"""Ratio of the errors, by the deviations that both share, from which the fit with the deviations of the first one is
left for that one."""


def std_ratio(before: ResidualWeights, after: ResidualWeights) -> np.ndarray:
    """Ratio of the former to the new standard deviations of the scored samples, (n,)."""
    parts = [
        earlier[channel] / later[channel]
        for earlier, later in zip(before.scored_std, after.scored_std, strict=True)
        for channel in earlier
    ]
    return np.concatenate(parts) if parts else np.empty(0)


def residual_function(model: Model, records: Sequence[PreparedRecord], weights: ResidualWeights) -> ResidualFunction:
    """The weighted residual (n,) of a model as a function of its unknowns (p,)."""
    keys = [u.key for u in model.unknowns]

    def residual(point: np.ndarray) -> np.ndarray:
        values = {**model.values, **dict(zip(keys, point.tolist(), strict=True))}
        return weighted_residual(model, records, weights, values)

    return residual


def with_final_jacobian(fitted: FittedModel, records: Sequence[PreparedRecord]) -> FittedModel:
    """The fit with its Jacobian measured by differences at the best values."""
    if fitted.fit.exact:
        return fitted
    point = np.array([fitted.fit.values[key] for key in fitted.fit.keys])
    residual = residual_function(fitted.model, records, fitted.weights)
    columns = jacobian(residual, point, fitted.fit.residual, fitted.model.unknowns)
    return replace(fitted, fit=replace(fitted.fit, jacobian=columns, exact=True))


def root_mean_huber(residual: np.ndarray) -> float:
    """Root of the mean Huber loss of a residual (n,) in standard deviations: the error by which models are ranked."""
    return float(np.sqrt(np.mean(huber_square(residual)))) if residual.size else float("nan")


@dataclass(frozen=True)
class InformationCriteria:
    """Criteria of a fitted model; the smaller, the better."""

    aic: float  # of Akaike
    bic: float  # of Schwarz
    samples: int  # n, scored samples of the records of the fit
    parameters: int  # k, with the residual variance


def information_criteria(fitted: FittedModel, beside: FittedModel | None = None) -> InformationCriteria:
    """Criteria of a model on the records of its fit, with the effective number of samples of one `beside` it."""
    noise, k = fitted if beside is None else beside, len(fitted.fit.keys) + 1
    products, squares, start = 0.0, 0.0, 0
    for samples in noise.weights.samples:
        for pick in samples.values():
            part = noise.fit.residual[start : start + pick.size]
            start += pick.size
            products, squares = products + float(part[1:] @ part[:-1]), squares + float(part @ part)
    return criteria_of(fitted.fit.residual, k, products / squares if squares > 0.0 else 0.0)


def criteria_of(residual: np.ndarray, parameters: int, correlation: float = 0.0) -> InformationCriteria:
    """Criteria of a weighted residual (n,) with a number of parameters, the variance included, and the autocorrelation
    of neighbouring samples."""
    n = residual.size
    if n == 0:
        return InformationCriteria(float("nan"), float("nan"), 0, parameters)
    r = min(max(correlation, 0.0), 1.0 - 2.0 / (n + 1.0))
    effective = n * (1.0 - r) / (1.0 + r)
    deviance = effective * float(np.log(max(float(residual @ residual), np.finfo(float).tiny) / n))
    penalty = float(np.log(max(effective, 1.0)))
    return InformationCriteria(deviance + 2.0 * parameters, deviance + penalty * parameters, n, parameters)
