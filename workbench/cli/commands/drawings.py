"""`stagecad drawings`: one DXF, SVG, PDF and PNG for each sheet, and its lint."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stagecad.parameters.errors import InputError
from workbench.cli.options import Run, common_options

if TYPE_CHECKING:
    from collections.abc import Sequence

    from drawings.artefacts.sheets import BuiltSheet
    from stagecad.parameters.design import Design

MANIFEST = "drawings_manifest.json"


@click.command("drawings")
@click.argument("names", metavar="[NAME]...", nargs=-1)
@click.option(
    "--part",
    "own",
    type=click.Path(path_type=Path),
    metavar="FILE.py",
    help="Draw a part of your own instead, from a Python file (see `stagecad new part`).",
)
@click.option("--trust", is_flag=True, help="Consent to run the file of --part as it is now.")
@click.option("--lint", is_flag=True, help="Check the sheets for overlapping texts and lines; exit status 1 on a hit.")
@click.option("--revision", help="Revision in the title block (parameter drawing.revision).")
@click.option("--date", help="Date of issue in the title block (drawing.date).")
@click.option("--drawn", metavar="NAME", help="Drawn by (drawing.drawn).")
@click.option("--checked", metavar="NAME", help="Checked by (drawing.checked).")
@click.option("--approved", metavar="NAME", help="Approved by (drawing.approved).")
@click.option(
    "--since",
    type=click.Path(path_type=Path),
    metavar="EARLIER.toml",
    help="Parameter file of the earlier issue: the differences form the revision table.",
)
@common_options
def command(
    run: Run, names: tuple[str, ...], own: Path | None, trust: bool, lint: bool, since: Path | None, **issue: str | None
) -> int:
    """Draw the sheets of all parts, or of those NAMEd only (a part, or one of its sheets: base_2)."""
    from workbench.cli.commands.declared import run_declared
    from workbench.machine.declared_machine import declared_machine

    entries = tuple(f"drawing.{key}={value}" for key, value in issue.items() if value is not None)
    run = replace(run, overrides=(*run.overrides, *entries), earlier=since)
    if own is not None:
        return _draw_own(run, own, names, trust, lint)
    declaration = declared_machine(run)
    if declaration is not None:
        return run_declared(run, declaration, ("drawings",), trust, lint, names)
    document = write_drawings(run, names)
    if run.json_target is None:
        _tell(run, document)
    hits = [hit for sheet in document["sheets"].values() for hit in sheet["hits"]]
    if lint:
        for name, sheet in document["sheets"].items():
            for hit in sheet["hits"]:
                run.note(f"{name}: {hit}")
        run.echo(f"lint: {len(hits)} hits on {len(document['sheets'])} sheets")
    run.emit(document)
    return 1 if lint and hits else 0


def _draw_own(run: Run, path: Path, names: tuple[str, ...], trust: bool, lint: bool) -> int:
    """Sheet, STEP AP242 and mass of a part from the user's file."""
    from workbench.machine.own_part import draw_part, load_part

    if names:
        raise InputError(f"--part {path}: draws this part alone; leave out '{names[0]}'")
    document = draw_part(load_part(path, run.design.values, trust), run.out)
    hits = [hit for sheet in document["sheets"] for hit in sheet["hits"]]
    for file in document["files"]:
        run.echo(file)
    for hit in hits if lint else ():
        run.note(f"{document['part']}: {hit}")
    run.echo(f"mass {document['mass']['value']:.4g} kg; lint: {len(hits)} hits")
    run.emit(document)
    return 1 if lint and hits else 0


def write_drawings(run: Run, names: tuple[str, ...] = ()) -> dict[str, Any]:
    """Draw what is missing, write the files that differ, and return the document of the command.

    Raises:
        InputError: a name that is neither a part with a drawing nor one of its sheets.
    """
    from drawings.artefacts.names import chosen_sheets
    from drawings.artefacts.tasks import build_all_sheets
    from drawings.sheets.overrides import FILE
    from stagecad.solids.artefacts.outputs import write_manifest, write_stored
    from stagecad.solids.artefacts.store import ArtefactStore
    from workbench.machine.artefacts import procedure_values, with_repair

    design = with_sheet_overrides(run)
    wanted = chosen_sheets(names, design)
    store = ArtefactStore()

    def draw() -> tuple[list[BuiltSheet], list[str]]:
        with run.progress() as progress:
            task = progress.add_task("drawings", total=len(wanted))
            made = build_all_sheets(
                store,
                wanted,
                design,
                lambda name: progress.update(task, advance=1, description=name),
                calculate=procedure_values,
            )
        sheets = [sheet for part, chosen in wanted.items() for sheet in made[part] if sheet.name in chosen]
        return sheets, write_stored(run.out, {file: sheet.artefact for sheet in sheets for file in _files(sheet)})

    sheets, changed = with_repair(run, store, draw)
    hashes = {file: sheet.artefact.hashes[file] for sheet in sheets for file in _files(sheet)}
    write_manifest(run.out / MANIFEST, hashes)
    for sheet in sheets:
        for hit in sheet.hits:
            if hit.startswith(FILE):
                run.note(hit)
    parameters = _write_parameters(run, sheets)
    return {
        "sheets": {
            sheet.name: {
                "part": sheet.part,
                "paper": sheet.paper,
                "scale": sheet.scale,
                "views": list(sheet.views),
                "files": [str(run.out / file) for file in _files(sheet)],
                "hits": list(sheet.hits),
            }
            for sheet in sheets
        },
        "changed": changed,
        "files": len(hashes),
        "parameters": parameters,
    }


def with_sheet_overrides(run: Run) -> Design:
    """The design with the manual changes of its sheets, from `sheets.toml` beside its parameter file.

    Raises:
        InputError: the file has an unknown sheet or key, or a wrong value.
    """
    from drawings.artefacts.names import sheet_names
    from drawings.sheets.overrides import FILE, read_overrides

    path = (run.design.path or Path("stage.toml")).parent / FILE
    if not path.is_file():
        return run.design.values
    known = [sheet for sheets in sheet_names(run.design.values).values() for sheet in sheets]
    return replace(run.design.values, sheets=read_overrides(path, known))


def _write_parameters(run: Run, sheets: Sequence[BuiltSheet]) -> list[str]:
    """Write the parameters beside the sheets, under the names that their title blocks give: `holder_c7088e19.toml`."""
    from stagecad.parameters.atomic import atomic_write_text

    text = run.design.to_toml()
    paths = dict.fromkeys(run.out / f"{sheet.part}_{sheet.digest}.toml" for sheet in sheets)
    for path in paths:
        if not path.is_file() or path.read_text("utf-8") != text:
            atomic_write_text(path, text)
    return [str(path) for path in paths]


def _files(sheet: BuiltSheet) -> tuple[str, ...]:
    """The sheet in its formats, its part's model with tolerances, and the table of what defines its faces."""
    return (*sheet.files, *(file for file in (sheet.model, sheet.definition) if file))


def _tell(run: Run, document: dict[str, Any]) -> None:
    width = max(len(name) for name in document["sheets"])
    run.echo(f"{'sheet':{width}}  paper  {'scale':>6}  views")
    for name, sheet in document["sheets"].items():
        run.echo(f"{name:{width}}  {sheet['paper']:5}  {sheet['scale']:>6}  {', '.join(sheet['views'])}")
    run.echo(f"{len(document['changed'])} of {document['files']} files written to {run.out}")
