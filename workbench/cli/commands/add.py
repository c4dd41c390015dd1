"""`stagecad add`: adds effects to an experiment's model, fits, writes the next rung; `--undo` goes back one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stagecad.parameters.errors import InputError
from workbench.cli.options import Run, common_options, experiment_options

if TYPE_CHECKING:
    from sysid.estimation.fit import FittedModel
    from sysid.prediction.problem import Problem


@click.command("add")
@click.option("--undo", "undo_last", is_flag=True, help="Return to the previous rung; the rung undone is kept.")
@click.option(
    "--write-back",
    "keys",
    multiple=True,
    metavar="KEY[=FITTED]",
    help="Write a fitted value to KEY of the parameter file (--params, or stage.toml here), with its deviation and the "
    "experiment as its origin; may be repeated, with or without an EFFECT to add first.",
)
@click.option(
    "--drop",
    multiple=True,
    metavar="EFFECT",
    help="Take an effect out of the model on the same rung; may be repeated, with or without an EFFECT to add.",
)
@common_options
@experiment_options
@click.argument("effects", nargs=-1, metavar="[EFFECT...]")
def command(
    run: Run, experiment: Path, effects: tuple[str, ...], undo_last: bool, keys: tuple[str, ...], drop: tuple[str, ...]
) -> None:
    """Add EFFECTs to the model of EXPERIMENT, fit it, write the next rung of its ladder and experiment.toml."""
    if undo_last and (effects or keys or drop):
        raise click.UsageError(f"--undo takes no {'EFFECT' if effects else '--drop' if drop else '--write-back'}")
    if undo_last:
        _undo(run, experiment)
    elif effects or drop:
        _add(run, experiment, effects, keys, drop)
    elif keys:
        _write_back_only(run, experiment, keys)
    else:
        raise click.UsageError("name at least one EFFECT to add, or --undo; 'stagecad effects' lists them")


def _undo(run: Run, experiment: Path) -> None:
    from workbench.identification.undo import undo_last

    found = undo_last(experiment)
    effects_now = ", ".join(found.rung.effects) or "no effects"
    run.echo(f"back on rung {found.rung.number:03d}: {effects_now}; the undone rung is kept in {found.kept}")
    run.emit(found.as_json())


def _add(run: Run, experiment: Path, effects: tuple[str, ...], keys: tuple[str, ...], drop: tuple[str, ...]) -> None:
    from sysid.ladder import add_effects, addition_json
    from workbench.console.identification import print_revision
    from workbench.identification.design_values import design_values

    def accept(problem: Problem, fitted: FittedModel) -> None:
        # Before the rung is written: values that cannot be written back stop the command with nothing done.
        if keys:
            values_to_write(run, problem, fitted, keys, f"measured: {problem.experiment.folder.resolve().name}")

    if keys:
        from workbench.identification.write_back import parameter_file, values_to_write

        parameter_file(run)
    with run.busy(f"fitting the model {_change(effects, drop)}"):
        step = add_effects(experiment, effects, design_values(run.design), drop, accept)
    document = addition_json(step)
    print_revision(run, step, document)
    if keys:
        try:
            document.update(_written(run, step.problem, step.base.fitted, keys, step.revision.number))
        except (InputError, OSError) as error:
            raise InputError(f"{error}; rung {step.revision.number:03d} was added all the same") from None
    run.emit(document)


def _change(effects: tuple[str, ...], drop: tuple[str, ...]) -> str:
    words = [f"{word} {', '.join(names)}" for word, names in (("with", effects), ("without", drop)) if names]
    return " and ".join(words)


def _write_back_only(run: Run, experiment: Path, keys: tuple[str, ...]) -> None:
    from sysid.estimation.reference_fit import fit_stated_model
    from sysid.experiment.history import edited_by_hand, read_history
    from sysid.prediction.problem import load_problem
    from sysid.report import parameters_json
    from workbench.identification.design_values import design_values

    with run.busy("fitting the model as it stands"):
        problem = load_problem(experiment, design_values(run.design))
        fitted = fit_stated_model(problem).fitted
    rungs = read_history(problem.experiment)
    rung = rungs[-1].number if rungs and not edited_by_hand(problem.experiment, rungs) else None
    document = {"schema": 1, "form": problem.form, "effects": [e.name for e in fitted.model.effects]}
    document["parameters"] = parameters_json(problem, fitted)
    run.emit({**document, **_written(run, problem, fitted, keys, rung)})


def _written(
    run: Run, problem: Problem, fitted: FittedModel, keys: tuple[str, ...], rung: int | None
) -> dict[str, Any]:
    from workbench.identification.write_back import parameter_file, write_back, written_json

    name = problem.experiment.folder.resolve().name
    origin = f"measured: {name}" if rung is None else f"measured: {name}, rung {rung:03d}"
    written = write_back(run, problem, fitted, keys, origin)
    path = parameter_file(run)
    for one in written:
        run.echo(f"{path}: {one.key} = {one.text} ({one.origin}); it was {one.before[0]} ({one.before[1]})")
    return {"parameter_file": str(path), "written_back": written_json(written)}
