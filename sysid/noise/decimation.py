"""Decimation of long records by means of blocks of k consecutive rows.

A mean over k rows keeps the band up to 1 / (2 k step), and the noise falls with it. For a first-order autoregression of
standard deviation s and lag-one correlation c (Priestley, Spectral Analysis and Time Series, 1981, section 5.3),

    var(mean)            = s^2 [k (1 - c^2) - 2 c (1 - c^k)] / [k^2 (1 - c)^2]
    correlation of means = c (1 - c^k)^2 / [k (1 - c^2) - 2 c (1 - c^k)].
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from sysid.experiment.record import Record
from sysid.noise.estimate import Noise
from sysid.signals.gaussian_filter import NoiseSpectrum

MOST_ROWS = 200_000
"""Largest number of rows of all records together that is not decimated."""

LONGEST_SPAN = 1.5
"""Longest span of a block, over k steps: a block with a gap in time has no mean."""


def decimation_factor(records: Sequence[Record]) -> int:
    """Rows per block that keep all records together within `MOST_ROWS`; 1 for no decimation."""
    return -(-sum(record.size for record in records) // MOST_ROWS)


def decimated(record: Record, k: int, held: Sequence[str] = ()) -> Record:
    """A record as means over blocks of k rows."""
    count = record.size // k
    time = record.time[: count * k].reshape(count, k)
    whole = time[:, -1] - time[:, 0] <= LONGEST_SPAN * k * record.step
    channels = {}
    for name, values in record.channels.items():
        if name in held:
            values = np.concatenate([values[:1], 0.5 * (values[1:] + values[:-1])])
        channels[name] = _means(values[: count * k].reshape(count, k))[whole]
    after = time.mean(axis=1)[whole]
    step = float(np.median(np.diff(after)))
    even = bool(np.all(np.abs(np.diff(after) - step) <= 0.01 * step))
    band = 0.5 / step
    note = f"{record.size} rows are averaged over {k} rows each: {after.size} rows, a band of {band:.3g} Hz"
    return replace(record, time=after, channels=channels, step=step, uniform=even, notes=(*record.notes, note))


def _means(values: np.ndarray) -> np.ndarray:
    """Mean (m,) of the known values of each block (m, k); NaN where less than half of a block is known."""
    known = np.isfinite(values)
    number = known.sum(axis=1)
    total = np.where(known, values, 0.0).sum(axis=1)
    return np.where(2 * number >= values.shape[1], total / np.maximum(number, 1), np.nan)


def noise_of_means(noise: Mapping[str, Noise], k: int) -> dict[str, Noise]:
    """Noise of each channel after the mean over k rows."""
    out = {}
    for channel, one in noise.items():
        c, white = one.spectrum
        spread = k * (1.0 - c**2) - 2.0 * c * (1.0 - c**k)
        parts = [white / k, (1.0 - white) * spread / (k * (1.0 - c)) ** 2]
        factor = float(np.sqrt(sum(parts)))
        spectrum = NoiseSpectrum(c * (1.0 - c**k) ** 2 / spread, parts[0] / sum(parts))
        inner = None if one.without_quantisation is None else factor * one.without_quantisation
        # A mean of quantised values is no longer on their grid.
        out[channel] = replace(
            one,
            value=factor * one.value,
            spectrum=spectrum,
            quantisation_step=None,
            without_quantisation=inner,
        )
    return out
