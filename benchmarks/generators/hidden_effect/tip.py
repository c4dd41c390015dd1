"""A tip on two piezos: play operators, creep in exponentials, amplifier lag, unequal gains."""

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.signal import lfilter

from .axis import SAMPLE

SPACING, HEIGHT, BIAS = 46e-3, 20e-3, 50.0


class TipTruth(NamedTuple):
    """What the tip really does; zero switches a law off.

    `gain` m/V, `offset_x` and `offset_y` m, `drive_lag` and `drive_delay` s, the rest pure numbers (shares).
    """

    gain: float = 4.5e-8
    offset_x: float = 0.0
    offset_y: float = 0.0
    mismatch: float = 0.0
    hysteresis: float = 0.0
    creep: float = 0.0
    creep_time: float = 1.0
    drive_lag: float = 0.0
    drive_delay: float = 0.0
    flexible_share: float = 0.0
    flexible_frequency: float = 80.0
    flexible_damping: float = 0.04


@njit(cache=True)
def _play(u, radius):
    out = np.empty_like(u)
    state = 0.0
    for k in range(u.size):
        state = min(max(state, u[k] - radius), u[k] + radius)
        out[k] = state
    return out


@njit(cache=True)
def _resonance(u, w, damping, step):
    out = np.empty_like(u)
    y, speed = u[0], 0.0
    count = 40
    h = step / count
    for k in range(u.size):
        out[k] = y
        for _ in range(count):
            speed += h * (w * w * (u[k] - y) - 2.0 * damping * w * speed)
            y += h * speed
    return out


def lagged(signal: np.ndarray, time_constant: float) -> np.ndarray:
    """First-order lag from rest at the first value; the input is linear between samples."""
    a = np.exp(-SAMPLE / time_constant)
    c = (1.0 - a) * time_constant / SAMPLE
    out, _ = lfilter([1.0 - c, c - a], [1.0, -a], signal, zi=[c * signal[0]])
    return out


def delayed(signal: np.ndarray, delay: float) -> np.ndarray:
    """The signal `delay` seconds later, the first value before its beginning."""
    rows = np.arange(signal.size)
    return np.interp(rows - delay / SAMPLE, rows, signal)


def _stretch(u: np.ndarray, p: TipTruth) -> np.ndarray:
    """Stretch of one piezo (m) under the voltage `u` over bias (V)."""
    rate = u
    if p.drive_delay > 0.0:
        rate = delayed(rate, p.drive_delay)
    if p.drive_lag > 0.0:
        rate = lagged(rate, p.drive_lag)
    total = rate.copy()
    if p.hysteresis > 0.0:
        for radius, weight in zip((3.0, 8.0, 15.0, 26.0), (0.35, 0.3, 0.2, 0.15)):
            total += p.hysteresis * weight * _play(rate, radius)
    if p.creep > 0.0:
        for factor, weight in zip((0.25, 1.0, 5.0), (0.4, 0.35, 0.25)):
            total += p.creep * weight * lagged(rate, factor * p.creep_time)
    if p.flexible_share > 0.0:
        ringing = _resonance(total, 2.0 * np.pi * p.flexible_frequency, p.flexible_damping, SAMPLE)
        total += p.flexible_share * (ringing - total)
    return p.gain * total


def simulate_tip(first: np.ndarray, second: np.ndarray, p: TipTruth) -> tuple[np.ndarray, np.ndarray]:
    """Motion of the tip (m, m) under two voltages (V), one value per millisecond."""
    one = (1.0 - 0.5 * p.mismatch) * _stretch(first - BIAS, p)
    two = (1.0 + 0.5 * p.mismatch) * _stretch(second - BIAS, p)
    return p.offset_x - HEIGHT * (two - one) / SPACING, p.offset_y + 0.5 * (one + two)
