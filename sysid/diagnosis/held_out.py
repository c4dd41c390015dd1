"""Held-out loss of a fitted model, and the comparison of two models by blocks of time.

The loss is the mean Huber square of the residual in standard deviations. The values of linear parameters are uncertain,
and a held-out record of another kind may require others: for every model alike the amplitudes are estimated again on
the held-out records, with the information of the records of the fit as the prior. With r the residual (n,), J its
sensitivities to the amplitudes (n, p), w robust weights, s^2 the variance of r (at least 1), and A the information of
the fit (p, p),

    r' = r - J (J^T w J / s^2 + A)^-1 J^T w r / s^2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from sysid.diagnosis.transfer import Transfer, transfer
from sysid.estimation.fit import FittedModel, residual_function
from sysid.estimation.least_squares import huber_weights, jacobian, robust_scale
from sysid.estimation.misfit import ResidualWeights, blocks, huber_square
from sysid.prediction.force_balance.force_noise import residual_noise
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import Model
from sysid.prediction.prepared_record import PreparedRecord
from sysid.signals.trimmed_rms import trimmed_rms

LINEAR_ROLES = ("amplitude", "level")
"""Roles of the parameters in which a force is linear."""

OFFSET_KEYS = "rig.offset_"
"""Keys of the offsets of measured channels, which are estimated on the held-out records alone: the zero of a sensor and
the state of a piezo at the start of a record differ between records."""


@dataclass(frozen=True)
class Gain:
    """Reduction of the held-out loss by a better model: of the mean loss, and the transfer of what it adds."""

    loss: float
    transfer: Transfer

    @property
    def z(self) -> float:
        """Significance, a normal deviate."""
        return self.transfer.z

    @property
    def p_value(self) -> float:
        """One-sided p value."""
        return self.transfer.p_value


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

    def gain_of(self, better: HeldOut) -> Gain:
        """Reduction of the loss by another model of the same samples."""
        return Gain(self.loss - better.loss, transfer(self.residual, better.residual, self.block))


def held_out(
    fitted: FittedModel, records: Sequence[PreparedRecord], weights: ResidualWeights, stated: Model | None = None
) -> HeldOut:
    """Residual of a fitted model on held-out records, with its amplitudes estimated again there.

    The residual of a driven mass contains the noise of mass times acceleration. An effect that attenuates it, as
    a heavily damped mode does, would lower the loss where nothing is missing: its residual is expressed in its own
    standard deviation, if that is smaller than that of the `stated` model.
    """
    residual, block = _refitted(fitted, records, weights)
    return HeldOut(
        residual if stated is None else residual * _attenuation(fitted.model, stated, records, weights), block
    )


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
    free = [u for u in model.unknowns if u.key in linear_keys(model) and u.key not in fitted.fit.at_bound]
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


def linear_keys(model: Model) -> set[str]:
    """Keys of the unknowns in which the prediction is nearly linear: amplitudes, levels and the rig's own values."""
    roles = {f"{e.name}.{p.name}": p.role for e in model.effects for p in e.parameters}
    return {u.key for u in model.unknowns if roles.get(u.key, "amplitude") in LINEAR_ROLES}
