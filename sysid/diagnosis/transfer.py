"""Transfer of an effect to other records: the amplitude with which it acts there, and its significance.

With r- the residual (n,) of the model without the effect, r that with it, and d = r- - r the change by the effect, all
clipped at the corner of the loss,

    a = sum r- d / sum d^2

is 1 where the effect acts as it was fitted, and 0 where it does not act. Its variance follows from the sums of
u d, u = r- - a d, within blocks of time. The blocks are twice as long as the integrated autocorrelation time of u, so
that errors in different blocks are independent:

    var a = k / (k - 1) sum over blocks of (sum u d)^2 / (sum d^2)^2
    k = (sum D)^2 / sum D^2,    D = sum of d^2 in a block

An effect that acts during a few events has a small effective number of blocks k, whatever the number of samples. The
significance z is the normal deviate of Student's t = a / sd with k - 1 degrees of freedom.
"""

from dataclasses import dataclass

import numpy as np

from sysid.estimation.least_squares import robust_scale
from sysid.estimation.misfit import LOSS_CORNER

CORRELATION_TIMES = 2.0
"""Length of a block, in autocorrelation times."""

FEWEST_BLOCKS = 8
"""Blocks of each record and channel, at least: a drift over the whole record has no correlation time within it."""

UNCORRELATED = 0.05
"""Autocorrelation at which the sum that gives the autocorrelation time ends."""

LARGEST = 37.0
"""Largest significance: beyond it the probability is zero in floating-point numbers."""


@dataclass(frozen=True)
class Transfer:
    """Transfer of an effect."""

    amplitude: float = 0.0  # a, over the fitted one
    z: float = 0.0  # significance, a normal deviate
    blocks: float = 0.0  # effective number of independent blocks

    @property
    def p_value(self) -> float:
        """One-sided p value of the amplitude."""
        from scipy.special import ndtr

        return float(ndtr(-self.z))


def transfer(worse: np.ndarray, better: np.ndarray, block: np.ndarray) -> Transfer:
    """Transfer of the effect that distinguishes two models.

    Args:
        worse: residual of the model without it, in standard deviations, (n,).
        better: residual of the model with it, (n,).
        block: numbers of blocks of time, (n,), that do not decrease within a record and channel.
    """
    # Fewer samples than blocks show no correlation time: nothing can be tested.
    if worse.size < FEWEST_BLOCKS or not (np.isfinite(worse).all() and np.isfinite(better).all()):
        return Transfer()
    corner = LOSS_CORNER * max(1.0, robust_scale(better))
    without, with_it = np.clip(worse, -corner, corner), np.clip(better, -corner, corner)
    change = without - with_it
    square = float(change @ change)
    if square <= 0.0:
        return Transfer()
    amplitude = float(without @ change) / square
    rest = without - amplitude * change
    number = _blocks(rest, block)
    sums, weights = np.bincount(number, rest * change), np.bincount(number, change**2)
    count = square**2 / float(weights @ weights)
    if count <= 1.0 + 1e-9:
        return Transfer(amplitude, 0.0, count)
    deviation = np.sqrt(count / (count - 1.0) * float(sums @ sums)) / square
    return Transfer(amplitude, _normal_deviate(amplitude, deviation, count - 1.0), count)


def _normal_deviate(amplitude: float, deviation: float, degrees: float) -> float:
    from scipy.special import ndtri, stdtr

    if deviation <= 0.0:
        return float(np.sign(amplitude)) * LARGEST
    probability = float(stdtr(degrees, -abs(amplitude) / deviation))
    size = LARGEST if probability <= 0.0 else min(float(-ndtri(probability)), LARGEST)
    return float(np.sign(amplitude)) * size


def _blocks(rest: np.ndarray, block: np.ndarray) -> np.ndarray:
    """Number (n,) of the independent block of each sample, from the autocorrelation of `rest` (n,)."""
    ends = np.flatnonzero(np.diff(block) < 0) + 1
    out, start = np.empty(rest.size, dtype=int), 0
    for piece in np.split(np.arange(rest.size), ends):
        records = int(block[piece[-1]]) - int(block[piece[0]])
        longest = max(1, piece.size // max(FEWEST_BLOCKS, records // 3))
        length = min(longest, int(np.ceil(CORRELATION_TIMES * correlation_time(rest[piece]))))
        number = np.arange(piece.size) // max(length, 1)
        out[piece] = start + number
        start += int(number[-1]) + 1
    return out


def correlation_time(signal: np.ndarray) -> float:
    """Integrated autocorrelation time of a signal (n,), in samples: 1 for white noise."""
    centred = signal - signal.mean()
    length = 1 << (2 * signal.size - 1).bit_length()
    power = np.abs(np.fft.rfft(centred, length)) ** 2
    correlation = np.fft.irfft(power, length)[: max(signal.size // 2, 1)]
    if correlation[0] <= 0.0:
        return 1.0
    correlation = correlation / correlation[0]
    below = np.flatnonzero(correlation < UNCORRELATED)
    last = int(below[0]) if below.size else correlation.size
    return 1.0 + 2.0 * float(correlation[1:last].sum())
