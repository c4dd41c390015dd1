"""`stagecad drawings`: one DXF, SVG, PDF and PNG for each sheet, and its lint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from workbench.options import Run, common_options

if TYPE_CHECKING:
    from drawings.artefacts.sheets import BuiltSheet

MANIFEST = "drawings_manifest.json"


@click.command("drawings")
@click.argument("names", metavar="[NAME]...", nargs=-1)
@click.option("--lint", is_flag=True, help="Check the sheets for overlapping texts and lines; exit status 1 on a hit.")
@common_options
def command(run: Run, names: tuple[str, ...], lint: bool) -> int:
    """Draw the sheets of all parts, or of those NAMEd only (a part, or one of its sheets: base_2)."""
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


def write_drawings(run: Run, names: tuple[str, ...] = ()) -> dict[str, Any]:
    """Draw what is missing, write the files that differ, and return the document of the command.

    Raises:
        InputError: a name that is neither a part with a drawing nor one of its sheets.
    """
    from drawings.artefacts.names import chosen_sheets
    from drawings.artefacts.tasks import build_all_sheets
    from stagecad.solids.artefacts.outputs import DamagedError, write_manifest, write_stored
    from stagecad.solids.artefacts.store import ArtefactStore
    from workbench.machine.artefacts import procedure_values

    wanted = chosen_sheets(names, run.design)
    store = ArtefactStore()

    def draw() -> tuple[list[BuiltSheet], list[str]]:
        with run.progress() as progress:
            task = progress.add_task("drawings", total=len(wanted))
            made = build_all_sheets(
                store,
                wanted,
                run.design,
                lambda name: progress.update(task, advance=1, description=name),
                calculate=procedure_values,
            )
        sheets = [sheet for part, chosen in wanted.items() for sheet in made[part] if sheet.name in chosen]
        return sheets, write_stored(run.out, {file: sheet.artefact for sheet in sheets for file in _files(sheet)})

    try:
        sheets, changed = draw()
    except DamagedError as damage:
        # A damaged cache entry is built again.
        store.drop(damage.entry)
        run.note("a stored result was damaged; it is made again")
        sheets, changed = draw()
    hashes = {file: sheet.artefact.hashes[file] for sheet in sheets for file in _files(sheet)}
    write_manifest(run.out / MANIFEST, hashes)
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
    }


def _files(sheet: BuiltSheet) -> tuple[str, ...]:
    """The sheet in its formats, and its part's model with tolerances where there is one."""
    return (*sheet.files, sheet.model) if sheet.model else sheet.files


def _tell(run: Run, document: dict[str, Any]) -> None:
    width = max(len(name) for name in document["sheets"])
    run.echo(f"{'sheet':{width}}  paper  {'scale':>6}  views")
    for name, sheet in document["sheets"].items():
        run.echo(f"{name:{width}}  {sheet['paper']:5}  {sheet['scale']:>6}  {', '.join(sheet['views'])}")
    run.echo(f"{len(document['changed'])} of {document['files']} files written to {run.out}")
