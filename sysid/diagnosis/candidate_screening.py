"""Screening of all candidate effects on top of a fitted model: score tests, then short fits of the best-scored ones.

The score test predicts the share of the squared residual that each candidate would remove. Candidates whose prediction
is too small are not fitted; the others are fitted for a few steps from their best grid points. The sensitivities of the
residual to the candidates are returned too, for screenings on top of a similar model.

For each of some thousand pairs of candidates the predicted reduction of the squared residual r is the solution of small
normal equations of the sensitivities D of its effects at their best grid points, with the base parameters projected
out,

    reduction = r^T D (D^T D)^-1 D^T r.
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from sim.effects.effect import Effect
from stagecad.processes import map_items
from sysid.estimation.driven_stage_search import truncated
from sysid.estimation.fit import FittedModel, root_mean_huber
from sysid.estimation.reference_fit import ReferenceFit
from sysid.estimation.screening import (
    IN_PAIRS,
    GridPoint,
    ScoredCandidate,
    ScoreStatistic,
    ScreeningFit,
    candidate_directions,
    out_of_bounds,
    profiled_residual,
    score_test,
    screen_scored,
    start_for,
)
from sysid.prediction.friction_drive.record import FrictionDriveRecord
from sysid.prediction.model import Model, Scales, public_name, with_effect
from sysid.prediction.observable import candidate_effects
from sysid.prediction.problem import Problem

Progress = Callable[[str, int, int], None]
"""Called with the name of the next step, the number of completed steps, and the total; and again at the end."""

LEAST_PROMISE = 0.02
OF_THE_BEST = 0.1
"""Predicted share of the squared residual, and its ratio to the largest one, below which no short fit is made. In
generated records with two missing effects, the second one had at least 0.05, and 0.4 of the largest."""

ROWS_SEEN = 5000
"""Least number of rows of the residual at which effects are scored; all rows if there are fewer."""


@dataclass(frozen=True)
class ScreeningResult:
    """Screening of every candidate on top of a fitted model."""

    fits: list[ScreeningFit]  # best first
    unfitted: list[ScoredCandidate]  # effects of which no fit was made, since their predicted share was too small
    target: np.ndarray  # residual of the model in the score tests, (n,)
    # changes of the residual at the points of the shape grid, by name of the effect, for screenings on top of this
    # model: nearly unchanged if the model has one effect more or less
    grids: Mapping[str, list[GridPoint]]
    size: int  # number of rows of the residual


def screen_all(
    problem: Problem,
    base: ReferenceFit,
    all_effects: bool = False,
    progress: Progress | None = None,
    promising: int | None = None,
    known: ScreeningResult | None = None,
    options: Sequence[Effect] | None = None,
    least: float = 0.0,
) -> ScreeningResult:
    """Screen every candidate on top of a fitted model; of those with a prediction, with at least a predicted share."""
    fitted, records = truncated(base.fitted, problem.fit_records)
    size = fitted.fit.residual.size
    rows = slice(None, None, max(1, size // ROWS_SEEN))
    basis, target = profiled_residual(fitted, rows)
    # On a driven stage one effect more or less changes the times of slip.
    driven = any(isinstance(record, FrictionDriveRecord) for record in records)
    known_grids = {} if known is None or known.size != size or driven else known.grids
    present = [effect.name for effect in fitted.model.effects]
    effects = candidate_effects(problem, present, all_effects) if options is None else list(options)
    shared = (*effects, *fitted.model.effects, fitted.weights)
    _preload(problem, effects)
    steps = itertools.count()

    def report(done: Effect | ScoredCandidate) -> None:
        if progress is not None:
            effect = done if isinstance(done, Effect) else done.effect
            progress(effect.name, next(steps), 2 * len(effects))

    def score(effect: Effect) -> tuple[ScoredCandidate, list[GridPoint]]:
        grid = None if effect.is_periodic else known_grids.get(effect.name)
        if grid is not None:
            return ScoredCandidate(effect, score_test(effect, grid, basis, target)), []
        grid = candidate_directions(fitted, effect, records, problem.scales, rows)
        return ScoredCandidate(effect, score_test(effect, grid, basis, target)), [] if known_grids else grid

    def screen(scored: ScoredCandidate) -> ScreeningFit | None:
        return screen_scored(scored, fitted, records, problem.scales, basis, rows)

    scored = map_items(score, effects, shared, report)
    # What multiplies a friction that is zero changes nothing, but does beside an effect with which it is not.
    grids = {one.effect.name: grid for one, grid in scored if any(point.changes.any() for point in grid)}
    by_score = sorted((one for one, _ in scored), key=lambda one: -one.score)
    # Effects without a linear amplitude are always fitted.
    best = max((one.score for one in by_score if one.linear), default=0.0)
    least_linear = max(LEAST_PROMISE, OF_THE_BEST * best)
    ranked = list(
        dict.fromkeys(public_name(one.effect.name) for one in by_score if one.linear and one.score >= least_linear)
    )
    first = set(ranked[:promising])
    fits = [
        (promising is None or not one.linear or public_name(one.effect.name) in first) and one.promise >= least
        for one in by_score
    ]
    fitting = [one for one, fit in zip(by_score, fits, strict=True) if fit]
    unfitted = [one for one, fit in zip(by_score, fits, strict=True) if not fit]
    shared = (*shared, *fitting, *(score for one in fitting for score in one.scores))
    found = map_items(screen, fitting, shared, report)
    screened = sorted((one for one in found if one is not None and np.isfinite(one.error)), key=lambda one: one.error)
    if progress is not None:
        progress("", 2 * len(effects), 2 * len(effects))
    return ScreeningResult(screened, unfitted, target, known_grids or grids, size)


def _preload(problem: Problem, effects: Sequence[Effect]) -> None:
    """Import libraries and compile loops of effects on signals before the fork, so that no worker does it again. The
    user's own effects are left out, since they may not accept an arbitrary signal."""
    signal = np.linspace(0.0, 1.0, 8)
    for effect in effects:
        if effect.signal is not None and effect not in problem.custom:
            effect.signal(signal, 1.0, effect.values())


