"""`optimise`: the nearest design without violated rules and failed checks, or the conflicts and what to relax."""

import math
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fnmatch import fnmatch
from typing import Any

import numpy as np

from designcalc.checks.check import Check
from designcalc.optimisation.conflicts import Conflict, Relaxation, irreducible, out_of_reach, relaxations, sample
from designcalc.optimisation.search import (
    Best,
    Evaluation,
    Evaluator,
    OutOfBudgetError,
    repair,
    round_values,
    search,
    take_back,
)
from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.units import as_json, attributes

CONFLICT_BUDGET = 150
"""Evaluations of each search of a design for a part of the requirements."""
_COMPROMISES = 3
"""Searches that find no design, each with the requirements too that the one before has broken."""
_SAMPLES, _FINISH = 6, 30
"""Sampled designs, and evaluations to take changes back, for each free parameter."""
MOST_CONFLICTS = 8


@dataclass(frozen=True)
class ParameterChange:
    """A changed parameter, and the requirements that fail without the change."""

    key: str
    before: str
    after: str
    needed_by: tuple[str, ...]

    @property
    def reason(self) -> str:
        """The requirements as text."""
        if not self.needed_by:
            return "needed together with the other changes"
        more = f" and {len(self.needed_by) - 3} more" if len(self.needed_by) > 3 else ""
        return f"needed by {', '.join(self.needed_by[:3])}{more}"

    def as_json(self) -> dict[str, Any]:
        """As a JSON document."""
        return {"key": self.key, "from": self.before, "to": self.after, "reason": self.reason}


@dataclass
class Outcome:
    """Result of an optimisation."""

    feasible: bool  # whether a design satisfies all requirements
    required: tuple[str, ...]  # names of the checks that were required
    before: Evaluation
    # the nearest design that satisfies the requirements, without those of the conflicts when there are any; None when
    # none was found
    design: Evaluation | None = None
    changes: tuple[ParameterChange, ...] = ()  # of it
    conflicts: list[Conflict] = field(default_factory=list)  # irreducible sets of requirements
    relax: list[Relaxation] = field(default_factory=list)  # how far each member of a conflict must be relaxed
    evaluations: int = 0  # number of evaluated designs
    left_out: tuple[str, ...] = ()  # requirements that the design does not meet, although no conflict is known
    complete: bool = True  # whether the search ended before its evaluations and its time were used up
    interrupted: bool = False  # by Ctrl-C; the rest is what was known then


def required_checks(checks: Sequence[Check], keep: Sequence[str]) -> tuple[str, ...]:
    """Names of the required checks: those of `--keep`, or all.

    A word of `--keep` is a name, its beginning, a pattern with `*`, or an entry of the thesis's tables (`Table 1:
    speed`).
    """
    names = [check.name for check in checks]
    if not keep:
        return tuple(names)
    found: dict[str, None] = {}
    for word in keep:
        exact = [check.name for check in checks if word in (check.name, check.requirement)]
        some = exact or [name for name in names if fnmatch(name, f"{word}*")]
        some = some or [check.name for check in checks if fnmatch(check.requirement, f"{word}*")]
        if not some:
            raise InputError(f"--keep '{word}': no such check{nearest(word, names)}")
        found.update(dict.fromkeys(some))
    return tuple(name for name in names if name in found)


