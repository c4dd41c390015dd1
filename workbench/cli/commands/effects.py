"""`stagecad effects`: the library of physical effects, printed from its declarations."""

from pathlib import Path

import click

from workbench.cli.console import show
from workbench.cli.options import FILE, Run, common_options, without_effect
from workbench.operations.effects import effect, effect_json, effect_lines, effects, library_table
from workbench.operations.templates import write_effect

CUSTOM = "A file of your own effects, checked and listed with the built-in ones; may be repeated."
WRITE = "Write an effect of your own to a new file to start from."


@click.command("effects")
@click.argument("name", required=False)
@click.option("--custom", "custom_files", multiple=True, type=FILE, metavar="FILE.py", help=CUSTOM)
@click.option("--write", "target", type=FILE, metavar="FILE.py", help=WRITE)
@without_effect("params", "overrides", "out")
@common_options
def command(run: Run, name: str | None, custom_files: tuple[Path, ...], target: Path | None) -> None:
    """List the physical effects, or describe one: NAME, NAME:VARIANT."""
    if target is not None:
        name = write_effect(target)
        run.note(
            f'written: {target}; to have it tried, put custom = ["{target.name}"] under [model] in experiment.toml '
            "and give --trust after each change"
        )
        custom_files = (*custom_files, target)
    if name is None:
        listed = effects(custom_files)
        show(run, [library_table(listed)])
        run.emit([effect_json(one) for one in listed])
        return
    described = effect(name, custom_files)
    show(run, effect_lines(described))
    run.emit(effect_json(described))
