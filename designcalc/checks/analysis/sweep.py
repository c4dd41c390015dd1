"""Margins over the values of one parameter, and over a grid of two."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from designcalc.checks.analysis.masses_over_values import masses_over
from designcalc.checks.check import Check
from designcalc.checks.run import run_checks
from stagecad.parameters.errors import InputError, require
from stagecad.parameters.mass_properties import Masses
from stagecad.parameters.units import as_json, from_si, parse_quantity, to_si

if TYPE_CHECKING:
    from stagecad.parameters.design import Design


DEFAULT_POINTS, MOST_POINTS = 11, 10_000


@dataclass(frozen=True)
class Range:
    """A key and its values, in the unit of its attribute."""

    key: str
    unit: str
    values: tuple[float, ...]

    @property
    def si_unit(self) -> str:
        return {"mm": "m", "deg": "rad"}.get(self.unit, self.unit)

    def override(self, value: float) -> str:
        """`KEY=VALUE` as `--set` takes it."""
        return f"{self.key}={value!r} {self.unit}".rstrip()


@dataclass(frozen=True)
class Point:
    """One value of a sweep, or one combination of values."""

    values: tuple[float, ...]  # SI, one of each range
    checks: tuple[Check, ...]
    refused: str = ""  # why the design is refused with these values; then there are no checks

    @property
    def failing(self) -> list[str]:
        """Names of the checks that do not pass."""
        return [check.name for check in self.checks if check.verdict == "fails"]


def read_range(text: str, design: Design) -> Range:
    """Read `KEY=LOW:HIGH[:N]`, N at least 2 (11 when left out)."""
    key, equals, rest = (part.strip() for part in text.partition("="))
    # Quotation marks left by a script that bypasses the shell are ignored.
    parts = [part.strip().strip("\"'").strip() for part in rest.split(":")]
    if not equals or len(parts) not in (2, 3) or not all(parts):
        raise InputError(f"--sweep '{text}': write KEY=LOW:HIGH or KEY=LOW:HIGH:N, like stage.thickness=8mm:20mm:13")
    try:
        entry = design.entry(key)
    except InputError as error:
        raise InputError(f"--sweep '{text}': {error}") from None
    if isinstance(entry.value, str | bool):
        raise InputError(f"--sweep '{text}': {key} = '{entry.text}' is not a number")
    low, high = (from_si(parse_quantity(part, entry.unit, f"--sweep {key}"), entry.unit) for part in parts[:2])
    try:
        count = int(parts[2]) if len(parts) == 3 else DEFAULT_POINTS
    except ValueError:
        count = 0
    require(2 <= count <= 10000, f"--sweep '{text}': the number of points must be a whole number from 2 to 10000")
    if not np.isfinite([low, high]).all() or low == high:
        raise InputError(f"--sweep '{text}': the ends must be finite and differ")
    # Twelve digits keep 'stage.thickness=12 mm' out of 12.000000000000002.
    values = [float(f"{v:.12g}") for v in np.linspace(low, high, count)]
    if isinstance(entry.value, int):
        values = [float(v) for v in dict.fromkeys(round(v) for v in values)]
    return Range(key, entry.unit, tuple(values))


def combinations(ranges: Sequence[Range]) -> list[tuple[float, ...]]:
    """Every combination of the values, in the units of the attributes; the last range varies fastest."""
    keys = [one.key for one in ranges]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice is not None:
        raise InputError(f"--sweep {twice}: is given twice; each key has one range")
    number = math.prod(len(one.values) for one in ranges)
    if number > MOST_POINTS:
        raise InputError(f"--sweep: the ranges have {number} combinations; at most {MOST_POINTS} are allowed")
    return list(product(*(one.values for one in ranges)))


def run_points(
    ranges: Sequence[Range],
    combined: Sequence[Sequence[float]],
    load: Callable[..., Design],
    base: Design,
    masses_of: Callable[[Design], Masses] | None,
) -> list[Point]:
    """The checks at combinations of values, one of each range, that differ in the last one, which rises or falls.

    `load`: design with more overrides, `KEY=VALUE`; `masses_of` a design's own solids, or None for estimates from plain
    volumes.
    """
    points: list[Point] = []
    designs: dict[int, Design] = {}
    for place, values in enumerate(combined):
        pairs = list(zip(ranges, values, strict=True))
        words = [one.override(int(value) if isinstance(base.value(one.key), int) else value) for one, value in pairs]
        points.append(Point(tuple(to_si(value, one.unit) for one, value in pairs), ()))
        try:
            designs[place] = load(*words)
        except InputError as error:
            points[place] = replace(points[place], refused=str(error))
    places = list(designs)
    masses: Sequence[Masses | str | None] = [None] * len(places)
    if masses_of is not None:
        whole = isinstance(base.value(ranges[-1].key), int)
        last = [combined[place][-1] for place in places]
        masses = masses_over(last, lambda number: masses_of(designs[places[number]]), interpolate=not whole)
    for place, found in zip(places, masses, strict=True):
        if isinstance(found, str):
            points[place] = replace(points[place], refused=found)
        else:
            points[place] = replace(points[place], checks=tuple(run_checks(designs[place], found)))
    return points


def table(swept: Range, points: Sequence[Point]) -> dict[str, Any]:
    """The sweep as a JSON document: values, and for each check its value, margin and verdict (null where refused)."""
    return {
        "key": swept.key,
        "values": [as_json(point.values[0], swept.si_unit) for point in points],
        "refused": [point.refused or None for point in points],
        "checks": _rows(points),
    }


def grid_table(ranges: Sequence[Range], points: Sequence[Point]) -> dict[str, Any]:
    """The grid as a JSON document: values of each point, and for each check its value, margin and verdict by point."""
    return {
        "keys": [one.key for one in ranges],
        "points": [
            {
                "values": [as_json(value, one.si_unit) for value, one in zip(point.values, ranges, strict=True)],
                "failing": point.failing if point.checks else None,
                "refused": point.refused or None,
            }
            for point in points
        ],
        "checks": _rows(points),
    }


def _rows(points: Sequence[Point]) -> dict[str, Any]:
    """Unit, values, margins and verdicts of each check at all points; None where the design is refused."""
    by_name = [{check.name: check for check in point.checks} for point in points]
    rows: dict[str, Any] = {}
    for name in dict.fromkeys(name for checks in by_name for name in checks):
        found = [checks.get(name) for checks in by_name]
        rows[name] = {"unit": next(check.unit for check in found if check is not None)}
        for what in ("value", "margin", "verdict"):
            rows[name][what] = [None if check is None else getattr(check, what) for check in found]
    return rows


def changing_checks(points: Sequence[Point], least: float = 1e-3) -> list[str]:
    """Names of the checks whose margin changes over the sweep by more than `least`.

    Those whose verdict changes come first, then those with the largest change relative to their size.
    """
    margins: dict[str, list[float]] = {}
    verdicts: dict[str, set[str]] = {}
    for point in points:
        for check in point.checks:
            if check.margin is not None:
                margins.setdefault(check.name, []).append(check.margin)
                verdicts.setdefault(check.name, set()).add(check.verdict)
    width = {name: max(m) - min(m) for name, m in margins.items()}
    size = {name: width[name] / (1 + max(abs(v) for v in m)) for name, m in margins.items()}
    kept = [name for name in margins if width[name] > least]
    return sorted(kept, key=lambda name: (-len(verdicts[name]), -size[name]))
