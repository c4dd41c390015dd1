"""Search for the design nearest to the present one that satisfies rules and checks, over the free parameters."""

import math
import time
import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from designcalc.checks.check import Check
from designcalc.checks.run import changed_masses, run_checks, subjects_of
from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError, require
from stagecad.parameters.mass_properties import Masses
from stagecad.parameters.rules import present_entries, remedies, rounded_values, violations
from stagecad.parameters.units import DIMENSIONLESS, format_quantity, from_si, parse_quantity, to_si, unit_dimension
from stagecad.parameters.variations import Variations

Array = NDArray[np.float64]

_WIDE = 20.0
"""A positive range whose ends differ by more than this factor is searched on a logarithmic scale."""


@dataclass(frozen=True)
class Free:
    """A parameter that may change."""

    key: str  # parameter
    unit: str  # of its attribute
    # low, high: ends of its range, in `unit`; equal for choices
    low: float
    high: float
    whole: bool  # whole numbers only
    choices: tuple[Any, ...]  # values instead of a range, in the order of the file
    start: Any  # present value
    weight: float = 1.0  # of its change in the distance

    @property
    def logarithmic(self) -> bool:
        """Whether the scale is logarithmic."""
        return self.low > 0 and self.high / self.low > _WIDE

    def value(self, place: float) -> Any:
        """Value at a place from 0 to 1."""
        place = min(max(place, 0.0), 1.0)
        if self.choices:
            return self.choices[min(int(place * len(self.choices)), len(self.choices) - 1)]
        if self.logarithmic:
            found = self.low * (self.high / self.low) ** place
        else:
            found = self.low + place * (self.high - self.low)
        found = min(max(found, self.low), self.high)
        return round(found) if self.whole else float(f"{found:.10g}")

    def place(self, value: Any) -> float:
        """Place of a value; a value outside of the range has that of the nearer end."""
        if self.choices:
            index = self.choices.index(value) if value in self.choices else 0
            return (index + 0.5) / len(self.choices)
        bounded = min(max(float(value), self.low), self.high)
        if self.logarithmic:
            return math.log(bounded / self.low) / math.log(self.high / self.low)
        return (bounded - self.low) / (self.high - self.low)

    def distance(self, value: Any) -> float:
        """Size of the change from the present value, in units of the range; 1 for another choice."""
        if self.choices:
            return float(value != self.start)
        if self.logarithmic:
            return abs(math.log(value / self.start)) / math.log(self.high / self.low) if value > 0 else 1.0
        return abs(value - self.start) / (self.high - self.low)

    def text(self, value: Any) -> str:
        """The value as it is written in a parameter file."""
        if isinstance(value, bool):
            return str(value).lower()
        if self.whole or isinstance(value, str):
            return str(value)
        return format_quantity(to_si(value, self.unit), self.unit, 10)


def free_parameters(design: Design, given: Sequence[str]) -> tuple[Free, ...]:
    """Parameters that are free: those marked in the file (`free = "8 mm..20 mm"`), and those of `--free`, texts
    `KEY=LOW:HIGH` or `KEY=A|B|C` for choices, which replace the marks of the same keys."""
    marked = [entry for entry in present_entries(design) if entry.free]
    found = {entry.key: read_range(entry.key, entry.free, "..", design, "free") for entry in marked}
    for text in given:
        key, equals, rest = (part.strip() for part in text.partition("="))
        require(equals and rest, f"--free '{text}': write KEY=LOW:HIGH, like stage.thickness=8mm:20mm, or KEY=A|B")
        read = read_range(key, rest, ":", design, "--free")
        found[read.key] = read
    require(found, f'{design.file}: no parameter is free; mark some (free = "8 mm..20 mm") or give --free KEY=LOW:HIGH')
    return tuple(found.values())


def read_range(key: str, text: str, separator: str, design: Design, where: str) -> Free:
    """Read a range or choices of one parameter."""
    entry = design.entry(key)
    place = f"{where} {key}"
    words = [word.strip().strip("\"'").strip() for word in text.split("|")]
    number = isinstance(entry.value, int | float) and not isinstance(entry.value, bool)
    whole = number and isinstance(entry.value, int)
    unit = entry.unit
    wanted = unit if unit_dimension(unit) != DIMENSIONLESS else ""
    if len(words) > 1 or not number:
        choices = tuple(_choice(word, entry.value, wanted, unit, place) for word in words)
        require(len(set(choices)) >= 2, f"{place} = '{text}': at least two different choices are needed, like A|B")
        if entry.value not in choices:
            choices = (entry.value, *choices)
        return Free(entry.key, unit, 0.0, 0.0, whole, choices, entry.value)
    ends = [part.strip().strip("\"'").strip() for part in text.split(separator)]
    require(len(ends) == 2 and all(ends), f"{place} = '{text}': write LOW{separator}HIGH, like '8 mm{separator}20 mm'")
    low, high = (from_si(parse_quantity(_bare(end, wanted), wanted, place), unit) for end in ends)
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise InputError(f"{place} = '{text}': the lower end must be below the upper one, and both finite")
    return Free(entry.key, unit, low, high, whole, (), entry.value)


