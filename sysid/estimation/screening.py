"""Screening of candidate effects: score test over the shape grid, short fit from its best points, then a full refit.

Score (Lagrange multiplier) test: while they are small, the amplitudes of an effect enter the residual linearly. Its
shape parameters (Stribeck velocity, pitch, lag) have no gradient where the effect is absent and are searched on a grid.
At each grid point, with D the change of the residual per amplitude, Q an orthonormal basis of the Jacobian of the base
model and r its winsorised residual,

    predicted reduction = max over a of 1 - |M r - M D a|^2 / |M r|^2,    M = 1 - Q Q^T

so that the base parameters are profiled out (C. R. Rao, Proc. Cambridge Phil. Soc. 44 (1948) 50).

Pitches of a periodic effect follow from a least-squares periodogram of the residual over the position. The peak of a
pitch has a width of pitch^2 / range, so a grid over every pitch from the range of the position down to a five-hundredth
of it has thousands of points. With x the position, r the residual and e its change by the effect if it were uniform
(the effect with an infinite pitch),

    reduction(k) = max over a, b of |r|^2 - |r - e (a cos k x + b sin k x)|^2

follows at every wave number k from the Fourier transforms over x of the sums of r e and of e^2 (W. H. Press and
G. B. Rybicki, Astrophys. J. 338 (1989) 277; there with e = 1). The filter of a force balance is left out: it lowers the
amplitude, but moves no peak.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from sim.effects.effect import Effect, Parameter
from sysid.estimation.driven_stage_search import ROUNDS, lowest_minimum, slipping_starts, synchronised_starts
from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber
from sysid.estimation.friction_state_search import lowest_bristle_fit, lowest_gap_fit
from sysid.estimation.least_squares import robust_scale
from sysid.estimation.misfit import weighted_residual
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.friction_drive.record import FrictionDriveRecord
from sysid.prediction.model import Model, Scales, shape_grid, size_of, with_effect
from sysid.prediction.prepared_record import PreparedRecord

KEPT_SCORES = 6
"""Best grid points of an effect that are kept as starting points of its refit."""

IN_PAIRS = 2
"""Number of these that enter the joint test of two effects and keep their columns for it."""

EVERY_ROW = slice(None)

WINSOR = 8.0
"""Robust standard deviations at which the residual is winsorised."""

DEPENDENT = 1e-12
"""Eigenvalue of the scaled normal equations, relative to the largest, below which directions are linearly dependent."""


@dataclass(frozen=True)
class ScoreStatistic:
    """Score statistic of an effect at one grid point: share of the squared residual removed, base parameters profiled
    out; values to start a refit from; the grid point; values of each candidate direction, one amplitude away from zero;
    changes of the residual (n, k), base Jacobian projected out, empty beyond the first `IN_PAIRS` points; share that
    only an amplitude beyond its bound (a negative drag) would remove; and, for a friction core, which cannot be scaled,
    the share with unit amplitude."""

    predicted_reduction: float
    start: dict[str, float]
    shape: dict[str, float]
    directions: list[dict[str, float]]
    columns: np.ndarray
    blocked_reduction: float = 0.0
    full_step_reduction: float = 0.0


def project_out(columns: np.ndarray, base: np.ndarray) -> np.ndarray:
    """Part of each column (n, k) orthogonal to the orthonormal `base` (n, p)."""
    return columns - base @ (base.T @ columns)


def orthonormal(columns: np.ndarray) -> np.ndarray:
    """Orthonormal basis (n, r) of the span of the columns (n, p); zero and dependent columns are left out."""
    norms = np.linalg.norm(columns, axis=0)
    active = norms > 0.0
    if not active.any():
        return np.empty((columns.shape[0], 0))
    u, s, _ = np.linalg.svd(columns[:, active] / norms[active], full_matrices=False)
    return u[:, s > 1e-8 * s[0]]


@dataclass(frozen=True)
class GridPoint:
    """Change of a residual by an effect at one point of its shape grid: the point, parameter values of each candidate
    direction, one amplitude away from zero, and the changes (n, k) of selected rows."""

    shape: dict[str, float]
    directions: list[dict[str, float]]
    changes: np.ndarray


def candidate_directions(
    base: FittedModel, effect: Effect, records: Sequence[PreparedRecord], scales: Scales, rows: slice = EVERY_ROW
) -> list[GridPoint]:
    """Changes of the residual of a fitted model by an effect, at every point of its shape grid."""
    points = []
    for shape in _search_points(base, effect, records, scales):
        trial = with_effect(base.model, effect, scales, shape)
        directions = _directions(effect, scales)
        values = ({**trial.values, **direction} for direction in directions)
        moved = (weighted_residual(trial, records, base.weights, one) for one in values)
        matrix = np.column_stack([(base.fit.residual - residual)[rows] for residual in moved])
        if np.isfinite(matrix).all():
            points.append(GridPoint(shape, directions, matrix))
    return points


def _search_points(
    base: FittedModel, effect: Effect, records: Sequence[PreparedRecord], scales: Scales
) -> list[dict[str, float]]:
    """The shape grid of an effect; of a periodic one its long pitches, and those of the residual's periodogram."""
    grid, pitch = shape_grid(effect, scales), periodic_parameter(effect)
    found = pitches(base, effect, records, scales, profiled_residual(base)[1]) if pitch is not None else []
    if pitch is None or not found:
        return grid
    key = f"{effect.name}.{pitch.name}"
    return [p for p in grid if p[key] >= LONG * scales.position] + [{**grid[0], key: value} for value in found]


