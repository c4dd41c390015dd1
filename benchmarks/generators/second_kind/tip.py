"""Two piezos under a tip: voltages to extensions to tip position, with relays, creep, lag and unequal gains.

tip_x = -h (d2 - d1) / D, tip_y = (d1 + d2) / 2, d_i = gain (u_i - bias), u_i the voltage that acts on piezo i.
"""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.signal import lfilter

from .machines import Machine

Signal = Callable[[np.ndarray, float], np.ndarray]
"""What becomes of a signal (rows,) with its time step."""


def tip(m: Machine, volts: np.ndarray) -> np.ndarray:
    """tip_x and tip_y (2, rows) in m of acting voltages (2, rows)."""
    d = m.gain * (volts - m.bias)
    return np.array([-m.height * (d[1] - d[0]) / m.spacing, 0.5 * (d[0] + d[1])])


def relays(count: int, low: float, high: float, weight: float) -> Signal:
    """Preisach relays (+-1) on a triangle of switching voltages; their mean, times `weight`, is added to the voltage.

    Narrow relays weigh more: density exp(-width / (0.35 range)).
    """
    levels = np.linspace(low, high, count)
    up, down = (a.ravel() for a in np.meshgrid(levels, levels, indexing="ij"))
    keep = up > down
    up, down = up[keep], down[keep]
    density = np.exp(-(up - down) / (0.35 * (high - low)))
    density *= weight / density.sum()

    def run(u: np.ndarray, _: float) -> np.ndarray:
        state = np.where(0.5 * (up + down) < u[0], 1.0, -1.0)
        out = np.empty_like(u)
        for k, value in enumerate(u):
            state[up <= value] = 1.0
            state[down >= value] = -1.0
            out[k] = density @ state
        return u + out

    return run


def creep(weights: Sequence[float] | np.ndarray, times: Sequence[float] | np.ndarray) -> Signal:
    """Voigt elements in series: u + sum of weight times (1 + s time)^-1 (u - u[0]), each settled at the first row."""

    def run(u: np.ndarray, dt: float) -> np.ndarray:
        out = u.copy()
        for weight, time in zip(weights, times, strict=True):
            decay = np.exp(-dt / time)
            out += weight * np.asarray(lfilter([0.0, 1.0 - decay], [1.0, -decay], u - u[0]))
        return out

    return run


def second_order(time: float, damping: float) -> Signal:
    """A second-order low-pass of unit gain and slope delay `time`: w = 2 damping / time, settled at the first row."""

    def run(u: np.ndarray, dt: float) -> np.ndarray:
        parts = max(1, int(np.ceil(12.0 * dt * damping / time)))
        fine = np.interp(np.arange((u.size - 1) * parts + 1) / parts, np.arange(u.size), u) if parts > 1 else u
        w = 2.0 * damping / time * dt / parts
        # Bilinear transform: s becomes 2 (1 - z^-1) / (1 + z^-1) per step.
        a = np.array([4.0 + 4.0 * damping * w + w * w, 2.0 * w * w - 8.0, 4.0 - 4.0 * damping * w + w * w])
        b = w * w * np.array([1.0, 2.0, 1.0])
        return u[0] + np.asarray(lfilter(b, a, fine - u[0]))[::parts]

    return run


def delayed(time: float) -> Signal:
    """The signal `time` seconds late, by linear interpolation."""

    def run(u: np.ndarray, dt: float) -> np.ndarray:
        rows = np.arange(u.size)
        return np.interp(rows - time / dt, rows, u)

    return run
