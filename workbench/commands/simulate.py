"""`stagecad simulate`: the thesis's experiments, with data, features and figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from stagecad.parameters.errors import InputError, nearest
from workbench.options import Run, common_options
from workbench.simulation_inputs import friction_of, moving_mass, tip_dimensions

EXPERIMENTS = ("tip", "presliding", "hysteresis", "stick-slip")
EXTRA = ("passivity",)
"""Run only when named."""


@click.command("simulate")
@click.argument("names", nargs=-1, metavar="[tip] [presliding] [hysteresis] [stick-slip] [passivity]")
@click.option("--mass", default=None, metavar="QUANTITY|design", help="Moving mass (default: the thesis's 1 kg).")
@click.option(
    "--model", "models", multiple=True, metavar="NAME", help="Friction model; may be repeated (default: all)."
)
@click.option(
    "--format",
    "kinds",
    type=click.Choice(["csv", "parquet", "both", "none"]),
    default="csv",
    show_default=True,
    help="Form of the data.",
)
@click.option("--figures/--no-figures", default=True, help="Draw the figures.")
@common_options
def command(
    run: Run, names: tuple[str, ...], mass: str | None, models: tuple[str, ...], kinds: str, figures: bool
) -> None:
    """Simulate the thesis's experiments; data and figures go to OUT/simulate.

    Without a name: tip, presliding, hysteresis, stick-slip. `passivity` audits the energy of the friction models.
    """
    from sim.experiments.friction_models import MODELS
    from sim.simulation import SimulationError

    for name in names:
        if name not in (*EXPERIMENTS, *EXTRA):
            raise InputError(f"no experiment '{name}'{nearest(name, (*EXPERIMENTS, *EXTRA))}")
    for model in models:
        if model not in MODELS:
            raise InputError(f"--model {model}: no such friction model{nearest(model, MODELS)}")
    wanted = [name for name in (*EXPERIMENTS, *EXTRA) if name in names] if names else list(EXPERIMENTS)
    folder = run.out / "simulate"
    folder.mkdir(parents=True, exist_ok=True)
    forms = {"both": ("csv", "parquet"), "none": ()}.get(kinds, (kinds,))
    job = _Job(run, folder, tuple(m for m in MODELS if not models or m in models), forms, figures)
    kilograms = moving_mass(run, mass) if wanted != ["tip"] else 1.0
    if wanted != ["tip"]:
        run.say(f"mass {kilograms:.6g} kg")
    document: dict[str, Any] = {}
    try:
        with run.progress() as progress:
            task = progress.add_task(
                "simulations", total=sum(1 if name == "tip" else len(job.models) for name in wanted)
            )
            job.advance = lambda: progress.advance(task)
            for name in wanted:
                progress.update(task, description=name)
                document[name] = job.run_one(name, kilograms)
    except SimulationError as failure:
        raise InputError(str(failure)) from None
    for name, models_found in document.items():
        _print(run, name, models_found)
    run.say(f"{len(job.written)} files in {folder}")
    run.emit(document)


def simulate_into(
    run: Run, folder: Path, names: Sequence[str], advance: Callable[[str], None] = lambda name: None
) -> list[Path]:
    """Run the named experiments at the design's own values, all models; data and figures go to `folder`.

    `advance` is called with each name as it is done. Returns the files written.
    """
    from sim.experiments.friction_models import MODELS

    folder.mkdir(parents=True, exist_ok=True)
    job = _Job(run, folder, tuple(MODELS), ("csv",), figures=True)
    mass = moving_mass(run, None)
    for name in names:
        job.run_one(name, mass)
        advance(name)
    return job.written


class _Job:
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
                self._write(f"tip_{stroke}_{phase.replace('/', '_over_')}", columns)
        if self.figures:
            from workbench.simulation_figures import draw_tip

            self.written += draw_tip(self.folder, results)
        return {
            stroke: {phase: _quantities(path.features()) for phase, path in phases.items()}
            for stroke, phases in results.items()
        }

    def presliding(self, mass: float) -> dict[str, Any]:
        from sim.experiments.presliding import presliding
        from workbench.simulation_data import table_of

        results = self._each(lambda model: presliding(friction_of(self.run), model, mass))
        for model, result in results.items():
            self._write(f"presliding_{model}", table_of(result.simulation, "drive_force"))
        if self.figures:
            from workbench.simulation_figures import draw_presliding

            self.written += draw_presliding(self.folder, results)
        return {model: _quantities(result.features()) for model, result in results.items()}

    def hysteresis(self, mass: float) -> dict[str, Any]:
        from sim.experiments.hysteresis import CASES, hysteresis
        from workbench.simulation_data import table_of

        results = self._each(lambda model: {case: hysteresis(friction_of(self.run), model, case) for case in CASES})
        for model, cases in results.items():
            for case, result in cases.items():
                columns = table_of(result.simulation, "acceleration", rows=2001)
                columns["acceleration [m/s^2]"] = columns.pop("acceleration [N]")
                del columns["kinetic [J]"]
                self._write(f"hysteresis_{model}_{case}", columns)
        if self.figures:
            from workbench.simulation_figures import draw_hysteresis

            self.written += draw_hysteresis(self.folder, results)
        return {
            model: {case: _quantities(result.features()) for case, result in cases.items()}
            for model, cases in results.items()
        }

    def stick_slip(self, mass: float) -> dict[str, Any]:
        from sim.experiments.stick_slip import PULL, SHOWN, stick_slip
        from workbench.simulation_data import table_of

        results = self._each(lambda model: stick_slip(friction_of(self.run), model, mass))
        for model, result in results.items():
            columns = table_of(result.simulation, "spring_force", SHOWN)
            columns["pull_position [m]"] = PULL * columns["time [s]"]
            self._write(f"stick-slip_{model}", columns)
        if self.figures:
            from workbench.simulation_figures import draw_stick_slip

            self.written += draw_stick_slip(self.folder, results)
        return {model: _quantities(result.features()) for model, result in results.items()}

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
                self._write(f"passivity_{model}_{motion}", columns)
        if self.figures:
            from workbench.simulation_figures import draw_passivity

            self.written += draw_passivity(self.folder, results)
        return {
            model: {motion: _quantities(result.features()) for motion, result in motions.items()}
            for model, motions in results.items()
        }

    def _each(self, simulated: Callable[[str], Any]) -> dict[str, Any]:
        """What `simulated` gives for every model."""
        results = {}
        for model in self.models:
            results[model] = simulated(model)
            self.advance()
        return results

    def _write(self, name: str, columns: dict[str, Any]) -> None:
        from workbench.simulation_data import write_table

        if self.forms:
            self.written += write_table(self.folder / name, columns, self.forms)


def _quantities(features: Mapping[str, tuple[float, str] | None]) -> dict[str, Any]:
    return {name: None if found is None else {"value": found[0], "unit": found[1]} for name, found in features.items()}


def _print(run: Run, experiment: str, found: dict[str, Any]) -> None:
    from rich.table import Table

    if not found:
        return
    rows: list[tuple[str, dict[str, Any]]] = []
    for model, features in found.items():
        if all(feature is None or "unit" in feature for feature in features.values()):
            rows.append((model, features))
        else:
            rows += [(f"{model}  {case}", inner) for case, inner in features.items()]
    table = Table(title=experiment, title_justify="left", box=None, header_style="bold")
    table.add_column("")
    names = list(rows[0][1])
    for name in names:
        table.add_column(name.replace("_", " "), justify="right")
    for label, features in rows:
        table.add_row(label, *[_text(features[name]) for name in names])
    run.console.print(table)


def _text(feature: dict[str, Any] | None) -> str:
    if feature is None:
        return "-"
    value, unit = feature["value"], feature["unit"]
    if unit == "m" and abs(value) < 1e-3:
        return f"{value * 1e6:.3f} um"
    return f"{value:.4f} {unit}" if abs(value) >= 1e-3 or value == 0.0 else f"{value:.3e} {unit}"
