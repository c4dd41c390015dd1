"""Hum of the mains in a measured channel: sinusoids of 50 or 60 Hz and their harmonics, fitted and removed.

A line adds a period to the variance of differences against lag, which neither white noise nor an autoregression has
(`sysid/noise/autocorrelation.py`). In blocks of some seconds, over which the mains keep their phase, the values are
fitted by

    y(t) = m + sum over h of a_h cos(2 pi h f t) + b_h sin(2 pi h f t),   f = 50 or 60 Hz,

with aliases where h f is above Nyquist's frequency. A line is accepted if its power exceeds the spectrum beside it;
harmonics of a periodic motion form a comb, of which no line is larger than its neighbours.

Source: Thomson, Proc. IEEE 70 (1982) 1055 (lines in a coloured spectrum). Frequency of the mains: EN 50160, 1 % in
99.5 % of the time.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sysid.noise.autocorrelation import Series
from sysid.signals import BAND, GaussianFilter

MAINS = (50.0, 60.0)
"""Frequencies of public supply, Hz."""

HARMONICS = (1, 2, 3)
"""Harmonics fitted: the hum itself, that of rectifiers, and that of saturated transformers."""

BLOCK = 4.0
"""Length of a block, s: a drift of the mains by 0.05 Hz changes the phase by 0.2 periods."""

LEAST_PERIODS = 20
"""Periods of the mains that a record must last."""

ABOVE = 15.0
"""Standard deviations by which the power of a line is above the mean power beside it. The power of noise at a frequency
is distributed exponentially; the standard deviation of the mean of m blocks is 1/sqrt(m) of it."""

ABOVE_LARGEST = 3.0
"""Power of a line over the largest one beside it."""

BESIDE = 0.7
"""Frequencies beside a line that it is compared with, relative to its own: those of a motion whose third harmonic it
would be are among them."""

DEVIATION, DEVIATION_STEP = 0.2, 0.05
"""Largest deviation from the nominal frequency, and step of the search, Hz. Causes: the control of the grid, and the
error of the sample clock."""

COMPARED_AT_ONCE = 16
"""Largest number of frequencies on each side of a line that are computed before they are compared with it."""

MOST_RUNS = 4
"""Gaps per block up to which blocks are divided at them; their runs are as long as the longest in memory."""

EVEN = 1e-3
"""Deviation of the times of a block from even spacing, relative to a step, up to which they are taken as even: the
error of a phase is below 0.003 rad up to Nyquist's frequency."""

EXCITATIONS = ("drive_force", "pull_position", "voltage_1", "voltage_2", "voltage_3")
"""Channels that are imposed: a line in one of them may be a tone of the excitation."""


class WithoutHum(NamedTuple):
    """Values without their lines, and the variance of the lines."""

    series: Series
    variance: float


def without_hum(series: Series, channel: str = "") -> WithoutHum:
    """Remove the hum of the mains from a channel; those of `EXCITATIONS` are not changed."""
    lines = [] if channel in EXCITATIONS else hum_frequencies(series)
    if not lines:
        return WithoutHum(series, 0.0)
    known = np.flatnonzero(np.isfinite(series.values))
    values, removed = series.values.copy(), 0.0
    for rows in _blocks(series, known):
        if rows.size > 4 * len(lines) + 2:
            hum = _fitted_lines(series.time[rows], series.values[rows], lines)
            values[rows] -= hum
            removed += float(hum @ hum)
    return WithoutHum(replace(series, values=values), removed / known.size)


def hum_frequencies(series: Series) -> list[float]:
    """Frequencies of the lines of the mains that exceed the spectrum beside them, Hz."""
    known = np.flatnonzero(np.isfinite(series.values))
    if known.size < 3 or known.size * series.step * MAINS[0] < LEAST_PERIODS:
        return []
    rate = 1.0 / series.step
    if rate <= 2.0 * 2.0 * DEVIATION:
        # Within its deviation, a line of the mains appears anywhere in so narrow a band.
        return []
    blocks = _windowed_blocks(series, known)
    found = []
    for mains in MAINS:
        for harmonic in HARMONICS:
            nominal = mains * harmonic
            alias = abs(nominal - rate * round(nominal / rate))
            room = min(alias, 0.5 * rate - alias)
            if room * series.step * known.size < LEAST_PERIODS:
                continue
            powers = _powers(blocks, nominal - DEVIATION, DEVIATION_STEP, round(2.0 * DEVIATION / DEVIATION_STEP) + 1)
            frequency = nominal - DEVIATION + DEVIATION_STEP * int(np.argmax(powers))
            resolution = 4.0 / (blocks.rows * series.step)
            power = float(np.max(powers))
            uneven = blocks.time.shape[1] > 1
            if uneven and power <= ABOVE_LARGEST * _power_of_slow_part(series, known, frequency):
                continue
            if _stands_out(blocks, frequency, power, room, resolution):
                found.append(frequency)
    return found


SLOW = 0.2
"""Frequency over that of a line up to which a motion is slow: a Gaussian filter of that band leaves 2^-25 of a line."""


