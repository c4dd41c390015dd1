"""Physical range of each number of the parameter file, with its reason: beyond it a value is a slip.

In `ranges.csv` the first pattern that a key matches counts, else its unit; the bounds of its declaration hold besides.
Ranges of single keys stand before those of tables. What fits together within the ranges is a matter of the rules.
"""

import csv
import math
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path

from stagecad.friction_stage.parameters import parts, physics
from stagecad.parameters.project_tables import ROW, Kind
from stagecad.parameters.schema import Declaration, declarations, mm, text
from stagecad.parameters.threads import threads

_Range = tuple[str, float, float, str]
"""Pattern of the key, least and greatest value, and reason."""


@cache
def _ranges() -> tuple[list[_Range], list[_Range], dict[str, tuple[float, str]]]:
    """Ranges of lengths, of other numbers, and upper bounds with their reasons by unit."""
    rows = list(csv.DictReader(Path(__file__).with_suffix(".csv").read_text("utf-8").splitlines()))
    of_keys: dict[bool, list[_Range]] = {True: [], False: []}
    for row in (row for row in rows if row["key"]):
        of_keys[row["unit"] == "mm"].append((row["key"], float(row["low"]), float(row["high"]), row["reason"]))
    return of_keys[True], of_keys[False], {r["unit"]: (float(r["high"]), r["reason"]) for r in rows if not r["key"]}


OTHERWISE = (1e15, "no quantity of the machine is larger")
"""Upper bound of a number of another unit."""


@cache
def with_range(key: str, declaration: Declaration) -> Declaration:
    """`declaration` of `key` with the bounds and the reason of its physical range."""
    if declaration.kind != "number":
        return declaration
    lengths, numbers, by_unit = _ranges()
    ranges = lengths if declaration.unit == "mm" else numbers
    found = next(((low, high, why) for pattern, low, high, why in ranges if fnmatchcase(key, pattern)), None)
    if found is None and math.isinf(declaration.high):
        found = (declaration.low, *by_unit.get(declaration.unit, OTHERWISE))
    if found is None:
        return declaration
    low, high, why = found
    # Zero stays where the declaration permits it: no coating, no chamfer.
    low = declaration.low if declaration.closed and declaration.low == 0.0 else max(low, declaration.low)
    closed = declaration.closed or low > declaration.low
    return replace(declaration, low=low, high=min(high, declaration.high), closed=closed, why=why)


@dataclass
class _Thread:
    tap_drill: float = mm("of the thread")
    pitch: float = mm("of the thread")
    designation: str = text("of a thread of one's own")
    major: float = mm("diameter of a thread of one's own")


@cache
def kinds() -> dict[str, Kind]:
    """The kinds of table by name."""

    def of(table: type, slots: tuple[str, ...], optional: tuple[str, ...] = ()) -> Kind:
        columns = {name: one for name, one in declarations(table).items() if name != ROW}
        free = (name for name, one in columns.items() if one.computed or one.default is not None)
        return Kind(columns, slots, (*optional, *free))

    screws = tuple(f"screws.{name}" for name in ("way", "clamp_long", "clamp_short", "bar"))
    ceramic = ("hysteresis", "strain_limit", "creep", "damping_ratio")
    return {
        "piezos": of(parts.Piezo, ("piezo",), ceramic),
        "screws": of(parts.Screw, screws, ("torque", "nut_factor")),
        "set_screws": of(parts.SetScrew, ("set_screw",)),
        "springs": of(parts.Spring, ("spring",)),
        "threads": Kind(declarations(_Thread), optional=("designation", "major"), names=tuple(threads())),
        "materials": of(physics.Material, ()),
    }
