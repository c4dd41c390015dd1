"""How far Table 1 can be met: the level of each requirement by itself and together, and Pareto fronts.

A requirement is weakened by a factor of up to `WEAKEST`. The least common factor with which a design violates no rule
and passes the checks is found by bisection, each step with a search of the free parameters; then each level is brought
nearer to its required value by itself. A search that finds no design counts as none.
"""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from designcalc.optimisation.conflicts import out_of_reach
from designcalc.optimisation.search import Best, Evaluator, Free, bisected, pareto_front, search, take_back_one
from stagecad.parameters.mass_properties import Masses
from stagecad.parameters.units import format_quantity, to_si
from stagecad.parameters.variations import Variations


@dataclass(frozen=True)
class Together:
    """Levels that one design meets together."""

    kept: str  # the requirement that was kept at the level it reaches by itself; empty for none
    levels: Mapping[str, float]  # in the unit of their keys, by name; empty where no design was found


@dataclass(frozen=True)
class Price:
    """A check that fails with the required value of one requirement, and not with the level that was reached."""

    requirement: str  # name in Table 1
    check: str  # name
    # value, limit: of the check, SI
    value: float | None
    limit: float | None
    unit: str  # of both


@dataclass
class Levels:
    """Result of the study; levels are in the units of their keys."""

    required: dict[str, float]  # values of the file
    units: dict[str, str]  # of the levels
    # checks that pass at no level, whatever the free parameters, by requirement
    never: dict[str, list[str]] = field(default_factory=dict)
    # what each requirement reaches by itself, the others as required but not met
    alone: dict[str, float] = field(default_factory=dict)
    # designs that meet all other checks of Table 1; nothing is kept in the first one
    together: list[Together] = field(default_factory=list)
    # what the required values of speed, acceleration and smoothness make fail
    prices: list[Price] = field(default_factory=list)
    # levels (n, 2) of two requirements by their names, the other ones left aside
    fronts: dict[tuple[str, str], list[tuple[float, float]]] = field(default_factory=dict)
    evaluations: int = 0  # number of evaluated designs


Array = NDArray[np.float64]

TABLE = "Table 1"
WEAKEST = 1e4
"""Factor by which a requirement may be weakened."""
CHANGE = 1e-3
"""Weight of a change of the machine, in its range, against one of a requirement."""
HALVINGS = 9
"""Bisections of a level for one machine: the range over 2^9, a factor of 1.02."""
STEPS = 5
"""Bisections of the common weakening, each with a search of a machine."""
SLACK = 1.05
"""Factor by which a kept requirement is weaker than the best that was reached, so that it is certainly met."""
FIRST = 5
"""Evaluations of the search of a first design, in those of the others."""
FRONT = 4
"""Designs of a Pareto front."""
ROUNDS = 2
"""Levels that are kept one after another before the rest is brought nearer for one machine."""


@dataclass(frozen=True)
class Level:
    """A requirement with a number that may be weakened."""

    name: str  # in Table 1
    key: str  # of its value
    larger: bool  # whether a larger value is harder to meet
    following: str = ""  # override of a key whose value may not be harder than this one

    def weaker(self, value: float, factor: float) -> float:
        """A level weaker by a factor."""
        return value / factor if self.larger else value * factor


LEVELS = (
    Level("resolution", "requirements.resolution_coarse", False),
    Level("speed", "requirements.speed", True),
    Level("acceleration", "requirements.acceleration", True, "requirements.acceleration_low"),
    Level("smoothness", "requirements.smoothness", False),
)
LEVEL_KEYS = frozenset(level.key for level in LEVELS)
FRONTS = (("speed", "acceleration"), ("acceleration", "smoothness"), ("speed", "smoothness"))
PRICED = ("speed", "acceleration", "smoothness")


