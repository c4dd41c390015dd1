"""One key of a design with its value, and how it is read: the text of a file checked against what the key may hold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.parameter_file import FileEntry
from stagecad.parameters.quantities import from_si, parse_uncertain, quoted
from stagecad.parameters.schema import Declaration


@dataclass(frozen=True)
class Entry:
    """One key of a design, for tables and reports.

    Args:
        key: `stage.length`.
        text: value with its unit, as written (or as computed).
        value: number as the attribute keeps it, or text, or truth value.
        unit: of `value`; empty when it has none.
        tolerance: class, or none.
        origin: where the value comes from.
        meaning: one line for people.
        std: standard deviation in `unit`, where the value carries one.
    """

    key: str
    text: str
    value: Any
    unit: str
    tolerance: str | None
    origin: str
    meaning: str
    std: float | None = None


def read_entry(key: str, entry: FileEntry, declaration: Declaration, materials: Sequence[str]) -> Entry:
    """An entry of the file checked against the declaration of its key."""
    value, std, tolerance = entry.value, None, entry.tolerance
    shown = str(value).lower() if isinstance(value, bool) else str(value)
    place = entry.place
    if declaration.kind == "number":
        value, std = _number(entry, declaration)
        if tolerance is None and entry.origin is None and declaration.unit == "mm":
            tolerance = _class_as_written(shown)
    elif declaration.kind == "count":
        value = _count(entry, declaration)
    elif declaration.kind == "switch":
        if shown not in ("true", "false"):
            raise InputError(f"{place}: {quoted(shown)} is neither true nor false")
        value, shown = shown == "true", shown.strip()
    else:
        if not isinstance(value, str) or not value.strip() or not value.isprintable():
            raise InputError(f"{place}: {shown!r} is no line of text")
        allowed = materials if declaration.kind == "material" else declaration.allowed
        if allowed and value not in allowed:
            what = "material" if declaration.kind == "material" else "choice"
            raise InputError(f"{place}: no {what} {quoted(value)}{nearest(value, allowed)}")
    if std is not None:
        std = from_si(std, declaration.unit)
    origin = entry.origin or "assumed: the file gives no origin"
    return Entry(key, shown, value, declaration.unit, tolerance, origin, declaration.meaning, std)


def _number(entry: FileEntry, declaration: Declaration) -> tuple[float, float | None]:
    si, std = parse_uncertain(entry.value, declaration.unit, entry.place)
    value = kept(si, declaration.unit)
    if not within(value, declaration):
        raise InputError(f"{entry.place}: {quoted(str(entry.value))} {bounds_text(declaration)}")
    return value, std


def within(value: float, declaration: Declaration) -> bool:
    """Whether a number lies in the bounds declared for its key."""
    above = value > declaration.low or (value == declaration.low and declaration.closed)
    return above and value <= declaration.high and not math.isinf(value)


def kept(si: float, unit: str) -> float:
    """SI as the attribute keeps it; a length in mm is freed of the rounding of its way through metres."""
    value = from_si(si, unit)
    return round(value, 9) if unit == "mm" and math.isfinite(value) else value


def bounds_text(declaration: Declaration) -> str:
    """What a number may be, as the end of a message."""
    unit = f" {declaration.unit}" if declaration.unit else ""
    low, high = declaration.low, declaration.high
    if math.isinf(high):
        if low == 0.0:
            return f"must be {'zero or more' if declaration.closed else 'positive'}, and finite"
        if math.isinf(low):
            return "must be finite"
        return f"must be {'at least' if declaration.closed else 'more than'} {low:g}{unit}, and finite"
    return f"must lie between {low:g} and {high:g}{unit}"


def _count(entry: FileEntry, declaration: Declaration) -> int:
    si, _ = parse_uncertain(entry.value, "", entry.place)
    low, high = declaration.low, declaration.high
    if not low <= si <= high or si != round(si):
        shown = quoted(str(entry.value))
        raise InputError(f"{entry.place}: {shown} must be a whole number from {low:g} to {high:g}")
    return int(si)


def _class_as_written(text: str) -> str:
    """The tolerance class that the decimals of a bare value show."""
    if not text.rstrip().endswith("mm"):
        return "X.X"
    decimals = len(text.partition(".")[2].rstrip(" m"))
    return ("X", "X.X", "X.XX")[min(decimals, 2)]
