"""Parts, assembly and contacts of a machine of the user's own (`[machine]`).

Standard parts are given by designation, from `standard_parts.csv`: `ISO 4762 M6x20` (cap screw), `ISO 10642 M6x20`
(countersunk), `ISO 4026 M6x20` (set screw), `ISO 4032 M6` (nut), `ISO 7089 6` (washer), `ISO 8734 6x20` (dowel pin m6),
`6204` (deep groove ball bearing, ISO 15). The designation is the number in the parts list, so it follows size and
length; a length that is not of the series is refused. Millimetres; the axis is z, and the origin where the part rests.
Threads are cosmetic."""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import cache, partial
from importlib.resources import files
from itertools import combinations
from typing import TYPE_CHECKING, Any

from stagecad.declared.own_part import file_digest, own_definition, own_design, used_files
from stagecad.parameters.dimension import Datum, Dimension
from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.load import overridden
from stagecad.parameters.machine import DeclaredPart, MachineDeclaration, Mate, packaged_machine
from stagecad.parameters.machine_declaration import placed_values
from stagecad.parameters.mass_properties import PartMasses, combined
from stagecad.parameters.threads import thread
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

if TYPE_CHECKING:
    import cadquery as cq


CAP, SUNK, SET, NUT, WASHER, PIN, BEARING = (
    "ISO 4762",
    "ISO 10642",
    "ISO 4026",
    "ISO 4032",
    "ISO 7089",
    "ISO 8734",
    "ISO 15",
)
WORDS = {
    CAP: "Hexagon socket head cap screw",
    SUNK: "Hexagon socket countersunk screw",
    SET: "Hexagon socket set screw, flat point",
    NUT: "Hexagon nut",
    WASHER: "Plain washer",
    PIN: "Dowel pin, hardened",
    BEARING: "Deep groove ball bearing",
}
SERIES = (2, 2.5, 3, 4, 5, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 25, 26, 28, 30, 32, *range(35, 100, 5))
SERIES = (*SERIES, *range(100, 161, 10), 180, 200)
"""Lengths of screws and pins, mm."""
NOT_OF = {PIN: (25, 110, 120, 130, 140, 150, 160, 180, 200), "screws": (14, 18, 22, 24, 26, 28, 32, 75, 85, 95)}
"""Those that pins, and screws, have not."""
RACE, SHIELD = 0.3, 0.42
"""Of a bearing: width of a ring over the radial section, and depth of the recess beside the balls over the width. The
mass is then that of the catalogues within 5 %."""
_WRITTEN = re.compile(r"(ISO \d+)?[ -]*(M?\d+(?:\.\d+)?)(?: *m6)?(?: *[xX\u00d7] *(\d+(?:\.\d+)?))?(?: mm)?")


def is_designation(text: str) -> bool:
    """Whether a text is meant as a designation."""
    return text.startswith("ISO ") or text.isdigit()


def standard_part(text: str) -> StandardPart:
    """The part of a designation.

    Raises:
        InputError: no such standard, size or length.
    """
    match = _WRITTEN.fullmatch(text.strip())
    standard, size, length = match.groups() if match else (None, "", None)
    standard, table = standard or BEARING, _table()
    # A washer is named by the thread, too.
    size = size.removeprefix("M") if standard == WASHER else size
    sizes = [known for of, known in table if of == standard]
    if not sizes:
        raise InputError(f"no standard part '{text}'{nearest(standard, list(WORDS))}; write it like ISO 4762 M6x20")
    if (standard, size) not in table:
        raise InputError(f"{standard} has no size '{size}'{nearest(size, sizes)}")
    row = table[standard, size]
    lengths = [one for one in SERIES if row["shortest"] <= one <= row["longest"]] if row["longest"] else []
    lengths = [one for one in lengths if one not in NOT_OF[PIN if standard == PIN else "screws"]]
    if bool(lengths) != bool(length) or (length and float(length) not in lengths):
        shown = f"its lengths: {', '.join(f'{one:g}' for one in lengths)} mm" if lengths else "it has no length"
        raise InputError(f"'{text}': no such length of {standard} {size}; {shown}")
    kind = StandardScrew if standard in (CAP, SUNK, SET) else StandardPart
    return kind(standard, size, row, float(length or 0.0))


@cache
def _table() -> dict[tuple[str, str], dict[str, float]]:
    text = files("stagecad.declared").joinpath("standard_parts.csv").read_text("utf-8")
    return {
        (row.pop("standard"), row.pop("size")): {key: float(value or 0.0) for key, value in row.items()}
        for row in csv.DictReader(text.splitlines())
    }