def optimise(
    evaluator: Evaluator,
    required: Collection[str],
    budget: int,
    *,
    seed: int = 1,
    evaluations: int = 100_000,
    seconds: float = math.inf,
    tell: Callable[[str], None] = lambda words: None,
) -> Outcome:
    """Find the nearest design that satisfies the rules and the required checks; otherwise their conflicts.

    Where the evaluations or the time end before the conflicts are found, the design is that of the best compromise,
    and the requirements that it does not meet are left out.
    """
    names = tuple(name for name in required if name in evaluator.positions)
    began = time.monotonic()
    outcome = Outcome(False, names, evaluator.at(evaluator.start))
    # The changed values are rounded, and each is taken back by itself for its reason.
    whole = len(evaluator.free) * (time.monotonic() - began)
    run = _Run(evaluator, outcome, budget, seed, tell, kept=list(names))
    # A part is kept for the changes that can be taken back, and for their reasons.
    evaluator.most = evaluations - min(evaluations // 3, _FINISH * len(evaluator.free))
    timed, finish = math.isfinite(seconds), began + seconds - min(2.0 * whole, 0.5 * seconds)
    evaluator.deadline = began + 0.75 * (finish - began) if timed else None
    try:
        run.explore()
    except OutOfBudgetError:
        outcome.complete = False
    except KeyboardInterrupt:
        outcome.interrupted = True
    evaluator.most = evaluations if not outcome.interrupted else None
    evaluator.deadline = finish if timed and not outcome.interrupted else None
    run.rounded = began + seconds - min(whole, 0.25 * seconds) if timed else None
    with suppress(OutOfBudgetError, KeyboardInterrupt):
        if not run.best.satisfied:
            run.compromise()
    evaluator.most = evaluator.deadline = None
    outcome.evaluations, evaluator.progress = evaluator.count, lambda done: None  # rounding below is no search
    best = run.best
    if best.satisfied:
        outcome.design = evaluator.of(best.found.values)  # with all checks
        outcome.feasible = not outcome.conflicts and not outcome.left_out
        outcome.changes = _changes(evaluator, outcome.design, best.names)
    else:
        outcome.design = best.evaluation
    return outcome


@dataclass
class _Run:
    """State of an optimisation, so that the best is known when it is interrupted."""

    evaluator: Evaluator
    outcome: Outcome
    budget: int
    seed: int
    tell: Callable[[str], None]
    kept: list[str]
    rounded: float | None = None  # time by which the values of a compromise are rounded
    best: Best = field(init=False)

    def __post_init__(self) -> None:
        self.best = Best(self.evaluator, self.kept)

    def explore(self) -> None:
        """Requirements out of reach, the nearest design that meets the others, and conflicts among these."""
        evaluator, outcome = self.evaluator, self.outcome
        self.tell("remedies of the rules")
        repair(evaluator)
        self.tell("samples")
        sampled = sample(evaluator, min(_SAMPLES * len(evaluator.free), self.budget // 4), self.seed)
        self.tell("each failed check by itself")
        single, alone = out_of_reach(evaluator, self.kept, sampled)
        outcome.conflicts = list(single.values())
        self.kept = [name for name in self.kept if name not in single]
        while True:
            self.tell(f"nearest design for {len(self.kept)} requirements")
            self.best = Best(evaluator, self.kept)
            _nearest(self.best, self.budget, self.seed)
            if self.best.satisfied or len(outcome.conflicts) >= len(single) + MOST_CONFLICTS:
                break
            self.tell("conflicting requirements")
            members = irreducible(evaluator, self.kept, CONFLICT_BUDGET)
            if members is None:
                self.best.offer(next(one for one in evaluator.archive if one.satisfies(self.kept)))
                break
            if not members:
                known = [one for one in evaluator.archive if one.violated] or [evaluator.at(evaluator.start)]
                fewest = min((one.violated for one in known), key=len)
                rules = ", ".join(f"'{name}'" for name in dict.fromkeys(fewest))
                raise InputError(
                    f"no design without violated rules was found: {rules}; free the parameters that these rules name, "
                    "or give more --time"
                )
            outcome.conflicts.append(Conflict(members))
            # Without the member that fewest of the evaluated designs satisfy.
            designs = [one for one in evaluator.archive if not one.refused]
            hardest = min(members, key=lambda name: sum(name not in one.unmet for one in designs))
            self.kept = [name for name in self.kept if name != hardest]
        self.tell("what to relax")
        for one in relaxations(evaluator, outcome.conflicts, alone, CONFLICT_BUDGET):
            outcome.relax.append(one)

    def compromise(self) -> None:
        """Leave out the requirements that the best design fails, and take its needless changes back."""
        complete = [one for one in self.evaluator.archive if one.complete and not one.violated]
        if not complete:
            return
        design = min(complete, key=lambda one: (len(one.unmet.intersection(self.kept)), one.shortfall(self.kept)))
        with suppress(OutOfBudgetError, KeyboardInterrupt):
            self.tell("requirements that one change meets")
            for one in _repaired(self.evaluator, design, self.kept):
                design = one
        self.outcome.left_out = tuple(name for name in self.kept if name in design.unmet)
        self.kept = [name for name in self.kept if name not in design.unmet]
        self.best = Best(self.evaluator, self.kept, evaluation=design)
        self.tell("changes taken back")
        # The checks that no design has failed so far are left for the end.
        part = [name for name in self.kept if any(name in one.unmet for one in complete)]
        inner = Best(self.evaluator, part, alone=True, evaluation=design)
        with suppress(OutOfBudgetError, KeyboardInterrupt):
            take_back(inner)
        self.evaluator.most, self.evaluator.deadline = None, self.rounded
        with suppress(OutOfBudgetError, KeyboardInterrupt):
            round_values(inner)
        self.best.offer(self.evaluator.of(inner.found.values, limited=False))


def _repaired(evaluator: Evaluator, design: Evaluation, names: Collection[str]) -> Iterator[Evaluation]:
    """Designs that fail ever fewer of these requirements, each by the change of one parameter of the one before."""
    for name in [one for one in names if one in design.unmet]:
        for axis in evaluator.axes(name):
            for place in sorted(np.linspace(0, 1, 9), key=lambda place: abs(place - design.point[axis])):
                trial = design.point.copy()
                trial[axis] = place
                alone = evaluator.at(trial, (name,))
                if name in alone.unmet or alone.refused or alone.violated:
                    continue
                whole = evaluator.at(trial)
                if whole.unmet.intersection(names) < design.unmet.intersection(names):
                    design = whole
                    yield design
                break
            if name not in design.unmet:
                break


def _nearest(best: Best, budget: int, seed: int) -> None:
    """Search with the requirements that fail now, and add those that the designs found fail, until none is new. Most
    requirements never matter, and a design is evaluated the faster the fewer checks are run."""
    evaluator, names = best.evaluator, best.names
    for known in evaluator.archive:
        best.offer(known)
    part = [name for name in names if name in evaluator.at(evaluator.start).unmet]
    compromises = 0
    while compromises < _COMPROMISES:
        inner = Best(evaluator, part, alone=True)
        try:
            search(inner, budget, seed=seed)
        finally:
            whole = None
            if inner.evaluation is not None:
                whole = evaluator.of(inner.evaluation.values, limited=False)
                best.offer(whole)
        compromises += not inner.satisfied
        new = [name for name in names if whole is not None and name in whole.unmet and name not in part]
        if not new:
            return
        part += new


def _changes(evaluator: Evaluator, design: Evaluation, names: Collection[str]) -> tuple[ParameterChange, ...]:
    found = []
    for one in evaluator.free:
        value = design.values[one.key]
        if value == one.start:
            continue
        without = evaluator.of({**design.values, one.key: one.start})
        failing = [f"'{name}'" for name in names if name in without.unmet]
        rules = [f"the rule '{name}'" for name in dict.fromkeys(without.violated)]
        found.append(ParameterChange(one.key, one.text(one.start), one.text(value), (*failing, *rules)))
    return tuple(found)


def outcome_document(outcome: Outcome, evaluator: Evaluator, after: Sequence[Check] | None) -> dict[str, Any]:
    """The result as a JSON document; `after`: checks of the new design."""
    document: dict[str, Any] = {"feasible": outcome.feasible, "evaluations": outcome.evaluations}
    if outcome.feasible or (outcome.design is not None and outcome.changes):
        document["changes"] = [change.as_json() for change in outcome.changes]
        new = {check.name: attributes(check, "margin", "verdict") for check in after or ()}
        document["margins"] = [
            {"check": one.name, "before": attributes(one, "margin", "verdict"), "after": new.get(one.name)}
            for one in evaluator.checks
        ]
    if not outcome.feasible:
        document["conflicts"] = [list(conflict.names) for conflict in outcome.conflicts]
        document["certain"] = [conflict.fixed for conflict in outcome.conflicts]
        document["relax"] = [
            {
                "check": one.name,
                "limit": None if one.limit is None else as_json(one.limit, one.unit),
                "needed": None if one.needed is None else as_json(one.needed, one.unit),
                "margin": one.margin,
                "keeping": list(one.keeping),
            }
            for one in outcome.relax
        ]
        if outcome.left_out:
            document["left_out"] = list(outcome.left_out)
    if not outcome.complete:
        document["complete"] = False
    if outcome.interrupted:
        document["interrupted"] = True
    return document
