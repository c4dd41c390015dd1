"""Piecewise-linear compression of a recorded drive.

A record has a corner at every row, and the integrator would stop at each. Here neighbouring segments s(t) are replaced
by one straight line, the least-squares fit, where the tolerance allows it: the difference e(t) has no impulse and no
first moment over the stretch, so the speed and the position at its end are those of the record itself. Within it the
error of the speed is at most max |D|/mass, D the integral of e, which is kept far below the tolerance of one step.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from sim.integration.drive import Drive
from sim.numerics.compilation import compiled

SHARE = 0.1
"""Part of a step's tolerance of the velocity that the compression may use."""
FEWEST = 32
"""Segments below which compression saves less than it costs."""


@compiled
def _joined(knots: Any, values: Any, rates: Any, last: int, end: float, allowed: float) -> Any:
    """Segments 0 to `last`, which ends at `end`, joined: knots, values and rates. The impulse is off by at most
    `allowed` N s, its integral by `allowed` N s^2."""
    count = last + 1
    edges = np.empty(count + 1)
    edges[:count] = knots[:count]
    edges[count] = end
    times, heights, slopes = np.empty(count), np.empty(count), np.empty(count)
    made, i, guess = 0, 0, 2
    while i < count:
        n, height, slope = min(guess, count - i), values[i], rates[i]
        shortened = False
        while n > 1:
            length, base = edges[i + n] - edges[i], values[i]
            # Impulse and first moment about the middle, relative to the first value: the differences are small.
            impulse, moment = 0.0, 0.0
            for k in range(i, i + n):
                step = edges[k + 1] - edges[k]
                push = (values[k] - base + 0.5 * rates[k] * step) * step
                impulse += push
                moment += push * (edges[k] + edges[k + 1] - edges[i] - edges[i + n]) + rates[k] * step**3 / 6.0
            rate = 6.0 * moment / length**3
            first = impulse / length - 0.5 * rate * length
            bound = min(allowed, allowed / length)
            # The integral D of the difference, which is zero at both ends.
            off, worst = 0.0, 0.0
            for k in range(i, i + n):
                step = edges[k + 1] - edges[k]
                before = values[k] - base - first - rate * (edges[k] - edges[i])
                after = before + (rates[k] - rate) * step
                worst = max(worst, abs(off) + 0.5 * step * max(abs(before), abs(after)))
                off += 0.5 * (before + after) * step
                if worst > bound:
                    break
            if worst <= bound:
                height, slope = base + first, rate
                break
            n = 2 * n // 3
            shortened = True
        n = max(n, 1)
        times[made], heights[made], slopes[made] = edges[i], height, slope
        made += 1
        guess = max(2, n + n // 10 if shortened else 2 * n)
        i += n
    return times[:made], heights[:made], slopes[:made]


def force_at(drive: Drive, time: np.ndarray) -> np.ndarray:
    """Value of the segments at instants, N, shape (n,): at a jump, the value before it; without the wave."""
    k = np.maximum(np.searchsorted(drive.knots, time, side="left") - 1, 0)
    return drive.values[k] + drive.rates[k] * (time - drive.knots[k])


def compressed(drive: Drive, begin: float, end: float, mass: float, accuracy: float) -> Drive:
    """The drive from `begin` to `end` with as few segments as the tolerance allows.

    Args:
        drive: segments and a wave; the wave is unchanged.
        begin, end: of the simulation, s.
        mass: moved by the drive, kg.
        accuracy: error of velocity and position that is tolerated in a step, m/s and m.

    Returns:
        A drive that differs by at most `SHARE` of that anywhere; the same one when nothing can be joined.
    """
    if drive.knots.size < FEWEST or not math.isfinite(end):
        return drive
    first = max(int(np.searchsorted(drive.knots, begin, side="right")) - 1, 0)
    last = int(np.searchsorted(drive.knots, end, side="left")) - 1
    if last - first + 1 < FEWEST:
        return drive
    knots, values, rates = (a[first:] for a in (drive.knots, drive.values, drive.rates))
    times, heights, slopes = _joined(knots, values, rates, last - first, end, SHARE * accuracy * mass)
    if times.size > last - first:
        return drive
    return replace(drive, knots=times, values=heights, rates=slopes)
