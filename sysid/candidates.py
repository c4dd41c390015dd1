"""Every effect that may be missing, tried: a linear score orders the starts, a refit decides.

An effect's amplitudes enter the residual linearly while they are small; its shape parameters (a Stribeck velocity, a
pitch, a lag) have no gradient where the effect is absent, so they are searched on a grid, and at each grid point the
drop in squared residual is found with the base model's parameters free to move. A few steps of a fit from the best
point show what the effect is good for; the best effects are then refitted in full.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim.effect import Effect
from sysid.base_fit import Fitted, fit_model, ranking_error
from sysid.driven_stage_starts import slipping_starts
from sysid.driven_stage_valleys import ROUNDS, lowest_valley
from sysid.fit import robust_scale
from sysid.friction_drive import FrictionDriveRecord
from sysid.held_fits import led
from sysid.misfit import weighted_residual
from sysid.model import Prepared, Scales, shape_grid, size_of, with_effect

KEPT_SCORES = 6
"""Grid points of an effect that are remembered: starts for its refit."""

WINSOR = 8.0
"""Robust deviations beyond which a residual counts no more in the linear score."""


@dataclass(frozen=True)
class Score:
    """Linear score of an effect at one grid point.

    Args:
        drop: expected share of the squared residual that goes, base parameters free.
        start: values to start a refit from.
        shape: the grid point.
        moves: parameter values of each move, amplitudes away from zero.
        columns: what each move does to the residual beyond what the base parameters can do, (n, k).
        barred: drop that amplitudes beyond their bounds (a negative drag) would have made.
        whole: of a core, the drop as it stands: it is there or not, half of it is no model.
    """

    drop: float
    start: dict[str, float]
    shape: dict[str, float]
    moves: list[dict[str, float]]
    columns: np.ndarray
    barred: float = 0.0
    whole: float = 0.0


def _project_out(columns: np.ndarray, base: np.ndarray) -> np.ndarray:
    """Part of each column (n, k) that the orthonormal `base` (n, p) cannot make."""
    return columns - base @ (base.T @ columns)


def orthonormal(columns: np.ndarray) -> np.ndarray:
    """Orthonormal basis (n, r) of the span of the columns, dead and dependent ones left out."""
    norms = np.linalg.norm(columns, axis=0)
    alive = norms > 0.0
    if not alive.any():
        return np.empty((columns.shape[0], 0))
    scaled = columns[:, alive] / norms[alive]
    u, s, _ = np.linalg.svd(scaled, full_matrices=False)
    return u[:, s > 1e-8 * s[0]]


def linear_scores(
    base: Fitted, effect: Effect, records: Sequence[Prepared], scales: Scales, basis: np.ndarray, target: np.ndarray
) -> list[Score]:
    """Scores of an effect at every point of its shape grid, best first.

    Args:
        base: the fitted base model.
        effect: the candidate.
        records: those fitted.
        scales: of the records.
        basis: orthonormal basis of the base model's Jacobian, (n, p).
        target: residual of the base model, winsorised, with the basis projected out, (n,).
    """
    total = float(target @ target) or 1.0
    residual = base.fit.residual
    amplitudes = [p for p in effect.parameters if p.role == "amplitude" and not p.fixed]
    phases = [p for p in effect.parameters if p.role == "phase"]
    scores = []
    for shape in shape_grid(effect, scales):
        trial = with_effect(base.model, effect, scales, shape)
        zero = {f"{effect.name}.{p.name}": 0.0 for p in amplitudes}
        moves: list[dict[str, float]] = []
        if not amplitudes or effect.core is not None:
            moves.append({})
        else:
            for amplitude in amplitudes:
                key = f"{effect.name}.{amplitude.name}"
                step = 1e-3 * size_of(amplitude, scales)
                moves.append({**zero, key: step})
                for phase in phases:
                    moves.append({**zero, key: step, f"{effect.name}.{phase.name}": 0.5 * np.pi})
        columns = []
        for move in moves:
            moved = weighted_residual(trial, records, base.weights, {**trial.values, **move})
            columns.append(residual - moved)
        matrix = np.column_stack(columns)
        if not np.isfinite(matrix).all():
            continue
        free = _project_out(matrix, basis)
        norms = np.linalg.norm(free, axis=0)
        if not (norms > 1e-9 * np.linalg.norm(matrix, axis=0)).any():
            continue
        scaled = free / np.maximum(norms, 1e-300)
        coefficients, *_ = np.linalg.lstsq(scaled, target, rcond=1e-8)
        drop, barred = 1.0 - float(np.sum((target - scaled @ coefficients) ** 2)) / total, 0.0
        if out_of_bounds(effect, moves, coefficients):
            drop, barred = 0.0, drop
        start = start_for(effect, shape, moves, coefficients / np.maximum(norms, 1e-300))
        whole = 1.0 - float(np.sum((target - free[:, 0]) ** 2)) / total if effect.core is not None else drop
        scores.append(Score(drop, start, shape, moves, free, barred, whole))
        if len(scores) > KEPT_SCORES:
            sparable = [score for score in scores if score.whole < max(s.whole for s in scores)] or scores
            scores.remove(min(sparable, key=lambda s: (s.drop, s.barred)))
    return sorted(scores, key=lambda s: -s.drop)


def out_of_bounds(effect: Effect, moves: list[dict[str, float]], coefficients: np.ndarray) -> bool:
    """Whether the one amplitude of an effect, zero at its bound, would have to go beyond that bound."""
    amplitudes = [p for p in effect.parameters if p.role == "amplitude" and not p.fixed]
    if effect.core is not None or len(amplitudes) != 1 or len(moves) != 1:
        return False
    wanted = float(coefficients[0])
    return (wanted < 0.0 <= amplitudes[0].low) or (wanted > 0.0 >= amplitudes[0].high)


def start_for(
    effect: Effect, shape: dict[str, float], moves: list[dict[str, float]], weights: np.ndarray
) -> dict[str, float]:
    """Values to start a refit from: a grid point, and the amplitudes that the moves' linear weights (k,) amount to."""
    if effect.core is not None or not any(moves):
        return dict(shape)
    return {**shape, **_amplitude_start(effect, moves, weights)}


