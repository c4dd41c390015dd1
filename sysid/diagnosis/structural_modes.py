"""Detection of a structural mode above the filter band of a force balance by a matched filter.

The filter width of the force balance follows from the noise of the position. A mode above the filter band does not
appear in the filtered balance, though every fast change of force excites it. Its response is narrow-band, so each
frequency is weighted by its noise power spectrum,

    S(f) = S_F(f) + (m (2 pi f)^2)^2 S_x(f),

and the response of a mode is searched for outside the neighbourhoods of events: with the part r of the mass m on the
mode,

    m r (R - 1) / (1 + r (R - 1)) T,    R(f) = f0^2 / (f0^2 - f^2 + 2i d f0 f),

where T is the acceleration of the total mass under the applied force and friction. Errors of the mass and of the time
of the force give m T and its derivatives, which are projected out. A mode must be significant on the records of the
fit and on the held-out ones.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from sim.effects.catalogue import find_where
from sim.effects.effect import Effect
from sysid.diagnosis.constants import LEAST_GAIN, NOISE_FACTOR
from sysid.diagnosis.ledger import Entry, Ledger
from sysid.diagnosis.model_search import ModelSearch
from sysid.estimation.fit import FittedModel, fit_model
from sysid.estimation.least_squares import robust_scale
from sysid.estimation.variant_selection import fits_clearly_better
from sysid.experiment.known import Prior
from sysid.noise.estimate import Noise
from sysid.prediction.force_balance.predict import unfiltered_force
from sysid.prediction.force_balance.record import EDGE_WIDTHS, ForceBalanceRecord
from sysid.prediction.model import Model, with_effect
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.problem import Problem
from sysid.signals import BAND, dilated, longer_than

EVENT_WIDTHS = 3.0
"""Filter widths around each event that are left out, since the uncertainty of its time exceeds the response of a
mode."""

FROM, TO = 0.8, 8.0
"""Range of frequencies, over the upper limit of the filter band."""

HIGHEST = 0.35
"""Highest frequency, over the sampling frequency."""

FREQUENCY_RATIO = 1.035
DAMPINGS = (0.01, 0.02, 0.04)
"""Ratio of neighbouring frequencies that are tried, and the damping ratios."""

LEAST_STATISTIC = 6.0
"""Least detection statistic, in standard errors, on the records of the fit and on the held-out ones. Without a mode it
was at most 3.3 on the held-out records (20 generated cases); on those of the fit it is a maximum over about a hundred
frequencies and damping ratios."""

LEAST_PEAK = 1.3
"""Least ratio of the detection statistic to its largest absolute value at frequencies that differ by a factor of 1.5 or
more."""

LEAST_PART = 0.02
"""Part of the mass on the mode below which it is not distinguishable from an error of the model."""

MOST_DAMPING = 0.15
"""Damping ratio from which the response is not distinguishable from an error of the model."""

MODEL_ERROR = {"frequency": 0.03, "damping": 0.3, "mass_ratio": 0.3}
"""Relative model errors of the values, in addition to their noise: the mode also vibrates while the mass sticks, at
another frequency, and is not at rest when sliding starts."""

SIZE_RATIO = 1.6
"""Largest ratio of the sizes on the records of the fit and on the held-out ones."""


@dataclass(frozen=True)
class StructuralMode:
    """A mode detected above the filter band."""

    values: Mapping[str, float]  # frequency (Hz), damping ratio, and part of the mass on the mode
    stds: Mapping[str, float]  # their standard deviations
    # fit, held_out: detection statistic, in standard errors
    fit: float
    held_out: float
    band: float  # upper limit of the filter band, Hz

    @property
    def words(self) -> str:
        """Detected frequency and detection statistics as text."""
        return (
            f"oscillates at {self.values['frequency']:.3g} Hz, above the {self.band:.3g} Hz of the filter: "
            f"{self.fit:.0f} standard errors with each frequency weighted by its noise, "
            f"{self.held_out:.0f} on the held-out records"
        )


@dataclass(frozen=True)
class _WhitenedRecord:
    """A whitened record: each frequency divided by the root of its noise power spectrum."""

    residual: np.ndarray  # of the model without a mode, in standard deviations, at `samples`, (k,)
    drive: np.ndarray  # spectrum of the mass times the predicted acceleration, over the noise
    frequencies: np.ndarray  # of `drive`, Hz
    samples: np.ndarray  # indices of the samples used, (k,)
    nuisance: np.ndarray  # orthonormal columns of errors of mass and time, which are projected out, (k, 3)
    # length, start: length of the transformed signals, and index of the record's first sample in them
    length: int
    start: int
    band: float  # upper limit of the filter band, Hz

    def signature(self, frequency: float, damping: float, part: float = 0.0) -> np.ndarray:
        """Response (k,) of a mode per part of the mass on it, errors of mass and time projected out."""
        f = self.frequencies
        moved = frequency**2 / (frequency**2 - f**2 + 2j * damping * frequency * f) - 1.0
        signal = np.fft.irfft(self.drive * moved / (1.0 + part * moved), self.length)[self.start :][self.samples]
        return signal - self.nuisance @ (self.nuisance.T @ signal)


def detect_structural_mode(problem: Problem, fitted: FittedModel) -> StructuralMode | None:
    """The structural mode above the filter band of a driven mass; None if none is significant."""
    if any(e.is_mode for e in fitted.model.effects):
        return None
    fits = _whitened_records(problem, fitted.model, problem.fit_records)
    held_out = _whitened_records(problem, fitted.model, problem.validate_records)
    if not fits or not held_out:
        return None
    band = min(record.band for record in fits)
    highest = min(TO * band, HIGHEST / max(r.step for r in problem.fit_records))
    if highest <= FROM * band:
        return None
    count = 2 + int(np.log(highest / (FROM * band)) / np.log(FREQUENCY_RATIO))
    points = product(np.geomspace(FROM * band, highest, count), DAMPINGS)
    tried = [(*_detection_statistic(fits, *point), *point) for point in points]
    errors, part, frequency, damping = max((t for t in tried if LEAST_PART <= t[1] <= 1.0), default=tried[0])
    elsewhere = max((abs(t[0]) for t in tried if not 1 / 1.5 < t[2] / frequency < 1.5), default=0.0)
    errors_held_out, part_held_out = _detection_statistic(held_out, frequency, damping)
    clear = min(errors, errors_held_out) >= LEAST_STATISTIC and errors >= LEAST_PEAK * elsewhere
    if not clear or not 1.0 / SIZE_RATIO < part / part_held_out < SIZE_RATIO:
        return None
    values, stds = _estimate(fits, frequency, damping, part)
    if values["damping"] >= MOST_DAMPING:
        return None
    return StructuralMode(values, stds, errors, errors_held_out, band)


def with_structural_mode(problem: Problem, fitted: FittedModel, found: StructuralMode) -> tuple[Effect, FittedModel]:
    """The mode, and the fit of the model with it; the detected values are the priors of the fit."""
    effect = find_where(lambda e: e.is_mode)
    start = {f"{effect.name}.{name}": value for name, value in found.values.items()}
    model = with_effect(fitted.model, effect, problem.scales, start)
    known = {f"{effect.name}.{name}": Prior(found.values[name], std) for name, std in found.stds.items()}
    model = replace(model, unknowns=tuple(replace(u, prior=known.get(u.key, u.prior)) for u in model.unknowns))
    return effect, fit_model(model, problem.fit_records, fitted.weights)


def with_mode_above_band(search: ModelSearch, ledger: Ledger) -> Ledger:
    """The ledger with a structural mode above the filter band of the force balance, if there is one.

    The mode is detected in the residual of the established effects. Where the ledger has a mode already, the modal
    values above the band are more accurate than those of the balance.
    """
    below = ledger.model
    found = next((e for e in below.added if e.is_mode), None)
    if found is not None:
        below = search.without(below, found.name) or below
    mode = detect_structural_mode(search.problem, below.fitted)
    if mode is None or any(e.is_mode for e in below.fitted.model.effects):
        return ledger
    effect, fitted = with_structural_mode(search.problem, below.fitted, mode)
    candidate = search.reference.evaluate(fitted, (*below.added, effect))
    loss = below.held_out.loss
    if candidate is None or candidate.error > LARGEST_INCREASE * np.sqrt(loss):
        return ledger
    if fitted.model.values[f"{effect.name}.mass_ratio"] < LEAST_PART:
        # A line that the balance does not contain is no motion of the mass: hum of a sensor.
        return ledger
    if found is not None and prefers_balance_fit(ledger.model.fitted, fitted):
        return ledger
    if loss > NOISE_FACTOR and loss - candidate.held_out.loss < LEAST_GAIN * loss:
        # Errors of a wrong model near its events are not white either: without a gain they do not indicate a mode.
        return ledger
    entry = Entry(effect, "established", "explains the oscillation above the filter band", candidate, words=mode.words)
    others = [e for e in ledger.entries if not e.effect.is_mode]
    before = search.reference.held_out.loss
    explained = 1.0 if loss <= NOISE_FACTOR else (before - candidate.held_out.loss) / max(before - 1.0, 1e-9)
    return Ledger((entry, *others), candidate, min(1.0, max(0.0, explained)), ledger.coordinate)


LARGEST_INCREASE = 1.1
"""Largest ratio of the error of the force balance with a mode to that without: it need not contain the mode."""

SAME_MODE = 0.1
"""Relative difference in frequency up to which two fits are of the same mode."""


def prefers_balance_fit(other: FittedModel, rings: FittedModel) -> bool:
    """Whether the fit of a mode to the force balance alone is preferred to that with the detected values."""
    models = other.model, rings.model
    frequencies = [m.values[f"{e.name}.frequency"] for m in models for e in m.effects if e.is_mode]
    same = abs(frequencies[0] / frequencies[1] - 1.0) < SAME_MODE
    return fits_clearly_better(other, rings) or (same and other.fit.cost <= rings.fit.cost)


def _whitened_records(problem: Problem, model: Model, records: Sequence[PreparedRecord]) -> list[_WhitenedRecord]:
    found = [_whitened_record(problem, model, record) for record in records if isinstance(record, ForceBalanceRecord)]
    return [one for one in found if one is not None]


def _whitened_record(problem: Problem, model: Model, balance: ForceBalanceRecord) -> _WhitenedRecord | None:
    """The whitened record; None of a motion that is not filtered, or if too few samples are far from reversals."""
    if balance.raw_position is None or balance.full_filter is None:
        return None
    assert balance.applied is not None
    mass = model.values.get("rig.mass", 0.0)
    width = balance.full_filter.width / balance.step
    samples = np.flatnonzero(_away_from_events(balance, width))
    if mass <= 0.0 or samples.size < 100:
        return None
    force = balance.applied - unfiltered_force(balance, model.effects, model.values)
    reach = min(balance.size - 1, int(np.ceil(8.0 * width)))
    length = 1 << (balance.size + 2 * reach - 1).bit_length()
    f = np.fft.rfftfreq(length, balance.step)
    turn = 2.0 * np.pi * f
    band = BAND / balance.full_filter.width
    noise = _noise_spectrum(problem, balance, mass, f)
    # Frequencies within the filter band are suppressed: the force balance covers them, with other model errors.
    weight = (1.0 - np.exp(-((f / (0.5 * band)) ** 4))) / np.sqrt(noise)

    def spectrum(signal: np.ndarray) -> np.ndarray:
        ends = 2.0 * signal[0] - signal[reach:0:-1], 2.0 * signal[-1] - signal[-2 : -reach - 2 : -1]
        return np.fft.rfft(np.concatenate([ends[0], signal, ends[1]]), length)

    def at_samples(of: np.ndarray) -> np.ndarray:
        return np.fft.irfft(of, length)[reach:][samples]

    drive = spectrum(force)
    residual = at_samples(weight * (drive + mass * turn**2 * spectrum(balance.raw_position)))
    nuisance, _ = np.linalg.qr(np.column_stack([at_samples(weight * drive * (1j * f / band) ** k) for k in range(3)]))
    # If the residual exceeds the noise, its own scale is taken as the standard deviation.
    scale = robust_scale(residual)
    residual = np.clip(residual / scale, -6.0, 6.0)
    residual -= nuisance @ (nuisance.T @ residual)
    return _WhitenedRecord(residual, weight * drive / scale, f, samples, nuisance, length, reach, band)


def _away_from_events(balance: ForceBalanceRecord, width: float) -> np.ndarray:
    """Mask (n,) of the samples in motion, away from reversals, gaps and ends; `width` in samples."""
    out = np.ones(balance.size, dtype=bool)
    assert balance.slip_phases is not None and balance.reversals is not None and balance.stick_fraction is not None
    reach = int(np.ceil(EVENT_WIDTHS * width))
    for time in (*balance.slip_phases.end, *balance.slip_phases.break_away, *np.abs(balance.reversals)):
        if np.isfinite(time):
            out[max(0, int(time) - reach) : int(time) + reach + 2] = False
    edge = int(np.ceil(EDGE_WIDTHS * width))
    out[:edge] = out[-edge:] = False
    if balance.interpolated is not None:
        out &= ~dilated(longer_than(balance.interpolated, 1.0), reach)
    return out & (balance.stick_fraction < 1e-3)


def _noise_spectrum(problem: Problem, balance: ForceBalanceRecord, mass: float, f: np.ndarray) -> np.ndarray:
    """Noise power spectrum (k,) of force minus mass times acceleration, N^2, up to a common factor."""
    turn = 2.0 * np.pi * f
    motion = (mass * turn**2) ** 2
    of_spring = balance.force_channel != "drive_force"
    if "position" in problem.noise:
        moved = _power(problem.noise["position"], f, balance.step)
    elif "velocity" in problem.noise:
        moved = _power(problem.noise["velocity"], f, balance.step) / np.maximum(turn, turn[1]) ** 2
    else:
        moved = _power(problem.noise["spring_force"], f, balance.step) / balance.pull_stiffness**2
    name = "spring_force" if of_spring else "drive_force"
    if name in problem.noise:
        forced = _power(problem.noise[name], f, balance.step)
    else:
        forced = balance.pull_stiffness**2 * moved if of_spring else np.zeros(f.size)
    power = forced + motion * moved
    return np.maximum(power, 1e-9 * float(power.max()))


def _power(noise: Noise, f: np.ndarray, step: float) -> np.ndarray:
    """Power spectrum (k,) of a sensor's noise."""
    return noise.value**2 * noise.spectrum.power(2.0 * np.pi * f * step)


