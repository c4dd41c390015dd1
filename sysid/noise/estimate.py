"""Noise of a measured channel, found before any model is fitted.

Sources in order of preference: the value given by the user; the scatter from cycle to cycle of a periodic motion;
stretches of constant input; differences of neighbouring samples. The residual of a model is never used, since it
contains the missing effects.

Differences contain only the fastest part of the noise. Correlated noise is detected by comparing them with the scatter
in windows of increasing length. A filtered log is detected by differences that keep decreasing with their order, or by
differences of neighbouring samples that are smaller than the noise of any sensor while the cycles scatter far more. A
filtered log without periodic repeats is reported, since the estimate is then only a lower bound.

Sources: Rice, Ann. Statist. 12 (1984) 1215, and Gasser, Sroka and Jennen-Steinmetz, Biometrika 73 (1986) 625
(differences); Pintelon and Schoukens, System Identification (2012), ch. 2 (repeats).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from stagecad.parameters.errors import InputError
from stagecad.parameters.units import as_json
from sysid.experiment.experiment import Experiment
from sysid.experiment.record import Record
from sysid.experiment.rigs import RIGS
from sysid.noise.autocorrelation import Autoregression, difference_scale, fit_autoregression, segments
from sysid.noise.quantisation import find_quantisation_step
from sysid.noise.repeats import cycle_scatter

NoiseSource = Literal["given", "repeats", "quiet", "difference"]
BEST_SENSOR = 1e-4
"""Ratio of noise to signal below which a force log whose cycles scatter more is taken to be filtered: no force sensor
has a signal-to-noise ratio above 80 dB from sample to sample."""


LEAST = 1e-9
"""Ratio of noise to largest value below which the noise is taken as zero: the error of rounding to nine digits."""


UNEVEN = 2.5
"""Largest ratio of the noise of a record to that at constant input at which both are taken as the same noise."""


@dataclass(frozen=True)
class Noise:
    """Standard deviation of the noise on one channel.

    Args:
        value: SI.
        unit: SI unit.
        source: method by which the value was obtained.
        correlation: correlation of neighbouring samples (first-order autoregression); zero for white noise.
        correlation_time: s, -step / log(correlation); zero for white noise.
        filtered: whether the log was low-pass filtered, so that differences of neighbours do not show the noise.
        quantisation_step: least significant bit of the values, SI; None if they are not quantised.
        note: one line for the user.
        without_quantisation: standard deviation without quantisation noise, SI; None if `value` does not include
            quantisation noise.
    """

    value: float
    unit: str
    source: NoiseSource
    correlation: float = 0.0
    correlation_time: float = 0.0
    filtered: bool = False
    quantisation_step: float | None = None
    note: str = ""
    without_quantisation: float | None = None

    def to_json(self) -> dict[str, Any]:
        """JSON output: a quantity with `from`."""
        return {**as_json(self.value, self.unit), "from": self.source}


def estimate_noise(records: Sequence[Record], channel: str, given: float | None = None) -> Noise:
    """Standard deviation of the noise on `channel`.

    Args:
        records: of one experiment; those without the channel are ignored.
        channel: measured channel.
        given: standard deviation given by the user, SI.

    Returns:
        The noise. With `given`, only its correlation and quantisation are estimated from the records.

    Raises:
        InputError: no record contains the channel, or none has a long enough stretch.
    """
    holding = [record for record in records if channel in record.channels]
    if not holding:
        raise InputError(f"no record holds '{channel}'")
    unit = holding[0].units[channel]
    step = float(np.median([record.step for record in holding]))
    quanta = [find_quantisation_step([record.channels[channel]]) for record in holding]
    quantisation_step = max((found for found in quanta if found is not None), default=None)
    if quantisation_step is None:
        fitted = fit_autoregression([piece for record in holding for piece in _pieces(record, channel)])
    else:
        # Records may differ in quantisation (two sensors, or processed data): each is evaluated with its own step.
        apart = [fit_autoregression(_pieces(record, channel), found) for record, found in zip(holding, quanta)]
        fitted = _together([found for found in apart if found is not None])
    irregular = fitted is None
    if fitted is None:
        fitted = _irregular(holding, channel)
    if given is not None:
        return _noise(given, unit, "given", fitted, step, quantisation_step, "given")
    repeats = [scatter for record in holding if (scatter := cycle_scatter(record, channel)) is not None]
    scatter = _rms([item.scatter for item in repeats])
    signal = _rms([float(np.sqrt(np.nanmean(record.channels[channel] ** 2))) for record in holding])
    filtered = fitted.filtered or (scatter > 10.0 * fitted.value and fitted.value < BEST_SENSOR * signal)
    if repeats and (filtered or scatter <= 3.0 * fitted.value):
        cycles = sum(item.cycles for item in repeats)
        note = f"from cycle to cycle, {cycles} cycles of {repeats[0].period:.4g} s"
        if filtered:
            note += f"; the log was filtered, so the difference of neighbouring samples ({fitted.value:.2g} {unit}) "
            note += "is no estimate of the noise"
            memory = float(np.median([item.correlation for item in repeats]))
            fitted = Autoregression(scatter, memory, True, fitted.white)
        return _noise(scatter, unit, "repeats", fitted, step, quantisation_step, note)
    least = LEAST * max(float(np.nanmax(np.abs(record.channels[channel]))) for record in holding) or LEAST
    if fitted.value < least:
        note = f"no noise is seen; taken as {LEAST:g} of the largest value, the last digit a file would keep"
        if fitted.filtered:
            note += ". The log was filtered, or comes from no sensor: a lower bound; give [noise], or record repeats"
        return _noise(
            least, unit, "difference", Autoregression(least, 0.0, fitted.filtered, least), step, quantisation_step, note
        )
    idle = _input_idle(holding, channel, fitted, quantisation_step)
    if idle is not None:
        return _noise(idle.value, unit, "quiet", idle, step, quantisation_step, "where the input stands still")
    note = "from differences of neighbouring samples"
    if irregular:
        note += " at uneven times"
    if fitted.correlation:
        note += f" and windows of growing length: coloured, correlation time {_time(fitted.correlation, step):.2g} s"
    if fitted.filtered:
        note += "; the log was filtered, so this is a lower bound: give [noise], or record repeats"
    elif repeats:
        # Cycles that differ by more than sensor noise contain an effect that changes from cycle to cycle.
        note += f"; cycles differ by {scatter:.2g} {unit}, which is no sensor noise"
    return _noise(fitted.value, unit, "difference", fitted, step, quantisation_step, note)


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else 0.0


def _pieces(record: Record, channel: str) -> list[np.ndarray]:
    return segments(record.time, record.channels[channel], record.step)


def _together(models: Sequence[Autoregression]) -> Autoregression | None:
    if not models:
        return None
    return Autoregression(
        _rms([fitted.value for fitted in models]),
        float(np.median([fitted.correlation for fitted in models])),
        all(fitted.filtered for fitted in models),
        _rms([fitted.white for fitted in models]),
    )


def _noise(
    value: float,
    unit: str,
    source: NoiseSource,
    fitted: Autoregression,
    step: float,
    quantisation_step: float | None,
    note: str,
) -> Noise:
    if quantisation_step is not None and quantisation_step > 0.1 * value:
        note += f"; the values lie on a grid of {quantisation_step:.3g} {unit}"
    correlation = fitted.correlation
    return Noise(value, unit, source, correlation, _time(correlation, step), fitted.filtered, quantisation_step, note)


def _time(correlation: float, step: float) -> float:
    return -step / float(np.log(correlation)) if correlation > 0.0 else 0.0


def _irregular(records: Sequence[Record], channel: str) -> Autoregression:
    """White noise of unevenly sampled records, from the residuals of each sample to the line between its neighbours,
    divided by their standard deviation for unit noise."""
    parts = []
    for record in records:
        good = np.flatnonzero(~np.isnan(record.channels[channel]))
        t, x = record.time[good], record.channels[channel][good]
        if t.size < 3:
            continue
        share = (t[1:-1] - t[:-2]) / (t[2:] - t[:-2])
        miss = x[1:-1] - (1.0 - share) * x[:-2] - share * x[2:]
        parts.append(miss / np.sqrt(1.0 + share**2 + (1.0 - share) ** 2))
    if not parts or sum(part.size for part in parts) < 8:
        raise InputError(f"channel '{channel}' has too few samples to estimate its noise; give it under [noise]")
    value = difference_scale(np.concatenate(parts))
    return Autoregression(value, 0.0, False, value)


def _input_idle(
    records: Sequence[Record], channel: str, overall: Autoregression, quantisation_step: float | None
) -> Autoregression | None:
    """The noise in stretches of constant input, if they are long enough and free of residual motion."""
    pieces: list[np.ndarray] = []
    for record in records:
        inputs = [name for name in _inputs(record) if name != channel and name in record.channels]
        if not inputs:
            continue
        still = np.ones(record.size, dtype=bool)
        for name in inputs:
            values = record.channels[name]
            reach = 1e-6 * float(np.nanmax(values) - np.nanmin(values))
            moves = np.abs(np.diff(values, prepend=values[0])) > reach
            still &= ~np.isnan(values) & ~moves
        masked = np.where(still, record.channels[channel], np.nan)
        pieces += [piece for piece in segments(record.time, masked, record.step) if piece.size >= 100]
    if sum(piece.size for piece in pieces) < 1000:
        return None
    fitted = fit_autoregression(pieces, quantisation_step, flat=True)
    if fitted is None or fitted.filtered:
        return None
    uneven = overall.white / max(fitted.white, 1e-300)
    if 0.8 < uneven < 1.0 / 0.6:
        return fitted
    if 1.0 / UNEVEN < uneven < UNEVEN:
        # Noise of equal correlation but uneven size: the standard deviation of the whole record applies.
        return replace(fitted, value=uneven * fitted.value, white=overall.white)
    # If the differences of neighbours deviate strongly from those of the whole record, the noise is not the same.
    return None


def _inputs(record: Record) -> tuple[str, ...]:
    """The imposed channels of the rig kinds that fit the record's channels."""
    held = set(record.channels)
    fitting = [
        rig
        for rig in RIGS.values()
        if all(held & set(group) for group in rig.inputs) and all(held & set(group) for group in rig.measured)
    ]
    return fitting[0].input_channels if fitting else ()


