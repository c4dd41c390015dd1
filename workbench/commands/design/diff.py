"""`stagecad diff A.toml B.toml`: what differs between two designs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stagecad.parameters.errors import InputError
from workbench.options import Run, common_options

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from workbench.machine.comparison import MarginChange, MassChange, SheetChange, VolumeChange


@click.command("diff")
@click.argument("first", metavar="A.toml", type=click.Path(path_type=Path))
@click.argument("second", metavar="B.toml", type=click.Path(path_type=Path))
@click.option("--solids/--no-solids", default=True, help="Compare masses, volumes and drawing sheets too.")
@common_options
def command(run: Run, first: Path, second: Path, solids: bool) -> None:
    """What differs between two designs: parameters, masses, margins of the checks, sheets, volumes of the solids.

    The sheets that differ are written to OUT/diff with the changes marked. --set applies to the second design.
    """
    from stagecad.parameters.load import diff, load_design
    from workbench.commands.params import difference_document, show_differences
    from workbench.console.comparison import print_changes

    if run.params is not None:
        raise InputError("diff: --params is not used; name the two files")
    before, after = load_design(first), load_design(second, run.overrides)
    differences = list(diff(before, after))
    show_differences(run, str(first), str(second), differences)
    document: dict[str, Any] = {
        "files": [str(first), str(second)],
        "parameters": [difference_document(item) for item in differences],
    }
    masses, margins, volumes, sheets = _changes(run, before, after, solids)
    print_changes(run, masses, margins, volumes, sheets)
    document["margins"] = [item.as_json() for item in margins]
    if solids:
        document["masses"] = [item.as_json() for item in masses]
        document["volumes"] = [item.as_json() for item in volumes]
        document["sheets"] = [item.as_json() for item in sheets]
    run.emit(document)


def _changes(
    run: Run, before: Design, after: Design, solids: bool
) -> tuple[list[MassChange], list[MarginChange], list[VolumeChange], list[SheetChange]]:
    from designcalc.checks import run_checks
    from workbench.machine.comparison import margin_changes, mass_changes, sheet_changes, volume_changes

    if not solids:
        return [], margin_changes(run_checks(before), run_checks(after)), [], []
    from stagecad.parameters.mass_properties import BodyMasses
    from stagecad.solids.assembly.machine import build_machine

    with run.progress() as progress:
        task = progress.add_task("parts", total=None)

        def advance(name: str) -> None:
            progress.update(task, description=name)

        one, other = (build_machine(design, None, advance) for design in (before, after))
        checks = [
            run_checks(machine.design, BodyMasses(machine.moving_body, machine.masses["tip"]))
            for machine in (one, other)
        ]
        progress.update(task, description="volumes")
        volumes = volume_changes(one, other)
        sheets = sheet_changes(before, after, run.out / "diff", advance)
    return mass_changes(one, other), margin_changes(*checks), volumes, sheets
