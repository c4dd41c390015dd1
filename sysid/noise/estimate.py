"""Noise of a measured channel, estimated before any model is fitted.

Sources in order of preference: the value given by the user; the scatter from cycle to cycle of a periodic motion; the
differences of the samples at several lags, after regression on smooth functions of the recorded motion and removal of
the hum of the mains, which is added again as a part of the noise.
The residual of the model is never used, since it contains the missing effects. Quantisation is part of the noise: the
differences are taken with a uniform random number of one step added to each value, so that they contain the rounding of
a signal that stays between two steps (Schuchman, IEEE Trans. Commun. Technol. 12 (1964) 162).

A log that was filtered shows no noise from sample to sample: its differences keep decreasing with their order, or are
smaller than the noise of any sensor while the cycles scatter far more. Without periodic repeats the estimate is then
only a lower bound, which is reported.

Source: Pintelon and Schoukens, System Identification (2012), ch. 2 (repeats).

A measured force is regressed on hat functions of every other recorded channel, of its rate and of the rate's rate,
separately for each direction of motion and for rest after each: these represent any force law without memory, and the
inertia. Effects with memory, on a scale finer than the hats, or that change in time remain; so does the noise, less the
part along the hat functions, which is small for all but the slowest noise. The regression is not a model of the
machine, and its coefficients are not used elsewhere.

Long records are decimated by means of blocks of k consecutive rows. A mean over k rows keeps the band up to 1 / (2 k
step), and the noise falls with it. For a first-order autoregression of standard deviation s and lag-one correlation c
(Priestley, Spectral Analysis and Time Series, 1981, section 5.3),

    var(mean)            = s^2 [k (1 - c^2) - 2 c (1 - c^k)] / [k^2 (1 - c)^2]
    correlation of means = c (1 - c^k)^2 / [k (1 - c^2) - 2 c (1 - c^k)].
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from stagecad.parameters.errors import InputError, require
from stagecad.parameters.units import as_json
from sysid.experiment.experiment import Experiment
from sysid.experiment.record import Record
from sysid.experiment.rigs import RIGS
from sysid.noise.autocorrelation import Autoregression, Series, fit_noise, without_outliers
from sysid.noise.mains import without_hum
from sysid.noise.repeats import LEAST_LEVELS, LEAST_NOISY_LEVELS, cycle_scatter, find_quantisation_step
from sysid.signals import WHITE, NoiseSpectrum, filled

KNOTS = 10
"""Hat functions of each coordinate."""

SHARP = np.concatenate([-(0.45 ** np.arange(9.0)), [0.0], 0.45 ** np.arange(8.0, -1.0, -1.0)])
"""Knots of a rate over its largest size: friction changes sharply at low velocity."""

OUTPUTS = ("friction_force", "drive_force", "spring_force", "tip_x", "tip_y")
"""Channels that are regressed on the others, but not on each other."""

MOVES = ("velocity", "position", "pull_position", "voltage_1", "voltage_2")
"""Channels whose rates are coordinates, too."""

AT_REST = 1e-4
"""Part of the highest rate up to which a channel is at rest."""

RIDGE = 1e-7
"""Relative to the mean of the diagonal: hat functions without samples."""

SURE = 0.02
"""Part of the rate's scatter up to which the noise of a smoothed rate is small."""


def motion_residual(record: Record, values: np.ndarray, channel: str) -> Series | None:
    """Residual of the regression of `values` (n,) of a channel, without the power that it removes from noise; None if
    the channel is not an output or nothing else was recorded."""
    if channel not in OUTPUTS:
        return None
    known = {
        name: filled(column)[0]
        for name, column in record.channels.items()
        if name not in OUTPUTS and np.nanmax(column, initial=-np.inf) > np.nanmin(column, initial=np.inf)
    }
    hats = _hat_functions(known, record.time / record.step)
    good = np.isfinite(values)
    if hats is None or good.sum() < 4 * hats.shape[0]:
        return None
    hats[:, ~good] = 0.0
    inner = hats @ hats.T
    root = np.linalg.cholesky(inner + RIDGE * np.trace(inner) / inner.shape[0] * np.eye(inner.shape[0]))
    basis = np.linalg.inv(root) @ hats  # (p, n)
    centred = np.where(good, values - np.mean(values[good]), 0.0)
    residual = centred - (basis @ centred) @ basis
    power = sum(np.abs(np.fft.rfft(row)) ** 2 for row in basis)
    return Series(record.time, np.where(good, residual, np.nan), record.step, power / basis.shape[1])


