"""Entries: a key of a parameter file as written, and a key of a design with its value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class FileEntry:
    """One key of a parameter file.

    Args:
        value: as written: text, number or truth value; or a `ByRow`.
        place: file and key, for messages.
        tolerance, origin: as written; None for a bare value.
        free: range or choices in which an optimisation may change the value, as written; empty for none.
    """

    value: Any
    place: str
    tolerance: str | None = None
    origin: str | None = None
    free: str = ""


@dataclass(frozen=True)
class ByRow:
    """The value of a key that a row of a project's table has.

    Args:
        key: of the row's name.
        file: of the table.
        rows: the entry in each row by the row's name; None where its cell is empty.
        otherwise: entry of the parameter file, for an empty cell or no row.
    """

    key: str
    file: str
    rows: Mapping[str, FileEntry | None]
    otherwise: FileEntry | None


@dataclass(frozen=True)
class Entry:
    """One key of a design with its value.

    Args:
        key: `stage.length`.
        text: value with its unit, as written (or as computed).
        value: number in the unit of the attribute, or text, or truth value.
        unit: of `value`; empty for a dimensionless one.
        tolerance: class, or None.
        origin: source of the value.
        meaning: one line for people.
        std: standard deviation in `unit`, where the file gives one.
        formula: as written, where the value comes from a formula of the file.
        free: range or choices in which an optimisation may change the value, as written.
    """

    key: str
    text: str
    value: Any
    unit: str
    tolerance: str | None
    origin: str
    meaning: str
    std: float | None = None
    formula: str = ""
    free: str = ""
