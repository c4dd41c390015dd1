"""Signals in rows: Gaussian filters with their noise, masks and runs of rows, root mean square without outliers."""

from functools import cached_property
from typing import NamedTuple

import numpy as np

from sim.numerics.compilation import SUMS_IN_ANY_ORDER, compiled

CUT = 8.0
"""Half-length of the kernel in standard deviations. At 4 the truncation error of the second derivative exceeds the
noise."""

BAND = 0.1325
"""Half-power frequency of a Gaussian filter times its width: sqrt(ln 2) / (2 pi)."""

CUT_SMOOTHING = 6.0
"""Half-length for smoothing at selected samples, in standard deviations: the weight of the truncated part is 2e-9."""


class NoiseSpectrum(NamedTuple):
    """Spectrum of noise of unit variance: a `white` part of the variance, and a first-order autoregression with this
    `correlation` of neighbouring samples; or of the mean of each sample and the one before, where `averaged`."""

    correlation: float = 0.0
    white: float = 1.0
    averaged: bool = False

    def power(self, angle: np.ndarray) -> np.ndarray:
        """Power density (k,), 1 for white noise; `angle` per sample, rad."""
        c = self.correlation
        power = self.white + (1.0 - self.white) * (1.0 - c**2) / (1.0 - 2.0 * c * np.cos(angle) + c**2)
        return power * np.cos(0.5 * angle) ** 2 if self.averaged else power

    def drawn(self, size: int, random: np.random.Generator) -> np.ndarray:
        """Noise (size,) of unit variance with this spectrum."""
        white = random.standard_normal(size)
        if self.correlation == 0.0:
            return white
        from scipy.signal import lfilter

        c, first = self.correlation, random.standard_normal()
        driven = np.sqrt(1.0 - c**2) * random.standard_normal(size)
        coloured = lfilter([1.0], [1.0, -c], driven, zi=np.array([c * first]))[0]
        return np.sqrt(self.white) * white + np.sqrt(1.0 - self.white) * np.asarray(coloured)


WHITE = NoiseSpectrum()


