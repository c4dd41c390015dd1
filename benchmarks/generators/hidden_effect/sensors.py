"""What a sensor does to a channel before its noise: lag, delay, drift, a bent scale; and after it: rounding."""

from typing import NamedTuple

import numpy as np

from .tip import delayed, lagged


class SensorTruth(NamedTuple):
    """Times in s; `drift` and `step` in the channel's own unit scale `span`, `bend` a pure number; zero is off."""

    lag: float = 0.0
    delay: float = 0.0
    drift: float = 0.0
    drift_power: float = 1.0
    bend: float = 0.0
    lean: float = 0.0
    step: float = 0.0


def sense(signal: np.ndarray, p: SensorTruth, span: float) -> np.ndarray:
    """The channel as its sensor tells it, noise-free and not yet rounded; `span` is its range in its own unit."""
    out = signal
    if p.delay > 0.0:
        out = delayed(out, p.delay)
    if p.lag > 0.0:
        out = lagged(out, p.lag)
    if p.bend != 0.0:
        a = np.sqrt(3.0 * abs(p.bend))
        out = span * np.tanh(a * out / span) / a + p.lean * p.bend * out * out / span
    if p.drift != 0.0:
        t = np.arange(out.size) / out.size
        out = out + p.drift * span * t**p.drift_power
    return out


def rounded(signal: np.ndarray, step: float) -> np.ndarray:
    """Rounded to whole steps, as a counter or converter does."""
    return step * np.round(signal / step) if step > 0.0 else signal


def same_on(signal: np.ndarray, p: SensorTruth) -> np.ndarray:
    """A companion signal (velocity, acceleration) after the same lag and delay."""
    return sense(signal, p._replace(bend=0.0, drift=0.0), 1.0) if (p.lag > 0.0 or p.delay > 0.0) else signal
