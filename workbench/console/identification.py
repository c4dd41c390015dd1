"""Output of the identification commands: tables, statements, and the progress of a search for effects."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import click

from stagecad.parameters.errors import one_line
from sysid.compare import Comparison
from sysid.diagnose import Diagnosis
from sysid.estimation.identifiability import public_key
from sysid.ladder import Addition
from workbench.cli.options import Run
from workbench.console.tables import rich_table
from workbench.identification.statements import (
    comparison_statement,
    diagnosis_statement,
    equivalence_statement,
    is_adequate,
    near_noise,
    next_step_statement,
    noise_text,
    replacement_statements,
    unphysical_statements,
)
from workbench.identification.tables import (
    correlation_table,
    dependence_table,
    detectable_table,
    error_table,
    parameter_table,
    quantity_text,
    ranking_table,
    simulation_table,
)

if TYPE_CHECKING:
    from rich.progress import Progress

MOST_COORDINATES = 6
"""Listed of the residual's dependence."""


def print_comparison(run: Run, comparison: Comparison, document: Mapping[str, Any]) -> None:
    """Print a comparison; `document` is its own."""
    _print_notes_and_noise(run, comparison)
    effects = ", ".join(e.name for e in comparison.base.fitted.model.effects) or "no effects"
    run.console.print(rich_table(error_table(f"Model as it stands: {effects}", document["before"])))
    simulation = simulation_table(document)
    if simulation.rows:
        run.console.print(rich_table(simulation))
    else:
        run.echo(comparison.simulation.note or "the prediction is the simulation from the inputs: the same errors")
    run.console.print(rich_table(parameter_table(document["parameters"])))
    for line in document["not_identifiable"]:
        run.echo(line)
    correlation = correlation_table(document)
    run.console.print(rich_table(correlation))
    run.echo(correlation.note)
    if not is_adequate(comparison):
        run.console.print(rich_table(dependence_table(document["where"][:MOST_COORDINATES])))
    print_warnings(run, comparison)
    run.echo(comparison_statement(comparison))


def print_diagnosis(run: Run, diagnosis: Diagnosis, document: Mapping[str, Any]) -> None:
    """Print a diagnosis; `document` is its own."""
    _print_notes_and_noise(run, diagnosis)
    run.console.print(rich_table(ranking_table(document["ranking"], len(diagnosis.trials))))
    added = f", with {diagnosis.effect}" if diagnosis.effect else ""
    run.console.print(rich_table(parameter_table(document["parameters"], f"Parameters of the model{added}")))
    if document["detectable"] and near_noise(diagnosis):
        run.console.print(rich_table(detectable_table(document["detectable"])))
    print_warnings(run, diagnosis)
    run.echo(_decision_line(diagnosis))
    lines = [
        equivalence_statement(diagnosis),
        next_step_statement(diagnosis),
        *replacement_statements(diagnosis),
        *unphysical_statements(diagnosis),
    ]
    for line in (*lines, *document["not_identifiable"]):
        if line:
            run.echo(line)


def _decision_line(found: Diagnosis) -> str:
    """The decision (`missing`, `adequate` or `unexplained`), a colon, and its statement."""
    statement = diagnosis_statement(found)
    if found.effect:
        return f"missing: {statement.replace(' is missing', '', 1)}"
    return f"adequate: {found.reason}." if found.verdict == "adequate" else f"{found.verdict}: {statement}"


def print_warnings(run: Run, found: Comparison | Diagnosis) -> None:
    """Print the contradictions in the records, above the verdict."""
    for line in found.warnings:
        run.echo(click.style(f"warning: {one_line(line)}", fg="yellow"))


def _print_notes_and_noise(run: Run, found: Comparison | Diagnosis) -> None:
    for note in found.problem.notes:
        run.note(f"note: {note}")
    run.echo(f"noise: {noise_text(found.problem)}")


def print_revision(run: Run, step: Addition, document: Mapping[str, Any]) -> None:
    """Print the errors before and after a revision of the model, and its parameters; `document` is that of `add`."""
    parts = [f"{sign} {', '.join(document[key])}" for sign, key in (("+", "added"), ("-", "removed")) if document[key]]
    title = f"Rung {step.revision.number:03d}: {' '.join(parts)}"
    run.console.print(rich_table(error_table(title, document["before"], document["after"])))
    parameters = document["parameters"]
    run.console.print(rich_table(parameter_table(parameters)))
    for key, (old, new) in step.changed.items():
        unit = parameters.get(public_key(key), {}).get("unit", "")
        run.echo(f"{public_key(key)} changed from {quantity_text(old, unit)} to {quantity_text(new, unit)}")
    run.echo(f"wrote {step.revision.path} and {step.problem.experiment.path}")


def search_progress(
    progress: Progress, afterwards: str = "comparing the candidates"
) -> Callable[[str, int, int], None]:
    """A callback (name, count, total) that counts the steps of a search; then the bar runs on without a total.

    The number of steps after the refits depends on their results, and they take less time than those counted.
    """
    task = progress.add_task("reading, and fitting the model as it stands", total=None)
    began = progress.tasks[-1].start_time

    def restart(text: str, total: int | None) -> None:
        # The total of a bar cannot be removed: a new bar replaces it and takes over its start time.
        nonlocal task
        progress.remove_task(task)
        task = progress.add_task(text, total=total)
        progress.tasks[-1].start_time = began

    def show(name: str, count: int, total: int) -> None:
        if count == total:
            restart(afterwards, None)
            return
        if count == 0:
            restart(name, total)
        progress.update(task, description=name, completed=count)

    return show
