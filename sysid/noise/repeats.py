"""Scatter from cycle to cycle of a periodic motion, and the step of a quantised channel."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sysid.experiment.record import Record
from sysid.signals import trimmed_rms

SAME = 2e-3
"""Mean squared change of the input from cycle to cycle, over twice its variance, below which it is periodic."""


@dataclass(frozen=True)
class CycleScatter:
    """Scatter from cycle to cycle."""

    scatter: float  # standard deviation of one cycle about its neighbours, in the channel's unit
    period: float  # s
    cycles: int  # number of cycles compared
    correlation: float  # of neighbouring samples of that scatter


def cycle_scatter(record: Record, channel: str) -> CycleScatter | None:
    """Scatter of `channel` between neighbouring cycles, where an imposed channel has at least three periods.

    Differences of neighbouring cycles suppress slow drift; the 3 % largest ones, at jumps, are left out.
    """
    imposed = _imposed(record, channel) if record.uniform else None
    lag = repeat_lag(imposed) if imposed is not None else None
    if lag is None:
        return None
    values = record.channels[channel]
    change = values[lag:] - values[:-lag]
    scatter = trimmed_rms(change[~np.isnan(change)]) / np.sqrt(2.0)
    if not scatter > 0.0 or not _load_repeats(record, values, scatter, lag):
        return None
    # No samples are left out here: the jumps contain the fast changes.
    whole = float(np.nanmean(change**2))
    correlation = float(np.clip(1.0 - 0.5 * np.nanmean(np.diff(change) ** 2) / whole, 0.0, 0.999))
    return CycleScatter(scatter, lag * record.step, values.size // lag, correlation)


def _load_repeats(record: Record, values: np.ndarray, scatter: float, lag: int) -> bool:
    """Whether the load changes so little from cycle to cycle that it does not cause the scatter."""
    load = record.channels.get("normal_load")
    if load is None or not np.nanmean(np.abs(load)) > 0.0:
        return True
    difference = load[lag:] - load[:-lag]
    change = trimmed_rms(difference[~np.isnan(difference)]) / np.sqrt(2.0) / float(np.nanmean(np.abs(load)))
    return change * float(np.sqrt(np.nanmean(values**2))) < 0.5 * scatter


def _imposed(record: Record, channel: str) -> np.ndarray | None:
    """The channel whose period is the cycle: an imposed one, other than `channel`."""
    order = ("pull_position", "voltage_1", "voltage_2") if channel != "friction_force" else ("position", "velocity")
    for name in order:
        values = record.channels.get(name)
        if values is not None and name != channel and not np.isnan(values).any() and np.ptp(values) > 0.0:
            return values
    return None


def repeat_lag(imposed: np.ndarray) -> int | None:
    """Period of `imposed` (n,) in rows; None if it is not periodic, or has fewer than three periods."""
    n = imposed.size
    centred = imposed - imposed.mean()
    variance = float(np.mean(centred**2))
    if variance == 0.0 or n < 60:
        return None
    spectrum = np.fft.rfft(centred, 2 * n)
    products = np.fft.irfft(np.abs(spectrum) ** 2)[:n]
    squares = np.concatenate([[0.0], np.cumsum(centred**2)])
    lags = np.arange(n)
    # sum (x[t + lag] - x[t])^2 over the overlap, from the products and the squares of both ends.
    change = (squares[n] - squares[lags]) + squares[n - lags] - 2.0 * products
    share = change / (2.0 * variance * (n - lags))
    limit = n // 3
    beyond = np.flatnonzero(share[:limit] > 0.5)
    if not beyond.size:
        return None
    start = int(beyond[0])
    fits = start + np.flatnonzero(share[start:limit] < SAME)
    if not fits.size:
        return None
    # The lag of the first minimum.
    first = int(fits[0])
    count = int(np.argmin(np.append(share[first:limit] < SAME, False)))
    return first + int(np.argmin(share[first : first + count]))


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
