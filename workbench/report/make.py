"""`stagecad make`: its results as tasks, what each needs and what makes it, their making side by side, the report.

The processes fill the store; whoever needs a result then finds it there. A result that is there already is not made
again.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property, partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from designcalc.checks.check import Check
from designcalc.checks.report import counted as count_of_verdicts
from designcalc.checks.run import subjects_of
from drawings.draw_sheets import PICTURES, PROCEDURE, TIME_LIMIT, build_sheets, slowest_first, stored_picture
from drawings.sheets.plans import sheets_of
from stagecad.parameters.design import Design
from stagecad.parameters.errors import LostProcessError, PartError
from stagecad.parameters.machine import content
from stagecad.parameters.mass_properties import Masses
from stagecad.processes import TimeLimit, parallel_map
from stagecad.solids.artefacts.part import CRASHED, BuiltPart, build_part
from stagecad.solids.artefacts.store import Artefact, ArtefactStore, write_stored
from stagecad.solids.assembly.bill_of_materials import document as bill_document
from stagecad.solids.assembly.built_machine import BuiltMachine, assemble, build_assembly
from stagecad.solids.assembly.interference import build_interferences, clashes, stored_interferences
from stagecad.solids.assembly.pictures import assembly_pictures, build_pictures, part_pictures
from stagecad.solids.modelling.kernel import load_kernel
from stagecad.solids.modelling.part import ASSEMBLY, part_names, part_source
from workbench.figures import plot as drawing
from workbench.figures import simulation as simulation_figures
from workbench.figures.checks import figures_of
from workbench.operations.design import Design as StatedDesign
from workbench.operations.drawings import drawings, procedure_values, reduced_sheet, stored_values, with_sheet_overrides
from workbench.operations.parts import parts, with_repair
from workbench.operations.result import ProgressCallback, counted
from workbench.report.machine import templates_digest, write_check_files, write_report

COMPILED_BY = {"hysteresis": "presliding", "stick-slip": "presliding"}
"""The experiment that compiles, with an empty cache, what another uses."""


def check_figure(store: ArtefactStore, design: Design, masses: Masses, title: str) -> Artefact:
    """The figure of a title, `NAME.png`; it is drawn again only if a value that it reads has changed."""
    name, draw = figures_of(design)[title]

    def make(tracked: Any, folder: Path) -> None:
        drawing.save(draw(tracked.design, tracked.masses), folder / f"{name}.png")

    # The values read of the design and of the masses are recorded together.
    both = SimpleNamespace(design=design, masses=masses)
    return store.make(f"figure {name}", both, ("workbench.figures.checks",), make)


def checked_by(design: Design) -> tuple[str, ...]:
    """Modules that evaluate the checks and their proposals; the one of the machine, with its table, states them."""
    stated = content("designcalc", design.machine, "checks").__name__
    return ("workbench.operations.checks", "stagecad.parameters.load", stated)


def stored_checks(store: ArtefactStore, source: StatedDesign, design: Design, masses: Masses) -> list[Check]:
    """Every check with its proposals evaluated.

    They depend on the whole parameter file, since a proposal is a change of any parameter. A project's own checks may
    depend on anything: with them all are evaluated now.
    """
    from workbench.operations.checks import evaluated_checks

    if source.check_files:
        return evaluated_checks(source, masses)

    depends = _all_parameters(source, design, masses)
    return store.computed("checks", design, checked_by(design), lambda _: evaluated_checks(source, masses), depends)


def _all_parameters(source: StatedDesign, design: Design, masses: Masses) -> tuple[str, ...]:
    return (source.contents(), repr(design.entries), design.file, repr(masses))


def check_files(store: ArtefactStore, source: StatedDesign, design: Design, masses: Masses) -> Artefact:
    """The checks as files with their figures: what `write_check_files` writes.

    For a design without a project's own checks (`stored_checks`).
    """
    figures = {title: check_figure(store, design, masses, title) for title in figures_of(design)}

    def make(_: Any, folder: Path) -> None:
        drawn = {title: entry.path(name) for title, entry in figures.items() for name in entry.hashes}
        write_check_files(stored_checks(store, source, design, masses), design, masses, folder, drawn)

    pictures = (f"{title} {entry.content}" for title, entry in figures.items())
    depends = (*_all_parameters(source, design, masses), *pictures, templates_digest())
    return store.make("files of the checks", design, (*checked_by(design), "workbench.report.machine"), make, depends)


def simulation(store: ArtefactStore, design: Design, name: str) -> Artefact:
    """Data and figures of one of the friction experiments at the design's own values, all models."""

    def make(tracked: Any, folder: Path) -> None:
        from sim.experiments.friction_models import MODELS
        from workbench.operations.simulation.simulate import moving_mass, simulate_experiment
        from workbench.operations.simulation.tables import tables_of, write_table

        results = simulate_experiment(tracked, name, tuple(MODELS), moving_mass(tracked, None))
        for file, columns in tables_of(name, results).items():
            write_table(folder / file, columns, ("csv",))
        drawing.save_figures(folder, simulation_figures.experiment_figures(name, results))

    return store.make(f"simulation {name}", design, (__name__,), make)


