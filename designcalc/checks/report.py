"""The checks as text: their numbers, the requirements traced to them, and the rows of the tables of the reports."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from designcalc.checks.check import Check
from designcalc.drive.suspension import Suspension
from designcalc.errors.dynamic_budget import DynamicBudget
from designcalc.errors.error_budget import Budget
from stagecad.parameters.units import as_json, format_quantity


def counted(checks: Sequence[Check]) -> str:
    """Number of checks with each verdict, `30 pass, 12 fail`."""
    words = {"passes": "pass", "fails": "fail", "out_of_range": "out of range", "undecidable": "undecidable"}
    numbers = {verdict: sum(c.verdict == verdict for c in checks) for verdict in words}
    return ", ".join(f"{n} {words[v]}" for v, n in numbers.items() if n or v in ("passes", "fails"))


def shown(value: float | None, unit: str) -> str:
    """A number of the table; a dash for none."""
    return "-" if value is None else format_quantity(value, unit, 4)


def shown_limit(check: Check) -> str:
    """The limit with its sense."""
    return "-" if check.limit is None else f"{check.sense} {shown(check.limit, check.unit)}"


def shown_margin(check: Check) -> str:
    """The margin in percent of the limit (as a distance where the limit is zero)."""
    if check.margin is None:
        return "-"
    if check.limit == 0:
        return shown(check.margin, check.unit)
    percent = 100 * check.margin
    return f"{percent:+.0f} %" if abs(percent) < 1e4 else f"{percent:+.1e} %"


def requirements(checks: Sequence[Check], stated: Iterable[str]) -> dict[str, list[Check]]:
    """Every stated requirement with the checks that apply to it."""
    return {name: [check for check in checks if check.requirement == name] for name in stated}


def corrections(checks: Sequence[Check]) -> list[Check]:
    """Checks for which the thesis is wrong or differs."""
    return [check for check in checks if check.thesis]


RANKING = (
    "Places by stiffness, smoothness, friction (which limits the resolution), repeatability and cost, added up; "
    "suspensions that are unstable or not compatible with the drive and its magnets are ranked last."
)
SUSPENSION_HEADINGS = [
    "suspension",
    "stiffness",
    "smoothness",
    "friction",
    "repeatability",
    "cost",
    "places",
    "stable",
    "fits",
    "why",
]


def suspension_rows(suspensions: Iterable[Suspension]) -> list[tuple[str, ...]]:
    """Suspensions as rows below `SUSPENSION_HEADINGS`."""
    return [_suspension_cells(one) for one in suspensions]


def _suspension_cells(c: Suspension) -> tuple[str, ...]:
    smooth, again = (
        "-" if value == math.inf else format_quantity(value, "m", 3) for value in (c.smoothness, c.repeatability)
    )
    stiff, rub = format_quantity(c.stiffness, "N/m", 3), format_quantity(c.friction, "N", 3)
    stable, fits = ("yes" if yes else "no" for yes in (c.stable, c.fits_drive))
    return c.name, stiff, smooth, rub, again, str(c.cost), f"{c.places:g}", stable, fits, c.why


def budget_cells(found: Budget) -> list[tuple[str, ...]]:
    """Contributions of a budget, the largest first, and their total."""
    rows = [
        (cause.name, cause.source, shown(abs(float(e[found.axis])), "m"), "by squares" if cause.random else "in full")
        for cause, e in found.rows
    ]
    return [*rows, ("total", "", shown(float(found.total[found.axis]), "m"), "")]


DYNAMIC_HEADINGS = ("disturbance", "source", "density at 1 Hz", "rms over the observation", "rms with drift")


def dynamic_cells(found: DynamicBudget, lowest: float) -> list[tuple[str, ...]]:
    """Disturbances of a dynamic budget, the largest above a frequency (Hz) first, and their total."""
    rows = [row for row, _ in found.largest_first(lowest)] + [found.total]
    return [
        (
            row.name,
            row.source,
            f"{1e9 * float(np.interp(1.0, found.frequency, row.density)):.3g} nm/sqrt(Hz)",
            shown(found.rms(row, lowest), "m"),
            shown(found.rms(row), "m"),
        )
        for row in rows
    ]


def dynamic_document(budgets: Sequence[DynamicBudget], lowest: float) -> dict[str, list[dict[str, object]]]:
    """Dynamic budgets for JSON: each disturbance with its rms over the observation and with drift."""
    return {
        found.name: [
            {
                "disturbance": row.name,
                "source": row.source,
                "rms": as_json(found.rms(row, lowest), "m"),
                "rms_with_drift": as_json(found.rms(row), "m"),
            }
            for row in [row for row, _ in found.largest_first(lowest)] + [found.total]
        ]
        for found in budgets
    }
