"""How large a residual is, in the ways the loop needs: over the noise, for ranking, and block by block."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.force_balance.stick_phases import STICK_DISPLACEMENT
from sysid.prediction.model import Model, PreparedRecord, predict

KEPT = 0.97
"""Share of samples in the robust figure: a reversal between two samples is nobody's fault."""

_CORNER = 2.17009
"""Two-sided 97 % point of the normal distribution."""

TRIM_FACTOR = float(np.sqrt(1.0 - 2.0 * _CORNER * np.exp(-0.5 * _CORNER**2) / np.sqrt(2.0 * np.pi) / KEPT))
"""rms of a standard normal variable within its central 97 %."""

LEAST_AT_REST = 200
"""Samples at rest from which their displacements are a misfit of their own."""

LOSS_CORNER = 4.0
"""Deviations beyond which the ranking's loss grows with the size of a residual, not its square."""


def trimmed_rms(residual: np.ndarray) -> float:
    """rms over the best 97 % of samples, scaled so that normal noise of unit deviation gives 1."""
    if residual.size == 0:
        return float("nan")
    size = np.sort(np.abs(residual))
    kept = size[: max(1, int(np.ceil(KEPT * size.size)))]
    return float(np.sqrt(np.mean(kept**2))) / TRIM_FACTOR


def huber_square(residual: np.ndarray) -> np.ndarray:
    """Twice Huber's loss (n,) of a residual in noise deviations: its square up to the corner, linear beyond."""
    size = np.abs(residual)
    inner = np.minimum(size, LOSS_CORNER)
    return inner**2 + 2.0 * LOSS_CORNER * (size - inner)


@dataclass(frozen=True)
class ChannelMisfit:
    """Residual of one channel of one set of records.

    Args:
        rms: over all scored samples, in the channel's unit.
        over_noise: robust rms over the noise in the same residual after the same filter; 1 is noise alone. Of a
            position, or that of what a held body gives way by, if it is more.
        fit_percent: 100 (1 - |residual| / |measured - mean|).
        size: scored samples.
    """

    rms: float
    over_noise: float
    fit_percent: float
    size: int


def dominated_by_few_samples(before: ChannelMisfit, after: ChannelMisfit) -> bool:
    """Whether the plain rms hides how far the error fell: few samples beside reversals rule it, or it shows at rest."""
    return after.rms * before.over_noise > 2.0 * after.over_noise * before.rms


def scored_channels(record: PreparedRecord) -> dict[str, tuple[np.ndarray, np.ndarray, float]]:
    """What a model is scored on, by name: values (n,), the samples that count (n,), and their noise."""
    if isinstance(record, ForceBalanceRecord):
        return record.scored
    return {channel: (y, record.valid[channel], record.noise[channel]) for channel, y in record.measured.items()}


FOLLOWED = 0.1
"""Part of the uncertain timing that is left where bristles follow a given position, and no force flips in a step."""


def sample_std(
    record: PreparedRecord, predicted: Mapping[str, np.ndarray], channel: str, timing: float = 1.0
) -> np.ndarray:
    """Standard deviation (n,) of a residual: sensor noise, and timing within a step where the prediction is steep.

    `timing` is the part of the record's own uncertainty of timing that the model leaves.
    """
    noise = scored_channels(record)[channel][2]
    if not isinstance(record, ForceBalanceRecord) or record.timing_uncertainty == 0.0 or channel == STICK_DISPLACEMENT:
        return np.full(record.size, noise)
    steep = np.gradient(predicted[channel], record.step)
    return np.hypot(noise, timing * record.timing_uncertainty * np.abs(steep))


def misfit(model: Model, records: Sequence[PreparedRecord]) -> dict[str, ChannelMisfit]:
    """Misfit of a model on records, by channel."""
    residuals: dict[str, list[np.ndarray]] = {}
    scaled: dict[str, list[np.ndarray]] = {}
    measured: dict[str, list[np.ndarray]] = {}
    given: dict[str, list[np.ndarray]] = {}
    for record in records:
        predicted = predict(record, model.effects, model.values)
        for channel in record.measured:
            ok = record.valid[channel]
            r = (record.measured[channel] - predicted[channel])[ok]
            residuals.setdefault(channel, []).append(r)
            scaled.setdefault(channel, []).append(r / record.noise[channel])
            measured.setdefault(channel, []).append(record.measured[channel][ok] - record.measured[channel][ok].mean())
        if isinstance(record, ForceBalanceRecord) and record.stick_phases is not None:
            # How a body gives way while it is held counts as a misfit of its position.
            ok = record.stick_phases.scored
            channel = "position" if "position" in record.measured else record.force_channel
            given.setdefault(channel, []).append(
                (record.stick_phases.displacement - predicted[STICK_DISPLACEMENT])[ok] / record.stick_phases.noise
            )
    out = {}
    for channel, parts in residuals.items():
        r, y = np.concatenate(parts), np.concatenate(measured[channel])
        norm = float(np.linalg.norm(y))
        over = trimmed_rms(np.concatenate(scaled[channel]))
        at_rest = np.concatenate(given.get(channel, [np.empty(0)]))
        if at_rest.size >= LEAST_AT_REST:
            over = max(over, trimmed_rms(at_rest))
        out[channel] = ChannelMisfit(
            rms=float(np.sqrt(np.mean(r**2))),
            over_noise=over,
            fit_percent=100.0 * (1.0 - float(np.linalg.norm(r)) / norm) if norm > 0 else float("nan"),
            size=r.size,
        )
    return out


