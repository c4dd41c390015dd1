"""`stagecad new KIND NAME`: templates of what a user makes."""

from pathlib import Path

import click

from stagecad.parameters.errors import nearest
from workbench.cli.console import show
from workbench.cli.options import FILE, Run, common_options
from workbench.operations.templates import EXAMPLES, copy_example, template, write_machine, write_new, write_table_of


class Templates(click.Group):
    """A group of one command for each kind of template; an unknown kind is refused with the most similar one."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and not args[0].startswith("-") and args[0] not in self.commands:
            raise click.UsageError(f"new: no template of a '{args[0]}'{nearest(args[0], self.commands)}", ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, " ".join((one.help or "").split())) for name, one in self.commands.items()])


@click.group("new", cls=Templates)
def command() -> None:
    """Write a template to start from."""


@command.command("experiment")
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


def _written(*files: Path) -> None:
    for file in files:
        click.echo(f"written: {file}")


def _add_template(kind: str, words: str) -> None:
    folder = Path("checks" if kind == "check" else "")

    @command.command(kind, help=words)
    @click.argument("name")
    def write(name: str) -> None:
        _written(write_new(folder / f"{name}.py", template(kind, name)))


for _kind, _words in {
    "part": "NAME.py: a part in cadquery with its dimensions; `stagecad drawings --part NAME.py` draws it.",
    "check": "checks/NAME.py: a design check; `stagecad check` runs those beside the parameter file.",
    "effect": "NAME.py: a physical effect, for `[model] custom` of an experiment.",
}.items():
    _add_template(_kind, _words)


@command.command("hardware")
@click.argument("kind")
@common_options
def hardware(run: Run, kind: str) -> None:
    """KIND.csv: a table of piezos, screws, set_screws, springs, threads or materials, with those of the present design.

    `[hardware]` of the parameter file names it; a part chooses a row by its key `row`.
    """
    show(run, write_table_of(run.design.values, kind))


@command.command("example")
@click.argument("name")
def example(name: str) -> None:
    """NAME/: a copy of a packaged example (demo, own_effect, own_rig, two_axis_stage, ball_screw_slide, ...)."""
    folder = copy_example(name, Path(name))
    _written(folder)
    click.echo(f"{EXAMPLES[name]}; see examples.html of 'stagecad docs'")


@command.command("machine")
@click.argument("name")
def machine(name: str) -> None:
    """NAME/: a project folder with stage.toml, a check of its own and a part of its own."""
    _written(*write_machine(name))
