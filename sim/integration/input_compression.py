"""Pieces of a recorded drive joined where the integrator's tolerance cannot tell the difference.

A record has a corner at every row, and the integrator would stop at each. Most corners are jitter of a sensor or the
grid on which a smooth motion was logged. Here neighbouring pieces s(t) are replaced by one straight line, the least
squares fit: what is left out, e(t), has no impulse and no first moment over the stretch, so speed and position at its
end are those of the record itself. Within it the speed is off by no more than max |D|/mass, D the integral of e, and
that is held far below the tolerance of one step. A drive acts on the motion through its impulse alone, so nothing else
is touched.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from sim.integration.drive import Drive
from sim.numerics.compilation import compiled

SHARE = 0.1
"""Part of a step's tolerated error of the velocity that joining may take."""
FEWEST = 32
"""Pieces below which joining saves less than it costs."""


@compiled
def _joined(knots: Any, values: Any, rates: Any, last: int, end: float, most: float, most_moment: float) -> Any:
    """Pieces 0 to `last`, which ends at `end`, joined where the speed is off by `most` N s at most, and the position by
    `most_moment` N s^2: knots, values and rates."""
    count = last + 1
    edge = np.empty(count + 1)
    edge[:count] = knots[:count]
    edge[count] = end
    times, heights, slopes = np.empty(count), np.empty(count), np.empty(count)
    made, i, guess = 0, 0, 2
    while i < count:
        n, height, slope = min(guess, count - i), values[i], rates[i]
        tries = 0
        while n > 1:
            length, base = edge[i + n] - edge[i], values[i]
            # Impulse and first moment about the middle, where height and slope part; from the first value on, since
            # what is sought is small beside the force itself.
            total, turn = 0.0, 0.0
            for k in range(i, i + n):
                step = edge[k + 1] - edge[k]
                push = (values[k] - base + 0.5 * rates[k] * step) * step
                total += push
                turn += push * (edge[k] + edge[k + 1] - edge[i] - edge[i + n]) + rates[k] * step * step * step / 6.0
            rate = 6.0 * turn / (length * length * length)
            first = total / length - 0.5 * rate * length
            bound = min(most, most_moment / length)
            off, worst = 0.0, 0.0
            for k in range(i, i + n):
                step = edge[k + 1] - edge[k]
                before = values[k] - base - first - rate * (edge[k] - edge[i])
                after = before + (rates[k] - rate) * step
                worst = max(worst, abs(off) + 0.5 * step * max(abs(before), abs(after)))
                off += 0.5 * (before + after) * step
                if worst > bound:
                    break
            if worst <= bound:
                height, slope = base + first, rate
                break
            n = 2 * n // 3
            tries += 1
        n = max(n, 1)
        times[made], heights[made], slopes[made] = edge[i], height, slope
        made += 1
        # What was just enough grows slowly, what was easy fast.
        guess = max(2, n + n // 10 if tries else 2 * n)
        i += n
    return times[:made], heights[:made], slopes[:made]


def force_at(drive: Drive, time: np.ndarray) -> np.ndarray:
    """The pieces' value at instants, N, shape (n,): at a jump, the value before it; the wave is not in it."""
    k = np.maximum(np.searchsorted(drive.knots, time, side="left") - 1, 0)
    return drive.values[k] + drive.rates[k] * (time - drive.knots[k])


def merged(drive: Drive, begin: float, end: float, mass: float, tolerance: float, scale: float) -> Drive:
    """The drive from `begin` to `end` with as few pieces as the tolerance allows.

    Args:
        drive: pieces and a wave; the wave is left as it is.
        begin, end: of the simulation, s.
        mass: moved by the drive, kg.
        tolerance, scale: velocity and position may be off by `tolerance * scale` in a step, m/s and m.

    Returns:
        A drive that differs by no more than `SHARE` of that anywhere; the same one when nothing can be joined.
    """
    if drive.knots.size < FEWEST or not math.isfinite(end):
        return drive
    first = max(int(np.searchsorted(drive.knots, begin, side="right")) - 1, 0)
    last = int(np.searchsorted(drive.knots, end, side="left")) - 1
    if last - first + 1 < FEWEST:
        return drive
    knots, values, rates = (a[first:] for a in (drive.knots, drive.values, drive.rates))
    allowed = SHARE * tolerance * scale * mass
    times, heights, slopes = _joined(knots, values, rates, last - first, end, allowed, allowed)
    if times.size > last - first:
        return drive
    return replace(drive, knots=times, values=heights, rates=slopes)