def _detection_statistic(records: Sequence[_WhitenedRecord], frequency: float, damping: float) -> tuple[float, float]:
    """Detection statistic of a small mode, in standard errors, and the part of the mass on it."""
    along = whole = 0.0
    for record in records:
        signal = record.signature(frequency, damping)
        along += float(signal @ record.residual)
        whole += float(signal @ signal)
    return (float(along / np.sqrt(whole)), along / whole) if whole > 0.0 else (0.0, 0.0)


def _estimate(
    records: Sequence[_WhitenedRecord], frequency: float, damping: float, part: float
) -> tuple[dict[str, float], dict[str, float]]:
    """Values of the mode and their standard deviations, by least squares from the maximum of the detection
    statistic."""
    # Imported here: the import takes half a second, and few records have such a mode.
    from scipy.optimize import least_squares

    part = min(part, 0.9)
    # The natural frequency of the mode on the free mass is that on a fixed mass over sqrt(1 - part).
    start = np.array([np.log(frequency * np.sqrt(1.0 - part)), np.log(damping), part])

    def left(point: np.ndarray) -> np.ndarray:
        f, d = np.exp(point[:2])
        return np.concatenate([r.residual - point[2] * r.signature(f, d, point[2]) for r in records])

    bounds = ([start[0] - 0.7, np.log(1e-3), 0.0], [start[0] + 0.7, np.log(0.35), 1.0])
    found = least_squares(left, start, bounds=bounds, x_scale=(0.01, 0.1, 0.01))
    spread_of = np.sqrt(np.diag(np.linalg.pinv(found.jac.T @ found.jac)))
    f, d = np.exp(found.x[:2])
    values = {"frequency": float(f), "damping": float(d), "mass_ratio": float(found.x[2])}
    noise = {"frequency": f * spread_of[0], "damping": d * spread_of[1], "mass_ratio": spread_of[2]}
    return values, {name: float(np.hypot(std, MODEL_ERROR[name] * values[name])) for name, std in noise.items()}
