"""Declaration of the keys of a table of the parameter file: one line each, with unit, meaning and bounds.

A table is a frozen dataclass whose fields are made by the functions below. The loader reads the declarations, so a key
is added by one line in its table and one in the parameter file, and nothing else.

A field's unit is the one its attribute is kept in: `mm` and `deg` for lengths and angles of geometry, SI for all else.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Any, Literal

TOLERANCE_CLASSES = ("X", "X.X", "X.XX")
"""General tolerances by the decimals of a dimension; a class of ISO 286 (`H7`) may stand in their place."""

FieldKind = Literal["number", "count", "switch", "text", "choice", "material"]


@dataclass(frozen=True)
class Declaration:
    """Type, unit and bounds of a key of the parameter file.

    Args:
        kind: of the value.
        meaning: one line for people.
        unit: of a number as the attribute keeps it; empty when dimensionless.
        low, high: bounds in `unit`; `low` itself is allowed only where `closed`.
        closed: whether the lower bound is allowed.
        allowed: values of a choice.
        computed: computed from other keys if the file leaves it out.
        why: reason of the bounds, for messages.
        default: value if the file leaves it out; None where the file must give one.
    """

    kind: FieldKind
    meaning: str
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    closed: bool = True
    allowed: tuple[str, ...] = ()
    computed: bool = False
    why: str = ""
    default: str | None = None


def _key(declaration: Declaration) -> Any:
    return field(metadata={"declaration": declaration})


def mm(meaning: str, *, zero: bool = False, computed: bool = False, default: str | None = None) -> Any:
    """A length of geometry, kept in millimetres; positive, or not negative where `zero` is allowed."""
    return _key(Declaration("number", meaning, "mm", low=0.0, closed=zero, computed=computed, default=default))


def number(
    meaning: str,
    unit: str = "",
    *,
    low: float = 0.0,
    high: float = math.inf,
    closed: bool = False,
    computed: bool = False,
    default: str | None = None,
) -> Any:
    """A number in SI; positive unless the bounds allow other values (`closed`: the lower bound itself is allowed)."""
    return _key(
        Declaration("number", meaning, unit, low=low, high=high, closed=closed, computed=computed, default=default)
    )


def count(meaning: str, *, low: int = 1, high: int = 100, computed: bool = False) -> Any:
    """A whole number."""
    return _key(Declaration("count", meaning, low=low, high=high, computed=computed))


def switch(meaning: str) -> Any:
    """true or false."""
    return _key(Declaration("switch", meaning))


def text(meaning: str, default: str | None = None) -> Any:
    """A line of text."""
    return _key(Declaration("text", meaning, default=default))


def choice(meaning: str, *allowed: str) -> Any:
    """One of a few words."""
    return _key(Declaration("choice", meaning, allowed=allowed))


def of_material(meaning: str = "material") -> Any:
    """Name of one of the tables below `materials`."""
    return _key(Declaration("material", meaning))


def declarations(table: type) -> dict[str, Declaration]:
    """The keys of a table, in order, with what each holds; tables below it are left out."""
    return {item.name: item.metadata["declaration"] for item in fields(table) if "declaration" in item.metadata}
