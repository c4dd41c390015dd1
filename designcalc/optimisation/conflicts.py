"""Requirements that contradict each other: those out of reach alone, irreducible sets, and what to relax."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from designcalc.checks.check import Check
from designcalc.optimisation.search import Best, Evaluation, Evaluator, search


@dataclass(frozen=True)
class Conflict:
    """Requirements that no design within the ranges satisfies together, while it does without any one of them."""

    names: tuple[str, ...]  # of the checks
    fixed: bool = False  # it is certain, since the check reads no free parameter; otherwise a search found no design


@dataclass(frozen=True)
class Relaxation:
    """How far one requirement must be relaxed while others are kept."""

    name: str  # of the check
    margin: float  # best that was reached
    needed: float | None  # value of the check there: the limit that would be met
    limit: float | None  # present limit
    unit: str  # of both
    keeping: tuple[str, ...]  # the other requirements of the conflict


def sample(evaluator: Evaluator, count: int, seed: int) -> list[Evaluation]:
    """Evaluations of all checks: of one changed parameter at a time first, then of random designs."""
    points = []
    for place in (0.0, 1.0, 0.5):
        for axis in range(len(evaluator.free)):
            points.append(evaluator.start.copy())
            points[-1][axis] = place
    random = np.random.default_rng(seed).random((max(count - len(points), 0), len(evaluator.free)))
    return [evaluator.at(point) for point in [*points[:count], *random]]


def out_of_reach(
    evaluator: Evaluator, names: Collection[str], sampled: Sequence[Evaluation] = ()
) -> tuple[dict[str, Conflict], dict[str, Evaluation]]:
    """Checks that fail whatever the free parameters, and the best evaluation of each of these checks.

    Rules are left aside: a check that cannot pass without them cannot pass with them. A check that reads no free
    parameter keeps its value. Each other one that fails in all sampled designs is searched by itself, one parameter
    after another.
    """
    found: dict[str, Conflict] = {}
    best: dict[str, Evaluation] = {}
    for name in names:
        if not evaluator.fails(evaluator.checks[evaluator.positions[name]]):
            continue
        axes = evaluator.axes(name)
        if not axes:
            found[name] = Conflict((name,), fixed=True)
            continue
        evaluation, reached = _best_of(evaluator, name, axes, sampled)
        best[name] = evaluation
        if not reached:
            found[name] = Conflict((name,))
    return found, best


def _best_of(
    evaluator: Evaluator, name: str, axes: Sequence[int], sampled: Sequence[Evaluation]
) -> tuple[Evaluation, bool]:
    """The best margin of one check over the cube, by coordinate search from the best sample; whether it passes."""

    def margin(evaluation: Evaluation) -> float:
        value = evaluation.margins.get(name)
        return -1e30 if value is None or evaluation.refused else value

    def passed(evaluation: Evaluation) -> bool:
        return not evaluation.refused and name in evaluation.margins and name not in evaluation.unmet

    start = evaluator.at(evaluator.start, (name,))
    best = max((start, *sampled), key=margin)
    if passed(best):
        return best, True
    # The sampled designs that differ from the present one in a single parameter, by its axis.
    moved: dict[int, list[Evaluation]] = {}
    for one in sampled:
        differ = np.flatnonzero(one.point != evaluator.start)
        if differ.size == 1:
            moved.setdefault(int(differ[0]), []).append(one)
    axes = [axis for axis in axes if axis not in moved or any(margin(one) != margin(start) for one in moved[axis])]
    together = evaluator.start.copy()
    for axis in axes:
        together[axis] = max((start, *moved.get(axis, ())), key=margin).point[axis]
    best = max((best, evaluator.at(together, (name,))), key=margin)
    if passed(best):
        return best, True
    for _ in range(2):
        before = margin(best)
        for axis in axes:
            for place in (0.0, 0.33, 0.67, 1.0):
                trial = best.point.copy()
                trial[axis] = place
                found = evaluator.at(trial, (name,))
                if margin(found) > margin(best):
                    best = found
                if passed(found):
                    return found, True
        if margin(best) <= before:
            break
    return best, passed(best)


def irreducible(evaluator: Evaluator, names: Collection[str], budget: int) -> tuple[str, ...] | None:
    """An irreducible infeasible subset of requirements by the deletion filter; None when a design satisfies all.

    Every requirement is left out in turn, and stays out if the rest still has no design. A search that finds none
    within its budget counts as none; each member of the result is verified by a design that satisfies all others.

    Source: Chinneck, Dravnieks, ORSA J. Computing 3 (1991) 157.
    """
    kept = _infeasible_part(evaluator, names, budget)
    if kept is None:
        return None
    for name in list(kept):
        rest = [other for other in kept if other != name]
        if feasible(evaluator, rest, budget) is None:
            kept = rest
    return tuple(sorted(kept, key=evaluator.positions.__getitem__))


def _infeasible_part(evaluator: Evaluator, names: Collection[str], budget: int) -> list[str] | None:
    """A small part of the requirements that has no design; None when a design satisfies all. It begins with those that
    the best compromise fails, and grows by those that the designs found for it fail."""
    known = [one for one in evaluator.archive if one.complete] or [evaluator.at(evaluator.start)]
    compromise = min(known, key=lambda one: one.shortfall(names))
    part = [name for name in names if name in compromise.unmet]
    while True:
        found = feasible(evaluator, part, budget)
        if found is None:
            # Requirements that most designs fail come last: the first to be left out are those that matter least.
            counts = {name: sum(name in one.unmet for one in evaluator.archive) for name in part}
            return sorted(part, key=lambda name: counts[name])
        whole = found if found.complete else evaluator.of(found.values)
        new = [name for name in names if name in whole.unmet and name not in part]
        if not new:
            return None
        part += new


def feasible(evaluator: Evaluator, names: Collection[str], budget: int) -> Evaluation | None:
    """A design that satisfies the rules and these checks: a known one, or one found by a search; None for none."""
    for known in evaluator.archive:
        if known.satisfies(names):
            return known
    for seed in (1, 2):
        best = search(Best(evaluator, names, alone=True), budget, seed=seed, first=True)
        if best.satisfied:
            return best.evaluation
    return None


def relaxations(
    evaluator: Evaluator, conflicts: Sequence[Conflict], alone: dict[str, Evaluation], budget: int
) -> Iterator[Relaxation]:
    """Best margin of each member of each conflict with the other members satisfied; of a single one, in any design."""
    for conflict in conflicts:
        for name in conflict.names:
            others = tuple(other for other in conflict.names if other != name)
            check = evaluator.checks[evaluator.positions[name]]
            evaluation = alone.get(name) if not others else _closest(evaluator, name, others, budget)
            margin = check.margin if evaluation is None else evaluation.margins.get(name)
            if margin is None:
                continue
            yield Relaxation(name, margin, _value(check, margin), check.limit, check.unit, others)


def _closest(evaluator: Evaluator, name: str, others: Collection[str], budget: int) -> Evaluation | None:
    """The best margin of a check among designs that satisfy the rules and the other checks."""
    best = search(Best(evaluator, (*others, name), alone=True), budget)
    satisfying = (one for one in (*evaluator.archive, best.found) if one.satisfies(others))
    candidates = [one for one in satisfying if one.margins.get(name) is not None]
    return max(candidates, key=lambda one: one.margins[name] or 0.0, default=None)


def _value(check: Check, margin: float) -> float | None:
    """Value of a check with this margin at its present limit."""
    if check.limit is None:
        return None
    size = abs(check.limit) if check.limit != 0 else 1.0
    return check.limit - margin * size if check.comparison.upper else check.limit + margin * size
