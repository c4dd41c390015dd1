"""`stagecad params`: every number of the machine with unit, tolerance and origin; differences between two files."""

from pathlib import Path

import click

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError
from stagecad.parameters.load import diff, load_design
from workbench.cli.console import show
from workbench.cli.options import FILE, Run, common_options
from workbench.operations.parameters import (
    difference_json,
    difference_lines,
    entry_json,
    is_named,
    parameter_table,
    require_known,
)


@click.command("params")
@click.argument("names", nargs=-1, metavar="[TABLE|KEY...]")
@click.option("--diff", "other", type=FILE, metavar="OTHER.toml", help="Show only what differs from OTHER.toml.")
@click.option(
    "--write",
    "target",
    type=FILE,
    metavar="FILE.toml",
    help="Write the parameters, with --set applied and comments kept, to a new file to start from.",
)
@common_options
def command(run: Run, names: tuple[str, ...], other: Path | None, target: Path | None) -> None:
    """The parameters with unit, tolerance and origin; all of them, or those of the tables and keys named."""
    values = run.design.values
    if target is not None:
        if target.exists():
            raise InputError(f"{target}: is there already; name a new file")
        atomic_write_text(target, run.design.to_toml())
        run.note(f"written: {target}")
    if other is not None:
        differences = [item for item in diff(values, load_design(other)) if is_named(item.key, names)]
        lines, document = (
            difference_lines(values.file, str(other), differences),
            {"files": [values.file, str(other)], "differences": [difference_json(item) for item in differences]},
        )
    else:
        require_known(names, values)
        entries = [entry for entry in values.entries if is_named(entry.key, names)]
        lines = [] if target is not None else [parameter_table(entries)]
        parameters = {entry.key: entry_json(entry) for entry in entries}
        document = {"file": values.file, "digest": values.digest, "parameters": parameters}
    if run.json_target is None:
        show(run, lines)
    run.emit(document)
