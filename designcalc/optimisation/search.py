"""Search for the design nearest to the present one that satisfies rules and checks."""

import math
import warnings
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from designcalc.optimisation.evaluation import Evaluation, Evaluator
from stagecad.parameters.errors import InputError
from stagecad.parameters.rules.registry import violations
from stagecad.parameters.rules.remedies import remedies

Array = NDArray[np.float64]

PENALTY = 3.0
"""Weight of the shortfall against the distance: any satisfying design is better than one that is not."""
OFFSET = 100.0
MOST_REMEDIES = 4
"""Changes of each free parameter by the remedies of rules."""


@dataclass
class Best:
    """The best evaluation so far, kept when a search is interrupted."""

    names: Collection[str]
    evaluation: Evaluation | None = None

    def offer(self, evaluation: Evaluation) -> float:
        """Merit of an evaluation, less is better; keeps it if it is the best."""
        merit = self.merit(evaluation)
        if self.evaluation is None or merit < self.merit(self.evaluation):
            self.evaluation = evaluation
        return merit

    def merit(self, evaluation: Evaluation) -> float:
        """Distance of a satisfying design; above that of any, by its shortfall, of another one."""
        shortfall = evaluation.shortfall(self.names)
        return evaluation.distance if shortfall == 0.0 else OFFSET + PENALTY * shortfall + 0.01 * evaluation.distance

    @property
    def satisfied(self) -> bool:
        """Whether the best design satisfies rules and checks."""
        return self.evaluation is not None and self.evaluation.satisfies(self.names)


def cma_es(function: Callable[[Array], float], start: Array, budget: int, seed: int) -> Iterator[None]:
    """Minimise a function over the unit cube by covariance matrix adaptation (Hansen, 2001), package `cma`.

    Yields after each generation, so that the caller can stop.
    """
    with warnings.catch_warnings():
        # Its plotting module warns when it is imported.
        warnings.simplefilter("ignore")
        import cma

        options = {"bounds": [0.0, 1.0], "seed": seed, "verbose": -9, "maxfevals": budget, "tolfun": 1e-6}
        size = len(start)
        if size == 1:
            # The package needs two dimensions.
            strategy = cma.CMAEvolutionStrategy([start[0], 0.5], 0.25, options)
        else:
            strategy = cma.CMAEvolutionStrategy(start.tolist(), 0.25, options)
        while not strategy.stop():
            points = strategy.ask()
            strategy.tell(points, [function(np.asarray(point)[:size]) for point in points])
            yield


class _FoundError(Exception):
    """A satisfying design was found, and no better one is sought."""


def cobyla(function: Callable[[Array], float], start: Array, budget: int) -> None:
    """Minimise a function over the unit cube by linear models in a trust region (Powell, 1994), of scipy."""
    from scipy.optimize import minimize

    bounds = [(0.0, 1.0)] * len(start)
    options = {"rhobeg": 0.25, "maxiter": max(budget, len(start) + 2), "tol": 1e-3}
    minimize(function, start, method="COBYLA", bounds=bounds, options=options)


