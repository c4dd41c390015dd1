"""`stagecad new KIND NAME`: templates of what a user makes."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import click

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError, nearest
from workbench.cli.options import Run, common_options

_NAME = re.compile(r"[a-z][a-z0-9_]*")


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
    """Write a template to start from."""


@command.command("experiment")
@click.argument("folder", type=click.Path(path_type=Path))
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path), metavar="FILE...")
@click.option("--kind", default=None, metavar="KIND", help="Kind of rig, where it is not to be guessed.")
@common_options
def experiment(run: Run, folder: Path, files: tuple[Path, ...], kind: str | None) -> None:
    """Write FOLDER/experiment.toml from measurement FILEs, with a question where something is uncertain."""
    from workbench.cli.console import show
    from workbench.operations.new_experiment import Proposal, inspect

    with run.busy("reading the files"):
        written = Proposal(*inspect(files, kind)).write(folder)
    show(run, written.lines())
    run.emit(written.to_json())


def _template(kind: str, name: str) -> str:
    """Text of a template with the user's name in it."""
    if not _NAME.fullmatch(name):
        raise InputError(f"new {kind} '{name}': a name has small letters, digits and _, and begins with a letter")
    folder = Path(__file__).parents[2] / "templates"
    suffix = "toml" if kind == "machine" else "py"
    text = (folder / f"{kind}.{suffix}.txt").read_text("utf-8")
    return text.replace(f"my_{kind}", name).replace(f"my {kind}", name.replace("_", " "))


def _write(path: Path, text: str) -> None:
    if path.exists():
        raise InputError(f"{path}: is there already; choose another name")
    path.parent.mkdir(parents=True, exist_ok=True)
    atomic_write_text(path, text)
    click.echo(f"written: {path}")


@command.command("part")
@click.argument("name")
def part(name: str) -> None:
    """NAME.py: a part in cadquery with its dimensions; `stagecad drawings --part NAME.py` draws it."""
    _write(Path(f"{name}.py"), _template("part", name))


@command.command("check")
@click.argument("name")
def check(name: str) -> None:
    """checks/NAME.py: a design check; `stagecad check` runs those beside the parameter file."""
    _write(Path("checks") / f"{name}.py", _template("check", name))


@command.command("effect")
@click.argument("name")
def effect(name: str) -> None:
    """NAME.py: a physical effect, for `[model] custom` of an experiment."""
    from sim.effects.catalogue import library

    if name in library():
        raise InputError(f"new effect '{name}': is an effect of the library; choose another name")
    _write(Path(f"{name}.py"), _template("effect", name))


@command.command("hardware")
@click.argument("kind")
@common_options
def hardware(run: Run, kind: str) -> None:
    """KIND.csv: a table of piezos, screws, set_screws, springs, threads or materials, with those of the present design.

    `[hardware]` of the parameter file names it; a part chooses a row by its key `row`.
    """
    from stagecad.parameters.machine import packaged_machine
    from stagecad.parameters.project_tables import HARDWARE, ROW
    from workbench.operations.hardware_table import table_text

    kinds = packaged_machine().kinds()
    if kind not in kinds:
        raise InputError(f"new hardware '{kind}': no such kind of table{nearest(kind, kinds)}")
    _write(Path(f"{kind}.csv"), table_text(run.design.values, kind))
    click.echo(f'then, in the parameter file: [{HARDWARE}] {kind} = "{kind}.csv"')
    for slot in kinds[kind].slots[:1]:
        click.echo(f"and the name of a row as {slot}.{ROW}")


@command.command("machine")
@click.argument("name")
def machine(name: str) -> None:
    """NAME/: a project folder with stage.toml, a check of its own and a part of its own."""
    folder = Path(name)
    texts = {
        "stage.toml": _template("machine", name),
        f"checks/{name}_check.py": _template("check", f"{name}_check"),
        f"{name}_part.py": _template("part", f"{name}_part"),
    }
    if folder.exists():
        raise InputError(f"{folder}: is there already; choose another name")
    # The folder appears complete, by renaming.
    with tempfile.TemporaryDirectory(prefix=f".{name}-", dir=folder.absolute().parent) as temporary:
        made = Path(temporary) / name
        for file, text in texts.items():
            atomic_write_text(made / file, text)
        made.rename(folder)
    for file in texts:
        click.echo(f"written: {folder / file}")
