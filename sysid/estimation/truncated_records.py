"""What first looks see of long records of a driven stage: their beginnings.

A prediction follows the stage from event to event, and takes as long as the record. Which of forty effects is worth
a full fit shows in a few seconds of motion; the fits that decide see all of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sysid.estimation.base_fit import Fitted
from sysid.estimation.misfit import Weighting
from sysid.prediction.friction_drive.record import ACROSS, FrictionDriveRecord, beginning
from sysid.prediction.model import Prepared

ROWS = 3000
"""Of each record, at the most."""


def looked_at(fitted: Fitted, records: Sequence[Prepared], rows: int = ROWS) -> tuple[Fitted, list[Prepared]]:
    """A fit and its records cut down to their beginnings, where they are long ones of a driven stage along one axis.

    Args:
        fitted: on the records.
        records: those fitted.
        rows: of each record that are kept, at the most.
    """
    driven = [r for r in records if isinstance(r, FrictionDriveRecord) and ACROSS not in r.measured]
    if len(driven) < len(records) or all(record.size <= rows for record in driven):
        return fitted, list(records)
    kept = [{channel: pick < rows for channel, pick in picks.items()} for picks in fitted.weights.picks]
    seen = np.concatenate([mask for masks in kept for mask in masks.values()])
    weights = Weighting(
        tuple({c: values[:rows] for c, values in deviations.items()} for deviations in fitted.weights.deviations),
        tuple(
            {c: pick[masks[c]] for c, pick in picks.items()}
            for picks, masks in zip(fitted.weights.picks, kept, strict=True)
        ),
    )
    fit = replace(
        fitted.fit, residual=fitted.fit.residual[seen], jacobian=fitted.fit.jacobian[seen],
        weights=fitted.fit.weights[seen],
    )  # fmt: skip
    return Fitted(fitted.model, fit, weights), [beginning(record, rows) for record in driven]