def search(
    evaluator: Evaluator,
    names: Collection[str],
    budget: int,
    *,
    seed: int = 1,
    best: Best | None = None,
    subset: bool = False,
    first: bool = False,
) -> Best:
    """Search the nearest design that satisfies the rules and the checks `names`.

    Covariance matrix adaptation, then each change is taken back as far as the requirements allow. Where the first
    satisfying design is enough, a local search comes before: it needs a fraction of the evaluations.
    """
    best = best or Best(names)
    run = names if subset else None
    for known in evaluator.archive:
        best.offer(known)

    def merit(point: Array) -> float:
        found = best.offer(evaluator.at(np.clip(point, 0.0, 1.0), run))
        if first and best.satisfied:
            raise _FoundError
        return found

    with suppress(_FoundError):
        merit(evaluator.start)
        began = evaluator.count
        if first:
            cobyla(merit, np.clip(_start(evaluator, best), 0.02, 0.98), budget // 2)
        rest = budget - (evaluator.count - began)
        for _ in cma_es(merit, np.clip(_start(evaluator, best), 0.02, 0.98), rest, seed):
            pass
    if best.satisfied and not first:
        take_back(evaluator, best, run)
        round_values(evaluator, best, run)
    return best


def repair(evaluator: Evaluator) -> None:
    """Evaluate the design to which the remedies of the violated rules lead, one free parameter after another.

    Where many rules tie lengths together, random designs satisfy them next to never. A value that was raised is not
    lowered again, so that two rules do not undo each other's changes in turn.
    """
    free = {one.key: one for one in evaluator.free if not one.choices}
    values = {one.key: one.start for one in evaluator.free}
    for _ in range(MOST_REMEDIES * len(free)):
        design = evaluator.design(values)

        def changed(key: str, value: float) -> Any:
            return evaluator.design({**values, key: value})

        found = [remedy for one in violations(design) for remedy in remedies(design, one, changed, free)]
        within = [
            one
            for one in found
            if free[one.key].low <= one.number <= free[one.key].high
            and (one.number - values[one.key]) * (values[one.key] - free[one.key].start) >= 0
        ]
        if not within:
            break
        best = min(within, key=lambda one: (len(one.new_violations), one.distance))
        values[best.key] = best.number
        evaluator.progress(evaluator.count)
    with suppress(InputError):
        evaluator.of(values)


def _start(evaluator: Evaluator, best: Best) -> Array:
    assert best.evaluation is not None
    return best.evaluation.point if best.evaluation.distance else evaluator.start


def take_back(
    evaluator: Evaluator,
    best: Best,
    run: Collection[str] | None = None,
    halvings: int = 5,
) -> None:
    """Take each change of a satisfying design back: wholly if possible, else by bisection."""
    assert best.evaluation is not None
    for _ in range(3):
        before = best.evaluation.distance
        order = sorted(evaluator.free, key=lambda one: one.distance(best.evaluation.values[one.key]))  # type: ignore[union-attr]
        for one in order:
            _take_back_one(evaluator, best, one, run, halvings)
        if best.evaluation.distance > 0.98 * before:
            break


def round_values(evaluator: Evaluator, best: Best, run: Collection[str] | None = None) -> None:
    """Round the changed values of a satisfying design to the fewest digits with which it still satisfies all."""
    for one in evaluator.free:
        _round(evaluator, best, one, run)


def _take_back_one(evaluator: Evaluator, best: Best, one: Any, run: Collection[str] | None, halvings: int) -> None:
    assert best.evaluation is not None
    values = best.evaluation.values
    if values[one.key] == one.start:
        return
    if best.merit(evaluator_offer(evaluator, best, {**values, one.key: one.start}, run)) < OFFSET or one.choices:
        return
    here, there = one.place(values[one.key]), one.place(one.start)
    for _ in range(halvings):
        middle = 0.5 * (here + there)
        found = evaluator_offer(evaluator, best, {**values, one.key: one.value(middle)}, run)
        here, there = (middle, there) if found.satisfies(best.names) else (here, middle)


def evaluator_offer(
    evaluator: Evaluator, best: Best, values: dict[str, Any], run: Collection[str] | None
) -> Evaluation:
    """Evaluate values and offer the result."""
    found = evaluator.of(values, run)
    best.offer(found)
    return found


def _round(evaluator: Evaluator, best: Best, one: Any, run: Collection[str] | None) -> None:
    """Round a changed value to the fewest digits with which the design still satisfies all."""
    assert best.evaluation is not None
    value = best.evaluation.values[one.key]
    if one.choices or one.whole or value == one.start or not value:
        return
    for digits in (2, 3, 4):
        scale = 10.0 ** (math.floor(math.log10(abs(value))) + 1 - digits)
        for rounding in (round, math.floor, math.ceil):
            rounded = float(f"{rounding(value / scale) * scale:.10g}")
            if not one.low <= rounded <= one.high:
                continue
            found = evaluator.of({**best.evaluation.values, one.key: rounded}, run)
            if found.satisfies(best.names):
                best.evaluation = found
                return
