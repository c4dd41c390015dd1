"""Residuals of a model in standard deviations of the noise, and their size: by channel, by block of time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.force_balance.stick_phases import STICK_DISPLACEMENT
from sysid.prediction.model import Model, predict
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.sensors import residual_noise
from sysid.signals.trimmed_rms import trimmed_rms

LEAST_AT_REST = 200
"""Scored samples in stick phases from which presliding displacements count in the misfit."""

LOSS_CORNER = 4.0
"""Corner of the Huber loss by which models are ranked, in standard deviations of the noise."""


def huber_square(residual: np.ndarray) -> np.ndarray:
    """Twice Huber's loss (n,) of a residual in standard deviations: its square up to `LOSS_CORNER`, linear beyond."""
    size = np.abs(residual)
    inner = np.minimum(size, LOSS_CORNER)
    return inner**2 + 2.0 * LOSS_CORNER * (size - inner)


@dataclass(frozen=True)
class ChannelMisfit:
    """Residual of one channel of one set of records.

    Args:
        rms: over all scored samples, in the channel's unit.
        over_noise: trimmed rms over the noise of the residual after the same filter (1 for noise alone); the same
            ratio for the presliding displacements in stick phases, if it is larger.
        fit_percent: 100 (1 - |residual| / |measured - mean|); in a free motion over the force of the inertia.
        size: scored samples.
    """

    rms: float
    over_noise: float
    fit_percent: float
    size: int


def dominated_by_few_samples(before: ChannelMisfit, after: ChannelMisfit) -> bool:
    """Whether the plain rms shows too small a reduction compared with the trimmed rms, since few samples at
    reversals dominate it."""
    return after.rms * before.over_noise > 2.0 * after.over_noise * before.rms


PRESLIDING_TIMING = 0.1
"""Part of the timing uncertainty that remains with presliding under imposed motion, where the force is continuous."""


def channel_noise(model: Model, record: PreparedRecord, channel: str) -> float:
    """Standard deviation that sensor noise leaves in the residual of one channel of a model.

    Where the velocity of an imposed motion comes from a noisy position, the friction that changes with it is uncertain.
    """
    if not isinstance(record, ForceBalanceRecord) or channel != record.force_channel:
        return record.scored[channel].noise
    noise = residual_noise(record, model.effects, model.values)
    if record.velocity_sign is None or record.prefiltered_noise == 0.0:
        return noise
    velocity = record.axis.velocity
    # In the direction of motion, so that a mirrored record has the same noise.
    axis = record.axis._replace(velocity=velocity + np.sign(velocity) * record.velocity_noise)
    change = predict(replace(record, axis=axis), model.effects, model.values)[channel]
    change = change - predict(record, model.effects, model.values)[channel]
    return float(np.hypot(noise, np.sqrt(np.mean(change[record.valid[channel]] ** 2))))


def sample_std(
    record: PreparedRecord, predicted: Mapping[str, np.ndarray], channel: str, noise: float, timing: float = 1.0
) -> np.ndarray:
    """Standard deviation (n,) of a residual, hypot(sensor noise, timing uncertainty x slope of the prediction).

    `timing` is the part of the record's timing uncertainty that applies to the model.
    """
    if record.timing_uncertainty == 0.0 or channel == STICK_DISPLACEMENT:
        return np.full(record.size, noise)
    steep = np.gradient(predicted[channel], record.step)
    return np.hypot(noise, timing * record.timing_uncertainty * np.abs(steep))


def misfit(model: Model, records: Sequence[PreparedRecord]) -> dict[str, ChannelMisfit]:
    """Misfit of a model on records, by channel."""
    residuals: dict[str, list[np.ndarray]] = {}
    scaled: dict[str, list[np.ndarray]] = {}
    measured: dict[str, list[np.ndarray]] = {}
    presliding: dict[str, list[np.ndarray]] = {}
    for record in records:
        predicted = predict(record, model.effects, model.values)
        for channel in record.measured:
            ok = record.valid[channel]
            r = record.measured[channel] - predicted[channel]
            if f"rig.offset_{channel}" in model.values:
                # The zero of a sensor and the state of a piezo at the start differ between records.
                r = r - np.median(r[ok])
            residuals.setdefault(channel, []).append(r[ok])
            compared = ok & ~held_by_measured_force(record, channel, r, model.values)
            kept = r[compared if compared.any() else ok]
            scaled.setdefault(channel, []).append(kept / channel_noise(model, record, channel))
            y = record.measured[channel][ok]
            reference = y - y.mean()
            if isinstance(record, ForceBalanceRecord) and record.is_free:
                reference = record.force[ok]
            measured.setdefault(channel, []).append(reference)
        if record.stick_phases is not None:
            # Presliding displacements in stick phases count as a misfit of the position.
            ok = record.stick_phases.scored
            channel = "position" if "position" in record.measured else record.force_channel
            presliding.setdefault(channel, []).append(
                (record.stick_phases.displacement - predicted[STICK_DISPLACEMENT])[ok] / record.stick_phases.noise
            )
    out = {}
    for channel, parts in residuals.items():
        r, y = np.concatenate(parts), np.concatenate(measured[channel])
        norm = float(np.linalg.norm(y))
        over = trimmed_rms(np.concatenate(scaled[channel]))
        at_rest = np.concatenate(presliding.get(channel, [np.empty(0)]))
        if at_rest.size >= LEAST_AT_REST:
            over = max(over, trimmed_rms(at_rest))
        out[channel] = ChannelMisfit(
            rms=float(np.sqrt(np.mean(r**2))),
            over_noise=over,
            fit_percent=100.0 * (1.0 - float(np.linalg.norm(r)) / norm) if norm > 0 else float("nan"),
            size=r.size,
        )
    return out


