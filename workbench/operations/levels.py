"""`optimize --levels`: how far a design can meet Table 1 of the thesis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from designcalc.checks.report import shown
from designcalc.optimisation.requirement_levels import Levels, LevelStudy
from stagecad.deferred import pd
from stagecad.parameters.units import as_json, format_quantity, to_si
from workbench.figures import Figure
from workbench.figures import design as design_figures
from workbench.operations.design import Design
from workbench.operations.optimise import Search, write_study
from workbench.operations.result import Line, ProgressCallback, Result, Table, frame, plain_table, render, silent


class ReachedLevels(Result):
    """Levels of the requirements of Table 1 that designs reach: alone, together, and with one kept."""

    def __init__(self, design: Design, levels: Levels) -> None:
        self.design, self.levels = design, levels

    def _text(self, name: str, value: float | None) -> str:
        """A level with its unit; a dash for none."""
        unit = self.levels.units[name]
        return "-" if value is None else format_quantity(to_si(value, unit), unit, 3)

    def _tables(self) -> tuple[Table, list[str], Table | None]:
        """The levels reached, what is met at no level, and what the values of Table 1 make fail."""
        levels = self.levels
        kept = [f"{row.kept} kept" if row.kept else "all together" for row in levels.together]
        designs = [levels.required, levels.alone, *(row.levels for row in levels.together)]
        rows = [[name, *(self._text(name, of.get(name)) for of in designs)] for name in levels.required]
        reached = plain_table("levels that can be met", "|".join(["requirement", "Table 1", "by itself", *kept]), rows)
        never = [f"{name}: {check}" for name, checks in levels.never.items() for check in checks]
        prices = [
            [
                f"{price.requirement} {self._text(price.requirement, levels.required[price.requirement])}",
                price.check,
                shown(price.value, price.unit),
                shown(price.limit, price.unit),
            ]
            for price in levels.prices
        ]
        title, columns = "what the values of Table 1 make fail", "requirement|check|value|limit"
        return reached, never, plain_table(title, columns, prices, "requirement|check") if prices else None

    def lines(self) -> list[Line]:
        """Levels that can be met, and what the values of Table 1 make fail."""
        reached, never, prices = self._tables()
        lines: list[Line] = [reached, *(f"met at no level: {line}" for line in never)]
        lines += [prices] if prices else []
        return [*lines, f"{self.levels.evaluations} designs evaluated"]

    def report(self) -> str:
        """The study as Markdown."""
        words = dict(zip(("reached", "never", "prices"), self._tables(), strict=True))
        return render("levels.md", file=self.design.values.file, evaluations=self.levels.evaluations, **words)

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each requirement: required, alone, and each design of levels together; in the unit of the key."""
        levels = self.levels
        columns = {"required": levels.required, "alone": levels.alone}
        columns |= {f"{row.kept} kept" if row.kept else "together": dict(row.levels) for row in levels.together}
        return frame(columns)

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad optimize --levels --json`, without files."""
        levels = self.levels

        def quantities(values: Mapping[str, float]) -> dict[str, Any]:
            units = levels.units
            return {name: as_json(to_si(value, units[name]), units[name]) for name, value in values.items()}

        return {
            "required": quantities(levels.required),
            "alone": quantities(levels.alone),
            "together": [{"kept": row.kept or None, "levels": quantities(row.levels)} for row in levels.together],
            "never": levels.never,
            "prices": [asdict(price) for price in levels.prices],
            "fronts": [{"names": list(names), "points": points} for names, points in levels.fronts.items()],
            "evaluations": levels.evaluations,
        }

    interrupted = False

    def figures(self) -> dict[str, Figure]:
        """The Pareto fronts, by the name of the file."""
        return {"levels": self.plot()}

    def write_results(self, folder: Path, figures: bool, *_: Any) -> tuple[dict[str, Any], list[Line], list[str]]:
        """Write report and figure into a folder; document, remarks, figures."""
        document, drawn = write_study(self, folder, "levels.md", figures)
        return document, [], drawn

    def plot(self) -> Figure:
        """Pareto fronts of the levels of two requirements each, with the values of Table 1."""
        return design_figures.levels_figure(self.levels)

    def __repr__(self) -> str:
        return f"<ReachedLevels of '{self.design.values.file}': {self.levels.evaluations} designs evaluated>"


def reached_levels(design: Design, wanted: Search, progress: ProgressCallback = silent) -> ReachedLevels:
    """How far Table 1 can be met by a design: each requirement alone, all together, and the Pareto fronts."""
    study = LevelStudy(
        vary=lambda more: design.variations(*more),
        machine=wanted.freed(design),
        masses=wanted.masses(design),
        budget=wanted.budget,
        seed=wanted.seed,
        tell=lambda words: progress(words, 0, 0),
    )
    return ReachedLevels(design, study.levels())
