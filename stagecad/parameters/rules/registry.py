"""Rules across values: conditions for the machine to be manufacturable and to fit together.

A rule checks a design and yields one message for each inconsistency: keys, values, and what would be right. Only a
design that cannot be built violates a rule; one that can be built but misses a requirement (speed, smoothness, load)
fails a design check.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

from stagecad.friction_stage.parameters.machine import schema

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

ROUNDING = 1e-6
"""Tolerance of comparisons for rounding errors, mm."""

_KEY = re.compile(r"[a-z][a-z0-9_]*(?:\.[a-z0-9_]+)+")

_MODULES = ("sliding", "height", "holes", "edges", "making", "stops", "teeth", "values")

Check = Callable[["Design"], Iterator[str]]
_RULES: dict[str, Check] = {}


@dataclass(frozen=True)
class Violation:
    """A rule that a design violates, with the message."""

    rule: str
    message: str

    @property
    def keys(self) -> tuple[str, ...]:
        """The parameters that the message names, in its order."""
        known = schema()
        return tuple(dict.fromkeys(word for word in _KEY.findall(self.message) if word in known))

    @property
    def part(self) -> str:
        """Table of the first of them: the part or subsystem concerned."""
        return self.keys[0].split(".")[0] if self.keys else "machine"


def rule(check: Check) -> Check:
    """Register a rule: a generator of messages, named by its function."""
    _RULES[check.__name__.removesuffix("_")] = check
    return check


@cache
def all_rules() -> dict[str, Check]:
    """Every rule by name."""
    for module in _MODULES:
        import_module(f"stagecad.friction_stage.rules.{module}")
    return dict(_RULES)


def violations(design: Design) -> list[Violation]:
    """All violations of a design; empty if it can be built."""
    return [Violation(name, message) for name, check in all_rules().items() for message in check(design)]


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
    """Messages about a screw whose thread engagement is too short or exceeds the depth of its thread.

    Args:
        design: the design.
        key: the screw's table, `screws.way`.
        engaged: length of engaged thread, mm.
        limit: key of the depth of the thread.
        where: the length outside the thread, for messages.
    """
    least = design.making.engagement * design.value(f"{key}.diameter")
    screw = given(design, f"{key}.length")
    if engaged < least - ROUNDING:
        yield f"{screw} is too short: {where} it engages {length(max(engaged, 0.0))}, and {length(least)} is needed"
    elif engaged > design.value(limit) + ROUNDING:
        yield f"{screw} is too long: {where} it goes {length(engaged)} deep, but {given(design, limit)}"
