"""The machine as a typed, frozen `Design`.

Units: an attribute of a table is in millimetres (or degrees) where it is geometry, and in SI otherwise; each table
states which. Geometry code reads attributes (`design.stage.length`, mm); calculators and simulation call
`design.si(key)`, which is SI for every key. Only this module converts between the two.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from stagecad.parameters.errors import InputError
from stagecad.parameters.iso286 import deviations, is_class
from stagecad.parameters.machine import Machine
from stagecad.parameters.schema import Entry, nearest_key
from stagecad.parameters.threads import Thread, thread


class Materials(dict[str, Any]):
    """Tables of the materials by name; not to be changed."""

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(tuple(self.items()))


@dataclass(frozen=True)
class Design:
    """Every number of a machine: the tables of the parameter file as attributes, and every entry by its key."""

    machine: Machine = field(repr=False, compare=False)
    materials: Materials
    entries: tuple[Entry, ...] = field(repr=False)
    file: str = "thesis.toml"  # name of the file it was read from
    overrides: tuple[str, ...] = ()  # keys replaced by `--set`
    sheets: tuple[tuple[str, str], ...] = ()  # manual changes of drawing sheets by the sheet's name, as JSON texts
    earlier: tuple[tuple[str, str], ...] = ()
    """Keys that differ from an earlier issue of the design, with their values then (`since`)."""

    own: tuple[tuple[str, Any], ...] = ()  # tables of parts of the user's own by name
    source: Any = field(default=None, repr=False, compare=False)
    """Entries that it was made from (`stagecad.parameters.variations.Source`)."""

    def __getattr__(self, name: str) -> Any:
        # Only for what is no attribute otherwise; the tables of a machine's own design are.
        if not name.startswith("_"):
            for known, table in self.__dict__.get("own", ()):
                if known == name:
                    return table
        raise AttributeError(f"the design has no table '{name}'")

    @cached_property
    def _by_key(self) -> dict[str, Entry]:
        found = {entry.key: entry for entry in self.entries}
        # A part of the user's own with the key of a packaged one stands in its place.
        for key, table in self.machine.declaration.tables.items() if self.machine.declaration else ():
            if key != table:
                found |= {
                    f"{key}.{name.partition('.')[2]}": one
                    for name, one in found.items()
                    if name.startswith(f"{table}.")
                }
        return found

    def entry(self, key: str) -> Entry:
        """The entry of a key."""
        try:
            return self._by_key[key]
        except KeyError:
            raise InputError(f"no parameter '{key}'{nearest_key(key, self._by_key)}") from None

    def has(self, key: str) -> bool:
        """Whether there is such a key."""
        return key in self._by_key

    def thread(self, name: str) -> Thread:
        """A screw thread by its name, of the project's table or the packaged one."""
        return thread(name, self.machine.threads)

    def value(self, key: str) -> Any:
        """Value of a key in the unit of its attribute: mm or degrees for geometry, SI otherwise."""
        return self.entry(key).value

    def si(self, key: str) -> float:
        """The number of a key in SI."""
        return self.entry(key).si

    def tolerance(self, key: str) -> str | None:
        """Tolerance class of a dimension, or None."""
        return self.entry(key).tolerance

    def plus_minus(self, key: str) -> float:
        """Half the width of the tolerance interval of a dimension, mm; 0 without a class."""
        low, high = self.deviations(key)
        return (high - low) / 2

    def deviations(self, key: str) -> tuple[float, float]:
        """Lower and upper limit deviation of a dimension by its tolerance class, mm; 0 without a class."""
        tolerance = self.tolerance(key) or ""
        if is_class(tolerance):
            return deviations(float(self.value(key)), tolerance)
        name = {"X": "tolerance_x", "X.X": "tolerance_x_x", "X.XX": "tolerance_x_xx"}.get(tolerance)
        plus_minus = self.value(f"drawing.{name}") if name else 0.0
        return -plus_minus, plus_minus

    def sheet_settings(self, sheet: str) -> str:
        """Manual changes of a drawing sheet as a JSON text; empty for none (`drawings.sheets.overrides`)."""
        return dict(self.sheets).get(sheet, "")

    def is_overridden(self, key: str) -> bool:
        """Whether `--set` replaced the value of a key; entries of the title block do not count."""
        return key in self.overrides and not key.startswith("drawing.")

    def earlier_text(self, key: str) -> str | None:
        """Value of a key in the earlier issue, as written; None if it is the same, or without an earlier issue."""
        return dict(self.earlier).get(key)

    def since(self, before: Design) -> Design:
        """This design with the values of an earlier issue, for the revision table."""
        then = before._by_key
        differ = tuple(
            (entry.key, then[entry.key].text if entry.key in then else "none")
            for entry in self.entries
            if entry.key not in then
            or (then[entry.key].value, then[entry.key].tolerance) != (entry.value, entry.tolerance)
        )
        return replace(self, earlier=differ)

    def material(self, key: str) -> Any:
        """Properties of the material whose name is the value of `key` (`base.material`)."""
        return self.materials[str(self.value(key))]

    @cached_property
    def digest(self) -> str:
        """Sha256 of all values and tolerances: equal for files that differ only in their text."""
        words = [[entry.key, repr(entry.value), entry.tolerance] for entry in sorted(self.entries, key=lambda e: e.key)]
        return hashlib.sha256(json.dumps(words).encode()).hexdigest()
