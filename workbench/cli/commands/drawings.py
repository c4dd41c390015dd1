"""`stagecad drawings`: one DXF, SVG, PDF and PNG for each sheet, and its lint."""

from pathlib import Path

import click

from stagecad.parameters.errors import InputError
from workbench.cli.commands.check import trust as trust_files
from workbench.cli.console import show
from workbench.cli.options import FILE, Run, common_options
from workbench.operations.design import Design
from workbench.operations.drawings import drawings, write_flat
from workbench.operations.proposed_part import draw_file


@click.command("drawings")
@click.argument("names", metavar="[NAME]...", nargs=-1)
@click.option(
    "--part",
    "part",
    type=FILE,
    metavar="FILE.py|FILE.step",
    help="Draw a part of your own instead, from a Python file (see `stagecad new part`), a CadQuery script or a STEP "
    "file; dimensions are proposed where none are declared.",
)
@click.option("--trust", is_flag=True, help="Consent to run the file of --part as it is now.")
@click.option("--lint", is_flag=True, help="Check the sheets for overlapping texts and lines; exit status 1 on a hit.")
@click.option(
    "--flat", is_flag=True, help="Write SHEET_flat.dxf too: all in model space on paper, for viewers without viewports."
)
@click.option("--revision", help="Revision in the title block (parameter drawing.revision).")
@click.option("--date", help="Date of issue in the title block (drawing.date).")
@click.option("--drawn", metavar="NAME", help="Drawn by (drawing.drawn).")
@click.option("--checked", metavar="NAME", help="Checked by (drawing.checked).")
@click.option("--approved", metavar="NAME", help="Approved by (drawing.approved).")
@click.option(
    "--since",
    type=FILE,
    metavar="EARLIER.toml",
    help="Parameter file of the earlier issue: the differences form the revision table.",
)
@common_options
def command(
    run: Run,
    names: tuple[str, ...],
    part: Path | None,
    trust: bool,
    lint: bool,
    flat: bool,
    since: Path | None,
    **issue: str,
) -> int:
    """Draw the sheets of all parts, or of those NAMEd only (a part, or one of its sheets: base_2)."""
    entries = tuple(f"drawing.{key}={value}" for key, value in issue.items() if value is not None)
    design = Design.chosen(run.params, (*run.overrides, *entries), earlier=since)
    if part is not None:
        if names:
            raise InputError(f"--part {part}: draws this part alone; leave out '{names[0]}'")
        return _draw_part(run, design, part, trust=trust, lint=lint, flat=flat)
    run = run.with_design(design)
    if trust:
        trust_files(run)
    folder = run.folder("drawings")
    with run.reporting() as report:
        made = drawings(design, names, folder, report)
    if flat:
        for sheet in made.document["sheets"].values():
            sheet["files"] += write_flat(sheet["files"])
    if run.json_target is None:
        show(run, made.lines())
        run.echo(f"{len(made.document['changed'])} of {made.document['files']} files written to {folder}")
    if lint:
        for name, hit in made.hits:
            run.note(f"{name}: {hit}")
        run.echo(f"lint: {len(made.hits)} hits on {len(made.sheets)} sheets")
    run.emit(made.document)
    return 1 if lint and made.hits else 0


def _draw_part(run: Run, design: Design, path: Path, *, trust: bool, lint: bool, flat: bool) -> int:
    """Sheets, STEP AP242 and mass of the parts of the user's file."""
    documents = draw_file(path, design, trust, run.folder("drawings"))
    hits = 0
    for document in documents:
        document["files"] += write_flat(document["files"]) if flat else []
        found = [hit for sheet in document["sheets"] for hit in sheet["hits"]]
        hits += len(found)
        for file in document["files"]:
            run.echo(file)
        for question in document.get("questions", ()):
            run.echo(f"question: {question}")
        for hit in found if lint else ():
            run.note(f"{document['part']}: {hit}")
        run.echo(f"mass {document['mass']['value']:.4g} kg; lint: {len(found)} hits")
    run.emit(documents[0] if len(documents) == 1 else {"parts": documents})
    return 1 if lint and hits else 0
