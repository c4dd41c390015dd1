"""Rules across values: what must hold together for the machine to be made and put together at all.

A rule looks at a design and says, in the user's words, what does not go together: keys, values, what would be right.
Only what cannot be built is refused here. What can be built but falls short of a requirement (speed, smoothness, load)
is a design check, and no rule.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

from stagecad.parameters.errors import InputError

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

HAIR = 1e-6
"""mm: what rounding may cost, and no workshop could tell."""

_MODULES = ("sliding", "height", "holes", "teeth", "values")

Check = Callable[["Design"], Iterator[str]]
_RULES: dict[str, Check] = {}


@dataclass(frozen=True)
class Violation:
    """A rule that a design breaks, and how."""

    rule: str
    message: str


def rule(check: Check) -> Check:
    """Register a rule: a generator of messages, named by its function."""
    _RULES[check.__name__.removesuffix("_")] = check
    return check


@cache
def all_rules() -> dict[str, Check]:
    """Every rule by name."""
    for module in _MODULES:
        import_module(f"stagecad.parameters.rules.{module}")
    return dict(_RULES)


def violations(design: Design) -> list[Violation]:
    """What does not go together in a design; empty where it can be built."""
    return [Violation(name, message) for name, check in all_rules().items() for message in check(design)]


def require(design: Design) -> None:
    """Refuse a design that cannot be built.

    Raises:
        InputError: with the first thing that does not go together, and the number of others.
    """
    found = violations(design)
    if found:
        more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
        raise InputError(f"{design.file}: {found[0].message}{more}")


def given(design: Design, *keys: str) -> str:
    """Keys with their values, as they stand in messages: ``stage.length = 230 mm and stage.travel = 200 mm``."""
    parts = [f"{key} = {design.entry(key).text}" for key in keys]
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


def length(value: float) -> str:
    """A length in a message: at most three decimals."""
    return f"{round(value, 3):g} mm"
