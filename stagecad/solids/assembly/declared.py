"""A machine of the user's own (`[machine]`): its parts put together, exported, weighed and checked for interference."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.friction_stage.assembly.assemble import Instance, count
from stagecad.parameters.dimension import Datum
from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.mass_properties import MassProperties, combined
from stagecad.solids.assembly.bill_of_materials import Row
from stagecad.solids.assembly.interference import CLASH, CONTACT, TOUCH
from stagecad.solids.assembly.pair_measurement import common_volume, relative_frame
from stagecad.solids.modelling.frame import UNMOVED, add, cross, mate, near, scaled, transformed_box
from stagecad.solids.modelling.mass import Geometry, mass_properties, placed
from stagecad.solids.modelling.placed_shape import PlacedShape, colour_of
from stagecad.solids.modelling.registry import ASSEMBLY

if TYPE_CHECKING:
    import cadquery as cq

    from stagecad.solids.assembly.machine_declaration import MachineDeclaration, Mate
    from stagecad.solids.export.mesh import Mesh

OVERLAP = "overlap"
_EXPLODED = 60.0
"""Displacement in the exploded view for each part below, mm."""


@dataclass(frozen=True)
class DeclaredSolid:
    """A kind of part as it was built.

    Args:
        key: name in the machine.
        solid: exact, mm.
        mesh: of it.
        geometry: volume properties.
        datums: by name.
        material: name in the parameter file.
        density: kg/m^3.
        designation: of the material, for ordering.
        description, part_number: for the list of parts.
        purchased: whether it is bought.
    """

    key: str
    solid: cq.Shape
    mesh: Mesh
    geometry: Geometry
    datums: Mapping[str, Datum]
    material: str
    density: float
    designation: str
    description: str
    part_number: str = ""
    purchased: bool = False

    @property
    def mass(self) -> MassProperties:
        """Mass properties in coordinates of the part."""
        return mass_properties(self.geometry, self.density)


@dataclass(frozen=True)
class Overlap:
    """Two instances that touch, or share volume, mm^3."""

    first: str
    second: str
    kind: str
    common_volume: float


@dataclass(frozen=True)
class DeclaredMachine:
    """The machine put together."""

    declaration: MachineDeclaration
    parts: Mapping[str, DeclaredSolid]
    instances: tuple[Instance, ...]

    @property
    def whole(self) -> MassProperties:
        """All parts together, in coordinates of the fixed part."""
        return combined(placed(self.parts[one.part].mass, one.frame) for one in self.instances)

    @property
    def bill_of_materials(self) -> tuple[Row, ...]:
        """Every kind of part with its number."""
        rows = []
        for item, (key, number) in enumerate(count(self.instances).items(), start=1):
            one = self.parts[key]
            rows.append(
                Row(
                    item,
                    key,
                    one.description,
                    one.part_number,
                    number,
                    one.designation,
                    one.mass.mass,
                    one.purchased,
                )
            )
        return tuple(rows)


def put_together(
    declaration: MachineDeclaration, datums: Mapping[str, Mapping[str, Datum]], file: str
) -> tuple[Instance, ...]:
    """Place every instance by its mate.

    Args:
        declaration: parts and mates.
        datums: of each kind of part.
        file: for messages.

    Raises:
        InputError: a part has no such datum.
    """
    found: dict[str, Instance] = {}
    for one in declaration.mates:
        if not one.datum:
            found[one.name] = Instance(one.name, one.part, UNMOVED, UNMOVED)
            continue
        parent = found[one.on[0]]
        seat = _seat(one, _datum(datums, parent.part, one.on[1], f"{file}: machine.mates.{one.name}.on"))
        child = _datum(datums, one.part, one.datum, f"{file}: machine.mates.{one.name}.datum")
        frame = mate(child, parent.frame, seat)
        away = scaled(parent.frame.direction(seat.normal), _EXPLODED)
        found[one.name] = Instance(one.name, one.part, frame, mate(child, parent.exploded, seat).shifted(away))
    return tuple(found.values())


def _datum(datums: Mapping[str, Mapping[str, Datum]], part: str, name: str, place: str) -> Datum:
    if name not in datums[part]:
        raise InputError(f"{place}: part '{part}' has no datum '{name}'{nearest(name, list(datums[part]))}")
    return datums[part][name]


def _seat(one: Mate, datum: Datum) -> Datum:
    """The datum moved by the offset and turned about its normal."""
    y = cross(datum.normal, datum.x_direction)
    origin = datum.origin
    for direction, length in zip((datum.x_direction, y, datum.normal), one.offset, strict=True):
        origin = add(origin, scaled(direction, length))
    angle = math.radians(one.turn)
    x = add(scaled(datum.x_direction, math.cos(angle)), scaled(y, math.sin(angle)))
    return Datum(datum.name, origin, datum.normal, x)


def overlaps_of(machine: DeclaredMachine) -> list[Overlap]:
    """Pairs of instances that touch or share volume; a common volume is a clash unless the pair may overlap."""
    shapes = {key: part.solid for key, part in machine.parts.items()}
    boxes = {
        one.name: transformed_box(one.frame, machine.parts[one.part].geometry.bounding_box) for one in machine.instances
    }
    found = []
    for one, two in combinations(machine.instances, 2):
        if not near(boxes[one.name], boxes[two.name], 1e-6):
            continue
        volume = common_volume(shapes[one.part], shapes[two.part], relative_frame(one.frame, two.frame))
        allowed = frozenset((one.part, two.part)) in machine.declaration.overlaps
        kind = CONTACT if volume <= TOUCH else OVERLAP if allowed else CLASH
        found.append(Overlap(one.name, two.name, kind, volume))
    return found


def export(machine: DeclaredMachine, folder: Path) -> list[str]:
    """Write STEP, STL and GLB of each kind of part and of the assembly; returns the names of the files."""
    from stagecad.parameters.atomic import atomic_write_bytes
    from stagecad.solids.export.step_stl_glb import glb_bytes, step_bytes, stl_bytes

    wrapped = {key: part.solid.wrapped for key, part in machine.parts.items()}
    meshes = {key: part.mesh for key, part in machine.parts.items()}
    groups: dict[str, Sequence[PlacedShape]] = {
        key: [PlacedShape(key, key, colour_of(part.material))] for key, part in machine.parts.items()
    }
    for name, exploded in ((ASSEMBLY, False), (f"{ASSEMBLY}_exploded", True)):
        groups[name] = [
            PlacedShape(
                one.name, one.part, colour_of(machine.parts[one.part].material), one.exploded if exploded else one.frame
            )
            for one in machine.instances
        ]
    files: dict[str, Any] = {}
    for name, shapes in groups.items():
        used = {shape.part for shape in shapes}
        files[f"{name}.glb"] = glb_bytes(name, shapes, {key: meshes[key] for key in used})
        if name.endswith("exploded"):
            continue
        files[f"{name}.step"] = step_bytes(name, shapes, {key: wrapped[key] for key in used})
        files[f"{name}.stl"] = stl_bytes([meshes[shape.part].placed(shape.frame) for shape in shapes])
    for name, data in files.items():
        atomic_write_bytes(folder / name, data)
    return list(files)
