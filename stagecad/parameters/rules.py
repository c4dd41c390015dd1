"""Rules across values: conditions for the machine to be manufacturable and to fit together.

A rule checks a design and yields one message for each inconsistency: keys, values, and what would be right; the values
of `<stage.length, stage.travel>` are put in. Only a design that cannot be built violates a rule; one that can be built
but misses a requirement (speed, smoothness, load) fails a design check. A remedy is a change of one parameter that
satisfies a violated rule.
"""

import math
import re
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError
from stagecad.parameters.machine import Machine
from stagecad.parameters.schema import Entry
from stagecad.parameters.units import attributes

ROUNDING = 1e-6
"""Tolerance of comparisons for rounding errors, mm."""

_KEY = re.compile(r"[a-z][a-z0-9_]*(?:\.[a-z0-9_]+)+")
_GIVEN = re.compile(r"<([^<>]+)>")

Check = Callable[["Design"], Iterator[str]]
_RULES: dict[str, dict[str, Check]] = {}
"""Rules by module and name."""


@dataclass(frozen=True)
class Violation:
    """A rule that a design violates, with the message, and the parameters that it names, in its order."""

    rule: str
    message: str
    keys: tuple[str, ...]

    @property
    def part(self) -> str:
        """Table of the first parameter: the part or subsystem concerned."""
        return self.keys[0].split(".")[0] if self.keys else "machine"


def rule(check: Check) -> Check:
    """Register a rule: a generator of messages, named by its function."""
    _RULES.setdefault(check.__module__, {})[check.__name__.removesuffix("_")] = check
    return check


def all_rules(machine: Machine) -> dict[str, Check]:
    """Every rule of a machine by name."""
    found: dict[str, Check] = {}
    for module in machine.rules:
        import_module(module)
        found.update(_RULES.get(module, {}))
    return found


def broken(design: Design, name: str, check: Check) -> list[Violation]:
    """Violations of one rule; silent about parts that are not in the machine."""
    absent = absent_tables(design.machine)
    found = []
    for written in check(design):
        message = _GIVEN.sub(lambda keys: given(design, *keys[1].split(", ")), written)
        keys = tuple(dict.fromkeys(word for word in _KEY.findall(message) if design.has(word)))
        if not any(key.startswith(table) for key in keys for table in absent):
            found.append(Violation(name, message, keys))
    return found


def absent_tables(machine: Machine) -> tuple[str, ...]:
    """Tables of packaged parts none of which is in a machine of the user's own, each with a dot at its end."""
    if machine.declaration is None:
        return ()
    present = {part.part for part in machine.declaration.parts}
    return tuple(f"{table}." for table, parts in machine.owners.items() if not present.intersection(parts))


def present_entries(design: Design) -> list[Entry]:
    """Every parameter but those of packaged parts that are not in the machine, those of its own parts first."""
    absent = absent_tables(design.machine)
    entries = [entry for entry in design.entries if not entry.key.startswith(absent)]
    return sorted(entries, key=lambda entry: entry.key not in design.machine.own)


def violations(design: Design) -> list[Violation]:
    """All violations of a design; empty if it can be built."""
    return [one for name, check in all_rules(design.machine).items() for one in broken(design, name, check)]


def by_part(found: Sequence[Violation]) -> list[Violation]:
    """Violations grouped by part, the parts in the order of their first violation."""
    parts = list(dict.fromkeys(one.part for one in found))
    return sorted(found, key=lambda one: parts.index(one.part))


def given(design: Design, *keys: str) -> str:
    """Keys with their values for a message: ``stage.length = 230 mm and stage.travel = 200 mm``."""
    parts = [f"{key} = {design.entry(key).text}" for key in keys]
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


def length(value: float) -> str:
    """A length in a message: at most three decimals."""
    return f"{round(value, 3):g} mm"


def screw_length(design: Design, key: str, engaged: float, limit: str, where: str) -> Iterator[str]:
    """Messages about a screw, of the table `key`, whose engaged length of thread, mm, is too short or exceeds the depth
    of its thread, of the key `limit`; `where` is the length outside the thread, in words."""
    least = design.making.engagement * design.value(f"{key}.diameter")
    if engaged < least - ROUNDING:
        short = length(max(engaged, 0.0))
        yield f"<{key}.length> is too short: {where} it engages {short}, and {length(least)} is needed"
    elif engaged > design.value(limit) + ROUNDING:
        yield f"<{key}.length> is too long: {where} it goes {length(engaged)} deep, but <{limit}>"


_FARTHEST = 4.0
"""A value is not searched beyond this multiple of the present one, or below its inverse."""
_STEPS, _HALVINGS = 10, 10

Changed = Callable[[Mapping[str, float]], "Design"]
"""The design with values changed, in the unit of their attributes, without regard to rules."""


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
    documents = []
    for one in found:
        ways = [attributes(remedy, "key", "value", "new_violations") for remedy in remedies(design, one, changed)]
        documents.append({**attributes(one, "rule", "part", "message", "keys"), "satisfied_by": ways})
    return documents


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
            messages = broken(changed({key: value}), violation.rule, rule)
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
    new = tuple(dict.fromkeys(one.rule for one in by_part(violations(changed({key: value}))) if one.rule not in known))
    text = f"{int(value) if whole else value:.10g} {entry.unit}".strip()
    return Remedy(key, text, value, new, abs(math.log(value / start)))


def _nearest(
    start: float, up: bool, whole: bool, named: Sequence[float], satisfied: Callable[[float], bool]
) -> float | None:
    """The satisfying value nearest to `start` in one direction, rounded away from it; None where there is none. Values
    `named` are tried besides those in growing steps."""
    if whole:
        values = [start + step if up else start - step for step in range(1, 9)]
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
    tried = rounded_values(outer, (3, 4, 6), (round, math.ceil if up else math.floor))
    return next((value for value in tried if satisfied(value)), outer)


def rounded_values(
    value: float, digits: Sequence[int], roundings: Sequence[Callable[[float], float]]
) -> Iterator[float]:
    """A value with each of these numbers of significant digits, by each of the roundings."""
    for count in digits:
        scale = 10.0 ** (math.floor(math.log10(abs(value))) + 1 - count)
        yield from (float(f"{rounding(value / scale) * scale:.10g}") for rounding in roundings)