def _directions(effect: Effect, scales: Scales) -> list[dict[str, float]]:
    """One direction per amplitude, and a second one shifted by a quarter period if it has a phase; for a friction core
    the effect itself."""
    amplitudes = [p for p in effect.parameters if p.role == "amplitude" and not p.fixed]
    if not amplitudes or effect.friction_state is not None:
        return [{}]
    phases = [f"{effect.name}.{p.name}" for p in effect.parameters if p.role == "phase"]
    zero = {f"{effect.name}.{p.name}": 0.0 for p in amplitudes}
    directions: list[dict[str, float]] = []
    for amplitude in amplitudes:
        step = {**zero, f"{effect.name}.{amplitude.name}": 1e-3 * size_of(amplitude, scales)}
        directions += [step, *({**step, phase: 0.5 * np.pi} for phase in phases)]
    return directions


def score_test(
    effect: Effect, grid: Sequence[GridPoint], basis: np.ndarray, target: np.ndarray
) -> list[ScoreStatistic]:
    """Score statistics of an effect at the points of its shape grid, largest predicted reduction first."""
    total = float(target @ target) or 1.0
    scores: list[ScoreStatistic] = []
    for point in grid:
        free = project_out(point.changes, basis)
        normal, right = free.T @ free, free.T @ target
        norms = np.sqrt(np.diag(normal))
        if not (norms > 1e-9 * np.linalg.norm(point.changes, axis=0)).any():
            continue
        amplitudes = _amplitudes(effect, normal, right, np.where(norms > 0.0, norms, 1.0))
        reduction, blocked = float((2.0 * right - normal @ amplitudes) @ amplitudes) / total, 0.0
        if out_of_bounds(effect, point.directions, amplitudes):
            reduction, blocked = 0.0, reduction
        full = float(2.0 * right[0] - normal[0, 0]) / total if effect.friction_state is not None else reduction
        start = start_for(effect, point.shape, point.directions, amplitudes)
        scores.append(ScoreStatistic(reduction, start, point.shape, point.directions, free, blocked, full))
        if len(scores) > KEPT_SCORES:
            largest = max(s.full_step_reduction for s in scores)
            removable = [score for score in scores if score.full_step_reduction < largest] or scores
            scores.remove(min(removable, key=lambda s: (s.predicted_reduction, s.blocked_reduction)))
    scores.sort(key=lambda s: -s.predicted_reduction)
    return [*scores[:IN_PAIRS], *(replace(s, columns=s.columns[:, :0].copy()) for s in scores[IN_PAIRS:])]


