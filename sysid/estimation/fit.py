"""Fit of a model to records: from the force balance, several starts, bounds and dead columns reported."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sysid.estimation.least_squares import FitResult, ResidualFunction, jacobian, least_squares
from sysid.estimation.misfit import ResidualWeights, huber_square, residual_weights, weighted_residual
from sysid.prediction.friction_drive.record import FrictionDriveRecord
from sysid.prediction.model import Model, PreparedRecord


@dataclass(frozen=True)
class FittedModel:
    """A model at its best values, with the fit that found them."""

    model: Model
    fit: FitResult
    weights: ResidualWeights

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """What each unknown does to the residual, (n,), by key."""
        return dict(zip(self.fit.keys, self.fit.jacobian.T, strict=True))


def fit_model(
    model: Model,
    records: Sequence[PreparedRecord],
    weights: ResidualWeights | None = None,
    iterations: int = 25,
    near: FittedModel | None = None,
    final_jacobian: bool = True,
) -> FittedModel:
    """Fit the model's unknowns to the records.

    Without `weights` the deviations are taken from the model's own start, and once more from its first fit.

    Args:
        model: with the values to start from.
        records: those fitted.
        weights: deviations and samples.
        iterations: steps at the most.
        near: fit of the same records on the same `weights` at values near the start: what an unknown of it does there
            is taken for what it does here, until a step tells otherwise.
        last_word: measure what the unknowns do where the fit ends; without, it is as the steps left it.
    """
    if weights is not None:
        # A driven stage slips at other times where a value is another: what its unknowns do, too.
        driven = any(isinstance(record, FrictionDriveRecord) for record in records)
        known = near.columns if near is not None and not driven else {}
        residual = _residual_of(model, records, weights)
        result = least_squares(
            residual, model.unknowns, iterations=iterations, known=known, final_jacobian=final_jacobian
        )
        return FittedModel(model.at(result.values), result, weights)
    first = fit_model(model, records, residual_weights(model, records), iterations)
    weights = residual_weights(first.model, records)
    rescaled = _rescaled(first.weights, weights)
    known = {key: column * rescaled for key, column in first.columns.items()}
    residual = _residual_of(first.model, records, weights)
    result = least_squares(residual, first.model.unknowns, iterations=iterations, known=known, exact_jacobian=True)
    return FittedModel(first.model.at(result.values), result, weights)


def _rescaled(before: ResidualWeights, after: ResidualWeights) -> np.ndarray:
    """Deviations of the scored samples before over those after, all channels of all records end to end, (n,)."""
    parts = [
        earlier[channel] / later[channel]
        for earlier, later in zip(before.scored_std, after.scored_std, strict=True)
        for channel in earlier
    ]
    return np.concatenate(parts) if parts else np.empty(0)


def _residual_of(model: Model, records: Sequence[PreparedRecord], weights: ResidualWeights) -> ResidualFunction:
    """The weighted residual (n,) of a model at a point (p,) of its unknowns."""
    keys = [u.key for u in model.unknowns]

    def residual(point: np.ndarray) -> np.ndarray:
        values = {**model.values, **dict(zip(keys, point.tolist(), strict=True))}
        return weighted_residual(model, records, weights, values)

    return residual


def with_final_jacobian(fitted: FittedModel, records: Sequence[PreparedRecord]) -> FittedModel:
    """The fit with what its unknowns do measured where it ended."""
    if fitted.fit.measured:
        return fitted
    point = np.array([fitted.fit.values[key] for key in fitted.fit.keys])
    residual = _residual_of(fitted.model, records, fitted.weights)
    columns = jacobian(residual, point, fitted.fit.residual, fitted.model.unknowns)
    return replace(fitted, fit=replace(fitted.fit, jacobian=columns, measured=True))


def root_mean_huber(residual: np.ndarray) -> float:
    """Error by which models are ranked: root mean Huber square of a residual in deviations."""
    return float(np.sqrt(np.mean(huber_square(residual)))) if residual.size else float("nan")
