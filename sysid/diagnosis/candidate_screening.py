"""Screening of all candidate effects on top of a fitted model: score tests, then short fits of the best-scored ones.

The score test predicts the share of the squared residual that each candidate would remove. Candidates whose prediction
is too small are not fitted; the others are fitted for a few steps from their best grid points. The sensitivities of the
residual to the candidates are returned too, for screenings on top of a similar model.
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from sim.effects.effect import Effect
from stagecad.processes import fork_map
from sysid.estimation.driven_stage_search import truncated
from sysid.estimation.reference_fit import ReferenceFit
from sysid.estimation.score_test import GridPoint, candidate_directions, profiled_residual, score_test
from sysid.estimation.screening import ScoredCandidate, ScreeningFit, screen_scored
from sysid.prediction.friction_drive.record import FrictionDriveRecord
from sysid.prediction.observable import candidate_effects
from sysid.prediction.problem import Problem

Progress = Callable[[str, int, int], None]
"""Called with the name of the next step, the number of completed steps, and the total; and again at the end."""

LEAST_PROMISE = 0.02
OF_THE_BEST = 0.1
"""Predicted share of the squared residual, and its ratio to the largest one, below which no short fit is made. In
generated records with two missing effects, the second one had at least 0.05, and 0.4 of the largest."""

ALONE = 0.2
"""Time for which items are computed in this process before others are forked, s."""

ROWS_SEEN = 5000
"""Least number of rows of the residual at which effects are scored; all rows if there are fewer."""


@dataclass(frozen=True)
class CandidateJacobians:
    """Changes of the residual by candidate effects; nearly unchanged if the model has one effect more or less."""

    size: int  # number of rows of the residual
    grids: Mapping[str, list[GridPoint]]  # changes at the points of the shape grid, by name of the effect


@dataclass(frozen=True)
class ScreeningResult:
    """Screening of every candidate on top of a fitted model."""

    fits: list[ScreeningFit]  # best first
    unfitted: list[ScoredCandidate]  # effects of which no fit was made, since their predicted share was too small
    target: np.ndarray  # residual of the model in the score tests, (n,)
    jacobians: CandidateJacobians  # sensitivities to each candidate, for screenings on top of this model


def screen_all(
    problem: Problem,
    base: ReferenceFit,
    present: Sequence[str],
    all_effects: bool = False,
    progress: Progress | None = None,
    promising: int | None = None,
    jacobians: CandidateJacobians | None = None,
    options: Sequence[Effect] | None = None,
) -> ScreeningResult:
    """Screen every candidate on top of a fitted model."""
    fitted, records = truncated(base.fitted, problem.fit_records)
    size = fitted.fit.residual.size
    rows = slice(None, None, max(1, size // ROWS_SEEN))
    basis, target = profiled_residual(fitted, rows)
    # On a driven stage one effect more or less changes the times of slip.
    driven = any(isinstance(record, FrictionDriveRecord) for record in records)
    known_grids = {} if jacobians is None or jacobians.size != size or driven else jacobians.grids
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
    grids = {one.effect.name: grid for one, grid in scored}
    known = sorted((one for one, _ in scored), key=lambda one: -one.score)
    # Effects without a linear amplitude are always fitted.
    best = max((one.score for one in known if one.linear), default=0.0)
    least = max(LEAST_PROMISE, OF_THE_BEST * best)
    ranked = {one.effect.name for one in [o for o in known if o.linear and o.score >= least][:promising]}
    fits = [promising is None or not one.linear or one.effect.name in ranked for one in known]
    fitting = [one for one, fit in zip(known, fits, strict=True) if fit]
    unfitted = [one for one, fit in zip(known, fits, strict=True) if not fit]
    shared = (*shared, *fitting, *(score for one in fitting for score in one.scores))
    found = map_items(screen, fitting, shared, report)
    screened = sorted((one for one in found if one is not None and np.isfinite(one.error)), key=lambda one: one.error)
    if progress is not None:
        progress("", 2 * len(effects), 2 * len(effects))
    return ScreeningResult(screened, unfitted, target, CandidateJacobians(size, known_grids or grids))


def map_items(
    function: Callable[[Any], Any],
    items: Sequence[Any],
    identical: Sequence[object] = (),
    progress: Callable[[Any], None] = lambda item: None,
) -> list[Any]:
    """`fork_map`, the first items in this process: to fork it takes as long as `ALONE`."""
    found, began = [], perf_counter()
    for item in items:
        if perf_counter() - began > ALONE:
            break
        found.append(function(item))
        progress(item)
    return [*found, *fork_map(function, items[len(found) :], identical, progress)]


def _preload(problem: Problem, effects: Sequence[Effect]) -> None:
    """Import libraries and compile loops of effects on signals before the fork, so that no worker does it again.

    The user's own effects are left out, since they may not accept an arbitrary signal.
    """
    signal = np.linspace(0.0, 1.0, 8)
    for effect in effects:
        if effect.signal is not None and effect not in problem.custom:
            effect.signal(signal, 1.0, effect.values())
