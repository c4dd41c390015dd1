"""Time-domain realisations of effects that have no law at one instant; `Effect.time_domain(p)` returns one of these.

Along a record such an effect is an operator on a signal or on the motion; in a simulation it is an additional state, a
delay, or a change of the drive.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class AddedOscillator:
    """A part of the moving mass on a spring and damper: x2'' = w^2 (x - x2) - 2 damping w x2', w = 2 pi frequency.

    Its reaction on the axis is mass_ratio * mass * x2''; the axis itself keeps (1 - mass_ratio) * mass. So a slow
    motion has the total mass, and a steady one no drag.
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
    """The friction level depends on the speed `delay` (s) ago, in the present direction."""

    delay: float


@dataclass(frozen=True)
class FirstOrderLag:
    """The drive's force, or the driven end of its spring, follows its command: y' = (u - y)/time_constant (s)."""

    time_constant: float


@dataclass(frozen=True)
class TransportDelay:
    """The drive follows its command after `delay` (s)."""

    delay: float


TimeDomain = AddedOscillator | Backlash | DelayedSpeed | FirstOrderLag | TransportDelay
