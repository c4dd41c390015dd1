"""`stagecad demo`: identification of hidden effects on packaged records, start to end."""

from time import perf_counter

import click

from workbench.cli.options import Run, common_options, without_effect


@click.command("demo")
@without_effect("params", "overrides")
@common_options
def command(run: Run) -> None:
    """Run compare, diagnose and add on packaged records of a slide, until the residual is at the noise level.

    The records are copied to OUT/demo. Every step is the command of that name, which can be repeated by hand.
    A folder OUT/demo that was changed since then, or that this command did not write, is not touched: the records are
    copied to OUT/demo_2.
    """
    from workbench.cli.console import search_progress, show
    from workbench.operations.measurement.demonstration import Demonstration
    from workbench.operations.templates import fresh_demo

    began = perf_counter()
    folder = fresh_demo(run.out / "demo")
    if folder.name != "demo":
        run.echo(f"{run.out / 'demo'} is not as the demonstration left it, and is not touched.")
    run.echo(f"A slide on its bearing way was driven back and forth and its friction force measured. Records: {folder}")
    run.echo("The model contains Coulomb and viscous friction. Is an effect missing?\n")
    demonstration = Demonstration(folder, run.out)
    for words, step in demonstration.steps():
        run.echo(f"$ stagecad {words}")
        with run.progress() as progress:
            lines = step(search_progress(progress))
        show(run, lines)
    document = {**demonstration.document, "seconds": perf_counter() - began}
    run.echo(
        f"\nDone in {document['seconds']:.0f} s. Hidden effects: a Stribeck curve and the cogging of magnetic teeth, "
        "simulated by a program that shares no law with this one."
    )
    run.echo(f"figure: {document['figure']}")
    run.echo(f"report: {document['report']}")
    run.emit(document)
