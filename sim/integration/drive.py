"""Drive of the axis in a simulation: a force, a spring with a driven end, or a prescribed motion.

All have the form mass * v' = s(t) + amplitude cos(frequency t + phase) - stiffness x - friction, with s piecewise
linear; the integrator steps from knot to knot of s, so a corner or a jump does not reduce the accuracy.
"""

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from sim.numerics.compilation import compiled


@dataclass(frozen=True)
class Drive:
    """A drive, built by `force`, `held_force`, `pulled_spring` or `sinusoidal_velocity`."""

    knots: np.ndarray  # times at which a segment begins, s, shape (m,), increasing
    values: np.ndarray  # s at each knot, N, shape (m,)
    rates: np.ndarray  # slope of s from each knot on, N/s, shape (m,)
    # amplitude (N), frequency (rad/s), phase (rad) of the sinusoidal part
    wave: tuple[float, float, float] = (0.0, 0.0, 0.0)
    stiffness: float = 0.0  # of the spring between the drive and the axis, N/m
    prescribes: bool = False  # the motion is imposed, without reaction of the friction; s is then an acceleration
    initial_velocity: float = field(default=0.0)  # the velocity an imposed motion starts with, m/s

    def __post_init__(self) -> None:
        if not (self.knots.shape == self.values.shape == self.rates.shape and self.knots.ndim == 1 and self.knots.size):
            raise ValueError(f"knots, values, rates must be of one shape (m,), got {self.knots.shape}")
        if np.any(np.diff(self.knots) <= 0.0):
            raise ValueError("a drive's knots must increase strictly")


def _array(values: object) -> np.ndarray:
    return np.ascontiguousarray(values, dtype=float)


def force(time: object, newtons: object) -> Drive:
    """A force (m,), N, given at instants (m,), s, strictly increasing, linear between them and constant after the
    last."""
    t, s = _array(time), _array(newtons)
    return Drive(t, s, np.append(np.diff(s) / np.diff(t), 0.0))


def held_force(time: object, newtons: object) -> Drive:
    """A force held from each instant to the next (the output of a sampled controller); arguments as `force`."""
    t, s = _array(time), _array(newtons)
    return Drive(t, s, np.zeros(t.size))


def pulled_spring(time: object, pull_position: object, stiffness: float) -> Drive:
    """A spring, N/m, positive, from the axis to a point moved along `pull_position` (m,), m, linear between instants
    (m,), s, of which there are two or more, strictly increasing.

    Beyond the last instant the point keeps the velocity of the last segment.
    """
    t, y = _array(time), _array(pull_position)
    rates = np.diff(y) / np.diff(t)
    return Drive(t, stiffness * y, stiffness * np.append(rates, rates[-1]), stiffness=stiffness)


def sinusoidal_velocity(amplitude: float, frequency: float, mean: float) -> Drive:
    """An imposed motion, v = mean + amplitude sin(frequency t): m/s, rad/s, m/s."""
    return Drive(
        np.zeros(1),
        np.zeros(1),
        np.zeros(1),
        wave=(amplitude * frequency, frequency, 0.0),
        prescribes=True,
        initial_velocity=mean,
    )


def delayed(drive: Drive, delay: float) -> Drive:
    """The drive, `delay` s late; before its first knot plus the delay it holds its first value."""
    if delay <= 0.0:
        return drive
    amplitude, frequency, phase = drive.wave
    return replace(
        drive,
        knots=np.append(drive.knots[0], drive.knots + delay),
        values=np.append(drive.values[0], drive.values),
        rates=np.append(0.0, drive.rates),
        wave=(amplitude, frequency, phase - frequency * delay),
    )


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
    """The drive from `begin` to `end`, s, with as few segments as the tolerance allows; the wave is unchanged.

    It differs by at most `SHARE` of `accuracy` (of velocity and position in a step, m/s and m) anywhere, for a mass in
    kg; the same drive when nothing can be joined.
    """
    if drive.knots.size < FEWEST or not math.isfinite(end):
        return drive
    first = max(int(np.searchsorted(drive.knots, begin, side="right")) - 1, 0)
    last = int(np.searchsorted(drive.knots, end, side="left")) - 1
    if last - first + 1 < FEWEST:
        return drive
    knots, values, rates = (a[first:] for a in (drive.knots, drive.values, drive.rates))
    times, heights, slopes = _joined(knots, values, rates, last - first, end, SHARE * accuracy * mass)
    return drive if times.size > last - first else replace(drive, knots=times, values=heights, rates=slopes)