Reporting = Callable[..., AbstractContextManager[ProgressCallback]]
"""What gives a progress callback."""


class Kind(StrEnum):
    """Kind of a result of `stagecad make`."""

    PART = "part"
    SHAPES = "assembly"
    CONTACTS = "interference"
    VIEW = "picture of the machine:"
    SHEET = "sheet of"
    RENDERING = "rendering of"
    FIGURE = "figure:"
    CHECKS = "checks"
    CHECK_FILES = "files of the checks"
    VALUES = "values of the procedure"
    SIMULATION = "simulation:"


LONG = {Kind.PART, Kind.SHAPES, Kind.CONTACTS, Kind.VIEW, Kind.SHEET, Kind.RENDERING, Kind.SIMULATION}
"""Kinds for which processes are started; the others alone take less than their start."""
SOLIDS = {Kind.PART, Kind.SHAPES, Kind.CONTACTS, Kind.VIEW}
"""Kinds that always need the CAD kernel."""


@dataclass(frozen=True)
class Task:
    """A result that the store has or that is to be made: its kind, and the name of the part, sheet, figure, ..."""

    kind: Kind
    name: str = ""

    def __str__(self) -> str:
        return f"{self.kind} {self.name}".strip()


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
    """Description of what is made, sent to the processes."""

    folder: Path  # of the store
    design: Design  # the design
    drawn: Design  # the same with the manual changes of its sheets
    source: StatedDesign  # text and overrides that the design was read from
    simulations: bool  # whether the friction experiments are run

    @cached_property
    def tasks(self) -> dict[Task, tuple[Task, ...]]:
        """Each task with those that it needs, the long ones first."""
        names = slowest_first(part_names(self.design))
        parts = tuple(Task(Kind.PART, name) for name in names)
        shapes, values, checks = Task(Kind.SHAPES), Task(Kind.VALUES), Task(Kind.CHECKS)
        machine = (*parts, shapes)
        views = {name: Task(Kind.VIEW, name) for shown in PICTURES.values() for name in shown}
        tasks: dict[Task, tuple[Task, ...]] = dict.fromkeys(parts, ())
        tasks |= {shapes: parts, Task(Kind.CONTACTS): parts}
        if self.simulations:
            for name in sorted(subjects_of(self.design).experiments, key=lambda one: one in COMPILED_BY):
                before = COMPILED_BY.get(name)
                tasks[Task(Kind.SIMULATION, name)] = (Task(Kind.SIMULATION, before),) if before else ()
        tasks |= dict.fromkeys(views.values(), parts)
        made = [name for name in names if not part_source(name, self.design).purchased]
        for subject in slowest_first((*made, *PICTURES)):
            needed = (*machine, *(views[name] for name in PICTURES.get(subject, ())))
            own = (*needed, values) if subject == PROCEDURE else needed
            tasks[Task(Kind.SHEET, subject)] = own if subject in PICTURES else (Task(Kind.PART, subject),)
        tasks |= {Task(Kind.RENDERING, ASSEMBLY): machine, checks: machine, values: machine}
        figures = tuple(Task(Kind.FIGURE, title) for title in figures_of(self.design))
        tasks |= dict.fromkeys(figures, machine)
        if self.source.check_files:
            del tasks[checks]
        else:
            tasks[Task(Kind.CHECK_FILES)] = (checks, *figures)
        return tasks | {Task(Kind.RENDERING, name): (Task(Kind.PART, name),) for name in names}

    @cached_property
    def parts(self) -> dict[str, BuiltPart]:
        """The parts from the store."""
        store = ArtefactStore(self.folder)
        return {name: build_part(store, name, self.design) for name in part_names(self.design)}

    @cached_property
    def machine(self) -> BuiltMachine:
        """Parts and assembly from the store."""
        return BuiltMachine(
            self.design, self.parts, build_assembly(ArtefactStore(self.folder), self.parts, self.design)
        )

    def run(self, task: Task, exact: bool = True) -> None:
        """Make the result of a task, in this process."""
        # The sheets of the machine need only its pictures.
        if task.kind in SOLIDS or (task.kind is Kind.SHEET and task.name not in PICTURES):
            load_kernel()
        self._make(ArtefactStore(self.folder), task, exact)

    def _make(self, store: ArtefactStore, task: Task, exact: bool) -> None:
        name, design = task.name, self.design
        match task.kind:
            case Kind.PART:
                build_part(store, name, design)
            case Kind.SHAPES:
                build_assembly(store, self.parts, design)
            case Kind.CONTACTS:
                stored_interferences(store, self.parts, design)
            case Kind.VIEW:
                stored_picture(store, name, assemble(self.parts, self.drawn), self.parts, self.drawn, exact=exact)
            case Kind.SHEET:
                for sheet in build_sheets(store, name, self.drawn, procedure_values, exact=exact):
                    file = f"{sheet.name}.png"
                    reduced_sheet(store, design, sheet.artefact.path(file), sheet.artefact.hashes[file])
            case Kind.RENDERING if name == ASSEMBLY:
                assembly_pictures(store, self.machine)
            case Kind.RENDERING:
                part_pictures(store, build_part(store, name, design), design)
            case Kind.FIGURE:
                check_figure(store, design, self.masses, name)
            case Kind.CHECKS:
                stored_checks(store, self.source, design, self.masses)
            case Kind.CHECK_FILES:
                check_files(store, self.source, design, self.masses)
            case Kind.VALUES:
                stored_values(store, design, self.masses)
            case Kind.SIMULATION:
                simulation(store, design, name)

    def has(self, task: Task) -> bool:
        """Whether the store has the result of a task."""
        try:
            self._make(_StoreAsItIs(self.folder), task, True)
        except _AbsentError:
            return False
        return True

    @property
    def absent(self) -> list[Task]:
        """The tasks whose results the store lacks, and those that need one of these."""
        found: list[Task] = []
        for task, needed in self.tasks.items():
            if not set(needed).isdisjoint(found) or not self.has(task):
                found.append(task)
        return found

    def make(self, tasks: Collection[Task], advance: Callable[[Task], None] = lambda task: None) -> None:
        """Make the results of tasks side by side in one pool, since a process needs seconds to load the CAD kernel."""
        making = replace(self)  # without the solids that it has loaded, which do not pickle
        requires = {task: [other for other in self.tasks[task] if other in tasks] for task in tasks}
        limit = TimeLimit(TIME_LIMIT, fallback=partial(making.run, exact=False))
        try:
            parallel_map(making.run, list(tasks), progress=advance, limit=limit, requires=requires, isolate=True)
        except LostProcessError as error:
            lost = error.item
            if isinstance(lost, Task) and lost.kind is Kind.PART:
                raise PartError(lost.name, self.design, CRASHED) from None
            if isinstance(lost, Task) and lost.kind in (Kind.SHAPES, Kind.CONTACTS):
                raise PartError(ASSEMBLY, self.design, CRASHED) from None
            raise

    @property
    def masses(self) -> Masses:
        return self.machine.checked_masses