def _amplitudes(effect: Effect, normal: np.ndarray, right: np.ndarray, norms: np.ndarray) -> np.ndarray:
    """Amplitudes (k,) of the directions of an effect; not negative where several may not be, as weights of plays."""
    own = [p for p in effect.parameters if p.role == "amplitude" and not p.fixed]
    scaled = normal / np.outer(norms, norms)
    free = np.linalg.pinv(scaled, rcond=DEPENDENT, hermitian=True) @ (right / norms) / norms
    if len(own) != right.size or right.size < 2 or any(p.low < 0.0 for p in own) or (free >= 0.0).all():
        return free
    # |D a - r|^2 is |L^T a - L^-1 D^T r|^2 up to a constant, with L L^T = D^T D.
    values, vectors = np.linalg.eigh(scaled)
    kept = values > DEPENDENT * values[-1]
    root = (vectors[:, kept] * np.sqrt(values[kept])).T
    found, _ = nnls(root, (vectors[:, kept].T @ (right / norms)) / np.sqrt(values[kept]))
    return found / norms


def out_of_bounds(effect: Effect, directions: list[dict[str, float]], coefficients: np.ndarray) -> bool:
    """Whether the estimate of the only amplitude of an effect is beyond its bound at zero."""
    amplitudes = [p for p in effect.parameters if p.role == "amplitude" and not p.fixed]
    if effect.friction_state is not None or len(amplitudes) != 1 or len(directions) != 1:
        return False
    wanted = float(coefficients[0])
    return (wanted < 0.0 <= amplitudes[0].low) or (wanted > 0.0 >= amplitudes[0].high)


def start_for(
    effect: Effect, shape: dict[str, float], directions: list[dict[str, float]], weights: np.ndarray
) -> dict[str, float]:
    """Starting values of a refit: a grid point, with the amplitudes, within their bounds, and phases of the linear
    weights (k,) of its directions."""
    if effect.friction_state is not None or not any(directions):
        return dict(shape)
    start: dict[str, float] = {}
    phase = next((p for p in effect.parameters if p.role == "phase"), None)
    for k, direction in enumerate(directions):
        key = next(name for name, value in direction.items() if value != 0.0)
        value = direction[key] * float(weights[k])
        phase_key = f"{effect.name}.{phase.name}" if phase is not None else ""
        if phase_key in direction:
            sine = start[key]
            start[key] = float(np.hypot(sine, value))
            start[phase_key] = float(np.arctan2(value, sine))
        else:
            start[key] = value
    for parameter in effect.parameters:
        key = f"{effect.name}.{parameter.name}"
        if key in start:
            start[key] = min(max(start[key], parameter.low), parameter.high)
    return {**shape, **start}


