"""Held-out loss of a fitted model, and the comparison of two models by blocks of time.

The loss is the mean Huber square of the residual in standard deviations. The values of linear parameters are uncertain,
and a held-out record of another kind may require others: for every model alike the amplitudes are estimated again on
the held-out records, with the information of the records of the fit as the prior. With r the residual (n,), J its
sensitivities to the amplitudes (n, p), w robust weights, s^2 the variance of r (at least 1), and A the information of
the fit (p, p),

    r' = r - J (J^T w J / s^2 + A)^-1 J^T w r / s^2.

Transfer of an effect to other records is the amplitude with which it acts there, and its significance. With r- the
residual (n,) of the model without the effect, r that with it, and d = r- - r the change by the effect, all clipped at
the corner of the loss,

    a = sum r- d / sum d^2

is 1 where the effect acts as it was fitted, and 0 where it does not act. Its variance follows from the sums of
u d, u = r- - a d, within blocks of time. The blocks are twice as long as the integrated autocorrelation time of u, so
that errors in different blocks are independent:

    var a = k / (k - 1) sum over blocks of (sum u d)^2 / (sum d^2)^2
    k = (sum D)^2 / sum D^2,    D = sum of d^2 in a block

An effect that acts during a few events has a small effective number of blocks k, whatever the number of samples. The
significance z is the normal deviate of Student's t = a / sd with k - 1 degrees of freedom.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from sysid.estimation.fit import FittedModel, residual_function
from sysid.estimation.least_squares import huber_weights, jacobian, robust_scale
from sysid.estimation.misfit import LOSS_CORNER, ResidualWeights, blocks, huber_square
from sysid.prediction.force_balance.predict import residual_noise
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import Model
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.problem import PARTS
from sysid.signals import trimmed_rms

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
    """Transfer of an effect to other records, and what it gains there."""

    amplitude: float = 0.0  # a, over the fitted one
    z: float = 0.0  # significance, a normal deviate
    blocks: float = 0.0  # effective number of independent blocks
    loss: float = 0.0  # reduction of the mean loss

    @property
    def p_value(self) -> float:
        """One-sided p value of the amplitude."""
        from scipy.special import ndtr

        return float(ndtr(-self.z))

    @property
    def z_of_half(self) -> float:
        """Significance of half the amplitude with the same standard deviation: that of t / 2. It is half of z for many
        blocks, and more for few, of which even the largest t has a small normal deviate."""
        from scipy.special import stdtrit

        if not 0.0 < self.z < LARGEST:
            return self.z
        t = -float(stdtrit(self.blocks - 1.0, self.p_value))
        return _normal_deviate(0.5 * t, 1.0, self.blocks - 1.0)


def transfer(worse: np.ndarray, better: np.ndarray, block: np.ndarray) -> Transfer:
    """Transfer of the effect that distinguishes two models, by their residuals (n,) in standard deviations, and numbers
    of blocks of time, (n,), that do not decrease within a record and channel."""
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


LINEAR_ROLES = ("amplitude", "level")
"""Roles of the parameters in which a force is linear."""

OFFSET_KEYS = "rig.offset_"
"""Keys of the offsets of measured channels, which are estimated on the held-out records alone: the zero of a sensor and
the state of a piezo at the start of a record differ between records."""


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Residual of a model on the held-out records."""

    residual: np.ndarray  # in standard deviations, (n,)
    block: np.ndarray  # number of the block of time of each sample, (n,)

    @cached_property
    def loss(self) -> float:
        """Mean Huber square; infinite where the prediction is not finite."""
        if not np.isfinite(self.residual).all():
            return float("inf")
        return float(np.mean(huber_square(self.residual))) if self.residual.size else float("nan")

    def at(self, rows: np.ndarray) -> HeldOut:
        """The residual of some of the samples, (n,) true or false."""
        return HeldOut(self.residual[rows], self.block[rows])

    def gain_of(self, better: HeldOut) -> Transfer:
        """What another model of the same samples gains."""
        found = transfer(self.residual, better.residual, self.block)
        return replace(found, loss=self.loss - better.loss)


def held_out(
    fitted: FittedModel, records: Sequence[PreparedRecord], weights: ResidualWeights, stated: Model | None = None
) -> HeldOut:
    """Residual of a fitted model on held-out records, with its amplitudes estimated again there.

    The residual of a driven mass contains the noise of mass times acceleration. An effect that attenuates it, as
    a heavily damped mode does, would lower the loss where nothing is missing: its residual is expressed in its own
    standard deviation, if that is smaller than that of the `stated` model. Where the weights are those of the fit, the
    records are its own: parts of them are left out in turn.
    """
    crossed = fitted.weights is weights
    residual, block = _left_out(fitted, records) if crossed else _refitted(fitted, records, weights)
    return HeldOut(
        residual if stated is None else residual * _attenuation(fitted.model, stated, records, weights), block
    )