def _amplitude_start(effect: Effect, moves: list[dict[str, float]], weights: np.ndarray) -> dict[str, float]:
    """Amplitudes (and phases) that the linear coefficients of the moves amount to."""
    start: dict[str, float] = {}
    phase = next((p for p in effect.parameters if p.role == "phase"), None)
    for k, move in enumerate(moves):
        key = next(name for name, value in move.items() if value != 0.0)
        value = move[key] * float(weights[k])
        if phase is None:
            start[key] = value
            continue
        phase_key = f"{effect.name}.{phase.name}"
        if phase_key in move:
            sine = start[key]
            start[key] = float(np.hypot(sine, value))
            start[phase_key] = float(np.arctan2(value, sine))
        else:
            start[key] = value
    for parameter in effect.parameters:
        key = f"{effect.name}.{parameter.name}"
        if key in start:
            start[key] = min(max(start[key], parameter.low), parameter.high)
    return start


def target_of(base: Fitted) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal basis (n, p) of the base model's Jacobian, and its residual (n,), winsorised, with that taken out."""
    basis = orthonormal(base.fit.jacobian)
    corner = WINSOR * robust_scale(base.fit.residual)
    clipped = np.clip(base.fit.residual, -corner, corner)
    return basis, clipped - basis @ (basis.T @ clipped)


@dataclass(frozen=True)
class Candidate:
    """One effect tried on top of a base model.

    Args:
        effect: tried.
        expected_drop: share of the squared residual that its linear score promised.
        fitted: the model with it.
        barred: share that only amplitudes beyond their bounds would have taken.
    """

    effect: Effect
    expected_drop: float
    fitted: Fitted
    barred: float = 0.0


@dataclass(frozen=True)
class Scored:
    """An effect scored over its grid, not fitted yet."""

    effect: Effect
    scores: list[Score]

    @property
    def promise(self) -> float:
        """Share of the squared residual that its best point promises; without any point only a fit can tell."""
        return max((score.whole for score in self.scores), default=np.inf)

    @property
    def linear(self) -> bool:
        """Whether its scores say what it can do: it has amplitudes that a linear weight stands for."""
        return bool(self.scores) and any(p.role == "amplitude" for p in self.effect.parameters)


@dataclass(frozen=True)
class Look(Scored):
    """A first look at an effect: its scores over the grid, and a short fit from the best of them."""

    fitted: Fitted

    @property
    def barred(self) -> float:
        """Largest drop that only an amplitude beyond its bounds would make."""
        return max((score.barred for score in self.scores), default=0.0)

    @property
    def expected(self) -> float:
        """Share of the squared residual that the linear score promised."""
        return max(self.scores[0].drop, 0.0)

    @property
    def error(self) -> float:
        """Ranking error of the short fit, in deviations."""
        return ranking_error(self.fitted.fit.residual)


SHORT = 4
"""Steps of the fit of a first look: enough to see what an effect is good for, not to know its values."""


FAR = 5.0
"""Ranking error of a driven stage, in deviations, from which a linear score says little of where a fit should begin."""
STARTS_FROM_AFAR = 3
FROM_AFAR = 8
"""Points of the grid, and steps of the fit from each, in a first look from so far away."""


def scored(
    base: Fitted, effect: Effect, records: Sequence[Prepared], scales: Scales, basis: np.ndarray, target: np.ndarray
) -> Scored:
    """An effect scored over its grid."""
    return Scored(effect, linear_scores(base, effect, records, scales, basis, target))


