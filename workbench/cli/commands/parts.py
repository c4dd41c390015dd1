"""`stagecad parts`: STEP, STL and GLB of parts and assembly, bill of materials, mass properties."""

import click

from stagecad.solids.modelling.part import CLASH
from workbench.cli.console import show
from workbench.cli.options import Run, common_options, design_trust
from workbench.operations.parts import parts

KERNEL = "making the parts; Ctrl-C ends it after the CAD kernel's step, which may take some seconds"


@click.command("parts")
@click.argument("names", metavar="[NAME]...", nargs=-1)
@design_trust("a machine of your own")
@common_options
def command(run: Run, names: tuple[str, ...]) -> None:
    """Write STEP, STL and GLB of the parts and the assembly, or of those NAMEd only, and print their mass."""
    with run.reporting(note=KERNEL) as report:
        made = parts(run.design, names, report)
    document, changed, count = made.write_changed(folder := run.folder("parts"))
    if run.json_target is None:
        show(run, made.lines())
        moving = f"moving body {document['moving_body']['mass']['value']:.3f} kg; " if "moving_body" in document else ""
        run.echo(f"{moving}{len(changed)} of {count} files written to {folder}")
    for pair in document.get("interference", ()):
        if pair["kind"] == CLASH:
            run.note(f"clash: {pair['first']} and {pair['second']} share {1e9 * pair['common_volume']:.3g} mm^3")
    run.emit(document)
