"""What a comparison may be wrong by in the same way throughout, which no scatter of residuals shows.

Two things that a record of an axis is not told to better:

- which part of the motion's filter a law should see. The motion is filtered before a law is evaluated along it, and a
  law is not linear: a narrow Stribeck curve or a short pitch comes out a little blunter. The prediction from a motion
  filtered half as much shows by how much.
- when each channel was sampled. The channels of a row are taken to be simultaneous; to a few hundredths of a step they
  are not.

Each is a change of the prediction (n,), and moves the fitted values by what the fit makes of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sysid.estimation.fit import FittedModel
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import PreparedRecord, predict

CHANNEL_SKEW = 0.06
"""Part of a step by which a channel may be sampled earlier or later than the others of its row (assumed)."""


def systematic_errors(fitted: FittedModel, records: Sequence[PreparedRecord]) -> list[np.ndarray]:
    """Changes (n,) of the weighted residual, each by one standard deviation of something that is not known better.

    The order of samples is that of `sysid.estimation.misfit.weighted_residual`. Empty for an actuator's tip, whose laws
    see its voltages as they are, and whose channels move slowly against a step.
    """
    if not any(isinstance(record, ForceBalanceRecord) for record in records):
        return []
    effects, values = fitted.model.effects, fitted.model.values
    channels = list(records[0].measured)
    skewed: dict[str, list[np.ndarray]] = {channel: [] for channel in channels}
    blunted: list[np.ndarray] = []
    for record, scales, samples in zip(records, fitted.weights.scored_std, fitted.weights.samples, strict=True):
        assert isinstance(record, ForceBalanceRecord)
        predicted = predict(record, effects, values)
        finer = predicted
        if record.half_width_variant is not None:
            axis, smooth = record.half_width_variant()
            finer = predict(replace(record, axis=axis, complementary_filter=smooth), effects, values)
        for channel, pick in samples.items():
            late = CHANNEL_SKEW * np.gradient(predicted[channel])[pick] / scales[channel]
            for other in channels:
                skewed[other].append(late if other == channel else np.zeros(pick.size))
            blunted.append((finer[channel] - predicted[channel])[pick] / scales[channel])
    changes = [np.concatenate(parts) for parts in (*skewed.values(), blunted)]
    return [change for change in changes if np.isfinite(change).all() and change.any()]
