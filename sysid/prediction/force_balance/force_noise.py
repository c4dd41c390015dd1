"""Noise of a force balance: of the force's sensor, and of the mass times the acceleration by the position's."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sim.effects.effect import Effect
from sysid.prediction.effect_terms import Values, values_of
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.sensors import ahead_of_motion, delays_motion
from sysid.signals.gaussian_filter import GaussianFilter, NoiseSpectrum


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


RINGING = 2000
"""Samples over which the response of a mode to the noise of one sample is followed."""


def residual_noise(balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values) -> float:
    """Standard deviation of the force channel's residual, with the acceleration's noise taken through the modes of the
    model, which part of the mass does not follow, and through the inverse of its delays, as the force is. A balance
    scored in the position delays the pull instead."""
    noise, of_force = balance.noise[balance.force_channel], balance.force_channel != "position"
    modes = [effect for effect in effects if effect.is_mode]
    delays = any(delays_motion(balance, effect) for effect in effects)
    if balance.full_filter is None or not of_force or not (delays or modes):
        return noise
    kernel = balance.full_filter.kernel(2)
    taken = np.pad(kernel, (kernel.size, kernel.size + RINGING * bool(modes)))
    for effect in modes:
        p = values_of(effect, values)
        assert effect.signal is not None
        taken = taken + getattr(p, "mass_ratio", 1.0) * (effect.signal(taken, balance.step, p) - taken)
    gain = float(np.linalg.norm(ahead_of_motion(balance, effects, values, taken)) / np.linalg.norm(kernel))
    own = values.get("rig.mass", 0.0) * balance.acceleration_noise
    return float(np.sqrt(noise**2 + max(gain**2 - 1.0, -1.0) * min(own, noise) ** 2))
