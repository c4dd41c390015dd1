"""`stagecad demo`: identification of hidden effects on packaged records, start to end."""

from pathlib import Path
from time import perf_counter
from typing import Any

import click

from workbench.cli.options import Run, common_options

MOST_ROUNDS = 5
"""Effects added at most; the packaged records need fewer."""


@click.command("demo")
@common_options
def command(run: Run) -> None:
    """Run compare, diagnose and add on packaged records of a slide, until the residual is at the noise level.

    The records are copied to OUT/demo. Every step is the command of that name, which can be repeated by hand.
    A folder OUT/demo that was changed since then, or that this command did not write, is not touched: the records are
    copied to OUT/demo_2.
    """
    from workbench.operations.measurement.demonstration import fresh_demo

    began = perf_counter()
    folder = fresh_demo(run.out / "demo")
    if folder.name != "demo":
        run.echo(f"{run.out / 'demo'} is not as the demonstration left it, and is not touched.")
    run.echo(f"A slide on its bearing way was driven back and forth and its friction force measured. Records: {folder}")
    run.echo("The model contains Coulomb and viscous friction. Is an effect missing?\n")
    document = {"schema": 1, "experiment": str(folder), **_loop(run, folder), "seconds": perf_counter() - began}
    seconds = f"\nDone in {document['seconds']:.0f} s."
    run.echo(f"{seconds} Hidden effects: a Stribeck curve and the cogging of magnetic teeth,")
    run.echo("simulated by a program that shares no law with this one.")
    run.echo(f"figure: {document['figure']}")
    run.echo(f"report: {document['report']}")
    run.emit(document)


def _loop(run: Run, folder: Path) -> dict[str, Any]:
    """Compare, diagnose and add until nothing is missing; suggest, ladder; the documents of all steps."""
    from workbench.cli.console import search_progress, show
    from workbench.operations.measurement.add import add, ladder
    from workbench.operations.measurement.compare import compare
    from workbench.operations.measurement.demonstration import remember
    from workbench.operations.measurement.diagnose import diagnose
    from workbench.operations.measurement.suggest import suggest_after
    from workbench.operations.measurement.tables import parameter_table

    run.echo(f"$ stagecad compare {folder}")
    with run.busy("fitting the model as it stands"):
        comparison = compare(folder)
    run.echo(f"  {comparison.statement}\n")
    comparison.write_report(run.out)
    document: dict[str, Any] = {"compare": comparison.document, "rounds": []}
    last = None
    for _ in range(MOST_ROUNDS):
        run.echo(f"$ stagecad diagnose {folder}")
        with run.progress() as progress:
            diagnosis = diagnose(folder, progress=search_progress(progress))
        tried = f"({len(diagnosis.computed.trials)} effects tried in {diagnosis.computed.seconds:.1f} s)\n"
        show(run, [f"  {line}" for line in (diagnosis.statement, diagnosis.ties, tried) if line])
        diagnosis.write_report(run.out)
        document["rounds"].append({"diagnose": diagnosis.document})
        if diagnosis.effect is None:
            break
        last = diagnosis
        run.echo(f"$ stagecad add {folder} {diagnosis.effect}")
        with run.busy(f"fitting the model with {diagnosis.effect}"):
            addition = add(folder, diagnosis.effect)
        remember(folder)
        added = {name: addition.document[name] for name in ("rung", "effects", "after", "parameters")}
        show(run, [parameter_table(added["parameters"], f"Rung {added['rung']:03d}, fitted again"), ""])
        document["rounds"][-1]["add"] = added
    if last is not None:
        run.echo(f"$ stagecad suggest {folder}")
        # The diagnosis that led to the effect added last is reused: the command would repeat it.
        with run.busy("comparing motions"):
            suggestion = suggest_after(last).write_below(run.out)
        show(run, [*(f"  {line}" for line in suggestion.statements), ""])
        suggestion.write_report(run.out)
        document["suggest"] = suggestion.to_json()
    run.echo(f"$ stagecad ladder {folder}")
    rungs = ladder(folder)
    if not rungs.rungs:
        return {**document, "ladder": [], "figure": None, "report": str(run.out / folder.name / "report.html")}
    show(run, rungs.lines())
    report = rungs.write_report(run.out)
    files = {"figure": str(report.parent / "ladder.png"), "report": str(report)}
    return {**document, "ladder": rungs.to_json(), **files}
