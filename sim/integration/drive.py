"""Drive of the axis in a simulation: a force, a spring with a driven end, or a prescribed motion.

All have the form mass * v' = s(t) + amplitude cos(frequency t + phase) - stiffness x - friction, with s piecewise
linear; the integrator steps from knot to knot of s, so a corner or a jump does not reduce the accuracy.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np


@dataclass(frozen=True)
class Drive:
    """A drive, built by `force`, `held_force`, `pulled_spring` or `sinusoidal_velocity`.

    Args:
        knots: times at which a segment begins, s, shape (m,), increasing.
        values: s at each knot, N, shape (m,).
        rates: slope of s from each knot on, N/s, shape (m,).
        wave: amplitude (N), frequency (rad/s), phase (rad) of the sinusoidal part.
        stiffness: of the spring between the drive and the axis, N/m.
        prescribes: the motion is imposed, without reaction of the friction; s is then an acceleration.
        initial_velocity: the velocity an imposed motion starts with, m/s.
    """

    knots: np.ndarray
    values: np.ndarray
    rates: np.ndarray
    wave: tuple[float, float, float] = (0.0, 0.0, 0.0)
    stiffness: float = 0.0
    prescribes: bool = False
    initial_velocity: float = field(default=0.0)

    def __post_init__(self) -> None:
        if not (self.knots.shape == self.values.shape == self.rates.shape and self.knots.ndim == 1 and self.knots.size):
            raise ValueError(f"knots, values, rates must be of one shape (m,), got {self.knots.shape}")
        if np.any(np.diff(self.knots) <= 0.0):
            raise ValueError("a drive's knots must increase strictly")


def _array(values: object) -> np.ndarray:
    return np.ascontiguousarray(values, dtype=float)


def force(time: object, newtons: object) -> Drive:
    """A force given at instants, linear between them and constant after the last.

    Args:
        time: s, shape (m,), strictly increasing.
        newtons: N, shape (m,).
    """
    t, s = _array(time), _array(newtons)
    return Drive(t, s, np.append(np.diff(s) / np.diff(t), 0.0))


def held_force(time: object, newtons: object) -> Drive:
    """A force held from each instant to the next (the output of a sampled controller); arguments as `force`."""
    t, s = _array(time), _array(newtons)
    return Drive(t, s, np.zeros(t.size))


def pulled_spring(time: object, pull_position: object, stiffness: float) -> Drive:
    """A spring from the axis to a point moved along `pull_position`, linear between the instants given.

    Beyond the last instant the point keeps the velocity of the last segment.

    Args:
        time: s, shape (m,), m >= 2, strictly increasing.
        pull_position: m, shape (m,).
        stiffness: N/m, positive.
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
