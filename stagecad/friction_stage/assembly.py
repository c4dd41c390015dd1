"""Assembly of the friction stage, every part positioned by mates of its datums, and the bodies of it that move.

The base is fixed at the origin (x along the travel, y across, z up, its top at z = 0). All other parts are placed by
mates, so that an error in a part appears in the assembly and in the interference check. The height of an actuator
follows from its wedge: pin 1 is moved along its bore, pin 2 is lowered in its own bore to the plane of the wedge, and
carries holder, piezos and tip.
"""

import math
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from stagecad.friction_stage.design import Design
from stagecad.friction_stage.parameters.derived import Derived
from stagecad.parameters.dimension import Datum
from stagecad.parameters.mass_properties import BodyMasses, combined
from stagecad.parameters.units import as_json
from stagecad.solids.artefacts.part import BuiltPart, build_parts, part_mass
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.bill_of_materials import Accessory
from stagecad.solids.assembly.built_machine import BuiltMachine
from stagecad.solids.modelling.frame import UNMOVED, Vector, add, dot, mate, scaled, subtract
from stagecad.solids.modelling.mass import MM, placed
from stagecad.solids.modelling.part import Instance

EXPLODED: dict[str, float] = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
"""Displacement of a part from its seat in the exploded view, mm, in addition to that of its parent."""


def assemble(
    parts: Mapping[str, BuiltPart], design: Design, travel: float = 0.0, height: float = 0.0
) -> tuple[Instance, ...]:
    """All instances of parts in the machine."""
    return tuple(_Builder(parts, design, travel, height).all())


