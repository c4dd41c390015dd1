"""Residual after subtracting its binned means over the coordinates of effects that are in the model (model-form error).

An added law is seldom exactly the true one, so its residual depends on its own coordinate. The means in bins of these
coordinates are subtracted before another effect is evaluated.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim.library.effect import Effect
from sysid.diagnosis.explained_share import cells_of, coordinates_of, edges_of, means_of
from sysid.estimation.misfit import ResidualWeights
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.force_balance.stick_phases import STICK_DISPLACEMENT
from sysid.prediction.model import PreparedRecord

OWN = ("time", "position", "distance_travelled", "temperature", "normal_load")
"""Coordinates over which the residual of an inexact law is attributed to its own effect."""

BINS = 24
PASSES = 2


def own_coordinates(effects: Sequence[Effect]) -> tuple[str, ...]:
    """Coordinates of effects, each once, over which the residual is attributed to them."""
    return tuple(dict.fromkeys(name for effect in effects for name in effect.coordinates if name in OWN))


def apart_from(
    residual: np.ndarray, records: Sequence[PreparedRecord], weights: ResidualWeights, coordinates: Sequence[str]
) -> np.ndarray:
    """A residual (n,) in deviations, less its mean in bins of each coordinate, separately by direction of motion."""
    out = residual.copy()
    start = 0
    for record, samples in zip(records, weights.samples, strict=True):
        known = coordinates_of(record)
        for channel, pick in samples.items():
            part = out[start : start + pick.size]
            start += pick.size
            if channel == STICK_DISPLACEMENT or pick.size == 0:
                continue
            direction = record.axis.direction[pick] if isinstance(record, ForceBalanceRecord) else np.ones(pick.size)
            for _ in range(PASSES):
                for name in coordinates:
                    values = known[name][pick] if name in known else None
                    if values is None:
                        continue
                    cells = cells_of(values, direction, edges_of(values, name, BINS))
                    # Clipped, so that a few large samples do not determine a mean.
                    part -= means_of(cells, np.clip(part, -8.0, 8.0), int(cells.max()) + 1)[cells]
    return out
