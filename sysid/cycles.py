"""Scatter from cycle to cycle of a motion that repeats."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sysid.records import Record

SAME = 2e-3
"""Mean squared change of the input from one cycle to the next, over twice its variance, below which it repeats."""
_IMPOSED = ("position", "velocity", "pull_position", "voltage_1", "voltage_2", "voltage_3")


@dataclass(frozen=True)
class CycleScatter:
    """Scatter from cycle to cycle.

    Args:
        scatter: standard deviation of one cycle about its neighbours, in the channel's unit.
        period: s.
        cycles: how many were compared.
    """

    scatter: float
    period: float
    cycles: int


def cycle_scatter(record: Record, channel: str) -> CycleScatter | None:
    """Scatter of `channel` between neighbouring cycles, where what is imposed on the rig repeats at least three times.

    Neighbours are compared, so that slow drift counts for little; 3 % of the samples, those beside jumps, are left out.

    Returns:
        None where nothing imposed repeats, or load or temperature change from cycle to cycle.
    """
    if not record.uniform:
        return None
    imposed = _imposed(record, channel)
    if imposed is None:
        return None
    lag = repeat_lag(imposed)
    if lag is None:
        return None
    values = record.channels[channel]
    change = values[lag:] - values[:-lag]
    change = np.abs(change[~np.isnan(change)])
    if change.size < 100:
        return None
    kept = np.sort(change)[: int(0.97 * change.size)]
    # Pure noise cut at its 97 % keeps 0.90 of its standard deviation.
    scatter = float(np.sqrt(np.mean(kept**2)) / 0.9005 / np.sqrt(2.0))
    return CycleScatter(scatter, lag * record.step, values.size // lag)


def _imposed(record: Record, channel: str) -> np.ndarray | None:
    """The channel that tells the cycle: an imposed one, not the one whose noise is asked for."""
    order = ("pull_position", "voltage_1", "voltage_2") if channel != "friction_force" else ("position", "velocity")
    for name in order:
        values = record.channels.get(name)
        if values is not None and name != channel and not np.isnan(values).any() and np.ptp(values) > 0.0:
            return values
    return None


def repeat_lag(imposed: np.ndarray) -> int | None:
    """Number of rows after which `imposed` (n,) repeats; none where it does not, or fewer than three times."""
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
    first = int(fits[0])
    # The best lag of the first dip.
    end = first
    while end + 1 < limit and share[end + 1] < SAME:
        end += 1
    return first + int(np.argmin(share[first : end + 1]))
