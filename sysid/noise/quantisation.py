"""The grid that a channel's values lie on, when a sensor or a log reports whole steps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

SHARPNESS = 0.995
"""Mean resultant of the values' phases on the grid: 1 on the grid, 0 when they lie anywhere; rounding costs little."""


def find_quantisation_step(arrays: Sequence[np.ndarray]) -> float | None:
    """Step of the grid that the values of a channel lie on.

    The step is estimated from the smallest changes between neighbours, then refined over ever wider ranges, since an
    error of one part in a thousand is a whole step after a thousand.

    Args:
        arrays: the channel in each record, shape (n,), gaps as NaN.

    Returns:
        The step in the channel's unit; none where the values lie on no grid.
    """
    values = np.concatenate([array[~np.isnan(array)] for array in arrays])
    if values.size < 20:
        return None
    changes = np.abs(np.concatenate([np.diff(array) for array in arrays]))
    changes = changes[changes > 1e-9 * np.max(np.abs(values), initial=0.0)]
    if changes.size < 10:
        return None
    # The smallest change that occurs more than a few times by itself is one step.
    small = np.sort(changes)
    step = float(np.median(small[: max(5, small.size // 1000)]))
    near = small[small < 1.5 * step]
    if near.size < 5 or small[0] < 0.5 * step:
        return None
    step = float(np.mean(near))
    if float(np.std(near)) > 0.05 * step:
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
            return step
        reach *= 4.0