def _left_out(fitted: FittedModel, records: Sequence[PreparedRecord]) -> tuple[np.ndarray, np.ndarray]:
    """Residual in standard deviations and number of the part, each (n,), each part left out of the fit in turn.

    With the information A of the whole fit, the residual of the rows B of a part without it is, for a linear model,
    (I - J_B A^-1 J_B^T w_B)^-1 r_B (R. D. Cook and S. Weisberg, Residuals and influence in regression, 1982, 2.2).
    """
    fit, number = fitted.fit, blocks(records, fitted.weights, PARTS)
    moves = np.array([key not in fit.at_bound for key in fit.keys], dtype=bool)
    columns, precision = fit.jacobian[:, moves], fit.precision[moves]
    lengths = np.sqrt(np.maximum((fit.weights[:, None] * columns**2).sum(axis=0) + precision, 1e-300))
    columns = columns / lengths
    normal = columns.T @ (fit.weights[:, None] * columns) + np.diag(precision / lengths**2)
    inverse, out = np.linalg.pinv(normal, rcond=1e-12, hermitian=True), fit.residual.copy()
    for part in np.unique(number):
        rows = number == part
        influence = columns[rows] @ inverse @ (columns[rows] * fit.weights[rows, None]).T
        out[rows] = np.linalg.lstsq(np.eye(influence.shape[0]) - influence, fit.residual[rows], rcond=None)[0]
    return out, number


def _attenuation(
    model: Model, stated: Model, records: Sequence[PreparedRecord], weights: ResidualWeights
) -> np.ndarray | float:
    """Noise of the residual of the stated model over that of another one, (n,), at least 1."""
    if not any(effect.signal is not None for effect in model.effects):
        return 1.0
    parts = []
    for record, samples in zip(records, weights.samples, strict=True):
        for channel, pick in samples.items():
            ratio = 1.0
            if isinstance(record, ForceBalanceRecord) and channel == record.force_channel:
                before, after = (residual_noise(record, m.effects, m.values) for m in (stated, model))
                ratio = max(1.0, before / after)
            parts.append(np.full(pick.size, ratio))
    return np.concatenate(parts) if parts else 1.0


def _refitted(
    fitted: FittedModel, records: Sequence[PreparedRecord], weights: ResidualWeights
) -> tuple[np.ndarray, np.ndarray]:
    """Residual in standard deviations and number of the block, each (n,), with the amplitudes estimated again."""
    model = fitted.model
    residual = residual_function(model, records, weights)
    roles = {f"{e.name}.{p.name}": p.role for e in model.effects for p in e.parameters}
    # In amplitudes, levels and the rig's own values the prediction is nearly linear.
    linear = [u for u in model.unknowns if roles.get(u.key, "amplitude") in LINEAR_ROLES]
    free = [u for u in linear if u.key not in fitted.fit.at_bound]
    base = residual(np.array([model.values[u.key] for u in model.unknowns]))
    number = blocks(records, weights)
    if not free or not np.isfinite(base).all():
        return base, number
    part = residual_function(replace(model, unknowns=tuple(free)), records, weights)
    columns = jacobian(part, np.array([model.values[u.key] for u in free]), base, free)
    places = [fitted.fit.keys.index(u.key) for u in free]
    own = fitted.fit.jacobian[:, places]
    fit_scale = max(robust_scale(fitted.fit.residual), 1.0)
    information = (own.T @ (fitted.fit.weights[:, None] * own) + np.diag(fitted.fit.precision[places])) / fit_scale**2
    new = np.array([u.key.startswith(OFFSET_KEYS) for u in free])
    information[new | new[:, None]] = 0.0
    scale = max(robust_scale(base), 1.0)
    weighted = huber_weights(base, scale)[:, None] * columns / scale**2
    normal, right = columns.T @ weighted + information, weighted.T @ base
    lengths = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    scaled = normal / np.outer(lengths, lengths)
    if not np.isfinite(scaled).all():
        # A channel that never changes: its residual has no scale.
        return base, number
    step = np.linalg.pinv(scaled, rcond=1e-12, hermitian=True) @ (right / lengths)
    refitted = base - columns @ (step / lengths)
    return refitted if np.isfinite(refitted).all() else base, number


def evenness(residual: np.ndarray, block: np.ndarray) -> float:
    """Median over mean of the variances of a residual (n,) in the blocks of time numbered `block` (n,).

    About 1 for stationary noise of any level; small where the residual is large in less than half of the blocks. The
    trimmed variance leaves out single samples.
    """
    order = np.argsort(block, kind="stable")
    parts = np.split(residual[order], np.flatnonzero(np.diff(block[order])) + 1)
    variances = [trimmed_rms(part) ** 2 for part in parts if part.size]
    mean = float(np.mean(variances)) if variances else 0.0
    return float(np.median(variances)) / mean if mean > 0.0 else 1.0
