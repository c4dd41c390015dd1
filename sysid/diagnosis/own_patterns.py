"""What a model leaves apart from the patterns of its own effects: an added law is seldom quite the true one."""

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
"""Coordinates along which an added law that is not quite the true one leaves a pattern that is clearly its own."""

BINS = 24
PASSES = 2


def own_coordinates(effects: Sequence[Effect]) -> tuple[str, ...]:
    """Coordinates of effects, each once, along which what their laws leave is theirs."""
    return tuple(dict.fromkeys(name for effect in effects for name in effect.coordinates if name in OWN))


def apart_from(
    residual: np.ndarray, records: Sequence[PreparedRecord], weights: ResidualWeights, coordinates: Sequence[str]
) -> np.ndarray:
    """A residual (n,) in deviations, less its mean in bins of each coordinate, apart for the directions of motion."""
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
                    # A few large samples are no pattern.
                    part -= means_of(cells, np.clip(part, -8.0, 8.0), int(cells.max()) + 1)[cells]
    return out
