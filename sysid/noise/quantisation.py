"""Detection of the quantisation step of a channel."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

SHARPNESS = 0.995
"""Least mean resultant length of the values' phases on the grid: 1 for exact multiples, 0 for uniform phases."""

PULSES = 0.99
"""Share of rows one step from the last from which the rows are taken as logged at pulses."""

LEAST_LEVELS = 8
"""Least number of occupied levels of a quantised channel, since a signal without noise may have few values itself."""

LEAST_NOISY_LEVELS = 2
"""The same for a sensor whose stated noise would change its values from row to row."""


def find_quantisation_step(arrays: Sequence[np.ndarray], least_levels: int = LEAST_LEVELS) -> float | None:
    """Quantisation step of the values of a channel.

    The step is estimated from the smallest changes between neighbours, then refined over increasing ranges of values,
    since a relative error of 1/1000 amounts to a full step after 1000 steps.
    """
    values = np.concatenate([array[~np.isnan(array)] for array in arrays])
    if values.size < 20:
        return None
    every = np.abs(np.concatenate([np.diff(array) for array in arrays]))
    changes = every[every > 1e-9 * np.max(np.abs(values), initial=0.0)]
    if changes.size < 5:
        return None
    # The smallest change that occurs repeatedly is one step.
    small = np.sort(changes)
    step = float(np.median(small[: max(5, small.size // 1000)]))
    near = small[small < 1.5 * step]
    if near.size < 5 or small[0] < 0.5 * step:
        return None
    step = float(np.mean(near))
    if float(np.std(near)) > 0.05 * step or near.size > PULSES * np.count_nonzero(~np.isnan(every)):
        return None
    offset = values - values[0]
    reach = 4.0 * step
    widest = float(np.max(np.abs(offset)))
    while True:
        inside = offset[np.abs(offset) <= reach]
        counts = np.round(inside / step)
        if counts.any():
            step = float(inside @ counts / (counts @ counts))
        if abs(np.mean(np.exp(2j * np.pi * inside / step))) < SHARPNESS:
            return None
        if reach >= widest:
            return step if np.unique(np.round(offset / step)).size >= least_levels else None
        reach *= 4.0