@compiled(fastmath=SUMS_IN_ANY_ORDER)
def _smoothed_at(signal: np.ndarray, kernel: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Convolution of a signal (n,) with a symmetric kernel (2 h + 1,) at the samples `index` (k,); odd reflection at
    the ends."""
    n, size = signal.size, kernel.size
    out = np.empty(index.size)
    for j in range(index.size):
        start = index[j] - size // 2
        total = 0.0
        if start >= 0 and start + size <= n:
            part = signal[start : start + size]
            for k in range(size):
                total += kernel[k] * part[k]
        else:
            for k in range(size):
                i = start + k
                if i < 0:
                    total += kernel[k] * (2.0 * signal[0] - signal[-i])
                elif i >= n:
                    total += kernel[k] * (2.0 * signal[n - 1] - signal[2 * n - 2 - i])
                else:
                    total += kernel[k] * signal[i]
        out[j] = total
    return out


class GaussianFilter:
    """Convolution with a Gaussian of standard deviation `width` (s), or its first or second derivative.

    The ends are continued by odd reflection; within `margin` samples of them the result depends on that extrapolation.
    A `width` of zero returns signals unchanged.
    """

    def __init__(self, width: float, step: float, size: int) -> None:
        self.width = width
        self.step = step
        self.size = size
        self.half = min(int(np.ceil(CUT * width / step)), size - 1) if width > 0 else 0
        self.margin = int(np.ceil(3.0 * width / step)) if width > 0 else 0
        length = size + 4 * self.half
        self._length = 1 << max(1, (length - 1).bit_length())
        self._spectra: dict[int, np.ndarray] = {}

    def kernel(self, order: int = 0) -> np.ndarray:
        """Kernel (2 half + 1,) of the derivative of `order` 0, 1 or 2; exact for polynomials up to that order."""
        if self.half == 0:
            if order:
                raise ValueError("a derivative needs a width above zero")
            return np.ones(1)
        t = np.arange(-self.half, self.half + 1) * self.step
        gauss = np.exp(-0.5 * (t / self.width) ** 2)
        gauss /= gauss.sum()
        if order == 0:
            return gauss
        if order == 1:
            first = t * gauss
            return first / (first * t).sum()
        second = (t**2 / self.width**4 - 1.0 / self.width**2) * gauss
        second -= second.sum() * gauss
        return second / (0.5 * (second * t**2).sum())

    def __call__(self, signal: np.ndarray, order: int = 0) -> np.ndarray:
        """Smoothed (or differentiated) signal, (n,) -> (n,)."""
        if self.half == 0 and order == 0:
            return signal
        if order not in self._spectra:
            # Convolution, not correlation, which would change the sign for an odd kernel.
            kernel = self.kernel(order)
            if order == 1:
                kernel = -kernel
            self._spectra[order] = np.fft.rfft(kernel, self._length)
        h = self.half
        padded = np.concatenate([2.0 * signal[0] - signal[h:0:-1], signal, 2.0 * signal[-1] - signal[-2 : -h - 2 : -1]])
        full = np.fft.irfft(np.fft.rfft(padded, self._length) * self._spectra[order], self._length)
        return full[2 * h : 2 * h + self.size]

    @cached_property
    def _short_kernel(self) -> np.ndarray:
        reach = min(int(np.ceil(CUT_SMOOTHING * self.width / self.step)), self.half)
        kernel = self.kernel()[self.half - reach : self.half + reach + 1]
        return kernel / kernel.sum()

    def at(self, signal: np.ndarray, index: np.ndarray) -> np.ndarray:
        """Smoothed signal (n,) at the samples `index` (k,) only, in a tenth of the computing time."""
        if self.half == 0:
            return signal[index]
        return _smoothed_at(np.ascontiguousarray(signal, dtype=float), self._short_kernel, index)

    def noise_gain(self, order: int = 0, spectrum: NoiseSpectrum = WHITE) -> float:
        """Standard deviation of the output for noise of unit variance."""
        kernel = self.kernel(order)
        if spectrum == WHITE:
            return float(np.sqrt(np.sum(kernel**2)))
        # The grid resolves the autoregression's peak at frequency zero.
        length = 1 << int(max(2 * kernel.size - 1, 64.0 / (1.0 - spectrum.correlation))).bit_length()
        power = np.abs(np.fft.rfft(kernel, length)) ** 2
        weights = np.full(power.size, 2.0)
        weights[[0, -1]] = 1.0
        angle = np.linspace(0.0, np.pi, power.size)
        return float(np.sqrt(np.sum(power * spectrum.power(angle) * weights) / length))


def runs(mask: np.ndarray) -> list[tuple[int, int]]:
    """Half-open index ranges in which `mask` (n,) is true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def longer_than(mask: np.ndarray, length: float) -> np.ndarray:
    """`mask` (n,) without its runs of at most `length` samples."""
    out = np.zeros_like(mask)
    for start, stop in runs(mask):
        if stop - start > length:
            out[start:stop] = True
    return out


def dilated(mask: np.ndarray, reach: int) -> np.ndarray:
    """`mask` (n,) extended by `reach` samples on both sides."""
    if reach <= 0 or not mask.any():
        return mask.copy()
    out = mask.copy()
    for start, stop in runs(mask):
        out[max(0, start - reach) : stop + reach] = True
    return out


def filled(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """`values` (n,) with gaps interpolated linearly, and the mask of the gaps."""
    gap = ~np.isfinite(values)
    if not gap.any():
        return values, gap
    if gap.all():
        return np.zeros_like(values), gap
    index = np.arange(values.size)
    bridged = values.copy()
    bridged[gap] = np.interp(index[gap], index[~gap], values[~gap])
    return bridged, gap


KEPT = 0.97
"""Share of samples in the trimmed rms; it leaves out single samples, such as those at jumps or beside a
reversal between two samples."""

_CORNER = 2.17009
"""Two-sided 97 % point of the normal distribution."""

TRIM_FACTOR = float(np.sqrt(1.0 - 2.0 * _CORNER * np.exp(-0.5 * _CORNER**2) / np.sqrt(2.0 * np.pi) / KEPT))
"""rms of a standard normal variable within its central 97 %."""


def trimmed_rms(residual: np.ndarray) -> float:
    """rms of the smallest 97 % of the samples (n,), over `TRIM_FACTOR`: the standard deviation of normal noise; NaN
    without samples."""
    if residual.size == 0:
        return float("nan")
    size = np.sort(np.abs(residual))
    kept = size[: max(1, int(np.ceil(KEPT * size.size)))]
    return float(np.sqrt(np.mean(kept**2))) / TRIM_FACTOR
