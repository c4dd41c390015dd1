"""Parts, assembly and contacts of a machine of the user's own (`[machine]`)."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from fnmatch import fnmatchcase
from functools import partial
from itertools import combinations
from typing import Any

from stagecad.declared.own_part import file_digest, own_definition, own_design, used_files
from stagecad.declared.standard_part import is_designation, standard_part
from stagecad.parameters.dimension import Datum
from stagecad.parameters.errors import at_place, require_known
from stagecad.parameters.machine import DeclaredPart, MachineDeclaration, Mate, packaged_machine
from stagecad.parameters.machine_declaration import placed_values
from stagecad.parameters.mass_properties import PartMasses, combined
from stagecad.parameters.override import overridden
from stagecad.solids.artefacts.part import BuiltPart, build_parts, part_mass
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.bill_of_materials import document as bill_document
from stagecad.solids.assembly.built_machine import BuiltMachine
from stagecad.solids.assembly.interference import build_interferences
from stagecad.solids.modelling.frame import UNMOVED, add, cross, mate, scaled
from stagecad.solids.modelling.mass import placed
from stagecad.solids.modelling.part import (
    CONTACT,
    OPEN,
    OVERLAP,
    Construction,
    Instance,
    PartSource,
    Position,
    packaged,
)

_EXPLODED = 60.0
"""Displacement in the exploded view for each part below, mm."""


def sources(design: Any) -> Mapping[str, PartSource]:
    """The parts of a design, in the order in which the mates bring them."""
    declaration: MachineDeclaration = design.machine.declaration
    order = dict.fromkeys([*(one.part for one in declaration.mates), *(part.key for part in declaration.parts)])
    return {key: _source(declaration, declaration.part(key), design) for key in order}


def _source(declaration: MachineDeclaration, part: DeclaredPart, design: Any) -> PartSource:
    if part.file:
        path = declaration.folder / part.file
        definition = partial(own_definition, path, part.description, packaged_machine().table_names)
        depends = (*map(file_digest, (path, *used_files(path))), part.description)
        return PartSource(
            part.key,
            part.part,
            (own_design.__module__,),
            definition,
            part.purchased,
            depends,
            partial(own_design, part),
        )
    known = packaged().sources(design)
    place = f"{declaration.file}: machine.parts.{part.key}"
    if is_designation(part.part):
        with at_place(place):
            definition = partial(standard_part, part.part)
            definition()
        return PartSource(part.key, part.key, (standard_part.__module__,), definition, True, (part.part,))
    require_known(part.part, known, f"{place}: no packaged part '{part.part}'")
    return replace(known[part.part], name=part.key, own_design=partial(overridden, values=part.parameters))


def assemble(parts: Mapping[str, BuiltPart], design: Any, position: Position) -> tuple[Instance, ...]:
    """Place every instance by its mate."""
    declaration: MachineDeclaration = design.machine.declaration
    return put_together(declaration, {key: part.datums for key, part in parts.items()}, design)


def put_together(
    declaration: MachineDeclaration, datums: Mapping[str, Mapping[str, Datum]], design: Any
) -> tuple[Instance, ...]:
    """Place every instance by its mate, given the datums of each kind of part; errors as `assemble`."""
    found: dict[str, Instance] = {}
    behind: Counter[tuple[str, str]] = Counter()  # parts that are on each datum already
    for one in declaration.mates:
        if not one.datum:
            found[one.name] = Instance(one.name, one.part, UNMOVED, UNMOVED)
            continue
        place = f"{declaration.file}: machine.mates.{one.name}"
        require_known(one.on[0], found, f"{place}.on: no part '{one.on[0]}'")
        parent = found[one.on[0]]
        child = _datum(datums, one.part, one.datum, f"{place}.datum")
        offset, turn = placed_values(design, one)
        for name, datum in _seats(one, datums, parent.part, f"{place}.on"):
            seat = _seat(datum, offset, turn)
            frame = mate(child, parent.frame, seat)
            behind[one.on[0], datum.name] += 1
            away = scaled(parent.frame.direction(seat.normal), behind[one.on[0], datum.name] * _EXPLODED)
            exploded = mate(child, parent.exploded, seat).shifted(away)
            found[name] = Instance(name, one.part, frame, exploded, carrier=parent.name)
    return tuple(found.values())


def _seats(
    one: Mate, datums: Mapping[str, Mapping[str, Datum]], parent: str, place: str
) -> Iterator[tuple[str, Datum]]:
    """The instances that a mate gives: their names, and the datums that they are put on."""
    if not one.is_pattern:
        yield one.name, _datum(datums, parent, one.on[1], place)
        return
    names = [name for name in datums[parent] if fnmatchcase(name, one.on[1])]
    if not names:
        _datum(datums, parent, one.on[1], place)
    for number, name in enumerate(names, start=1):
        yield f"{one.name}_{number}", datums[parent][name]


def _datum(datums: Mapping[str, Mapping[str, Datum]], part: str, name: str, place: str) -> Datum:
    require_known(name, datums[part], f"{place}: part '{part}' has no datum '{name}'")
    return datums[part][name]


def _seat(datum: Datum, offset: tuple[float, float, float], turn: float) -> Datum:
    """The datum moved by an offset, mm, and turned about its normal, deg."""
    y = cross(datum.normal, datum.x_direction)
    origin = datum.origin
    for direction, length in zip((datum.x_direction, y, datum.normal), offset, strict=True):
        origin = add(origin, scaled(direction, length))
    angle = math.radians(turn)
    x = add(scaled(datum.x_direction, math.cos(angle)), scaled(y, math.sin(angle)))
    return Datum(datum.name, origin, datum.normal, x)


def relations(design: Any) -> Mapping[frozenset[str], str]:
    """Parts that may overlap by their declaration, those that a mate puts on each other, and all others."""
    declaration: MachineDeclaration = design.machine.declaration
    keys = [part.key for part in declaration.parts]
    found = {frozenset(pair): OPEN for pair in [*combinations(keys, 2), *((key, key) for key in keys)]}
    kinds = {one.name: one.part for one in declaration.mates}
    for one in declaration.mates:
        parent = kinds.get(one.on[0]) or kinds.get(one.on[0].rpartition("_")[0])
        if parent and one.offset[2].split()[0] in ("0", "0.0"):
            found[frozenset((one.part, parent))] = CONTACT
    return found | dict.fromkeys(declaration.overlaps, OVERLAP)


def depends(design: Any) -> tuple[str, ...]:
    """Mates and overlaps as they are written."""
    declaration: MachineDeclaration = design.machine.declaration
    return (repr(declaration.mates), repr(sorted(map(sorted, declaration.overlaps))))


def masses(design: Any) -> PartMasses:
    """Mass properties of each part, and of the whole, `machine`."""
    parts = build_parts(ArtefactStore(), list(sources(design)), design, contents="data")
    each = {name: part_mass(part, design) for name, part in parts.items()}
    whole = combined(placed(each[one.part], one.frame) for one in assemble(parts, design, (0.0, 0.0)))
    return PartMasses({**each, "machine": whole})


def machine_masses(machine: BuiltMachine) -> PartMasses:
    """The same of a machine that is built."""
    return PartMasses({**machine.masses, "machine": machine.whole})


def documents(machine: BuiltMachine) -> dict[str, Any]:
    """Mass of the whole, list of parts, and interference."""
    pairs = build_interferences(ArtefactStore(), machine.parts, machine.design)
    return {
        "assembly": machine.whole.as_json(),
        "bill_of_materials": bill_document(machine.bill_of_materials),
        "interference": [
            {"first": pair.first, "second": pair.second, "kind": pair.kind, "common_volume": pair.common_volume * 1e-9}
            for pair in pairs
        ],
    }


CONSTRUCTION = Construction(
    sources=sources,
    relations=relations,
    modules=(__name__,),
    assemble=assemble,
    masses=masses,
    machine_masses=machine_masses,
    documents=documents,
    depends=depends,
)
