"""Times of the rows of a record without the rounding of their stamps.

Stamps printed with few digits have unequal steps (16.666 and 16.667 ms at 60 Hz), of which neither is the sampling
step: a line of the mains would alias to a wrong frequency, and rates would be noisy. Rows whose stamps are within their
rounding of evenly spaced times were sampled at these; the step is the slope of the times over the row numbers.
"""

from __future__ import annotations

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


def stamp_rounding(time: np.ndarray) -> float:
    """The largest power of ten, s, of which all stamps (n,) are multiples; zero where there is none down to 1 ns."""
    for digits in range(FINEST + 1):
        ticks = (time - time[0]) * 10.0**digits
        if np.all(np.abs(ticks - np.rint(ticks)) < EXACT):
            return 10.0**-digits
    return 0.0


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
    if rounding == 0.0 or np.ptp(away) > WITHIN * rounding or np.ptp(away) < EXACT * step:
        return time
    if rounding > NOTED * step:
        notes.append(
            f"time stamps are rounded to {format_quantity(rounding, 's', 3)}: the rows are taken as evenly spaced by "
            f"{format_quantity(float(step), 's', 6)}, which may hide an uneven spacing below the rounding"
        )
    return time[0] + step * rows
