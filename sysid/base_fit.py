"""Fit of a model to records: from the force balance, several starts, bounds and dead columns reported."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sysid.fit import FitResult, least_squares
from sysid.misfit import Weighting, huber_square, weighted_residual, weighting
from sysid.model import Model, Prepared


@dataclass(frozen=True)
class Fitted:
    """A model at its best values, with the fit that found them."""

    model: Model
    fit: FitResult
    weights: Weighting


def fit_model(
    model: Model, records: Sequence[Prepared], weights: Weighting | None = None, iterations: int = 25
) -> Fitted:
    """Fit the model's unknowns to the records.

    Without `weights` the deviations are taken from the model's own start, and once more from its first fit.
    """
    own = weights is None
    if weights is None:
        weights = weighting(model, records)
    result = _fit(model, records, weights, iterations)
    model = model.at(result.values)
    if own:
        weights = weighting(model, records)
        result = _fit(model, records, weights, iterations)
        model = model.at(result.values)
    return Fitted(model, result, weights)


def _fit(model: Model, records: Sequence[Prepared], weights: Weighting, iterations: int) -> FitResult:
    keys = [u.key for u in model.unknowns]

    def residual(point: np.ndarray) -> np.ndarray:
        values = {**model.values, **dict(zip(keys, point.tolist(), strict=True))}
        return weighted_residual(model, records, weights, values)

    return least_squares(residual, model.unknowns, iterations=iterations)


def ranking_error(residual: np.ndarray) -> float:
    """Error by which models are ranked: root mean Huber square of a residual in deviations."""
    return float(np.sqrt(np.mean(huber_square(residual)))) if residual.size else float("nan")