class _Builder:
    def __init__(self, parts: Mapping[str, BuiltPart], design: Design, travel: float, height: float) -> None:
        self.parts, self.design, self.travel, self.height = parts, design, travel, height

    def datum(self, part: str, name: str) -> Datum:
        try:
            return self.parts[part].datums[name]
        except KeyError:
            raise ValueError(f"part '{part}' has no datum '{name}', which the assembly needs") from None

    def seats(self, parent: Instance, part: str) -> Iterator[tuple[str, Datum]]:
        """Seats for `part` on `parent`, in the order of their declaration."""
        for name, datum in self.parts[parent.part].datums.items():
            if name.rpartition("_")[0] == part:
                yield name, datum

    def on(self, parent: Instance, seat: Datum, part: str, own: str, name: str, **more: Any) -> Instance:
        """`part` with its datum `own` on `seat` of `parent`."""
        child = self.datum(part, own)
        out = scaled(parent.frame.direction(seat.normal), EXPLODED[part])
        frame = mate(child, parent.frame, seat)
        return Instance(name, part, frame, mate(child, parent.exploded, seat).shifted(out), **more)

    def row(self, parent: Instance, part: str, own: str = "seat") -> list[Instance]:
        """`part` on each of its seats on `parent`, by the name of the seat."""
        return [self.on(parent, seat, part, own, name) for name, seat in self.seats(parent, part)]

    def fastened(self, parent: Instance, part: str, word: str) -> Iterator[Instance]:
        """`part` on each of its seats on one of several parents, whose number follows `word` in its name."""
        number = parent.name.removeprefix(parent.part)
        for name, seat in self.seats(parent, part):
            yield self.on(parent, seat, part, "seat", name.replace(word, f"{word}{number}"))

    def all(self) -> Iterator[Instance]:
        base = Instance("base", "base", UNMOVED, UNMOVED)
        yield base
        ways = self.row(base, "bearing_way", "bottom")
        for way in ways:
            yield way
            yield from self.fastened(way, "way_screw", "screw")
        for screw in ("clamp_screw_long", "clamp_screw_short"):
            yield from self.row(base, screw)
        for number in range(1, int(self.design.actuator.fitted) + 1):
            yield from self.actuator(base, number)
        stage = self.stage(base, ways[0])
        yield stage
        if self.design.teeth.fitted:
            for bar in self.row(base, "tooth_bar"):
                yield bar
                yield from self.fastened(bar, "bar_screw", "screw")
            for part in ("tooth_iron", "magnet"):
                yield from self.row(stage, part)
        if Derived(self.design).end_stops:
            yield from self.end_stops(base)
            yield from self.row(stage, "mirror")

    def end_stops(self, base: Instance) -> Iterator[Instance]:
        """The stop bars with buffers and screws, and on the last one the interferometer with its bracket."""
        bars = self.row(base, "stop_bar")
        for bar in bars:
            yield bar
            for part in ("stop_screw", "buffer"):
                yield from self.fastened(bar, part, part)
        back = self.datum("stop_bar", "sensor_bracket")
        bracket = self.on(bars[-1], back, "sensor_bracket", "seat", "sensor_bracket")
        yield bracket
        for name, seat in self.seats(bracket, "bar_screw"):
            yield self.on(bracket, seat, "bar_screw", "seat", name.replace("screw", "screw_sensor"))
        yield from self.row(bracket, "interferometer")

    def stage(self, base: Instance, way: Instance) -> Instance:
        """The stage with its pads' plane on the ways, moved along the travel."""
        top = way.frame.point(self.datum("bearing_way", "top").origin)
        shift = self.travel * self.design.stage.travel / 2
        plane = Datum("pads", (shift, 0.0, top[2]), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
        return self.on(base, plane, "stage", "pads", "stage")

    def actuator(self, base: Instance, number: int) -> Iterator[Instance]:
        """Wedge, pin, holder, piezos and tip of one actuator, from the bottom up."""
        bore = self.datum("base", f"pin_1_bore_{number}")
        shift = scaled(bore.normal, -self.height * self.design.height_pin_1.stroke / 2)
        seat = Datum("stroke", add(bore.origin, shift), bore.normal, bore.x_direction)
        wedge = self.on(base, seat, "height_pin_1", "axis", f"height_pin_1_{number}")
        yield wedge
        yield self.on(wedge, self.datum("height_pin_1", "screw_end"), "set_screw", "end", f"set_screw_{number}")
        rest = self.datum("base", f"spring_{number}")
        shoulder = wedge.frame.point(self.datum("height_pin_1", "spring_end").origin)
        room = abs(dot(subtract(shoulder, rest.origin), rest.normal))
        free = subtract(self.datum("spring", "end_2").origin, self.datum("spring", "end_1").origin)
        compression = dot(free, (0.0, 0.0, 1.0)) - room
        yield self.on(base, rest, "spring", "end_1", f"spring_{number}", compression=compression)

        pin = self.on(
            base, self.datum("base", f"pin_2_bore_{number}"), "height_pin_2", "axis", f"height_pin_2_{number}"
        )
        pin = Instance(pin.name, pin.part, pin.frame.shifted(self._down_to(pin, wedge)), pin.exploded)
        yield pin
        pocket = self.datum("base", f"pocket_{number}")
        up = pocket.normal
        rise = dot(subtract(pin.frame.point(self.datum("height_pin_2", "top").origin), pocket.origin), up)
        foot = Datum("foot", add(pocket.origin, scaled(up, rise)), up, pocket.x_direction)
        holder = self.on(base, foot, "holder", "bottom", f"holder_{number}")
        lift = scaled(up, EXPLODED["height_pin_2"] + self.datum("height_pin_2", "top").origin[2] - rise)
        holder = Instance(holder.name, holder.part, holder.frame, holder.exploded.shifted(lift))
        yield holder
        piezos = []
        for name, bored in self.seats(holder, "piezo"):
            piezos.append(self.on(holder, bored, "piezo", "foot", f"{name.replace('_', f'_{number}_')}"))
            yield piezos[-1]
        yield self._tip(holder, piezos, number)
        yield self.on(base, self.datum("base", f"lead_clip_{number}"), "lead_clip", "seat", f"lead_clip_{number}")

    def _down_to(self, pin: Instance, wedge: Instance) -> Vector:
        """Shift along the bore's axis that brings the pin's sloping end into the plane of the wedge."""
        face = self.datum("height_pin_1", "wedge")
        normal = wedge.frame.direction(face.normal)
        end = self.datum("height_pin_2", "wedge")
        axis = scaled(pin.frame.direction(self.datum("height_pin_2", "axis").normal), -1.0)
        gap = dot(subtract(wedge.frame.point(face.origin), pin.frame.point(end.origin)), normal)
        return scaled(axis, gap / dot(axis, normal))

    def _tip(self, holder: Instance, piezos: list[Instance], number: int) -> Instance:
        """The tip on the ends of the piezos, oriented like the holder."""
        end = self.datum("piezo", "end")
        # The orientation is the holder's: piezos are round, with no preferred orientation.
        orientation = holder.frame.direction(self.datum("holder", "bottom").x_direction)
        x, y, z = (dot(axis, orientation) for axis in zip(*piezos[0].frame.rotation, strict=True))
        seat = Datum("piezo_ends", end.origin, end.normal, (x, y, z))
        return self.on(piezos[0], seat, "tip", "piezo_1", f"tip_{number}")


MOVING = ("stage", "tooth_iron", "magnet")
CARRIED = (*MOVING, "mirror")
"""Parts that move with the stage; the mirror is counted in the mass of the payload."""


def documents(machine: BuiltMachine) -> dict[str, Any]:
    """Mass of the moving body, and dimensions measured on the built parts, SI: area of all pads, D and h of the tip,
    spacing of the first two screws of a way, and the way's box."""
    tip, way = machine.parts["tip"].datums, machine.parts["bearing_way"]
    low, high = way.geometry.bounding_box
    lengths = {
        "piezo_spacing": math.dist(tip["piezo_1"].origin, tip["piezo_2"].origin),
        "tip_height": subtract(tip["apex"].origin, tip["piezo_1"].origin)[2],
        "bolt_spacing": math.dist(way.datums["way_screw_1"].origin, way.datums["way_screw_2"].origin),
        **{f"way_{name}": high[k] - low[k] for k, name in enumerate(("length", "width", "height"))},
    }
    area = math.fsum(machine.parts["stage"].face_areas.values()) * MM**2
    measures = {"pad_area": as_json(area, "m^2")} | {name: as_json(mm * MM, "m") for name, mm in lengths.items()}
    assert machine.moving_body is not None
    return {"moving_body": machine.moving_body.as_json(), "measures": measures}


def machine_masses(machine: BuiltMachine) -> BodyMasses:
    """Mass properties of the moving body and of the tip of a built machine."""
    assert machine.moving_body is not None
    return BodyMasses(machine.moving_body, machine.masses["tip"])


def masses(design: Design) -> BodyMasses:
    """Mass properties of the moving body (stage with irons and magnets, at mid-travel) and of the tip, SI.

    Only the solids of these parts are needed; they come from the cache or are made now. The positions of irons and
    magnets follow from the stage's own datums, so that the result equals that of the whole assembly.
    """
    riders = ("tooth_iron", "magnet") if design.teeth.fitted else ()
    parts = build_parts(ArtefactStore(), ("stage", "tip", *riders), design, contents="data")
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


def accessories(design: Design) -> tuple[Accessory, ...]:
    """The accessories of a design, in the order of their use in the procedure."""
    fitted = int(design.actuator.fitted)
    base, shim = design.base, design.shim
    found = [
        Accessory("eye bolt, for lifting", "M10", 4),
        Accessory("foot", "M10, with lock nut", 3),
        Accessory("setting pin", f"dia. {base.setting_pin_hole:g} h6 x {3 * base.setting_pin_depth:g}", 4),
        Accessory("grease for the height pins", "lithium soap, NLGI 2", 1),
        Accessory("set screw, soft-tipped", "M4x0.7 x 8", 3 * fitted),
        Accessory("pair of leads", f"{design.piezo.highest_voltage:g} V, shielded", 3 * fitted),
        Accessory("adhesive for the tip", "cyanoacrylate gel, soluble in acetone", 1),
        Accessory("lifting screw of the holder", "M4x0.7 x 20", 3),
        Accessory("shim set", f"{1e3 * shim.thinnest:.3g} um to {1e3 * shim.thickest:.3g} um", 1),
        Accessory("PTFE film on the pads", f"{1e6 * design.bearing.film_thickness:g} um, by a coater", 1),
        Accessory("adhesive for the lead clips", "silicone", 1),
    ]
    if design.teeth.fitted:
        found += [
            Accessory("adhesive for irons and magnets", "epoxy, low shrinkage", 1),
            Accessory("jack screw for the irons", "M3x0.5 x 16", 2),
        ]
    if Derived(design).end_stops:
        found += [
            Accessory("adhesive for the buffers", "polyurethane", 1),
            Accessory("screw of mirror and interferometer", "ISO 4762 - M4 x 16", 4),
        ]
    return tuple(found)
