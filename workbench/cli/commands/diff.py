"""`stagecad diff A.toml B.toml`: what differs between two designs."""

from __future__ import annotations

from pathlib import Path

import click

from stagecad.parameters.errors import InputError
from workbench.cli.options import Run, common_options


@click.command("diff")
@click.argument("first", metavar="A.toml", type=click.Path(path_type=Path))
@click.argument("second", metavar="B.toml", type=click.Path(path_type=Path))
@click.option("--solids/--no-solids", default=True, help="Compare masses, volumes and drawing sheets too.")
@common_options
def command(run: Run, first: Path, second: Path, solids: bool) -> None:
    """What differs between two designs: parameters, masses, margins of the checks, sheets, volumes of the solids.

    Either may be 'thesis', the packaged design. The sheets that differ are written to OUT/diff with the changes marked.
    --set applies to the second design.
    """
    from stagecad.parameters.file import PACKAGED
    from stagecad.parameters.load import load_design
    from workbench.cli.commands.params import show_differences
    from workbench.console.comparison import print_changes
    from workbench.machine.comparison import compare_designs

    if run.params is not None:
        raise InputError("diff: --params is not used; name the two files")
    paths = [None if str(path) == PACKAGED and not path.exists() else path for path in (first, second)]
    designs = load_design(paths[0]), load_design(paths[1], run.overrides)
    names = str(first), str(second)
    with run.progress() as progress:
        task = progress.add_task("differences", total=None)
        found = compare_designs(
            designs,
            names,
            run.out / "diff" if solids else None,
            progress=lambda step, done, total: progress.update(task, description=step),
        )
    show_differences(run, *names, list(found.parameters))
    print_changes(run, found.masses or [], found.margins or [], found.volumes or [], found.sheets or [])
    run.emit(found.as_json())
