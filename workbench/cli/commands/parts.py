"""`stagecad parts`: STEP, STL and GLB of parts and assembly, bill of materials, mass properties."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from workbench.cli.options import Run, common_options

if TYPE_CHECKING:
    from stagecad.friction_stage.assembly.machine import Machine
    from stagecad.parameters.mass_properties import MassProperties

MANIFEST = "parts_manifest.json"
BILL = "bill_of_materials"


@click.command("parts")
@click.argument("names", metavar="[NAME]...", nargs=-1)
@click.option("--trust", is_flag=True, help="Consent to run the files of a machine of your own as they are now.")
@common_options
def command(run: Run, names: tuple[str, ...], trust: bool) -> int:
    """Write STEP, STL and GLB of the parts and the assembly, or of those NAMEd only, and print their mass."""
    from stagecad.solids.modelling.registry import chosen
    from workbench.cli.commands.declared import run_declared
    from workbench.machine.declared_machine import declared_machine

    declaration = declared_machine(run)
    if declaration is not None:
        return run_declared(run, declaration, ("parts",), trust, refused=names)
    wanted = chosen(names, run.design.values)
    document = write_parts(run, wanted)
    _tell(run, document)
    run.emit({"parts": document["parts"], "moving_body": document["moving_body"], "measures": document["measures"]})
    return 0


def write_parts(run: Run, wanted: tuple[str, ...]) -> dict[str, Any]:
    """Make what is missing, write the files of `wanted` that differ, and return the document of the command."""
    from stagecad.solids.artefacts.store import ArtefactStore
    from workbench.machine.artefacts import built_machine, with_repair

    store = ArtefactStore()
    return with_repair(run, store, lambda: _write(run, built_machine(run, store), wanted))


def _write(run: Run, machine: Machine, wanted: tuple[str, ...]) -> dict[str, Any]:
    import json

    from stagecad.friction_stage.assembly.accessories import accessories
    from stagecad.solids.artefacts.outputs import write_manifest, write_stored, write_text
    from stagecad.solids.assembly.bill_of_materials import csv_text
    from stagecad.solids.assembly.bill_of_materials import document as bill_document
    from stagecad.solids.modelling.registry import ASSEMBLY

    files: dict[str, Any] = {}
    parts: dict[str, Any] = {}
    for name in wanted:
        made = machine.assembly if name == ASSEMBLY else machine.parts[name]
        files.update(dict.fromkeys(made.files, made.entry))
        mass = machine.whole if name == ASSEMBLY else machine.masses[name]
        parts[name] = {**mass.as_json(), "files": [str(run.out / file) for file in made.files]}
    changed = write_stored(run.out, files)
    hashes = {name: entry.hashes[name] for name, entry in files.items()}
    if ASSEMBLY in wanted:
        rows = machine.bill_of_materials
        texts = {
            f"{BILL}.csv": csv_text(rows, accessories(run.design.values)),
            f"{BILL}.json": json.dumps(bill_document(rows), indent=1) + "\n",
        }
        from stagecad.solids.artefacts.store import sha256

        for name, text in texts.items():
            if write_text(run.out / name, text):
                changed.append(name)
            hashes[name] = sha256(text.encode("utf-8"))
        parts[ASSEMBLY]["files"] += [str(run.out / name) for name in texts]
    write_manifest(run.out / MANIFEST, hashes)
    moving: MassProperties = machine.moving_body
    return {
        "parts": parts,
        "moving_body": moving.as_json(),
        "measures": measures_json(machine),
        "changed": changed,
        "files": len(hashes),
    }


def measures_json(machine: Machine) -> dict[str, Any]:
    """Dimensions measured on the built parts, SI."""
    from dataclasses import asdict

    units = {"pad_area": "m^2"}
    return {name: {"value": value, "unit": units.get(name, "m")} for name, value in asdict(machine.measures).items()}


def _tell(run: Run, document: dict[str, Any]) -> None:
    """A line for each part: mass, volume, size."""
    if run.json_target is not None:
        return
    width = max(len(name) for name in document["parts"])
    run.echo(f"{'part':{width}}  {'mass':>10}  {'volume':>12}  size")
    for name, part in document["parts"].items():
        low, high = part["bounding_box"]["value"]
        size = " x ".join(f"{1000 * (b - a):.1f}" for a, b in zip(low, high, strict=True))
        mass, volume = part["mass"]["value"], part["volume"]["value"] * 1e6
        shown = f"{mass:8.3f} kg" if mass >= 1.0 else f"{1000 * mass:8.2f} g "
        run.echo(f"{name:{width}}  {shown:>10}  {volume:8.2f} cm^3  {size} mm")
    moving = document["moving_body"]["mass"]["value"]
    run.echo(
        f"moving body {moving:.3f} kg; {len(document['changed'])} of {document['files']} files written to {run.out}"
    )