@dataclass(frozen=True)
class StandardPart:
    """A standard part as a part (`stagecad.solids.modelling.part.Part`)."""

    standard: str
    size: str
    row: dict[str, float]  # its sizes, mm
    length: float  # 0 for a part without

    def build(self, design: Any) -> cq.Solid:
        """The part as one solid, mm."""
        import cadquery as cq

        body = cq.Workplane("XZ").polyline(self._outline()).close().revolve(360.0, (0, 0), (0, 1))
        if self.row["socket"]:
            top = self._outline()[-1][1]
            deep = 0.5 * (self.row["height"] or self.row["diameter"])
            socket = cq.Workplane("XY").workplane(offset=top - deep).polygon(6, self.row["socket"] / 0.75**0.5)
            body = body.cut(socket.extrude(2 * deep))
        if self.standard == NUT:
            hexagon = cq.Workplane("XY").polygon(6, self.row["outer"] / 0.75**0.5).extrude(self.row["height"])
            body = hexagon.cut(cq.Workplane("XY").circle(self._drill() / 2).extrude(self.row["height"]))
        return body.solids().val()  # type: ignore[return-value]

    def _drill(self) -> float:
        return thread(self.size.lower().replace(".", "_")).tap_drill

    def _outline(self) -> list[tuple[float, float]]:
        """Half of the section through the axis: radius and height."""
        r, outer, high, low = self.row["diameter"] / 2, self.row["outer"] / 2, self.row["height"], -self.length
        edge = 0.16 * r
        shank = [(0.0, low), (r - edge, low), (r, low + edge)]
        if self.standard == CAP:
            rim = 0.06 * high
            return [*shank, (r, 0.0), (outer, 0.0), (outer, high - rim), (outer - rim, high), (0.0, high)]
        if self.standard == SUNK:
            return [*shank, (r, r - outer), (outer, 0.0), (0.0, 0.0)]
        if self.standard == SET:
            return [*shank, (r, 0.0), (0.0, 0.0)]
        if self.standard == PIN:
            chamfer, top = 0.27 * high, self.length
            sides = [(r - chamfer, 0.0), (r, high), (r, top - high), (r - chamfer, top)]
            return [(0.0, 0.0), *sides, (0.0, top)]
        if self.standard == BEARING:
            inner, race = r + RACE * (outer - r), outer - RACE * (outer - r)
            deep = SHIELD * high
            below = [(r, 0.0), (inner, 0.0), (inner, deep), (race, deep), (race, 0.0), (outer, 0.0)]
            return [*below, *((radius, high - level) for radius, level in reversed(below))]
        return [(r, 0.0), (outer, 0.0), (outer, high), (r, high)]

    def material(self, design: Any) -> str:
        return "alloy_steel" if self.standard in (CAP, SUNK, SET, PIN) else "steel"

    @property
    def _size(self) -> str:
        between = " m6" if self.standard == PIN else ""
        return f"{self.size}{between} x {self.length:g}" if self.length else self.size

    def part_number(self, design: Any) -> str:
        return self.size if self.standard == BEARING else f"{self.standard} - {self._size}"

    def description(self, design: Any) -> str:
        return f"{WORDS[self.standard]} {self._size}"

    def datums(self, design: Any) -> dict[str, Datum]:
        """``seat``, ``end`` of screws and ``head`` where the seat is under it; else ``bottom`` and ``top``."""
        down, up, x = (0.0, 0.0, -1.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)
        if isinstance(self, StandardScrew):
            names = {"seat": 0.0, "head": 0.0, "end": -self.length}
            return {name: Datum(name, (0.0, 0.0, level), down, x) for name, level in names.items()}
        top = self.length or self.row["height"]
        return {
            "bottom": Datum("bottom", (0.0, 0.0, 0.0), down, x),
            "middle": Datum("middle", (0.0, 0.0, top / 2), down, x),
            "top": Datum("top", (0.0, 0.0, top), up, x),
        }

    def dimensions(self, design: Any) -> tuple[Dimension, ...]:
        """None but the thread of a nut: it is purchased."""
        if self.standard != NUT:
            return ()
        major, points = self.row["diameter"], ((0.0, 0.0, self.row["height"] / 2),)
        return (Dimension("thread", "tap_drill", self._drill(), "", points, (0.0, 0.0, 1.0), major=major),)


class StandardScrew(StandardPart):
    """One with an outer thread."""

    def thread(self, design: Any) -> tuple[float, float]:
        """Major diameter and length of the thread, mm."""
        return self.row["diameter"], self.length


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
        try:
            definition = partial(standard_part, part.part)
            definition()
        except InputError as error:
            raise InputError(f"{place}: {error}") from None
        return PartSource(part.key, part.key, (standard_part.__module__,), definition, True, (part.part,))
    if part.part not in known:
        raise InputError(f"{place}: no packaged part '{part.part}'{nearest(part.part, list(known))}")
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
        if one.on[0] not in found:
            raise InputError(f"{place}.on: no part '{one.on[0]}'{nearest(one.on[0], list(found))}")
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
    if name not in datums[part]:
        raise InputError(f"{place}: part '{part}' has no datum '{name}'{nearest(name, list(datums[part]))}")
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
    parts = build_parts(ArtefactStore(), list(sources(design)), design, files=False)
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
