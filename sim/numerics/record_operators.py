"""Operators with memory along a record, compiled once and cached on disk.

Imported only inside the laws that need them, since importing numba is slow.
"""

import math

import numpy as np

from sim.numerics.compilation import compiled
from sim.numerics.steps import age_step, play_step


def first_order_lag(signal: np.ndarray, step: float, time_constant: float) -> np.ndarray:
    """Response of y' = (u - y)/T to `signal` (n,), linear between samples (exact for such an input); y(0) = u(0)."""
    if time_constant <= 1e-6 * step:
        return np.array(signal)
    ratio = step / time_constant
    decay = math.exp(-ratio)
    # Exact update for an input that is linear over the step (first-order hold).
    ramp = (1.0 - decay) / ratio
    return _first_order(signal, decay, ramp - decay, 1.0 - ramp)


def first_order_lag_of_steps(signal: np.ndarray, step: float, time_constant: float, early: float) -> np.ndarray:
    """Response of y' = (u - y)/T to `signal` (n,), held, which changes to a row's value `early` steps before that row.

        y_k = d y_(k-1) + (e - d) u_(k-1) + (1 - e) u_k,   d = exp(-step/T), e = exp(-early step/T)

    Exact for such an input; y(0) = u(0). With `early` = 0 the input is held from each row to the next, with 1 it is the
    usual digital low-pass y_k = y_(k-1) + (1 - d) (u_k - y_(k-1)). Rows are `step` s apart, T is `time_constant`, s.
    """
    time_constant = max(time_constant, 1e-6 * step)
    decay, kept = math.exp(-step / time_constant), math.exp(-early * step / time_constant)
    return _first_order(signal, decay, kept - decay, 1.0 - kept)


@compiled
def _first_order(signal: np.ndarray, decay: float, before: float, now: float) -> np.ndarray:
    """Steps y_k = decay y_(k-1) + before u_(k-1) + now u_k, y_0 = u_0."""
    out = np.empty(signal.size)
    out[0] = signal[0]
    for i in range(1, signal.size):
        out[i] = decay * out[i - 1] + before * signal[i - 1] + now * signal[i]
    return out


def resonance(signal: np.ndarray, step: float, frequency: float, damping: float) -> np.ndarray:
    """Response of y'' + 2 d w y' + w^2 y = w^2 u, w = 2 pi frequency, exact for an input linear between samples.

    Started at rest on the first sample.
    """
    late = 2.0 * damping / (2.0 * math.pi * frequency)
    return _resonance(np.ascontiguousarray(signal), step, late, False, _transition(step, frequency, damping))


def resonance_of_steps(signal: np.ndarray, step: float, frequency: float, damping: float) -> np.ndarray:
    """`resonance` of an input that is held from each row to the next, as a converter holds a voltage."""
    return _resonance(np.ascontiguousarray(signal), step, 0.0, True, _transition(step, frequency, damping))


def _transition(step: float, frequency: float, damping: float) -> tuple[float, float, float, float]:
    """Transition matrix of (y, y') of a free resonance over one step, row by row."""
    w = 2.0 * math.pi * frequency
    wd = w * math.sqrt(1.0 - damping * damping)
    e = math.exp(-damping * w * step)
    c, s = math.cos(wd * step), math.sin(wd * step)
    return e * (c + damping * w / wd * s), e * s / wd, -e * w * w / wd * s, e * (c - damping * w / wd * s)


@compiled
def _resonance(
    signal: np.ndarray, step: float, late: float, held: bool, transition: tuple[float, float, float, float]
) -> np.ndarray:
    """Steps of (error, its rate) about the particular solution u - late * u', or about the value held."""
    a11, a12, a21, a22 = transition
    out = np.empty(signal.size)
    y, rate = signal[0], 0.0
    out[0] = y
    for i in range(1, signal.size):
        slope = 0.0 if held else (signal[i] - signal[i - 1]) / step
        lag = late * slope
        error = y - (signal[i - 1] - lag)
        error_rate = rate - slope
        y = signal[i - 1 if held else i] - lag + a11 * error + a12 * error_rate
        rate = slope + a21 * error + a22 * error_rate
        out[i] = y
    return out


@compiled
def play(signal: np.ndarray, half_width: float) -> np.ndarray:
    """Play (backlash) operator: the output is constant while the input is within `half_width` of it."""
    out = np.empty(signal.size)
    y = signal[0]
    for i in range(signal.size):
        y = play_step(y, signal[i], half_width)
        out[i] = y
    return out


@compiled
def contact_age(time: np.ndarray, position: np.ndarray, memory_length: float) -> np.ndarray:
    """Mean age of the contacts by the ageing law, age' = 1 - |v| age / L (Dieterich 1979, Ruina 1983), exact a step."""
    out = np.zeros(time.size)
    for i in range(1, time.size):
        out[i] = age_step(out[i - 1], abs(position[i] - position[i - 1]), time[i] - time[i - 1], memory_length)
    return out


@compiled
def ageing_strength(
    time: np.ndarray, gone: np.ndarray, rested: np.ndarray, cut_off: float, memory_length: float
) -> np.ndarray:
    """Strength ln(1 + time at rest/cut_off) of a contact (n,), which decays to 1/e over the distance slid
    `memory_length`; `gone`: distance slid, m; `rested`: above zero where the body rests."""
    out = np.empty(time.size)
    age = 0.0
    out[0] = 0.0
    for i in range(1, time.size):
        if rested[i] > 0.0:
            age += time[i] - time[i - 1]
        elif age > 0.0:
            strength = np.log1p(age / cut_off) * np.exp(-(gone[i] - gone[i - 1]) / memory_length)
            age = cut_off * np.expm1(strength)
        out[i] = np.log1p(age / cut_off)
    return out


@compiled
def bouc_wen(signal: np.ndarray, width: float, turning: float) -> np.ndarray:
    """Bouc-Wen hysteresis h driven by `signal`: dh = du - (turning |du| h + (1 - turning) du |h|) / width.

    While loading dh = du (1 - |h|/width), while unloading dh = du (1 + (2 turning - 1) |h|/width); both are solved
    exactly where the signal is linear.
    """
    out = np.empty(signal.size)
    h = 0.0
    out[0] = 0.0
    back = (2.0 * turning - 1.0) / width
    for i in range(1, signal.size):
        du = signal[i] - signal[i - 1]
        side, path = (1.0 if du > 0.0 else -1.0), abs(du)
        down = -side * h
        if down > 0.0:
            # Unloading, at most to zero: the magnitude falls by 1 + back * magnitude per path.
            to_zero = np.log1p(back * down) / back if abs(back) > 1e-12 else down
            gone = min(path, to_zero)
            faded = np.exp(-back * gone)
            left = down * faded - ((1.0 - faded) / back if abs(back) > 1e-12 else gone)
            h = -side * max(left, 0.0)
            path -= gone
        if path > 0.0:
            h = side * (width + (side * h - width) * np.exp(-path / width))
        out[i] = h
    return out
