"""Commands on a machine that the parameter file declares (`[machine]`): parts, drawings, checks, all of them."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError
from workbench.cli.options import Run

if TYPE_CHECKING:
    from stagecad.solids.assembly.machine_declaration import MachineDeclaration
    from workbench.machine.declared_machine import BuiltMachine

BILL = "bill_of_materials"
WHAT = ("parts", "drawings", "checks")


def run_declared(
    run: Run, declaration: MachineDeclaration, what: tuple[str, ...], trust: bool, lint: bool = False, refused: Any = ()
) -> int:
    """Make parts, drawings and checks, or some of these, of a declared machine; the exit status.

    Args:
        run: of the command.
        declaration: of the machine.
        what: of `WHAT`.
        trust: whether the user consents to run the files of parts and checks as they are now.
        lint: whether lint hits decide the exit status.
        refused: names or options given that only the machine of the thesis has.
    """
    from designcalc.checks.analysis.report import counted
    from workbench.cli.console import show
    from workbench.machine.declared_machine import build, checks, draw
    from workbench.machine.own_checks import register
    from workbench.operations.checks import check_lines

    if refused:
        raise InputError(f"'{refused[0]}': is for the machine of the thesis; {run.design.path} declares another one")
    if trust:
        from workbench.cli.commands.check import trust as trust_checks

        trust_checks(run)
    if "checks" in what:
        register(run.design.check_files)
    status, document = 0, {}
    with run.progress() as progress:
        task = progress.add_task("parts", total=len(declaration.parts))
        built = build(run, declaration, trust, lambda name: progress.update(task, advance=1, description=name))
    if "parts" in what:
        document.update(_parts(run, built))
    if "drawings" in what:
        with run.busy("drawings"):
            sheets = draw(built, run.out)
        hits = [f"{sheet['name']}: {hit}" for sheet in sheets for hit in sheet["hits"]]
        for hit in hits if lint else ():
            run.note(hit)
        run.echo(f"drawings: {len(sheets)} sheets, {len(hits)} lint hits")
        document["sheets"] = sheets
        status = 1 if lint and hits else status
    if "checks" in what:
        found = checks(run, built)
        if what == ("checks",):
            show(run, check_lines(found))
            run.echo(f"{counted(found)}; every formula with its numbers: {run.out / 'checks' / 'checks.html'}")
            status = 1 if any(check.verdict == "fails" for check in found) else status
        else:
            run.echo(f"checks: {counted(found)}")
        document["checks"] = [check.as_json() for check in found]
    run.emit(document["checks"] if what == ("checks",) else document)
    return status


def _parts(run: Run, built: BuiltMachine) -> dict[str, Any]:
    """Files, masses, list of parts and interference."""
    from stagecad.solids.assembly.bill_of_materials import csv_text
    from stagecad.solids.assembly.bill_of_materials import document as bill_document
    from stagecad.solids.assembly.declared import export, overlaps_of
    from stagecad.solids.assembly.interference import CLASH

    machine = built.machine
    with run.busy("assembly"):
        files = export(machine, run.out)
        pairs = overlaps_of(machine)
    rows = machine.bill_of_materials
    atomic_write_text(run.out / f"{BILL}.csv", csv_text(rows))
    atomic_write_text(run.out / f"{BILL}.json", json.dumps(bill_document(rows), indent=1) + "\n")
    for row in rows:
        run.echo(f"{row.quantity:3d} x {row.part}: {row.mass:.4g} kg each, {row.material}")
    run.echo(f"assembly: {machine.whole.mass:.4g} kg; {len(files) + 2} files written to {run.out}")
    clashes = [pair for pair in pairs if pair.kind == CLASH]
    for pair in clashes:
        run.note(f"clash: {pair.first} and {pair.second} share {pair.common_volume:.3g} mm^3")
    run.echo(f"interference: {len(clashes)} clashes, {len(pairs) - len(clashes)} contacts and intended overlaps")
    return {
        "parts": {key: solid.mass.as_json() for key, solid in machine.parts.items()},
        "assembly": {**machine.whole.as_json(), "files": [str(run.out / name) for name in files]},
        "bill_of_materials": bill_document(rows),
        "interference": [
            {"first": pair.first, "second": pair.second, "kind": pair.kind, "common_volume": pair.common_volume * 1e-9}
            for pair in pairs
        ],
    }
