"""Time stamps of a record: their rounding, repeated ones, runs that start anew, uneven steps.

Stamps printed with few digits have unequal steps (16.666 and 16.667 ms at 60 Hz), of which neither is the sampling
step: a line of the mains would alias to a wrong frequency, and rates would be noisy. Rows whose stamps are within their
rounding of evenly spaced times were sampled at these; the step is the slope of the times over the row numbers.
"""

from collections.abc import Mapping

import numpy as np

from stagecad.parameters.units import format_quantity

FINEST = 9
"""Decimal digits of a second beyond which stamps count as exact."""

WITHIN = 1.25
"""Range of the deviations, over the rounding, of rounded stamps: errors that change slowly tilt the fitted line."""

NOTED = 0.01
"""Rounding over the step from which it is reported."""

EXACT = 1e-4
"""Part of the rounding by which a stamp may differ from a multiple of it, as a floating-point number does."""

PRINTED, SURE = 0.1, 10
"""Largest error of a single-precision number printed with nine digits, over the spacing of such numbers (5e-9 of its
value over 2^-24 of it); and number of different stamps so near to such numbers that it is no chance (once in 5^10)."""

LEAST_JITTER = 0.05
"""Part of the time step by which the others must differ from it to be reported as uneven."""


def stamp_rounding(time: np.ndarray, unit: float = 1.0, origin: float = 0.0) -> float:
    """The largest step, s, of which all stamps (n,) are multiples: a power of ten in seconds or in the `unit` of their
    column, s, or else one of two; zero where there is none down to 1 ns. Of single-precision numbers it is the spacing
    of the largest. They are counted from `origin`, s."""
    digits_lost = 4.0 * float(np.spacing(abs(origin) + np.abs(time).max(initial=1.0)))
    tens = [size * 10.0**-digits for size in {1.0, unit if unit > 1.0 else 1.0} for digits in range(FINEST + 1)]
    found = 0.0
    for size in [*sorted(tens, reverse=True), *(2.0**-digits for digits in range(3 * FINEST))]:
        ticks = (time - time[0]) / size
        near = np.abs(ticks - np.rint(ticks)) < max(EXACT, digits_lost / size)
        if digits_lost < 0.01 * size and np.all(near) and np.any(ticks > 0.5):
            found = size
            break
    stamps = (origin + time) / unit
    single = np.abs(stamps.astype(np.float32))
    away = np.abs(np.abs(stamps) - single)
    spacing = unit * float(np.spacing(single.max(initial=0.0)))
    printed = np.unique(single).size >= SURE and np.all(away <= PRINTED * np.spacing(single) + digits_lost / unit)
    return spacing if printed and found + digits_lost < 0.5 * spacing else found


def sampled_times(time: np.ndarray, rounding: float, notes: list[str]) -> np.ndarray:
    """Times (n,) of the rows, s: evenly spaced, but for missing rows, if their stamps are within their
    `rounding` of such times; else as they are."""
    steps = np.diff(time)
    usual = float(np.median(steps))
    if rounding >= 0.5 * usual:
        # The rounding hides which rows are missing.
        rows = np.arange(time.size, dtype=float)
    else:
        near = steps[np.abs(steps - usual) < 0.5 * usual]
        rows = np.concatenate([[0.0], np.cumsum(np.rint(steps / float(np.mean(near))))])
    if np.any(np.diff(rows) < 1.0):
        return time
    step, start = np.polyfit(rows, time, 1)
    away = time - (start + step * rows)
    if not EXACT * rounding < np.ptp(away) <= WITHIN * rounding:
        return time
    if rounding > NOTED * step:
        notes.append(
            f"time stamps are rounded to {format_quantity(rounding, 's', 3)}: the rows are taken as evenly spaced by "
            f"{format_quantity(float(step), 's', 6)}, which may hide an uneven spacing below the rounding"
        )
    return time[0] + step * rows


class RepeatedTime(Exception):  # noqa: N818
    """Two rows have one time and different values; the argument is the later row, from 0."""


