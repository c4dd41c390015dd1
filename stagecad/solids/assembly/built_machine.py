"""The machine as solids: built parts and assembly, with mass properties and measured dimensions.

If the cache has all of it, no solid is loaded, and the CAD kernel is not imported.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from stagecad.parameters.errors import InputError
from stagecad.parameters.machine import packaged_machine
from stagecad.parameters.mass_properties import Masses, MassProperties, combined
from stagecad.parameters.rules import absent_tables
from stagecad.solids.artefacts.part import BuiltPart, build_part, find_part, in_processes, kernel_errors, part_mass
from stagecad.solids.artefacts.store import FILE, Artefact, ArtefactStore
from stagecad.solids.assembly.bill_of_materials import Row, bill_of_materials
from stagecad.solids.export.mesh import Mesh, glb_bytes, mesh_of, stl_bytes
from stagecad.solids.export.step import step_bytes
from stagecad.solids.modelling.frame import PlacedShape
from stagecad.solids.modelling.kernel import cq
from stagecad.solids.modelling.mass import placed
from stagecad.solids.modelling.part import ASSEMBLY, Instance, Position, construction, packaged, part_names, part_source

EXPLODED = f"{ASSEMBLY}_exploded"


@dataclass(frozen=True)
class BuiltAssembly:
    """The whole machine at the middle of its travel and height adjustment."""

    entry: Artefact

    @cached_property
    def instances(self) -> tuple[Instance, ...]:
        return self.entry.object()

    @property
    def files(self) -> tuple[str, ...]:
        return (*(f"{ASSEMBLY}.{kind}" for kind in ("step", "stl", "glb")), f"{EXPLODED}.glb")


def find_assembly(store: ArtefactStore, parts: Mapping[str, BuiltPart], design: Any) -> BuiltAssembly | None:
    """The assembly from the cache, or None."""
    entry = store.find(ASSEMBLY, design, _modules(design), contents_of(parts, design))
    return BuiltAssembly(entry) if entry is not None else None


def build_assembly(store: ArtefactStore, parts: Mapping[str, BuiltPart], design: Any) -> BuiltAssembly:
    """The assembly of `parts` (all parts of the design), from the cache or built now."""

    @kernel_errors(ASSEMBLY, design)
    def make(tracked: Any, folder: Path) -> None:
        instances = assemble(parts, tracked)
        (folder / FILE).write_bytes(pickle.dumps(instances))
        shapes = shapes_of(instances, parts, tracked)
        meshes = meshes_of(instances, parts, shapes)
        placed = placed_shapes(instances, parts)
        wrapped = {name: shape.wrapped for name, shape in shapes.items()}
        (folder / f"{ASSEMBLY}.step").write_bytes(step_bytes(ASSEMBLY, placed, wrapped))
        (folder / f"{ASSEMBLY}.glb").write_bytes(glb_bytes(ASSEMBLY, placed, meshes))
        exploded = placed_shapes(instances, parts, exploded=True)
        (folder / f"{EXPLODED}.glb").write_bytes(glb_bytes(EXPLODED, exploded, meshes))
        moved = [meshes[shape.part].placed(shape.frame) for shape in placed]
        (folder / f"{ASSEMBLY}.stl").write_bytes(stl_bytes(moved))

    return BuiltAssembly(store.make(ASSEMBLY, design, _modules(design), make, contents_of(parts, design)))


def assemble(parts: Mapping[str, BuiltPart], design: Any, position: Position = (0.0, 0.0)) -> tuple[Instance, ...]:
    """All instances of the parts of a machine, at a position of travel and height adjustment."""
    return construction(design).assemble(parts, design, position)


def _modules(design: Any) -> tuple[str, ...]:
    return (__name__, *construction(design).modules)


def contents_of(parts: Mapping[str, BuiltPart], design: Any) -> list[str]:
    """What an artefact of all parts depends on besides the parameters."""
    return [*(part.entry.content for part in parts.values()), *construction(design).depends(design)]


def placed_shapes(
    instances: Sequence[Instance], parts: Mapping[str, BuiltPart], *, exploded: bool = False
) -> list[PlacedShape]:
    """The instances as shapes with position and colour, for export and pictures."""
    frames = [(i, i.exploded if exploded else i.frame) for i in instances]
    return [PlacedShape(i.name, i.shape, parts[i.part].colour, frame) for i, frame in frames]


def shapes_of(instances: Sequence[Instance], parts: Mapping[str, BuiltPart], design: Any) -> dict[str, cq.Shape]:
    """The exact solid of each `Instance.shape`: that of the part, or a spring at its length in the assembly."""
    shapes: dict[str, cq.Shape] = {}
    for instance in instances:
        if instance.shape not in shapes:
            part = instance.part
            if instance.shape == part:
                shapes[part] = parts[part].solid
            else:
                spring: Any = part_source(part, design).definition()
                shapes[instance.shape] = spring.build(design, instance.compression)
    return shapes


def meshes_of(
    instances: Sequence[Instance], parts: Mapping[str, BuiltPart], shapes: Mapping[str, cq.Shape]
) -> dict[str, Mesh]:
    """The mesh of each `Instance.shape`; `shapes` is needed only for springs off their installed length."""
    meshes: dict[str, Mesh] = {}
    for instance in instances:
        name = instance.shape
        if name not in meshes:
            own = name == instance.part
            meshes[name] = parts[name].mesh if own else mesh_of(shapes[name], shapes[name].Volume())
    return meshes


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
        build_assembly(store, {part: build_part(store, part, design) for part in part_names(design)}, design)
    else:
        build_part(store, name, design)


def body_masses(design: Any) -> Masses:
    """Mass properties that checks and simulation of a machine read, SI; its parts are from the cache or made now."""
    return construction(design).masses(design)


def packaged_masses(design: Any) -> Any:
    """Mass properties of the packaged machine with a design's values, whose driven stage is simulated; SI.

    Errors: a machine of the user's own without this stage is refused."""
    if "stage." in absent_tables(design.machine):
        raise InputError(f'{design.file}: its [machine] has no part "stage" of the packaged machine; state a mass')
    return packaged().masses(replace(design, machine=packaged_machine()))
