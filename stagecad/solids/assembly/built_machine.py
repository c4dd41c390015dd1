"""The machine as solids: built parts and assembly, with mass properties and measured dimensions.

If the cache has all of it, no solid is loaded, and the CAD kernel is not imported.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from stagecad.parameters.machine import packaged_machine
from stagecad.parameters.mass_properties import Masses, MassProperties, combined
from stagecad.solids.artefacts.part import BuiltPart, build_part, find_part, in_processes, kernel_errors, part_mass
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.bill_of_materials import Row, bill_of_materials
from stagecad.solids.assembly.built_assembly import BuiltAssembly, build_assembly, find_assembly
from stagecad.solids.modelling.instance import Instance
from stagecad.solids.modelling.mass import placed
from stagecad.solids.modelling.registry import ASSEMBLY, construction, packaged, part_names


@dataclass(frozen=True)
class BuiltMachine:
    """Parts and assembly of one design."""

    design: Any
    parts: dict[str, BuiltPart]
    assembly: BuiltAssembly

    @cached_property
    def masses(self) -> dict[str, MassProperties]:
        """Mass properties of each part, in its own coordinates."""
        return {name: part_mass(part, self.design) for name, part in self.parts.items()}

    @cached_property
    def moving_body(self) -> MassProperties | None:
        """The parts that move, in the assembly's coordinates at rest; None where none does."""
        moving = construction(self.design).moving
        pieces = [piece for piece in self.assembly.instances if piece.part in moving]
        return self._together(pieces) if pieces else None

    @cached_property
    def whole(self) -> MassProperties:
        """All parts together, in the assembly's coordinates."""
        return self._together(self.assembly.instances)

    def _together(self, instances: Sequence[Instance]) -> MassProperties:
        return combined(placed(self.masses[instance.part], instance.frame) for instance in instances)

    @cached_property
    def checked_masses(self) -> Masses:
        """Mass properties that checks and simulation read."""
        return construction(self.design).machine_masses(self)

    @cached_property
    def bill_of_materials(self) -> tuple[Row, ...]:
        return bill_of_materials(self.assembly.instances, self.parts, self.masses, self.design)


def find_machine(design: Any, store: ArtefactStore | None = None) -> BuiltMachine | None:
    """The machine if the cache has all of it, else None; does not import the CAD kernel."""
    store = store or ArtefactStore()
    parts: dict[str, BuiltPart] = {}
    for name in part_names(design):
        part = find_part(store, name, design)
        if part is None:
            return None
        parts[name] = part
    assembly = find_assembly(store, parts, design)
    return BuiltMachine(design, parts, assembly) if assembly is not None else None


def build_machine(
    design: Any, store: ArtefactStore | None = None, advance: Callable[[str], None] = lambda name: None
) -> BuiltMachine:
    """The machine; parts and assembly are built, in other processes, if the cache lacks them."""
    store = store or ArtefactStore()
    found = {name: find_part(store, name, design) for name in part_names(design)}
    present = {name: part for name, part in found.items() if part is not None}
    for name in present:
        advance(name)
    missing = [name for name in found if name not in present]
    if missing or find_assembly(store, present, design) is None:
        # In the same processes: each needs seconds to load the kernel.
        run = partial(_build, store.folder, design)
        in_processes(run, [*missing, ASSEMBLY], design, advance, requires={ASSEMBLY: missing})
    else:
        advance(ASSEMBLY)
    parts = {name: present.get(name) or build_part(store, name, design) for name in found}
    return BuiltMachine(design, parts, build_assembly(store, parts, design))


def _build(folder: Path, design: Any, name: str) -> None:
    store = ArtefactStore(folder)
    if name == ASSEMBLY:
        parts = {part: build_part(store, part, design) for part in part_names(design)}
        with kernel_errors(ASSEMBLY, design):
            build_assembly(store, parts, design)
    else:
        build_part(store, name, design)


def body_masses(design: Any) -> Masses:
    """Mass properties that checks and simulation of a machine read, SI; its parts are from the cache or made now."""
    return construction(design).masses(design)


def packaged_masses(design: Any) -> Any:
    """Mass properties of the packaged machine with a design's values, whose driven stage is simulated; SI."""
    return packaged().masses(replace(design, machine=packaged_machine()))