def profiled_residual(base: FittedModel, rows: slice = EVERY_ROW) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal basis (n, p) of the Jacobian of a fitted model at selected rows, and its winsorised residual (n,)
    at these rows with that basis projected out."""
    basis = orthonormal(base.fit.jacobian[rows])
    corner = WINSOR * robust_scale(base.fit.residual)
    clipped = np.clip(base.fit.residual[rows], -corner, corner)
    return basis, clipped - basis @ (basis.T @ clipped)


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
    base: FittedModel, effect: Effect, records: Sequence[PreparedRecord], scales: Scales, target: np.ndarray
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


class Reductions(NamedTuple):
    """Shares of the squared residual: that an effect removes by the score test, and that only amplitudes beyond their
    bounds would remove."""

    predicted: float = 0.0
    blocked: float = 0.0


UNSCREENED = Reductions()


@dataclass(frozen=True)
class ScoredCandidate:
    """A candidate effect with its score statistics over the shape grid, best first, before any fit."""

    effect: Effect
    scores: list[ScoreStatistic]

    @property
    def score(self) -> float:
        """Largest predicted reduction; infinite without any score, where only a fit shows the reduction."""
        return max((score.full_step_reduction for score in self.scores), default=np.inf)

    @property
    def promise(self) -> float:
        """Largest predicted reduction with any amplitude; infinite where only a fit shows it (friction states)."""
        unknown = not self.scores or self.effect.friction_state is not None
        return np.inf if unknown else max(score.predicted_reduction for score in self.scores)

    @property
    def linear(self) -> bool:
        """Whether the effect has amplitudes, so that the score test applies to it."""
        return bool(self.scores) and any(p.role == "amplitude" for p in self.effect.parameters)


@dataclass(frozen=True)
class ScreeningFit(ScoredCandidate):
    """A scored candidate with a fit from its best starting points."""

    fitted: FittedModel

    @property
    def reductions(self) -> Reductions:
        """Its reductions by the score test."""
        blocked = max((score.blocked_reduction for score in self.scores), default=0.0)
        return Reductions(max(self.scores[0].predicted_reduction, 0.0), blocked)

    @property
    def error(self) -> float:
        """Root mean Huber loss of the short fit on its own records, in standard deviations."""
        return root_mean_huber(self.fitted.fit.residual)


SHORT = 4
"""Steps of a screening fit."""

SHORT_OF_PROMISE = 4.0
"""Cost of a short fit over that promised by the score test, twice its error, from which the fit is continued."""

FAR = 5.0
"""Root mean Huber loss on a driven stage above which the score test does not give reliable starting points."""
STARTS_FROM_AFAR = 3
STEPS_FROM_AFAR = 8
"""Grid points, and steps of the screening fit from each, in that case."""

SHOWS_PROMISE = 0.5
"""Fraction of the error of the base model below which lower minima near the fit of a driven stage are searched."""


def screen_scored(
    known: ScoredCandidate,
    base: FittedModel,
    records: Sequence[PreparedRecord],
    scales: Scales,
    basis: np.ndarray,
    rows: slice = EVERY_ROW,
) -> ScreeningFit | None:
    """Short fit of a scored candidate from its best starting points; None if it does not change the prediction."""
    effect, scores = known.effect, known.scores
    far = any(isinstance(r, FrictionDriveRecord) for r in records) and root_mean_huber(base.fit.residual) > FAR
    starts = _screening_starts(known, base, records, scales, far)
    if not starts:
        return None
    steps = STEPS_FROM_AFAR if far else SHORT
    fits = [fit_model(start, records, base.weights, steps, near=base, final_jacobian=False) for start in starts]
    nearest = min(fits, key=lambda fitted: fitted.fit.cost)
    promised = 1.0 - max((score.predicted_reduction for score in scores), default=0.0)
    if not nearest.fit.converged and nearest.fit.cost > SHORT_OF_PROMISE * promised * base.fit.cost:
        # A few steps do not follow a narrow valley of correlated values to its lowest point.
        nearest = fit_model(nearest.model, records, base.weights, near=nearest, final_jacobian=False)
    if known.linear and nearest.fit.cost > base.fit.cost:
        # Too large an amplitude, where one of the base model could take its place: without any the error is lower.
        start = with_effect(base.model, effect, scales, {**scores[0].start, **_amplitudes_of_none(effect)})
        other = fit_model(start, records, base.weights, steps, near=base, final_jacobian=False)
        nearest = min(nearest, other, key=lambda fitted: fitted.fit.cost)
    nearest = lowest_gap_fit(base, nearest, effect, records, scales)
    if not scores:
        # No gradient at the start: the change of the residual by the fit replaces the directions.
        own = {key: value for key, value in nearest.model.values.items() if key.startswith(f"{effect.name}.")}
        change = project_out((base.fit.residual - nearest.fit.residual)[rows, None], basis)
        scores = [ScoreStatistic(0.0, own, own, [{}], change)]
    return ScreeningFit(effect, scores, nearest)


def _amplitudes_of_none(effect: Effect) -> dict[str, float]:
    """Amplitudes of an effect that is absent: zero, or the bound nearest to it."""
    amplitudes = [p for p in effect.parameters if p.role == "amplitude"]
    return {f"{effect.name}.{p.name}": min(max(0.0, p.low), p.high) for p in amplitudes}


def _screening_starts(
    known: ScoredCandidate, base: FittedModel, records: Sequence[PreparedRecord], scales: Scales, far: bool
) -> list[Model]:
    """Models with the candidate at the starting points of its screening fits; `far`: on a driven stage, the error of
    the base model is large."""
    effect, scores = known.effect, known.scores
    points = [score.start for score in (_distinct(scores, STARTS_FROM_AFAR) if far and scores else scores[:1])]
    if scores and effect.friction_state is not None:
        # A long presliding displacement may have the best score with a small weight, a short one with unit weight.
        best = max(scores, key=lambda score: score.full_step_reduction).start
        points += [best] if best is not points[0] else []
    starts = [with_effect(base.model, effect, scales, point) for point in points]
    starts += slipping_starts(base.model, effect, records, scales, far, points[0] if points else None)
    if starts and far:
        starts += synchronised_starts(starts, records, base.weights, STEPS_FROM_AFAR)
    return starts


def refit_candidate(
    base: FittedModel, screened: ScreeningFit, records: Sequence[PreparedRecord], scales: Scales
) -> ScreeningFit:
    """Refit of a screened effect from its screening fit and from other points of the grid; the fit of lowest cost."""
    best = fit_model(screened.fitted.model, records, base.weights, near=screened.fitted)
    for score in _distinct(screened.scores, 2)[1:]:
        start = with_effect(base.model, screened.effect, scales, score.start)
        fitted = fit_model(start, records, base.weights, near=base)
        if fitted.fit.cost < best.fit.cost:
            best = fitted
    if screened.effect.has_presliding:
        best = lowest_bristle_fit(best, records, scales, base.weights)
    return replace(screened, fitted=best)


def search_lower_minimum(
    base: FittedModel, fitted: FittedModel, records: Sequence[PreparedRecord], of_contact: bool = False
) -> FittedModel:
    """The fit of a model with one effect more than the base model, moved to the lowest nearby local minimum of the cost
    on a driven stage."""
    promising = root_mean_huber(fitted.fit.residual) <= SHOWS_PROMISE * root_mean_huber(base.fit.residual)
    return lowest_minimum(fitted, records, 1 if of_contact else ROUNDS) if of_contact or promising else fitted


def screen_and_refit(
    base: FittedModel,
    effect: Effect,
    records: Sequence[PreparedRecord],
    scales: Scales,
    profiled: tuple[np.ndarray, np.ndarray],
) -> ScreeningFit | None:
    """Screening and full refit of one effect; None if it does not change the prediction."""
    scores = score_test(effect, candidate_directions(base, effect, records, scales), *profiled)
    screened = screen_scored(ScoredCandidate(effect, scores), base, records, scales, profiled[0])
    return refit_candidate(base, screened, records, scales) if screened is not None else None


def _distinct(scores: list[ScoreStatistic], count: int) -> list[ScoreStatistic]:
    """The best score, and further ones of at least half its reduction with distinct starting values."""
    chosen = [scores[0]]
    for score in scores[1:]:
        if len(chosen) >= count:
            break
        strong = score.predicted_reduction > 0.5 * scores[0].predicted_reduction
        if strong and all(_apart(score.start, other.start) for other in chosen):
            chosen.append(score)
    return chosen


def _apart(a: dict[str, float], b: dict[str, float]) -> bool:
    """Whether some value of two points differs by more than 30 %."""
    return any(abs(a[k] - b.get(k, 0.0)) > 0.3 * max(abs(a[k]), abs(b.get(k, 0.0))) for k in a)
