"""T-optimal design of the next experiment: the motion that best discriminates the competing models per second.

The discrimination distance of two models j and k is the difference of their predictions that remains after one is
refitted to the other (Atkinson and Fedorov, Biometrika 62 (1975) 57):

    distance^2 = min over j, k of min over theta_k of sum_i (y_j(t_i) - y_k(t_i; theta_k))^2 / sigma_i^2

with all parameters of model k free, refitted from several starts. The sum is scaled to the number of independent
samples. Squared distances add over experiments, so motions are ordered by their smallest squared distance per second.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from sysid.diagnose import Diagnosis, diagnose
from sysid.diagnosis.candidate import Candidate
from sysid.diagnosis.candidate_screening import Progress
from sysid.estimation.fit import residual_function
from sysid.estimation.least_squares import FitResult, least_squares
from sysid.estimation.misfit import ResidualWeights, residual_weights
from sysid.experiment.experiment import DesignValues
from sysid.experiment.known import Unknown
from sysid.experiment.ladder import read_history
from sysid.prediction.actuator_tip import TipRecord
from sysid.prediction.force_balance.record import ForceBalanceRecord, make_axis
from sysid.prediction.friction_drive.record import FrictionDriveRecord
from sysid.prediction.model import Model, predict, scales_of, shape_grid
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.problem import Problem, build_problem, load_problem
from sysid.signals import GaussianFilter, dilated


@dataclass(frozen=True)
class Envelope:
    """Ranges of the motion in the records of an axis, SI: ends of the travel, highest speed, high quantile of the
    acceleration, smallest useful amplitude of a reversal (well above the position's noise), and range of the normal
    load if it was varied."""

    low: float
    high: float
    speed: float
    acceleration: float
    fine: float
    load: tuple[float, float] | None = None


@dataclass(frozen=True)
class Motion:
    """A motion to run: its name, the effects to which it is sensitive as text, signals (n,) in SI (`position`, or
    `voltage_1`, `voltage_2`, ..., and `normal_load` if it is to be varied), and sampling step, s."""

    name: str
    reason: str
    signals: dict[str, np.ndarray]
    step: float

    @property
    def seconds(self) -> float:
        """Duration, s."""
        return self.step * (next(iter(self.signals.values())).size - 1)


def axis_motions(envelope: Envelope, step: float, longest: float = 40.0, most: int = 4000) -> list[Motion]:
    """Excitations of an axis, sampled at `step` (s), or more coarsely if a motion would exceed `most` samples.

    The last one is space-filling: targets, speeds and rests from a low-discrepancy sequence.
    """
    e = envelope
    middle, span = 0.5 * (e.low + e.high), e.high - e.low
    speeds = e.speed * np.array([1.0, 0.3, 0.1, 0.03, 0.01])
    made = []

    def add(name: str, reason: str, legs: Iterable[tuple[float, float, float]], load: bool = False) -> None:
        listed, seconds = _within(legs, middle, longest)
        if not listed:
            return
        own = max(step, seconds / most)
        position = _track(listed, middle, own, e)
        signals = {"position": position}
        if load and e.load is not None:
            t = np.arange(position.size) * own
            swing = np.sin(2.0 * np.pi * 3.0 * t / max(t[-1], own))
            signals["normal_load"] = 0.5 * sum(e.load) + 0.5 * (e.load[1] - e.load[0]) * swing
        made.append(Motion(name, reason, signals, own))

    strokes = [(v, min(0.8 * span, 1.2 * v)) for v in speeds]
    sides = (1.0, -1.0)
    legs = [(middle + 0.5 * side * stroke, v, 0.0) for v, stroke in strokes for side in 2 * sides]
    add("triangle sweeps", "steady-state friction against speed, in both directions", legs)
    amplitudes = np.geomspace(max(e.fine, 1e-4 * span), 0.05 * span, 5)
    legs = [(middle + side * a, min(0.05 * e.speed, 4.0 * a), 0.0) for a in amplitudes for side in 3 * sides]
    add("presliding reversals", "reversals of increasing amplitude, from the presliding range on", legs)
    stroke = min(0.1 * span, 0.2 * e.speed)
    rests = (0.05, 0.15, 0.5, 1.5, 4.0)
    legs = [(middle + 0.5 * side * stroke, 0.1 * e.speed, rest) for rest in rests for side in sides]
    add("dwell ladder", "starts after rests of increasing duration, in both directions", legs)
    slow = max(0.03 * e.speed, span / 12.0)
    legs = [(place, slow, 0.0) for place in (e.high, e.low, middle)]
    add("slow full travel", "effects of position and direction, at one speed", legs)
    legs = [(place, e.speed, 0.0) for place in 8 * (e.high, e.low)]
    add("fast full strokes", "effects of speed, acceleration and distance travelled", legs)
    if e.load is not None:
        legs = [(middle + 0.3 * side * span, 0.2 * e.speed, 0.0) for side in 6 * sides]
        add("strokes under a varied load", "effects of the normal load", legs, load=True)
    made.append(_multisine(e, step, most))
    reason = "any effect: positions, speeds and rests of a low-discrepancy sequence"
    add("space-filling", reason, _space_filling(e), load=e.load is not None)
    return made


def _within(
    legs: Iterable[tuple[float, float, float]], start: float, longest: float
) -> tuple[list[tuple[float, float, float]], float]:
    """Legs (target, speed, subsequent rest) up to the longest duration, and their duration, s."""
    kept, total, at = [], 0.0, start
    for target, speed, rest in legs:
        seconds = abs(target - at) / speed + rest
        if total + seconds > longest:
            break
        kept.append((target, speed, rest))
        total, at = total + seconds, target
    return kept, total


def _track(legs: Sequence[tuple[float, float, float]], start: float, step: float, e: Envelope) -> np.ndarray:
    """Position (n,) along the legs, its corners rounded so that the highest speed is reached at the acceleration."""
    times, places = [0.0], [start]
    for target, speed, rest in legs:
        times.append(times[-1] + abs(target - places[-1]) / speed)
        places.append(target)
        if rest > 0.0:
            times.append(times[-1] + rest)
            places.append(target)
    t = np.arange(0.0, times[-1], step)
    position = np.interp(t, times, places)
    half = max(2, int(np.ceil(min(0.1, e.speed / max(e.acceleration, 1e-9)) / step)))
    window = np.hanning(2 * half + 1)
    return np.convolve(np.pad(position, half, mode="edge"), window / window.sum(), mode="valid")


def _multisine(e: Envelope, step: float, most: int) -> Motion:
    """Sum of sines at eight geometrically spaced frequencies with Schroeder phases, scaled to speed and travel."""
    seconds = 10.0
    own = max(step, seconds / most)
    t = np.arange(0.0, seconds, own)
    frequencies = np.round(np.geomspace(0.2, min(12.0, 0.05 / own), 8) * seconds) / seconds
    wave = np.zeros(t.size)
    for k, f in enumerate(np.unique(frequencies)):
        wave += np.cos(2.0 * np.pi * f * t - np.pi * k * (k + 1) / 8.0) / f
    wave -= wave.mean()
    by_speed = 0.8 * e.speed / float(np.max(np.abs(np.gradient(wave, own))))
    wave *= min(by_speed, 0.4 * (e.high - e.low) / float(np.max(np.abs(wave))))
    signals = {"position": 0.5 * (e.low + e.high) + wave}
    return Motion("multisine", "dynamics: lags, delays, flexible modes", signals, own)


def _low_discrepancy(count: int) -> np.ndarray:
    """Halton's sequence of the bases 2, 3 and 5 without its origin, (count, 3)."""
    from scipy.stats import qmc

    return qmc.Halton(3, scramble=False).random(count + 1)[1:]


def _space_filling(e: Envelope) -> list[tuple[float, float, float]]:
    legs, at = [], 0.5 * (e.low + e.high)
    for k, (place, slowness, pause) in enumerate(_low_discrepancy(24).tolist(), start=1):
        speed = e.speed * 10.0 ** (-2.0 * slowness)
        target = e.low + (e.high - e.low) * (0.05 + 0.9 * place)
        # Legs are limited to two seconds, so that a slow leg covers only part of the travel.
        target = at + float(np.clip(target - at, -2.0 * speed, 2.0 * speed))
        rest = 0.0 if k % 3 else 0.05 * 30.0**pause
        legs.append((target, speed, rest))
        at = target
    return legs


def tip_motions(low: Sequence[float], high: Sequence[float], step: float, most: int = 6000) -> list[Motion]:
    """Excitations of an actuator's tip: voltages of each piezo within `low` and `high` (V); the last is
    space-filling."""
    count = len(low)
    middle = [0.5 * (a + b) for a, b in zip(low, high, strict=True)]
    reach = [0.45 * (b - a) for a, b in zip(low, high, strict=True)]

    def made(name: str, reason: str, waves: Sequence[np.ndarray], own: float) -> Motion:
        signals = {f"voltage_{k + 1}": middle[k] + reach[k] * waves[k] for k in range(count)}
        return Motion(name, reason, signals, own)

    def grid(seconds: float) -> tuple[np.ndarray, float]:
        own = max(step, seconds / most)
        return np.arange(0.0, seconds, own), own

    motions = []
    t, own = grid(12.0)
    steps = np.array([0.0, 1.0, -1.0, 0.5, -0.5, 0.0])[np.minimum((t / 2.0).astype(int), 5)]
    motions.append(made("steps, then rest", "creep, lag, delay", [steps] * count, own))
    t, own = grid(16.0)
    ramp = _triangle(t, 4.0) * np.array([1.0, 0.7, 0.4, 0.2])[np.minimum((t / 4.0).astype(int), 3)]
    motions.append(made("slow ramps of falling height", "hysteresis and nonlinearity", [ramp] * count, own))
    t, own = grid(6.0)
    top = min(200.0, 0.1 / own)
    phase = 2.0 * np.pi * 0.5 * 6.0 / np.log(top / 0.5) * ((top / 0.5) ** (t / 6.0) - 1.0)
    motions.append(made("sine of rising frequency", "lag and delay, flexible modes", [np.sin(phase)] * count, own))
    t, own = grid(8.0)
    alone = [
        _triangle(t, 8.0 / count / 2.0) * ((t >= 8.0 * k / count) & (t < 8.0 * (k + 1) / count)) for k in range(count)
    ]
    motions.append(made("one piezo at a time", "gains that differ between the piezos", alone, own))
    t, own = grid(15.0)
    waves = []
    for k in range(count):
        index = np.minimum((t / 0.5).astype(int), 29)
        levels = 2.0 * _low_discrepancy(30)[:, k % 3] - 1.0
        tone = np.sin(2.0 * np.pi * np.array([0.0, 3.0, 0.0, 11.0, 40.0])[index % 5] * t)
        waves.append(np.clip(0.8 * levels[index] + 0.2 * tone, -1.0, 1.0))
    motions.append(
        made("space-filling", "any effect: levels, frequencies and rests of a low-discrepancy sequence", waves, own)
    )
    return motions


def _triangle(t: np.ndarray, period: float) -> np.ndarray:
    return 2.0 / np.pi * np.arcsin(np.sin(2.0 * np.pi * t / period))


MOST_MODELS = 4
COMPETING_ERROR = 2.0
"""Largest ratio of the held-out error of a competing model to that of the best candidate."""

SHAPES, COARSE_STEPS, REFINED = 16, 4, 3
"""Of the fit of one model to the predictions of another: shapes that it starts from, steps of each start, and starts
that are refined."""
REFIT_STEPS, REFIT_TOLERANCE = 60, 1e-8
"""Of each refinement: the distance is exact at the minimum only."""

SCORED = 4000
"""Largest number of samples from which the distance on the present records is computed."""


@dataclass(frozen=True)
class Discrimination:
    """Discrimination distance of two competing models."""

    effects: tuple[str, str]  # names of the effects of the two models
    deviations: float  # distance on the motion, in standard deviations
    records: float  # distance on the records of the fit, in standard deviations


@dataclass(frozen=True)
class RankedMotion:
    """Design value of a motion."""

    motion: Motion  # the motion
    pairs: tuple[Discrimination, ...]  # distances of the competing models, smallest first
    least: float = 0.0  # smallest distance among the models that at least one motion discriminates

    @property
    def rate(self) -> float:
        """Smallest squared distance per second of machine time."""
        return self.least**2 / self.motion.seconds if self.motion.seconds > 0 else 0.0


@dataclass(frozen=True)
class Suggestion:
    """Ranked motions for the next experiment."""

    problem: Problem  # the diagnosed problem
    diagnosis: Diagnosis  # of the present model, or, if no effect is missing, of the model without its last effect
    competing: tuple[str, ...]  # names of the effects compared, best first
    motions: tuple[RankedMotion, ...]  # best first, the space-filling one last
    inseparable: tuple[str, ...] = ()  # models that no motion discriminates from the first
    revisited: str | None = None  # the effect added last, if it is compared with its alternatives


def suggest(
    source: str | Path | Problem, design: DesignValues | None = None, progress: Progress | None = None
) -> Suggestion:
    """Diagnose an experiment, and rank motions by how well they discriminate the models that remain.

    If no effect is missing, the effect added last is compared with its alternatives. With a single model only the
    space-filling motion is returned.
    """
    problem = source if isinstance(source, Problem) else load_problem(source, design)
    found = diagnose(problem, progress=progress)
    revisited = None
    if found.verdict != "missing-effect" and len(read_history(problem.experiment)) > 1:
        *before, last = problem.experiment.effects
        again = diagnose(build_problem(problem.experiment, problem.records, before), progress=progress)
        if again.verdict == "missing-effect":
            found, revisited = again, last
    return rank_motions(found, motions_for(found.problem), revisited, progress)


def rank_motions(
    found: Diagnosis, motions: Sequence[Motion], revisited: str | None = None, progress: Progress | None = None
) -> Suggestion:
    """Order motions by their design value for the competing models of a diagnosis."""
    competing = competing_models(found)
    filling, problem = motions[-1], found.problem
    names = [t.public_name for t in competing]
    if len(competing) < 2:
        return Suggestion(problem, found, tuple(names), (RankedMotion(filling, ()),), (), revisited)
    models = [t.fitted.model for t in competing]
    now = [_distance_on_records(problem, models[0], other) for other in models[1:]]
    found_pairs: list[list[Discrimination]] = []
    for k, motion in enumerate(motions):
        if progress is not None:
            progress(motion.name, k, len(motions))
        record, count = motion_record(problem, motion)
        weights = residual_weights(models[0], [record], thin=False)
        apart = [count * discrimination_distance(models[0], other, [record], weights) for other in models[1:]]
        found_pairs.append([Discrimination((names[0], n), a, h) for n, a, h in zip(names[1:], apart, now, strict=True)])
    if progress is not None:
        progress("", len(motions), len(motions))
    # Models that no motion discriminates are left out of the design value.
    same = [n for k, n in enumerate(names[1:]) if max(pairs[k].deviations for pairs in found_pairs) < 1.0]
    values = []
    for motion, pairs in zip(motions, found_pairs, strict=True):
        least = min((p.deviations for p in pairs if p.effects[1] not in same), default=0.0)
        values.append(RankedMotion(motion, tuple(sorted(pairs, key=lambda p: p.deviations)), least))
    ordered = sorted(values[:-1], key=lambda w: -w.rate)
    return Suggestion(problem, found, tuple(names), (*ordered, values[-1]), tuple(same), revisited)


def competing_models(found: Diagnosis) -> list[Candidate]:
    """The best candidate, those equivalent to it, and others of similar error; empty if no effect is missing."""
    best = found.best
    if best is None or found.verdict != "missing-effect" or any(e.rounds for e in best.added):
        # Quantisation is detected in the values of a channel and does not require a particular motion.
        return []
    rivals = [t for t in found.trials if t is not best and t.implausible is None]
    usable = [t for t in rivals if t.fitted.fit.keys and t.fit_gain > 0.0]
    tied = [t for t in usable if t.public_name in found.indistinguishable]
    others = [t for t in usable if t not in tied and t.gain.loss > 0.3 * best.gain.loss]
    near = [t for t in others if t.error <= COMPETING_ERROR * max(best.error, 1.0)]
    # Without one of similar error only the second-best candidate is kept.
    return [best, *tied, *(near or (others[:1] if not tied else []))][:MOST_MODELS]


def discrimination_distance(
    one: Model, other: Model, records: Sequence[PreparedRecord], weights: ResidualWeights
) -> float:
    """Discrimination distance of two models, each refitted to the other; the smaller of the two."""
    return min(_distance_after_refit(one, other, records, weights), _distance_after_refit(other, one, records, weights))


def _distance_after_refit(
    truth: Model, rival: Model, records: Sequence[PreparedRecord], weights: ResidualWeights
) -> float:
    posed = [replace(r, measured=predict(r, truth.effects, truth.values)) for r in records]
    residual = residual_function(rival, posed, weights)

    def fitted(unknowns: Sequence[Unknown], steps: int) -> FitResult:
        return least_squares(residual, unknowns, robust=False, iterations=steps, tolerance=REFIT_TOLERANCE)

    # From the present values, without the effect that the rival adds, and over its shapes: a record may leave several
    # minima, and at an amplitude of zero the shapes have no gradient.
    own = [effect for effect in rival.effects if effect.name not in {other.name for other in truth.effects}]
    amplitudes = [(e.name, q) for e in own for q in e.parameters if q.role == "amplitude"]
    absent = {f"{name}.{q.name}": min(max(0.0, q.low), q.high) for name, q in amplitudes}
    scales = scales_of(records)
    starts: list[Mapping[str, float]] = [{}, absent, *(shapes for e in own for shapes in shape_grid(e, scales, SHAPES))]

    def begun(values: Mapping[str, float]) -> list[Unknown]:
        return [replace(u, start=values.get(u.key, u.start)) for u in rival.unknowns]

    coarse = [fitted(begun(one), COARSE_STEPS) for one in starts]
    best = sorted(coarse, key=lambda fit: float(np.linalg.norm(fit.residual)))[:REFINED]
    return min(float(np.linalg.norm(fitted(begun(one.values), REFIT_STEPS).residual)) for one in best)


def _independent(problem: Problem, record: PreparedRecord, step: float) -> float:
    """Root of the number of independent samples per sample, `step` (s) apart."""
    colour = max((n.autocorrelation for n in problem.noise.values()), default=0.0)
    apart = max(record.step * (1.0 + colour) / max(1.0 - colour, 1e-3), record.filter_width)
    return float(np.sqrt(step / apart))


def _distance_on_records(problem: Problem, one: Model, other: Model) -> float:
    """Discrimination distance of two models on the records of the fit."""
    full = residual_weights(one, problem.fit_records)
    every = max(1, sum(max((p.size for p in pick.values()), default=0) for pick in full.samples) // SCORED)
    samples = tuple(
        {c: _away_from_reversals(record, p)[::every] for c, p in pick.items()}
        for record, pick in zip(problem.fit_records, full.samples, strict=True)
    )
    record = problem.fit_records[0]
    gap = every * max(1, int(record.filter_width / record.step)) * record.step
    distance = discrimination_distance(one, other, problem.fit_records, replace(full, samples=samples))
    return _independent(problem, record, gap) * distance


def _near_reversals(record: ForceBalanceRecord, reach: int) -> np.ndarray:
    """Mask (n,) of the samples near a reversal (in samples or in distance) or at rest, which are not scored."""
    direction = record.axis.direction if record.direction is None else record.direction
    turns = np.concatenate([[False], direction[1:] != direction[:-1]])
    turning = dilated(turns, reach) | (record.axis.reversal_distance < 4.0 * record.stretch)
    if record.acceleration is not None:
        # At rest friction equals the drive force for any friction law.
        turning |= dilated(record.axis.contact_age > 0.0, reach)
    return turning


def _away_from_reversals(record: PreparedRecord, pick: np.ndarray) -> np.ndarray:
    if not isinstance(record, ForceBalanceRecord):
        return pick
    return pick[~_near_reversals(record, 2 + int(np.ceil(5.0 * record.filter_width / record.step)))[pick]]


def motions_for(problem: Problem) -> list[Motion]:
    """Excitations for a problem's rig, within the ranges of its records."""
    first = problem.fit_records[0]
    driven = [r for r in problem.fit_records if isinstance(r, TipRecord | FrictionDriveRecord)]
    if driven:
        drives = [np.concatenate(u) for u in zip(*(r.drives for r in driven), strict=True)]
        return tip_motions([float(u.min()) for u in drives], [float(u.max()) for u in drives], first.step)
    return axis_motions(envelope_of(problem), first.step)


def envelope_of(problem: Problem) -> Envelope:
    """Ranges of travel, speed and acceleration in the records of the fit."""
    axes = [r.axis for r in problem.fit_records if isinstance(r, ForceBalanceRecord)]
    first = problem.fit_records[0]
    assert isinstance(first, ForceBalanceRecord)
    position = np.concatenate([a.position for a in axes])
    speed = float(np.quantile(np.abs(np.concatenate([a.velocity for a in axes])), 0.998))
    acceleration = float(np.quantile(np.abs(np.concatenate([a.acceleration for a in axes])), 0.98))
    load = np.concatenate([a.load for a in axes])
    noise = problem.noise.get("position")
    span = float(np.ptp(position))
    fine = max(30.0 * noise.value if noise is not None else 0.0, 1e-5 * span)
    varied = float(np.ptp(load)) > 0.05 * abs(float(np.mean(load)))
    low, high = (float(q) for q in np.quantile(load, (0.02, 0.98)))
    ends = float(position.min()), float(position.max())
    return Envelope(*ends, speed, max(acceleration, speed / 0.1), fine, load=(low, high) if varied else None)


def motion_record(problem: Problem, motion: Motion) -> tuple[PreparedRecord, float]:
    """A prepared record of a motion that the rig follows exactly, and the weight of its samples.

    On a rig that drives a mass the motion is the reference of the axis, and models are compared in the force.
    """
    first = problem.fit_records[0]
    n = next(iter(motion.signals.values())).size
    if isinstance(first, TipRecord | FrictionDriveRecord):
        bias = problem.experiment.rig.known.get("bias_voltage")
        drives = [motion.signals[f"voltage_{k + 1}"] - (bias.value if bias else 0.0) for k in range(len(first.drives))]
        return first.driven_by(motion.name, motion.step, drives), _independent(problem, first, motion.step)
    assert isinstance(first, ForceBalanceRecord)
    position = motion.signals["position"]
    velocity = np.gradient(position, motion.step)
    acceleration = np.gradient(velocity, motion.step)
    load = motion.signals.get("normal_load", np.full(n, problem.scales.load_mean))
    warmth = np.full(n, problem.scales.temperature_mean)
    rest = 1e-6 * float(np.max(np.abs(velocity)))
    axis = make_axis(np.arange(n) * motion.step, position, velocity, acceleration, load, warmth, rest)
    channel = first.force_channel
    width = first.filter_width
    margin = int(np.ceil(4.0 * width / motion.step)) + 1
    inside = (np.arange(n) >= margin) & (np.arange(n) < n - margin)
    record = replace(
        first,
        name=motion.name,
        step=motion.step,
        axis=axis,
        measured={channel: np.zeros(n)},
        valid={channel: inside},
        noise={channel: first.noise[channel]},
        acceleration=None if first.acceleration is None else acceleration,
        stick_fraction=None,
        complementary_filter=GaussianFilter(width, motion.step, n),
        full_filter=None,
        direction=None,
        velocity_sign=None,
        half_width_variant=None,
        inputs={"pull_position": position, "spring_force": np.zeros(n)},
        applied=None,
        stick_phases=None,
        redrawn=(),
    )
    record.valid[channel] = inside & ~_near_reversals(record, 2 + int(np.ceil(5.0 * width / motion.step)))
    return record, _independent(problem, first, motion.step)


def columns_of(problem: Problem, motion: Motion) -> dict[str, np.ndarray]:
    """The motion as a table: columns `name [unit]` in SI, (n,) each, `time [s]` first."""
    unit = "rad" if problem.experiment.rig.rotary else "m"
    n = next(iter(motion.signals.values())).size
    table = {"time [s]": np.arange(n) * motion.step}
    for name, values in motion.signals.items():
        if name == "position":
            # On this rig the motion is imposed on the end of the pulling spring.
            inputs = problem.experiment.rig.declaration.input_channels
            table[f"{'pull_position' if 'pull_position' in inputs else 'position'} [{unit}]"] = values
            if "velocity" in inputs:
                table[f"velocity [{unit}/s]"] = np.gradient(values, motion.step)
        else:
            table[f"{name} [{'V' if name.startswith('voltage') else 'N'}]"] = values
    return table
