"""`stagecad new KIND NAME`: templates of what a user makes."""

import sys
from pathlib import Path

import click

from workbench.cli.console import show
from workbench.cli.dispatch import Group
from workbench.cli.options import FILE, Run, common_options, folded
from workbench.operations.templates import TEMPLATES, write_table_of, write_template


@click.group("new", cls=Group)
def command() -> None:
    """Write a template to start from."""


command.refusal = "new: no template of a '{}'"


class Experiment(click.Command):
    """`new experiment --help` lists the kinds of rig."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        from sysid.experiment.rig_kinds.declaration import find_rig, kinds

        with formatter.section("Kinds of rig (time, normal_load and temperature may be recorded on each)"):
            formatter.write_dl([(name, find_rig(name, "").summary) for name in kinds()])


@command.command("experiment", cls=Experiment)
@click.argument("folder", type=FILE)
@click.argument("files", nargs=-1, required=True, type=FILE, metavar="FILE...")
@click.option("--kind", default=None, metavar="KIND", help="Kind of rig, where it is not to be guessed.")
@common_options
def experiment(run: Run, folder: Path, files: tuple[Path, ...], kind: str | None) -> None:
    """Write FOLDER/experiment.toml from measurement FILEs, with a question where something is uncertain."""
    from workbench.operations.measurement.new_experiment import Proposal, inspect

    with run.busy("reading the files"):
        written = Proposal(*inspect(files, kind)).write(folder)
    show(run, written.lines())
    run.emit(written.to_json())


def _add_template(kind: str) -> None:
    @command.command(kind, help=TEMPLATES[kind])
    @click.argument("name")
    def write(name: str) -> None:
        click.echo(folded("\n".join(write_template(kind, name)), sys.stdout))


for _kind in ("part", "check", "effect"):
    _add_template(_kind)


@command.command("hardware")
@click.argument("kind")
@common_options
def hardware(run: Run, kind: str) -> None:
    """KIND.csv: a table of piezos, screws, set_screws, springs, threads or materials, with those of the present design.

    `[hardware]` of the parameter file names it; a part chooses a row by its key `row`.
    """
    show(run, write_table_of(run.design.values, kind))


for _kind in ("example", "machine"):
    _add_template(_kind)
