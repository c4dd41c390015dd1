"""Residuals of a model in standard deviations of the noise, and their size: by channel, by block of time."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from stagecad.processes import map_threads
from sysid.estimation.least_squares import HELD
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.force_balance.stick_phases import STICK_DISPLACEMENT
from sysid.prediction.model import Model, predict
from sysid.prediction.prepared_record import PreparedRecord
from sysid.signals import GaussianFilter, trimmed_rms

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
    """Residual of one channel of one set of records."""

    rms: float  # over all scored samples, in the channel's unit
    # trimmed rms over the noise of the residual after the same filter (1 for noise alone); the same ratio for the
    # presliding displacements in stick phases, if it is larger
    over_noise: float
    fit_percent: float  # 100 (1 - |residual| / |measured - mean|); in a free motion over the force of the inertia
    size: int  # scored samples
    # the trimmed rms over the noise of the channel's own sensor after the filter
    over_sensor_noise: float | None = None


def dominated_by_few_samples(before: ChannelMisfit, after: ChannelMisfit) -> bool:
    """Whether the plain rms shows too small a reduction compared with the trimmed rms, since few samples at
    reversals dominate it."""
    return after.rms * before.over_noise > 2.0 * after.over_noise * before.rms


PRESLIDING_TIMING = 0.1
"""Part of the timing uncertainty that remains with presliding under imposed motion, where the force is continuous."""

UNEVEN = 2.0
"""Ratio of the local to the usual variance of a change of the residual that is no error of the estimate."""

USUAL_TRIALS = 4
"""Passes in which the median is taken again without the rows whose variance was clearly above it, while half remain."""

LOCAL = 6.0
"""Width, in samples or in widths of the record's filter, over which the local variance is averaged."""

NORMAL_MEDIAN = 0.67449
"""Median size of a standard normal variable."""

FROM_HALF_WIDTH = (8.0 / 7.0) ** 2
"""Squared error by a filter over the squared change at half its width: the error grows with the cube of the width."""


def residual_std(
    model: Model, record: PreparedRecord, channel: str, predicted: Mapping[str, np.ndarray], timing: float = 1.0
) -> np.ndarray:
    """Standard deviation (n,) of the residual of a channel, where the model is true.

    Where a prediction uses the measured motion, sensor noise enters through the model too. Its effect is the change of
    the residual by noise of the same size, added to the log. The error by the filter of the motion is estimated from
    the change at half the width, less that by noise. Events are uncertain by the record's timing uncertainty, of which
    the part `timing` applies to the model, times the slope of the prediction.
    """
    noise = np.full(record.size, record.scored[channel].noise)
    if channel == STICK_DISPLACEMENT:
        return noise
    redrawn = record.redrawn
    if redrawn:
        residual = record.measured[channel] - predicted[channel]
        drawn = map_threads(lambda one: predict(one, model.effects, model.values)[channel], redrawn)
        change = np.array([one.measured[channel] - there - residual for one, there in zip(redrawn, drawn, strict=True)])
        own = _change_without_effects(model, record, channel)
        held = held_by_measured_force(record, channel, residual, model.values)
        variance = _variance_of_change(change, own, record, channel, record.valid[channel] & ~held)
        if isinstance(record, ForceBalanceRecord):
            halves = [at_half_width(model, one, channel) for one in (record, record.redrawn[0])]
            if halves[0] is not None and halves[1] is not None:
                blur = halves[0] - predicted[channel]
                by_noise = halves[1] - drawn[0] - blur
                whole, noisy = (_local_mean(part**2, record, channel) for part in (blur, by_noise))
                variance = variance + FROM_HALF_WIDTH * np.where(whole > UNEVEN * noisy, whole - noisy, 0.0)
            if channel == "position":
                variance = variance + _rounding_left(record)
        noise = np.sqrt(np.maximum(variance, (1e-3 * record.scored[channel].noise) ** 2))
    if record.timing_uncertainty > 0.0:
        noise = np.hypot(noise, timing * record.timing_uncertainty * np.gradient(predicted[channel], record.step))
    return noise


