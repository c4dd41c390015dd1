"""A record on a uniform time grid."""

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.record import Record
from sysid.signals import dilated, filled, longer_than

MOST_SAMPLES = 1_000_000
MOST_PER_ROW = 100
"""Largest number of samples of the uniform grid, and largest number per row."""

FEWEST, RINGING = 4, 6
"""Rows through which a cubic is drawn, at least, and rows in which its oscillation beside a jump of the acceleration
falls to a thousandth: by 2 - sqrt 3 in each."""

ON_ROW = 0.02
"""Part of a step by which a sample may differ from a row and count as this row."""

UniformGrid = tuple[np.ndarray, float, dict[str, np.ndarray], np.ndarray]
"""Time (n,), step, channels by name (n,), and the mask (n,) of samples that were not measured."""


def uniform(record: Record) -> UniformGrid:
    """The record on a uniform grid of its median step.

    Returns:
        time from zero (n,), step in s, channels by name, and the mask (n,) of samples that were not measured:
        in gaps of the time axis of more than three steps, or at missing rows of a regular log.
    """
    time = record.time - record.time[0]
    step = float(np.median(np.diff(time)))
    # Time stamps of a date (1.7e9 s) are rounded to 2.4e-7 s: neither the step nor its jitter may depend on that.
    rounding = 2.0 * float(np.spacing(np.max(np.abs(record.time))))
    if np.max(np.abs(np.diff(time) - step)) <= 1e-3 * step + rounding:
        rows = np.arange(time.size)
        # The slope over all rows: the rounding of the two ends would change the step of a record of seconds by 1e-7.
        step = float(np.polyfit(rows, time, 1)[0])
        grid = step * rows
        return grid, step, dict(record.channels), np.zeros(time.size, dtype=bool)
    count = int(np.floor(time[-1] / step)) + 1
    if count > max(MOST_SAMPLES, MOST_PER_ROW * time.size):
        before = int(np.argmax(np.diff(time)))
        raise InputError(
            f"{record.file}: no row between {record.time[before]:.9g} s and {record.time[before + 1]:.9g} s, "
            f"at a usual step of {step:.3g} s; leave one side out with from or to, or make it a record of its own"
        )
    grid = step * np.arange(count)
    on_row = np.abs(time[_nearest(time, grid)] - grid) <= ON_ROW * step
    regular, after = bool(on_row.mean() > 0.5), np.clip(np.searchsorted(time, grid), 1, time.size - 1)
    channels = {}
    for name, values in record.channels.items():
        known = np.isfinite(values)
        if not known.any():
            channels[name] = np.full(grid.size, np.nan)
            continue
        resampled = _between(grid, time[known], values[known], record.units.get(name) in SMOOTH, regular)
        if not known.all():
            # Gaps are kept: a grid point next to an empty row is empty.
            resampled[~(known[after] & known[after - 1])] = np.nan
        channels[name] = resampled
    hole = (time[after] - time[after - 1]) > 3.0 * step
    if regular:
        # A regular log with missing rows: samples at missing rows were not measured.
        hole = hole | ~on_row
    return grid, step, channels, hole


SMOOTH = ("m", "rad")
"""Units of channels that have a continuous slope: the position of a mass, which an acceleration a bends by a dt^2/8
between two rows, 4 um at 400 Hz and 5 m/s^2."""


def _between(grid: np.ndarray, time: np.ndarray, values: np.ndarray, smooth: bool, regular: bool) -> np.ndarray:
    """Values (k,) at the times `grid` (k,) of a channel known at `time` (n,): along lines, or smooth cubics. Those with
    a continuous second derivative are exact under a force that is linear between rows, but oscillate where noise is
    larger than the curvature, and beside the missing rows of a regular log."""
    if not smooth or time.size < FEWEST:
        return np.interp(grid, time, values)
    from scipy.interpolate import Akima1DInterpolator, CubicSpline

    steps = np.diff(time)
    change = np.diff(np.diff(np.diff(values) / steps) / (steps[1:] + steps[:-1]))
    # Of white noise neighbouring third differences have the correlation -3/4.
    curved = not regular and change[1:] @ change[:-1] > 0.0
    at = np.clip(grid, time[0], time[-1])
    if not curved:
        return Akima1DInterpolator(time, values)(at)
    # Where a body stops its acceleration jumps: beside a rest a cubic would turn back, and with it the friction.
    near = dilated(longer_than(np.diff(values) == 0.0, 1.0), RINGING)
    row = np.clip(np.searchsorted(time, at, "right") - 1, 0, near.size - 1)
    ends = np.sort(np.stack([values[row], values[row + 1]]), axis=0)
    out = CubicSpline(time, values)(at)
    return np.where(near[row], np.clip(out, *ends), out)


def mean_of_held(record: Record, name: str, grid: np.ndarray, step: float) -> np.ndarray:
    """Mean (k,) over the step around each sample of a grid (k,) of a channel whose value is held from row to row; gaps
    are bridged."""
    time, values = record.time - record.time[0], filled(record.channels[name])[0]
    total = np.concatenate([[0.0], np.cumsum(values[:-1] * np.diff(time))])
    ends = [np.interp(np.clip(grid + side * step, 0.0, time[-1]), time, total) for side in (-0.5, 0.5)]
    lasts = np.clip(grid + 0.5 * step, 0.0, time[-1]) - np.clip(grid - 0.5 * step, 0.0, time[-1])
    return (ends[1] - ends[0]) / np.maximum(lasts, 1e-300)


def distance_to_rows(record: Record, grid: np.ndarray) -> np.ndarray:
    """Time (n,) between each sample of a grid (n,) and the nearest row, s."""
    time = record.time - record.time[0]
    return np.abs(time[_nearest(time, grid)] - grid)


def nearest_row(record: Record, values: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """Value (n,) of a channel in the row nearest to each sample of a grid (n,)."""
    return values[_nearest(record.time - record.time[0], grid)]


def _nearest(time: np.ndarray, grid: np.ndarray) -> np.ndarray:
    after = np.clip(np.searchsorted(time, grid), 1, time.size - 1)
    return np.where(time[after] - grid < grid - time[after - 1], after, after - 1)
