"""Systematic errors of the comparison of an axis, which do not appear in the scatter of the residuals.

Filtering: the motion is filtered before a force law is evaluated along it, which smooths a nonlinear law (a narrow
Stribeck curve, a short pitch). The error is taken as the change of the prediction at half the filter width.

Skew: the channels of a row are assumed to be simultaneous, which is accurate to a few hundredths of a sampling step.

Each is a change (n,) of the weighted residual by one standard deviation; it shifts the fitted values linearly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sysid.estimation.fit import FittedModel
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import predict
from sysid.prediction.prepared_record import PreparedRecord

CHANNEL_SKEW = 0.06
"""Inter-channel skew: standard deviation of the sampling time of a channel in its row, in sampling steps (assumed)."""


def systematic_errors(fitted: FittedModel, records: Sequence[PreparedRecord]) -> list[np.ndarray]:
    """Changes (n,) of the weighted residual, each by one standard deviation of a systematic error.

    The order of samples is that of `sysid.estimation.misfit.weighted_residual`. Empty for an actuator tip: its voltages
    are not filtered, and its channels change little within a step.
    """
    if not any(isinstance(record, ForceBalanceRecord) for record in records):
        return []
    effects, values = fitted.model.effects, fitted.model.values
    channels = list(records[0].measured)
    skewed: dict[str, list[np.ndarray]] = {channel: [] for channel in channels}
    filtered: list[np.ndarray] = []
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
            filtered.append((finer[channel] - predicted[channel])[pick] / scales[channel])
    changes = [np.concatenate(parts) for parts in (*skewed.values(), filtered)]
    return [change for change in changes if np.isfinite(change).all() and change.any()]