def _rounding_left(record: ForceBalanceRecord) -> np.ndarray:
    """Variance (n,) of the rounding by an encoder that a Gaussian filter leaves where the motion is slow, beside that
    of white noise: at the velocity v the error is a wave of the frequency v / step, which a width w attenuates by
    exp(-2 pi^2 (v w / step)^2)."""
    smooth, step = record.full_filter, record.encoder_step
    if step == 0.0 or smooth is None or smooth.width == 0.0:
        return np.zeros(record.size)
    left = np.exp(-((2.0 * np.pi * record.axis.velocity * smooth.width / step) ** 2))
    return step**2 / 12.0 * np.maximum(left - smooth.noise_gain() ** 2, 0.0)


def _change_without_effects(model: Model, record: PreparedRecord, channel: str) -> np.ndarray:
    """Changes (k, n) of the residual by k draws of noise, of the model without effects, whose noise is that of the
    record: of a driven mass it was computed with the mass and stiffness before any fit."""
    if not isinstance(record, ForceBalanceRecord) or record.acceleration is None:
        return np.array([one.measured[channel] - record.measured[channel] for one in record.redrawn])
    values = model.values | {"rig.mass": record.mass, "rig.pull_stiffness": record.pull_stiffness}
    values["rig.pull_damping"] = 0.0
    first, *others = [one.measured[channel] - predict(one, (), values)[channel] for one in (record, *record.redrawn)]
    return np.array(others) - first


def _variance_of_change(
    change: np.ndarray, own: np.ndarray, record: PreparedRecord, channel: str, compared: np.ndarray
) -> np.ndarray:
    """Variance (n,) of a residual from its `change` (k, n) by k draws of noise in the rows `compared` (n,), relative to
    that of the model without effects, `own` (k, n), whose variance is known: both share the error of a finite sample.
    """
    known = record.scored[channel].noise ** 2
    compared = compared if compared.any() else record.valid[channel]
    # At rest the prediction cancels the noise, which would lower the median.
    here, there = (_local_mean(np.mean(part**2, axis=0), record, channel) for part in (change, own))
    uncancelled = compared & (here >= there / UNEVEN)
    usual = compared = uncancelled if 2 * np.count_nonzero(uncancelled) >= np.count_nonzero(compared) else compared
    level, excess = 0.0, np.zeros(record.size)
    for _ in range(USUAL_TRIALS):
        size, reference = (float(np.median(np.abs(part[:, usual]))) ** 2 for part in (change, own))
        # A constant channel has no noise added.
        ratio = size / reference if reference > 0.0 else 0.0
        level = ratio * known if reference > 0.0 else size / NORMAL_MEDIAN**2
        excess = here - ratio * there
        # Where the prediction amplifies the noise its change is not the usual one, and would raise the median.
        quiet = compared & (excess <= (UNEVEN - 1.0) * level)
        if 2 * np.count_nonzero(quiet) < np.count_nonzero(compared) or np.array_equal(quiet, usual):
            break
        usual = quiet
    return level + np.where(excess > (UNEVEN - 1.0) * level, excess, 0.0)


def at_half_width(model: Model, record: ForceBalanceRecord, channel: str) -> np.ndarray | None:
    """Prediction (n,) along the motion filtered by half the width; none without a filter."""
    if record.half_width_variant is None:
        return None
    axis, rest = record.half_width_variant()
    return predict(replace(record, axis=axis, complementary_filter=rest), model.effects, model.values)[channel]


def _local_mean(square: np.ndarray, record: PreparedRecord, channel: str) -> np.ndarray:
    """Mean (n,) of the squares of a change over some samples on each side."""
    valid = record.valid[channel]
    width = min(LOCAL * max(record.step, record.filter_width), 0.01 * record.step * record.size)
    smooth = GaussianFilter(width, record.step, record.size)
    return np.maximum(smooth(np.where(valid, square, 0.0)) / np.maximum(smooth(valid.astype(float)), 0.1), 0.0)