def _bare(text: str, unit: str) -> Any:
    if unit:
        return text
    try:
        return float(text)
    except ValueError:
        return text


def _choice(word: str, present: Any, wanted: str, unit: str, place: str) -> Any:
    if isinstance(present, bool):
        require(word in ("true", "false"), f"{place}: '{word}' is neither true nor false")
        return word == "true"
    if isinstance(present, str):
        return word
    value = from_si(parse_quantity(_bare(word, wanted), wanted, place), unit)
    return round(value) if isinstance(present, int) else value


def values_at(free: Sequence[Free], point: Array) -> dict[str, Any]:
    """Values of all free parameters at a point of the unit cube, shape (n,)."""
    return {one.key: one.value(float(place)) for one, place in zip(free, point, strict=True)}


def start_point(free: Sequence[Free]) -> Array:
    """Point of the present values."""
    return np.array([one.place(one.start) for one in free])


def distance(free: Sequence[Free], values: Mapping[str, Any]) -> float:
    """Weighted sum of the changes in units of their ranges."""
    return math.fsum(one.weight * one.distance(values[one.key]) for one in free)


RULE_PENALTY = 1.0
"""Shortfall of one violated rule; a check that misses its limit by its own size has log 2."""
UNMET_PENALTY = 0.1
"""Shortfall of a check that fails by next to nothing: rather one check by far than many by little."""
REFUSED = 50.0
"""Shortfall of values that make no design, or of a check without a value."""


@dataclass(frozen=True)
class Evaluation:
    """One design of the search."""

    point: Array  # of the unit cube
    values: Mapping[str, Any]  # of the free parameters
    margins: Mapping[str, float | None]  # of the checks that were run; None without a value
    unmet: frozenset[str]  # checks among them that do not pass
    violated: tuple[str, ...]  # names of the violated rules, one for each message
    distance: float  # sum of the changes in units of their ranges
    refused: str = ""  # why the values make no design
    complete: bool = True  # whether all checks of the design were run

    def _knows(self, names: Collection[str]) -> bool:
        return self.complete or all(name in self.margins for name in names)

    def shortfall(self, names: Collection[str]) -> float:
        """Distance from satisfying all rules and these checks: 0 when all are satisfied.

        The sum of ``log(1 - margin)`` and a constant over the checks that fail, of a constant for each violated rule
        and for each check out of its range.
        """
        if self.refused or not self._knows(names):
            return REFUSED
        total = RULE_PENALTY * len(self.violated)
        for name in names:
            if name in self.unmet:
                margin = self.margins.get(name)
                total += REFUSED / 10 if margin is None else math.log1p(max(-margin, 0.0)) + UNMET_PENALTY
        return total

    def satisfies(self, names: Collection[str]) -> bool:
        """Whether no rule is violated and all these checks pass."""
        return not self.refused and not self.violated and self._knows(names) and self.unmet.isdisjoint(names)


class OutOfBudgetError(Exception):
    """The evaluations, or the time, of a search are used up."""