RIDGE = 1e-6
"""Added to the scaled normal equations of two effects."""


@dataclass(frozen=True)
class ScoredPair:
    """Two effects at their best grid points."""

    reduction: float  # predicted reduction of the squared residual
    # the effects and their scores; a friction state model first, since the other starts from its level
    effects: tuple[Effect, Effect]
    scores: tuple[ScoreStatistic, ScoreStatistic]
    weights: tuple[np.ndarray, np.ndarray]  # linear weights of the directions of each

    @property
    def families(self) -> frozenset[str]:
        """Public names of the two."""
        return frozenset(public_name(effect.name) for effect in self.effects)

    def start(self, model: Model, scales: Scales) -> Model:
        """The model with both effects at the values of the joint score."""
        for effect, score, weights in zip(self.effects, self.scores, self.weights, strict=True):
            model = with_effect(model, effect, scales, start_for(effect, score.shape, score.directions, weights))
        return model


def scored_pairs(fitted: FittedModel, screening: ScreeningResult, most: int) -> list[ScoredPair]:
    """The pairs of effects of different families with the largest joint scores, one per pair of families."""
    alone = root_mean_huber(fitted.fit.residual)
    # A change of the friction state model has no amplitude and no linear weight: it is judged by its own fit.
    able = [one for one in screening.fits if one.linear or one.error < alone]
    parts = [(one.effect, score) for one in (*able, *screening.unfitted) for score in one.scores[:IN_PAIRS]]
    if len(parts) < 2:
        return []
    norms = [np.maximum(np.linalg.norm(score.columns, axis=0), 1e-300) for _, score in parts]
    columns = np.hstack([score.columns / norm for (_, score), norm in zip(parts, norms, strict=True)])
    gram, right = columns.T @ columns, columns.T @ screening.target
    places = np.split(np.arange(right.size), np.cumsum([norm.size for norm in norms])[:-1])
    found = []
    for pair in combinations(range(len(parts)), 2):
        # A friction state model comes first.
        one, other = sorted(pair, key=lambda k: parts[k][0].friction_state is None)
        effects, scores = (parts[one][0], parts[other][0]), (parts[one][1], parts[other][1])
        same = public_name(effects[0].name) == public_name(effects[1].name)
        if same or all(effect.friction_state is not None for effect in effects):
            continue
        index = np.concatenate([places[one], places[other]])
        scaled = np.linalg.solve(gram[np.ix_(index, index)] + RIDGE * np.eye(index.size), right[index])
        count = norms[one].size
        weights = scaled[:count] / norms[one], scaled[count:] / norms[other]
        # A pair whose best weights are not physical, such as a negative drag, is not an explanation.
        directions = [score.directions for score in scores]
        if not any(map(out_of_bounds, effects, directions, weights)):
            found.append(ScoredPair(float(right[index] @ scaled), effects, scores, weights))
    chosen: dict[frozenset[str], ScoredPair] = {}
    for pair in sorted(found, key=lambda one: -one.reduction):
        chosen.setdefault(pair.families, pair)
    return list(chosen.values())[:most]
