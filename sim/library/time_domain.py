"""What an effect that has no law at one instant is in a simulation: `Effect.time_domain(p)` gives one of these.

Along a record such an effect is an operator on a signal or on the motion; in time it is a state of its own, a memory of
the motion, or a change of the drive.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class AddedOscillator:
    """A part of the moving mass that rides on a resonance: x2'' = w^2 (x - x2) - 2 damping w x2', w = 2 pi frequency.

    It takes mass_ratio * mass * x2'' from the axis, of which (1 - mass_ratio) * mass is left; so a slow motion feels
    the whole mass, and a steady one no drag.
    """

    frequency: float  # Hz
    damping: float  # ratio
    mass_ratio: float


@dataclass(frozen=True)
class Backlash:
    """Lost motion of full width `gap` (m) in the spring that drives the axis: no force within +-gap/2 of stretch."""

    gap: float


@dataclass(frozen=True)
class DelayedSpeed:
    """The friction level sees the speed of `delay` (s) ago, in the direction of now."""

    delay: float


@dataclass(frozen=True)
class FirstOrderLag:
    """The drive's force, or the end its spring is pulled by, follows its command: y' = (u - y)/time_constant (s)."""

    time_constant: float


@dataclass(frozen=True)
class TransportDelay:
    """The drive does what its command said `delay` (s) ago."""

    delay: float


TimeDomain = AddedOscillator | Backlash | DelayedSpeed | FirstOrderLag | TransportDelay