def make(
    design: StatedDesign, out: Path, simulations: bool, reporting: Reporting, tell: Callable[[str], None]
) -> dict[str, Any]:
    """Everything from a design, into a folder: parts, pictures, drawings, checks, simulations, report; its document.

    `reporting` gives a progress callback for each stage of the work, and `tell` is called with what each has made.
    """
    store, values = ArtefactStore(), design.values
    _fill(Making(store.folder, values, with_sheet_overrides(design), design, simulations), reporting)
    made = parts(design)
    document, changed, count = made.write_changed(out / "parts")
    tell(f"parts: {len(changed)} of {count} files written")
    machine = made.machine
    masses = machine.checked_masses
    with reporting() as report:
        pictures = with_repair(store, lambda: _pictures(store, machine, out / "pictures", report))
    with reporting() as report:
        report("interference", 0, 0)
        interferences = build_interferences(store, machine.parts, values)
    pairs, found = len(interferences), len(clashes(interferences))
    tell(f"interference: {found} clashes, {pairs} contacts, fits and near places looked at")
    with reporting() as report:
        drawn = drawings(design, (), out / "drawings", report)
    sheets = drawn.document
    tell(f"drawings: {len(sheets['changed'])} of {sheets['files']} files written, {len(drawn.hits)} lint hits")
    checks = stored_checks(store, design, values, masses)
    tell(f"checks: {count_of_verdicts(checks)}")
    figures = with_repair(store, lambda: _checks(store, design, checks, masses, out / "checks"))
    simulated: list[Path] = []
    if simulations:
        with reporting() as steps:
            files, written = with_repair(store, lambda: _simulations(store, values, out / "simulate", steps))
        simulated = [file for file in files if file.suffix == ".png"]
        tell(f"simulations: {written} files written" if written else "simulations: unchanged")
    bill = machine.bill_of_materials
    results = {
        "parts": document,
        "pictures": pictures,
        "checks": checks,
        "check_figures": figures,
        "simulation_figures": simulated,
        "bill": bill_document(bill),
        "interferences": interferences,
        "procedure": sheets_of(values).procedure(values, bill, stored_values(store, values, masses)),
        "drawings": sheets,
    }
    page = write_report(values, out, results)
    tell(f"report: {page}")
    stated = {"drawings": sheets["sheets"], "checks": [check.as_json() for check in checks], "report": str(page)}
    return {**document, **stated}


