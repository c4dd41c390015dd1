"""Changes of one parameter that satisfy a violated rule."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError
from stagecad.parameters.rules.registry import Violation, all_rules, broken, by_part, violations

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

_FARTHEST = 4.0
"""A value is not searched beyond this multiple of the present one, or below its inverse."""
_STEPS, _HALVINGS = 10, 10

Changed = Callable[[str, float], "Design"]
"""The design with one value changed, in the unit of its attribute, without regard to rules."""


@dataclass(frozen=True)
class Remedy:
    """The nearest value of one parameter with which a rule is satisfied."""

    key: str  # parameter
    value: str  # with its unit
    number: float  # the same in the unit of its attribute
    new_violations: tuple[str, ...]  # rules that the design then violates and did not before
    distance: float  # logarithm of the ratio of the two values


def violation_documents(design: Design, found: Sequence[Violation], changed: Changed) -> list[dict[str, Any]]:
    """Violations as JSON documents, in their order, each with its remedies."""
    return [
        {
            "rule": one.rule,
            "part": one.part,
            "message": one.message,
            "keys": list(one.keys),
            "satisfied_by": [
                {"key": remedy.key, "value": remedy.value, "new_violations": list(remedy.new_violations)}
                for remedy in remedies(design, one, changed)
            ],
        }
        for one in found
    ]


def remedies(
    design: Design, violation: Violation, changed: Changed, among: Container[str] | None = None
) -> list[Remedy]:
    """The nearest value that satisfies the rule, for each parameter that the message names, or those `among` them.

    Those without new violations come first, then the smallest relative change; values that `--set` gives last. With
    `among`, the rule may have another message instead: the first of several changes.
    """
    keys = [key for key in violation.keys if among is None or key in among]
    found = [remedy for key in keys if (remedy := _remedy(design, violation, key, changed, among is None)) is not None]
    return sorted(found, key=lambda one: (design.is_overridden(one.key), len(one.new_violations), one.distance))


def _remedy(design: Design, violation: Violation, key: str, changed: Changed, fewer: bool) -> Remedy | None:
    entry = design.entry(key)
    if isinstance(entry.value, bool | str) or entry.value <= 0 or entry.origin.startswith("computed:"):
        return None
    rule = all_rules(design.machine)[violation.rule]
    before = len(broken(design, violation.rule, rule))

    def satisfied(value: float) -> bool:
        try:
            messages = broken(changed(key, value), violation.rule, rule)
        except InputError:
            return False
        return len(messages) < before + (not fewer) and all(one.keys != violation.keys for one in messages)

    start = float(entry.value)
    whole = isinstance(entry.value, int)
    # A message names the ends of a range that is narrower than the steps of the search.
    named = [float(text) for text in re.findall(rf"(\d+(?:\.\d+)?) {re.escape(entry.unit)}\b", violation.message)]
    found = [value for up in (True, False) if (value := _nearest(start, up, whole, named, satisfied)) is not None]
    if not found:
        return None
    value = min(found, key=lambda one: abs(math.log(one / start)))
    known = {one.rule for one in violations(design)}
    new = tuple(dict.fromkeys(one.rule for one in by_part(violations(changed(key, value))) if one.rule not in known))
    text = f"{int(value) if whole else value:.10g} {entry.unit}".strip()
    return Remedy(key, text, value, new, abs(math.log(value / start)))


def _nearest(
    start: float, up: bool, whole: bool, named: Sequence[float], satisfied: Callable[[float], bool]
) -> float | None:
    """The satisfying value nearest to `start` in one direction, rounded away from it; None where there is none. Values
    `named` are tried besides those in growing steps."""
    if whole:
        steps = range(1, 9)
        values = [start + step if up else start - step for step in steps]
        return next((value for value in values if value > 0 and satisfied(value)), None)
    steps = [0.02 * 1.6**number for number in range(_STEPS)]
    steps += [abs(math.log(one / start)) for one in named if one > 0 and (one > start) == up and one != start]
    tried = [start, *(start * math.exp(step if up else -step) for step in sorted(steps) if step < math.log(_FARTHEST))]
    place = next((place for place, one in enumerate(tried) if place and satisfied(one)), None)
    if place is None:
        return None
    inner, outer = tried[place - 1], tried[place]
    for _ in range(_HALVINGS):
        middle = math.sqrt(inner * outer)
        inner, outer = (inner, middle) if satisfied(middle) else (middle, outer)
    for digits in (3, 4, 6):
        scale = 10.0 ** (math.floor(math.log10(outer)) + 1 - digits)
        for rounding in (round, math.ceil if up else math.floor):
            rounded = float(f"{rounding(outer / scale) * scale:.10g}")
            if satisfied(rounded):
                return rounded
    return outer
