"""Margins over the values of one parameter, and over a grid of two.

Masses are those of solids at some values, between them by interpolation that solids verify. A dimension of a part moves
its faces, so that volume, centre and inertia are smooth functions of it between the values at which features meet. In
an interval the fourth-degree polynomials through the numbers of five solids give those of two others to `TOLERANCE` of
the body's size, or the interval is halved, down to a solid at every value.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from designcalc.checks.check import Check
from designcalc.checks.run import run_checks
from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError, PartError, at_place, require
from stagecad.parameters.mass_properties import BodyMasses, Masses, MassProperties, PartMasses
from stagecad.parameters.units import as_json, from_si, parse_quantity, si_of, to_si

Array = NDArray[np.float64]

SOLIDS = 7
"""Solids in each interval."""
VERIFYING = [2, 4]
"""Those that verify the polynomials through the others."""
TOLERANCE = 1e-8
"""Largest difference relative to volume, mass, size or mass times size^2: ten times that of the kernel's integrals."""


def masses_over(
    values: Sequence[float], masses_at: Callable[[int], Masses], interpolate: bool = True
) -> list[Masses | str]:
    """Masses at each of the values of a parameter, which rise or fall, by `masses_at` its number; a text where no solid
    can be made, which says why. Without `interpolate` the solids of each value are made."""
    found: dict[int, Masses | str] = {}

    def make(place: int) -> None:
        if place not in found:
            try:
                found[place] = masses_at(place)
            except (InputError, PartError) as error:
                found[place] = str(error)

    def fill(first: int, last: int) -> None:
        places = [round(place) for place in np.linspace(first, last, min(SOLIDS, last - first + 1))]
        for place in places:
            make(place)
        between = [place for place in range(first, last + 1) if place not in found]
        if between and not interpolated(places, between):
            fill(first, places[len(places) // 2])
            fill(places[len(places) // 2], last)

    def interpolated(places: list[int], between: list[int]) -> bool:
        from scipy.interpolate import BarycentricInterpolator

        x = np.array([values[place] for place in places])
        known = [one for place in places if not isinstance(one := found[place], str)]
        same = len({tuple(_bodies(one)) for one in known}) == 1
        if not same or len(known) < SOLIDS or len(np.unique(x)) < SOLIDS:
            return False
        numbers = np.array([_numbers(one) for one in known])
        others = np.delete(np.arange(SOLIDS), VERIFYING)
        estimated = BarycentricInterpolator(x[others], numbers[others])(x[VERIFYING])
        if np.any(np.abs(estimated - numbers[VERIFYING]) > TOLERANCE * _sizes(known[0])):
            return False
        rows = BarycentricInterpolator(x, numbers)([values[place] for place in between])
        found.update((place, _with_numbers(known[0], row)) for place, row in zip(between, rows, strict=True))
        return True

    if interpolate and values:
        fill(0, len(values) - 1)
    for place in range(len(values)):
        make(place)
    return [found[place] for place in range(len(values))]


def _bodies(masses: Masses) -> dict[str, MassProperties]:
    return dict(masses.parts) if isinstance(masses, PartMasses) else vars(masses)


def _numbers(masses: Masses) -> Array:
    """All numbers of all bodies (bodies, 20): volume, mass, centre, inertia, box."""
    bodies = _bodies(masses).values()
    return np.array([np.hstack([np.ravel(number) for number in vars(one).values()]) for one in bodies])


def _sizes(masses: Masses) -> Array:
    """What the differences of these numbers are relative to (bodies, 20)."""
    rows = []
    for one in _bodies(masses).values():
        size = float(np.linalg.norm(np.subtract(*one.bounding_box)))
        rows.append([one.volume, one.mass, *[size] * 3, *[one.mass * size**2] * 9, *[size] * 6])
    return np.array(rows)


def _with_numbers(masses: Masses, numbers: Array) -> Masses:
    bodies = {
        name: MassProperties(float(row[0]), float(row[1]), row[2:5], row[5:14].reshape(3, 3), row[14:].reshape(2, 3))
        for name, row in zip(_bodies(masses), numbers, strict=True)
    }
    return PartMasses(bodies) if isinstance(masses, PartMasses) else BodyMasses(**bodies)


DEFAULT_POINTS, MOST_POINTS = 11, 10_000


@dataclass(frozen=True)
class Range:
    """A key and its values, in the unit of its attribute."""

    key: str
    unit: str
    values: tuple[float, ...]

    @property
    def si_unit(self) -> str:
        return si_of(self.unit)

    def override(self, value: float) -> str:
        """`KEY=VALUE` as `--set` takes it."""
        return f"{self.key}={value!r} {self.unit}".rstrip()


@dataclass(frozen=True)
class Point:
    """One value of a sweep, or one combination of values."""

    values: tuple[float, ...]  # SI, one of each range
    checks: tuple[Check, ...]  # without texts and proposals
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
    with at_place(f"--sweep '{text}'"):
        entry = design.entry(key)
    require(not isinstance(entry.value, str | bool), f"--sweep '{text}': {key} = '{entry.text}' is not a number")
    low, high = (from_si(parse_quantity(part, entry.unit, f"--sweep {key}"), entry.unit) for part in parts[:2])
    try:
        count = int(parts[2]) if len(parts) == 3 else DEFAULT_POINTS
    except ValueError:
        count = 0
    require(2 <= count <= 10000, f"--sweep '{text}': the number of points must be a whole number from 2 to 10000")
    require(np.isfinite([low, high]).all() and low != high, f"--sweep '{text}': the ends must be finite and differ")
    # Twelve digits keep 'stage.thickness=12 mm' out of 12.000000000000002.
    values = [float(f"{v:.12g}") for v in np.linspace(low, high, count)]
    if isinstance(entry.value, int):
        values = [float(v) for v in dict.fromkeys(round(v) for v in values)]
    return Range(key, entry.unit, tuple(values))


def combinations(ranges: Sequence[Range]) -> list[tuple[float, ...]]:
    """Every combination of the values, in the units of the attributes; the last range varies fastest."""
    keys = [one.key for one in ranges]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    require(twice is None, f"--sweep {twice}: is given twice; each key has one range")
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
            points[place] = replace(points[place], checks=tuple(run_checks(designs[place], found, advise=False)))
    return points


def sweep_document(ranges: Sequence[Range], points: Sequence[Point]) -> dict[str, Any]:
    """As a JSON document: values at each point, and for each check its value, margin and verdict there (null where
    refused); of a grid the checks that fail too."""
    quantities = [
        [as_json(value, one.si_unit) for value, one in zip(point.values, ranges, strict=True)] for point in points
    ]
    refused, checks = [point.refused or None for point in points], _rows(points)
    if len(ranges) == 1:
        return {"key": ranges[0].key, "values": [one for (one,) in quantities], "refused": refused, "checks": checks}
    places = [
        {"values": values, "failing": point.failing if point.checks else None, "refused": why}
        for values, point, why in zip(quantities, points, refused, strict=True)
    ]
    return {"keys": [one.key for one in ranges], "points": places, "checks": checks}


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


def changing_checks(points: Sequence[Point]) -> list[str]:
    """Names of the checks whose margin changes over the sweep by more than a thousandth of the limit.

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
    kept = [name for name in margins if width[name] > 1e-3]
    return sorted(kept, key=lambda name: (-len(verdicts[name]), -size[name]))
