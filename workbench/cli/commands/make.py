"""`stagecad make`: all results of the parameter file, and one HTML report; results with unchanged inputs are kept."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import click

from designcalc.checks.analysis.report import counted
from designcalc.checks.check import Check
from designcalc.checks.run import subjects_of
from drawings.sheets.plans import sheets_of
from stagecad.parameters.mass_properties import Masses
from stagecad.solids.artefacts.outputs import write_stored
from stagecad.solids.artefacts.store import Artefact, ArtefactStore
from stagecad.solids.assembly.bill_of_materials import document as bill_document
from stagecad.solids.assembly.built_machine import BuiltMachine
from stagecad.solids.assembly.interference import build_interferences, clashes
from stagecad.solids.assembly.pictures import build_pictures
from workbench.cli.commands.check import trust as trust_checks
from workbench.cli.options import Run, common_options
from workbench.operations.drawings import drawings, stored_values, with_sheet_overrides
from workbench.operations.lines import counted as steps_of
from workbench.operations.parts import parts, with_repair
from workbench.report.checks import write_check_files
from workbench.report.machine import write_report
from workbench.report.make_tasks import LONG, Making
from workbench.report.stored_results import check_figure, check_files, figures_of, simulation, stored_checks


@click.command("make")
@click.option("--simulations/--no-simulations", default=True, help="Run the thesis's friction experiments too.")
@click.option("--trust", is_flag=True, help="Consent to run the files of the folder checks as they are now.")
@common_options
def command(run: Run, simulations: bool, trust: bool) -> int:
    """Make everything from the parameter file: parts, assembly, drawings, list of parts, checks, simulations, report.

    Exit status 0 once all is built, whatever the verdicts of the checks.
    """
    if trust:
        trust_checks(run)
    store = ArtefactStore()
    _fill(run, store, simulations)
    design, made = run.design.values, parts(run.design)
    document, changed, count = made.write_changed(run.out / "parts")
    run.echo(f"parts: {len(changed)} of {count} files written")
    machine = made.machine
    pictures = with_repair(store, lambda: _pictures(run, store, machine))
    with run.busy("interference"):
        interferences = build_interferences(store, machine.parts, design)
    pairs, found = len(interferences), len(clashes(interferences))
    run.echo(f"interference: {found} clashes, {pairs} contacts, fits and near places looked at")
    with run.reporting() as report:
        drawn = drawings(run.design, (), run.out / "drawings", report)
    hits, sheets = len(drawn.hits), drawn.document
    run.echo(f"drawings: {len(sheets['changed'])} of {sheets['files']} files written, {hits} lint hits")
    masses = machine.checked_masses
    checks = stored_checks(store, run.design, design, masses)
    run.echo(f"checks: {counted(checks)}")
    figures = with_repair(store, lambda: _checks(run, store, checks, masses))
    simulated = with_repair(store, lambda: _simulations(run, store)) if simulations else []
    bill = machine.bill_of_materials
    results = {
        "parts": document,
        "pictures": pictures,
        "checks": checks,
        "check_figures": figures,
        "simulation_figures": simulated,
        "bill": bill_document(bill),
        "interferences": interferences,
        "procedure": sheets_of(design).procedure(design, bill, stored_values(store, design, masses)),
        "drawings": sheets,
    }
    page = write_report(design, run.out, results)
    run.echo(f"report: {page}")
    stated = {"drawings": sheets["sheets"], "checks": [check.as_json() for check in checks], "report": str(page)}
    run.emit({**document, **stated})
    return 0


def _pictures(run: Run, store: ArtefactStore, machine: BuiltMachine) -> dict[str, Path]:
    """Pictures of the parts and of the assembly, by name."""
    with run.reporting() as report:
        files = build_pictures(store, machine, steps_of(report, "", len(machine.parts) + 1))
    write_stored(run.out / "pictures", files)
    return {Path(name).stem: run.out / "pictures" / name for name in files}


def _checks(run: Run, store: ArtefactStore, checks: Sequence[Check], masses: Masses) -> dict[str, Path]:
    """Write figures of the checks and the checks as files, those of a project's own without the cache; the figures."""
    design, folder = run.design.values, run.out / "checks"
    entries = {title: check_figure(store, design, masses, title) for title in figures_of(design)}
    figures = {title: path for title, entry in entries.items() for path in _write(folder, [entry])[0]}
    if run.design.check_files:
        write_check_files(checks, design, masses, folder, figures)
    else:
        _write(folder, [check_files(store, run.design, design, masses)])
    return figures


def _simulations(run: Run, store: ArtefactStore) -> list[Path]:
    """Data and figures of the thesis's experiments; the figures, as PNG."""
    names, entries = subjects_of(run.design.values).experiments, []
    with run.reporting() as report:
        advance = steps_of(report, "", len(names))
        for name in names:
            entries.append(simulation(store, run.design.values, name))
            advance(name)
    files, written = _write(run.out / "simulate", entries)
    run.echo(f"simulations: {written} files written" if written else "simulations: unchanged")
    return [file for file in files if file.suffix == ".png"]


def _write(folder: Path, entries: Iterable[Artefact]) -> tuple[list[Path], int]:
    """Copy the files of artefacts into a folder; their paths, and the number of those written."""
    files = {name: entry for entry in entries for name in entry.hashes}
    return [folder / name for name in files], len(write_stored(folder, files))


def _fill(run: Run, store: ArtefactStore, simulations: bool) -> None:
    """Make what the store lacks, side by side.

    The CAD kernel cannot be interrupted within a step: a note on a terminal states so before the kernel begins.
    """
    making = Making(store.folder, run.design.values, with_sheet_overrides(run.design), run.design, simulations)
    tasks = making.absent
    if any(task.kind in LONG for task in tasks):
        note = "Ctrl-C ends it after the CAD kernel's step, which may take some seconds"
        with run.reporting(note=note) as report:
            report("results", 0, len(tasks))
            making.make(tasks, steps_of(report, "", len(tasks)))