def _fill(making: Making, reporting: Reporting) -> None:
    """Make what the store lacks, side by side. The CAD kernel cannot be interrupted within a step: a note on a terminal
    states so before the kernel begins."""
    tasks = making.absent
    if any(task.kind in LONG for task in tasks):
        note = "Ctrl-C ends it after the CAD kernel's step, which may take some seconds"
        with reporting(note=note) as report:
            report("results", 0, len(tasks))
            making.make(tasks, counted(report, "", len(tasks)))


def _pictures(store: ArtefactStore, machine: BuiltMachine, folder: Path, report: ProgressCallback) -> dict[str, Path]:
    """Pictures of the parts and of the assembly, by name."""
    files = build_pictures(store, machine, counted(report, "", len(machine.parts) + 1))
    write_stored(folder, files)
    return {Path(name).stem: folder / name for name in files}


def _checks(
    store: ArtefactStore, stated: StatedDesign, checks: Sequence[Check], masses: Masses, folder: Path
) -> dict[str, Path]:
    """Write figures of the checks and the checks as files, those of a project's own without the cache; the figures."""
    design = stated.values
    entries = {title: check_figure(store, design, masses, title) for title in figures_of(design)}
    figures = {title: path for title, entry in entries.items() for path in _write(folder, [entry])[0]}
    if stated.check_files:
        write_check_files(checks, design, masses, folder, figures)
    else:
        _write(folder, [check_files(store, stated, design, masses)])
    return figures


def _simulations(
    store: ArtefactStore, design: Design, folder: Path, report: ProgressCallback
) -> tuple[list[Path], int]:
    """Data and figures of the thesis's experiments; the files, and the number of those written."""
    names, entries = subjects_of(design).experiments, []
    advance = counted(report, "", len(names))
    for name in names:
        entries.append(simulation(store, design, name))
        advance(name)
    return _write(folder, entries)


def _write(folder: Path, entries: Iterable[Artefact]) -> tuple[list[Path], int]:
    """Copy the files of artefacts into a folder; their paths, and the number of those written."""
    files = {name: entry for entry in entries for name in entry.hashes}
    return [folder / name for name in files], len(write_stored(folder, files))
