"""Machines that a parameter file declares (`[machine]`): built from packaged parts and parts of the user's own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError
from workbench.cli.options import Run
from workbench.machine.own_part import OwnPart, built_solid, called, draw_part, load_part, own_design

if TYPE_CHECKING:
    from designcalc.checks.check import Check
    from stagecad.parameters.design import Design
    from stagecad.solids.assembly.declared import DeclaredMachine, DeclaredSolid
    from stagecad.solids.assembly.machine_declaration import DeclaredPart, MachineDeclaration


@dataclass(frozen=True)
class BuiltMachine:
    """A declared machine with the parts of the user's own, and the design of each packaged part, by key."""

    machine: DeclaredMachine
    own: dict[str, OwnPart]
    designs: dict[str, Design]


def declared_machine(run: Run) -> MachineDeclaration | None:
    """The machine that the run's parameter file declares; None for that of the thesis."""
    from stagecad.parameters.file import read_parameter_file
    from stagecad.solids.assembly.machine_declaration import read_machine

    path = run.design.path
    if path is None:
        return None
    file = read_parameter_file(path)
    return None if file.machine is None else read_machine(file.machine, file.name, run.design.values)


def build(
    run: Run, declaration: MachineDeclaration, trust: bool, advance: Callable[[str], None] = lambda name: None
) -> BuiltMachine:
    """Build every part and put the machine together.

    Raises:
        InputError: no consent to a file, an error of a file, or a datum that a part does not have.
    """
    from stagecad.solids.assembly.declared import DeclaredMachine, put_together

    assert run.design.path is not None
    folder = run.design.path.parent
    solids: dict[str, DeclaredSolid] = {}
    own: dict[str, OwnPart] = {}
    designs: dict[str, Design] = {}
    for part in declaration.parts:
        advance(part.key)
        if part.file:
            own[part.key] = _own(run.design.values, part, folder, trust)
            solids[part.key] = _own_solid(own[part.key], part)
        else:
            designs[part.key] = run.design.values_with(*(f"{key}={text}" for key, text in part.parameters.items()))
            solids[part.key] = _packaged_solid(designs[part.key], part, str(run.design.path))
    datums = {key: solid.datums for key, solid in solids.items()}
    instances = put_together(declaration, datums, str(run.design.path))
    return BuiltMachine(DeclaredMachine(declaration, solids, instances), own, designs)


def _own(design: Design, part: DeclaredPart, folder: Path, trust: bool) -> OwnPart:
    loaded = load_part(folder / part.file, design, trust)
    declared = loaded.module.PARAMETERS
    for key in part.parameters:
        if key not in declared:
            raise InputError(f"machine.parts.{part.key}.parameters: {part.file} has no '{key}': {', '.join(declared)}")
    values = {**declared, **part.parameters}
    return replace(loaded, design=own_design(design, loaded.name, values, loaded.path))


def _own_solid(own: OwnPart, part: DeclaredPart) -> DeclaredSolid:
    from stagecad.solids.assembly.declared import DeclaredSolid
    from stagecad.solids.export.mesh import mesh_of
    from stagecad.solids.modelling.mass import geometry_of

    solid, material = built_solid(own)
    geometry = geometry_of(solid)
    first = (own.module.__doc__ or own.name).strip().splitlines()[0]
    return DeclaredSolid(
        key=part.key,
        solid=solid,
        mesh=mesh_of(solid, geometry.volume),
        geometry=geometry,
        datums=called(own, "datums") if hasattr(own.module, "datums") else {},
        material=material,
        density=own.design.materials[material].density,
        designation=own.design.materials[material].description,
        description=part.description or first.partition(":")[2].strip().rstrip(".") or first,
        part_number=getattr(own.module, "PART_NUMBER", ""),
        purchased=hasattr(own.module, "PART_NUMBER"),
    )


def _packaged_solid(design: Design, part: DeclaredPart, file: str) -> DeclaredSolid:
    from stagecad.parameters.errors import nearest
    from stagecad.solids.artefacts.part import build_part
    from stagecad.solids.artefacts.store import ArtefactStore
    from stagecad.solids.assembly.declared import DeclaredSolid
    from stagecad.solids.modelling.registry import PURCHASED, part_names

    known = part_names(design)
    if part.part not in known:
        raise InputError(f"{file}: machine.parts.{part.key}: no packaged part '{part.part}'{nearest(part.part, known)}")
    built = build_part(ArtefactStore(), part.part, design)
    material = design.materials[built.material]
    return DeclaredSolid(
        key=part.key,
        solid=built.solid,
        mesh=built.mesh,
        geometry=built.geometry,
        datums=built.datums,
        material=built.material,
        density=material.density,
        designation=material.description,
        description=part.description or built.description,
        part_number=built.part_number,
        purchased=part.part in PURCHASED,
    )


def draw(built: BuiltMachine, folder: Path) -> list[dict[str, Any]]:
    """Draw the sheets of every part that is made; returns the documents of the sheets."""
    from drawings.artefacts.names import chosen_sheets
    from drawings.artefacts.tasks import build_all_sheets
    from stagecad.solids.artefacts.outputs import write_stored
    from stagecad.solids.artefacts.store import ArtefactStore
    from workbench.operations.drawings import procedure_values

    sheets: list[dict[str, Any]] = []
    for part in built.machine.declaration.parts:
        if built.machine.parts[part.key].purchased:
            continue
        # One file, or one packaged part, may serve for parts of several sizes.
        name = built.own[part.key].name if part.file else part.part
        target = folder if part.key == name else folder / part.key
        if part.file:
            document = draw_part(built.own[part.key], target)
            sheets += [{"part": part.key, **sheet} for sheet in document["sheets"]]
            continue
        design, store = built.designs[part.key], ArtefactStore()
        made = build_all_sheets(store, chosen_sheets((part.part,), design), design, calculate=procedure_values)
        for sheet in made[part.part]:
            write_stored(target, dict.fromkeys(sheet.files, sheet.artefact))
            files = [str(target / file) for file in sheet.files]
            sheets.append({"part": part.key, "name": sheet.name, "files": files, "hits": list(sheet.hits)})
    return sheets


def checks(run: Run, built: BuiltMachine) -> list[Check]:
    """The user's own checks; they may read parameters and mass of each part, `carriage.length` and `carriage.mass`,
    and the mass of the whole, `machine.mass`."""
    from designcalc.checks.run import OWN, run_checks
    from stagecad.parameters.file import Entry

    design, machine = run.design.values, built.machine
    entries = list(design.entries)
    for key, own in built.own.items():
        prefix = f"{own.name}."
        entries += [
            replace(entry, key=f"{key}.{entry.key.removeprefix(prefix)}")
            for entry in own.design.entries
            if entry.key.startswith(prefix)
        ]
    masses = {**{key: solid.mass.mass for key, solid in machine.parts.items()}, "machine": machine.whole.mass}
    for key, mass in masses.items():
        entries.append(Entry(f"{key}.mass", f"{mass:.6g} kg", mass, "kg", None, "measured from the solids", "mass"))
    return run_checks(replace(design, entries=tuple(entries)), subjects=tuple({subject for subject, _ in OWN.values()}))
