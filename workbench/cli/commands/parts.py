"""`stagecad parts`: STEP, STL and GLB of parts and assembly, bill of materials, mass properties."""

from __future__ import annotations

import click

from workbench.cli.commands.declared import run_declared
from workbench.cli.console import show
from workbench.cli.options import Run, common_options
from workbench.machine.declared_machine import declared_machine
from workbench.operations.parts import parts

KERNEL = "making the parts; Ctrl-C ends it after the CAD kernel's step, which may take some seconds"


@click.command("parts")
@click.argument("names", metavar="[NAME]...", nargs=-1)
@click.option("--trust", is_flag=True, help="Consent to run the files of a machine of your own as they are now.")
@common_options
def command(run: Run, names: tuple[str, ...], trust: bool) -> int:
    """Write STEP, STL and GLB of the parts and the assembly, or of those NAMEd only, and print their mass."""
    declaration = declared_machine(run)
    if declaration is not None:
        return run_declared(run, declaration, ("parts",), trust, refused=names)
    with run.reporting(note=KERNEL) as report:
        made = parts(run.design, names, report)
    document, changed, count = made.write_changed(run.out)
    if run.json_target is None:
        show(run, made.lines())
        moving = document["moving_body"]["mass"]["value"]
        run.echo(f"moving body {moving:.3f} kg; {len(changed)} of {count} files written to {run.out}")
    run.emit(document)
    return 0
