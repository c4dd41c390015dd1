"""`stagecad add`: adds effects to an experiment's model, fits, writes the next rung; `--undo` goes back one."""

from __future__ import annotations

from pathlib import Path

import click

from workbench.options import Run, common_options


@click.command("add")
@click.argument("experiment", type=click.Path(path_type=Path))
@click.argument("effects", nargs=-1, metavar="EFFECT...")
@click.option("--undo", "undo_last", is_flag=True, help="Go back to the rung before; the undone one is kept.")
@common_options
def command(run: Run, experiment: Path, effects: tuple[str, ...], undo_last: bool) -> None:
    """Add EFFECTs to the model of EXPERIMENT, fit it, write the next rung of its ladder and experiment.toml."""
    from workbench.design_values import design_values

    if undo_last and effects:
        raise click.UsageError("--undo takes no EFFECT")
    if not undo_last and not effects:
        raise click.UsageError("name at least one EFFECT to add, or --undo; 'stagecad effects' lists them")
    if undo_last:
        from sysid.experiment import load_experiment
        from sysid.ladder_files import undo

        rung, kept = undo(load_experiment(experiment, design_values(run)))
        effects_now = ", ".join(rung.effects) or "no effects"
        run.say(f"back on rung {rung.number:03d}: {effects_now}; the undone rung is kept in {kept}")
        run.emit({"schema": 1, "rung": rung.number, "effects": list(rung.effects), "kept": str(kept)})
        return
    from sysid.document import both_json
    from sysid.ladder import add_effects
    from workbench.loop_text import say_step

    step = add_effects(experiment, effects, design_values(run))
    parameters = dict(step.rung.document["parameters"])
    say_step(run, step, parameters)
    run.emit(
        {
            "schema": 1,
            "rung": step.rung.number,
            "file": str(step.rung.path),
            "form": step.case.form,
            "effects": list(step.rung.effects),
            "added": list(step.rung.document.get("added", ())),
            "before": both_json(step.case, step.before_fit, step.before_validate),
            "after": both_json(step.case, step.after_fit, step.after_validate),
            "parameters": parameters,
            "seconds": step.seconds,
        }
    )
