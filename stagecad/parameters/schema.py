"""Declaration of the keys of a table of the parameter file: one line each, with unit, meaning and bounds.

A table is a frozen dataclass whose fields are made by the functions below. The loader reads the declarations, so a key
is added by one line in its table and one in the parameter file, and nothing else.

A field's unit is the one its attribute is kept in: `mm` and `deg` for lengths and angles of geometry, SI for all else.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any, Literal

from stagecad.parameters.errors import nearest, require
from stagecad.parameters.units import to_si

TOLERANCE_CLASSES = ("X", "X.X", "X.XX")
"""General tolerances by the decimals of a dimension; a class of ISO 286 (`H7`) may stand in their place."""

FieldKind = Literal["number", "count", "switch", "text", "choice", "material"]


@dataclass(frozen=True)
class Declaration:
    """Type, unit and bounds of a key of the parameter file."""

    kind: FieldKind  # of the value
    meaning: str  # one line for people
    unit: str = ""  # of a number as the attribute keeps it; empty when dimensionless
    # low, high: bounds in `unit`; `low` itself is allowed only where `closed`
    low: float = -math.inf
    high: float = math.inf
    closed: bool = True  # whether the lower bound is allowed
    allowed: tuple[str, ...] = ()  # values of a choice
    computed: bool = False  # computed from other keys if the file leaves it out
    why: str = ""  # reason of the bounds, for messages
    default: str | None = None  # value if the file leaves it out; None where the file must give one


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


@cache
def declarations(table: type) -> Mapping[str, Declaration]:
    """The keys of a table, in order, with what each holds; tables below it are left out."""
    return {item.name: item.metadata["declaration"] for item in fields(table) if "declaration" in item.metadata}


def nearest_key(key: str, known: Iterable[str]) -> str:
    """End of a message about an unknown key: the nearest known key, or the keys of its table."""
    keys = sorted(known)
    hint = nearest(key, keys)
    if key in {item.split(".")[0] for item in keys}:
        return f"; [{key}] is a table: name a key in it, like '{next(item for item in keys if item.startswith(key))}'"
    table, _, name = key.rpartition(".")
    if table.startswith("materials."):
        materials = {item.split(".")[1] for item in keys if item.startswith("materials.")}
        if table.split(".")[1] not in materials:
            return nearest(table.split(".")[1], materials).replace("did you mean", "did you mean material")
    if "did you mean" in hint:
        return hint
    table, _, name = key.rpartition(".")
    siblings = [item for item in keys if item.rpartition(".")[0] == table]
    if siblings:
        return f"; keys of [{table}]: {', '.join(item.rpartition('.')[2] for item in siblings)}"
    same = [item for item in keys if item.rpartition(".")[2] == name]
    if same:
        return f"; did you mean '{same[0]}'?"
    return nearest(key.split(".")[0], {item.split(".")[0] for item in keys})


@dataclass(frozen=True)
class FileEntry:
    """One key of a parameter file."""

    value: Any  # as written: text, number or truth value; or a `ByRow`
    place: str  # file and key, for messages
    # tolerance, origin: as written; None for a bare value
    tolerance: str | None = None
    origin: str | None = None
    free: str = ""  # range or choices in which an optimisation may change the value, as written; empty for none


@dataclass(frozen=True)
class ByRow:
    """The value of a key that a row of a project's table has."""

    key: str  # of the row's name
    file: str  # of the table
    rows: Mapping[str, FileEntry | None]  # the entry in each row by the row's name; None where its cell is empty
    otherwise: FileEntry | None  # entry of the parameter file, for an empty cell or no row


@dataclass(frozen=True)
class Entry:
    """One key of a design with its value."""

    key: str  # `stage.length`
    text: str  # value with its unit, as written (or as computed)
    value: Any  # number in the unit of the attribute, or text, or truth value
    unit: str  # of `value`; empty for a dimensionless one
    tolerance: str | None  # class, or None
    origin: str  # source of the value
    meaning: str  # one line for people
    std: float | None = None  # standard deviation in `unit`, where the file gives one
    formula: str = ""  # as written, where the value comes from a formula of the file
    free: str = ""  # range or choices in which an optimisation may change the value, as written

    @property
    def si(self) -> float:
        """The number in SI."""
        require(not isinstance(self.value, bool | str), f"parameter '{self.key}' = '{self.text}' is not a number")
        return to_si(float(self.value), self.unit)