def _hat_functions(known: Mapping[str, np.ndarray], time: np.ndarray) -> np.ndarray | None:
    """Hat functions (p, n) of all coordinates; time in rows."""
    found: list[np.ndarray] = []
    for name, values in known.items():
        if name not in MOVES:
            found.append(hats_of(values))
            continue
        rate = known.get("velocity") if name in ("position", "velocity") else None
        rate = _rate(values, time) if rate is None else rate
        ways = _ways(rate)
        if name != "velocity":
            hats = hats_of(values)
            found += [hats * way for way in ways]
        if name == "position" and "velocity" in known:
            continue
        found += [hats_of(rate, SHARP)]
        hats = hats_of(_rate(rate, time))
        found += [hats * way for way in ways]
    if not found:
        return None
    return np.concatenate([hats[np.any(hats, axis=1)] for hats in found])


def _ways(rate: np.ndarray) -> list[np.ndarray]:
    """Rows (n,) of motion in each direction, and of rest after each: friction at rest keeps the sign it had."""
    moving = np.abs(rate) > AT_REST * float(np.max(np.abs(rate)))
    last = np.maximum.accumulate(np.where(moving, np.arange(rate.size), 0))
    forward = rate[last] > 0.0
    return [moving & forward, moving & ~forward, ~moving & forward, ~moving & ~forward]


def hats_of(values: np.ndarray, places: np.ndarray | None = None) -> np.ndarray:
    """Hat functions (k, n): on knots at `places` times the largest size, else halfway between even spacing and even
    population."""
    if places is not None:
        knots = places * float(np.max(np.abs(values)))
        knots[[0, -1]] = values.min(), values.max()
        knots = np.unique(np.clip(knots, values.min(), values.max()))
    else:
        shares = np.linspace(0.0, 1.0, KNOTS)
        knots = 0.5 * (np.quantile(values, shares) + values.min() + shares * np.ptp(values))
        knots = knots[np.concatenate([[True], np.diff(knots) > 1e-9 * float(np.max(np.abs(knots)))])]
    if knots.size < 2:
        return np.ones((1, values.size))
    left = np.clip(np.searchsorted(knots, values, side="right") - 1, 0, knots.size - 2)
    part = (values - knots[left]) / (knots[left + 1] - knots[left])
    out = np.zeros((knots.size, values.size))
    rows = np.arange(values.size)
    out[left, rows], out[left + 1, rows] = 1.0 - part, part
    return out


