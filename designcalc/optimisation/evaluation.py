"""Fast evaluation of the rules and checks of a changed design, and its distance from satisfying all of them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from designcalc.checks.check import Check
from designcalc.checks.run import changed_masses, run_checks, subjects_of
from designcalc.optimisation.space import Free, distance, start_point, values_at
from stagecad.parameters.errors import InputError
from stagecad.parameters.rules.registry import violations

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import Masses
    from stagecad.parameters.variations import Variations

Array = NDArray[np.float64]

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
            return check.margin is not None and check.margin < min(self.safety, self._present(check))
        return check.verdict != "passes"

    def _present(self, check: Check) -> float:
        position = self.positions.get(check.name)
        margin = self.checks[position].margin if position is not None else None
        return max(margin, 0.0) if margin is not None else math.inf

    def axes(self, name: str) -> list[int]:
        """The free parameters that a check reads, directly, by a formula or by the masses of the solids."""
        inputs = self.checks[self.positions[name]].inputs
        weighed = any("solids" in item.origin for item in inputs.values()) and self.masses is not None
        # A weighed check reads the masses, which depend on these keys.
        of_mass = subjects_of(self.base).mass_keys if weighed else ()
        found = []
        for axis, one in enumerate(self.free):
            moved = self.variations.dependents([one.key])
            if moved & inputs.keys() or not inputs or any(key.startswith(of_mass) for key in moved):
                found.append(axis)
        return found
