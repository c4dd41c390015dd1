"""`stagecad add`: adds effects to an experiment's model, fits, writes the next rung; `--undo` goes back one."""

from functools import partial
from pathlib import Path
from typing import Any

import click

from workbench.cli.options import Run, common_options, experiment_options
from workbench.operations.result import update_report

WRITE_BACK = (
    "Write a fitted value to KEY of the parameter file (--params, or stage.toml here), with its deviation and the "
    "experiment as its origin; may be repeated, with or without an EFFECT to add first."
)
DROP = "Take an effect out of the model on the same rung; may be repeated, with or without an EFFECT to add."


@click.command("add")
@click.option("--undo", "undo_last", is_flag=True, help="Return to the previous rung; the rung undone is kept.")
@click.option("--write-back", "keys", multiple=True, metavar="KEY[=FITTED]", help=WRITE_BACK)
@click.option("--drop", multiple=True, metavar="EFFECT", help=DROP)
@click.option("--all", "every", is_flag=True, help="Diagnose, and add every effect that is certain, each on a rung.")
@common_options
@experiment_options
@click.argument("effects", nargs=-1, metavar="[EFFECT...]")
def command(
    run: Run,
    experiment: Path,
    effects: tuple[str, ...],
    undo_last: bool,
    keys: tuple[str, ...],
    drop: tuple[str, ...],
    every: bool,
) -> None:
    """Add EFFECTs to the model of EXPERIMENT, fit it, write the next rung of its ladder and experiment.toml."""
    given = (("EFFECT", effects), ("--drop", drop), ("--write-back", keys), ("--undo", every and undo_last))
    what = next((word for word, one in given if one), None)
    if what is not None and (every or undo_last):
        raise click.UsageError(f"--{'undo' if undo_last and what != '--undo' else 'all'} takes no {what}")
    if not (undo_last or effects or drop or keys or every):
        raise click.UsageError("name at least one EFFECT to add, or --undo; 'stagecad effects' lists them")
    from workbench.cli.console import search_progress, show
    from workbench.operations.measurement.add import add, add_all, undo, write_fitted
    from workbench.operations.measurement.write_back import WriteBack

    write_back = WriteBack(keys, run.design) if keys else None
    change: Any = partial(add, drop=drop, design=run.design) if effects or drop else write_fitted
    words = [f"{word} {', '.join(names)}" for word, names in (("with", effects), ("without", drop)) if names]
    if every:
        with run.progress() as progress:
            result = add_all(experiment, run.design, search_progress(progress))
    elif undo_last:
        result = undo(experiment, run.design)
    else:
        with run.busy(f"fitting the model {' and '.join(words) or 'as it stands'}"):
            result = change(experiment, *effects, write_back=write_back)
    show(run, result.lines())
    update_report(result, run.out)
    run.emit(result.to_json())
