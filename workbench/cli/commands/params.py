"""`stagecad params`: every number of the machine with unit, tolerance and origin; differences between two files."""

from pathlib import Path

import click

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import require
from workbench.cli.console import show
from workbench.cli.options import FILE, Run, common_options, without_effect
from workbench.operations.parameters import stated_parameters

WRITE = "Write the parameters, with --set applied and comments kept, to a new file to start from."


@click.command("params")
@click.argument("names", nargs=-1, metavar="[TABLE|KEY...]")
@click.option("--diff", "other", type=FILE, metavar="OTHER.toml", help="Show only what differs from OTHER.toml.")
@click.option("--write", "target", type=FILE, metavar="FILE.toml", help=WRITE)
@without_effect("out")
@common_options
def command(run: Run, names: tuple[str, ...], other: Path | None, target: Path | None) -> None:
    """The parameters with unit, tolerance and origin; all of them, or those of the tables and keys named."""
    values = run.design.values
    if target is not None:
        require(not target.exists(), f"{target}: is there already; name a new file")
        atomic_write_text(target, run.design.to_toml())
        run.note(f"written: {target}")
    lines, document = stated_parameters(values, names, other)
    if run.json_target is None and (target is None or other is not None):
        show(run, lines)
    run.emit(document)