def look_at(
    base: Fitted,
    effect: Effect,
    records: Sequence[Prepared],
    scales: Scales,
    basis: np.ndarray,
    target: np.ndarray,
) -> Look | None:
    """Score an effect over its grid, and fit it shortly from the best point; none where it changes nothing."""
    return look_from(scored(base, effect, records, scales, basis, target), base, records, scales, basis)


def look_from(
    known: Scored, base: Fitted, records: Sequence[Prepared], scales: Scales, basis: np.ndarray
) -> Look | None:
    """The look at an effect whose scores are known; none where it changes nothing."""
    effect, scores = known.effect, known.scores
    far = any(isinstance(r, FrictionDriveRecord) for r in records) and ranking_error(base.fit.residual) > FAR
    points = [score.start for score in (_spread(scores, STARTS_FROM_AFAR) if far and scores else scores[:1])]
    if scores and effect.core is not None:
        # Part of a long stretch may promise most, and a short one is what fits as a whole.
        best = max(scores, key=lambda score: score.whole).start
        points += [best] if best is not points[0] else []
    starts = [with_effect(base.model, effect, scales, point) for point in points]
    starts += slipping_starts(base.model, effect, records, scales, far, points[0] if points else None)
    if not starts:
        return None
    if far:
        starts += led(starts, records, base.weights, FROM_AFAR)
    fits = [fit_model(start, records, base.weights, FROM_AFAR if far else SHORT) for start in starts]
    nearest = min(fits, key=lambda fitted: fitted.fit.cost)
    if not scores:
        # No gradient where it began: what it did where it ended stands for what it can do.
        own = {key: value for key, value in nearest.model.values.items() if key.startswith(f"{effect.name}.")}
        change = _project_out((base.fit.residual - nearest.fit.residual)[:, None], basis)
        scores = [Score(0.0, own, own, [{}], change)]
    return Look(effect, scores, nearest)


def refined(
    base: Fitted, look: Look, records: Sequence[Prepared], scales: Scales, starts: int = 2, iterations: int = 15
) -> Candidate:
    """The effect of a look refitted: further from where the look ended, and from other points of the grid."""
    best = fit_model(look.fitted.model, records, base.weights, iterations)
    others = _spread(look.scores, starts)[1:]
    if look.effect.core is not None:
        others += sorted(look.scores, key=lambda score: -score.whole)[:2]
    for score in others:
        start = with_effect(base.model, look.effect, scales, score.start)
        fitted = fit_model(start, records, base.weights, iterations)
        if fitted.fit.cost < best.fit.cost:
            best = fitted
    return Candidate(look.effect, look.expected, best, look.barred)


HALFWAY = 0.5
"""Part of the base model's error below which an effect is promising: what it leaves may be of a side valley."""


def settled(base: Fitted, candidate: Candidate, records: Sequence[Prepared], of_contact: bool = False) -> Candidate:
    """A promising effect on a driven stage, its fit gone on to the lowest valley near; any other as it is.

    Args:
        base: the fitted base model.
        candidate: an effect on top of it.
        records: those fitted.
        of_contact: it acts between tip and stage: one round over its numbers, promising or not.
    """
    if not of_contact and ranking_error(candidate.fitted.fit.residual) > HALFWAY * ranking_error(base.fit.residual):
        return candidate
    lowest = lowest_valley(candidate.fitted, records, 1 if of_contact else ROUNDS)
    return candidate if lowest is candidate.fitted else replace(candidate, fitted=lowest)


def try_effect(
    base: Fitted,
    effect: Effect,
    records: Sequence[Prepared],
    scales: Scales,
    basis: np.ndarray,
    target: np.ndarray,
    starts: int = 2,
    iterations: int = 15,
) -> Candidate | None:
    """Score an effect over its grid, refit it from the best few points, keep the best."""
    look = look_at(base, effect, records, scales, basis, target)
    return refined(base, look, records, scales, starts, iterations) if look is not None else None


def as_it_looks(look: Look) -> Candidate:
    """The effect as the first look left it."""
    return Candidate(look.effect, look.expected, look.fitted, look.barred)


def _spread(scores: list[Score], count: int) -> list[Score]:
    """The best score, and further ones that begin elsewhere on the grid."""
    picked = [scores[0]]
    for score in scores[1:]:
        if len(picked) >= count:
            break
        if score.drop > 0.5 * scores[0].drop and all(_apart(score.start, other.start) for other in picked):
            picked.append(score)
    return picked


def _apart(a: dict[str, float], b: dict[str, float]) -> bool:
    return any(abs(a[k] - b.get(k, 0.0)) > 0.3 * max(abs(a[k]), abs(b.get(k, 0.0))) for k in a)
