"""A first-order lag of a signal that goes in steps, as converters and digital filters have it."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter


def lag_of_steps(signal: np.ndarray, step: float, time_constant: float, early: float) -> np.ndarray:
    """Response at each row (n,) of y' = (u - y)/T, where u goes to a row's value `early` steps before that row.

        y_k = d y_(k-1) + (e - d) u_(k-1) + (1 - e) u_k,   d = exp(-step/T), e = exp(-early step/T)

    Exact for such an input; y(0) = u(0). With `early` = 0 the input is held from each row to the next, with 1 it is the
    usual digital low-pass y_k = y_(k-1) + (1 - d) (u_k - y_(k-1)).

    Args:
        signal: u, (n,).
        step: between rows, s.
        time_constant: T, s.
        early: part of a step, 0 to 1.
    """
    time_constant = max(time_constant, 1e-6 * step)
    decay, kept = np.exp(-step / time_constant), np.exp(-early * step / time_constant)
    taps = np.array([1.0 - kept, kept - decay])
    # The state of a filter that has stood at the first value all along.
    rest = np.array([decay * signal[0] + taps[1] * signal[0]])
    return lfilter(taps, [1.0, -decay], signal, zi=rest)[0]