def _power_of_slow_part(series: Series, known: np.ndarray, frequency: float) -> float:
    """Power at the frequency of a line that the values have without it: seen at uneven times, a slow motion has power
    at frequencies at which many of its rows have nearly one phase, such as 100 Hz in rows about 10 ms apart."""
    first, last = series.time[known[[0, -1]]].tolist()
    if last - first > 2.0 * series.step * series.time.size:
        # Most of the time is gaps: the rows between them are even.
        return 0.0
    even = np.arange(first, last, series.step)
    smooth = GaussianFilter(BAND / (SLOW * frequency), series.step, even.size)
    slow = smooth(np.interp(even, series.time[known], series.values[known]))
    values = np.where(np.isfinite(series.values), np.interp(series.time, even, slow), np.nan)
    return float(_powers(_windowed_blocks(replace(series, values=values), known), frequency, 0.0, 1)[0])


class _Blocks(NamedTuple):
    """Windowed values of blocks, each divided into runs without gaps in time: number and rows of the blocks; values of
    the r runs (n, r), zero where unknown or beyond the end; time after the start of the run, s, (n, r), or (n, 1) if
    the same in all; start of the runs in their block (r,), s; first run of each block (count,)."""

    count: int
    rows: int
    values: np.ndarray
    time: np.ndarray
    start: np.ndarray
    first: np.ndarray


def _blocks(series: Series, known: np.ndarray) -> list[np.ndarray]:
    """Rows of the blocks, as many in each as `BLOCK` has without gaps in time."""
    return np.array_split(known, max(1, round(known.size * series.step / BLOCK)))


def _windowed_blocks(series: Series, known: np.ndarray) -> _Blocks:
    blocks = _blocks(series, known)
    few_gaps = np.count_nonzero(_gaps(series.time, series.step)) <= MOST_RUNS * len(blocks)
    runs: list[tuple[np.ndarray, np.ndarray]] = []
    first, start = [], []
    for rows in blocks:
        values = np.zeros(rows[-1] + 1 - rows[0])
        held = series.values[rows]
        values[rows - rows[0]] = np.hanning(rows.size) * (held - np.mean(held))
        time = series.time[rows[0] : rows[-1] + 1]
        gaps = np.flatnonzero(_gaps(time, series.step)) + 1 if few_gaps else []
        first.append(len(runs))
        for own_time, own_values in zip(np.split(time, gaps), np.split(values, gaps), strict=True):
            runs.append((own_time - own_time[0], own_values))
            start.append(own_time[0] - time[0])
    longest = max(values.size for _, values in runs)
    even = series.step * np.arange(longest)
    time, windowed = (np.zeros((longest, len(runs))) for _ in range(2))
    for k, (own_time, own_values) in enumerate(runs):
        time[:, k], time[: own_time.size, k], windowed[: own_time.size, k] = even, own_time, own_values
    if np.max(np.abs(time - even[:, None])) < EVEN * series.step:
        time = even[:, None]
    return _Blocks(len(blocks), blocks[0].size, windowed, time, np.array(start), np.array(first))


def _gaps(time: np.ndarray, step: float) -> np.ndarray:
    """Whether rows are missing after each row but the last, (n - 1,)."""
    return np.diff(time) > 1.5 * step


def _powers(blocks: _Blocks, first: float, step: float, count: int) -> np.ndarray:
    """Power (count,) at the frequencies first + k step, summed over the blocks; e^(-i (w + s) t) = e^(-i w t) e^(-i s
    t)."""
    found = np.zeros(count)
    phase = np.exp(-2j * np.pi * first * blocks.time)
    turn = np.exp(-2j * np.pi * step * blocks.time)
    for k in range(count):
        runs = _sums(phase, blocks.values) * np.exp(-2j * np.pi * (first + k * step) * blocks.start)
        found[k] = np.sum(np.abs(np.add.reduceat(runs, blocks.first)) ** 2)
        phase *= turn
    return found


def _sums(phase: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Sums (r,) of the products of phases, (n, r) or (n, 1), and values, (n, r)."""
    if phase.shape[1] == 1:
        return np.real(phase[:, 0]) @ values + 1j * (np.imag(phase[:, 0]) @ values)
    return np.einsum("nr,nr->r", phase, values)


def _stands_out(blocks: _Blocks, frequency: float, power: float, room: float, resolution: float) -> bool:
    """Whether the power at a frequency is above that beside it, from the nearest on; `room` is the distance of its
    alias from zero and from Nyquist's frequency, `resolution` the width of a line, Hz."""
    span = min(BESIDE * frequency, 0.9 * room)
    if span < 4.0 * resolution:
        return False
    shifts = np.arange(1.5 * resolution, span, 0.5 * resolution)
    beside: list[float] = []
    start, count = 0, 1
    while start < shifts.size:
        part = shifts[start : start + count]
        start, count = start + count, min(2 * count, COMPARED_AT_ONCE)
        for sign in (1.0, -1.0):
            beside += _powers(blocks, frequency + sign * part[0], sign * 0.5 * resolution, part.size).tolist()
        if power <= ABOVE_LARGEST * max(beside):
            return False
    return power > (1.0 + ABOVE / np.sqrt(blocks.count)) * float(np.mean(beside))


def _fitted_lines(time: np.ndarray, values: np.ndarray, lines: list[float]) -> np.ndarray:
    """The sinusoids (n,) at the frequencies, by least squares with a mean, weighted by a Hann window: without it, a
    motion of low frequency adds its ends to a line, falling with 1/f only."""
    angles = 2.0 * np.pi * np.outer(time - time[0], lines)
    columns = np.column_stack([np.cos(angles), np.sin(angles), np.ones(time.size)])
    root = np.sqrt(np.hanning(time.size))
    found = np.linalg.lstsq(root[:, None] * columns, root * values, rcond=None)[0]
    return columns[:, :-1] @ found[:-1]
