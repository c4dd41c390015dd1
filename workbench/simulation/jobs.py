"""The friction experiments run for the command: simulated, written as tables, drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from workbench.options import Run
from workbench.simulation.inputs import friction_of, tip_dimensions


def simulated(
    run: Run, name: str, models: tuple[str, ...], mass: float, advance: Callable[[], None] = lambda: None
) -> dict[str, Any]:
    """Results of one experiment: by model (and case or motion); those of `tip` by stroke and phase.

    Args:
        run: whose design is simulated.
        name: of the experiment; `stage` has a module of its own.
        models: friction models.
        mass: kg.
        advance: called after each model.
    """
    if name == "tip":
        from sim.experiments.tip import PHASES, STROKES, tip_ellipse

        spacing, height = tip_dimensions(run)
        ellipses = {
            stroke: {phase: tip_ellipse(spacing, height, size, lag) for phase, lag in PHASES.items()}
            for stroke, size in STROKES.items()
        }
        advance()
        return ellipses
    friction = friction_of(run)
    results: dict[str, Any] = {}
    for model in models:
        if name == "presliding":
            from sim.experiments.presliding import presliding

            results[model] = presliding(friction, model, mass)
        elif name == "stick-slip":
            from sim.experiments.stick_slip import stick_slip

            results[model] = stick_slip(friction, model, mass)
        elif name == "hysteresis":
            from sim.experiments.hysteresis import CASES, hysteresis

            results[model] = {case: hysteresis(friction, model, case) for case in CASES}
        else:
            from sim.experiments.passivity import MOTIONS, audit

            results[model] = {motion: audit(friction, model, motion) for motion in MOTIONS}
        advance()
    return results


class Job:
    """One run of the command: where it writes, and what it has written."""

    def __init__(self, run: Run, folder: Path, models: tuple[str, ...], forms: tuple[str, ...], figures: bool) -> None:
        self.run, self.folder, self.models, self.forms, self.figures = run, folder, models, forms, figures
        self.written: list[Path] = []
        self.advance: Callable[[], None] = lambda: None

    def run_one(self, name: str, mass: float) -> dict[str, Any]:
        """Simulate an experiment, write and draw what is wanted of it; its features."""
        if name == "passivity":
            from sim.experiments.passivity import passive_below

            below = passive_below(friction_of(self.run))
            self.run.say(f"lugre is passive at any stretch below 4 Fc/a1 = {below * 1e3:.2f} mm/s")
        results = simulated(self.run, name, self.models, mass, self.advance)
        if self.forms:
            for table, columns in tables_of(name, results).items():
                self.write(table, columns)
        if self.figures:
            from workbench.simulation import figures

            draw = {
                "tip": figures.draw_tip,
                "presliding": figures.draw_presliding,
                "hysteresis": figures.draw_hysteresis,
                "stick-slip": figures.draw_stick_slip,
                "passivity": figures.draw_passivity,
            }
            self.written += draw[name](self.folder, results)
        return features_of(results)

    def write(self, name: str, columns: dict[str, Any]) -> None:
        """Write a table in the forms wanted."""
        from workbench.simulation.data import write_table

        if self.forms:
            self.written += write_table(self.folder / name, columns, self.forms)


def tables_of(name: str, results: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """The tables of an experiment, by the name of their file."""
    from workbench.simulation.data import table_of

    tables: dict[str, dict[str, Any]] = {}
    if name == "tip":
        for stroke, phases in results.items():
            for phase, path in phases.items():
                columns = {"time [s]": path.time, "tip_x [m]": path.x, "tip_y [m]": path.y}
                tables[f"tip_{stroke}_{phase.replace('/', '_over_')}"] = columns
    elif name == "presliding":
        for model, result in results.items():
            tables[f"presliding_{model}"] = table_of(result.simulation, "drive_force")
    elif name == "stick-slip":
        from sim.experiments.stick_slip import PULL, SHOWN

        for model, result in results.items():
            columns = table_of(result.simulation, "spring_force", SHOWN)
            columns["pull_position [m]"] = PULL * columns["time [s]"]
            tables[f"stick-slip_{model}"] = columns
    else:
        for model, cases in results.items():
            for case, result in cases.items():
                # The motion is imposed: what drives it is an acceleration, and no mass has a kinetic energy.
                columns = table_of(result.simulation, "acceleration", rows=2001)
                columns["acceleration [m/s^2]"] = columns.pop("acceleration [N]")
                del columns["kinetic [J]"]
                if name == "passivity":
                    del columns["acceleration [m/s^2]"]
                tables[f"{name}_{model}_{case}"] = columns
    return tables


def features_of(results: Mapping[str, Any]) -> dict[str, Any]:
    """Features of results, nested as they are, as JSON quantities."""
    return {
        name: features_of(found) if isinstance(found, Mapping) else quantities(found.features())
        for name, found in results.items()
    }


def quantities(features: Mapping[str, tuple[float, str] | None]) -> dict[str, Any]:
    """Features as JSON quantities; none stays none."""
    return {name: None if found is None else {"value": found[0], "unit": found[1]} for name, found in features.items()}


def features_document(studies: Mapping[str, Any]) -> dict[str, Any]:
    """What is printed of the stage's studies: their features by name."""
    return {name: quantities(study.features()) for name, study in studies.items()}
