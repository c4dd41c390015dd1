"""`stagecad make`: all results of the parameter file, and one HTML report; results with unchanged inputs are kept."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from workbench.cli.options import Run, common_options

if TYPE_CHECKING:
    from designcalc.checks.check import Check
    from stagecad.parameters.mass_properties import Masses
    from stagecad.solids.artefacts.store import Artefact, ArtefactStore
    from stagecad.solids.assembly.built_machine import BuiltMachine


@click.command("make")
@click.option("--simulations/--no-simulations", default=True, help="Run the thesis's friction experiments too.")
@click.option("--trust", is_flag=True, help="Consent to run the files of the folder checks as they are now.")
@common_options
def command(run: Run, simulations: bool, trust: bool) -> int:
    """Make everything from the parameter file: parts, assembly, drawings, list of parts, checks, simulations, report.

    Exit status 0 once all is built, whatever the verdicts of the checks.
    """
    from stagecad.solids.artefacts.store import ArtefactStore
    from workbench.cli.commands.check import trust as trust_checks

    if trust:
        trust_checks(run)
    store = ArtefactStore()
    _fill(run, store, simulations)
    _write_results(run, store, simulations)
    return 0


def _write_results(run: Run, store: ArtefactStore, simulations: bool) -> None:
    """Write all results from the store, and the report."""
    from designcalc.checks.analysis.report import counted
    from drawings.sheets.plans import sheets_of
    from stagecad.solids.assembly.bill_of_materials import document as bill_document
    from stagecad.solids.assembly.interference import build_interferences, clashes
    from workbench.operations.drawings import drawings, stored_values
    from workbench.operations.parts import parts, with_repair
    from workbench.report.machine import MachineResults, write_report
    from workbench.report.stored_results import stored_checks

    design = run.design.values
    made = parts(run.design)
    document, changed, count = made.write_changed(run.out)
    run.echo(f"parts: {len(changed)} of {count} files written")
    machine = made.machine
    pictures = with_repair(store, lambda: _pictures(run, store, machine))
    with run.busy("interference"):
        interferences = build_interferences(store, machine.parts, design)
    pairs, found = len(interferences), len(clashes(interferences))
    run.echo(f"interference: {found} clashes, {pairs} contacts, fits and near places looked at")
    with run.reporting() as report:
        drawn = drawings(run.design, (), run.out, report)
    hits, sheets = len(drawn.hits), drawn.document
    run.echo(f"drawings: {len(sheets['changed'])} of {sheets['files']} files written, {hits} lint hits")
    masses = machine.checked_masses
    checks = stored_checks(store, run.design, design, masses)
    run.echo(f"checks: {counted(checks)}")
    check_figures = with_repair(store, lambda: _check_figures(run, store, masses))
    with_repair(store, lambda: _write_checks(run, store, checks, masses, check_figures))
    figures = with_repair(store, lambda: _simulations(run, store)) if simulations else []
    bill = machine.bill_of_materials
    steps = sheets_of(design).procedure(design, bill, stored_values(store, design, masses))
    results = MachineResults(
        parts=document,
        pictures=pictures,
        checks=checks,
        check_figures=check_figures,
        simulation_figures=figures,
        bill=bill_document(bill),
        interferences=interferences,
        procedure=steps,
        drawings=sheets,
    )
    page = write_report(design, run.out, results)
    run.echo(f"report: {page}")
    run.emit(
        {
            **document,
            "drawings": sheets["sheets"],
            "checks": [check.as_json() for check in checks],
            "report": str(page),
        }
    )


def _pictures(run: Run, store: ArtefactStore, machine: BuiltMachine) -> dict[str, Path]:
    """Pictures of the parts and of the assembly, by name."""
    from stagecad.solids.artefacts.outputs import write_stored
    from stagecad.solids.assembly.pictures import build_pictures

    with run.progress() as progress:
        task = progress.add_task("pictures", total=len(machine.parts) + 1)
        files = build_pictures(store, machine, lambda name: progress.update(task, advance=1, description=name))
    write_stored(run.out / "pictures", files)
    return {Path(name).stem: run.out / "pictures" / name for name in files}


def _check_figures(run: Run, store: ArtefactStore, masses: Masses) -> dict[str, Path]:
    """The figures of the checks by title."""
    from workbench.report.stored_results import check_figure, figures_of

    entries = {title: check_figure(store, run.design.values, masses, title) for title in figures_of(run.design.values)}
    return {title: path for title, entry in entries.items() for path in _write(run.out / "checks", [entry])[0]}


def _write_checks(
    run: Run, store: ArtefactStore, checks: Sequence[Check], masses: Masses, figures: Mapping[str, Path]
) -> None:
    """Write the checks as files; those of a project's own are not kept in the cache."""
    from workbench.report.checks import write_check_files
    from workbench.report.stored_results import check_files

    source, folder = run.design, run.out / "checks"
    if source.check_files:
        write_check_files(checks, run.design.values, masses, folder, figures)
    else:
        _write(folder, [check_files(store, source, run.design.values, masses)])


def _simulations(run: Run, store: ArtefactStore) -> list[Path]:
    """Data and figures of the thesis's experiments; the figures, as PNG."""
    from designcalc.checks.run import subjects_of
    from workbench.report.stored_results import simulation

    names = subjects_of(run.design.values).experiments
    with run.progress() as progress:
        task = progress.add_task("simulations", total=len(names))
        entries = []
        for name in names:
            entries.append(simulation(store, run.design.values, name))
            progress.update(task, advance=1, description=name)
    files, written = _write(run.out / "simulate", entries)
    run.echo(f"simulations: {written} files written" if written else "simulations: unchanged")
    return [file for file in files if file.suffix == ".png"]


def _write(folder: Path, entries: Iterable[Artefact]) -> tuple[list[Path], int]:
    """Copy the files of artefacts into a folder; their paths, and the number of those written."""
    from stagecad.solids.artefacts.outputs import write_stored

    files = {name: entry for entry in entries for name in entry.hashes}
    return [folder / name for name in files], len(write_stored(folder, files))


def _fill(run: Run, store: ArtefactStore, simulations: bool) -> None:
    """Make what the store lacks, side by side.

    The CAD kernel cannot be interrupted within a step: a note on a terminal states so before the kernel begins.
    """
    from workbench.operations.drawings import with_sheet_overrides
    from workbench.report.make import LONG, Making

    making = Making(store.folder, run.design.values, with_sheet_overrides(run.design), run.design, simulations)
    tasks = making.absent
    if not any(task.kind in LONG for task in tasks):
        return
    with run.progress() as progress:
        if not progress.disable:
            run.note("Ctrl-C ends it after the CAD kernel's step, which may take some seconds")
        bar = progress.add_task("results", total=len(tasks))
        making.make(tasks, lambda task: progress.update(bar, advance=1, description=str(task)))
