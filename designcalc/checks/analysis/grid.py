"""Margins over the values of several parameters together: every combination of their values."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

from designcalc.checks.analysis.sweep import Range
from designcalc.checks.check import Check
from designcalc.checks.run import run_checks
from stagecad.parameters.errors import InputError
from stagecad.parameters.mass_properties import Masses
from stagecad.parameters.units import as_json, to_si

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

MOST_POINTS = 10_000


@dataclass(frozen=True)
class GridPoint:
    """One combination of values."""

    values: tuple[float, ...]
    """SI, one of each range"""
    checks: tuple[Check, ...]
    refused: str = ""
    """why the design is refused with these values; then there are no checks"""

    @property
    def failing(self) -> list[str]:
        """Names of the checks that do not pass."""
        return [check.name for check in self.checks if check.verdict == "fails"]


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


def run_grid_point(
    ranges: Sequence[Range],
    values: Sequence[float],
    load: Callable[..., Design],
    base: Design,
    masses_of: Callable[[Design], Masses | None],
) -> GridPoint:
    """The checks at one combination of values.

    Args:
        ranges: of the grid.
        values: one of each range.
        load: design with more overrides, `KEY=VALUE`.
        base: the unchanged design.
        masses_of: masses of a design's own solids; None estimates them from plain volumes.
    """
    si = tuple(to_si(value, one.unit) for one, value in zip(ranges, values, strict=True))
    pairs = zip(ranges, values, strict=True)
    words = [r.override(int(v) if isinstance(base.value(r.key), int) else v) for r, v in pairs]
    try:
        design = load(*words)
    except InputError as error:
        return GridPoint(si, (), str(error))
    return GridPoint(si, tuple(run_checks(design, masses_of(design))))


def grid_table(ranges: Sequence[Range], points: Sequence[GridPoint]) -> dict[str, Any]:
    """The grid as a JSON document: values of each point, and for each check its value, margin and verdict by point."""
    names = list(dict.fromkeys(check.name for point in points for check in point.checks))
    rows: dict[str, Any] = {}
    by_name = [{check.name: check for check in point.checks} for point in points]
    for name in names:
        found = [checks.get(name) for checks in by_name]
        rows[name] = {
            "unit": next(c.unit for c in found if c is not None),
            "value": [None if c is None else c.value for c in found],
            "margin": [None if c is None else c.margin for c in found],
            "verdict": [None if c is None else c.verdict for c in found],
        }
    units = [{"mm": "m", "deg": "rad"}.get(one.unit, one.unit) for one in ranges]
    return {
        "keys": [one.key for one in ranges],
        "points": [
            {
                "values": [as_json(value, unit) for value, unit in zip(point.values, units, strict=True)],
                "failing": point.failing if point.checks else None,
                "refused": point.refused or None,
            }
            for point in points
        ],
        "checks": rows,
    }
