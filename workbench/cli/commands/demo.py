"""`stagecad demo`: identification of hidden effects on packaged records, start to end."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterator
from importlib.resources import as_file, files
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from stagecad.parameters.atomic import atomic_write_bytes, atomic_write_text
from workbench.cli.options import Run, common_options

if TYPE_CHECKING:
    from sysid.diagnose import Diagnosis

MOST_ROUNDS = 5
"""Effects added at most; the packaged records need fewer."""
STATE = ".demo.json"
"""File in a folder of the demonstration: the hash of each file of the experiment as the demonstration left it."""


@click.command("demo")
@common_options
def command(run: Run) -> None:
    """Run compare, diagnose and add on packaged records of a slide, until the residual is at the noise level.

    The records are copied to OUT/demo. Every step is the command of that name, which can be repeated by hand.
    A folder OUT/demo that was changed since then, or that this command did not write, is not touched: the records are
    copied to OUT/demo_2.
    """
    began = perf_counter()
    folder = fresh_copy(free_folder(run.out / "demo"))
    echo = run.echo
    if folder.name != "demo":
        echo(f"{run.out / 'demo'} is not as the demonstration left it, and is not touched.")
    echo(f"A slide on its bearing way was driven back and forth and its friction force measured. Records: {folder}")
    echo("The model contains Coulomb and viscous friction. Is an effect missing?\n")
    document: dict[str, Any] = {"schema": 1, "experiment": str(folder), "compare": _compare(run, folder), "rounds": []}
    last = None
    for _ in range(MOST_ROUNDS):
        found, diagnosis = _diagnose(run, folder)
        document["rounds"].append({"diagnose": diagnosis})
        if found.effect is None:
            break
        last = found
        document["rounds"][-1]["add"] = _add(run, folder, found.effect)
    if last is not None:
        document["suggest"] = _suggest(run, folder, last)
    document.update(_ladder(run, folder))
    document["seconds"] = perf_counter() - began
    echo(f"\nDone in {document['seconds']:.0f} s. Hidden effects: a Stribeck curve and the cogging of magnetic teeth,")
    echo("simulated by a program that shares no law with this one.")
    echo(f"figure: {document['figure']}")
    echo(f"report: {document['report']}")
    run.emit(document)


def free_folder(folder: Path) -> Path:
    """`folder`, or the first of FOLDER_2, FOLDER_3, ... that does not exist or is as a demonstration left it."""
    number, found = 1, folder
    while (found.exists() or found.is_symlink()) and not _as_left(found):
        number += 1
        found = folder.with_name(f"{folder.name}_{number}")
    return found


def fresh_copy(folder: Path) -> Path:
    """The packaged experiment in its initial state in `folder`, which is new or one that `free_folder` has found."""
    for left_over in ("ladder", "sections"):
        if (folder / left_over).is_dir():
            shutil.rmtree(folder / left_over)
    with as_file(files("workbench") / "demo_records") as packaged:
        for path in sorted(packaged.iterdir()):
            if path.suffix in (".toml", ".csv"):
                atomic_write_bytes(folder / path.name, path.read_bytes())
    remember(folder)
    return folder


def remember(folder: Path) -> None:
    """Store the state of the experiment in `folder`, by which the next demonstration recognises an unchanged folder."""
    atomic_write_text(folder / STATE, json.dumps(dict(_hashes(folder)), indent=1) + "\n")


def _as_left(folder: Path) -> bool:
    try:
        return not folder.is_symlink() and json.loads((folder / STATE).read_text("utf-8")) == dict(_hashes(folder))
    except (OSError, ValueError):
        return False


def _hashes(folder: Path) -> Iterator[tuple[str, str]]:
    """Name and hash of each file of the experiment; reports and figures can be made again and do not count."""
    beside = [path for path in folder.iterdir() if path.suffix in (".toml", ".csv", ".parquet", ".mat", ".py")]
    for path in sorted(path for path in (*beside, *(folder / "ladder").rglob("*")) if path.is_file()):
        yield path.relative_to(folder).as_posix(), hashlib.sha256(path.read_bytes()).hexdigest()


def _compare(run: Run, folder: Path) -> dict[str, Any]:
    from sysid.compare import compare
    from sysid.report import comparison_json
    from workbench.identification.statements import comparison_statement
    from workbench.report.page import write_comparison

    run.echo(f"$ stagecad compare {folder}")
    with run.busy("fitting the model as it stands"):
        found = compare(folder)
    document = comparison_json(found)
    run.echo(f"  {comparison_statement(found)}\n")
    write_comparison(run, found, document)
    return document


def _diagnose(run: Run, folder: Path) -> tuple[Diagnosis, dict[str, Any]]:
    from sysid.diagnose import diagnose
    from sysid.report import diagnosis_json
    from workbench.console.identification import search_progress
    from workbench.identification.statements import diagnosis_statement, equivalence_statement
    from workbench.report.page import write_diagnosis

    run.echo(f"$ stagecad diagnose {folder}")
    with run.progress() as progress:
        found = diagnose(folder, progress=search_progress(progress))
    document = diagnosis_json(found)
    run.echo(f"  {diagnosis_statement(found)}")
    if found.indistinguishable:
        run.echo(f"  {equivalence_statement(found)}")
    run.echo(f"  ({len(found.trials)} effects tried in {found.seconds:.1f} s)\n")
    write_diagnosis(run, found, document)
    return found, document


def _add(run: Run, folder: Path, effect: str) -> dict[str, Any]:
    from sysid.ladder import add_effects
    from sysid.report import both_json
    from workbench.console.tables import rich_table
    from workbench.identification.tables import parameter_table

    run.echo(f"$ stagecad add {folder} {effect}")
    with run.busy(f"fitting the model with {effect}"):
        step = add_effects(folder, [effect])
    remember(folder)
    parameters = dict(step.revision.document["parameters"])
    run.console.print(rich_table(parameter_table(parameters, f"Rung {step.revision.number:03d}, fitted again")))
    run.echo("")
    return {
        "rung": step.revision.number,
        "effects": list(step.revision.effects),
        "after": both_json(step.problem, step.after_fit, step.after_validate),
        "parameters": parameters,
    }


def _suggest(run: Run, folder: Path, last: Diagnosis) -> list[dict[str, Any]]:
    from sysid.experiment_design.t_optimal_design import motions_for, rank_motions
    from workbench.identification.statements import suggestion_statements
    from workbench.report.page import write_motions, write_suggestion

    run.echo(f"$ stagecad suggest {folder}")
    # The diagnosis that led to the effect added last is reused: the command would repeat it.
    with run.busy("comparing motions"):
        found = rank_motions(last, motions_for(last.problem), last.effect)
    motions = write_motions(run, found)
    for line in suggestion_statements(found):
        run.echo(f"  {line}")
    run.echo("")
    write_suggestion(run, found, motions)
    return motions


def _ladder(run: Run, folder: Path) -> dict[str, Any]:
    from sysid.experiment.experiment import load_experiment
    from sysid.ladder import current_ladder
    from workbench.console.tables import rich_table
    from workbench.identification.tables import ladder_table
    from workbench.report.page import write_ladder

    run.echo(f"$ stagecad ladder {folder}")
    rungs, _ = current_ladder(load_experiment(folder))
    if not rungs:
        return {"ladder": [], "figure": None, "report": str(run.out / folder.name / "report.html")}
    run.console.print(rich_table(ladder_table(rungs)))
    report = write_ladder(run, folder.name, rungs)
    return {"ladder": rungs, "figure": str(report.parent / "ladder.png"), "report": str(report)}
