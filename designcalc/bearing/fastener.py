"""Screws of the bearing way: preload from torque, stripping of threads, pressure under the head."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import k0

from stagecad.parameters.errors import InputError, require

Array = NDArray[np.float64]


INCH = 25.4e-3


@dataclass(frozen=True)
class Thread:
    """A 60-degree thread, m: unified where its pitch is a whole number of threads per inch, else metric.

    Least screw and largest nut by ASME B1.1 (class 2A of unfinished material in 2B) or ISO 965-1 (6g in 6H); the length
    of engagement of the tolerances is the diameter.
    """

    diameter: float
    pitch: float

    @property
    def is_unified(self) -> bool:
        per_inch = INCH / self.pitch
        return abs(per_inch - round(per_inch)) < 1e-3 * per_inch

    @property
    def pitch_diameter(self) -> float:
        """``d - 0.649519 P``"""
        return self.diameter - 0.6495190528 * self.pitch

    @property
    def stress_area(self) -> float:
        """Tensile stress area, m^2: ``pi/4 (d - 0.9743 P)^2`` (ASME B1.1), ``pi/4 (d - 0.9382 P)^2`` (ISO 898-1)."""
        return math.pi / 4 * (self.diameter - (0.9743 if self.is_unified else 0.9382) * self.pitch) ** 2

    @property
    def internal_minor_diameter(self) -> float:
        """``d - 1.082532 P``"""
        return self.diameter - 1.0825317547 * self.pitch

    @property
    def _tolerances(self) -> tuple[float, float, float, float]:
        """Allowance of the screw; tolerances of its major and pitch diameter, and of the nut's minor diameter, m."""
        if self.is_unified:
            d, p = self.diameter / INCH, self.pitch / INCH
            pitch = 0.0015 * (d ** (1 / 3) + math.sqrt(d)) + 0.015 * p ** (2 / 3)
            return 0.3 * pitch * INCH, 0.09 * p ** (2 / 3) * INCH, pitch * INCH, (0.25 * p - 0.4 * p**2) * INCH
        d, p = self.diameter * 1e3, self.pitch * 1e3
        minor = 433 * p - 190 * p**1.22 if p < 1.0 else 230 * p**0.7
        major = 180 * p ** (2 / 3) - 3.15 / math.sqrt(p)
        return (15 + 11 * p) * 1e-6, major * 1e-6, 90 * p**0.4 * d**0.1 * 1e-6, minor * 1e-6

    @property
    def least_screw(self) -> tuple[float, float]:
        """Smallest major and pitch diameter of the external thread, m."""
        allowance, major, pitch, _ = self._tolerances
        return self.diameter - allowance - major, self.pitch_diameter - allowance - pitch

    @property
    def largest_nut(self) -> tuple[float, float]:
        """Largest pitch and minor diameter of the internal thread, m."""
        *_, pitch, minor = self._tolerances
        factor = 1.3 if self.is_unified else 1.32
        return self.pitch_diameter + factor * pitch, self.internal_minor_diameter + minor


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


def strip_area_of_bed(thread: Thread, engagement: ArrayLike) -> Array:
    """Shear area of the internal thread, m^2: ``pi n Le d (1/(2n) + 0.57735 (d - d2))``, n threads per length, with the
    least major diameter d of the screw and the largest pitch diameter d2 of the nut.

    Args:
        engagement: Le, m, > 0.

    Source: ASME B1.1 / FED-STD-H28, shear area of internal threads.
    """
    major, pitch = thread.least_screw[0], thread.largest_nut[0]
    return _strip_area(thread, engagement, major, major - pitch)


def strip_area_of_screw(thread: Thread, engagement: ArrayLike) -> Array:
    """Shear area of the external thread, m^2: ``pi n Le D1 (1/(2n) + 0.57735 (d2 - D1))``, with the largest minor
    diameter D1 of the nut and the least pitch diameter d2 of the screw; source as the bed's."""
    minor, pitch = thread.largest_nut[1], thread.least_screw[1]
    return _strip_area(thread, engagement, minor, pitch - minor)


def _strip_area(thread: Thread, engagement: ArrayLike, diameter: float, overlap: float) -> Array:
    depth = np.asarray(engagement, float)
    require(np.all(depth > 0), "fastener: engagement: must be above 0 m")
    return math.pi * depth / thread.pitch * diameter * (0.5 * thread.pitch + overlap / math.sqrt(3))


def cone_compliance(
    head: ArrayLike, hole: ArrayLike, thickness: ArrayLike, edge: ArrayLike, modulus: ArrayLike
) -> Array:
    """Compression of a clamped part by the force of a screw in a tapped bed, m/N.

    ``delta = 2 ln[(D + d)(D + 2 l tan(phi) - d)/((D - d)(D + 2 l tan(phi) + d))]/(2 E pi d tan(phi))``,
    ``tan(phi) = 0.348 + 0.013 ln(l/D) + 0.193 ln(D_A/D)``: a cone from the head to the bed.

    Args:
        head: D, outer diameter of the bearing surface, m, > d.
        hole: d, m, > 0.
        thickness: l, m, > 0.
        edge: D_A, twice the distance of the screw from the edge of the part, m, > D.
        modulus: E of the part, Pa.

    Raises:
        InputError: outside the range.

    Source: VDI 2230-1 (2015), section 5.1.2, screw joint in a tapped hole (w = 2).
    """
    D, d, length, outer, E = (np.asarray(v, float) for v in (head, hole, thickness, edge, modulus))
    if not (np.all(d > 0) and np.all(d < D) and np.all(length > 0) and np.all(outer > D) and np.all(E > 0)):
        raise InputError("fastener: the head must be larger than its hole, and the part larger than the head")
    slope = 0.348 + 0.013 * np.log(length / D) + 0.193 * np.log(outer / D)
    wide = D + 2 * length * slope
    return np.log((D + d) * (wide - d) / ((D - d) * (wide + d))) / (E * np.pi * d * slope)


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
