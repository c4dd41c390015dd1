"""Resolution, range and hand-over of a sensor, and errors by differencing and misalignment."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stagecad.parameters.errors import require

Array = NDArray[np.float64]


def count_size(span: ArrayLike, bits: ArrayLike) -> Array:
    """Step of a converter over a span (m): ``span/2^bits``, m; bits 1 to 32, whole."""
    n, whole = np.asarray(bits, float), np.asarray(span, float)
    require(np.all((n >= 1) & (n <= 32) & (n == np.round(n))), "sensors: bits: must be a whole number in 1 to 32")
    require(np.all(whole > 0), "sensors: span: must be above 0 m")
    return whole / 2**n


def filtered_noise(noise: ArrayLike, bandwidth: ArrayLike, cutoff: ArrayLike) -> Array:
    """Rms of white noise after a narrower filter of the same kind: ``noise sqrt(cutoff/bandwidth)``, m.

    Gain after the filter changes neither signal nor noise in metres; it only reduces the converter's count.

    Args:
        noise: rms within the bandwidth, m.
        bandwidth, cutoff: Hz, cutoff at most the bandwidth.
    """
    wide, narrow = np.asarray(bandwidth, float), np.asarray(cutoff, float)
    require(np.all((narrow > 0) & (narrow <= wide)), "sensors: cutoff: must lie above 0 and at most at the bandwidth")
    return np.asarray(noise, float) * np.sqrt(narrow / wide)


def velocity_noise(count: ArrayLike, rate: ArrayLike) -> Array:
    """Rms velocity error of differencing a quantised position: ``count/sqrt(6) rate``, m/s.

    Two independent roundings of count/sqrt(12) each; it grows with the sampling rate.

    Args:
        count: step of the position, m.
        rate: samples per second, Hz.
    """
    step, f = np.asarray(count, float), np.asarray(rate, float)
    require(np.all(step > 0) and np.all(f > 0), "sensors: count and rate: must be above 0")
    return step / np.sqrt(6.0) * f


def lag_error(speed: ArrayLike, bandwidth: ArrayLike) -> Array:
    """Position error of a first-order sensor at constant speed: ``v/(2 pi f)``, m (v in m/s, f > 0 in Hz).

    Raises:
        InputError: bandwidth not above 0.
    """
    f = np.asarray(bandwidth, float)
    require(np.all(f > 0), "sensors: bandwidth: must be above 0 Hz")
    return np.asarray(speed, float) / (2 * np.pi * f)


def abbe_error(offset: ArrayLike, angle: ArrayLike) -> Array:
    """``offset sin(angle)``, m; `offset` of the measured from the line of interest (m), `angle` of the stage (rad)."""
    turn = np.asarray(angle, float)
    require(np.all(np.abs(turn) <= np.pi / 2), "sensors: angle: must lie in -90 to 90 deg")
    return np.asarray(offset, float) * np.sin(turn)


def cosine_error(travel: ArrayLike, misalignment: ArrayLike) -> Array:
    """``travel (1 - cos(angle))``, m, computed without cancellation as ``2 travel sin^2(angle/2)``."""
    length, turn = np.asarray(travel, float), np.asarray(misalignment, float)
    require(
        np.all(length >= 0) and np.all(np.abs(turn) <= np.pi / 2), "sensors: misalignment: must lie in -90 to 90 deg"
    )
    return 2 * length * np.sin(turn / 2) ** 2


def air_index_error(path: ArrayLike, temperature_change: ArrayLike, pressure_change: ArrayLike) -> Array:
    """Largest error of a length in air by the change of its refractive index, m.

    ``L (0.93e-6/K |dT| + 2.7e-9/Pa |dp|)``: the slopes of Edlen's equation at 20 degC and 101 kPa; of humidity, 8.5e-9
    per per cent, a tenth of that and left out.

    Args:
        path: L, m, >= 0.
        temperature_change: dT of the air, K.
        pressure_change: dp of the air, Pa.

    Source: Birch, Downs, Metrologia 31 (1994) 315.
    """
    length, dt, dp = (np.asarray(v, float) for v in (path, temperature_change, pressure_change))
    require(np.all(length >= 0), "sensors: path: must be 0 m or more")
    return length * (0.93e-6 * np.abs(dt) + 2.7e-9 * np.abs(dp))