def misfit(model: Model, records: Sequence[PreparedRecord]) -> dict[str, ChannelMisfit]:
    """Misfit of a model on records, by channel."""
    residuals, scaled, sensor, measured, at_rests = (defaultdict[str, list[np.ndarray]](list) for _ in range(5))
    for record in records:
        predicted = predict(record, model.effects, model.values)
        for channel in record.measured:
            ok = record.valid[channel]
            r = record.measured[channel] - predicted[channel]
            if f"rig.offset_{channel}" in model.values:
                # The zero of a sensor and the state of a piezo at the start differ between records.
                r = r - np.median(r[ok])
            residuals[channel].append(r[ok])
            compared = ok & ~held_by_measured_force(record, channel, r, model.values)
            kept = compared if compared.any() else ok
            std = residual_std(model, record, channel, predicted, timing=0.0)
            scaled[channel].append(r[kept] / std[kept])
            sensor[channel].append(r[kept] / record.noise[channel])
            y = record.measured[channel][ok]
            reference = y - y.mean()
            if isinstance(record, ForceBalanceRecord) and record.is_free:
                reference = record.force[ok]
            measured[channel].append(reference)
        if record.stick_phases is not None:
            # Presliding displacements in stick phases count as a misfit of the position.
            ok = record.stick_phases.scored
            channel = "position" if "position" in record.measured else record.force_channel
            moved = record.stick_phases.displacement - predicted[STICK_DISPLACEMENT]
            at_rests[channel].append(moved[ok] / record.stick_phases.noise)
    out = {}
    for channel, parts in residuals.items():
        r, y = np.concatenate(parts), np.concatenate(measured[channel])
        norm = float(np.linalg.norm(y))
        over = trimmed_rms(np.concatenate(scaled[channel]))
        at_rest = np.concatenate(at_rests.get(channel, [np.empty(0)]))
        if at_rest.size >= LEAST_AT_REST:
            over = max(over, trimmed_rms(at_rest))
        out[channel] = ChannelMisfit(
            rms=float(np.sqrt(np.mean(r**2))),
            over_noise=over,
            fit_percent=100.0 * (1.0 - float(np.linalg.norm(r)) / norm) if norm > 0 else float("nan"),
            size=r.size,
            over_sensor_noise=trimmed_rms(np.concatenate(sensor[channel])),
        )
    return out


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

    def scaled(self, ratio: Mapping[str, float]) -> "ResidualWeights":
        """The weights with the deviations of each channel multiplied by a ratio; of others unchanged."""
        return replace(self, std=tuple({c: std * ratio.get(c, 1.0) for c, std in one.items()} for one in self.std))


def shared_weights(one: ResidualWeights, other: ResidualWeights) -> ResidualWeights:
    """Weights by which two models are compared: at each sample the larger of their standard deviations, so that neither
    gains by a prediction that depends more on the noise."""
    pairs = zip(one.std, other.std, strict=True)
    return ResidualWeights(tuple({c: np.maximum(a[c], b[c]) for c in a} for a, b in pairs), one.samples)


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
        std.append({c: residual_std(model, record, c, predicted, timing) for c in scored})
        every = max(1, int(record.filter_width / record.step)) if thin else 1
        samples.append({c: np.ascontiguousarray(np.flatnonzero(ok)[::every]) for c, (_, ok, _) in scored.items()})
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


def scored_channels(weights: ResidualWeights) -> np.ndarray:
    """Channel (n,) of each scored sample; displacements at rest belong to the first channel of their record."""
    parts = []
    for samples in weights.samples:
        first = next((channel for channel in samples if channel != STICK_DISPLACEMENT), "")
        names = (first if channel == STICK_DISPLACEMENT else channel for channel in samples)
        parts += [np.full(pick.size, name) for name, pick in zip(names, samples.values(), strict=True)]
    return np.concatenate(parts) if parts else np.empty(0, dtype=str)


def blocks(
    records: Sequence[PreparedRecord], weights: ResidualWeights, per_record: int = 24, offset: float = 0.0
) -> np.ndarray:
    """Number (n,) of the block of time of each scored sample, the same for all channels of a record; `offset`, at least
    0 and below 1, of the edges of the blocks, in blocks."""
    parts, start = [], 0
    for record, samples in zip(records, weights.samples, strict=True):
        for pick in samples.values():
            parts.append(start + (pick * per_record / record.size + offset).astype(int))
        start += per_record + (offset > 0.0)
    return np.concatenate(parts) if parts else np.empty(0, dtype=int)
