"""`stagecad make`: all results of the parameter file, and one HTML report; results with unchanged inputs are kept."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stagecad.parameters.atomic import atomic_write_text
from workbench.options import Run, common_options

if TYPE_CHECKING:
    from stagecad.parameters.mass_properties import BodyMasses
    from stagecad.solids.artefacts.store import Artefact, ArtefactStore
    from stagecad.solids.assembly.machine import Machine

SIMULATED = ("tip", "presliding", "hysteresis", "stick-slip")
STAMP = "made_from_{name}.json"


@click.command("make")
@click.option("--simulations/--no-simulations", default=True, help="Run the thesis's friction experiments too.")
@click.option("--trust", is_flag=True, help="Consent to run the files of the folder checks as they are now.")
@common_options
def command(run: Run, simulations: bool, trust: bool) -> int:
    """Make everything from the parameter file: parts, assembly, drawings, list of parts, checks, simulations, report.

    Exit status 0 once all is built, whatever the verdicts of the checks.
    """
    from designcalc.checks.analysis.report import counted
    from drawings.procedure.procedure import procedure
    from stagecad.parameters.mass_properties import BodyMasses
    from stagecad.solids.artefacts.store import ArtefactStore
    from stagecad.solids.assembly.bill_of_materials import document as bill_document
    from stagecad.solids.assembly.interference import build_interferences, clashes
    from stagecad.solids.modelling.registry import chosen
    from workbench.commands.check import trust_own_checks
    from workbench.commands.design.declared import WHAT, run_declared
    from workbench.commands.drawings import write_drawings
    from workbench.commands.parts import write_parts
    from workbench.machine.artefacts import built_machine, stored_values, with_repair
    from workbench.machine.declared_machine import declared_machine
    from workbench.machine.margin_studies import evaluated_checks
    from workbench.report.checks import write_check_files
    from workbench.report.machine import MachineResults, write_report

    declaration = declared_machine(run)
    if declaration is not None:
        return run_declared(run, declaration, WHAT, trust)
    design = run.design
    if trust:
        trust_own_checks(run)
    document = write_parts(run, chosen((), design))
    run.echo(f"parts: {len(document['changed'])} of {document['files']} files written")
    store = ArtefactStore()
    machine = built_machine(run, store)
    pictures = with_repair(run, store, lambda: _pictures(run, store, machine))
    with run.busy("interference"):
        interferences = build_interferences(store, machine.parts, design)
    pairs, found = len(interferences), len(clashes(interferences))
    run.echo(f"interference: {found} clashes, {pairs} contacts, fits and near places looked at")
    drawings = write_drawings(run)
    hits = sum(len(sheet["hits"]) for sheet in drawings["sheets"].values())
    run.echo(f"drawings: {len(drawings['changed'])} of {drawings['files']} files written, {hits} lint hits")
    masses = BodyMasses(machine.moving_body, machine.masses["tip"])
    checks = evaluated_checks(run, masses)
    run.echo(f"checks: {counted(checks)}")
    check_figures = with_repair(run, store, lambda: _check_figures(run, store, masses))
    write_check_files(checks, design, masses, run.out / "checks", check_figures)
    figures = _simulate(run) if simulations else []
    bill = machine.bill_of_materials
    steps = procedure(design, bill, stored_values(store, design, masses))
    results = MachineResults(
        parts=document,
        pictures=pictures,
        checks=checks,
        check_figures=check_figures,
        simulation_figures=figures,
        bill=bill_document(bill),
        interferences=interferences,
        procedure=steps,
        drawings=drawings,
    )
    page = write_report(run, results)
    run.echo(f"report: {page}")
    run.emit(
        {
            "parts": document["parts"],
            "moving_body": document["moving_body"],
            "measures": document["measures"],
            "drawings": drawings["sheets"],
            "checks": [check.as_json() for check in checks],
            "report": str(page),
        }
    )
    return 0


def _pictures(run: Run, store: ArtefactStore, machine: Machine) -> dict[str, Path]:
    """Pictures of the parts and of the assembly, by name."""
    from stagecad.solids.artefacts.outputs import write_stored
    from stagecad.solids.assembly.pictures import build_pictures

    with run.progress() as progress:
        task = progress.add_task("pictures", total=len(machine.parts) + 1)
        files = build_pictures(store, machine, lambda name: progress.update(task, advance=1, description=name))
    write_stored(run.out / "pictures", files)
    return {Path(name).stem: run.out / "pictures" / name for name in files}


def _made_files(folder: Path, name: str, inputs: str) -> list[Path]:
    """The files of an experiment that `folder` has from the same inputs; none if one of them is missing."""
    stamp = folder / STAMP.format(name=name)
    if not stamp.is_file():
        return []
    made = json.loads(stamp.read_text("utf-8"))
    files = [folder / file for file in made.get("files", ())]
    return files if made.get("inputs") == inputs and all(file.is_file() for file in files) else []


def _hash(inputs: object) -> str:
    return hashlib.sha256(json.dumps(inputs, sort_keys=True, default=str).encode()).hexdigest()


def _stamp(folder: Path, name: str, inputs: str, files: list[Path]) -> None:
    names = [file.name for file in files]
    text = json.dumps({"inputs": inputs, "files": names}, indent=1) + "\n"
    atomic_write_text(folder / STAMP.format(name=name), text)


def _source_of(*packages: str) -> str:
    """Hash of the source of packages, on which their results depend."""
    from importlib.util import find_spec

    digest = hashlib.sha256()
    for package in packages:
        spec = find_spec(package)
        assert spec is not None and spec.submodule_search_locations is not None
        for place in spec.submodule_search_locations:
            for file in sorted(Path(place).rglob("*.py")):
                digest.update(file.read_bytes())
    return digest.hexdigest()


def _check_figures(run: Run, store: ArtefactStore, masses: BodyMasses) -> dict[str, Path]:
    """The figures of the checks by title; each is drawn again only if a value that it reads has changed."""
    from stagecad.solids.artefacts.outputs import write_stored
    from workbench.report.check_figures import FIGURES

    folder = run.out / "checks"
    files: dict[str, Path] = {}
    entries: dict[str, Artefact] = {}
    for title, (name, draw) in FIGURES.items():
        if title == "map of the magnetic teeth" and not run.design.teeth.fitted:
            continue

        def make(tracked: Any, target: Path, name: str = name, draw: Any = draw) -> None:
            draw(tracked, masses, target / f"{name}.png")

        depends = (repr((masses.moving, masses.tip)),)
        entry = store.make(f"figure {name}", run.design, ("workbench.report.check_figures", __name__), make, depends)
        entries[f"{name}.png"] = entry
        files[title] = folder / f"{name}.png"
    write_stored(folder, entries)
    return files


def _simulate(run: Run) -> list[Path]:
    """Data and figures of the thesis's experiments, each made again if its inputs have changed; the figures, as PNG."""
    from dataclasses import asdict

    from workbench.commands.simulate import simulate_into
    from workbench.simulation.experiments import friction_of, moving_mass, tip_dimensions

    folder = run.out / "simulate"
    source = _source_of("sim")
    friction = [asdict(friction_of(run.design)), moving_mass(run.design, None)]
    files: list[Path] = []
    written = 0
    with run.progress() as progress:
        task = progress.add_task("simulations", total=len(SIMULATED))
        for name in SIMULATED:
            inputs = _hash([name, source, tip_dimensions(run.design) if name == "tip" else friction])
            found = _made_files(folder, name, inputs)
            if not found:
                found = simulate_into(run, folder, (name,))
                _stamp(folder, name, inputs, found)
                written += len(found)
            files += found
            progress.update(task, advance=1, description=name)
    run.echo(f"simulations: {written} files written" if written else "simulations: unchanged")
    return [file for file in files if file.suffix == ".png"]
