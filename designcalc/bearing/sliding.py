"""Convex PTFE-coated pads on a hard way: load, stiffness, averaging of the surface, wear and heat."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.fft import irfft, next_fast_len, rfft

from stagecad.parameters.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PadStiffness:
    """Stiffness of the stage on its pads, about the pads' stiffness centre."""

    normal: float  # N/m
    pitch: float  # about the axis across the travel, N m/rad
    roll: float  # about the axis along the travel, N m/rad


def crown_wear_distance(depth: ArrayLike, crown_radius: ArrayLike, wear_rate: ArrayLike, load: ArrayLike) -> Array:
    """Distance slid until a crown is worn by `depth`: cap volume over Archard's rate, ``s = pi R h^2/(k F)``, m.

    Args:
        depth: h, m, small compared with R.
        crown_radius: R, m.
        wear_rate: k, m^3/(N m) = m^2/N.
        load: F, N.
    """
    h, R, k, F = (np.asarray(v, float) for v in (depth, crown_radius, wear_rate, load))
    if not (np.all(h > 0) and np.all(h <= R / 10) and np.all(k > 0) and np.all(F > 0)):
        raise InputError("sliding bearing: wear: rate and load must be above 0, the depth 0 to a tenth of the radius")
    return np.pi * R * h**2 / (k * F)


def crown_wear_depth(distance: ArrayLike, crown_radius: ArrayLike, wear_rate: ArrayLike, load: ArrayLike) -> Array:
    """Depth a crown is worn to by sliding, ``h = sqrt(k F s/(pi R))``, m: the inverse of `crown_wear_distance`."""
    s, R, k, F = (np.asarray(v, float) for v in (distance, crown_radius, wear_rate, load))
    if not (np.all(s >= 0) and np.all(R > 0) and np.all(k > 0) and np.all(F > 0)):
        raise InputError(
            "sliding bearing: wear needs a radius, a wear rate and a load above 0, and a distance of 0 or more"
        )
    return np.sqrt(k * F * s / (np.pi * R))


def pad_loads(pads: ArrayLike, load: float, centre: ArrayLike) -> Array:
    """Normal load of each pad, N: equal springs under a rigid stage (statics alone for three pads).

    Args:
        pads: pad centres, m, shape (n, 2).
        load: weight and preload, N.
        centre: point of action of the load, m, shape (2,).

    Returns:
        shape (n,); a negative one means the pad would lift.

    Raises:
        InputError: the pads lie on one line.
    """
    points = np.asarray(pads, float)
    rows = np.vstack([np.ones(len(points)), points.T])
    if np.linalg.matrix_rank(rows) < 3:
        raise InputError("sliding bearing: pads: must not lie on one line")
    return rows.T @ np.linalg.solve(rows @ rows.T, load * np.concatenate([[1.0], np.asarray(centre, float)]))


def pad_stiffness(pads: ArrayLike, stiffnesses: ArrayLike) -> PadStiffness:
    """Normal, pitch and roll stiffness of pads at (x along, y across) with each its own normal stiffness.

    Args:
        pads: pad centres, m, shape (n, 2).
        stiffnesses: N/m, shape (n,).
    """
    points, k = np.asarray(pads, float), np.asarray(stiffnesses, float)
    away = points - k @ points / k.sum()
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
    weight = pad_weights(heights.size, step, pad_length)
    # By Fourier transform: direct summation takes ten times as long for a way at a quarter of its correlation length.
    size: int = next_fast_len(heights.size, real=True)  # type: ignore[assignment]
    middle = heights.mean()
    spectrum = np.asarray(rfft(heights - middle, size)) * np.asarray(rfft(weight, size))
    return np.asarray(irfft(spectrum, size), float)[weight.size - 1 : heights.size] + middle


def pad_weights(size: int, step: float, pad_length: float) -> Array:
    """Shares of a pad's load on the heights under it, a parabola; `size`: number of heights of the profile.

    Raises:
        InputError: the pad is longer than the profile, or shorter than two steps.
    """
    count = int(np.floor(pad_length / step + 1e-9)) + 1
    if count < 3 or count > size:
        raise InputError(
            f"sliding bearing: a pad of {pad_length:g} m covers {count} of {size} heights; 3 or more are needed"
        )
    weight = 1 - np.linspace(-1, 1, count + 2)[1:-1] ** 2
    return weight / weight.sum()


def averaged_roughness(roughness: ArrayLike, correlation_length: ArrayLike, radius: ArrayLike, pads: int = 1) -> Array:
    """Rms height of a pad that averages a random surface over its Hertzian contact, m.

    ``sigma = Ra sqrt(pi/2)`` of a Gaussian surface with correlation ``exp(-r^2/l^2)``. Averaged with the weight w over
    an area much larger than l^2 it keeps ``sigma sqrt(pi) l/sqrt(A)`` with ``A = (int w)^2/int w^2``; Hertz's pressure
    on a circle of radius a has ``A = 8 pi a^2/9``. Of n pads in parallel 1/sqrt(n) remains.

    Args:
        roughness: Ra, m.
        correlation_length: l, m, at most a third of the diameter.
        radius: a of the contact, m.
        pads: number of pads that share the load.

    Raises:
        InputError: correlation length too long for the averaging to be valid.
    """
    ra, correlation, a = (np.asarray(v, float) for v in (roughness, correlation_length, radius))
    if not np.all(correlation <= 2 * a / 3):
        raise InputError("sliding bearing: correlation length: must be at most a third of the contact's diameter")
    return ra * np.sqrt(np.pi / 2) * np.sqrt(np.pi) * correlation / (a * np.sqrt(8 * np.pi / 9 * pads))


def friction_heat(friction: ArrayLike, load: ArrayLike, speed: ArrayLike) -> Array:
    """Heat of sliding ``mu N v``, W; all three 0 or more."""
    mu, N, v = (np.asarray(value, float) for value in (friction, load, speed))
    if not (np.all(mu >= 0) and np.all(N >= 0) and np.all(v >= 0)):
        raise InputError("sliding bearing: friction, load and speed must be 0 or more")
    return mu * N * v
