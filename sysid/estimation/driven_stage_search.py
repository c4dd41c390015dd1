"""What first looks see of long records of a driven stage: their beginnings.

A prediction follows the stage from event to event, and takes as long as the record. Which of forty effects is worth
a full fit shows in a few seconds of motion; the fits that decide see all of it.

Fits of a driven stage that is held to its measured motion: after every row it is brought part of the way there.

A stage that is on its own slips a row too early, rings the other way, and is wrong from there on: errors that grow make
the cost a landscape of narrow valleys. Held, it forgets within some rows, and what every row shows is what the row
before it led to; the cost has few valleys, and those far apart (Abarbanel, Creveling, Farsian and Kostuk, SIAM J.
Applied Dynamical Systems 8 (2009) 1341: synchronisation). What it finds is no estimate (the noise of the measured
motion goes through the stage) but it is where a fit may begin.

Fits of a friction drive that ended in a side valley: each number is moved away in turn, and the fit goes on there.

Slips, lift-offs and loops of hysteresis make the error of a driven stage a landscape of narrow valleys. A fit ends in
the one it began in, though what a contact holds may be off by a factor and the rest be bent to make up for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber
from sysid.estimation.misfit import ResidualWeights
from sysid.prediction.friction_drive.parameters import CONTACT_STIFFNESS
from sysid.prediction.friction_drive.record import TRANSVERSE, FrictionDriveRecord, leading_segment
from sysid.prediction.model import Model, PreparedRecord

ROWS = 3000
"""Of each record, at the most."""


def truncated(
    fitted: FittedModel, records: Sequence[PreparedRecord], rows: int = ROWS
) -> tuple[FittedModel, list[PreparedRecord]]:
    """A fit and its records cut down to their beginnings, where they are long ones of a driven stage along one axis.

    Args:
        fitted: on the records.
        records: those fitted.
        rows: of each record that are kept, at the most.
    """
    driven = [r for r in records if isinstance(r, FrictionDriveRecord) and TRANSVERSE not in r.measured]
    if len(driven) < len(records) or all(record.size <= rows for record in driven):
        return fitted, list(records)
    kept = [{channel: pick < rows for channel, pick in samples.items()} for samples in fitted.weights.samples]
    seen = np.concatenate([mask for masks in kept for mask in masks.values()])
    weights = ResidualWeights(
        tuple({c: values[:rows] for c, values in deviations.items()} for deviations in fitted.weights.deviations),
        tuple(
            {c: pick[masks[c]] for c, pick in samples.items()}
            for samples, masks in zip(fitted.weights.samples, kept, strict=True)
        ),
    )
    fit = replace(
        fitted.fit, residual=fitted.fit.residual[seen], jacobian=fitted.fit.jacobian[seen],
        weights=fitted.fit.weights[seen],
    )  # fmt: skip
    return FittedModel(fitted.model, fit, weights), [leading_segment(record, rows) for record in driven]


HELD_TO = 0.3
"""Part of the way to the measured place, in a row: half of an error is gone after two."""


def held(records: Sequence[PreparedRecord]) -> list[PreparedRecord]:
    """The records with their stages held to the measured motion; none where some are not driven along one axis."""
    driven = [r for r in records if isinstance(r, FrictionDriveRecord) and TRANSVERSE not in r.measured]
    return [replace(r, nudging_gain=HELD_TO) for r in driven] if len(driven) == len(records) else []


def synchronised_starts(
    starts: Sequence[Model],
    records: Sequence[PreparedRecord],
    weights: ResidualWeights | None,
    steps: int,
    count: int = 1,
) -> list[Model]:
    """The starts that come nearest once fitted held, best first; none where nothing can be held, nor
    where bristles give way before they slip: their stretch follows the stage's own motion.

    Args:
        starts: of one model.
        records: those fitted, on their own.
        weights: of the fit that follows.
        steps: of each fit.
        count: of the models returned, at the most.
    """
    tied = held(records)
    if (
        not tied
        or not starts
        or any(e.friction_state is not None and e.friction_state.name != "coulomb" for e in starts[0].effects)
    ):
        return []
    fits = [fit_model(start, tied, weights, steps) for start in starts]
    return [fitted.model for fitted in sorted(fits, key=lambda f: f.fit.cost)[:count]]


AWAY = (0.6, 1.6)
"""Factors by which a number is moved."""
TRIED = 6
"""Steps of a fit from there, before it is judged."""
STIFFNESS, DAMPING = "rig.contact_stiffness", "rig.contact_damping"
HELD = 15
"""Steps of a fit held to the measured motion, which leads there."""
ROUNDS = 3
"""At the most, over all numbers."""
LOWER = 0.98
"""Part of the cost from which another valley is lower."""
AT_THE_NOISE = 1.03
"""Ranking error, in deviations, that leaves nothing to look for."""


def lowest_minimum(fitted: FittedModel, records: Sequence[PreparedRecord], rounds: int = ROUNDS) -> FittedModel:
    """The fit, or one that began with some number elsewhere and ended lower; as it is where nothing is driven.

    Of long records the beginnings are searched.

    Args:
        fitted: with its weights, which are kept.
        records: those fitted.
        rounds: over all numbers, at the most.
    """
    if not any(isinstance(record, FrictionDriveRecord) for record in records):
        return fitted
    seen, beginnings = truncated(fitted, records)
    if seen is fitted:
        return _lowest(fitted, records, rounds)
    near = _lowest(fit_model(seen.model, beginnings, seen.weights, TRIED), beginnings, rounds)
    whole = fit_model(near.model, records, fitted.weights)
    return whole if whole.fit.cost < LOWER * fitted.fit.cost else fitted


def _lowest(fitted: FittedModel, records: Sequence[PreparedRecord], rounds: int) -> FittedModel:
    best = fitted
    for _ in range(rounds):
        before = best
        starts = [best.model, *_stiffer(best.model)]
        held = synchronised_starts(starts, records, best.weights, HELD)
        fits = [fit_model(start, records, best.weights, TRIED) for start in (*held, *starts[1:])]
        best = min([best, *fits], key=lambda f: f.fit.cost)
        for key in [u.key for u in best.model.unknowns]:
            if root_mean_huber(best.fit.residual) <= AT_THE_NOISE:
                return best
            best = min([best, *_beside(best, key, records)], key=lambda f: f.fit.cost)
        if best.fit.cost > LOWER * before.fit.cost:
            break
        best = fit_model(best.model, records, best.weights)
    return best


def _stiffer(model: Model) -> list[Model]:
    """The model with a softer contact, a stiffer one, and one as any fit begins with, all forces in proportion.

    Motion alone tells forces over stiffness well, the stiffness itself by inertia only.
    """
    unknowns = {u.key: u for u in model.unknowns}
    if STIFFNESS not in unknowns:
        return []
    values = model.values
    starts = []
    for part in (*AWAY, CONTACT_STIFFNESS / values[STIFFNESS]):
        moved = {key: part * values[key] for key in unknowns if key == STIFFNESS or key.endswith(".force")}
        if DAMPING in unknowns:
            moved[DAMPING] = float(np.sqrt(part)) * values[DAMPING]
        starts.append(model.at({key: min(max(v, unknowns[key].low), unknowns[key].high) for key, v in moved.items()}))
    return starts


def _beside(fitted: FittedModel, key: str, records: Sequence[PreparedRecord]) -> list[FittedModel]:
    """Short fits from either side of a number."""
    unknown = next(u for u in fitted.model.unknowns if u.key == key)
    value = fitted.model.values[key]
    moved = [min(max(part * value, unknown.low), unknown.high) for part in AWAY]
    starts = [fitted.model.at({key: other}) for other in moved if not np.isclose(other, value, rtol=0.05)]
    return [fit_model(start, records, fitted.weights, TRIED) for start in starts]
