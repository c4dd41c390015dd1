"""Convex PTFE-coated pads on a hard way: pressure, stiffness, averaging of the surface, wear and heat."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stagecad.parameters.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FilmContact:
    """A crowned pad with a thin soft film pressed on a flat; SI units."""

    radius: Array
    """of the contact, m"""
    indentation: Array
    """of the film in the middle, m"""
    peak_pressure: Array
    """Pa"""
    stiffness: Array
    """dF/ddelta, N/m"""


@dataclass(frozen=True)
class PadStiffness:
    """Stiffness of the stage on its pads, about the pads' stiffness centre."""

    normal: float
    """N/m"""
    pitch: float
    """about the axis across the travel, N m/rad"""
    roll: float
    """about the axis along the travel, N m/rad"""


def confined_modulus(modulus: float, poisson: float) -> float:
    """Stiffness of a film that cannot spread: ``E (1-nu)/((1+nu)(1-2nu))``, Pa; nu 0 to below 0.5."""
    if not 0 <= poisson < 0.499:
        raise InputError(f"sliding bearing: poisson: {poisson:g} must lie in 0 to 0.499 (a film of 0.5 has no give)")
    return modulus * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))


def film_contact(load: ArrayLike, crown_radius: float, thickness: float, film_modulus: float) -> FilmContact:
    """A spherical crown pressed on a flat through a thin film that acts as an elastic foundation.

    ``delta = a^2/(2R)``, ``F = pi M a^4/(4 R t)``, ``p0 = M delta/t``, ``dF/ddelta = pi M a^2 / t`` with M the confined
    modulus: the film is much thinner than the contact is wide, and much softer than what it lies on.

    Args:
        load: F, N, > 0.
        crown_radius: R of the pad, m.
        thickness: t of the film, m.
        film_modulus: confined modulus M, Pa (`confined_modulus`).

    Returns:
        `FilmContact`. Valid while t < a and delta < t: check `indentation`.

    Raises:
        InputError: an argument not above zero.

    Source: Johnson, Contact Mechanics (1985), section 5.8 (frictionless layer bonded to a rigid base).
    """
    force = np.asarray(load, float)
    for name, value in (("crown radius", crown_radius), ("film thickness", thickness), ("film modulus", film_modulus)):
        if not value > 0:
            raise InputError(f"sliding bearing: {name}: {value:g} must be above 0")
    if not np.all(force > 0):
        raise InputError("sliding bearing: load: must be above 0 N")
    square = np.sqrt(4 * force * crown_radius * thickness / (np.pi * film_modulus))
    indentation = square / (2 * crown_radius)
    return FilmContact(
        radius=np.sqrt(square),
        indentation=indentation,
        peak_pressure=film_modulus * indentation / thickness,
        stiffness=np.pi * film_modulus * square / thickness,
    )


def pad_loads(pads: ArrayLike, load: float, centre: ArrayLike) -> Array:
    """Normal load of each pad, N: equal springs under a rigid stage (statics alone for three pads).

    Args:
        pads: pad centres, m, shape (n, 2).
        load: weight and preload, N.
        centre: where the load acts, m, shape (2,).

    Returns:
        shape (n,); a negative one means the pad would lift.
    """
    points = np.asarray(pads, float)
    rows = np.vstack([np.ones(len(points)), points.T])
    right = load * np.concatenate([[1.0], np.asarray(centre, float)])
    return rows.T @ np.linalg.solve(rows @ rows.T, right)


def pad_stiffness(pads: ArrayLike, stiffnesses: ArrayLike) -> PadStiffness:
    """Normal, pitch and roll stiffness of pads at (x along, y across) with each its own normal stiffness.

    Args:
        pads: pad centres, m, shape (n, 2).
        stiffnesses: N/m, shape (n,).
    """
    points, k = np.asarray(pads, float), np.asarray(stiffnesses, float)
    middle = k @ points / k.sum()
    away = points - middle
    return PadStiffness(float(k.sum()), float(k @ away[:, 0] ** 2), float(k @ away[:, 1] ** 2))


def averaged_profile(profile: ArrayLike, step: float, pad_length: float) -> Array:
    """Height of a pad riding on a profile, its load spread as a parabola over its length.

    Args:
        profile: heights along the travel, m, shape (n,), evenly spaced.
        step: spacing of the heights, m.
        pad_length: length of the contact along the travel, m, at least two steps.

    Returns:
        height at every position where the whole pad is on the profile, m.

    Raises:
        InputError: the pad is longer than the profile, or shorter than two steps.
    """
    heights = np.asarray(profile, float)
    count = int(np.floor(pad_length / step + 1e-9)) + 1
    if count < 3 or count > heights.size:
        raise InputError(
            f"sliding bearing: a pad of {pad_length:g} m covers {count} of {heights.size} heights; 3 or more are needed"
        )
    place = np.linspace(-1, 1, count + 2)[1:-1]
    weight = 1 - place**2
    return np.convolve(heights, weight / weight.sum(), mode="valid")


def averaged_roughness(
    roughness: ArrayLike, correlation_length: ArrayLike, length: float, width: float, pads: int = 1
) -> Array:
    """Rms height of a pad averaging a random surface, m.

    ``sigma = Ra sqrt(pi/2)`` of a Gaussian surface with correlation ``exp(-r^2/l^2)``; the mean over L x W much larger
    than l keeps ``sigma sqrt(pi) l / sqrt(L W)``, and n pads in parallel 1/sqrt(n) of that.

    Args:
        roughness: Ra, m.
        correlation_length: l, m, at most a third of length and width.
        length, width: of the contact, m.
        pads: number of pads that share the load.

    Raises:
        InputError: correlation length too long for the averaging to hold.
    """
    ra, correlation = np.asarray(roughness, float), np.asarray(correlation_length, float)
    if not np.all(correlation <= min(length, width) / 3):
        raise InputError("sliding bearing: correlation length: must be at most a third of the contact's sides")
    return ra * np.sqrt(np.pi / 2) * np.sqrt(np.pi) * correlation / np.sqrt(length * width * pads)


def wear_distance(depth: ArrayLike, wear_rate: ArrayLike, pressure: ArrayLike) -> Array:
    """Distance slid until a film is worn through, ``s = depth/(k p)``, m (Archard).

    Args:
        depth: film to be worn, m.
        wear_rate: k, specific wear, m^3/(N m) = 1/Pa.
        pressure: mean, Pa.
    """
    return np.asarray(depth, float) / (np.asarray(wear_rate, float) * np.asarray(pressure, float))


def friction_heat(friction: ArrayLike, load: ArrayLike, speed: ArrayLike) -> Array:
    """Heat of sliding ``mu N v``, W."""
    return np.asarray(friction, float) * np.asarray(load, float) * np.asarray(speed, float)
