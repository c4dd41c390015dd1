"""The machine as solids: built parts and assembly, with mass properties and measured dimensions.

If the cache has all of it, no solid is loaded, and the CAD kernel is not imported.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from stagecad.friction_stage.assembly.assemble import Instance
from stagecad.parameters.dimension import Datum
from stagecad.parameters.mass_properties import BodyMasses, MassProperties, combined
from stagecad.solids.artefacts.part import BuiltPart, build_part, build_parts, find_part, in_processes, kernel_errors
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.bill_of_materials import Row, bill_of_materials
from stagecad.solids.assembly.built_assembly import BuiltAssembly, build_assembly, find_assembly
from stagecad.solids.modelling.frame import UNMOVED, mate, subtract
from stagecad.solids.modelling.mass import MM, density_of, mass_properties, placed
from stagecad.solids.modelling.registry import ASSEMBLY, part_names

MOVING = ("stage", "tooth_iron", "magnet")
CARRIED = (*MOVING, "mirror")
"""Parts that move with the stage; the mirror is counted in the mass of the payload."""


@dataclass(frozen=True)
class Measures:
    """Dimensions for checks and simulation, measured on the built parts; SI.

    Attributes:
        pad_area: of all pads together, m^2.
        piezo_spacing: D, between the seats of piezos 1 and 2 in the tip, m.
        tip_height: h, from those seats to the apex, m.
        bolt_spacing: between the first two screws of a way, m.
        way_length, way_width, way_height: of the rail's box, m.
    """

    pad_area: float
    piezo_spacing: float
    tip_height: float
    bolt_spacing: float
    way_length: float
    way_width: float
    way_height: float


@dataclass(frozen=True)
class Machine:
    """Parts and assembly of one design."""

    design: Any
    parts: dict[str, BuiltPart]
    assembly: BuiltAssembly

    @cached_property
    def masses(self) -> dict[str, MassProperties]:
        """Mass properties of each part, in its own coordinates."""
        return {name: part_mass(part, self.design) for name, part in self.parts.items()}

    @cached_property
    def moving_body(self) -> MassProperties:
        """Stage with irons and magnets, in the assembly's coordinates at mid-travel."""
        return self._together([piece for piece in self.assembly.instances if piece.part in MOVING])

    @cached_property
    def whole(self) -> MassProperties:
        """All parts together, in the assembly's coordinates."""
        return self._together(self.assembly.instances)

    def _together(self, instances: Sequence[Instance]) -> MassProperties:
        return combined(placed(self.masses[instance.part], instance.frame) for instance in instances)

    @cached_property
    def measures(self) -> Measures:
        tip, way = self.parts["tip"].datums, self.parts["bearing_way"]
        one, two = way.datums["way_screw_1"].origin, way.datums["way_screw_2"].origin
        low, high = way.geometry.bounding_box
        return Measures(
            pad_area=math.fsum(self.parts["stage"].face_areas.values()) * MM**2,
            piezo_spacing=math.dist(tip["piezo_1"].origin, tip["piezo_2"].origin) * MM,
            tip_height=subtract(tip["apex"].origin, tip["piezo_1"].origin)[2] * MM,
            bolt_spacing=math.dist(one, two) * MM,
            way_length=(high[0] - low[0]) * MM,
            way_width=(high[1] - low[1]) * MM,
            way_height=(high[2] - low[2]) * MM,
        )

    @cached_property
    def bill_of_materials(self) -> tuple[Row, ...]:
        return bill_of_materials(self.assembly.instances, self.parts, self.masses, self.design)


def part_mass(part: BuiltPart, design: Any) -> MassProperties:
    """Mass properties of a part in its own coordinates."""
    return mass_properties(part.geometry, density_of(design, part.material))


def find_machine(design: Any, store: ArtefactStore | None = None) -> Machine | None:
    """The machine if the cache has all of it, else None; does not import the CAD kernel."""
    store = store or ArtefactStore()
    parts: dict[str, BuiltPart] = {}
    for name in part_names(design):
        part = find_part(store, name, design)
        if part is None:
            return None
        parts[name] = part
    assembly = find_assembly(store, parts, design)
    return Machine(design, parts, assembly) if assembly is not None else None


def build_machine(
    design: Any, store: ArtefactStore | None = None, advance: Callable[[str], None] = lambda name: None
) -> Machine:
    """The machine; parts and assembly are built, in other processes, if the cache lacks them.

    Args:
        design: the design.
        store: the cache; the user's own when left out.
        advance: called with the name of each finished part, and finally of the assembly.

    Raises:
        PartError: the CAD kernel makes no valid solid of a part, or ends its process.
    """
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
    return Machine(design, parts, build_assembly(store, parts, design))


def _build(folder: Path, design: Any, name: str) -> None:
    store = ArtefactStore(folder)
    if name == ASSEMBLY:
        parts = {part: build_part(store, part, design) for part in part_names(design)}
        with kernel_errors(ASSEMBLY, design):
            build_assembly(store, parts, design)
    else:
        build_part(store, name, design)


def body_masses(design: Any) -> BodyMasses:
    """Mass properties of the moving body (stage with irons and magnets, at mid-travel) and of the tip, SI.

    Only the solids of these parts are needed; they come from the cache or are made now. The positions of irons and
    magnets follow from the stage's own datums, so that the result equals that of the whole assembly.
    """
    riders = ("tooth_iron", "magnet") if design.teeth.fitted else ()
    store = ArtefactStore()
    parts = build_parts(store, ("stage", "tip", *riders), design)
    plane = Datum("pads", (0.0, 0.0, design.bearing_way.height), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    stage = parts["stage"]
    frame = mate(stage.datums["pads"], UNMOVED, plane)
    bodies = [placed(part_mass(stage, design), frame)]
    for rider in riders:
        mass = part_mass(parts[rider], design)
        for name, seat in stage.datums.items():
            if name.rpartition("_")[0] == rider:
                bodies.append(placed(mass, mate(parts[rider].datums["seat"], frame, seat)))
    return BodyMasses(combined(bodies), part_mass(parts["tip"], design))
