"""Rules across values: conditions for the machine to be manufacturable and to fit together.

A rule checks a design and yields one message for each inconsistency: keys, values, and what would be right. Only a
design that cannot be built violates a rule; one that can be built but misses a requirement (speed, smoothness, load)
fails a design check.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.machine import Machine

ROUNDING = 1e-6
"""Tolerance of comparisons for rounding errors, mm."""

_KEY = re.compile(r"[a-z][a-z0-9_]*(?:\.[a-z0-9_]+)+")

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
    for message in check(design):
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
    screw = given(design, f"{key}.length")
    if engaged < least - ROUNDING:
        yield f"{screw} is too short: {where} it engages {length(max(engaged, 0.0))}, and {length(least)} is needed"
    elif engaged > design.value(limit) + ROUNDING:
        yield f"{screw} is too long: {where} it goes {length(engaged)} deep, but {given(design, limit)}"
