"""The results of `stagecad make` as tasks: what each needs, and what makes it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drawings.artefacts.machine_pictures import stored_picture
from drawings.artefacts.sheets import PICTURES, PROCEDURE, build_sheets
from drawings.artefacts.tasks import slowest_first
from stagecad.friction_stage.assembly.assemble import assemble
from stagecad.friction_stage.assembly.machine import Machine
from stagecad.parameters.mass_properties import BodyMasses
from stagecad.solids.artefacts.part import BuiltPart, build_part, kernel_errors
from stagecad.solids.artefacts.store import Artefact, ArtefactStore
from stagecad.solids.assembly.built_assembly import build_assembly
from stagecad.solids.assembly.interference import stored_interferences
from stagecad.solids.assembly.pictures import assembly_pictures, part_pictures
from stagecad.solids.modelling.kernel import load_kernel
from stagecad.solids.modelling.registry import ASSEMBLY, MADE, part_names
from workbench.machine.artefacts import procedure_values, stored_values
from workbench.making.stored_results import (
    COMPILED_BY,
    SIMULATED,
    check_figure,
    check_files,
    figures_of,
    simulation,
    stored_checks,
)
from workbench.report.reduced_sheet import reduced_sheet

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from workbench.operations.design import Design as StatedDesign

PART, SHAPES, CONTACTS, VIEW, SHEET, RENDERING, FIGURE, CHECKS, CHECK_FILES, VALUES, SIMULATION = (
    "part",
    "assembly",
    "interference",
    "picture of the machine:",
    "sheet of",
    "rendering of",
    "figure:",
    "checks",
    "files of the checks",
    "values of the procedure",
    "simulation:",
)
"""Kinds of task; the name of what is made follows."""
KINDS = (PART, SHAPES, CONTACTS, VIEW, SHEET, RENDERING, FIGURE, CHECKS, CHECK_FILES, VALUES, SIMULATION)


def needs_kernel(task: str) -> bool:
    """Whether a task needs the CAD kernel; the sheets of the machine need only its pictures."""
    if task.startswith(SHEET):
        return task.removeprefix(SHEET).strip() not in PICTURES
    return task.startswith((PART, SHAPES, CONTACTS, VIEW))


class _AbsentError(Exception):
    """The store does not have a result."""


class _StoreAsItIs(ArtefactStore):
    """The store without making: a result that it lacks is an error."""

    def make(self, name: str, design: Any, modules: Any, make: Any, depends: Any = ()) -> Artefact:
        entry = self.find(name, design, modules, depends)
        if entry is None:
            raise _AbsentError(name)
        return entry


@dataclass(frozen=True)
class Making:
    """Description of what is made, sent to the processes.

    Attributes:
        folder: of the store.
        design: the design.
        drawn: the same with the manual changes of its sheets.
        source: text and overrides that the design was read from.
        simulations: whether the friction experiments are run.
    """

    folder: Path
    design: Design
    drawn: Design
    source: StatedDesign
    simulations: bool

    @cached_property
    def tasks(self) -> dict[str, tuple[str, ...]]:
        """Each task with those that it needs, the long ones first."""
        names = slowest_first(part_names(self.design))
        parts = tuple(f"{PART} {name}" for name in names)
        machine = (*parts, SHAPES)
        views = tuple(dict.fromkeys(f"{VIEW} {name}" for shown in PICTURES.values() for name in shown))
        tasks: dict[str, tuple[str, ...]] = dict.fromkeys(parts, ())
        tasks |= {SHAPES: parts, CONTACTS: parts}
        if self.simulations:
            for name in sorted(SIMULATED, key=lambda one: one in COMPILED_BY):
                before = COMPILED_BY.get(name)
                tasks[f"{SIMULATION} {name}"] = (f"{SIMULATION} {before}",) if before else ()
        tasks |= dict.fromkeys(views, parts)
        for subject in slowest_first((*(name for name in names if name in MADE), *PICTURES)):
            needed = (*machine, *(f"{VIEW} {name}" for name in PICTURES.get(subject, ())))
            own = (*needed, VALUES) if subject == PROCEDURE else needed
            tasks[f"{SHEET} {subject}"] = own if subject in PICTURES else (f"{PART} {subject}",)
        tasks |= {f"{RENDERING} {ASSEMBLY}": machine, CHECKS: machine, VALUES: machine}
        figures = tuple(f"{FIGURE} {title}" for title in figures_of(self.design))
        tasks |= dict.fromkeys(figures, machine)
        if self.source.check_files:
            del tasks[CHECKS]
        else:
            tasks[CHECK_FILES] = (CHECKS, *figures)
        return tasks | {f"{RENDERING} {name}": (f"{PART} {name}",) for name in names}

    @cached_property
    def parts(self) -> dict[str, BuiltPart]:
        """The parts from the store."""
        store = ArtefactStore(self.folder)
        return {name: build_part(store, name, self.design) for name in part_names(self.design)}

    @cached_property
    def machine(self) -> Machine:
        """Parts and assembly from the store."""
        return Machine(self.design, self.parts, build_assembly(ArtefactStore(self.folder), self.parts, self.design))

    def run(self, task: str, exact: bool = True) -> None:
        """Make the result of a task, in this process.

        Args:
            task: of `tasks`.
            exact: method of hidden-line removal (`drawings.views.projection.hidden_lines`).
        """
        if needs_kernel(task):
            load_kernel()
        self._make(ArtefactStore(self.folder), task, exact)

    def has(self, task: str) -> bool:
        """Whether the store has the result of a task."""
        try:
            self._make(_StoreAsItIs(self.folder), task, exact=True)
        except _AbsentError:
            return False
        return True

    def _make(self, store: ArtefactStore, task: str, exact: bool) -> None:
        kind, name = next((kind, task.removeprefix(kind).strip()) for kind in _MAKERS if task.startswith(kind))
        _MAKERS[kind](self, store, name, exact)

    @property
    def masses(self) -> BodyMasses:
        return BodyMasses(self.machine.moving_body, self.machine.masses["tip"])


def _part(making: Making, store: ArtefactStore, name: str, exact: bool) -> None:
    build_part(store, name, making.design)


def _assembly(making: Making, store: ArtefactStore, name: str, exact: bool) -> None:
    with kernel_errors(ASSEMBLY, making.design):
        build_assembly(store, making.parts, making.design)


def _interferences(making: Making, store: ArtefactStore, name: str, exact: bool) -> None:
    stored_interferences(store, making.parts, making.design)


def _view(making: Making, store: ArtefactStore, name: str, exact: bool) -> None:
    parts = making.parts
    stored_picture(store, name, assemble(parts, making.drawn), parts, making.drawn, exact=exact)


def _sheet(making: Making, store: ArtefactStore, subject: str, exact: bool) -> None:
    for sheet in build_sheets(store, subject, making.drawn, procedure_values, exact=exact):
        name = f"{sheet.name}.png"
        reduced_sheet(store, making.design, sheet.artefact.path(name), sheet.artefact.hashes[name])


def _rendering(making: Making, store: ArtefactStore, name: str, exact: bool) -> None:
    if name == ASSEMBLY:
        assembly_pictures(store, making.machine)
    else:
        part_pictures(store, build_part(store, name, making.design), making.design)


def _figure(making: Making, store: ArtefactStore, title: str, exact: bool) -> None:
    check_figure(store, making.design, making.masses, title)


def _checks(making: Making, store: ArtefactStore, name: str, exact: bool) -> None:
    stored_checks(store, making.source, making.design, making.masses)


def _check_files(making: Making, store: ArtefactStore, name: str, exact: bool) -> None:
    check_files(store, making.source, making.design, making.masses)


def _values(making: Making, store: ArtefactStore, name: str, exact: bool) -> None:
    stored_values(store, making.design, making.masses)


def _simulation(making: Making, store: ArtefactStore, name: str, exact: bool) -> None:
    simulation(store, making.design, name)


_MAKERS: Mapping[str, Callable[[Making, ArtefactStore, str, bool], None]] = {
    PART: _part,
    SHAPES: _assembly,
    CONTACTS: _interferences,
    VIEW: _view,
    SHEET: _sheet,
    RENDERING: _rendering,
    FIGURE: _figure,
    CHECKS: _checks,
    CHECK_FILES: _check_files,
    VALUES: _values,
    SIMULATION: _simulation,
}
