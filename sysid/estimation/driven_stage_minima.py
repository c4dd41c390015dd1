"""Fits of a friction drive that ended in a side valley: each number is moved away in turn, and the fit goes on there.

Slips, lift-offs and loops of hysteresis make the error of a driven stage a landscape of narrow valleys. A fit ends in
the one it began in, though what a contact holds may be off by a factor and the rest be bent to make up for it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sysid.estimation.base_fit import Fitted, fit_model, ranking_error
from sysid.estimation.synchronised_fit import led
from sysid.estimation.truncated_records import looked_at
from sysid.prediction.friction_drive.parameters import CONTACT_STIFFNESS
from sysid.prediction.friction_drive.record import FrictionDriveRecord
from sysid.prediction.model import Model, Prepared

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


def lowest_valley(fitted: Fitted, records: Sequence[Prepared], rounds: int = ROUNDS) -> Fitted:
    """The fit, or one that began with some number elsewhere and ended lower; as it is where nothing is driven.

    Of long records the beginnings are searched.

    Args:
        fitted: with its weights, which are kept.
        records: those fitted.
        rounds: over all numbers, at the most.
    """
    if not any(isinstance(record, FrictionDriveRecord) for record in records):
        return fitted
    seen, beginnings = looked_at(fitted, records)
    if seen is fitted:
        return _lowest(fitted, records, rounds)
    near = _lowest(fit_model(seen.model, beginnings, seen.weights, TRIED), beginnings, rounds)
    whole = fit_model(near.model, records, fitted.weights)
    return whole if whole.fit.cost < LOWER * fitted.fit.cost else fitted


def _lowest(fitted: Fitted, records: Sequence[Prepared], rounds: int) -> Fitted:
    best = fitted
    for _ in range(rounds):
        before = best
        starts = [best.model, *_stiffer(best.model)]
        held = led(starts, records, best.weights, HELD)
        fits = [fit_model(start, records, best.weights, TRIED) for start in (*held, *starts[1:])]
        best = min([best, *fits], key=lambda f: f.fit.cost)
        for key in [u.key for u in best.model.unknowns]:
            if ranking_error(best.fit.residual) <= AT_THE_NOISE:
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


def _beside(fitted: Fitted, key: str, records: Sequence[Prepared]) -> list[Fitted]:
    """Short fits from either side of a number."""
    unknown = next(u for u in fitted.model.unknowns if u.key == key)
    value = fitted.model.values[key]
    moved = [min(max(part * value, unknown.low), unknown.high) for part in AWAY]
    starts = [fitted.model.at({key: other}) for other in moved if not np.isclose(other, value, rtol=0.05)]
    return [fit_model(start, records, fitted.weights, TRIED) for start in starts]
