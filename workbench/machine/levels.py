"""The study of the levels of Table 1 as rows of tables and as a JSON document."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from designcalc.checks.analysis.report import shown
from stagecad.parameters.units import as_json, format_quantity, to_si

if TYPE_CHECKING:
    from designcalc.optimisation.reached_levels import Levels


def level_text(levels: Levels, name: str, value: float | None) -> str:
    """A level with its unit; a dash for none."""
    unit = levels.units[name]
    return "-" if value is None else format_quantity(to_si(value, unit), unit, 3)


def level_rows(levels: Levels) -> tuple[list[str], list[list[str]]]:
    """Headings and rows: each requirement of Table 1, as required, by itself, together, and with one kept."""
    headings = ["requirement", "Table 1", "by itself"]
    headings += [f"{one.kept} kept" if one.kept else "all together" for one in levels.together]
    rows = []
    for name, required in levels.required.items():
        values = [required, levels.alone.get(name), *(one.levels.get(name) for one in levels.together)]
        rows.append([name, *(level_text(levels, name, value) for value in values)])
    return headings, rows


def price_rows(levels: Levels) -> list[list[str]]:
    """Rows: requirement with its value, a check that fails with it, value and limit of the check."""
    return [
        [
            f"{one.requirement} {level_text(levels, one.requirement, levels.required[one.requirement])}",
            one.check,
            "-" if one.value is None else shown(one.value, one.unit),
            "-" if one.limit is None else shown(one.limit, one.unit),
        ]
        for one in levels.prices
    ]


def never_met(levels: Levels) -> list[str]:
    """Lines: checks that pass at no level."""
    return [f"{name}: {check}" for name, checks in levels.never.items() for check in checks]


def levels_document(levels: Levels) -> dict[str, Any]:
    """The study as a JSON document."""

    def quantities(values: Mapping[str, float]) -> dict[str, Any]:
        return {name: as_json(to_si(value, levels.units[name]), levels.units[name]) for name, value in values.items()}

    return {
        "required": quantities(levels.required),
        "alone": quantities(levels.alone),
        "together": [{"kept": one.kept or None, "levels": quantities(one.levels)} for one in levels.together],
        "never": levels.never,
        "prices": [asdict(one) for one in levels.prices],
        "fronts": [{"names": list(names), "points": points} for names, points in levels.fronts.items()],
        "evaluations": levels.evaluations,
    }