@dataclass
class Evaluator:
    """Evaluates points of the unit cube of the free parameters."""

    variations: Variations  # of the design
    free: Sequence[Free]  # parameters
    masses: Masses | None = None  # of the present solids; None estimates them from plain volumes
    safety: float = 0.0  # part of its limit by which a check must pass, so that small errors of the masses do no harm
    count: int = 0
    # Every evaluated design that violates no rule, or of which all checks were run
    archive: list[Evaluation] = field(default_factory=list)
    most: int | None = None  # Number of evaluations beyond which `OutOfBudgetError` is raised
    deadline: float | None = None  # Time on the clock `time.monotonic` beyond which it is raised
    progress: Callable[[int], None] = lambda done: None  # called with the number of evaluations at each of them

    def __post_init__(self) -> None:
        self.base: Design = self.variations.design
        self.checks: list[Check] = run_checks(self.base, self.masses)
        self.positions = {check.name: position for position, check in enumerate(self.checks)}
        self.start = start_point(self.free)

    def design(self, values: Mapping[str, Any]) -> Design:
        """The design with these values of free parameters; those at their present value keep formula and origin."""
        changed = {one.key: values[one.key] for one in self.free if values[one.key] != one.start}
        return self.variations.changed(changed) if changed else self.base

    def checks_of(self, values: Mapping[str, Any]) -> list[Check]:
        """All checks of the design with these values."""
        design = self.design(values)
        return run_checks(design, changed_masses(design, self.base, self.masses), advise=False)

    def at(self, point: Array, names: Collection[str] | None = None) -> Evaluation:
        """The evaluation at a point; of all checks, or of those named."""
        return self.of(values_at(self.free, point), names, point)

    def of(
        self,
        values: Mapping[str, Any],
        names: Collection[str] | None = None,
        point: Array | None = None,
        limited: bool = True,
    ) -> Evaluation:
        """The evaluation of values of the free parameters; where it is not `limited`, at any time."""
        late = self.deadline is not None and time.monotonic() >= self.deadline
        if limited and (late or (self.most is not None and self.count >= self.most)):
            raise OutOfBudgetError
        self.count += 1
        self.progress(self.count)
        if point is None:
            point = np.array([one.place(values[one.key]) for one in self.free])
        far = distance(self.free, values)
        try:
            design = self.design(values)
        except InputError as error:
            return Evaluation(point, values, {}, frozenset(), (), far, str(error))
        violated = tuple(one.rule for one in violations(design))
        masses = changed_masses(design, self.base, self.masses)
        positions = {self.positions[name] for name in names} if names is not None else None
        found = run_checks(design, masses, None, positions, advise=False)
        if names is not None and {check.name for check in found} != set(names):
            # With another switch the design has other checks, at other positions.
            found, positions = run_checks(design, masses, advise=False), None
        margins = {check.name: check.margin for check in found}
        unmet = frozenset(check.name for check in found if self.fails(check))
        evaluation = Evaluation(point, values, margins, unmet, violated, far, complete=positions is None)
        if positions is None or not violated:
            self.archive.append(evaluation)
        return evaluation

    def fails(self, check: Check) -> bool:
        """Whether a check does not pass; one without a verdict in the present design is not required."""
        if check.verdict == "undecidable":
            return False
        if check.verdict == "passes" and self.safety and check.limit:
            position = self.positions.get(check.name)
            present = self.checks[position].margin if position is not None else None
            least = self.safety if present is None else min(self.safety, max(present, 0.0))
            return check.margin is not None and check.margin < least
        return check.verdict != "passes"

    def axes(self, name: str) -> list[int]:
        """The free parameters that a check reads, directly, by a formula or by the masses of the solids."""
        inputs = self.checks[self.positions[name]].inputs
        weighed = any("solids" in item.origin for item in inputs.values()) and self.masses is not None
        # A weighed check reads the masses, which depend on these keys.
        of_mass = subjects_of(self.base).mass_keys if weighed else ()
        moved = [self.variations.dependents([one.key]) for one in self.free]
        weighs = [any(key.startswith(of_mass) for key in keys) for keys in moved]
        return [k for k, keys in enumerate(moved) if keys & inputs.keys() or not inputs or weighs[k]]


PENALTY = 3.0
"""Weight of the shortfall against the distance: any satisfying design is better than one that is not."""
OFFSET = 100.0
HALVINGS = 5
"""Bisections by which a change is taken back in part."""
MOST_REMEDIES = 4
"""Changes of each free parameter by the remedies of rules."""


@dataclass
class Best:
    """The best design of a search so far, kept when the search is interrupted."""

    evaluator: Evaluator
    names: Collection[str]  # checks that it should pass
    alone: bool = False  # whether no other checks are run
    evaluation: Evaluation | None = None

    @property
    def found(self) -> Evaluation:
        """The best evaluation, after the first one."""
        assert self.evaluation is not None
        return self.evaluation

    @property
    def run(self) -> Collection[str] | None:
        """The checks that are run; None for all."""
        return self.names if self.alone else None

    def passes(self, values: Mapping[str, Any]) -> bool:
        """Whether the design with these values satisfies rules and checks; it is kept if it is the best."""
        evaluation = self.evaluator.of(values, self.run)
        self.offer(evaluation)
        return evaluation.satisfies(self.names)

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


