"""Least-squares periodogram of a residual over the position: pitches of a periodic effect worth a score test.

The peak of a pitch has a width of pitch^2 / range, so a grid over every pitch from the range of the position down to a
five-hundredth of it has thousands of points. With x the position, r the residual and e its change by the effect if it
were uniform (the effect with an infinite pitch),

    reduction(k) = max over a, b of |r|^2 - |r - e (a cos k x + b sin k x)|^2

follows at every wave number k from the Fourier transforms over x of the sums of r e and of e^2 (W. H. Press and
G. B. Rybicki, Astrophys. J. 338 (1989) 277; there with e = 1). The filter of a force balance is left out: it lowers the
amplitude, but moves no peak.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim.effects.effect import Effect, Parameter
from sysid.estimation.fit import FittedModel
from sysid.estimation.misfit import weighted_residual
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import Scales, size_of, with_effect
from sysid.prediction.prepared_record import PreparedRecord

PEAKS = 20
"""Largest number of pitches."""

OVERSAMPLING = 4
"""Wave numbers per width of a peak."""

CELLS = 8
"""Cells of the position per shortest pitch: the sums within a cell lose 5 % of its amplitude at most."""

LONG = 0.1
"""Pitch over the range of the position from which the grid of the effect has every pitch."""


def periodic_parameter(effect: Effect) -> Parameter | None:
    """The pitch of an effect that is periodic in the position; None for another effect."""
    return next((p for p in effect.parameters if p.scan is not None and p.scan.shortest > 0.0), None)


def pitches(
    base: FittedModel,
    effect: Effect,
    records: Sequence[PreparedRecord],
    scales: Scales,
    target: np.ndarray,
) -> list[float]:
    """Pitches at the peaks of the periodogram, m, largest reduction first; none where no position is scored."""
    pitch = periodic_parameter(effect)
    balances = [record for record in records if isinstance(record, ForceBalanceRecord)]
    if pitch is None or pitch.scan is None or len(balances) != len(records):
        return []
    position = np.concatenate(
        [r.axis.position[pick] for r, of in zip(balances, base.weights.samples, strict=True) for pick in of.values()]
    )
    uniform = _uniform_change(base, effect, records, scales, pitch)
    shortest = max(pitch.scan.shortest * scales.position, 2.0 * _usual_step(balances, base))
    if position.size != target.size or not uniform.any() or shortest >= LONG * scales.position:
        return []
    waves, reduction = _spectrum(position, uniform, target, shortest)
    peak = np.flatnonzero((reduction[1:-1] >= reduction[:-2]) & (reduction[1:-1] > reduction[2:])) + 1
    peak = peak[waves[peak] > 1.0 / (LONG * scales.position)]
    peak = peak[np.argsort(-reduction[peak])[:PEAKS]]
    return (1.0 / waves[peak]).tolist()


def _uniform_change(
    base: FittedModel, effect: Effect, records: Sequence[PreparedRecord], scales: Scales, pitch: Parameter
) -> np.ndarray:
    """Change (n,) of the residual by the effect at the same phase everywhere."""
    amplitude, phase = (next(p for p in effect.parameters if p.role == role) for role in ("amplitude", "phase"))
    start = with_effect(base.model, effect, scales)
    moved = {
        f"{effect.name}.{pitch.name}": 1e6 * scales.position,
        f"{effect.name}.{phase.name}": 0.5 * np.pi,
        f"{effect.name}.{amplitude.name}": 1e-3 * size_of(amplitude, scales),
    }
    return base.fit.residual - weighted_residual(start, records, base.weights, {**start.values, **moved})


def _usual_step(records: Sequence[ForceBalanceRecord], base: FittedModel) -> float:
    """Median distance between scored samples in motion, m: shorter pitches alias."""
    steps = [
        np.abs(np.diff(record.axis.position[samples[record.force_channel]]))
        for record, samples in zip(records, base.weights.samples, strict=True)
    ]
    moved = np.concatenate(steps)
    return float(np.median(moved[moved > 0.0])) if moved.any() else np.inf


def _spectrum(
    position: np.ndarray, uniform: np.ndarray, target: np.ndarray, shortest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Wave numbers 1/pitch (k,) up to 1/shortest, and the reduction of the squared residual at each (k,)."""
    cells = int(np.ceil(CELLS * np.ptp(position) / shortest)) + 1
    place = np.rint((position - position.min()) / shortest * CELLS).astype(int)
    length = 1 << int(np.ceil(np.log2(OVERSAMPLING * cells)))
    linear = np.fft.rfft(np.bincount(place, target * uniform, cells), length)
    square = np.fft.rfft(np.bincount(place, uniform**2, cells), length)
    count = length // CELLS
    waves = np.arange(count) * CELLS / (length * shortest)
    # Normal equations of cosine and sine, from the transform of the squares at zero and at twice the wave number.
    twice = square[np.minimum(2 * np.arange(count), square.size - 1)]
    cc, ss, cs = 0.5 * (square[0].real + twice.real), 0.5 * (square[0].real - twice.real), -0.5 * twice.imag
    c, s = linear[:count].real, -linear[:count].imag
    determinant = cc * ss - cs**2
    usable = determinant > 1e-3 * square[0].real ** 2
    reduction = (c**2 * ss - 2.0 * c * s * cs + s**2 * cc) / np.where(usable, determinant, np.inf)
    return waves, reduction
