"""Search for lower local minima of the cost of a driven stage.

Slips, lift-offs and hysteresis give the cost of a driven stage many narrow local minima. A fit ends in the one near its
start, where the friction limit of the contact may be wrong by a factor. Two methods find lower minima:

- multistart: each value in turn is moved away from its fitted one, and the fit continues from there;
- synchronisation (nudging): during the fit the simulated position is corrected by a fraction of its deviation from the
  measured one after every row. An error then decays within some rows, and the cost has few, widely separated minima
  (Abarbanel, Creveling, Farsian and Kostuk, SIAM J. Applied Dynamical Systems 8 (2009) 1341). The correction feeds the
  noise of the measured motion into the simulation, so the result is a starting point, not an estimate.

The simulation takes as long as the record; long records are truncated during the search.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber
from sysid.estimation.misfit import ResidualWeights
from sysid.prediction.friction_drive.parameters import CONTACT_STIFFNESS
from sysid.prediction.friction_drive.record import TRANSVERSE, FrictionDriveRecord, leading_segment
from sysid.prediction.model import Model
from sysid.prediction.prepared_record import PreparedRecord

TRUNCATED_ROWS = 3000
"""Largest number of rows of each record that are kept."""

NUDGING_GAIN = 0.3
"""Fraction of the deviation from the measured position that is corrected per row: an error is halved in two rows."""

SYNCHRONISED_STEPS = 15
"""Steps of a synchronisation fit."""

FACTORS = (0.6, 1.6)
"""Factors by which a value is moved."""
SHORT_STEPS = 6
"""Steps of the fit from a moved value, before it is compared."""
STIFFNESS, DAMPING = "rig.contact_stiffness", "rig.contact_damping"
ROUNDS = 3
"""Largest number of rounds over all values."""
LOWER = 0.98
"""Ratio of costs below which another local minimum counts as lower."""
AT_THE_NOISE = 1.03
"""Root mean Huber loss at which the search ends."""


def _along_one_axis(records: Sequence[PreparedRecord]) -> list[FrictionDriveRecord]:
    """The records, if all are of stages driven along one axis; otherwise an empty result."""
    driven = [r for r in records if isinstance(r, FrictionDriveRecord) and TRANSVERSE not in r.measured]
    return driven if len(driven) == len(records) else []


def truncated(
    fitted: FittedModel, records: Sequence[PreparedRecord], rows: int = TRUNCATED_ROWS
) -> tuple[FittedModel, list[PreparedRecord]]:
    """A fit and its records truncated to their first rows, if they are long and of a stage driven along one axis."""
    driven = _along_one_axis(records)
    if all(record.size <= rows for record in driven):
        return fitted, list(records)
    weights = fitted.weights
    kept = [{channel: index < rows for channel, index in samples.items()} for samples in weights.samples]
    mask = np.concatenate([of_channel for of_record in kept for of_channel in of_record.values()])
    short = ResidualWeights(
        tuple({c: values[:rows] for c, values in std.items()} for std in weights.std),
        tuple({c: s[k[c]] for c, s in samples.items()} for samples, k in zip(weights.samples, kept, strict=True)),
    )
    fit = fitted.fit
    fit = replace(fit, residual=fit.residual[mask], jacobian=fit.jacobian[mask], weights=fit.weights[mask])
    return FittedModel(fitted.model, fit, short), [leading_segment(record, rows) for record in driven]


def synchronised_starts(
    starts: Sequence[Model],
    records: Sequence[PreparedRecord],
    weights: ResidualWeights | None,
    steps: int,
    count: int = 1,
) -> list[Model]:
    """Results of synchronisation fits from several starts, lowest cost first.

    Empty if some record is not of a stage driven along one axis, or if the model has presliding, whose displacement
    depends on the simulated motion and is not corrected.
    """
    synchronised = [replace(record, nudging_gain=NUDGING_GAIN) for record in _along_one_axis(records)]
    presliding = starts and any(e.has_presliding for e in starts[0].effects)
    if not synchronised or not starts or presliding:
        return []
    fits = [fit_model(start, synchronised, weights, steps) for start in starts]
    return [fitted.model for fitted in sorted(fits, key=lambda f: f.fit.cost)[:count]]


def lowest_minimum(fitted: FittedModel, records: Sequence[PreparedRecord], rounds: int = ROUNDS) -> FittedModel:
    """The fit, or one from another start that ended at a lower cost; unchanged if no stage is driven."""
    if not any(isinstance(record, FrictionDriveRecord) for record in records):
        return fitted
    short, beginnings = truncated(fitted, records)
    if short is fitted:
        return _multistart(fitted, records, rounds)
    near = _multistart(fit_model(short.model, beginnings, short.weights, SHORT_STEPS), beginnings, rounds)
    whole = fit_model(near.model, records, fitted.weights)
    return whole if whole.fit.cost < LOWER * fitted.fit.cost else fitted


def _multistart(fitted: FittedModel, records: Sequence[PreparedRecord], rounds: int) -> FittedModel:
    best = fitted
    for _ in range(rounds):
        before = best
        starts = [best.model, *_other_stiffnesses(best.model)]
        synchronised = synchronised_starts(starts, records, best.weights, SYNCHRONISED_STEPS)
        fits = [fit_model(start, records, best.weights, SHORT_STEPS) for start in (*synchronised, *starts[1:])]
        best = min([best, *fits], key=lambda f: f.fit.cost)
        for key in [u.key for u in best.model.unknowns]:
            if root_mean_huber(best.fit.residual) <= AT_THE_NOISE:
                return best
            best = min([best, *_fits_beside(best, key, records)], key=lambda f: f.fit.cost)
        if best.fit.cost > LOWER * before.fit.cost:
            break
        best = fit_model(best.model, records, best.weights)
    return best


def _other_stiffnesses(model: Model) -> list[Model]:
    """The model with a softer, a stiffer, and the default contact; all forces are scaled by the same factor.

    The motion determines ratios of force to stiffness well, but the stiffness itself only through inertia.
    """
    unknowns = {u.key: u for u in model.unknowns}
    if STIFFNESS not in unknowns:
        return []
    values = model.values
    starts = []
    for factor in (*FACTORS, CONTACT_STIFFNESS / values[STIFFNESS]):
        moved = {key: factor * values[key] for key in unknowns if key == STIFFNESS or key.endswith(".force")}
        if DAMPING in unknowns:
            moved[DAMPING] = float(np.sqrt(factor)) * values[DAMPING]
        starts.append(model.at({key: min(max(v, unknowns[key].low), unknowns[key].high) for key, v in moved.items()}))
    return starts


def _fits_beside(fitted: FittedModel, key: str, records: Sequence[PreparedRecord]) -> list[FittedModel]:
    """Short fits from a smaller and a larger value."""
    unknown = next(u for u in fitted.model.unknowns if u.key == key)
    value = fitted.model.values[key]
    moved = [min(max(factor * value, unknown.low), unknown.high) for factor in FACTORS]
    starts = [fitted.model.at({key: other}) for other in moved if not np.isclose(other, value, rtol=0.05)]
    return [fit_model(start, records, fitted.weights, SHORT_STEPS) for start in starts]
