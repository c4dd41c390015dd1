"""Entries: a key of a parameter file as written, and a key of a design with its value."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


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