def measured_channels(experiment: Experiment, records: Sequence[Record]) -> list[str]:
    """Channels of the records that contain sensor noise on this kind of rig."""
    rig = experiment.rig
    names = list(rig.declaration.measured_channels)
    if rig.kind == "force-drive":
        names.append("drive_force")
    if rig.kind == "velocity-drive":
        names.append("position")
    present = set().union(*(r.channels for r in records))
    return [n for n in dict.fromkeys(names) if n in present]


def noise_by_channel(experiment: Experiment, records: Sequence[Record]) -> tuple[dict[str, Noise], list[str]]:
    """Noise of each measured channel, given or estimated, and notes for the user."""
    noise, notes = {}, []
    for channel in measured_channels(experiment, records):
        given = experiment.noise.get(channel)
        per_record = [r.noise[channel] for r in records if channel in r.noise]
        if given is None and per_record:
            given = float(np.sqrt(np.mean(np.square(per_record))))
        # A known input: its noise matters only where it is differentiated to obtain the velocity.
        imposed = channel == "position" and experiment.rig.kind == "velocity-drive" and given is None
        if imposed and any("velocity" in r.channels for r in records):
            continue
        found = estimate_noise(records, channel, given)
        noise[channel] = found
        if found.note:
            notes.append(f"noise of {channel}: {found.note}")
    return noise, notes


def with_quantisation(noise: Mapping[str, Noise], names: Sequence[str]) -> dict[str, Noise]:
    """Noise with step/sqrt(12) added in the channels that the named `sensor_quantisation` effects act on."""
    out = dict(noise)
    for name in names:
        wanted = name.partition("@")[2]
        for channel, found in noise.items():
            if found.quantisation_step is None or (wanted and wanted != channel):
                continue
            step = found.quantisation_step / np.sqrt(12.0)
            # Quantisation errors well above the noise change with the motion; they are treated as white.
            value = float(np.hypot(found.value, step))
            out[channel] = replace(found, value=value, correlation=0.0, without_quantisation=found.value)
    return out