def without_repeats(
    time: np.ndarray, values: Mapping[str, np.ndarray], repeated: str | None, notes: list[str]
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Time and channels (n,) with strictly increasing time.

    A row that repeats the one before in all channels is left out. Others are treated by `repeated`: `first` keeps
    the first row of each time, `mean` takes the mean of its rows, `spread` places m rows of one time at
    t + k (t_next - t)/m, k = 0 .. m - 1, where the last group takes the step of the group before.
    """
    again = np.diff(time, prepend=-np.inf) == 0.0
    if not again.any():
        return time, dict(values)
    same = again.copy()
    for array in values.values():
        before = np.concatenate([array[:1], array[:-1]])
        same &= (array == before) | (np.isnan(array) & np.isnan(before))
    if repeated is None and not np.array_equal(same, again):
        raise RepeatedTime(int(np.flatnonzero(again & ~same)[0]))
    count = int(again.sum())
    rows = f"{count} row{'s' * (count != 1)} with the time of the row before"
    starts = np.flatnonzero(~again)
    if repeated is None or repeated == "first":
        notes.append(f"{rows}{'' if repeated else ' and the same values'} left out")
        return time[starts], {channel: array[starts] for channel, array in values.items()}
    sizes = np.diff(np.append(starts, time.size))
    if repeated == "mean":
        notes.append(f"{rows}: the mean of the rows of one time is taken")
        return time[starts], {c: np.add.reduceat(array, starts) / sizes for c, array in values.items()}
    steps = np.diff(time[starts])
    steps = np.append(steps, steps[-1] * sizes[-1] / sizes[-2] if steps.size else 0.0)
    within = np.arange(time.size) - np.repeat(starts, sizes)
    notes.append(f"{rows}: rows of one time are spread evenly up to the next")
    return time + within * np.repeat(steps / sizes, sizes), dict(values)


COUNTER_BITS = (16, 24, 32)
"""Widths of the counters of clock ticks."""


def counter_range(ticks: np.ndarray) -> float:
    """Range of the counter that counts the ticks (n,), which begins anew at its end; 0 where it does not. The step over
    each end is one of those from row to row elsewhere, so that a second run is none."""
    steps = np.diff(ticks)
    falls, others = steps[steps < 0.0], steps[steps > 0.0]
    if not falls.size or not others.size or ticks.min() < 0.0 or np.any(ticks % 1.0):
        return 0.0
    bits = next((bits for bits in COUNTER_BITS if ticks.max() < 2.0**bits), 0)
    over = falls + 2.0**bits
    return 2.0**bits if bits and np.all((over >= others.min()) & (over <= others.max())) else 0.0


def restarts(time: np.ndarray) -> list[int]:
    """First rows of the runs: where the time falls back to its begin, within two steps, and rises from there."""
    steps = np.diff(time)
    falls = np.flatnonzero(steps < 0.0) + 1
    if not falls.size or not np.isfinite(time).all():
        return [0]
    rising = steps[steps > 0.0]
    reach = time[0] + 2.0 * (float(np.median(rising)) if rising.size else 0.0)
    anew = falls[(falls + 1 < time.size) & (time[falls] <= reach)]
    return [0, *(int(row) for row in anew if time[row] < time[row + 1] < time[row - 1])]


def jitter(steps: np.ndarray, step: float) -> list[str]:
    """A note where the time steps (n,), s, differ from their median `step`; else none."""
    longest = int(np.argmax(steps))
    if 2.0 * steps[longest] > np.sum(steps):
        return [
            f"row {longest + 2} is {format_quantity(float(steps[longest]), 's', 6)} after the row before, more than "
            "all others together: was a clock set (summer time)? split the file there, if it holds two runs"
        ]
    low, high = np.quantile(steps, (0.005, 0.995))
    if max(high - step, step - low) < LEAST_JITTER * step:
        return []
    return [
        f"rows are unevenly spaced in time: {format_quantity(float(low), 's', 3)} to "
        f"{format_quantity(float(high), 's', 3)} (99 %), median {format_quantity(step, 's', 3)}"
    ]
