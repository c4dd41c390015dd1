"""Noise of a force balance: of the filtered acceleration and force, and the width of the filter that it requires."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from sysid.noise.estimate import Noise
from sysid.signals import GaussianFilter, NoiseSpectrum


class Signal(NamedTuple):
    """A signal (n,) with its gaps bridged, the mask (n,) of the gaps, and size and spectrum of its noise."""

    values: np.ndarray
    gap: np.ndarray
    std: float
    spectrum: NoiseSpectrum


def acceleration_noise(position: Signal, full: GaussianFilter) -> float:
    """Noise of the filtered acceleration that the measured position leaves, m/s^2."""
    return position.std * full.noise_gain(2, position.spectrum)


def force_noise(position: Signal, force: Signal, mass: float, full: GaussianFilter) -> float:
    """Noise of the filtered balance of a force and ``mass`` times the acceleration, N."""
    own = force.std * full.noise_gain(0, force.spectrum)
    return float(np.hypot(own, mass * acceleration_noise(position, full)))


def filter_width(
    channels: Mapping[str, np.ndarray],
    noise: Mapping[str, Noise],
    signals: tuple[Signal, Signal],
    step: float,
    mass: float,
) -> float:
    """Width of the filter, s, from the noise of position and force (`signals`)."""
    position, force = signals
    of = next((noise[name] for name in ("position", "velocity", "spring_force") if name in channels), None)
    # Quantisation steps of a slow motion are no noise that a wider filter would reduce: it only blurs more.
    unquantised = 1.0 if of is None or of.without_quantisation is None else of.without_quantisation / of.value
    if rms_about_mean(force.values) == 0.0:
        return _free_motion_width(position, step)
    target = max(force.std, 1e-3 * rms_about_mean(force.values))
    return _width_for(position.std * unquantised, step, mass, target, position.values.size, position.spectrum)


FREE_MOTION = 1e-2
"""Noise of the acceleration over its rms that the filter of a free motion leaves: it has no force to compare with."""


def _free_motion_width(position: Signal, step: float) -> float:
    """Width of the filter of a coast-down or a free oscillation, s: the least at which the acceleration's noise is a
    hundredth of its rms, else that of the least ratio, up to a fortieth of the record."""
    n, best, least = position.values.size, step, np.inf
    for width in step * np.geomspace(1.0, max(1.0, n / 40.0), 30):
        smooth = GaussianFilter(width, step, n)
        inside = slice(smooth.margin, n - smooth.margin)
        own = position.std * smooth.noise_gain(2, position.spectrum)
        ratio = own / max(float(np.std(smooth(position.values, 2)[inside])), 1e-300)
        if ratio < least:
            best, least = float(width), ratio
        if ratio <= FREE_MOTION:
            break
    return best


def rms_about_mean(values: np.ndarray) -> float:
    """Root mean square of a signal (n,) less its mean."""
    return float(np.sqrt(np.mean((values - values.mean()) ** 2)))


def _width_for(
    position_noise: float, step: float, mass: float, allowed: float, size: int, spectrum: NoiseSpectrum
) -> float:
    """Width (s) of the filter: the least at which mass times acceleration is no noisier than an `allowed` force."""
    width = 1.0 * step
    longest = size * step / 40.0
    while width < longest:
        gain = GaussianFilter(width, step, size).noise_gain(2, spectrum)
        if mass * position_noise * gain <= allowed:
            return width
        width *= 1.15
    return longest
