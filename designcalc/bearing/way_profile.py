"""Profiles of a lapped way, measured or synthetic, and the height of a stage on pads that follow them."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from designcalc.bearing.sliding import averaged_profile, pad_weights
from stagecad.parameters.errors import InputError, require

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Surface:
    """Surface of a lapped way: random roughness, and waves. SI."""

    roughness: float  # Ra, m
    correlation_length: float  # l of the roughness, correlation exp(-r^2/l^2), m
    waviness: float  # amplitude of the waves, m
    wavelength: float  # of the waves, m

    def __post_init__(self) -> None:
        for name in ("correlation_length", "wavelength"):
            require(getattr(self, name) > 0, f"way profile: {name.replace('_', ' ')} must be above 0")
        for name in ("roughness", "waviness"):
            require(getattr(self, name) >= 0, f"way profile: {name} must be 0 or more")


def synthetic_profiles(
    surface: Surface, length: float, contact_length: float, count: int, phase: float = 0.0, seed: int = 1
) -> tuple[Array, float]:
    """Profiles along several tracks of a way, each already averaged across a circular contact.

    Roughness is a Gaussian random line of rms ``Ra sqrt(pi/2)``; the mean across a width w much larger than l leaves
    ``sqrt(sqrt(pi) l/w)`` of it. Hertz's pressure on a circle of radius a, summed across, is a parabola along the
    travel (`averaged_profile`), which averages over ``5 a/3``; with ``w = 8 pi a/15`` the area is Hertz's
    ``8 pi a^2/9``. Waves are a sine of the given amplitude.

    Args:
        surface: after lapping.
        length: over which the pads' middles run, m; at least twenty correlation lengths.
        contact_length: diameter of a pad's contact, m.
        count: of the tracks.
        phase: of the waves on the second track and those after it against the first, rad.
        seed: of the random numbers: the same profiles each time.

    Returns:
        heights, m, shape (count, n), and their spacing, m.

    Raises:
        InputError: a correlation length above a third of the contact, for which the mean across is not valid.
    """
    l = surface.correlation_length  # noqa: E741
    if not l <= contact_length / 3:
        raise InputError("way profile: correlation length: must be at most a third of the contact's diameter")
    require(length >= 20 * l and count >= 1, "way profile: length: must be at least twenty correlation lengths")
    step = l / 4
    n = int(np.ceil((length + contact_length) / step)) + 1
    sigma = surface.roughness * np.sqrt(np.pi / 2) * np.sqrt(np.sqrt(np.pi) * l / (4 * np.pi / 15 * contact_length))
    heights = _random_lines(count, n, seed) * sigma
    if surface.waviness > 0:
        shift = np.where(np.arange(count) > 0, phase, 0.0)[:, None]
        heights += surface.waviness * np.sin(2 * np.pi * step * np.arange(n) / surface.wavelength + shift)
    return heights, step


@lru_cache(maxsize=8)
def _random_lines(count: int, n: int, seed: int) -> Array:
    """Random lines of unit rms, with correlation ``exp(-x^2/l^2)`` at four points a correlation length."""
    size = 1 << (count * n - 1).bit_length()
    white = _white_noise(size, seed)[: count * n].reshape(count, n)
    # A transform of a length without large prime factors is quicker: the line is periodic, so its ends are repeated
    # beyond each other as far as the filter reaches.
    ends = np.arange(-_REACH, n + _REACH) % n
    padded: int = next_fast_len(ends.size, real=True)  # type: ignore[assignment]
    spectrum = np.asarray(rfft(white[:, ends], padded, axis=-1)) * _gain(padded)
    rough = np.asarray(irfft(spectrum, padded, axis=-1), float)
    gain = _gain(n)
    expected = np.sqrt(np.mean(np.concatenate([gain, gain[1 : (n + 1) // 2]]) ** 2))
    return rough[:, _REACH : _REACH + n] / expected


_REACH = 24
"""Points, six correlation lengths, beyond which the filter of `_random_lines` is below 1e-10 of its peak."""


def _gain(n: int) -> Array:
    """Of the filter, at the frequencies of a transform of n points: white noise becomes a line with correlation
    ``exp(-x^2/l^2)`` through ``exp(-k^2 l^2/8)``."""
    return np.exp(-((2 * np.pi * rfftfreq(n, 0.25)) ** 2) / 8)


def carried_waves(
    surface: Surface, starts: Array, phases: Array, step: float, size: int, contact_length: float
) -> float:
    """Rms of `carried_height` over the waves of a surface alone, in closed form, m.

    Every pad averages a sine to a sine, and so does the mean of the pads: ``|Z| sin(k x + arg Z)``, whose mean and mean
    square over equally spaced places are geometric series.

    Args:
        surface: its waves.
        starts: where the profile of each pad begins, in steps, shape (pads,).
        phases: of the waves under each pad, rad, shape (pads,).
        step: spacing of the heights, m.
        size: number of heights of each profile.
        contact_length: of a pad along the travel, m, at least two steps.
    """
    weight = pad_weights(size, step, contact_length)
    turn = 2 * np.pi * step / surface.wavelength
    pads = np.mean(np.exp(1j * (turn * np.asarray(starts, float) + phases)))
    whole = surface.waviness * pads * np.sum(weight * np.exp(-1j * turn * np.arange(weight.size)))
    whole = whole * np.exp(1j * turn * (weight.size - 1))
    places = size - weight.size + 1

    def mean(angle: float) -> complex:
        step_on = np.exp(1j * angle)
        return complex((1 - step_on**places) / (1 - step_on) / places) if step_on != 1 else 1.0 + 0.0j

    square = 0.5 * abs(whole) ** 2 - 0.5 * (whole**2 * mean(2 * turn)).real
    return float(np.sqrt(max(square - (whole * mean(turn)).imag ** 2, 0.0)))


@lru_cache(maxsize=2)
def _white_noise(size: int, seed: int) -> Array:
    """Random numbers of unit variance; longer ones begin alike."""
    return np.random.default_rng(seed).standard_normal(size)


def carried_height(profiles: ArrayLike, step: float, contact_length: float) -> Array:
    """Height of a stage on pads that each follow their own profile, over the travel, m.

    Each pad takes the mean over its contact, its pressure falling as a parabola (`averaged_profile`); the stage takes
    the mean of its pads.

    Args:
        profiles: heights along the track of each pad, m, shape (pads, n); measured ones are accepted.
        step: spacing of the heights, m.
        contact_length: of a pad along the travel, m, at least two steps.
    """
    # Both means are linear: that of the pads is taken first, since it takes less time.
    return averaged_profile(np.mean(np.atleast_2d(np.asarray(profiles, float)), axis=0), step, contact_length)
