"""Screws of the bearing way: preload from torque, stripping of threads, pressure under the head."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import k0

from stagecad.parameters.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class UnifiedThread:
    """Basic dimensions of a unified inch thread, m."""

    diameter: float
    pitch: float

    @property
    def pitch_diameter(self) -> float:
        """``d - 0.649519 P``"""
        return self.diameter - 0.6495190528 * self.pitch

    @property
    def stress_area(self) -> float:
        """Tensile stress area ``pi/4 (d - 0.9743 P)^2``, m^2 (ASME B1.1)."""
        return math.pi / 4 * (self.diameter - 0.9743 * self.pitch) ** 2

    @property
    def internal_minor_diameter(self) -> float:
        """``d - 1.082532 P``"""
        return self.diameter - 1.0825317547 * self.pitch


def preload_of_torque(torque: ArrayLike, diameter: ArrayLike, nut_factor: ArrayLike = 0.2) -> Array:
    """Preload of a screw, ``F = T/(K d)``, N.

    Args:
        torque: T, N m.
        diameter: d, m.
        nut_factor: K, 0.1 (greased) to 0.3 (dry, rough); its scatter is +-30 %.

    Source: Shigley, Mechanical Engineering Design, section 8-8.
    """
    T, d, K = (np.asarray(v, float) for v in (torque, diameter, nut_factor))
    if not (np.all(T >= 0) and np.all(d > 0) and np.all((K >= 0.05) & (K <= 0.5))):
        raise InputError("fastener: diameter must be above 0, torque 0 or more, nut factor 0.05 to 0.5")
    return T / (K * d)


def strip_area_of_bed(thread: UnifiedThread, engagement: ArrayLike) -> Array:
    """Shear area of the internal thread, m^2: ``pi n Le d (1/(2n) + 0.57735 (d - d2))``, n threads per length.

    Basic dimensions, no allowance: real areas are a few percent smaller.

    Args:
        thread: the thread.
        engagement: Le, m, > 0.

    Source: ASME B1.1 / FED-STD-H28, shear area of internal threads.
    """
    depth = np.asarray(engagement, float)
    if not np.all(depth > 0):
        raise InputError("fastener: engagement: must be above 0 m")
    per_length = 1 / thread.pitch
    flank = 0.5 / per_length + 0.57735 * (thread.diameter - thread.pitch_diameter)
    return math.pi * per_length * depth * thread.diameter * flank


def strip_area_of_screw(thread: UnifiedThread, engagement: ArrayLike) -> Array:
    """Shear area of the external thread, m^2: ``pi n Le D1 (1/(2n) + 0.57735 (d2 - D1))``; source as the bed's."""
    depth = np.asarray(engagement, float)
    if not np.all(depth > 0):
        raise InputError("fastener: engagement: must be above 0 m")
    per_length = 1 / thread.pitch
    minor = thread.internal_minor_diameter
    return math.pi * per_length * depth * minor * (0.5 / per_length + 0.57735 * (thread.pitch_diameter - minor))


def head_pressure(force: ArrayLike, head_diameter: ArrayLike, hole_diameter: ArrayLike) -> Array:
    """Mean pressure under a screw head, ``F/(pi/4 (Dh^2 - D^2))``, Pa."""
    F, head, hole = (np.asarray(v, float) for v in (force, head_diameter, hole_diameter))
    if not (np.all(head > hole) and np.all(hole > 0)):
        raise InputError("fastener: the head must be larger than its hole")
    return F / (math.pi / 4 * (head**2 - hole**2))


def screw_waves(
    force: ArrayLike, pitch: ArrayLike, distance: ArrayLike, modulus: ArrayLike, poisson: ArrayLike
) -> Array:
    """Amplitude of the waves that a row of screws presses into the surface next to it, m.

    The Fourier series along the row of ``sum (1 - nu^2) F/(pi E r)`` has waves of the pitch, of the amplitude
    ``4 F (1 - nu^2)/(pi E p) K0(2 pi d/p)``; the higher ones are far smaller.

    Args:
        force: F of each screw, N, >= 0.
        pitch: p, m, > 0.
        distance: d from the row, m, > 0; a quarter of the pitch or more, for the first wave to dominate.
        modulus, poisson: of the body, Pa and -.

    Raises:
        InputError: outside the range.

    Source: Boussinesq's point force, Johnson (1985), eq. 3.22; the sum as a Fourier series of Bessel functions.
    """
    F, p, d, E, nu = (np.asarray(v, float) for v in (force, pitch, distance, modulus, poisson))
    if not (np.all(F >= 0) and np.all(p > 0) and np.all(E > 0) and np.all(d >= p / 4)):
        raise InputError(
            "fastener: pitch and modulus must be above 0, the distance from the row a quarter pitch or more"
        )
    return 4 * F * (1 - nu**2) / (np.pi * E * p) * k0(2 * np.pi * d / p)
