"""The friction experiments run for the command: simulated, written as tables, drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from workbench.options import Run
from workbench.simulation_inputs import friction_of, tip_dimensions


class Job:
    """One run of the command: where it writes, and what it has written."""

    def __init__(self, run: Run, folder: Path, models: tuple[str, ...], forms: tuple[str, ...], figures: bool) -> None:
        self.run, self.folder, self.models, self.forms, self.figures = run, folder, models, forms, figures
        self.written: list[Path] = []
        self.advance: Callable[[], None] = lambda: None

    def run_one(self, name: str, mass: float) -> dict[str, Any]:
        steps: dict[str, Callable[[float], dict[str, Any]]] = {
            "tip": self.tip,
            "presliding": self.presliding,
            "hysteresis": self.hysteresis,
            "stick-slip": self.stick_slip,
            "passivity": self.passivity,
        }
        return steps[name](mass)

    def tip(self, mass: float) -> dict[str, Any]:
        from sim.experiments.tip import PHASES, STROKES, tip_ellipse

        spacing, height = tip_dimensions(self.run)
        results = {
            stroke: {phase: tip_ellipse(spacing, height, size, lag) for phase, lag in PHASES.items()}
            for stroke, size in STROKES.items()
        }
        self.advance()
        for stroke, phases in results.items():
            for phase, path in phases.items():
                columns = {"time [s]": path.time, "tip_x [m]": path.x, "tip_y [m]": path.y}
                self.write(f"tip_{stroke}_{phase.replace('/', '_over_')}", columns)
        if self.figures:
            from workbench.simulation_figures import draw_tip

            self.written += draw_tip(self.folder, results)
        return {
            stroke: {phase: quantities(path.features()) for phase, path in phases.items()}
            for stroke, phases in results.items()
        }

    def presliding(self, mass: float) -> dict[str, Any]:
        from sim.experiments.presliding import presliding
        from workbench.simulation_data import table_of

        results = self._each(lambda model: presliding(friction_of(self.run), model, mass))
        for model, result in results.items():
            self.write(f"presliding_{model}", table_of(result.simulation, "drive_force"))
        if self.figures:
            from workbench.simulation_figures import draw_presliding

            self.written += draw_presliding(self.folder, results)
        return {model: quantities(result.features()) for model, result in results.items()}

    def hysteresis(self, mass: float) -> dict[str, Any]:
        from sim.experiments.hysteresis import CASES, hysteresis
        from workbench.simulation_data import table_of

        results = self._each(lambda model: {case: hysteresis(friction_of(self.run), model, case) for case in CASES})
        for model, cases in results.items():
            for case, result in cases.items():
                columns = table_of(result.simulation, "acceleration", rows=2001)
                columns["acceleration [m/s^2]"] = columns.pop("acceleration [N]")
                del columns["kinetic [J]"]
                self.write(f"hysteresis_{model}_{case}", columns)
        if self.figures:
            from workbench.simulation_figures import draw_hysteresis

            self.written += draw_hysteresis(self.folder, results)
        return {
            model: {case: quantities(result.features()) for case, result in cases.items()}
            for model, cases in results.items()
        }

    def stick_slip(self, mass: float) -> dict[str, Any]:
        from sim.experiments.stick_slip import PULL, SHOWN, stick_slip
        from workbench.simulation_data import table_of

        results = self._each(lambda model: stick_slip(friction_of(self.run), model, mass))
        for model, result in results.items():
            columns = table_of(result.simulation, "spring_force", SHOWN)
            columns["pull_position [m]"] = PULL * columns["time [s]"]
            self.write(f"stick-slip_{model}", columns)
        if self.figures:
            from workbench.simulation_figures import draw_stick_slip

            self.written += draw_stick_slip(self.folder, results)
        return {model: quantities(result.features()) for model, result in results.items()}

    def passivity(self, mass: float) -> dict[str, Any]:
        from sim.experiments.passivity import MOTIONS, audit, passive_below
        from workbench.simulation_data import table_of

        friction = friction_of(self.run)
        self.run.say(f"lugre is passive at any stretch below 4 Fc/a1 = {passive_below(friction) * 1e3:.2f} mm/s")
        results = self._each(lambda model: {motion: audit(friction, model, motion) for motion in MOTIONS})
        for model, motions in results.items():
            for motion, result in motions.items():
                columns = table_of(result.simulation, "acceleration", rows=2001)
                del columns["acceleration [N]"], columns["kinetic [J]"]
                self.write(f"passivity_{model}_{motion}", columns)
        if self.figures:
            from workbench.simulation_figures import draw_passivity

            self.written += draw_passivity(self.folder, results)
        return {
            model: {motion: quantities(result.features()) for motion, result in motions.items()}
            for model, motions in results.items()
        }

    def _each(self, simulated: Callable[[str], Any]) -> dict[str, Any]:
        """What `simulated` gives for every model."""
        results = {}
        for model in self.models:
            results[model] = simulated(model)
            self.advance()
        return results

    def write(self, name: str, columns: dict[str, Any]) -> None:
        """Write a table in the forms wanted."""
        from workbench.simulation_data import write_table

        if self.forms:
            self.written += write_table(self.folder / name, columns, self.forms)


def quantities(features: Mapping[str, tuple[float, str] | None]) -> dict[str, Any]:
    """Features as JSON quantities; none stays none."""
    return {name: None if found is None else {"value": found[0], "unit": found[1]} for name, found in features.items()}


def features_document(studies: Mapping[str, Any]) -> dict[str, Any]:
    """What is printed of the stage's studies: their features by name."""
    return {name: quantities(study.features()) for name, study in studies.items()}