HELD = 1e-3
"""Part of the noise within which a force is that of the measurement."""


def held_by_measured_force(
    record: PreparedRecord, channel: str, residual: np.ndarray, values: Mapping[str, float]
) -> np.ndarray:
    """Samples (n,) at which friction holds the body of a driven mass against the measured force.

    There the model's friction is the measured force less the inertia, whose noise cancels: the residual is the noise of
    the inertia alone, and no comparison.
    """
    if record.acceleration is None or channel != record.force_channel:
        return np.zeros(record.size, dtype=bool)
    inertia = values["rig.mass"] * record.acceleration
    if channel == "position":
        inertia = -inertia / values["rig.pull_stiffness"]
    return np.abs(residual + inertia) <= HELD * record.noise[channel]


def worst_over_noise(fit: dict[str, ChannelMisfit], validate: dict[str, ChannelMisfit]) -> float:
    """Largest normalised residual of any channel, on the records of the fit or the held-out ones."""
    return max((m.over_noise for m in (*fit.values(), *validate.values())), default=1.0)


@dataclass(frozen=True)
class ResidualWeights:
    """Standard deviations (n,) and indices of the scored samples (k,), by record and channel.

    Computed from one model and used for others, so that their residuals are comparable.
    """

    std: tuple[dict[str, np.ndarray], ...]
    samples: tuple[dict[str, np.ndarray], ...]

    @cached_property
    def scored_std(self) -> tuple[dict[str, np.ndarray], ...]:
        """The standard deviations at the scored samples, (k,)."""
        return tuple(
            {channel: std[channel][index] for channel, index in samples.items()}
            for std, samples in zip(self.std, self.samples, strict=True)
        )


def residual_weights(model: Model, records: Sequence[PreparedRecord], thin: bool = True) -> ResidualWeights:
    """Standard deviations along a model's prediction, and the scored samples.

    A filtered record is reduced to one sample per filter width, since neighbouring samples are correlated.
    """
    std, samples = [], []
    for record in records:
        predicted = predict(record, model.effects, model.values)
        scored = record.scored
        presliding = record.stick_fraction is None and any(e.has_presliding for e in model.effects)
        timing = PRESLIDING_TIMING if presliding else 1.0
        std.append({c: sample_std(record, predicted, c, channel_noise(model, record, c), timing) for c in scored})
        every = max(1, int(record.filter_width / record.step)) if thin else 1
        samples.append({channel: np.flatnonzero(valid)[::every] for channel, (_, valid, _) in scored.items()})
    return ResidualWeights(tuple(std), tuple(samples))


def weighted_residual(
    model: Model, records: Sequence[PreparedRecord], weights: ResidualWeights, values: Mapping[str, float] | None = None
) -> np.ndarray:
    """Residual over its standard deviation at the scored samples, all channels of all records concatenated, (n,)."""
    values = model.values if values is None else values
    parts = []
    for record, scales, samples in zip(records, weights.scored_std, weights.samples, strict=True):
        predicted = predict(record, model.effects, values, samples)
        scored = record.scored
        for channel, pick in samples.items():
            parts.append((scored[channel][0][pick] - predicted[channel]) / scales[channel])
    return np.concatenate(parts) if parts else np.empty(0)


def blocks(records: Sequence[PreparedRecord], weights: ResidualWeights, per_record: int = 24) -> np.ndarray:
    """Number (n,) of the block of time of each scored sample, the same for all channels of a record."""
    parts, start = [], 0
    for record, samples in zip(records, weights.samples, strict=True):
        for pick in samples.values():
            parts.append(start + (pick * per_record) // record.size)
        start += per_record
    return np.concatenate(parts) if parts else np.empty(0, dtype=int)
