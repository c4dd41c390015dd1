"""Results of `stagecad make` without the CAD kernel, from the cache or made now: checks, their figures, simulations."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.solids.artefacts.store import Artefact, ArtefactStore, stored_object

if TYPE_CHECKING:
    from designcalc.checks.check import Check
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import Masses
    from workbench.operations.design import Design as StatedDesign

CHECKED_BY = ("workbench.operations.checks", "stagecad.parameters.load")
"""Modules that evaluate the checks and their proposals."""
COMPILED_BY = {"hysteresis": "presliding", "stick-slip": "presliding"}
"""The experiment that compiles, with an empty cache, what another uses."""


@dataclass(frozen=True)
class _WithMasses:
    """A design and the masses of its solids, so that the values read of either are recorded together."""

    design: Design
    masses: Masses


def check_figure(store: ArtefactStore, design: Design, masses: Masses, title: str) -> Artefact:
    """The figure of a title, `NAME.png`; it is drawn again only if a value that it reads has changed."""
    from workbench.figures.checks import figures_of
    from workbench.figures.plot import save

    name, draw = figures_of(design)[title]

    def make(tracked: Any, folder: Path) -> None:
        drawn = draw(tracked.design, tracked.masses)
        assert drawn is not None
        save(drawn, folder / f"{name}.png")

    return store.make(f"figure {name}", _WithMasses(design, masses), ("workbench.figures.checks",), make)


def stored_checks(store: ArtefactStore, source: StatedDesign, design: Design, masses: Masses) -> list[Check]:
    """Every check with its proposals evaluated.

    They depend on the whole parameter file, since a proposal is a change of any parameter. A project's own checks may
    depend on anything: with them all are evaluated now.
    """
    from workbench.operations.checks import evaluated_checks

    if source.check_files:
        return evaluated_checks(source, masses)

    depends = _all_parameters(source, design, masses)
    return stored_object(store, "checks", design, CHECKED_BY, lambda _: evaluated_checks(source, masses), depends)


def _all_parameters(source: StatedDesign, design: Design, masses: Masses) -> tuple[str, ...]:
    return (source.contents(), repr(design.entries), design.file, repr(masses))


def check_files(store: ArtefactStore, source: StatedDesign, design: Design, masses: Masses) -> Artefact:
    """The checks as files with their figures: what `workbench.report.checks.write_check_files` writes.

    For a design without a project's own checks (`stored_checks`).
    """
    from workbench.figures.checks import figures_of
    from workbench.report.checks import templates_digest

    figures = {title: check_figure(store, design, masses, title) for title in figures_of(design)}

    def make(_: Any, folder: Path) -> None:
        from workbench.report.checks import write_check_files

        drawn = {title: entry.path(name) for title, entry in figures.items() for name in entry.hashes}
        write_check_files(stored_checks(store, source, design, masses), design, masses, folder, drawn)

    pictures = (f"{title} {entry.content}" for title, entry in figures.items())
    depends = (*_all_parameters(source, design, masses), *pictures, templates_digest())
    return store.make("files of the checks", design, (*CHECKED_BY, "workbench.report.checks"), make, depends)


def simulation(store: ArtefactStore, design: Design, name: str) -> Artefact:
    """Data and figures of one of the friction experiments at the design's own values, all models."""

    def make(tracked: Any, folder: Path) -> None:
        from sim.experiments.friction_models import MODELS
        from workbench.figures.plot import save_figures
        from workbench.figures.simulation import experiment_figures
        from workbench.operations.simulation.simulate import moving_mass, simulate_experiment
        from workbench.operations.simulation.tables import tables_of, write_table

        results = simulate_experiment(tracked, name, tuple(MODELS), moving_mass(tracked, None))
        for file, columns in tables_of(name, results).items():
            write_table(folder / file, columns, ("csv",))
        save_figures(folder, experiment_figures(name, results))

    return store.make(f"simulation {name}", design, (__name__,), make)
