"""Stiffness of a bolted-down bearing way against the spacing of its bolts (the 'boxway' rail spreadsheet).

With ``tau = t/Db`` (flange thickness over bolt diameter), stiffnesses over ``E Db``:

    flange compression  pi / ln[5 (0.5 + 2 tau)/(2.5 + 2 tau)]      flange shear  pi tau / ((1 + nu) ln 2)
    thread shear = bed shear  pi / ((1 + nu) ln 2)                  bolt          (pi/4) / (tau + 0.75)

The rail is a one-sided cantilever, held at `overhang_a` from one edge and loaded at the other: a lower bound for a way
that is bedded over its whole width.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar

from stagecad.parameters.errors import InputError, require

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rail:
    """The rail and what it is bolted to, SI units. Each number may be an array; shapes broadcast."""

    length: float  # length of rail L, m
    overhang_a: float  # from the bolt line to the edge the rail pivots on, m
    overhang_b: float  # from the bolt line to the loaded edge, m
    height: float  # rail height h, m
    bolt_diameter: float  # Db, m
    rail_modulus: float  # Young's modulus of rail and flange, Pa
    bed_modulus: float  # Young's modulus of thread and bed, Pa
    bolt_modulus: float  # Young's modulus of the bolt, Pa
    poisson: float = 0.3  # Poisson's ratio of rail and flange
    bed_poisson: float | None = None  # Poisson's ratio of thread and bed; that of the rail if left out
    joint_ratio: float = 10.0  # stiffness of the bedded joint over that of the bolt joint

    def __post_init__(self) -> None:
        for name in ("length", "overhang_a", "overhang_b", "height", "bolt_diameter"):
            _positive(name, getattr(self, name), "m")
        for name in ("rail_modulus", "bed_modulus", "bolt_modulus"):
            _positive(name, getattr(self, name), "Pa")
        _positive("joint_ratio", self.joint_ratio, "")
        for name in ("poisson", "bed_poisson"):
            ratio = np.asarray(0.0 if getattr(self, name) is None else getattr(self, name))
            require(np.all((ratio >= 0) & (ratio <= 0.5)), f"rail: {name.replace('_', '-')}: must lie in 0 to 0.5")


@dataclass(frozen=True)
class JointStiffness:
    """The springs of one bolt joint per bolt diameter (N/m per m = Pa), each with the modulus of its material."""

    flange_compression: Array
    flange_shear: Array
    thread_shear: Array
    bolt: Array

    @property
    def joint_per_diameter(self) -> Array:
        """Cb/Db: flange, thread and bolt in series, Pa."""
        return 1 / (1 / self.flange_compression + 1 / self.flange_shear + 1 / self.thread_shear + 1 / self.bolt)


def joint_stiffness(rail: Rail, flange_ratio: ArrayLike) -> JointStiffness:
    """Springs of the bolt joint for a flange `flange_ratio` bolt diameters thick.

    Args:
        flange_ratio: tau = t/Db, any shape, above 0.0 (the 45-degree cone of the formula needs tau > 0).

    Returns:
        `JointStiffness` of that shape.

    Raises:
        InputError: flange_ratio not above zero.

    Source: Slocum, Precision Machine Design (1992), section 7.5; spreadsheet of the thesis, appendix B.
    """
    tau = np.asarray(flange_ratio, float)
    require(np.all(tau > 0), "rail: flange-ratio: must be above 0")
    bed = rail.poisson if rail.bed_poisson is None else rail.bed_poisson
    flange_shear, thread_shear = (np.pi / ((1 + np.asarray(nu)) * np.log(2)) for nu in (rail.poisson, bed))
    return JointStiffness(
        flange_compression=rail.rail_modulus * np.pi / np.log(5 * (0.5 + 2 * tau) / (2.5 + 2 * tau)),
        flange_shear=rail.rail_modulus * flange_shear * tau,
        thread_shear=rail.bed_modulus * thread_shear * np.ones_like(tau),
        bolt=rail.bolt_modulus * (np.pi / 4) / (tau + 0.75),
    )


def bending_shear_compliance(rail: Rail) -> Array:
    """Deflection at the loaded edge per force, times the length of section: 1/A, m^2/N.

    ``1/A = l [(a+b) b^2/(3 E I) + b h^2 (a+b)(1+nu)/(5 a E I)]`` with ``I = l h^3/12``: bending and shear.

    Source: thesis, appendix B (A = 1.26e9 N/m^2 for its rail).
    """
    a, b, h = (np.asarray(v, float) for v in (rail.overhang_a, rail.overhang_b, rail.height))
    inertia_per_length = h**3 / 12
    bending = (a + b) * b**2 / (3 * rail.rail_modulus * inertia_per_length)
    shear = b * h**2 * (a + b) * (1 + rail.poisson) / (5 * a * rail.rail_modulus * inertia_per_length)
    return bending + shear


def total_stiffness(rail: Rail, spacing_ratio: ArrayLike, flange_ratio: ArrayLike) -> Array:
    """Stiffness of the whole rail at its loaded edge.

    ``K = N / [1/K_bs + 1/(J (K_joint + K_bolt joint))]``, ``N = L/(M Db)``, ``K_bs = A Db (M - 1)``,
    ``J = (a/(a+b))^2``, ``K_joint = joint_ratio K_bolt joint``.

    Args:
        spacing_ratio: M, bolt spacing over bolt diameter, above 1, any shape.
        flange_ratio: tau = t/Db, above 0, broadcast with M.

    Returns:
        K, N/m.

    Raises:
        InputError: M not above 1, or tau not above 0.

    Source: thesis, appendix B; Slocum (1992), section 7.5.
    """
    M = np.asarray(spacing_ratio, float)
    require(np.all(M > 1), "rail: spacing-ratio: must be above 1 (bolts would overlap)")
    bolt_joint = joint_stiffness(rail, flange_ratio).joint_per_diameter * rail.bolt_diameter
    lever = (rail.overhang_a / (rail.overhang_a + rail.overhang_b)) ** 2
    bending = bending_shear_compliance(rail) / (rail.bolt_diameter * (M - 1))
    count = rail.length / (M * rail.bolt_diameter)
    return count / (bending + 1 / (lever * (1 + rail.joint_ratio) * bolt_joint))


@lru_cache(maxsize=256)
def best_spacing_ratio(rail: Rail, flange_ratio: float) -> float:
    """Spacing ratio M in (1, 100) with the largest total stiffness; ``K`` has a single peak there.

    With compliances ``1/K_bs = p/(M - 1)`` and ``q`` of the joint, K ~ 1/(M (p/(M-1) + q)), so ``M = 1 + sqrt(p/q)``;
    the search does not rely on that, and its test does.
    """
    found = minimize_scalar(
        lambda M: -float(total_stiffness(rail, M, flange_ratio)), bounds=(1 + 1e-6, 100.0), method="bounded"
    )
    return float(found.x)


def _positive(name: str, value: ArrayLike, unit: str) -> None:
    if not np.all((np.asarray(value) > 0) & np.isfinite(value)):
        raise InputError(f"rail: {name.replace('_', '-')}: must be above 0 {unit}".rstrip())
