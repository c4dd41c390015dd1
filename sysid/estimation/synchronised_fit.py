"""Fits of a driven stage that is held to its measured motion: after every row it is brought part of the way there.

A stage that is on its own slips a row too early, rings the other way, and is wrong from there on: errors that grow make
the cost a landscape of narrow valleys. Held, it forgets within some rows, and what every row shows is what the row
before it led to; the cost has few valleys, and those far apart (Abarbanel, Creveling, Farsian and Kostuk, SIAM J.
Applied Dynamical Systems 8 (2009) 1341: synchronisation). What it finds is no estimate (the noise of the measured
motion goes through the stage) but it is where a fit may begin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from sysid.estimation.base_fit import fit_model
from sysid.estimation.misfit import Weighting
from sysid.prediction.friction_drive.record import ACROSS, FrictionDriveRecord
from sysid.prediction.model import Model, Prepared

HELD_TO = 0.3
"""Part of the way to the measured place, in a row: half of an error is gone after two."""


def held(records: Sequence[Prepared]) -> list[Prepared]:
    """The records with their stages held to the measured motion; none where some are not driven along one axis."""
    driven = [r for r in records if isinstance(r, FrictionDriveRecord) and ACROSS not in r.measured]
    return [replace(r, held_to=HELD_TO) for r in driven] if len(driven) == len(records) else []


def led(
    starts: Sequence[Model], records: Sequence[Prepared], weights: Weighting | None, steps: int, count: int = 1
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
    if not tied or not starts or any(e.core is not None and e.core.name != "coulomb" for e in starts[0].effects):
        return []
    fits = [fit_model(start, tied, weights, steps) for start in starts]
    return [fitted.model for fitted in sorted(fits, key=lambda f: f.fit.cost)[:count]]
