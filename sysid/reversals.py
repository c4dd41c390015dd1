"""When exactly a body turned or came to rest, from a noisy position: sharper than its smoothed velocity can say.

Where friction jumps, the acceleration does, and smoothing the position over that kink shifts the zero of the velocity
by up to half the filter's width. At ten reversals a second that shift, times twice the Coulomb force, would be the
largest error of a force balance. Here each event is fitted by two parabolas that meet at rest,

    x = x0 + a1 (t - t0)^2 / 2  before t0,   x0 + a2 (t - t0)^2 / 2  after (a2 = 0: it stays),

so that t0 comes out free of that bias, to a few hundredths of a sampling step.
"""

from __future__ import annotations

import numpy as np

from sim.compilation import compiled
from sysid.balance import runs


@compiled
def event_times(position: np.ndarray, events: np.ndarray, reach: int, search: float, tries: int) -> np.ndarray:
    """Times (in samples) at which the motion around each event stood still.

    Args:
        position: measured, unfiltered, (n,).
        events: first guesses, in samples, (k,).
        reach: samples on each side that are fitted.
        search: how far from the guess t0 is looked for, in samples.
        tries: number of trial times over that range.

    Returns:
        (k,); the guess itself where the window would leave the record.
    """
    out = events.copy()
    n = position.size
    for k in range(events.size):
        centre = int(np.round(events[k]))
        low, high = centre - reach, centre + reach
        if low < 0 or high >= n:
            continue
        best = np.inf
        for j in range(tries):
            t0 = events[k] - search + 2.0 * search * j / (tries - 1)
            # Normal equations of (x0, a1, a2); the two quadratics do not overlap.
            s_b, s_bb, s_a, s_aa = 0.0, 0.0, 0.0, 0.0
            y_1, y_b, y_a, yy = 0.0, 0.0, 0.0, 0.0
            offset = position[centre]
            for i in range(low, high + 1):
                y = position[i] - offset
                q = 0.5 * (i - t0) ** 2
                y_1 += y
                yy += y * y
                if i < t0:
                    s_b += q
                    s_bb += q * q
                    y_b += q * y
                else:
                    s_a += q
                    s_aa += q * q
                    y_a += q * y
            if s_bb <= 0.0 or s_aa <= 0.0:
                continue
            # Eliminate the curvatures, solve for x0.
            determinant = (high - low + 1) - s_b * s_b / s_bb - s_a * s_a / s_aa
            if determinant <= 1e-9:
                continue
            x0 = (y_1 - s_b * y_b / s_bb - s_a * y_a / s_aa) / determinant
            a1 = (y_b - s_b * x0) / s_bb
            a2 = (y_a - s_a * x0) / s_aa
            error = yy - x0 * y_1 - a1 * y_b - a2 * y_a
            if error < best:
                best = error
                out[k] = t0
    return out


def sharp_direction(
    position: np.ndarray, velocity: np.ndarray, resting: np.ndarray, reach: int, search: float, shortest: int
) -> tuple[np.ndarray, np.ndarray]:
    """Direction of motion with its flips where they happened, and how much of each step was spent at rest.

    Args:
        position: measured, unfiltered, (n,).
        velocity: smoothed, (n,).
        resting: where the smoothed velocity is indistinguishable from rest, (n,).
        reach: samples fitted on each side of an event.
        search: how far a flip may lie from where the smoothed velocity puts it, in samples.
        shortest: a motion of fewer samples is noise.

    Returns:
        direction (n,), in [-1, 1]: the sign of the motion, averaged over the step around each sample; 0 at rest.
        rest (n,), in [0, 1]: the part of the step around each sample spent at rest.
    """
    n = velocity.size
    sign = np.where(resting, 0.0, np.sign(velocity))
    # Noise at rest looks like motion for a sample or two.
    for start, stop in runs(sign != 0.0):
        if stop - start < shortest:
            sign[start:stop] = 0.0
    moving = np.flatnonzero(sign)
    direction, rest = np.zeros(n), np.zeros(n)
    if moving.size == 0:
        return direction, np.ones(n)
    # Where one stretch of motion ends (sample i) and the next begins (sample j), with or without a rest between.
    last, first = moving[:-1], moving[1:]
    ends = np.flatnonzero((first - last > 1) | (sign[first] != sign[last]))
    i, j = last[ends], first[ends]
    through = j - i == 1
    fall = np.where(through, velocity[i] / np.where(through, velocity[i] - velocity[j], 1.0), 0.5)
    guesses = (i + fall).astype(float)
    times = event_times(np.ascontiguousarray(position), guesses, reach, search, 16 * int(np.ceil(search)) + 1)
    departures = np.where(through, times, np.maximum(j - 0.5, times))
    start = -0.5
    if moving[0] > 0:
        _paint(rest, start, moving[0] - 0.5, 1.0)
        start = moving[0] - 0.5
    for stop, departure, heading in zip(times.tolist(), departures.tolist(), sign[i].tolist(), strict=True):
        _paint(direction, start, stop, heading)
        _paint(rest, stop, departure, 1.0)
        start = max(departure, stop)
    end = float(moving[-1]) + 0.5
    _paint(direction, start, end, float(sign[moving[-1]]))
    _paint(rest, end, n - 0.5, 1.0)
    return direction, rest


def _paint(cells: np.ndarray, start: float, stop: float, value: float) -> None:
    """Add `value` times the part of each sample's step (half before, half after it) that lies in [start, stop]."""
    start, stop = max(start, -0.5), min(stop, cells.size - 0.5)
    if stop <= start:
        return
    first, last = int(np.floor(start + 0.5)), min(int(np.floor(stop + 0.5)), cells.size - 1)
    if first == last:
        cells[first] += value * (stop - start)
        return
    cells[first] += value * (first + 0.5 - start)
    cells[first + 1 : last] += value
    cells[last] += value * (stop - (last - 0.5))
