"""`stagecad drawings`: one DXF, SVG, PDF and PNG for each sheet, and its lint."""

from pathlib import Path

import click

from stagecad.parameters.errors import InputError
from workbench.cli.console import show
from workbench.cli.options import FILE, Run, common_options
from workbench.operations.design import Design
from workbench.operations.drawings import draw_file, drawings

PART = (
    "Draw a part of your own instead, from a Python file (see `stagecad new part`), a CadQuery script or a STEP file; "
    "dimensions are proposed where none are declared."
)
FLAT = "Write SHEET_flat.dxf too: all in model space on paper, for viewers without viewports."
SINCE = "Parameter file of the earlier issue: the differences form the revision table."


@click.command("drawings")
@click.argument("names", metavar="[NAME]...", nargs=-1)
@click.option("--part", type=FILE, metavar="FILE.py|FILE.step", help=PART)
@click.option("--trust", is_flag=True, help="Consent to run the file of --part as it is now.")
@click.option("--lint", is_flag=True, help="Check the sheets for overlapping texts and lines; exit status 1 on a hit.")
@click.option("--flat", is_flag=True, help=FLAT)
@click.option("--revision", help="Revision in the title block (parameter drawing.revision).")
@click.option("--date", help="Date of issue in the title block (drawing.date).")
@click.option("--drawn", metavar="NAME", help="Drawn by (drawing.drawn).")
@click.option("--checked", metavar="NAME", help="Checked by (drawing.checked).")
@click.option("--approved", metavar="NAME", help="Approved by (drawing.approved).")
@click.option("--since", type=FILE, metavar="EARLIER.toml", help=SINCE)
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
        made = draw_file(part, design, trust, run.folder("drawings"), flat)
        show(run, made.lines(lint))
    else:
        if trust:
            run.trust_files(design)
        with run.reporting() as report:
            made = drawings(design, names, run.folder("drawings"), report, flat)
        show(run, [*(() if run.json_target else made.lines()), *(made.lint_lines() if lint else ())])
    run.emit(made.to_json())
    return 1 if lint and made.hits else 0