def _rate(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Rate (n,) of `values`, smoothed over as many rows as its noise demands."""
    noise = 1.4826 * float(np.median(np.abs(np.diff(values, 3)))) / np.sqrt(20.0)
    width = 1
    while True:
        rate = np.gradient(_smoothed(_smoothed(values, width), width), time)
        if 1.5 * noise <= SURE * float(np.std(rate)) * (2 * width - 1) ** 1.5 or width > values.size // 40:
            return rate
        width *= 2


def _smoothed(values: np.ndarray, width: int) -> np.ndarray:
    """Running mean (n,) over 2 width - 1 rows."""
    if width == 1:
        return values
    padded = np.pad(values, (width, width - 1), mode="reflect", reflect_type="odd")
    total = np.cumsum(padded)
    return (total[2 * width - 1 :] - total[: -(2 * width - 1)]) / (2 * width - 1)


NoiseSource = Literal["given", "repeats", "difference"]
BEST_SENSOR = 1e-4
"""Ratio of noise to signal below which a force log whose cycles scatter more is taken to be filtered: no force sensor
has a signal-to-noise ratio above 80 dB from sample to sample. Position sensors have (an interferometer 120 dB)."""

FORCES = ("N", "N*m")
"""Units of the channels to which that limit applies."""

LEAST = 1e-9
"""Ratio of noise to largest value below which the noise is taken as zero: the error of rounding to nine digits."""

UNSEEN_UNDER_STEP = 0.1
"""Noise below a tenth of a sensor's step does not affect its readings; it is taken to be that tenth."""

MOST_ROWS, STRETCHES = 16_000, 4
"""Largest number of rows of a record from which its noise is estimated, and number of sections that contain them."""

WHITE_FROM = 0.9
"""Noise of the finest differences over a stated one from which that is white: 0.91 at the autocorrelation 0.1."""

WRONG_FLOOR, LEAST_SAMPLES = 0.7, 300
"""Error over noise below which, with at least so many samples, the noise is overestimated."""


@dataclass(frozen=True)
class Noise:
    """Standard deviation of the noise on one channel."""

    value: float  # SI, quantisation included
    unit: str  # SI unit
    source: NoiseSource  # method by which the value was obtained
    spectrum: NoiseSpectrum = WHITE  # of the noise
    correlation_time: float = 0.0  # s, of the autoregressive part; zero for white noise
    # whether the log was low-pass filtered, so that `value` is a lower bound unless given or from repeats
    filtered: bool = False
    factor: float = 1.0  # by which an estimated `value` may be too small or too large
    quantisation_step: float | None = None  # least significant bit of the values, SI; None if they are not quantised
    note: str = ""  # one line for the user
    # standard deviation without quantisation noise, SI; None if `value` does not include quantisation noise
    without_quantisation: float | None = None

    @property
    def is_known(self) -> bool:
        """Whether the level is known: stated, or mostly that of rounding, of which a rich model may leave less."""
        return self.source == "given" or (self.quantisation_step or 0.0) ** 2 / 12.0 >= 0.5 * self.value**2

    @property
    def autocorrelation(self) -> float:
        """Autocorrelation at a lag of one sample."""
        return (1.0 - self.spectrum.white) * self.spectrum.correlation

    def to_json(self) -> dict[str, Any]:
        """JSON output: a quantity with `from`, and the autocorrelation at a lag of one sample if it is not zero."""
        out = {**as_json(self.value, self.unit), "from": self.source}
        return {**out, "autocorrelation": round(self.autocorrelation, 4)} if self.autocorrelation else out


def estimate_noise(
    records: Sequence[Record],
    channel: str,
    given: float | None = None,
    least_levels: int = LEAST_LEVELS,
    imposed: bool = False,
) -> Noise:
    """Noise on a measured `channel` of the records of one experiment. With the standard deviation `given`, SI, only its
    autocorrelation and quantisation are estimated.

    A quantised channel has at least `least_levels` occupied levels; an `imposed` one may have any course, so that only
    its finest differences are noise. InputError: no record contains the channel, or it has too few values.
    """
    whole = [record for record in records if channel in record.channels]
    require(whole, f"no record holds '{channel}'")
    holding = [_stretches(_own_rows(record, channel)) for record in whole]
    unit = holding[0].units[channel]
    steps = [find_quantisation_step([record.channels[channel]], least_levels) or 0.0 for record in holding]
    # Records may differ in quantisation (two sensors, or processed data).
    rounding = float(np.sqrt(np.average(np.square(steps), weights=[record.size for record in holding]) / 12.0))
    key = (_digest(holding), channel, tuple(steps))
    if key not in _FITTED:
        _FITTED[key] = _fitted(holding, channel, steps)
    fitted = _FITTED[key]
    if fitted is None:
        if given is None:
            raise InputError(f"channel '{channel}' has too few samples to estimate its noise; give it under [noise]")
        fitted = Autoregression(given)
    elif imposed and given is None:
        fitted = Autoregression(fitted.finest, filtered=fitted.filtered, finest=fitted.finest)
    value = float(np.hypot(_unrounded(fitted.value**2 - 2.0 * rounding**2, rounding), rounding))
    time = _correlation_time(fitted.spectrum.correlation, holding)
    # Of a slower sensor the correlation is that from row to row of the record.
    rate = sum(record.step for record in whole) / sum(record.step for record in holding)
    spectrum = fitted.spectrum._replace(correlation=fitted.spectrum.correlation**rate)
    noise = Noise(value, unit, "difference", spectrum, time, fitted.filtered, fitted.factor, max(steps) or None)
    if given is None:
        noise = _estimated(noise, records, channel)
    elif given < rounding:
        return replace(noise, value=given, source="given", factor=1.0, note=_with_grid("given", noise, given))
    else:
        # The records show whether a stated value includes the rounding.
        total = min(float(np.hypot(given, rounding)), max(given, value))
        noise = replace(noise, value=total, source="given", factor=1.0, note="given")
        if fitted.finest > WHITE_FROM * np.hypot(total, rounding):
            noise = replace(noise, spectrum=WHITE, correlation_time=0.0)
    own = _unrounded(noise.value**2 - rounding**2, rounding) if rounding else None
    return replace(noise, note=_with_grid(noise.note, noise, noise.value), without_quantisation=own)


def _correlation_time(correlation: float, records: Sequence[Record]) -> float:
    step = float(np.median([record.step for record in records]))
    return -step / float(np.log(correlation)) if correlation > 0.0 else 0.0


def _unrounded(variance: float, rounding: float) -> float:
    """Standard deviation of the noise before rounding, at least the value that rounding masks."""
    return float(np.sqrt(max(variance, 12.0 * (UNSEEN_UNDER_STEP * rounding) ** 2)))


def _with_grid(note: str, noise: Noise, value: float) -> str:
    step = noise.quantisation_step
    coarse = step is not None and step > 0.1 * value
    return f"{note}; the values lie on a grid of {step:.3g} {noise.unit}" if coarse else note


def _own_rows(record: Record, channel: str) -> Record:
    """The record in the rows in which a channel has values, if its sensor is slower than the logger."""
    rows = np.flatnonzero(np.isfinite(record.channels[channel]))
    if rows.size < 2 or np.median(np.diff(rows)) < 2:
        return record
    channels, time = {name: values[rows] for name, values in record.channels.items()}, record.time[rows]
    return replace(record, time=time, channels=channels, step=float(np.median(np.diff(time))))


def _stretches(record: Record) -> Record:
    """The record, reduced to evenly spaced sections if it is long."""
    if record.size <= MOST_ROWS:
        return record
    starts = np.linspace(0, record.size - MOST_ROWS // STRETCHES, STRETCHES).astype(int)
    rows = np.unique(np.concatenate([np.arange(start, start + MOST_ROWS // STRETCHES) for start in starts]))
    channels = {name: values[rows] for name, values in record.channels.items()}
    return replace(record, time=record.time[rows], channels=channels)


def _digest(records: Sequence[Record]) -> bytes:
    """Digest of the recorded values."""
    found = hashlib.blake2b(digest_size=16)
    for record in records:
        found.update(repr((record.step, *record.channels)).encode())
        for values in (record.time, *record.channels.values()):
            found.update(values.tobytes())
    return found.digest()


_FITTED: dict[tuple[bytes, str, tuple[float, ...]], Autoregression | None] = {}
"""Noise by the digest of the records, the channel and its quantisation steps: a command reads its records several
times."""


def _fitted(records: Sequence[Record], channel: str, steps: Sequence[float]) -> Autoregression | None:
    """White and autoregressive noise of the channel, with uniform noise of the width `steps` of each record added, and
    with the hum of the mains, which is fitted separately."""
    random = np.random.default_rng(0)
    signal, residual = [], []
    for record, step in zip(records, steps, strict=True):
        values = record.channels[channel]
        values = without_outliers(values + step * random.uniform(-0.5, 0.5, values.size) if step else values)
        signal.append(without_hum(Series(record.time, values, record.step), channel))
        if (rest := motion_residual(record, values, channel)) is not None:
            residual.append(without_hum(replace(rest, values=without_outliers(rest.values)), channel))
    compared = len(residual) == len(signal)
    found = fit_noise([one.series for one in signal], [one.series for one in residual] if compared else None)
    hum = np.mean([one.variance for one in (residual if compared else signal)])
    return None if found is None else replace(found, value=float(np.hypot(found.value, np.sqrt(hum))))


def _estimated(noise: Noise, records: Sequence[Record], channel: str) -> Noise:
    """The noise from differences, or that from repeats where it replaces them."""
    holding = [record for record in records if channel in record.channels]
    repeats = [scatter for record in holding if (scatter := cycle_scatter(record, channel)) is not None]
    scatter = _rms([item.scatter for item in repeats])
    signal = _rms([float(np.sqrt(np.nanmean(record.channels[channel] ** 2))) for record in holding])
    too_good = noise.unit in FORCES and noise.value < BEST_SENSOR * signal
    filtered = noise.filtered or (scatter > 10.0 * noise.value and too_good)
    if repeats and (filtered or scatter <= 3.0 * noise.value):
        cycles = sum(item.cycles for item in repeats)
        note = f"from cycle to cycle, {cycles} cycles of {repeats[0].period:.4g} s"
        rounded = (noise.quantisation_step or 0.0) / np.sqrt(12.0)
        found = replace(noise, value=max(scatter, rounded), source="repeats", filtered=filtered, factor=1.0)
        if filtered:
            note += f"; the log was filtered, so the difference of neighbouring samples ({noise.value:.2g} "
            note += f"{noise.unit}) is not an estimate of the noise"
            memory = float(np.median([item.correlation for item in repeats]))
            time = _correlation_time(memory, holding)
            found = replace(found, spectrum=NoiseSpectrum(memory, 0.0), correlation_time=time)
        return replace(found, note=note)
    if noise.value < (least := _least(holding, channel)):
        note = f"no noise is detected; taken as {LEAST:g} of the largest value, the rounding error of nine digits"
        if noise.filtered:
            note += ". The log was filtered, or comes from no sensor: a lower bound; give [noise], or record repeats"
        elif 1 < (count := _distinct(holding, channel)) < LEAST_LEVELS:
            note += f". It has {count} different values: if these are the steps of its sensor, give [noise]"
        return Noise(least, noise.unit, "difference", filtered=noise.filtered, note=note)
    note = "from differences of samples at several lags"
    if noise.correlation_time:
        note += f"; autocorrelated over {noise.correlation_time:.2g} s"
    if noise.factor > 1.2:
        note += f", uncertain by a factor of {noise.factor:.2g}"
    if noise.filtered:
        note += "; the log was filtered, so this is a lower bound: give [noise], or record repeats"
    elif repeats:
        # Cycles that differ by more than sensor noise contain an effect that changes from cycle to cycle.
        note += f"; cycles differ by {scatter:.2g} {noise.unit}, which is not sensor noise"
    return replace(noise, note=note)


def _least(records: Sequence[Record], channel: str) -> float:
    """Least noise of a channel that is detected: the rounding error of nine digits."""
    return LEAST * max(float(np.nanmax(np.abs(record.channels[channel]))) for record in records) or LEAST


def _distinct(records: Sequence[Record], channel: str) -> int:
    """Number of different values of a channel."""
    values = np.concatenate([record.channels[channel] for record in records])
    return np.unique(values[~np.isnan(values)]).size


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else 0.0


def noise_warnings(noise: Mapping[str, Noise], errors: Mapping[str, tuple[float, int]]) -> list[str]:
    """One line for each channel whose error is clearly below its noise."""
    out = []
    for channel, (over, size) in errors.items():
        if over < WRONG_FLOOR and size >= LEAST_SAMPLES and channel in noise:
            found = noise[channel]
            source = "the stated noise" if found.source == "given" else "the estimated noise"
            advice = "correct [noise]" if found.source == "given" else "state it under [noise]"
            out.append(
                f"{channel}: the error is {over:.2g} of {source} ({found.value:.3g} {found.unit}), which is therefore "
                f"too large; {advice}"
            )
    return out


def noisy_channels(experiment: Experiment, records: Sequence[Record]) -> list[str]:
    """Channels of the records that contain sensor noise on this kind of rig: measured ones, motions that are imposed
    and logged, and others whose noise is stated."""
    rig = experiment.rig
    stated = [name for name in rig.declaration.channels if name in experiment.noise]
    names = [*rig.declaration.measured_channels, *RIGS[rig.kind].sensed_inputs, *stated]
    present = set().union(*(r.channels for r in records))
    return [n for n in dict.fromkeys(names) if n in present]


def noise_by_channel(experiment: Experiment, records: Sequence[Record]) -> tuple[dict[str, Noise], list[str]]:
    """Noise of each measured channel, given or estimated, and notes for the user."""
    noise, notes = {}, []
    inputs, sensed = RIGS[experiment.rig.kind].input_channels, RIGS[experiment.rig.kind].sensed_inputs
    for channel in noisy_channels(experiment, records):
        given = experiment.noise.get(channel)
        per_record = [r.noise[channel] for r in records if channel in r.noise]
        if given is None and per_record:
            given = float(np.sqrt(np.mean(np.square(per_record))))
        sensor = given is not None and channel not in inputs
        # A position without a velocity is filtered by the width that its noise requires, and needs a value.
        derived = channel == "position" and not any("velocity" in record.channels for record in records)
        imposed = given is None and channel in sensed and channel != "drive_force" and not derived
        try:
            found = estimate_noise(records, channel, given, LEAST_NOISY_LEVELS if sensor else LEAST_LEVELS, imposed)
        except InputError:
            # An input of a few values, as a load at another rate, shows no noise.
            if imposed:
                continue
            raise
        if imposed and found.value <= _least([r for r in records if channel in r.channels], channel):
            continue
        noise[channel] = found
        if found.note:
            notes.append(f"noise of {channel}: {found.note}")
    return noise, notes


def with_quantisation(noise: Mapping[str, Noise], names: Sequence[str]) -> dict[str, Noise]:
    """Noise with step/sqrt(12) added in the channels that the named `sensor_quantisation` effects act on, where it does
    not include that yet: the stated value is smaller."""
    out = dict(noise)
    for name in names:
        wanted = name.partition("@")[2]
        for channel, found in noise.items():
            if found.quantisation_step is None or found.without_quantisation is not None or wanted not in ("", channel):
                continue
            value = float(np.hypot(found.value, found.quantisation_step / np.sqrt(12.0)))
            # Quantisation errors well above the noise change with the motion; they are treated as white.
            out[channel] = replace(
                found, value=value, spectrum=WHITE, correlation_time=0.0, without_quantisation=found.value
            )
    return out


MOST_ROWS_FITTED = 200_000
"""Largest number of rows of all records together that is not decimated."""

LONGEST_SPAN = 1.5
"""Longest span of a block, over k steps: a block with a gap in time has no mean."""


def decimation_factor(records: Sequence[Record]) -> int:
    """Rows per block that keep all records together within `MOST_ROWS_FITTED`; 1 for no decimation."""
    return -(-sum(record.size for record in records) // MOST_ROWS_FITTED)


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
        c, white = one.spectrum.correlation, one.spectrum.white
        spread = k * (1.0 - c**2) - 2.0 * c * (1.0 - c**k)
        parts = [white / k, (1.0 - white) * spread / (k * (1.0 - c)) ** 2]
        factor = float(np.sqrt(sum(parts)))
        spectrum = NoiseSpectrum(c * (1.0 - c**k) ** 2 / spread, parts[0] / sum(parts))
        inner = None if one.without_quantisation is None else factor * one.without_quantisation
        # A mean of quantised values is no longer on their grid.
        value = factor * one.value
        out[channel] = replace(one, value=value, spectrum=spectrum, quantisation_step=None, without_quantisation=inner)
    return out
