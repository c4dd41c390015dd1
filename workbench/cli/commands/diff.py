"""`stagecad diff A.toml B.toml`: what differs between two designs."""

from pathlib import Path

import click

from stagecad.parameters.errors import require
from stagecad.parameters.file import PACKAGED
from workbench.cli.console import show
from workbench.cli.options import FILE, Run, common_options, without_effect
from workbench.operations.design import Design
from workbench.operations.diff import diff


@click.command("diff")
@click.argument("first", metavar="A.toml", type=FILE)
@click.argument("second", metavar="B.toml", type=FILE)
@click.option("--solids/--no-solids", default=True, help="Compare masses, volumes and drawing sheets too.")
@click.option("--trust", is_flag=True, help="Consent to run the checks and parts of both designs as they are now.")
@without_effect("params")
@common_options
def command(run: Run, first: Path, second: Path, solids: bool, trust: bool) -> None:
    """What differs between two designs: parameters, masses, margins of the checks, sheets, volumes of the solids.

    Either may be 'thesis', the packaged design. The sheets that differ are written to OUT/diff with the changes marked.
    --set applies to the second design.
    """
    require(run.params is None, "diff: --params is not used; name the two files")
    paths = [None if str(path) == PACKAGED and not path.exists() else path for path in (first, second)]
    designs = Design(paths[0]), Design(paths[1], run.overrides)
    if trust:
        run.trust_files(*designs)
    with run.reporting() as report:
        differences = diff(*designs, solids=solids, out=run.out, progress=report, names=(str(first), str(second)))
    if run.json_target is None:
        show(run, differences.lines())
    run.emit(differences.to_json())
