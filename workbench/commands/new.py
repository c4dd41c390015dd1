"""`stagecad new KIND NAME`: templates of what a user makes."""

from __future__ import annotations

from pathlib import Path

import click

from stagecad.parameters.errors import nearest
from workbench.options import Run, common_options


class Templates(click.Group):
    """A group of one command for each kind of template; an unknown kind is refused with the most similar one."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and not args[0].startswith("-") and args[0] not in self.commands:
            raise click.UsageError(f"new: no template of a '{args[0]}'{nearest(args[0], self.commands)}", ctx)
        return super().resolve_command(ctx, args)


@click.group("new", cls=Templates)
def command() -> None:
    """Write a template of KIND to start from."""


@command.command("experiment")
@click.argument("folder", type=click.Path(path_type=Path))
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="FILE...")
@click.option("--kind", default=None, metavar="KIND", help="Kind of rig, where it is not to be guessed.")
@common_options
def experiment(run: Run, folder: Path, files: tuple[Path, ...], kind: str | None) -> None:
    """Write FOLDER/experiment.toml from measurement FILEs, with a question where something is uncertain."""
    from sysid.experiment.columns.proposal import number_columns
    from workbench.identification.new_experiment import inspect, questions, write_experiment
    from workbench.report.column_figure import draw_columns

    with run.busy("reading the files"):
        opened, proposal = inspect(files, kind)
        target = write_experiment(folder, opened, proposal)
        picture = draw_columns(folder / "columns.png", number_columns(opened[0]), proposal)
    if opened[0].header.remarks:
        run.echo(f"read as: {', '.join(opened[0].header.remarks)}")
    for column in proposal.columns:
        run.echo(f"column {column.number} '{column.label}': {column.channel or 'left out'}")
    asked = questions(proposal)
    for question in asked:
        run.echo(f"question: {question}")
    then = "answer its questions, then" if asked else "then"
    run.echo(f"written: {target} and {picture}; {then}: stagecad compare {folder}")
    run.emit(
        {
            "experiment": str(target),
            "picture": str(picture),
            "read_as": list(opened[0].header.remarks),
            "kind": proposal.kind,
            "channels": {c.channel: c.label for c in proposal.columns if c.channel is not None},
            "questions": asked,
        }
    )