def cma_es(function: Callable[[Array], float], start: Array, budget: int, seed: int) -> None:
    """Minimise a function over the unit cube by covariance matrix adaptation (Hansen, 2001), package `cma`."""
    with warnings.catch_warnings():
        # Its plotting module warns when it is imported.
        warnings.simplefilter("ignore")
        import cma

        options = {"bounds": [0.0, 1.0], "seed": seed, "verbose": -9, "maxfevals": budget, "tolfun": 1e-6}
        # The package needs two dimensions.
        padded = [*start.tolist(), *[0.5] * (len(start) == 1)]
        strategy = cma.CMAEvolutionStrategy(padded, 0.25, options)
        while not strategy.stop():
            points = strategy.ask()
            strategy.tell(points, [function(np.asarray(point)[: len(start)]) for point in points])


class _FoundError(Exception):
    """A satisfying design was found, and no better one is sought."""


def cobyla(function: Callable[[Array], float], start: Array, budget: int) -> None:
    """Minimise a function over the unit cube by linear models in a trust region (Powell, 1994), of scipy."""
    from scipy.optimize import minimize

    bounds = [(0.0, 1.0)] * len(start)
    options = {"rhobeg": 0.25, "maxiter": max(budget, len(start) + 2), "tol": 1e-3}
    minimize(function, start, method="COBYLA", bounds=bounds, options=options)


def search(best: Best, budget: int, *, seed: int = 1, first: bool = False) -> Best:
    """Search the nearest design that satisfies the rules and the checks of `best`.

    Covariance matrix adaptation, then each change is taken back as far as the requirements allow. Where the first
    satisfying design is enough, a local search comes before: it needs a fraction of the evaluations.
    """
    evaluator = best.evaluator
    for known in evaluator.archive:
        best.offer(known)

    def merit(point: Array) -> float:
        found = best.offer(evaluator.at(np.clip(point, 0.0, 1.0), best.run))
        if first and best.satisfied:
            raise _FoundError
        return found

    def start() -> Array:
        return np.clip(best.found.point if best.found.distance else evaluator.start, 0.02, 0.98)

    with suppress(_FoundError):
        merit(evaluator.start)
        began = evaluator.count
        if first:
            cobyla(merit, start(), budget // 2)
        cma_es(merit, start(), budget - (evaluator.count - began), seed)
    if best.satisfied and not first:
        take_back(best)
        round_values(best)
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
        found = [
            remedy
            for one in violations(design)
            for remedy in remedies(design, one, lambda new: evaluator.design({**values, **new}), free)
        ]
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


NO_GAIN = 0.98
"""Ratio of two distances from the present design above which they count as equal."""


def take_back(best: Best) -> None:
    """Take each change of a satisfying design back."""
    for _ in range(3):
        before, values = best.found.distance, best.found.values
        for one in sorted(best.evaluator.free, key=lambda one: one.distance(values[one.key])):
            if best.found.values[one.key] != one.start:
                take_back_one(best, one, HALVINGS)
        if best.found.distance > NO_GAIN * before:
            break


def take_back_one(best: Best, one: Free, halvings: int) -> None:
    """Take the change of one parameter of a satisfying design back: wholly if possible, else by bisection."""
    kept = best.found.values
    if not best.passes({**kept, one.key: one.start}) and not one.choices:
        there, here = one.place(one.start), one.place(kept[one.key])
        bisected(there, here, lambda place: best.passes({**kept, one.key: one.value(place)}), halvings)


def bisected(low: float, high: float, fits: Callable[[float], bool], halvings: int) -> float:
    """The number nearest to `low` that fits, by bisection from `high`, which does."""
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fits(middle) else (middle, high)
    return high


def round_values(best: Best) -> None:
    """Round each changed value of a satisfying design to the fewest digits with which it still satisfies all, and is
    as near."""
    for one in best.evaluator.free:
        value, farthest = best.found.values[one.key], best.found.distance / NO_GAIN
        if one.choices or one.whole or value == one.start or not value:
            continue
        for rounded in rounded_values(value, (2, 3, 4), (round, math.floor, math.ceil)):
            if one.low <= rounded <= one.high:
                found = best.evaluator.of({**best.found.values, one.key: rounded}, best.run)
                if found.satisfies(best.names) and found.distance <= farthest:
                    best.evaluation = found
                    break


def pareto_front(points: Array) -> Array:
    """The points, shape (n, 2), of which no other one is larger in one coordinate and not smaller in the other."""
    order = np.lexsort((-points[:, 1], -points[:, 0]))
    front: list[Any] = []
    for point in points[order]:
        if not front or point[1] > front[-1][1]:
            front.append(point)
    return np.array(front[::-1]).reshape(-1, 2)