@dataclass
class LevelStudy:
    """Study how far the requirements of Table 1 can be met."""

    vary: Callable[[Sequence[str]], Variations]  # the design with overrides `KEY=VALUE`
    machine: Sequence[Free]  # free parameters
    masses: Masses | None  # of the present solids
    budget: int  # evaluations of each search of a design
    seed: int = 1
    tell: Callable[[str], None] = lambda words: None  # called with what is being done

    def __post_init__(self) -> None:
        self.machine = [replace(one, weight=CHANGE) for one in self.machine]
        design = self.vary(()).design
        entries = {level.name: design.entry(level.key) for level in LEVELS}
        self.following = [
            f"{level.following}==min({design.entry(level.following).text}, {level.key})"
            for level in LEVELS
            if level.following
        ]
        self.result = Levels(
            {name: float(entry.value) for name, entry in entries.items()},
            {name: entry.unit for name, entry in entries.items()},
        )
        self.groups: dict[str, list[str]] = {}
        self.active: set[str] = set()

    def levels(self) -> Levels:
        """All parts of the study."""
        result = self.result
        self._find_groups()
        for level in LEVELS:
            self.tell(f"{level.name} by itself")
            found = self._reached((level,), {}, self.groups[level.name])
            if found is not None:
                result.alone[level.name] = found[level.name]
        names = [name for group in self.groups.values() for name in group]
        for kept in (None, *LEVELS):
            if kept is not None and (kept.name not in result.alone or kept.name not in PRICED):
                continue
            self.tell("all together" if kept is None else f"all together, {kept.name} kept")
            fixed = {} if kept is None else {kept.name: kept.weaker(result.alone[kept.name], SLACK)}
            found = self._reached([level for level in LEVELS if level is not kept], fixed, names)
            result.together.append(Together("" if kept is None else kept.name, found or {}))
        for pair in FRONTS:
            self._front(*pair)
        return result

    def _find_groups(self) -> None:
        """The checks of each requirement, and those among them that pass at no level."""
        self.tell("checks that pass at no level")
        evaluator = self._evaluator(LEVELS, {})
        # The present design with all free levels at their weakest.
        weak = evaluator.start.copy()
        for axis, one in enumerate(evaluator.free):
            if one.key in LEVEL_KEYS:
                weak[axis] = float(one.start == one.low)
        for check in evaluator.checks:
            if check.requirement.startswith(f"{TABLE}: "):
                self.groups.setdefault(check.requirement.removeprefix(f"{TABLE}: "), []).append(check.name)
        at_weakest = evaluator.at(weak)
        before = evaluator.at(evaluator.start)
        self.active = set(before.unmet)
        machine = range(len(self.machine))
        for name, group in self.groups.items():
            # A check that fails only at the weakest levels, and reads no free parameter, concerns the requirement alone
            # (the choice of a sensor, for example): no machine can change it.
            self.groups[name] = [
                one
                for one in group
                if one not in at_weakest.unmet or one in before.unmet or set(machine) & set(evaluator.axes(one))
            ]
        names = [name for group in self.groups.values() for name in group]
        never = out_of_reach(evaluator, [name for name in names if name in at_weakest.unmet], [at_weakest])[0]
        for name, group in self.groups.items():
            self.result.never[name] = [one for one in group if one in never]
            self.groups[name] = [one for one in group if one not in never]
        self.result.evaluations += evaluator.count

    def _evaluator(self, free: Collection[Level], fixed: Mapping[str, float]) -> Evaluator:
        """An evaluator of designs with free levels; the others as required, or `fixed`."""
        texts = [f"{level.key}={self._text(level, fixed[level.name])}" for level in LEVELS if level.name in fixed]
        ranges = []
        for level in LEVELS:
            if level in free:
                value = self.result.required[level.name]
                ends = sorted((value, level.weaker(value, WEAKEST)))
                ranges.append(Free(level.key, self.result.units[level.name], ends[0], ends[1], False, (), value))
        return Evaluator(self.vary([*self.following, *texts]), [*self.machine, *ranges], self.masses)

    def _text(self, level: Level, value: float) -> str:
        unit = self.result.units[level.name]
        return format_quantity(to_si(value, unit), unit, 10)

    def _reached(
        self, free: Sequence[Level], fixed: Mapping[str, float], names: Collection[str]
    ) -> dict[str, float] | None:
        """The hardest levels together of designs that pass the checks; None where no design was found. The level that
        is weakened most is kept where it is, then the least common weakening of the others is searched."""
        rest, found = list(free), dict(fixed)
        machine, levels = dict[str, Any](), dict[str, float]()
        for number in range(ROUNDS):
            best = Best(self._evaluator(rest, found), names, alone=True)
            if number:
                best.passes({**machine, **{level.key: levels[level.name] for level in rest}})
            if not self._least_common(best, rest, found):
                return None
            _harden(best)
            self.result.evaluations += best.evaluator.count
            values = best.found.values
            machine = {one.key: values[one.key] for one in self.machine}
            levels = {level.name: float(values[level.key]) for level in rest}
            worst = max(rest, key=lambda level: self._share(level, levels[level.name]))
            if not self._share(worst, levels[worst.name]) or len(rest) == 1 or number == ROUNDS - 1:
                break
            found[worst.name] = levels[worst.name]
            rest.remove(worst)
        found.update({level.name: levels[level.name] for level in rest})
        if len(free) == len(LEVELS):
            self._price(machine, found)
        return found

    def _least_common(self, best: Best, free: Sequence[Level], fixed: Mapping[str, float]) -> bool:
        """Bisect the common weakening of the free levels, with a search of a machine at each; whether there is one."""
        low, high = 0.0, 1.0
        if best.satisfied:
            high = _harden_together(best, max(self._share(level, best.found.values[level.key]) for level in free))
        while high - low >= 0.5**STEPS or not best.satisfied:
            share = 0.5 * (low + high) if best.satisfied else 1.0
            required = self.result.required
            levels = {level.name: level.weaker(required[level.name], WEAKEST**share) for level in free}
            machine = self._machine({**fixed, **levels}, best)
            keys = {level.key: levels[level.name] for level in free}
            if machine is not None and best.passes({**machine, **keys}):
                high = _harden_together(best, share)
            elif not best.satisfied:
                return False
            else:
                low = share
        return True

    def _share(self, level: Level, value: float) -> float:
        """The weakening of a level as a share of `WEAKEST`, on a logarithmic scale."""
        return abs(math.log(value / self.result.required[level.name])) / math.log(WEAKEST)

    def _machine(self, levels: Mapping[str, float], known: Best) -> dict[str, Any] | None:
        """Values of the machine's parameters with which the checks pass at these levels; None where none were found."""
        evaluator = self._evaluator((), levels)
        if known.evaluation is not None:
            evaluator.of({one.key: known.evaluation.values[one.key] for one in self.machine}, known.names)
        # Most checks always pass: a search asks for those that some design has failed. The first design takes longest.
        part = [name for name in known.names if name in self.active]
        budget = self.budget if known.satisfied else FIRST * self.budget
        while True:
            best = search(Best(evaluator, part, alone=True), budget, seed=self.seed, first=True)
            found = dict(best.found.values) if best.satisfied else None
            new = () if found is None else evaluator.of(found, known.names).unmet.intersection(known.names)
            if not new:
                break
            self.active |= set(new)
            part += sorted(new)
        self.result.evaluations += evaluator.count
        return found

    def _price(self, machine: Mapping[str, Any], levels: Mapping[str, float]) -> None:
        """What fails in the design that meets most, with the required value of one requirement after another."""
        failing = self._evaluator((), levels).of(machine).unmet
        for name in PRICED:
            if name not in levels:
                continue
            evaluator = self._evaluator((), {**levels, name: self.result.required[name]})
            unmet = evaluator.of(machine).unmet - failing
            self.result.prices += [
                Price(name, check.name, check.value, check.limit, check.unit)
                for check in evaluator.checks_of(machine)
                if check.name in unmet
            ]

    def _front(self, first: str, second: str) -> None:
        """Levels of two requirements that are met together, each kept in turn at levels between its ends."""
        alone = self.result.alone
        if first not in alone or second not in alone:
            return
        self.tell(f"Pareto front of {first} and {second}")
        one, other = (next(level for level in LEVELS if level.name == name) for name in (first, second))
        names = [*self.groups[first], *self.groups[second]]
        ends = self._reached((one,), {second: other.weaker(alone[second], SLACK)}, names)
        if ends is None:
            return
        points = [(ends[first], ends[second])]
        near, far = one.weaker(alone[first], SLACK), ends[first]
        for value in np.geomspace(near, far, FRONT)[:-1]:
            found = self._reached((other,), {first: float(value)}, names)
            if found is not None:
                points.append((found[first], found[second]))
        signs = np.where([one.larger, other.larger], 1.0, -1.0)
        front = pareto_front(np.array(points) * signs) * signs
        self.result.fronts[first, second] = sorted((float(x), float(y)) for x, y in front)


def _harden_together(best: Best, share: float) -> float:
    """Bring all free levels of a satisfying design nearer to their required values by one factor; the share left."""
    values, levels = best.found.values, [one for one in best.evaluator.free if one.key in LEVEL_KEYS]

    def passes(middle: float) -> bool:
        return best.passes({**values, **{one.key: one.value(_place(one, middle)) for one in levels}})

    return bisected(0.0, share, passes, HALVINGS)


def _place(one: Free, share: float) -> float:
    """Place of a level weakened by a share of its range."""
    return share if one.start == one.low else 1.0 - share


def _harden(best: Best) -> None:
    """Bring each level of a satisfying design as near to its required value as the checks allow, by bisection."""
    levels = [one for one in best.evaluator.free if one.key in LEVEL_KEYS]
    for one in levels * min(len(levels), 2):
        take_back_one(best, one, HALVINGS)