def worst_over_noise(fit: dict[str, ChannelMisfit], validate: dict[str, ChannelMisfit]) -> float:
    """Largest error over noise of any channel, on the records of the fit or the held-out ones."""
    return max((m.over_noise for m in (*fit.values(), *validate.values())), default=1.0)


@dataclass(frozen=True)
class ResidualWeights:
    """What makes residuals comparable between models: fixed deviations and thinning, taken from the base model."""

    deviations: tuple[dict[str, np.ndarray], ...]
    samples: tuple[dict[str, np.ndarray], ...]

    @cached_property
    def scored_std(self) -> tuple[dict[str, np.ndarray], ...]:
        """The deviations at the samples that are scored."""
        return tuple(
            {channel: deviations[channel][pick] for channel, pick in samples.items()}
            for deviations, samples in zip(self.deviations, self.samples, strict=True)
        )


def residual_weights(model: Model, records: Sequence[PreparedRecord], thin: bool = True) -> ResidualWeights:
    """Deviations from the base model's prediction, and the samples that are scored.

    A filtered record is thinned to a sample per filter width: its neighbours say the same, and count once.
    """
    deviations, samples = [], []
    for record in records:
        predicted = predict(record, model.effects, model.values)
        scored = scored_channels(record)
        given = isinstance(record, ForceBalanceRecord) and record.stick_fraction is None
        timing = (
            FOLLOWED
            if given and any(e.friction_state and e.friction_state.name != "coulomb" for e in model.effects)
            else 1.0
        )
        deviations.append({c: sample_std(record, predicted, c, timing) for c in scored})
        every = 1
        if thin and isinstance(record, ForceBalanceRecord) and record.full_filter is not None:
            every = max(1, int(record.full_filter.width / record.step))
        pick = {}
        for channel, (_, valid, _) in scored.items():
            index = np.flatnonzero(valid)
            pick[channel] = index[::every]
        samples.append(pick)
    return ResidualWeights(tuple(deviations), tuple(samples))


def weighted_residual(
    model: Model, records: Sequence[PreparedRecord], weights: ResidualWeights, values: Mapping[str, float] | None = None
) -> np.ndarray:
    """Residual over its deviation at the scored samples, all channels of all records end to end, (n,)."""
    values = model.values if values is None else values
    parts = []
    for record, scales, samples in zip(records, weights.scored_std, weights.samples, strict=True):
        predicted = predict(record, model.effects, values, samples)
        scored = scored_channels(record)
        for channel, pick in samples.items():
            parts.append((scored[channel][0][pick] - predicted[channel]) / scales[channel])
    return np.concatenate(parts) if parts else np.empty(0)


def in_stick_phase(weights: ResidualWeights) -> np.ndarray:
    """Which of the scored samples (n,) are displacements while friction holds the body."""
    parts = [
        np.full(pick.size, channel == STICK_DISPLACEMENT)
        for samples in weights.samples
        for channel, pick in samples.items()
    ]
    return np.concatenate(parts) if parts else np.empty(0, dtype=bool)


AWAY = 4.0
"""Widths of the filter from a stop, a start or a turn beyond which nothing of it is left in a balance."""


def away_from_events(records: Sequence[PreparedRecord], weights: ResidualWeights) -> np.ndarray:
    """Which of the scored samples (n,) of driven masses lie in motion or at rest, beyond the reach of any turn.

    Where a mass stops and starts, its balance depends on when to a fraction of a sample; beside, on the laws alone.
    """
    parts = []
    for record, samples in zip(records, weights.samples, strict=True):
        near = np.ones(record.size, dtype=bool)
        if isinstance(record, ForceBalanceRecord) and record.slip_phases is not None and record.full_filter is not None:
            near = _near(record, AWAY * record.full_filter.width / record.step)
        parts += [
            ~near[pick] if channel != STICK_DISPLACEMENT else np.zeros(pick.size, bool)
            for channel, pick in samples.items()
        ]
    return np.concatenate(parts) if parts else np.empty(0, dtype=bool)


def _near(record: ForceBalanceRecord, reach: float) -> np.ndarray:
    assert record.slip_phases is not None and record.reversals is not None
    near = np.zeros(record.size + 1, dtype=int)
    for time in (*record.slip_phases.end, *record.slip_phases.break_away, *np.abs(record.reversals)):
        if np.isfinite(time):
            near[max(0, int(time - reach)) : int(time + reach) + 2] = 1
    return near[:-1].astype(bool)


def blocks(records: Sequence[PreparedRecord], weights: ResidualWeights, per_record: int = 24) -> np.ndarray:
    """Block number (n,) of each scored sample: stretches of time, the same for all channels of a record."""
    parts, start = [], 0
    for record, samples in zip(records, weights.samples, strict=True):
        for pick in samples.values():
            parts.append(start + (pick * per_record) // record.size)
        start += per_record
    return np.concatenate(parts) if parts else np.empty(0, dtype=int)
